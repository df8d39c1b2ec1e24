//! The cut of a body's equations: one graph for each sweep, and the values that a body keeps from
//! one sweep to a later one.
//!
//! A value is computed in the first sweep in which its operands are known, and kept in the body's
//! record. Negations, and single operations on arguments and constants, are computed again where
//! they are needed.

use std::collections::{BTreeMap, BTreeSet};

use modyn_runtime::equations::dynamics::Sweep;

use crate::graph::bodies::{BodyGraphs, BodyKind};
use crate::graph::{Graph, Id, Node};
use crate::program::{Execution, Program, argument_of};

/// The program of a body in a sweep. Its arguments are the body's constants, then the numbers that
/// it reads.
pub(super) struct BodyStep {
    pub program: Program,
    /// The number of constants.
    pub constants: usize,
    /// The numbers that it reads.
    pub reads: Vec<BodyRead>,
    /// The place of each of its results.
    pub writes: Vec<BodyWrite>,
}

/// A number that a body reads in a sweep.
#[derive(Clone, Copy)]
pub(super) enum BodyRead {
    /// An entry of a joint vector (first index): the body's entry with this index.
    Vector(usize, usize),
    /// A run-time parameter.
    Parameter(usize),
    /// A number of the body's record.
    Own(usize),
    /// A number of the parent's record.
    Parent(usize),
}

/// The place of a result of a body in a sweep.
#[derive(Clone, Copy)]
pub(super) enum BodyWrite {
    /// A number of the body's record.
    Own(usize),
    /// A number of the parent's record, to which it is added.
    AddToParent(usize),
    /// The body's entry of the result with this index.
    Result(usize),
}

/// The equations of a kind of bodies, cut into sweeps.
pub(super) struct Kind {
    parts: Vec<Part>,
    /// For each value that is kept, the sweep that computes it and the last sweep that reads it.
    pub kept: BTreeMap<Id, (usize, usize)>,
}

/// The equations of one sweep. The inputs of the graph are the constants, then the numbers that it
/// reads.
struct Part {
    graph: Graph,
    constants: usize,
    reads: Vec<Number>,
    writes: Vec<Number>,
}

/// A number that is an input or an output of a sweep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Number {
    /// An entry of a joint vector: the vector, and the index among the body's entries.
    Vector(usize, usize),
    /// A run-time parameter.
    Parameter(usize),
    /// A number that passes between a body and its parent in a sweep: the sweep, and the index
    /// among its numbers.
    Exchanged(usize, usize),
    /// A value that the body keeps.
    Kept(Id),
    /// An entry of the result.
    Result(usize),
    /// A constant of the body.
    Constant(usize),
}

/// The arguments that the graphs of all kinds have.
#[derive(Clone, Copy)]
struct Arguments {
    /// The sweeps of the recursion, and the numbers that bodies have in them.
    sweeps: &'static [(Sweep, usize)],
    /// The number of run-time parameters.
    parameters: usize,
}

impl Arguments {
    fn of(graphs: &BodyGraphs) -> Self {
        Self { sweeps: graphs.sweeps, parameters: graphs.parameters }
    }
}

/// Returns the number that input `i` of a kind's graph is.
fn number_of(kind: &BodyKind, arguments: Arguments, input: usize) -> Number {
    let [nq, nv] = kind.entries;
    let exchanged = arguments.sweeps.iter().map(|(_, length)| *length);
    let lengths = [nq, nv, nv, arguments.parameters].into_iter().chain(exchanged);
    match argument_of(input, lengths) {
        Ok((vector @ 0..3, entry)) => Number::Vector(vector, entry),
        Ok((3, parameter)) => Number::Parameter(parameter),
        Ok((group, k)) => Number::Exchanged(group - 4, k),
        Err(column) => Number::Constant(column),
    }
}

/// Returns the numbers that some body reads when they pass between bodies: the sweep, and the index
/// among its numbers.
pub(super) fn received(graphs: &BodyGraphs) -> BTreeSet<(usize, usize)> {
    let arguments = Arguments::of(graphs);
    graphs.kinds.iter().flat_map(|kind| received_by(kind, arguments)).collect()
}

/// Returns the numbers that bodies of this kind read when they pass between bodies.
fn received_by(kind: &BodyKind, arguments: Arguments) -> BTreeSet<(usize, usize)> {
    let live = kind.graph.live();
    let nodes = kind.graph.nodes().iter().zip(live).filter(|(_, live)| *live);
    let exchanged = nodes.filter_map(|(node, _)| match node {
        Node::Input(input) => match number_of(kind, arguments, *input as usize) {
            Number::Exchanged(sweep, k) => Some((sweep, k)),
            _ => None,
        },
        _ => None,
    });
    exchanged.collect()
}

impl Kind {
    /// Returns the equations of all kinds, cut.
    pub fn all(graphs: &BodyGraphs) -> Vec<Self> {
        let needed = received(graphs);
        let arguments = Arguments::of(graphs);
        graphs.kinds.iter().map(|kind| Self::new(kind, arguments, &needed)).collect()
    }

