//! Programs with loops, whose iterations call machine code: the solver of a step.
//!
//! What runs before the loops, each routine, and what runs after them are functions of machine
//! code. The loops themselves run here, or in the code of an object's entry. In a batch the lanes of
//! each number are states. A state whose loop has ended keeps its numbers while others go on: the
//! routines of a batch select them by a number that is negative in the lanes of such states.
//!
//! All numbers of a call are in one memory, which is the argument of each function:
//!
//! ```text
//! arguments | results of `before` | arrays of the loops | in a batch, which states run
//! ```
//!
//! An array that no routine writes is read where `before` stores it.

use std::collections::BTreeMap;

use modyn_codegen::program::{Call, Entry, Loop, Loops, Place, Program, Read, Step, Table, Write};

use crate::machine::{Code, Pages};
use crate::real::Real;
use crate::values::Kept;

/// The code of a program with loops.
pub(crate) struct LoopedCode {
    pub before: Code,
    pub after: Code,
    /// The code of each routine.
    pub routines: Vec<Code>,
    pub plan: LoopPlan,
}

/// The loops, with the places of all numbers in the memory.
pub(crate) struct LoopPlan {
    pub layout: Layout,
    /// The copies of the results of `before` into arrays that routines write.
    pub stored: Vec<Copied>,
    pub steps: Vec<PlannedStep>,
}

/// A call or a loop, with places in the memory.
pub(crate) enum PlannedStep {
    Call { routine: usize, writes: Vec<Copied> },
    Loop { count: usize, end: Option<usize>, steps: Vec<PlannedStep> },
}

/// A copy of consecutive numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Copied {
    pub from: usize,
    pub to: usize,
    pub count: usize,
}

/// The lanes of a program's vectors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Lanes {
    /// Numbers of one state.
    Numbers,
    /// A number of many states.
    States,
}

/// The places of numbers in the memory.
pub(crate) struct Layout {
    /// The length of the memory.
    pub length: usize,
    /// The first result of `before`: the number of the program's arguments.
    pub before: usize,
    /// The first number of the arrays.
    pub arrays: usize,
    /// The start of each array.
    starts: Vec<usize>,
    /// In a batch, the number that is negative for states whose loop has ended.
    runs: Option<usize>,
    /// For each array that no routine writes, the places of its entries among the stored numbers.
    unwritten: Vec<Option<BTreeMap<usize, usize>>>,
}

impl Layout {
    /// Returns the places of a program with so many arguments and results of `before`.
    fn new(loops: &Loops, arguments: usize, results: usize, lanes: Lanes) -> Self {
        let mut is_written = vec![false; loops.arrays.len()];
        note_writes(&loops.steps, &mut is_written);
        let mut stored = vec![BTreeMap::new(); loops.arrays.len()];
        for (k, number) in loops.stored.iter().enumerate() {
            stored[number.entry.array].insert(number.entry.index, k);
        }
        let stored_arrays = loops.arrays.iter().zip(is_written).zip(stored);
        let unwritten: Vec<Option<BTreeMap<usize, usize>>> = stored_arrays
            .map(|((array, is_written), stored)| {
                (!is_written && stored.len() == array.len()).then_some(stored)
            })
            .collect();
        let arrays = arguments + results;
        let mut length = arrays;
        let mut starts = Vec::new();
        for (array, unwritten) in loops.arrays.iter().zip(&unwritten) {
            starts.push(length);
            length += if unwritten.is_some() { 0 } else { array.len() };
        }
        let runs = (lanes == Lanes::States).then_some(length);
        length += usize::from(runs.is_some());
        Self { length, before: arguments, arrays, starts, runs, unwritten }
    }

    /// Returns the place of an entry of an array.
    fn place(&self, entry: Entry) -> usize {
        match &self.unwritten[entry.array] {
            Some(stored) => self.before + stored[&entry.index],
            None => self.starts[entry.array] + entry.index,
        }
    }

    /// Returns the place of a number that a routine reads.
    fn read(&self, read: Read) -> usize {
        match read {
            Read::Entry(array, place) => self.place(Entry { array, index: fixed(place) }),
            Read::Argument(place) => fixed(place),
        }
    }

    /// Returns the place of a number that a routine writes.
    fn written(&self, write: &Write) -> usize {
        self.starts[write.array] + fixed(write.place)
    }

    /// Returns the place of an argument of what runs after the loops.
    fn after(&self, loops: &Loops, argument: usize) -> usize {
        let Some(number) = argument.checked_sub(self.before) else { return argument };
        match loops.results.get(number) {
            Some(&entry) => self.place(entry),
            None => self.before + loops.stored.len() + number - loops.results.len(),
        }
    }

    /// Returns calls and loops with the places of what they write.
    fn steps(&self, steps: &[Step], tables: &[Table]) -> Vec<PlannedStep> {
        let step = |step: &Step| match step {
            Step::Call(call) => PlannedStep::Call {
                routine: call.routine,
                writes: runs(call.writes.iter().enumerate().map(|(from, write)| {
                    assert!(!write.adds, "results of a solver replace numbers");
                    (from, self.written(write))
                })),
            },
            Step::Loop(Loop { table, end, steps, .. }) => PlannedStep::Loop {
                count: tables[*table].rows.len(),
                end: end.map(|entry| self.place(entry)),
                steps: self.steps(steps, tables),
            },
        };
        steps.iter().map(step).collect()
    }
}

/// Notes the arrays that steps write.
fn note_writes(steps: &[Step], is_written: &mut [bool]) {
    for step in steps {
        match step {
            Step::Call(call) => call.writes.iter().for_each(|write| is_written[write.array] = true),
            Step::Loop(inner) => note_writes(&inner.steps, is_written),
        }
    }
}

