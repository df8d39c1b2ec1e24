//! The rules that loops satisfy.

use super::{Array, Call, Entry, Loop, Loops, Place, Read, Routine, Step, Table};
use crate::program::{Execution, Program};

impl Loops {
    /// Returns the rule that the loops break. The rules of operands are checked for all operations
    /// together.
    pub(in crate::program) fn fault(&self, program: &Program) -> Option<&'static str> {
        let entries = self.stored.iter().map(|stored| &stored.entry).chain(&self.results);
        if !entries.into_iter().all(|entry| self.has(entry)) {
            return Some("an entry of an array is within the array");
        }
        if program.execution == Execution::Threads && !self.has_fixed_places(program) {
            return Some("loops of threads have fixed places and no constants");
        }
        let mut check = Check { loops: self, program, tables: Vec::new() };
        check.steps(&self.steps)
    }

    /// Returns whether all iterations are the same but for the numbers in arrays.
    fn has_fixed_places(&self, program: &Program) -> bool {
        program.tables.iter().all(Table::is_empty)
            && self.arrays.iter().all(|array| array.columns == 1)
    }

    fn has(&self, entry: &Entry) -> bool {
        self.arrays.get(entry.array).is_some_and(|array| entry.index < array.len())
    }
}

struct Check<'a> {
    loops: &'a Loops,
    program: &'a Program,
    /// The tables of the loops around the current step.
    tables: Vec<&'a Table>,
}

impl<'a> Check<'a> {
    fn steps(&mut self, steps: &'a [Step]) -> Option<&'static str> {
        steps.iter().find_map(|step| match step {
            Step::Call(call) => self.call(call),
            Step::Loop(inner) => self.inner(inner),
        })
    }

    fn inner(&mut self, inner: &'a Loop) -> Option<&'static str> {
        let Some(table) = self.program.tables.get(inner.table) else {
            return Some("a loop has a table");
        };
        if inner.end.is_some_and(|entry| !self.loops.has(&entry)) {
            return Some("an entry of an array is within the array");
        }
        self.tables.push(table);
        let fault = self.steps(&inner.steps);
        self.tables.pop();
        fault
    }

    fn call(&self, call: &Call) -> Option<&'static str> {
        let Some(Routine { program, constants, .. }) = self.program.routines.get(call.routine)
        else {
            return Some("a routine that is called exists");
        };
        let given = self.tables.last().map_or(0, |table| table.constants());
        if ![0, given].contains(constants)
            || program.arguments != constants + call.reads.len()
            || program.results.len() != call.writes.len()
        {
            return Some("a routine has as many arguments and results as its calls give");
        }
        let array = |array: usize| self.loops.arrays.get(array).copied();
        let reads = call.reads.iter().all(|read| match *read {
            Read::Argument(place) => {
                self.ends_within(place, Some(Array::flat(self.program.arguments)))
            }
            Read::Entry(read, place) => self.ends_within(place, array(read)),
        });
        let writes =
            call.writes.iter().all(|write| self.ends_within(write.place, array(write.array)));
        (!reads || !writes).then_some("an entry of an array is within the array")
    }

    /// Returns whether a place is within an array in all iterations.
    fn ends_within(&self, place: Place, array: Option<Array>) -> bool {
        let Some(array) = array else { return false };
        let Some(row) = place.row else { return place.index < array.len() };
        let is_in_row = array.columns == 1 || place.index < array.columns;
        let ends = |first: Option<&usize>| {
            let start = first.and_then(|first| first.checked_mul(array.columns));
            let index = start.and_then(|start| start.checked_add(place.index));
            index.is_some_and(|index| index < array.len())
        };
        let table = self.tables.get(row.depth);
        is_in_row
            && table.is_some_and(|table| table.rows.iter().all(|r| ends(r.places.get(row.column))))
    }
}

/// Returns the rule that the tables and routines of a program break.
pub(in crate::program) fn tables_fault(program: &Program) -> Option<&'static str> {
    let is_even = |table: &Table| {
        let [constants, places] = [table.constants(), table.places()];
        let has_lengths =
            |row: &super::Row| row.constants.len() == constants && row.places.len() == places;
        table.rows.iter().all(has_lengths)
    };
    let is_flat = |routine: &Routine| routine.program.routines.is_empty();
    if !program.tables.iter().all(is_even) {
        return Some("the rows of a table have the same lengths");
    }
    (!program.routines.iter().all(is_flat)).then_some("a routine has no loops")
}
