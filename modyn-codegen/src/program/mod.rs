//! Programs: straight-line code between the graph and the printers of languages.
//!
//! ```text
//! Graph ─ lower ─▶ statements in order ─ outline ─▶ chunks and scopes ─ validate ─▶ Program ─▶ printers
//! ```
//!
//! All decisions are made here: the order of operations; which products are fused into sums; which
//! signs are folded into operands; which angles share one evaluation of sine and cosine; where a
//! long function is cut; and which values cross a cut. A printer chooses names, types, literals and
//! calls only.
//!
//! An operand is a constant, an argument or a result of a statement. It has a sign, and scalars are
//! broadcast to as many lanes as the operation has. A printer therefore needs no expression trees.
//! Machine code can be made from a program directly: it is one basic block with known last uses
//! ([`Statement::last_use`]).
//!
//! A program has a text, which can be read again: [`Program`] implements `Display` and `FromStr`.
//!
//! Programs have one kind of loop ([`Loops`]): routines run over arrays, for each row of a table.
//! Recursions over bodies and equal limbs that share code are such loops.
//!
//! `validate` checks each program once, before a printer sees it. If a packed program is invalid,
//! the plan uses the program on scalars and adds a warning. `evaluate` computes a program's results
//! on numbers: the reference of all back ends.

mod around_loops;
mod bodies;
mod count;
mod evaluate;
mod loops;
mod lower;
mod outline;
mod places;
mod products;
mod repeat;
mod row_equations;
mod soft_steps;
mod text;
mod validate;

use std::collections::BTreeSet;
use std::ops::Range;

pub use around_loops::AroundLoops;
pub use bodies::{RecursionSizes, Sweep};
pub use loops::{
    Array, Call, Column, Entry, Loop, LoopForm, Loops, Place, Read, Routine, Row, Step, Stored,
    Table, Write,
};
pub use places::argument_of;
pub(crate) use products::is_zero;
pub use products::{ProductBlock, ProductMatrix, Products, ROW_LANES};
pub use row_equations::RowEquations;
pub use text::ParseProgramError;
pub use validate::InvalidProgram;

/// The way that programs run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Execution {
    /// One state at a time, on scalars.
    Scalar,
    /// One state at a time, on scalars of which some are packed into vectors.
    Simd,
    /// Many states, one in each lane of vectors.
    Batch,
    /// Many states, one in each thread of a graphics processor.
    Threads,
}

impl Execution {
    /// Returns whether there are many states. Results are then stored as soon as they are computed.
    #[must_use]
    pub fn has_many_states(self) -> bool {
        matches!(self, Self::Batch | Self::Threads)
    }
}

/// A program from scalars to scalars.
#[derive(Clone, Debug, PartialEq)]
pub struct Program {
    /// The way that the program runs.
    pub execution: Execution,
    /// The number of scalar arguments.
    pub arguments: usize,
    /// The operations, each after the operations that it reads.
    pub statements: Vec<Statement>,
    /// The results.
    pub results: Vec<Operand>,
    /// The products of matrices that are added to some results, in loops after the statements.
    pub products: Option<Products>,
    /// The numbers that are stored and need no statement.
    pub first_stores: Vec<usize>,
    /// The statements, cut into chunks. The last chunk calls the others in their order, and returns
    /// the results.
    pub chunks: Vec<Chunk>,
    /// The programs that loops call.
    pub routines: Vec<Routine>,
    /// The tables of loops.
    pub tables: Vec<Table>,
}

impl Program {
    /// Returns a program without statements and results.
    fn without_statements(execution: Execution, arguments: usize) -> Self {
        Self {
            execution,
            arguments,
            statements: Vec::new(),
            results: Vec::new(),
            products: None,
            first_stores: Vec::new(),
            chunks: Vec::new(),
            routines: Vec::new(),
            tables: Vec::new(),
        }
    }
}

/// An operation in its place in the program.
#[derive(Clone, Debug, PartialEq)]
pub struct Statement {
    /// The operation.
    pub operation: Operation,
    /// The number of lanes of each result; 1 for a scalar.
    pub lanes: u8,
    /// For each result, whether it is read.
    pub used: Vec<bool>,
    /// The last statement that reads one of the results; `usize::MAX` if a result is a result of
    /// the program.
    pub last_use: usize,
    /// The indices of the numbers that are stored and that this statement computes: see
    /// [`Program::stored`].
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
    /// A product plus or minus an addend, rounded once if the processor has an instruction for it.
    MultiplyAdd(MultiplyAdd),
    /// 1 / a
    Reciprocal(Operand),
    /// The sine and the cosine of each angle, in this order: two results for each angle.
    SinCos(Vec<Operand>),
    /// The angle from the x axis to the point (second operand, first operand).
    Atan2(Operand, Operand),
    /// The square root.
    SquareRoot(Operand),
    /// The natural logarithm.
    Logarithm(Operand),
    /// The absolute value.
    Absolute(Operand),
    /// The larger of two numbers; if one is NaN, the other.
    Maximum(Operand, Operand),
    /// The second operand if the first is at least zero, else the third.
    Select(Operand, Operand, Operand),
    /// A vector with these scalars as its lanes.
    Pack(Vec<Operand>),
    /// A vector with these constants as its lanes.
    Constants(Vec<f64>),
    /// The lanes of a vector as scalars: one result for each lane.
    Unpack(Operand),
    /// Loops over arrays.
    Loops(Loops),
    /// The solution of equations of constraint rows, where some may be dependent.
    RowEquations(RowEquations),
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

/// The addend of a product.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Addend {
    /// A value.
    Value(Operand),
    /// Another product, rounded before it is added.
    Product(Operand, Operand),
}

