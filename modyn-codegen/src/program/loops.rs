//! Loops within a program: routines that run for each row of a table, over arrays of numbers.
//!
//! ```text
//! store values into arrays
//! for each row of table 0            constants and places of an iteration
//!     call routine 1                 reads entries of arrays and arguments, writes entries of arrays
//!     for each row of table 2 ..
//! results from arrays
//! ```
//!
//! A loop runs at most once for each row of its table. It ends early where an entry of an array
//! says so, as a solver's residual does. Arrays carry numbers from one iteration to the next. A
//! routine is a program without loops, and knows nothing of arrays.

mod evaluate;
mod text;
mod validate;

use modyn_runtime::OperationCount;
pub(super) use validate::tables_fault;

use super::{Operand, Operation, Program, Value};

/// An operation that consists of steps over arrays. The arrays begin with zeros.
#[derive(Clone, Debug, PartialEq)]
pub struct Loops {
    /// The arrays.
    pub arrays: Vec<Array>,
    /// The values that are stored into arrays before the steps.
    pub stored: Vec<Stored>,
    /// The steps, in order.
    pub steps: Vec<Step>,
    /// The entries of arrays that are the results of the operation.
    pub results: Vec<Entry>,
}

/// Loops whose stored values are outputs of a graph.
#[derive(Clone, Debug)]
pub struct LoopForm {
    /// The loops, without stored values.
    pub loops: Loops,
    /// The entries of the stored values.
    pub stored: Vec<Entry>,
}

/// An array of numbers in rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Array {
    /// The number of rows.
    pub rows: usize,
    /// The length of a row.
    pub columns: usize,
}

/// An entry of an array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Entry {
    /// The index of the array.
    pub array: usize,
    /// The index in the array, row after row.
    pub index: usize,
}

/// A value that is stored into an array.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stored {
    /// The entry.
    pub entry: Entry,
    /// The value.
    pub value: Operand,
}

/// A step over arrays.
#[derive(Clone, Debug, PartialEq)]
pub enum Step {
    /// A routine runs once.
    Call(Call),
    /// Steps run for each row of a table.
    Loop(Loop),
}

/// A loop over the rows of a table.
#[derive(Clone, Debug, PartialEq)]
pub struct Loop {
    /// The index of the table.
    pub table: usize,
    /// Whether the last row is the first one.
    pub reversed: bool,
    /// The loop ends before an iteration where this number is at least zero. A number that is NaN
    /// does not end it.
    pub end: Option<Entry>,
    /// The steps of an iteration.
    pub steps: Vec<Step>,
}

/// A call of a routine.
#[derive(Clone, Debug, PartialEq)]
pub struct Call {
    /// The index of the routine.
    pub routine: usize,
    /// The arguments of the routine after its constants.
    pub reads: Vec<Read>,
    /// The destination of each result of the routine.
    pub writes: Vec<Write>,
}

/// An argument of a routine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Read {
    /// An argument of the program.
    Argument(Place),
    /// An entry of an array.
    Entry(usize, Place),
}

/// The destination of a result of a routine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Write {
    /// The index of the array.
    pub array: usize,
    /// The place in the array.
    pub place: Place,
    /// Whether the result is added to the entry, or replaces it.
    pub adds: bool,
}

/// A place in an array, which may differ from iteration to iteration. Arguments of the program have
/// rows of length 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// The index in the array, or after the beginning of the row that `row` gives: within that row
    /// if rows are longer than 1.
    pub index: usize,
    /// The column of rows.
    pub row: Option<Column>,
}

/// A column of rows of arrays in the table of a loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Column {
    /// The number of loops around that loop.
    pub depth: usize,
    /// The index of the column.
    pub column: usize,
}

/// A table of a loop: a row for each iteration.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// The rows; all of them have the same lengths.
    pub rows: Vec<Row>,
}

/// A row of a table.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Row {
    /// The first arguments of the routines that the loop calls.
    pub constants: Vec<f64>,
    /// The rows of arrays to which [`Column`] refers.
    pub places: Vec<usize>,
}

/// A program that steps call. Its arguments are the constants of the innermost loop's row, then the
/// numbers that a call reads.
#[derive(Clone, Debug, PartialEq)]
pub struct Routine {
    /// The program.
    pub program: Program,
    /// The number of constants.
    pub constants: usize,
    /// Whether its code must not be inlined into the calls, since there are several.
    pub never_inline: bool,
}

