//! Programs with loops, whose iterations call machine code: the solver of a step.
//!
//! What runs before the loops, each routine, and what runs after them are functions of machine
//! code. The loops themselves run here, over arrays. In a batch the lanes of each number are
//! states. A state whose loop has ended keeps its numbers while others go on.

use modyn_codegen::program::{Call, Loop, Loops, Place, Program, Read, Step, Table};

use crate::machine::{Code, Pages};
use crate::real::Real;

/// The code of a program with loops.
pub(crate) struct LoopedCode {
    before: Code,
    after: Code,
    /// The code of each routine, whose argument is one array.
    routines: Vec<Code>,
    plan: LoopPlan,
}

/// The loops, with copies of consecutive numbers.
pub(crate) struct LoopPlan {
    /// The start of each array in the memory of all arrays, and its end.
    starts: Vec<usize>,
    /// The copies of the results of `before` into arrays, and the number of these results.
    stored: Vec<Copied>,
    stored_count: usize,
    steps: Vec<PlannedStep>,
    /// The copies of arrays into an argument of `after`.
    results: Vec<Copied>,
    /// The lengths of the arrays of arguments.
    arguments: Vec<usize>,
}

enum PlannedStep {
    Call { routine: usize, reads: Vec<ReadCopy>, writes: Vec<Copied> },
    Loop { count: usize, end: Option<usize>, steps: Vec<PlannedStep> },
}

/// A copy of consecutive numbers, by indices in the memory of all arrays or in an array of a
/// routine.
#[derive(Clone, Copy, Debug)]
struct Copied {
    from: usize,
    to: usize,
    count: usize,
}

/// A copy of consecutive numbers to the argument of a routine.
#[derive(Clone, Copy, Debug)]
struct ReadCopy {
    source: Source,
    copied: Copied,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Source {
    Arrays,
    Argument(usize),
}

impl LoopPlan {
    /// Returns the plan of loops. All places are fixed, as in the solver of a step.
    pub fn new(program: &Program, loops: &Loops, arguments: &[usize]) -> Self {
        let mut starts = vec![0];
        for array in &loops.arrays {
            starts.push(starts[starts.len() - 1] + array.len());
        }
        let mut planning = Planning { starts: &starts, arguments, tables: &program.tables };
        let stored_entries = loops.stored.iter().enumerate();
        let stored =
            stored_entries.map(|(k, stored)| (k, starts[stored.entry.array] + stored.entry.index));
        let entries = loops.results.iter().enumerate();
        let results = entries.map(|(k, entry)| (starts[entry.array] + entry.index, k));
        Self {
            stored: runs(stored),
            stored_count: loops.stored.len(),
            results: runs(results),
            steps: planning.steps(&loops.steps),
            arguments: arguments.to_vec(),
            starts,
        }
    }
}

/// What the steps of a plan are made from.
struct Planning<'a> {
    starts: &'a [usize],
    arguments: &'a [usize],
    tables: &'a [Table],
}

impl Planning<'_> {
    fn steps(&mut self, steps: &[Step]) -> Vec<PlannedStep> {
        let step = |step: &Step| match step {
            Step::Call(call) => self.call(call),
            Step::Loop(Loop { table, end, steps, .. }) => PlannedStep::Loop {
                count: self.tables[*table].rows.len(),
                end: end.map(|entry| self.starts[entry.array] + entry.index),
                steps: self.steps(steps),
            },
        };
        steps.iter().map(step).collect()
    }

    fn call(&self, call: &Call) -> PlannedStep {
        let mut reads: Vec<ReadCopy> = Vec::new();
        for (to, read) in call.reads.iter().enumerate() {
            let (source, from) = match *read {
                Read::Entry(array, place) => (Source::Arrays, self.starts[array] + fixed(place)),
                Read::Argument(place) => self.argument(fixed(place)),
            };
            match reads.last_mut() {
                Some(last)
                    if last.source == source && last.copied.from + last.copied.count == from =>
                {
                    last.copied.count += 1;
                }
                _ => reads.push(ReadCopy { source, copied: Copied { from, to, count: 1 } }),
            }
        }
        let writes = call.writes.iter().enumerate().map(|(from, write)| {
            assert!(!write.adds, "results of a solver replace numbers");
            (from, self.starts[write.array] + fixed(write.place))
        });
        PlannedStep::Call { routine: call.routine, reads, writes: runs(writes) }
    }

    fn argument(&self, mut number: usize) -> (Source, usize) {
        for (array, &length) in self.arguments.iter().enumerate() {
            if number < length {
                return (Source::Argument(array), number);
            }
            number -= length;
        }
        unreachable!("an argument of the program")
    }
}

/// Returns the index of a place that is the same in all iterations.
fn fixed(place: Place) -> usize {
    assert!(place.row.is_none(), "the places of a solver are fixed");
    place.index
}

