//! A straight-line program: what a graph becomes before any language prints it.
//!
//! ```text
//! Graph ─ lower ─▶ statements in order ─ outline ─▶ chunks and scopes ─ validate ─▶ Program ─▶ printers
//! ```
//!
//! All decisions are made here: the order of operations, which products are fused into sums, which signs are folded
//! into operands, which angles share one evaluation of sine and cosine, where a long function is cut, and which values
//! cross a cut. A printer only gives names, types, literals and calls.
//!
//! Every value is an operand of the form *constant*, *argument* or *result of a statement*, with a sign, copied to as
//! many lanes as its use has. So a printer needs no expression trees, and machine code can be made from a program
//! directly: it is one basic block whose last uses are known ([`Statement::last_use`]).

mod evaluate;
mod lower;
mod outline;
mod repeat;
mod validate;

use std::collections::BTreeSet;
use std::ops::Range;

use modyn_runtime::OperationCount;

pub use validate::Fault;

/// The kind of numbers that a program runs on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// Numbers of one state.
    Scalar,
    /// Vectors with a state in each lane; results are stored as soon as they are known.
    Batch,
    /// Numbers of one state, some of them packed into vectors.
    Simd,
}

/// A program: scalars in, scalars out.
#[derive(Clone, Debug)]
pub struct Program {
    /// The kind of numbers.
    pub target: Target,
    /// The number of scalars that the program is given.
    pub arguments: usize,
    /// The operations, each after the operations that it reads.
    pub statements: Vec<Statement>,
    /// The results.
    pub results: Vec<Operand>,
    /// The results that need no statement: they can be stored at once. Empty unless results are stored as soon as
    /// they are known.
    pub first_stores: Vec<usize>,
    /// The statements cut into chunks. The last chunk calls the others, in their order, and has the results.
    pub chunks: Vec<Chunk>,
    /// Programs that statements call.
    pub routines: Vec<Routine>,
}

/// An operation at its place in the program.
#[derive(Clone, Debug)]
pub struct Statement {
    /// The operation.
    pub operation: Operation,
    /// The number of lanes of each result; 1 for a scalar.
    pub lanes: u8,
    /// For each result whether anything reads it.
    pub used: Vec<bool>,
    /// The last statement that reads one of the results; `usize::MAX` where a result is one of the program's.
    pub last_use: usize,
    /// The program's results that can be stored after this statement. Empty unless results are stored as soon as
    /// they are known.
    pub stores: Vec<usize>,
}

/// An operation. It acts lane by lane, except [`Pack`](Self::Pack) and [`Unpack`](Self::Unpack).
#[derive(Clone, Debug, PartialEq)]
pub enum Operation {
    /// a + b
    Add(Operand, Operand),
    /// a - b
    Subtract(Operand, Operand),
    /// a b
    Multiply(Operand, Operand),
    /// A product and a sum, rounded once where the target can.
    MultiplyAdd(MultiplyAdd),
    /// 1 / a
    Reciprocal(Operand),
    /// The sine and the cosine of each angle, in this order: two results an angle.
    SinCos(Vec<Operand>),
    /// The angle from the x axis to the point (second operand, first operand).
    Atan2(Operand, Operand),
    /// Square root.
    SquareRoot(Operand),
    /// Natural logarithm.
    Logarithm(Operand),
    /// Absolute value.
    Absolute(Operand),
    /// The larger of two numbers; the other one where one is NaN.
    Maximum(Operand, Operand),
    /// The second operand where the first is at least zero, else the third.
    Select(Operand, Operand, Operand),
    /// Scalars as the lanes of one vector.
    Pack(Vec<Operand>),
    /// Constants as the lanes of one vector.
    Constants(Vec<f64>),
    /// The lanes of a vector as scalars: one result a lane.
    Unpack(Operand),
    /// A call of a routine.
    Call(Call),
}

/// (-) a b (+ or -) c
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MultiplyAdd {
    /// Whether the product is negated.
    pub negative_product: bool,
    /// The factors.
    pub factors: [Operand; 2],
    /// Whether the addend is negated.
    pub negative_addend: bool,
    /// The addend.
    pub addend: Addend,
}

/// The number that is added to a product.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Addend {
    /// A value.
    Value(Operand),
    /// Another product, rounded before it is added.
    Product(Operand, Operand),
}

/// A value as an operation reads it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Operand {
    /// The value.
    pub source: Source,
    /// Whether it is negated.
    pub negated: bool,
    /// The number of lanes; a scalar is copied to all of them.
    pub lanes: u8,
}

/// A value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Source {
    /// A constant.
    Constant(f64),
    /// The scalar argument of that number.
    Argument(usize),
    /// A result of a statement.
    Result(Value),
}

/// A result of a statement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Value {
    /// The statement.
    pub statement: usize,
    /// Which of its results.
    pub place: usize,
}

/// Statements that become one function where a language has functions.
#[derive(Clone, Debug)]
pub struct Chunk {
    /// The statements.
    pub statements: Range<usize>,
    /// Earlier chunks whose values this chunk reads.
    pub live_in: Vec<usize>,
    /// The values that later chunks read, scalars first, then by lanes.
    pub live_out: Vec<Value>,
    /// The statements in scopes of bounded length.
    pub scopes: Vec<Scope>,
}

