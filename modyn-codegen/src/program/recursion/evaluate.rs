//! The evaluation of a recursion on numbers: the reference for printers.

use modyn_runtime::Scalar;

use super::{Read, Recursion, Step, Sweep, Write};
use crate::program::Source;

impl Recursion {
    /// Returns the result for these arguments, one after the other, by the operations of [`Scalar`].
    ///
    /// # Panics
    ///
    /// If an argument that is read is missing.
    #[must_use]
    pub fn evaluate<S: Scalar>(&self, arguments: &[S]) -> Vec<S> {
        let mut starts = [0; 4];
        for k in 1..4 {
            starts[k] = starts[k - 1] + self.arguments[k - 1];
        }
        let mut records = vec![vec![S::zero(); self.record]; self.records()];
        let mut results = vec![S::zero(); self.results];
        for (s, &sweep) in self.sweeps.iter().enumerate() {
            for (slot, number) in &self.world[s] {
                let value = match number.source {
                    Source::Constant(value) => S::from_f64(value),
                    Source::Argument(parameter) => arguments[starts[3] + parameter],
                    Source::Result(_) => unreachable!("the world computes nothing"),
                };
                records[0][*slot] = if number.negated { -value } else { value };
            }
            for (_, run) in self.in_order(sweep) {
                let Step { program, reads, writes, .. } = &self.steps[run.kind][s];
                let count = run.bodies.len();
                for i in 0..count {
                    let i = if sweep == Sweep::Outward { i } else { count - 1 - i };
                    let [own, parent, q, v] = run.bodies[i].all().map(usize::from);
                    let read = |read: &Read| match *read {
                        Read::Vector(0, entry) => arguments[q + entry],
                        Read::Vector(vector, entry) => arguments[starts[vector] + v + entry],
                        Read::Parameter(parameter) => arguments[starts[3] + parameter],
                        Read::Own(slot) => records[own][slot],
                        Read::Parent(slot) => records[parent][slot],
                    };
                    let constants = run.table[i].iter().map(|&x| S::from_f64(x));
                    let all: Vec<S> = constants.chain(reads.iter().map(read)).collect();
                    for (write, x) in writes.iter().zip(program.evaluate(&all)) {
                        match *write {
                            Write::Own(slot) => records[own][slot] = x,
                            Write::AddToParent(slot) => {
                                records[parent][slot] = records[parent][slot] + x;
                            }
                            Write::Result(entry) => results[v + entry] = x,
                        }
                    }
                }
            }
        }
        results
    }
}
