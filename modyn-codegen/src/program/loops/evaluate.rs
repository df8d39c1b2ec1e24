//! The evaluation of loops on numbers: the reference for printers and back ends.

use modyn_runtime::Scalar;

use super::{Call, Loop, Loops, Place, Read, Row, Step};
use crate::program::{Operand, Program};

impl Loops {
    /// Returns the results. `number` returns the number of an operand.
    pub(in crate::program) fn evaluate<S: Scalar>(
        &self,
        program: &Program,
        arguments: &[S],
        number: impl Fn(&Operand) -> S,
    ) -> Vec<S> {
        let mut arrays: Vec<Vec<S>> =
            self.arrays.iter().map(|array| vec![S::zero(); array.len()]).collect();
        for stored in &self.stored {
            arrays[stored.entry.array][stored.entry.index] = number(&stored.value);
        }
        let mut run = Run { loops: self, program, arguments, arrays, rows: Vec::new() };
        run.steps(&self.steps);
        self.results.iter().map(|entry| run.arrays[entry.array][entry.index]).collect()
    }
}

/// A run of loops.
struct Run<'a, S> {
    loops: &'a Loops,
    program: &'a Program,
    arguments: &'a [S],
    arrays: Vec<Vec<S>>,
    /// The rows of the loops around the current step.
    rows: Vec<&'a Row>,
}

impl<'a, S: Scalar> Run<'a, S> {
    fn steps(&mut self, steps: &'a [Step]) {
        for step in steps {
            match step {
                Step::Call(call) => self.call(call),
                Step::Loop(inner) => self.iterations(inner),
            }
        }
    }

    fn iterations(&mut self, inner: &'a Loop) {
        let rows = &self.program.tables[inner.table].rows;
        for i in 0..rows.len() {
            let ends = |entry: &super::Entry| {
                let number = self.arrays[entry.array][entry.index];
                number.is_known_nonnegative()
            };
            if inner.end.as_ref().is_some_and(ends) {
                break;
            }
            self.rows.push(&rows[if inner.reversed { rows.len() - 1 - i } else { i }]);
            self.steps(&inner.steps);
            self.rows.pop();
        }
    }

    fn call(&mut self, call: &Call) {
        let routine = &self.program.routines[call.routine];
        let of_row = self.rows.last().into_iter().flat_map(|row| &row.constants);
        let constants = of_row.take(routine.constants).map(|&x| S::from_f64(x));
        let read = |read: &Read| match *read {
            Read::Argument(place) => self.arguments[self.index(place, 1)],
            Read::Entry(array, place) => {
                self.arrays[array][self.index(place, self.loops.arrays[array].columns)]
            }
        };
        let inputs: Vec<S> = constants.chain(call.reads.iter().map(read)).collect();
        for (write, result) in call.writes.iter().zip(routine.program.evaluate(&inputs)) {
            let index = self.index(write.place, self.loops.arrays[write.array].columns);
            let entry = &mut self.arrays[write.array][index];
            *entry = if write.adds { *entry + result } else { result };
        }
    }

    /// Returns the index of a place in an array with rows of length `columns`.
    fn index(&self, place: Place, columns: usize) -> usize {
        let row = place.row.map(|row| self.rows[row.depth].places[row.column]);
        place.index + row.unwrap_or(0) * columns
    }
}