/// Statements whose values are forgotten at the end, but for some.
#[derive(Clone, Debug)]
pub struct Scope {
    /// The statements.
    pub statements: Range<usize>,
    /// The values that are read after the scope, scalars first, then by lanes.
    pub live_out: Vec<Value>,
}

/// A program that is called several times, each time with constants of its own. Its arguments are the constants of one
/// repetition, then the operands of the repetition, then operands that all repetitions have in common.
#[derive(Clone, Debug)]
pub struct Routine {
    /// The program.
    pub program: Program,
    /// For each repetition its constants, the same number of them.
    pub tables: Vec<Vec<f64>>,
    /// The number of operands that each repetition has.
    pub own: usize,
    /// The number of operands that all repetitions have in common.
    pub common: usize,
}

/// One repetition of a routine; its results are the routine's.
#[derive(Clone, Debug, PartialEq)]
pub struct Call {
    /// The routine.
    pub routine: usize,
    /// Which of its repetitions, and so which table of constants.
    pub repetition: usize,
    /// The operands of this repetition.
    pub own: Vec<Operand>,
    /// The operands that all repetitions have in common.
    pub common: Vec<Operand>,
}

impl Operation {
    /// The operands, in their order.
    #[must_use]
    pub fn operands(&self) -> Vec<Operand> {
        match self {
            Self::Add(a, b)
            | Self::Subtract(a, b)
            | Self::Multiply(a, b)
            | Self::Atan2(a, b)
            | Self::Maximum(a, b) => vec![*a, *b],
            Self::MultiplyAdd(MultiplyAdd { factors, addend, .. }) => match *addend {
                Addend::Value(a) => vec![factors[0], factors[1], a],
                Addend::Product(a, b) => vec![factors[0], factors[1], a, b],
            },
            Self::Reciprocal(a)
            | Self::SquareRoot(a)
            | Self::Logarithm(a)
            | Self::Absolute(a)
            | Self::Unpack(a) => vec![*a],
            Self::Select(a, b, c) => vec![*a, *b, *c],
            Self::SinCos(all) | Self::Pack(all) => all.clone(),
            Self::Constants(_) => Vec::new(),
            Self::Call(call) => [&*call.own, &*call.common].concat(),
        }
    }
}

impl Operand {
    /// The value, if a statement computes it.
    #[must_use]
    pub fn value(&self) -> Option<Value> {
        match self.source {
            Source::Result(value) => Some(value),
            Source::Constant(_) | Source::Argument(_) => None,
        }
    }
}

impl Program {
    /// The numbers of lanes that statements have, 1 among them.
    #[must_use]
    pub fn widths(&self) -> BTreeSet<u8> {
        self.statements.iter().map(|statement| statement.lanes).chain([1]).collect()
    }

    /// The statements whose results statement `s` reads, and its stores read.
    pub fn reads(&self, s: usize) -> impl Iterator<Item = usize> {
        let Statement { operation, stores, .. } = &self.statements[s];
        let stored = stores.iter().map(|&result| self.results[result]);
        let operands = operation.operands().into_iter().chain(stored);
        operands.filter_map(|operand| operand.value()).map(|value| value.statement)
    }

    /// The number of lanes of a value before it is copied to more.
    #[must_use]
    pub fn lanes_of(&self, source: Source) -> u8 {
        match source {
            Source::Result(value) => self.statements[value.statement].lanes,
            Source::Constant(_) | Source::Argument(_) => 1,
        }
    }

    /// The operations of one call; those of routines as often as these are called.
    #[must_use]
    pub fn operations_per_call(&self) -> OperationCount {
        let calls = |routine: &Routine| {
            let one = routine.program.operations_per_call();
            std::iter::repeat_n(one, routine.tables.len()).sum::<OperationCount>()
        };
        self.own_operations() + self.routines.iter().map(calls).sum()
    }

    /// The operations in the program's text, those of routines once.
    #[must_use]
    pub fn static_operations(&self) -> OperationCount {
        let routines = self.routines.iter().map(|routine| routine.program.static_operations());
        self.own_operations() + routines.sum()
    }

    /// The operations of the program's own statements; an operation on lanes counts once, packing and unpacking do not.
    fn own_operations(&self) -> OperationCount {
        let mut count = OperationCount::default();
        for Statement { operation, .. } in &self.statements {
            match operation {
                Operation::Add(..) | Operation::Subtract(..) => count.additions += 1,
                Operation::Multiply(..) => count.multiplications += 1,
                Operation::MultiplyAdd(fused) => {
                    count.additions += 1;
                    count.multiplications += match fused.addend {
                        Addend::Value(_) => 1,
                        Addend::Product(..) => 2,
                    };
                }
                Operation::Reciprocal(_) => count.divisions += 1,
                Operation::SinCos(angles) => count.sin_cos += angles.len(),
                Operation::Atan2(..)
                | Operation::SquareRoot(_)
                | Operation::Logarithm(_)
                | Operation::Absolute(_)
                | Operation::Maximum(..)
                | Operation::Select(..) => count.others += 1,
                Operation::Pack(_)
                | Operation::Constants(_)
                | Operation::Unpack(_)
                | Operation::Call(_) => {}
            }
        }
        count
    }
}
