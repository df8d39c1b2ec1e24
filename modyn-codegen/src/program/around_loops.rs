//! A program as what runs before its loops, the loops, and what runs after them, for back ends that
//! run the loops themselves.

use std::collections::{BTreeMap, BTreeSet};

use super::{Addend, Loops, MultiplyAdd, Operand, Operation, Program, Source, Statement, Value};

/// The parts of a program with loops in one of its statements.
pub struct AroundLoops<'a> {
    /// What runs before. Results: the stored values of the loops, then the values that `after`
    /// reads.
    pub before: Program,
    /// The loops.
    pub loops: &'a Loops,
    /// What runs after. Arguments: the program's arguments, the results of the loops, then the
    /// values that `before` computes for it.
    pub after: Program,
}

impl Program {
    /// Returns the parts around the loops; `None` for programs without loops.
    ///
    /// # Panics
    ///
    /// If there are several loops, which no program of a step has.
    #[must_use]
    pub fn around_loops(&self) -> Option<AroundLoops<'_>> {
        let is_loop = |statement: &Statement| matches!(statement.operation, Operation::Loops(_));
        let at = self.statements.iter().position(is_loop)?;
        let Operation::Loops(loops) = &self.statements[at].operation else { return None };
        assert!(self.loops().count() == 1, "one solver");
        let after = &self.statements[at + 1..];
        let operands = after.iter().flat_map(|statement| statement.operation.operands());
        let read = operands.chain(self.results.iter().copied()).filter_map(|x| x.value());
        let crossing: BTreeSet<Value> = read.filter(|value| value.statement < at).collect();
        let mut cut = Cut {
            before: Self {
                statements: self.statements[..at].iter().map(without_last_use).collect(),
                results: loops.stored.iter().map(|stored| stored.value).collect(),
                ..Self::without_statements(self.execution, self.arguments)
            },
            after: Self::without_statements(self.execution, self.arguments + loops.results.len()),
            sources: BTreeMap::new(),
        };
        crossing
            .into_iter()
            .for_each(|value| cut.pass(value, self.statements[value.statement].lanes));
        let Cut { before, mut after, sources } = cut;
        let first = after.statements.len();
        let moved = |operand: Operand| {
            let source = match operand.source {
                Source::Result(value) if value.statement < at => sources[&value],
                Source::Result(value) if value.statement == at => {
                    Source::Argument(self.arguments + value.place)
                }
                Source::Result(value) => {
                    let statement = value.statement - at - 1 + first;
                    Source::Result(Value { statement, ..value })
                }
                source => source,
            };
            Operand { source, ..operand }
        };
        after.statements.extend(self.statements[at + 1..].iter().map(|statement| Statement {
            operation: statement.operation.map(moved),
            ..without_last_use(statement)
        }));
        after.results = self.results.iter().map(|&result| moved(result)).collect();
        let finished = |program: Self| program.finished().expect("a part of a valid program");
        Some(AroundLoops { before: finished(before), loops, after: finished(after) })
    }
}

impl Program {
    /// Returns the program among so many arguments, of which argument `n` is the one at `place(n)`.
    ///
    /// # Panics
    ///
    /// If the program has products, or if there are fewer arguments.
    #[must_use]
    pub fn with_arguments_at(&self, arguments: usize, place: impl Fn(usize) -> usize) -> Self {
        assert!(self.products.is_none(), "products read their arguments by matrices");
        let moved = |operand: Operand| match operand.source {
            Source::Argument(number) => {
                Operand { source: Source::Argument(place(number)), ..operand }
            }
            _ => operand,
        };
        let statements = self.statements.iter().map(|statement| Statement {
            operation: statement.operation.map(moved),
            ..without_last_use(statement)
        });
        let program = Self {
            statements: statements.collect(),
            results: self.results.iter().map(|&result| moved(result)).collect(),
            ..Self::without_statements(self.execution, arguments)
        };
        program.finished().expect("the same program")
    }
}

/// The parts of a program while values are passed from one to the other.
struct Cut {
    before: Program,
    after: Program,
    /// The values in `after`.
    sources: BTreeMap<Value, Source>,
}

impl Cut {
    /// Makes a value of `before` one of `after`, by its lanes.
    fn pass(&mut self, value: Value, lanes: u8) {
        let Self { before, after, sources } = self;
        let result = |source| Operand { source, negated: false, lanes: 1 };
        let first = after.arguments;
        after.arguments += usize::from(lanes);
        if lanes == 1 {
            before.results.push(result(Source::Result(value)));
            sources.insert(value, Source::Argument(first));
            return;
        }
        let vector = Operand { source: Source::Result(value), negated: false, lanes };
        let statement = before.statements.len();
        before.statements.push(new_statement(Operation::Unpack(vector), 1, lanes.into()));
        let places = 0..usize::from(lanes);
        before
            .results
            .extend(places.clone().map(|place| result(Source::Result(Value { statement, place }))));
        let packed = places.map(|place| result(Source::Argument(first + place))).collect();
        let statement = after.statements.len();
        after.statements.push(new_statement(Operation::Pack(packed), lanes, 1));
        sources.insert(value, Source::Result(Value { statement, place: 0 }));
    }
}

fn new_statement(operation: Operation, lanes: u8, results: usize) -> Statement {
    Statement { operation, lanes, used: vec![true; results], last_use: 0, stores: Vec::new() }
}

fn without_last_use(statement: &Statement) -> Statement {
    Statement { last_use: 0, ..statement.clone() }
}

impl Operation {
    /// Returns the operation with `f` applied to its operands.
    fn map(&self, f: impl Fn(Operand) -> Operand) -> Self {
        match self {
            Self::Add(a, b) => Self::Add(f(*a), f(*b)),
            Self::Subtract(a, b) => Self::Subtract(f(*a), f(*b)),
            Self::Multiply(a, b) => Self::Multiply(f(*a), f(*b)),
            Self::Atan2(a, b) => Self::Atan2(f(*a), f(*b)),
            Self::Maximum(a, b) => Self::Maximum(f(*a), f(*b)),
            Self::MultiplyAdd(MultiplyAdd {
                negative_product,
                factors,
                negative_addend,
                addend,
            }) => Self::MultiplyAdd(MultiplyAdd {
                negative_product: *negative_product,
                factors: factors.map(&f),
                negative_addend: *negative_addend,
                addend: match *addend {
                    Addend::Value(a) => Addend::Value(f(a)),
                    Addend::Product(a, b) => Addend::Product(f(a), f(b)),
                },
            }),
            Self::Reciprocal(a) => Self::Reciprocal(f(*a)),
            Self::SquareRoot(a) => Self::SquareRoot(f(*a)),
            Self::Logarithm(a) => Self::Logarithm(f(*a)),
            Self::Absolute(a) => Self::Absolute(f(*a)),
            Self::Unpack(a) => Self::Unpack(f(*a)),
            Self::Select(a, b, c) => Self::Select(f(*a), f(*b), f(*c)),
            Self::SinCos(angles) => Self::SinCos(angles.iter().map(|&a| f(a)).collect()),
            Self::Pack(packed) => Self::Pack(packed.iter().map(|&a| f(a)).collect()),
            Self::Constants(_) | Self::Loops(_) | Self::RowEquations(_) => self.clone(),
        }
    }
}
