//! Equal limbs by one routine, with a table of constants for each limb.
//!
//! A graph with packed limbs is split into stages: scalars, then limbs that need them, then scalars
//! that need the limbs, and so on. Each stage becomes a routine over its inputs. In a limb's
//! routine a value has one lane instead of all lanes, and a loop calls the routine once for each
//! lane.

use std::collections::{BTreeMap, BTreeSet};

use super::validate::COPIED;
use super::{
    Array, Call, Entry, Execution, InvalidProgram, Loop, Loops, Operand, Operation, Place, Program,
    Read, Routine, Row, Source, Statement, Step, Stored, Table, Value, Write,
};
use crate::graph::{Graph, Id, Node};

impl Program {
    /// Returns the program, on scalars only, of a graph with packed limbs over `arguments` scalars.
    ///
    /// # Errors
    ///
    /// Returns the first violation of a rule.
    pub fn repeated(graph: &Graph, arguments: usize) -> Result<Self, InvalidProgram> {
        if mixes_widths(graph) {
            return Err(InvalidProgram { statement: None, rule: COPIED });
        }
        let stages = stages(graph);
        let mut program = Self::without_statements(Execution::Scalar, arguments);
        for stage in &stages {
            let loops = program.stage(graph, &stages, stage)?;
            program.statements.push(Statement {
                used: vec![true; loops.results.len()],
                operation: Operation::Loops(loops),
                lanes: 1,
                last_use: 0,
                stores: Vec::new(),
            });
        }
        program.results = graph.outputs.iter().map(|&id| operand(graph, &stages, id, 0)).collect();
        program.finished()
    }

    /// Adds the routine and the table of a stage, and returns the loop that computes the stage's
    /// outputs, lane by lane.
    fn stage(
        &mut self,
        graph: &Graph,
        stages: &[Stage],
        stage: &Stage,
    ) -> Result<Loops, InvalidProgram> {
        /// The arrays: values of each lane, values that all lanes share, and results.
        const OWN: usize = 0;
        const COMMON: usize = 1;
        const RESULTS: usize = 2;
        let [constants, values, common] = stage.kinds();
        let [own_count, outputs] = [values.len(), stage.outputs.len()];
        let value = |id: &Id, lane| operand(graph, stages, *id, lane);
        let row = |lane: u8| {
            let number = |&id: &Id| graph.value(graph.packed_at(id, lane));
            let repetition = usize::from(lane);
            Row {
                constants: constants.iter().map(|id| number(id).expect("a constant")).collect(),
                places: vec![repetition],
            }
        };
        let own_values =
            (0..stage.calls).flat_map(|lane| values.iter().map(move |id| value(id, lane)));
        let stored =
            |array: usize| move |(index, value)| Stored { entry: Entry { array, index }, value };
        let reads_own = (0..own_count).map(|i| Read::Entry(OWN, Place::in_row(0, i)));
        let reads_common = (0..common.len()).map(|i| Read::Entry(COMMON, Place::fixed(i)));
        let writes =
            (0..outputs).map(|i| Write { array: RESULTS, place: Place::in_row(0, i), adds: false });
        let call = Call {
            routine: self.routines.len(),
            reads: reads_own.chain(reads_common).collect(),
            writes: writes.collect(),
        };
        self.routines.push(Routine {
            program: Self::try_new(&stage.graph, stage.inputs.len(), Execution::Scalar)?,
            constants: constants.len(),
            never_inline: false,
        });
        self.tables.push(Table { rows: (0..stage.calls).map(row).collect() });
        let lanes = usize::from(stage.calls);
        let table = self.tables.len() - 1;
        Ok(Loops {
            arrays: vec![
                Array { rows: lanes, columns: own_count },
                Array::flat(common.len()),
                Array { rows: lanes, columns: outputs },
            ],
            stored: own_values
                .enumerate()
                .map(stored(OWN))
                .chain(common.iter().map(|id| value(id, 0)).enumerate().map(stored(COMMON)))
                .collect(),
            steps: vec![Step::Loop(Loop {
                table,
                reversed: false,
                end: None,
                steps: vec![Step::Call(call)],
            })],
            results: (0..lanes * outputs).map(|index| Entry { array: RESULTS, index }).collect(),
        })
    }
}

/// Returns whether an operation has packs of several widths as operands. In a program on scalars
/// their lanes could not be told from each other.
fn mixes_widths(graph: &Graph) -> bool {
    let nodes = (0..).zip(graph.nodes()).zip(graph.live());
    nodes.filter(|&(_, live)| live).any(|((id, node), _)| match node {
        Node::Pack(..) | Node::ExtractLane(..) => false,
        node => node.operands().any(|a| ![1, graph.width(id)].contains(&graph.width(a))),
    })
}

/// An input of a stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Input {
    /// Constants, one for each lane.
    Table(Id),
    /// A value that differs from lane to lane.
    Own(Id),
    /// A value that is the same for all lanes.
    Common(Id),
}

impl Input {
    fn id(self) -> Id {
        let (Self::Table(id) | Self::Own(id) | Self::Common(id)) = self;
        id
    }
}

/// Nodes that one routine computes.
struct Stage {
    /// The number of lanes of the nodes; 1 for scalars.
    width: u8,
    /// The number of calls: the lanes that are used.
    calls: u8,
    inputs: Vec<Input>,
    /// The nodes that other stages need.
    outputs: Vec<Id>,
    graph: Graph,
}