/// Returns the call of each routine. A routine has one call.
fn calls<'a>(steps: &'a [Step], by_routine: &mut BTreeMap<usize, &'a Call>) {
    for step in steps {
        match step {
            Step::Call(call) => {
                let other = by_routine.insert(call.routine, call);
                assert!(other.is_none(), "each routine of a solver has one call");
            }
            Step::Loop(inner) => calls(&inner.steps, by_routine),
        }
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
    /// Returns the code of a program with loops. `append` compiles a program whose arguments are
    /// one array of this length, and whose states keep numbers.
    pub fn new(
        program: &Program,
        arguments: usize,
        lanes: Lanes,
        mut append: impl FnMut(&Program, usize, Option<&Kept>) -> Code,
    ) -> Self {
        let parts = program.around_loops().expect("a program with loops");
        let loops = parts.loops;
        let layout = Layout::new(loops, arguments, parts.before.results.len(), lanes);
        let mut by_routine = BTreeMap::new();
        calls(&loops.steps, &mut by_routine);
        let mut routines = Vec::new();
        for (k, routine) in program.routines.iter().enumerate() {
            let Call { reads, writes, .. } = by_routine[&k];
            let placed =
                routine.program.with_arguments_at(layout.length, |n| layout.read(reads[n]));
            let places = || writes.iter().map(|write| layout.written(write)).collect();
            let kept = layout.runs.map(|runs| Kept { runs, places: places() });
            routines.push(append(&placed, layout.length, kept.as_ref()));
        }
        let after = parts.after.with_arguments_at(layout.length, |n| layout.after(loops, n));
        let numbers = loops.stored.iter().enumerate();
        let stored = numbers
            .filter(|(_, stored)| layout.unwritten[stored.entry.array].is_none())
            .map(|(k, stored)| (layout.before + k, layout.place(stored.entry)));
        Self {
            before: append(&parts.before, arguments, None),
            after: append(&after, layout.length, None),
            routines,
            plan: LoopPlan {
                stored: runs(stored),
                steps: layout.steps(&loops.steps, &program.tables),
                layout,
            },
        }
    }

    /// Returns the largest number of results of a routine.
    pub fn routine_results(&self) -> usize {
        self.routines.iter().map(|code| code.results).max().unwrap_or(0)
    }

    /// Runs the code on checked arguments, with this number of states at a time.
    pub fn call<S: Real>(&self, pages: &Pages, arguments: &[&[S]], result: &mut [S], lanes: usize) {
        let LoopPlan { layout, stored, steps } = &self.plan;
        let routine_results = self.routine_results();
        let length = layout.length * lanes;
        S::with_scratch(length + routine_results, |scratch| {
            let (memory, results) = scratch.split_at_mut(length);
            let (given, rest) = memory.split_at_mut(layout.before * lanes);
            let mut left = &mut *given;
            for argument in arguments {
                let numbers;
                (numbers, left) = left.split_at_mut(argument.len());
                numbers.copy_from_slice(argument);
            }
            self.before.call(pages, &[given], rest);
            // All states run: zero is not negative.
            memory[layout.arrays * lanes..].fill(S::default());
            for Copied { from, to, count } in stored {
                memory.copy_within(from * lanes..(from + count) * lanes, to * lanes);
            }
            let is_running = u32::MAX >> (u32::BITS as usize - lanes);
            Run { code: self, pages, lanes, memory, results, is_running }.steps(steps);
            self.after.call(pages, &[memory], result);
        });
    }
}

/// A run of loops.
struct Run<'a, S> {
    code: &'a LoopedCode,
    pages: &'a Pages,
    lanes: usize,
    memory: &'a mut [S],
    /// The results of a routine.
    results: &'a mut [S],
    /// A bit for each lane: whether no loop around the current step has ended.
    is_running: u32,
}

impl<S: Real> Run<'_, S> {
    fn steps(&mut self, steps: &[PlannedStep]) {
        for step in steps {
            match step {
                PlannedStep::Call { routine, writes } => self.routine(*routine, writes),
                PlannedStep::Loop { count, end, steps } => self.iterations(*count, *end, steps),
            }
        }
    }

    fn iterations(&mut self, count: usize, end: Option<usize>, steps: &[PlannedStep]) {
        let outer = self.is_running;
        for _ in 0..count {
            if let Some(end) = end {
                let ends = &self.memory[end * self.lanes..][..self.lanes];
                let mut states = self.is_running;
                for (lane, end) in ends.iter().enumerate() {
                    states &= !(u32::from(end.is_known_nonnegative()) << lane);
                }
                self.run_only(states);
                if states == 0 {
                    break;
                }
            }
            self.steps(steps);
        }
        self.run_only(outer);
    }

    /// Sets which states run, as bits.
    fn run_only(&mut self, states: u32) {
        if states == self.is_running {
            return;
        }
        self.is_running = states;
        let Some(runs) = self.code.plan.layout.runs else { return };
        for (lane, runs) in self.memory[runs * self.lanes..][..self.lanes].iter_mut().enumerate() {
            *runs = S::from_f64(if states >> lane & 1 == 1 { 0.0 } else { -1.0 });
        }
    }

    fn routine(&mut self, routine: usize, writes: &[Copied]) {
        let lanes = self.lanes;
        self.code.routines[routine].call(self.pages, &[self.memory], self.results);
        for &Copied { from, to, count } in writes {
            let length = count * lanes;
            let from = &self.results[from * lanes..][..length];
            let to = &mut self.memory[to * lanes..][..length];
            to.copy_from_slice(from);
        }
    }
}
