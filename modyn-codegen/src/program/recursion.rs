//! Recursions in loops over bodies: the short form of code, whose length does not depend on the number of bodies.
//!
//! Each body has a record of numbers, and so has the world. A sweep runs the program of a body's kind for each body, in order
//! or in reverse. The program reads the body's constants, its entries of the arguments, its own record, and in outward sweeps
//! its parent's record. In inward sweeps it adds numbers to its parent's record.

mod cut;
mod evaluate;
mod order;
mod slots;
mod validate;

use std::collections::BTreeSet;

use modyn_runtime::OperationCount;
pub use modyn_runtime::equations::dynamics::Sweep;

use super::{Execution, Operand, Program};
use crate::graph::Graph;
use crate::trace::BodyGraphs;
use cut::{Kind, Number};
use order::runs;

/// A recursion over the bodies of a tree, in loops.
#[derive(Clone, Debug)]
pub struct Recursion {
    /// The sweeps, in order.
    pub sweeps: Vec<Sweep>,
    /// For each sweep, the numbers of the world's record before it.
    pub world: Vec<Vec<(usize, Operand)>>,
    /// The programs of a body of each kind, one for each sweep.
    pub steps: Vec<Vec<Step>>,
    /// The bodies, parents before children; bodies of one kind that follow each other share a loop.
    pub runs: Vec<Run>,
    /// The lengths of the arguments: three joint vectors, then the run-time parameters.
    pub arguments: [usize; 4],
    /// The length of the result, a joint vector.
    pub results: usize,
    /// The length of a record.
    pub record: usize,
}

/// The program of a body in a sweep. Its arguments are the body's constants, then the numbers that it reads.
#[derive(Clone, Debug)]
pub struct Step {
    /// The program.
    pub program: Program,
    /// The numbers that it reads.
    pub reads: Vec<Read>,
    /// The place of each of its results.
    pub writes: Vec<Write>,
    /// Whether several loops call it.
    pub is_shared: bool,
}

/// A number that a step reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Read {
    /// An entry of a joint vector (first index): the body's entry with this index.
    Vector(usize, usize),
    /// A run-time parameter.
    Parameter(usize),
    /// A number of the body's record.
    Own(usize),
    /// A number of the parent's record.
    Parent(usize),
}

/// The place of a result of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Write {
    /// A number of the body's record.
    Own(usize),
    /// A number of the parent's record, to which it is added.
    AddToParent(usize),
    /// The body's entry of the result with this index.
    Result(usize),
}

/// Bodies of one kind that follow each other.
#[derive(Clone, Debug)]
pub struct Run {
    /// The index of their kind.
    pub kind: usize,
    /// The constants of each body.
    pub table: Vec<Vec<f64>>,
    /// The places of each body.
    pub bodies: Vec<Places>,
}

/// The places of a body's numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Places {
    /// The index of its record; 0 is the world's.
    pub own: u16,
    /// The index of its parent's record.
    pub parent: u16,
    /// The index of its first entry of q.
    pub q: u16,
    /// The index of its first entry of the other joint vectors.
    pub v: u16,
}

impl Recursion {
    /// Returns the recursion with these graphs, for joint vectors of these lengths; `None` if the robot has too many joints
    /// for the tables of places. `pass` rewrites the graph of each sweep.
    #[must_use]
    pub fn new(
        graphs: &BodyGraphs,
        [nq, nv]: [usize; 2],
        pass: fn(&Graph) -> Graph,
    ) -> Option<Self> {
        let sweeps: Vec<Sweep> = graphs.sweeps.iter().map(|(sweep, _)| *sweep).collect();
        let context = (graphs.sweeps, graphs.parameters);
        let received = graphs.kinds.iter().flat_map(|kind| cut::received(kind, context));
        let needed: BTreeSet<(usize, usize)> = received.collect();
        let kinds: Vec<Kind> =
            graphs.kinds.iter().map(|kind| Kind::new(kind, context, &needed)).collect();
        let (slots, record) = slots::slots(&kinds, graphs.sweeps, &needed);
        let runs = runs(graphs)?;
        let steps = kinds.iter().zip(&slots).enumerate().map(|(k, (kind, slots))| {
            let is_shared = runs.iter().filter(|run| run.kind == k).count() > 1;
            let slot =
                |number: &Number| slots.of(number).expect("a number of a record has a place");
            let step = |(sweep, direction): (usize, &Sweep)| {
                kind.step((sweep, *direction), slot, (pass, is_shared))
            };
            sweeps.iter().enumerate().map(step).collect()
        });
        let world = graphs.world.iter().enumerate().map(|(sweep, graph)| {
            let program = Program::new(graph, graphs.parameters, Execution::Scalar);
            assert!(program.statements.is_empty(), "the world computes nothing");
            let slot = |k| slots.first()?.of(&Number::Exchanged(sweep, k));
            let numbers = program.results.iter().enumerate();
            numbers.filter_map(|(k, number)| Some((slot(k)?, *number))).collect()
        });
        let recursion = Self {
            world: world.collect(),
            steps: steps.collect(),
            runs,
            arguments: [nq, nv, nv, graphs.parameters],
            results: nv,
            record,
            sweeps,
        };
        assert_eq!(recursion.fault(), None, "a fault of modyn: please report it");
        Some(recursion)
    }

    /// Returns the number of records: those of the bodies, and the world's.
    #[must_use]
    pub fn records(&self) -> usize {
        1 + self.runs.iter().map(|run| run.bodies.len()).sum::<usize>()
    }

    /// Returns the runs in the order of a sweep.
    pub fn in_order(&self, sweep: Sweep) -> impl Iterator<Item = (usize, &Run)> {
        let count = self.runs.len();
        let place = move |i| if sweep == Sweep::Outward { i } else { count - 1 - i };
        (0..count).map(move |i| (place(i), &self.runs[place(i)]))
    }

    /// Returns the operations of one call; the steps count once for each body.
    #[must_use]
    pub fn operations_per_call(&self) -> OperationCount {
        let run = |run: &Run| {
            let one: OperationCount = self.steps[run.kind].iter().map(Step::operations).sum();
            std::iter::repeat_n(one, run.bodies.len()).sum::<OperationCount>()
        };
        self.runs.iter().map(run).sum()
    }

    /// Returns the operations in the text; the steps count once.
    #[must_use]
    pub fn static_operations(&self) -> OperationCount {
        self.steps.iter().flatten().map(Step::operations).sum()
    }
}

impl Step {
    /// Returns the operations for one body: those of the program, and the additions to the parent's record.
    fn operations(&self) -> OperationCount {
        let added = self.writes.iter().filter(|write| matches!(write, Write::AddToParent(_)));
        let additions = OperationCount { additions: added.count(), ..OperationCount::default() };
        self.program.operations_per_call() + additions
    }
}

impl Run {
    /// Returns the number of constants of a body.
    #[must_use]
    pub fn constants(&self) -> usize {
        self.table.first().map_or(0, Vec::len)
    }
}

impl Places {
    /// Returns the four places, in the order of the fields.
    #[must_use]
    pub fn all(&self) -> [u16; 4] {
        [self.own, self.parent, self.q, self.v]
    }
}
