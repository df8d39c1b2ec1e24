//! Recursions as loops over bodies: the short form of code, whose length does not depend on the
//! number of bodies.
//!
//! Each body has a record of numbers, and so has the world; all records are one array. A sweep runs
//! the routine of a body's kind for each body, in order or in reverse. The routine reads the body's
//! constants, its entries of the arguments, its own record, and in outward sweeps its parent's
//! record. In inward sweeps it adds numbers to its parent's record.

mod cut;
mod order;
mod slots;

use std::collections::BTreeSet;

pub use modyn_runtime::equations::dynamics::Sweep;

use super::{
    Array, Call, Execution, Loop, Loops, Operand, Operation, Place, Program, Read, Routine, Row,
    Source, Statement, Step, Table, Value, Write,
};
use crate::graph::Graph;
use crate::graph::bodies::BodyGraphs;
use cut::{BodyRead, BodyStep, BodyWrite, Kind, Number};
use order::runs;
use slots::Slots;

/// The arrays of a recursion: the records of all bodies, and the result.
const RECORDS: usize = 0;
const RESULT: usize = 1;

/// The columns of the tables: the row of a body's record, the row of its parent's record, the
/// body's first entry of q, and its first entry of the other joint vectors.
const OWN: usize = 0;
const PARENT: usize = 1;
const Q: usize = 2;
const V: usize = 3;

/// The lengths of the arguments of a recursion: q, two vectors of length `nv`, and the run-time
/// parameters.
#[derive(Clone, Copy, Debug)]
pub struct RecursionSizes {
    /// The length of q.
    pub nq: usize,
    /// The length of the other joint vectors and of the result.
    pub nv: usize,
    /// The number of run-time parameters.
    pub parameters: usize,
}

impl RecursionSizes {
    /// Returns the index of the first number of a joint vector among the arguments, or the index of
    /// the parameters.
    fn start(self, argument: usize) -> usize {
        if argument == 0 { 0 } else { self.nq + (argument - 1) * self.nv }
    }
}

impl Program {
    /// Returns the program of a recursion over bodies. `pass` rewrites the graph of each sweep.
    ///
    /// # Panics
    ///
    /// If the world computes something in a sweep, or the program is invalid, which no recursion of
    /// modyn is.
    #[must_use]
    pub fn over_bodies(
        graphs: &BodyGraphs,
        sizes: RecursionSizes,
        pass: fn(&Graph) -> Graph,
    ) -> Self {
        let kinds = Kind::all(graphs);
        let needed: BTreeSet<(usize, usize)> = cut::received(graphs);
        let (slots, record) = slots::slots(&kinds, graphs.sweeps, &needed);
        let runs = runs(graphs);
        let mut recursion =
            Self::without_statements(Execution::Scalar, sizes.start(3) + sizes.parameters);
        recursion.tables = runs.iter().map(|run| run.table()).collect();
        let mut steps = Vec::new();
        for (sweep, &(direction, _)) in graphs.sweeps.iter().enumerate() {
            let reversed = direction == Sweep::Inward;
            steps.extend(recursion.world(graphs, sweep, slots.first(), sizes));
            let calls: Vec<Call> = kinds
                .iter()
                .zip(&slots)
                .enumerate()
                .map(|(k, (kind, slots))| {
                    let is_shared = runs.iter().filter(|run| run.kind == k).count() > 1;
                    let slot = |number: &Number| {
                        slots.of(number).expect("a number of a record has a place")
                    };
                    recursion.body(kind.step(sweep, direction, slot, pass), is_shared, sizes)
                })
                .collect();
            let loops = runs.iter().enumerate().map(|(table, run)| {
                let steps = vec![Step::Call(calls[run.kind].clone())];
                Step::Loop(Loop { table, reversed, end: None, steps })
            });
            if reversed { steps.extend(loops.rev()) } else { steps.extend(loops) }
        }
        let results = (0..sizes.nv).map(|index| super::Entry { array: RESULT, index });
        let records = 1 + runs.iter().map(|run| run.bodies.len()).sum::<usize>();
        let loops = Loops {
            arrays: vec![Array { rows: records, columns: record }, Array::flat(sizes.nv)],
            stored: Vec::new(),
            steps,
            results: results.collect(),
        };
        recursion.statements.push(Statement {
            operation: Operation::Loops(loops),
            lanes: 1,
            used: vec![true; sizes.nv],
            last_use: 0,
            stores: Vec::new(),
        });
        let result = |place| Operand {
            source: Source::Result(Value { statement: 0, place }),
            negated: false,
            lanes: 1,
        };
        recursion.results = (0..sizes.nv).map(result).collect();
        recursion.finished().expect("a fault of modyn: please report it")
    }