impl Array {
    /// Returns an array with rows of length 1.
    #[must_use]
    pub fn flat(rows: usize) -> Self {
        Self { rows, columns: 1 }
    }

    /// Returns the number of entries.
    #[must_use]
    pub fn len(self) -> usize {
        self.rows * self.columns
    }

    /// Returns whether there are no entries.
    #[must_use]
    pub fn is_empty(self) -> bool {
        self.len() == 0
    }
}

impl Place {
    /// Returns a place that is the same in all iterations.
    #[must_use]
    pub fn fixed(index: usize) -> Self {
        Self { index, row: None }
    }

    /// Returns place `index` of the row in this column of the loop that no other loop surrounds.
    #[must_use]
    pub fn in_row(column: usize, index: usize) -> Self {
        Self { index, row: Some(Column { depth: 0, column }) }
    }
}

impl Table {
    /// Returns the number of constants of a row.
    #[must_use]
    pub fn constants(&self) -> usize {
        self.rows.first().map_or(0, |row| row.constants.len())
    }

    /// Returns the number of places of a row.
    #[must_use]
    pub fn places(&self) -> usize {
        self.rows.first().map_or(0, |row| row.places.len())
    }

    /// Returns whether the rows are empty: they only count iterations.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.constants() == 0 && self.places() == 0
    }

    /// Returns the largest place.
    #[must_use]
    pub fn last_place(&self) -> usize {
        self.rows.iter().flat_map(|row| row.places.iter().copied()).max().unwrap_or(0)
    }
}

impl Loops {
    /// Returns the operations of all iterations; of a loop that may end early, the operations of
    /// one iteration. Additions to entries count.
    pub(super) fn operations(&self, program: &Program) -> OperationCount {
        operations(&self.steps, program)
    }

    /// Returns the number of additions to entries in the text.
    pub(super) fn static_operations(&self) -> OperationCount {
        let mut additions = 0;
        self.each_call(&mut |call| additions += call.additions());
        OperationCount { additions, ..OperationCount::default() }
    }

    /// Returns the arguments of the program that routines read: where a table gives their places,
    /// the first one.
    #[must_use]
    pub fn arguments(&self) -> Vec<usize> {
        let mut arguments = Vec::new();
        self.each_call(&mut |call| {
            arguments.extend(call.reads.iter().filter_map(|read| match read {
                Read::Argument(place) => Some(place.index),
                Read::Entry(..) => None,
            }));
        });
        arguments
    }

    /// Calls `visit` for each call in the text, in order.
    pub(crate) fn each_call<'a>(&'a self, visit: &mut dyn FnMut(&'a Call)) {
        each_call(&self.steps, visit);
    }
}

impl Call {
    /// Returns the number of results that are added to entries.
    fn additions(&self) -> usize {
        self.writes.iter().filter(|write| write.adds).count()
    }
}

impl Program {
    /// Returns the index of the statement and the first entry if the results of the program are
    /// consecutive entries of an array of loops that has rows of length 1.
    #[must_use]
    pub fn results_in_array(&self) -> Option<(usize, Entry)> {
        let entry = |result: &Operand| {
            let Value { statement, place } = result.value().filter(|_| !result.negated)?;
            let Operation::Loops(loops) = &self.statements[statement].operation else {
                return None;
            };
            let entry = loops.results[place];
            (loops.arrays[entry.array].columns == 1).then_some((statement, entry))
        };
        let (statement, first) = entry(self.results.first()?)?;
        let expected = |k: usize| Entry { index: first.index + k, ..first };
        let mut results = self.results.iter().enumerate();
        let are_consecutive = results.all(|(k, x)| entry(x) == Some((statement, expected(k))));
        are_consecutive.then_some((statement, first))
    }
}

fn each_call<'a>(steps: &'a [Step], visit: &mut dyn FnMut(&'a Call)) {
    for step in steps {
        match step {
            Step::Call(call) => visit(call),
            Step::Loop(inner) => each_call(&inner.steps, visit),
        }
    }
}

fn operations(steps: &[Step], program: &Program) -> OperationCount {
    let count = |step: &Step| match step {
        Step::Call(call) => {
            let additions =
                OperationCount { additions: call.additions(), ..OperationCount::default() };
            program.routines[call.routine].program.operations_per_call() + additions
        }
        Step::Loop(inner) => {
            let iteration = operations(&inner.steps, program);
            let rows = program.tables[inner.table].rows.len();
            std::iter::repeat_n(iteration, if inner.end.is_some() { 1 } else { rows }).sum()
        }
    };
    steps.iter().map(count).sum()
}