    /// Returns the equations of a kind, cut. `needed` are the numbers between bodies that some body
    /// reads.
    fn new(kind: &BodyKind, arguments: Arguments, needed: &BTreeSet<(usize, usize)>) -> Self {
        let Arguments { sweeps, .. } = arguments;
        let cut = Cut::new(kind, arguments);
        let mut outputs: Vec<Vec<(Number, Id)>> = vec![Vec::new(); sweeps.len()];
        let mut ids = kind.graph.outputs.iter().copied();
        for (sweep, count) in kind.kept.iter().enumerate() {
            for (k, id) in ids.by_ref().take(*count).enumerate() {
                if needed.contains(&(sweep, k)) {
                    outputs[sweep - 1].push((Number::Exchanged(sweep, k), id));
                }
            }
        }
        for (sweep, count) in kind.sent.iter().enumerate() {
            for (k, id) in ids.by_ref().take(*count).enumerate() {
                let adds_nothing =
                    sweeps[sweep].0 == Sweep::Inward && kind.graph.value(id) == Some(0.0);
                if needed.contains(&(sweep, k)) && !adds_nothing {
                    outputs[sweep].push((Number::Exchanged(sweep, k), id));
                }
            }
        }
        for (k, id) in ids.enumerate() {
            outputs[cut.levels[id as usize]].push((Number::Result(k), id));
        }
        let mut kept: BTreeMap<Id, (usize, usize)> = BTreeMap::new();
        let mut parts = Vec::new();
        for sweep in (0..sweeps.len()).rev() {
            let in_this = kept.iter().filter(|(_, (computed, _))| *computed == sweep);
            outputs[sweep].extend(in_this.map(|(&id, _)| (Number::Kept(id), id)));
            let part = cut.part(sweep, &outputs[sweep]);
            for read in &part.reads {
                if let Number::Kept(id) = *read {
                    kept.entry(id).or_insert((cut.levels[id as usize], sweep));
                }
            }
            parts.push(part);
        }
        parts.reverse();
        Self { parts, kept }
    }

    /// Returns the program of a sweep in this direction, after `pass`; `slot` is the place of a
    /// number in the record.
    pub fn step(
        &self,
        sweep: usize,
        direction: Sweep,
        slot: impl Fn(&Number) -> usize,
        pass: fn(&Graph) -> Graph,
    ) -> BodyStep {
        let Part { graph, constants, reads, writes } = &self.parts[sweep];
        let inward = direction == Sweep::Inward;
        let read = |number: &Number| match *number {
            Number::Vector(vector, entry) => BodyRead::Vector(vector, entry),
            Number::Parameter(parameter) => BodyRead::Parameter(parameter),
            Number::Exchanged(..) if !inward => BodyRead::Parent(slot(number)),
            _ => BodyRead::Own(slot(number)),
        };
        let write = |number: &Number| match *number {
            Number::Result(entry) => BodyWrite::Result(entry),
            Number::Exchanged(to, _) if inward && to == sweep => {
                BodyWrite::AddToParent(slot(number))
            }
            _ => BodyWrite::Own(slot(number)),
        };
        BodyStep {
            program: Program::new(&pass(graph), constants + reads.len(), Execution::Scalar),
            constants: *constants,
            reads: reads.iter().map(read).collect(),
            writes: writes.iter().map(write).collect(),
        }
    }
}

/// A kind's graph with the sweep of each node.
struct Cut<'a> {
    kind: &'a BodyKind,
    arguments: Arguments,
    /// For each node, the first sweep in which its operands are known.
    levels: Vec<usize>,
    /// For each node, whether each sweep that needs it computes it.
    is_repeated: Vec<bool>,
}

impl<'a> Cut<'a> {
    fn new(kind: &'a BodyKind, arguments: Arguments) -> Self {
        let graph = &kind.graph;
        let mut levels = Vec::new();
        let mut is_repeated = Vec::new();
        // Whether a node is an argument or a constant.
        let mut is_given: Vec<bool> = Vec::new();
        for node in graph.nodes() {
            let number = match node {
                Node::Input(input) => Some(number_of(kind, arguments, *input as usize)),
                _ => None,
            };
            let level = match number {
                Some(Number::Exchanged(sweep, _)) => sweep,
                _ => node.operands().map(|id| levels[id as usize]).max().unwrap_or(0),
            };
            let given = match number {
                Some(number) => !matches!(number, Number::Exchanged(..)),
                None => matches!(node, Node::Constant(_)),
            };
            let is_cheap = matches!(node, Node::Add(..) | Node::Sub(..) | Node::Mul(..));
            is_repeated.push(
                given
                    || matches!(node, Node::Neg(_))
                    || is_cheap && node.operands().all(|id| is_given[id as usize]),
            );
            levels.push(level);
            is_given.push(given);
        }
        Self { kind, arguments, levels, is_repeated }
    }

    /// Returns the equations of a sweep with these outputs.
    fn part(&self, sweep: usize, outputs: &[(Number, Id)]) -> Part {
        let nodes = self.kind.graph.nodes();
        let is_computed = |id: usize| self.is_repeated[id] || self.levels[id] == sweep;
        let mut needed = vec![false; nodes.len()];
        outputs.iter().for_each(|(_, id)| needed[*id as usize] = true);
        for (id, node) in nodes.iter().enumerate().rev() {
            if needed[id] && is_computed(id) {
                node.operands().for_each(|operand| needed[operand as usize] = true);
            }
        }
        let constants = self.kind.table[0].len();
        let mut graph = Graph::default();
        let mut reads = Vec::new();
        let mut ids: Vec<Id> = vec![0; nodes.len()];
        for (id, node) in nodes.iter().enumerate().filter(|(id, _)| needed[*id]) {
            let number = match node {
                _ if !is_computed(id) => Number::Kept(id as Id),
                Node::Input(input) => number_of(self.kind, self.arguments, *input as usize),
                _ => {
                    ids[id] = graph.make(node.map(|operand| ids[operand as usize]));
                    continue;
                }
            };
            ids[id] = match number {
                Number::Constant(column) => graph.input(column),
                number => {
                    reads.push(number);
                    graph.input(constants + reads.len() - 1)
                }
            };
        }
        graph.outputs = outputs.iter().map(|(_, id)| ids[*id as usize]).collect();
        Part {
            graph,
            constants,
            reads,
            writes: outputs.iter().map(|(number, _)| *number).collect(),
        }
    }
}