/// A value, as an operation reads it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Operand {
    /// The value.
    pub source: Source,
    /// Whether the value is negated.
    pub negated: bool,
    /// The number of lanes; a scalar is broadcast to all of them.
    pub lanes: u8,
}

/// A value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Source {
    /// A constant.
    Constant(f64),
    /// The scalar argument with this index.
    Argument(usize),
    /// A result of a statement.
    Result(Value),
}

/// A result of a statement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Value {
    /// The index of the statement.
    pub statement: usize,
    /// The index of the result among the statement's results.
    pub place: usize,
}

/// Statements that become one function in languages with functions.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Chunk {
    /// The statements.
    pub statements: Range<usize>,
    /// Earlier chunks whose values this chunk reads.
    pub live_in: Vec<usize>,
    /// The values that later chunks read, scalars first, then by lanes.
    pub live_out: Vec<Value>,
    /// The statements, in scopes of bounded length.
    pub scopes: Vec<Scope>,
}

/// Statements in a scope: only the `live_out` values are visible afterwards.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Scope {
    /// The statements.
    pub statements: Range<usize>,
    /// The values that are read after the scope, scalars first, then by lanes.
    pub live_out: Vec<Value>,
}

impl Operation {
    /// Returns the operands, in order.
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
            Self::Loops(loops) => loops.stored.iter().map(|stored| stored.value).collect(),
            Self::RowEquations(equations) => equations.operands.clone(),
        }
    }
}

impl Operand {
    /// Returns the value, if a statement computes it.
    #[must_use]
    pub fn value(&self) -> Option<Value> {
        match self.source {
            Source::Result(value) => Some(value),
            Source::Constant(_) | Source::Argument(_) => None,
        }
    }
}

impl Program {
    /// Returns the numbers of lanes of the statements; 1 is always among them.
    #[must_use]
    pub fn widths(&self) -> BTreeSet<u8> {
        self.statements.iter().map(|statement| statement.lanes).chain([1]).collect()
    }

    /// Returns the statements whose results are read by statement `s` or its stores.
    pub fn reads(&self, s: usize) -> impl Iterator<Item = usize> {
        let Statement { operation, stores, .. } = &self.statements[s];
        let stored = stores.iter().map(|&i| *self.stored(i));
        let operands = operation.operands().into_iter().chain(stored);
        operands.filter_map(|operand| operand.value()).map(|value| value.statement)
    }

    /// Returns the numbers that are stored as soon as they are computed: the entries of products
    /// that are in arrays, then with many states the results.
    pub fn all_stored(&self) -> impl Iterator<Item = &Operand> {
        let entries = self.products.iter().filter(|products| products.in_place.is_none());
        let results = if self.execution.has_many_states() { &*self.results } else { &[] };
        entries.flat_map(|products| &products.entries).chain(results)
    }

    /// Returns the stored number with this index.
    ///
    /// # Panics
    ///
    /// If there is no such number.
    #[must_use]
    pub fn stored(&self, index: usize) -> &Operand {
        match self.stored_result(index) {
            Some(result) => &self.results[result],
            None => &self.products.as_ref().expect("an entry").entries[index],
        }
    }

    /// Returns the result that the stored number with this index is; `None` for entries of
    /// products.
    #[must_use]
    pub fn stored_result(&self, index: usize) -> Option<usize> {
        let entries = self.products.iter().filter(|products| products.in_place.is_none());
        index.checked_sub(entries.map(|products| products.entries.len()).sum())
    }

    /// Returns the numbers that are read after the statements: with one state the results, and the
    /// entries of products among them.
    pub(crate) fn read_last(&self) -> impl Iterator<Item = &Operand> {
        let results = if self.execution.has_many_states() { &[] } else { &*self.results };
        let entries = self.products.iter().filter(|products| products.in_place.is_some());
        results.iter().chain(entries.flat_map(|products| &products.entries))
    }

    /// Returns the number of lanes of a value before it is broadcast.
    #[must_use]
    pub fn lanes_of(&self, source: Source) -> u8 {
        match source {
            Source::Result(value) => self.statements[value.statement].lanes,
            Source::Constant(_) | Source::Argument(_) => 1,
        }
    }
}
