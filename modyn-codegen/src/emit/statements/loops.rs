//! Loops over tables as lines of text, for all languages whose statements differ by a [`Syntax`].

use std::fmt::Write as _;

use super::{Body, Syntax};
use crate::program::{Array, Call, Column, Entry, Loop, Loops, Place, Read, Step, Table};

/// The lines before and after the steps of a loop, or before and after the stores of a call.
pub(in crate::emit) struct Around {
    pub before: Vec<String>,
    pub after: Vec<String>,
}

/// A loop, as languages print it.
pub(in crate::emit) struct Iterations<'a> {
    /// The number of loops around this loop.
    pub depth: usize,
    /// The index of the table.
    pub number: usize,
    /// The table, which has a row for each iteration.
    pub table: &'a Table,
    /// Whether the last row is the first one.
    pub reversed: bool,
    /// Whether routines receive the constants of a row.
    pub has_constants: bool,
    /// The text of the number that ends the loop where it is at least zero.
    pub end: Option<String>,
}

/// A call of a routine, as languages print it. Its results are named `results`.
pub(in crate::emit) struct RoutineCall {
    /// The index of the routine.
    pub routine: usize,
    /// The number of loops around the loop whose constants the routine receives.
    pub constants: Option<usize>,
    /// The texts of the numbers that the routine reads.
    pub reads: Vec<String>,
    /// The number of results.
    pub results: usize,
}

/// The loops of one statement.
pub(super) struct LoopStatements<'a, S> {
    /// The statements of the chunk.
    pub body: &'a Body<'a, S>,
    /// The index of the statement.
    pub statement: usize,
    /// The loops.
    pub loops: &'a Loops,
}

impl<S: Syntax> LoopStatements<'_, S> {
    /// Prints the statements that define the arrays and run the steps.
    pub(super) fn print(&self, text: &mut String) {
        let Self { body, statement, loops } = *self;
        for (number, shape) in loops.arrays.iter().enumerate() {
            if !shape.is_empty() {
                line(text, 1, &body.syntax.zeros(&body.array(statement, number), *shape));
            }
        }
        for stored in &loops.stored {
            let entry = self.place(stored.entry.array, Place::fixed(stored.entry.index));
            line(text, 1, &format!("{entry} = {};", body.operand(&stored.value)));
        }
        self.steps(text, &loops.steps, 0);
    }

    fn steps(&self, text: &mut String, steps: &[Step], depth: usize) {
        for step in steps {
            match step {
                Step::Call(call) => self.call(text, call, depth),
                Step::Loop(inner) => self.iterations(text, inner, depth),
            }
        }
    }

    fn iterations(&self, text: &mut String, inner: &Loop, depth: usize) {
        let program = self.body.program;
        let end = |Entry { array, index }| self.place(array, Place::fixed(index));
        let Around { before, after } = self.body.syntax.iterations(&Iterations {
            depth,
            number: inner.table,
            table: &program.tables[inner.table],
            reversed: inner.reversed,
            has_constants: inner.steps.iter().any(|step| match step {
                Step::Call(call) => program.routines[call.routine].constants > 0,
                Step::Loop(_) => false,
            }),
            end: inner.end.map(end),
        });
        before.iter().for_each(|head| line(text, depth + 1, head));
        self.steps(text, &inner.steps, depth + 1);
        after.iter().for_each(|tail| line(text, depth + 1, tail));
    }

    /// Prints the statements of a call: its numbers are read, the routine is called, and the
    /// results are stored.
    fn call(&self, text: &mut String, call: &Call, depth: usize) {
        let Self { body, .. } = *self;
        let constants = body.program.routines[call.routine].constants > 0;
        let Around { before, after } = body.syntax.call(&RoutineCall {
            routine: call.routine,
            constants: constants.then(|| depth - 1),
            reads: call.reads.iter().map(|read| self.read(read)).collect(),
            results: call.writes.len(),
        });
        before.iter().for_each(|head| line(text, depth + 1, head));
        for (i, write) in call.writes.iter().enumerate() {
            let entry = self.place(write.array, write.place);
            let result = body.syntax.result(i);
            let value = if write.adds { format!("{entry} + {result}") } else { result };
            line(text, depth + 1 + usize::from(!after.is_empty()), &format!("{entry} = {value};"));
        }
        after.iter().for_each(|tail| line(text, depth + 1, tail));
    }

    fn read(&self, read: &Read) -> String {
        match *read {
            Read::Argument(place) => self.body.given(place),
            Read::Entry(array, place) => self.place(array, place),
        }
    }

    fn place(&self, array: usize, place: Place) -> String {
        let name = self.body.array(self.statement, array);
        entry(self.body.syntax, &name, self.loops.arrays[array], place)
    }
}

/// Returns the text of an entry of an array. Rows have an index of their own, so that compilers
/// tell them from each other.
pub(super) fn entry(syntax: &impl Syntax, array: &str, shape: Array, place: Place) -> String {
    let Array { columns, .. } = shape;
    if columns == 1 {
        return syntax.entry(array, place);
    }
    let (row, column) = match place.row {
        None => (Place::fixed(place.index / columns), place.index % columns),
        Some(row) => (Place { index: 0, row: Some(row) }, place.index),
    };
    syntax.entry(&syntax.entry(array, row), Place::fixed(column))
}

/// Returns the text of an index in languages that count from zero.
pub(super) fn index(place: Place) -> String {
    match place {
        Place { index, row: None } => index.to_string(),
        Place { index: 0, row: Some(row) } => row_index(row),
        Place { index, row: Some(row) } => format!("{} + {index}", row_index(row)),
    }
}

/// Returns the text of a place of a table.
fn row_index(row: Column) -> String {
    format!("places{}[{}]", row.depth, row.column)
}

/// Prints a line within this number of blocks.
fn line(text: &mut String, depth: usize, line: &str) {
    let _ = writeln!(text, "{}{line}", "    ".repeat(depth));
}