/// Returns copies of consecutive numbers from pairs of places.
fn runs(pairs: impl Iterator<Item = (usize, usize)>) -> Vec<Copied> {
    let mut runs: Vec<Copied> = Vec::new();
    for (from, to) in pairs {
        match runs.last_mut() {
            Some(last) if (last.from + last.count, last.to + last.count) == (from, to) => {
                last.count += 1;
            }
            _ => runs.push(Copied { from, to, count: 1 }),
        }
    }
    runs
}

impl LoopedCode {
    /// Returns the code of a program with loops. `append` compiles a program with arguments in
    /// arrays of these lengths.
    pub fn new(
        program: &Program,
        arguments: &[usize],
        mut append: impl FnMut(&Program, &[usize]) -> Code,
    ) -> Self {
        let parts = program.around_loops().expect("a program with loops");
        let given: usize = arguments.iter().sum();
        let after = [arguments, &[parts.after.arguments - given]].concat();
        Self {
            before: append(&parts.before, arguments),
            after: append(&parts.after, &after),
            routines: program
                .routines
                .iter()
                .map(|routine| append(&routine.program, &[routine.program.arguments]))
                .collect(),
            plan: LoopPlan::new(program, parts.loops, arguments),
        }
    }

    /// Runs the code on checked arguments, with this number of states at a time.
    pub fn call<S: Real>(&self, pages: &Pages, arguments: &[&[S]], result: &mut [S], lanes: usize) {
        let zero = S::default();
        let plan = &self.plan;
        let mut computed = vec![zero; self.before.results];
        self.before.call(pages, arguments, &mut computed);
        let count = plan.starts[plan.starts.len() - 1];
        let mut run = Run {
            code: self,
            pages,
            arguments,
            lanes,
            arrays: vec![zero; count * lanes],
            reads: Vec::new(),
            results: Vec::new(),
            is_running: vec![true; lanes],
        };
        for stored in &plan.stored {
            copy(*stored, lanes, &computed, &mut run.arrays);
        }
        run.steps(&plan.steps);
        // The results of the loops, then what `before` has computed for `after`.
        let mut given = vec![zero; self.after.arguments[plan.arguments.len()]];
        for copied in &plan.results {
            copy(*copied, lanes, &run.arrays, &mut given);
        }
        let crossing = &computed[plan.stored_count * lanes..];
        let results = given.len() - crossing.len();
        given[results..].copy_from_slice(crossing);
        self.after.call(pages, &[arguments, &[&given[..]]].concat(), result);
    }
}

/// A run of loops.
struct Run<'a, S> {
    code: &'a LoopedCode,
    pages: &'a Pages,
    arguments: &'a [&'a [S]],
    lanes: usize,
    /// The numbers of all arrays.
    arrays: Vec<S>,
    /// The argument and the results of a routine.
    reads: Vec<S>,
    results: Vec<S>,
    /// For each lane, whether no loop around the current step has ended.
    is_running: Vec<bool>,
}

impl<S: Real> Run<'_, S> {
    fn steps(&mut self, steps: &[PlannedStep]) {
        for step in steps {
            match step {
                PlannedStep::Call { routine, reads, writes } => {
                    self.routine(*routine, reads, writes);
                }
                PlannedStep::Loop { count, end, steps } => self.iterations(*count, *end, steps),
            }
        }
    }

    fn iterations(&mut self, count: usize, end: Option<usize>, steps: &[PlannedStep]) {
        let outer = self.is_running.clone();
        for _ in 0..count {
            if let Some(end) = end {
                let ends = &self.arrays[end * self.lanes..][..self.lanes];
                for (is_running, end) in self.is_running.iter_mut().zip(ends) {
                    *is_running &= !end.is_known_nonnegative();
                }
                if !self.is_running.contains(&true) {
                    break;
                }
            }
            self.steps(steps);
        }
        self.is_running = outer;
    }

    fn routine(&mut self, routine: usize, reads: &[ReadCopy], writes: &[Copied]) {
        let code = &self.code.routines[routine];
        self.reads.resize(code.arguments[0], S::default());
        self.results.resize(code.results, S::default());
        for ReadCopy { source, copied } in reads {
            let from = match source {
                Source::Arrays => &self.arrays[..],
                Source::Argument(array) => self.arguments[*array],
            };
            copy(*copied, self.lanes, from, &mut self.reads);
        }
        code.call(self.pages, &[&self.reads[..code.arguments[0]]], &mut self.results);
        let is_whole = !self.is_running.contains(&false);
        for copied in writes {
            if is_whole {
                copy(*copied, self.lanes, &self.results, &mut self.arrays);
                continue;
            }
            let length = copied.count * self.lanes;
            let from = &self.results[copied.from * self.lanes..][..length];
            let to = &mut self.arrays[copied.to * self.lanes..][..length];
            for (i, (to, from)) in to.iter_mut().zip(from).enumerate() {
                if self.is_running[i % self.lanes] {
                    *to = *from;
                }
            }
        }
    }
}

/// Copies numbers, each with its lanes.
fn copy<S: Real>(copied: Copied, lanes: usize, from: &[S], to: &mut [S]) {
    let Copied { from: first, to: target, count } = copied;
    let length = count * lanes;
    to[target * lanes..][..length].copy_from_slice(&from[first * lanes..][..length]);
}