/// Returns one lane of a value, as a call reads it.
fn operand(graph: &Graph, stages: &[Stage], id: Id, lane: u8) -> Operand {
    let scalar = |source| Operand { source, negated: false, lanes: 1 };
    match graph.node(id) {
        Node::Constant(bits) => scalar(Source::Constant(f64::from_bits(bits))),
        Node::Input(number) => scalar(Source::Argument(number as usize)),
        Node::ExtractLane(vector, lane) => operand(graph, stages, vector, lane),
        Node::Pack(..) => operand(graph, stages, graph.packed_at(id, lane), 0),
        _ => {
            let place = stages.iter().enumerate().find_map(|(statement, stage)| {
                let place = stage.outputs.iter().position(|&output| output == id)?;
                let call = if stage.width == 1 { 0 } else { usize::from(lane) };
                Some(Value { statement, place: call * stage.outputs.len() + place })
            });
            scalar(Source::Result(
                place.expect("a value that other chunks read is an output of its chunk"),
            ))
        }
    }
}

/// Returns whether a node needs no operation: arguments, constants, packs and lanes of these.
fn is_known(node: Node) -> bool {
    matches!(node, Node::Constant(_) | Node::Input(_) | Node::Pack(..) | Node::ExtractLane(..))
}

/// Returns the stages of a graph, each after the stages that it needs.
fn stages(graph: &Graph) -> Vec<Stage> {
    let nodes = graph.nodes();
    let live = graph.live();
    let mut members: BTreeMap<(usize, u8), Vec<Id>> = BTreeMap::new();
    let mut class = vec![None; nodes.len()];
    for (i, level) in levels(graph).into_iter().enumerate() {
        if live[i] && !is_known(nodes[i]) {
            let id = Id::try_from(i).expect("an index of a node");
            class[i] = Some((level, graph.width(id)));
            members.entry((level, graph.width(id))).or_default().push(id);
        }
    }
    // The nodes that are needed outside of their stage.
    let mut needed = vec![false; nodes.len()];
    for (i, node) in nodes.iter().enumerate().filter(|(i, _)| live[*i]) {
        for operand in node.operands().map(|id| id as usize) {
            needed[operand] |= class[operand].is_some() && class[operand] != class[i];
        }
    }
    graph.outputs.iter().for_each(|&id| needed[id as usize] = true);
    let lanes = |width: u8| {
        let lanes = nodes.iter().zip(&live).filter_map(|(node, live)| match *node {
            Node::ExtractLane(pack, lane) if *live && graph.width(pack) == width => Some(lane + 1),
            _ => None,
        });
        lanes.max().unwrap_or(1)
    };
    let mut stages: Vec<Stage> = Vec::new();
    for ((_, width), ids) in &members {
        let outputs = ids.iter().copied().filter(|&id| needed[id as usize]).collect();
        stages.push(Stage::new(graph, *width, lanes(*width), ids, outputs));
    }
    stages
}

/// Returns, for each node, how often the path to it changes between scalars and lanes: even for
/// scalars, odd for lanes.
fn levels(graph: &Graph) -> Vec<usize> {
    let mut levels: Vec<usize> = Vec::with_capacity(graph.nodes().len());
    for (i, node) in graph.nodes().iter().enumerate() {
        let wide = graph.width(i as Id) > 1;
        let below = node.operands().map(|operand| {
            let change = (graph.width(operand) > 1) != wide;
            levels[operand as usize] + usize::from(change)
        });
        levels.push(below.max().unwrap_or(0));
    }
    levels
}

impl Stage {
    fn new(graph: &Graph, width: u8, calls: u8, ids: &[Id], outputs: Vec<Id>) -> Self {
        let members: BTreeSet<Id> = ids.iter().copied().collect();
        let input = |id: Id| match graph.node(id) {
            _ if members.contains(&id) => None,
            Node::Constant(_) => None,
            _ if graph.width(id) == 1 => Some(Input::Common(id)),
            _ if graph.is_constant(id) => Some(Input::Table(id)),
            _ => Some(Input::Own(id)),
        };
        let operands = ids.iter().flat_map(|&id| graph.node(id).operands());
        let distinct: BTreeSet<Input> = operands.filter_map(input).collect();
        let all: Vec<Input> = distinct.into_iter().collect();
        let mut made = Graph::default();
        let mut ids_made: BTreeMap<Id, Id> = BTreeMap::new();
        for (place, input) in all.iter().enumerate() {
            ids_made.insert(input.id(), made.input(place));
        }
        for &id in ids {
            for operand in graph.node(id).operands() {
                if let Node::Constant(_) = graph.node(operand) {
                    let constant = made.make(graph.node(operand));
                    ids_made.insert(operand, constant);
                }
            }
            let node = graph.node(id).map(|operand| ids_made[&operand]);
            let same = made.make(node);
            ids_made.insert(id, same);
        }
        made.outputs = outputs.iter().map(|id| ids_made[id]).collect();
        Self { width, calls, inputs: all, outputs, graph: made }
    }

    /// Returns the inputs of the stage: constants, values of each lane, values that are the same
    /// for all lanes.
    fn kinds(&self) -> [Vec<Id>; 3] {
        [Input::Table, Input::Own, Input::Common].map(|kind: fn(Id) -> Input| {
            let ids = self.inputs.iter().map(|input| input.id());
            ids.filter(|&id| self.inputs.contains(&kind(id))).collect()
        })
    }
}