    /// Adds the routine of the numbers that the world sends in a sweep, and returns its call;
    /// `None` if it sends none. The record begins with zeros.
    fn world(
        &mut self,
        graphs: &BodyGraphs,
        sweep: usize,
        slots: Option<&Slots>,
        sizes: RecursionSizes,
    ) -> Option<Step> {
        let mut graph = graphs.world[sweep].clone();
        let sent = graph.outputs.iter().enumerate().filter_map(|(k, &id)| {
            let is_there = sweep == 0 && graph.value(id) == Some(0.0);
            let slot = slots?.of(&Number::Exchanged(sweep, k)).filter(|_| !is_there)?;
            Some((id, Write { array: RECORDS, place: Place::fixed(slot), adds: false }))
        });
        let (outputs, writes): (Vec<_>, Vec<Write>) = sent.unzip();
        graph.outputs = outputs;
        let parameters = (0..sizes.parameters).map(|i| Place::fixed(sizes.start(3) + i));
        let program = Self::new(&graph, sizes.parameters, Execution::Scalar);
        if writes.is_empty() {
            return None;
        }
        self.routines.push(Routine { program, constants: 0, never_inline: false });
        let reads = parameters.map(Read::Argument).collect();
        Some(Step::Call(Call { routine: self.routines.len() - 1, reads, writes }))
    }

    /// Adds the routine of a kind's step, and returns its call in a loop.
    fn body(&mut self, step: BodyStep, is_shared: bool, sizes: RecursionSizes) -> Call {
        let BodyStep { program, constants, reads, writes } = step;
        let read = |read: &BodyRead| match *read {
            BodyRead::Vector(vector, entry) => {
                let column = if vector == 0 { Q } else { V };
                Read::Argument(Place::in_row(column, sizes.start(vector) + entry))
            }
            BodyRead::Parameter(i) => Read::Argument(Place::fixed(sizes.start(3) + i)),
            BodyRead::Own(slot) => Read::Entry(RECORDS, Place::in_row(OWN, slot)),
            BodyRead::Parent(slot) => Read::Entry(RECORDS, Place::in_row(PARENT, slot)),
        };
        let write = |write: &BodyWrite| {
            let (array, place, adds) = match *write {
                BodyWrite::Own(slot) => (RECORDS, Place::in_row(OWN, slot), false),
                BodyWrite::AddToParent(slot) => (RECORDS, Place::in_row(PARENT, slot), true),
                BodyWrite::Result(entry) => (RESULT, Place::in_row(V, entry), false),
            };
            Write { array, place, adds }
        };
        self.routines.push(Routine { program, constants, never_inline: is_shared });
        Call {
            routine: self.routines.len() - 1,
            reads: reads.iter().map(read).collect(),
            writes: writes.iter().map(write).collect(),
        }
    }
}

/// Bodies of one kind that follow each other.
struct Run {
    /// The index of their kind.
    kind: usize,
    bodies: Vec<PlacedBody>,
}

/// A body with the indices of its numbers.
struct PlacedBody {
    /// The body's constants.
    constants: Vec<f64>,
    /// The index of its record; 0 is the world's.
    record: usize,
    /// The index of its parent's record.
    parent: usize,
    /// The index of its first entry of q.
    q: usize,
    /// The index of its first entry of the other joint vectors.
    v: usize,
}

impl Run {
    /// Returns the table of the bodies.
    fn table(&self) -> Table {
        let row = |body: &PlacedBody| Row {
            constants: body.constants.clone(),
            places: vec![body.record, body.parent, body.q, body.v],
        };
        Table { rows: self.bodies.iter().map(row).collect() }
    }
}
