//! A step with soft constraints as a program: what runs once, then the iterations of the solver as
//! loops.
//!
//! ```text
//! statements            what no iteration changes
//! for at most 100 iterations
//!     call advance      a full step of Newton's method
//!     for at most 30 evaluations
//!         call search   an evaluation of the line search
//! statements            the state after the step
//! ```
//!
//! All parts are one graph. A node belongs to the part whose inputs it depends on. A node of the
//! full step that only the results need, such as the acceleration of a limb that touches nothing,
//! runs after the loops.
//!
//! All languages but CasADi print the loops; MATLAB runs them for all states together, and each
//! state leaves at its own end. Machine code has a function for each part
//! (`Program::around_loops`), and `modyn-jit/src/looped.rs` runs the loops.

use std::collections::BTreeMap;
use std::ops::Range;

use modyn_runtime::equations::soft_constraints::{MAX_ITERATIONS, MAX_SEARCH};

use super::{
    Array, Call, Entry, Execution, InvalidProgram, Loop, LoopForm, Loops, Place, Program, Read,
    Routine, Row, Step, Table, Write,
};
use crate::graph::{Graph, Id, Node};
use crate::trace::{SEARCH, StepGraph};

/// The arrays of the loops: numbers that no iteration changes; the accelerations and balances of
/// the rows at the start of an iteration, at the end of its full step, and where the next iteration
/// starts; the numbers of the solver; the numbers of the last full step that the results need.
const FRONT: usize = 0;
const START: usize = 1;
const FULL: usize = 2;
const NEXT: usize = 3;
const SOLVER: usize = 4;
const AFTER: usize = 5;

/// The numbers of the solver: the scale of the next iteration, the number of iterations, the
/// residual, the end; the numbers of the search, of which the last is its end; the scale of this
/// iteration.
const SCALE: usize = 0;
const ITERATIONS: usize = 1;
const RESIDUAL: usize = 2;
const END: usize = 3;
const SEARCH_START: usize = 4;
const SEARCH_END: usize = SEARCH_START + SEARCH - 1;
const LAST_SCALE: usize = SEARCH_START + SEARCH;

/// The tables of the loops, and the routines.
const ITERATION: usize = 0;
const EVALUATION: usize = 1;

/// The part whose inputs a node depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Zone {
    /// None: the node is computed before the loops.
    Front,
    Advance,
    Search,
    /// The inputs of the solution, or those of a full step whose results no iteration needs.
    Solution,
}

/// A lane of a node of the whole graph; lane 0 of a scalar.
type Lane = (Id, u8);

/// A part of a graph as a graph of its own.
struct Piece {
    graph: Graph,
    /// The lanes of the whole graph that are the inputs.
    reads: Vec<Lane>,
}

/// A graph that is cut into pieces.
struct Cut<'a> {
    step: &'a StepGraph,
    zones: Vec<Zone>,
}

impl<'a> Cut<'a> {
    fn new(step: &'a StepGraph) -> Self {
        let graph = &step.graph;
        let advance = graph.live_from(&graph.outputs[step.advance.outputs.clone()]);
        let mut zones: Vec<Zone> = Vec::with_capacity(graph.nodes().len());
        for (i, node) in graph.nodes().iter().enumerate() {
            let zone = match *node {
                Node::Input(number) => [
                    (&step.advance, Zone::Advance),
                    (&step.search, Zone::Search),
                    (&step.solution, Zone::Solution),
                ]
                .into_iter()
                .find(|(part, _)| part.inputs.contains(&(number as usize)))
                .map_or(Zone::Front, |(_, zone)| zone),
                node => {
                    let operands = node.operands().map(|operand| zones[operand as usize]);
                    match operands.max().unwrap_or(Zone::Front) {
                        Zone::Advance if !advance[i] => Zone::Solution,
                        zone => zone,
                    }
                }
            };
            zones.push(zone);
        }
        Self { step, zones }
    }

    /// Returns outputs of the whole graph, which are scalars.
    fn outputs(&self, range: &Range<usize>) -> Vec<Lane> {
        self.step.graph.outputs[range.clone()].iter().map(|&id| (id, 0)).collect()
    }

    /// Returns the piece with these outputs: nodes of which `is_inside` is false are its inputs,
    /// and so are inputs of parts, except that signs of such nodes are inside.
    fn piece(&self, outputs: &[Lane], is_inside: impl Fn(Zone) -> bool) -> Piece {
        let whole = &self.step.graph;
        let is_read = |id: Id| match whole.node(id) {
            Node::Input(_) => true,
            Node::Neg(_) => false,
            _ => !whole.is_constant(id) && !is_inside(self.zones[id as usize]),
        };
        let mut is_needed = vec![false; whole.nodes().len()];
        outputs.iter().for_each(|&(output, _)| is_needed[output as usize] = true);
        for (i, node) in whole.nodes().iter().enumerate().rev() {
            if is_needed[i] && !is_read(i as Id) {
                node.operands().for_each(|operand| is_needed[operand as usize] = true);
            }
        }
        let mut piece = Piece { graph: Graph::default(), reads: Vec::new() };
        let mut ids: Vec<Id> = vec![0; whole.nodes().len()];
        for (i, node) in whole.nodes().iter().enumerate().filter(|(i, _)| is_needed[*i]) {
            ids[i] = if is_read(i as Id) {
                let first = piece.reads.len();
                piece.reads.extend((0..whole.width(i as Id)).map(|lane| (i as Id, lane)));
                let inputs = piece.graph.inputs(first..piece.reads.len());
                piece.graph.pack(&inputs)
            } else {
                piece.graph.make(node.map(|operand| ids[operand as usize]))
            };
        }
        let lanes = outputs
            .iter()
            .map(|&(output, lane)| piece.graph.make(Node::ExtractLane(ids[output as usize], lane)));
        piece.graph.outputs = lanes.collect();
        piece
    }

    /// Returns the number of an input of a part, counted from the part's first one; `None` for
    /// other nodes.
    fn input(&self, inputs: &Range<usize>, lane: Lane) -> Option<usize> {
        match self.step.graph.node(lane.0) {
            Node::Input(number) if inputs.contains(&(number as usize)) => {
                Some(number as usize - inputs.start)
            }
            _ => None,
        }
    }
}

/// The entries of arrays for lanes that loops read.
#[derive(Default)]
struct Captured {
    nodes: Vec<Lane>,
    index: BTreeMap<Lane, usize>,
}

impl Captured {
    /// Returns the place of a node that runs before the loops, as a routine reads it.
    fn read(&mut self, graph: &Graph, lane: Lane) -> Read {
        if let Node::Input(number) = graph.node(lane.0) {
            return Read::Argument(Place::fixed(number as usize));
        }
        let index = *self.index.entry(lane).or_insert_with(|| {
            self.nodes.push(lane);
            self.nodes.len() - 1
        });
        Read::Entry(FRONT, Place::fixed(index))
    }
}

impl Program {
    /// Returns the program of a step over `arguments` scalars. The results are those of the
    /// solution, then the residual and the number of iterations. `pass` rewrites the graph of each
    /// routine.
    ///
    /// # Errors
    ///
    /// Returns the first violation of a rule.
    pub fn of_step(
        step: &StepGraph,
        arguments: usize,
        execution: Execution,
        pass: fn(Graph) -> Graph,
    ) -> Result<Self, InvalidProgram> {
        let cut = Cut::new(step);
        let rows = step.rows;
        let solver = |index: usize| Entry { array: SOLVER, index };
        let solution = cut.outputs(&step.solution.outputs);
        let is_main = |zone: Zone| zone == Zone::Front || zone == Zone::Solution;

        // The results of loops, in the order in which the program reads them.
        let is_argument = |lane: Lane| cut.zones[lane.0 as usize] == Zone::Front;
        let read = cut.piece(&solution, is_main).reads;
        let needed: Vec<Lane> = read.into_iter().filter(|&lane| !is_argument(lane)).collect();
        let is_after = |lane: Lane| cut.input(&step.solution.inputs, lane).is_none();
        let after: Vec<Lane> = needed.iter().copied().filter(|&lane| is_after(lane)).collect();

        let mut captured = Captured::default();
        let advance_inputs = step.advance.inputs.clone();
        let starts: Vec<Lane> = (advance_inputs.clone())
            .map(|number| (step.graph.find(Node::input(number)).expect("a traced input"), 0))
            .collect();
        let advance_outputs = cut.outputs(&step.advance.outputs);
        let [full, numbers] = split(&advance_outputs, 2 * rows);
        let start = &starts[..2 * rows];
        let last_scale = starts[2 * rows];
        let outputs = [start, full, full, numbers, &[last_scale], &after].concat();
        let advance = cut.piece(&outputs, |zone| zone == Zone::Advance);
        let to = |array: usize, count: usize| {
            (0..count).map(move |index| Write { array, place: Place::fixed(index), adds: false })
        };
        let advance_call = Call {
            routine: ITERATION,
            reads: (advance.reads.iter())
                .map(|&lane| match cut.input(&advance_inputs, lane) {
                    Some(k) if k < 2 * rows => Read::Entry(NEXT, Place::fixed(k)),
                    Some(k) => Read::Entry(SOLVER, Place::fixed(SCALE + k - 2 * rows)),
                    None => captured.read(&step.graph, lane),
                })
                .collect(),
            writes: to(START, 2 * rows)
                .chain(to(FULL, 2 * rows))
                .chain(to(NEXT, 2 * rows))
                .chain(to(SOLVER, LAST_SCALE + 1))
                .chain(to(AFTER, after.len()))
                .collect(),
        };

        let search = cut.piece(&cut.outputs(&step.search.outputs), |zone| zone == Zone::Search);
        let search_call = Call {
            routine: EVALUATION,
            reads: (search.reads.iter())
                .map(|&lane| match cut.input(&step.search.inputs, lane) {
                    Some(k) if k < 2 * rows => Read::Entry(START, Place::fixed(k)),
                    Some(k) if k < 4 * rows => Read::Entry(FULL, Place::fixed(k - 2 * rows)),
                    Some(k) if k < 4 * rows + SEARCH - 1 => {
                        Read::Entry(SOLVER, Place::fixed(SEARCH_START + k - 4 * rows))
                    }
                    Some(_) => Read::Entry(SOLVER, Place::fixed(LAST_SCALE)),
                    None => captured.read(&step.graph, lane),
                })
                .collect(),
            writes: to(NEXT, 2 * rows)
                .chain((0..SEARCH).map(|k| Write {
                    array: SOLVER,
                    place: Place::fixed(SEARCH_START + k),
                    adds: false,
                }))
                .collect(),
        };

        // The statements: results, then what is stored before the loops.
        let first = cut.outputs(&step.first.outputs);
        let main = cut.piece(&[&solution[..], &captured.nodes, &first].concat(), is_main);
        let results: Vec<Entry> = (needed.iter())
            .map(|&lane| match cut.input(&step.solution.inputs, lane) {
                Some(index) => Entry { array: NEXT, index },
                None => {
                    let index = after.iter().position(|&other| other == lane);
                    Entry { array: AFTER, index: index.expect("a node after the loops") }
                }
            })
            .chain([solver(RESIDUAL), solver(ITERATIONS)])
            .collect();
        let mut graph = Graph::default();
        let inputs: Vec<Id> = (main.reads.iter())
            .map(|&lane| {
                let place = needed.iter().position(|&other| other == lane);
                match (place, step.graph.node(lane.0)) {
                    (Some(place), _) => graph.input(arguments + place),
                    (None, Node::Input(number)) => graph.input(number as usize),
                    (None, _) => unreachable!("what runs before the loops is inside"),
                }
            })
            .collect();
        let outputs = graph.compose(&main.graph, &inputs);
        let (solved, stored) = outputs.split_at(solution.len());
        let ends = graph.inputs(arguments + needed.len()..arguments + results.len());
        let [one, minus_one] = [1.0, -1.0].map(|number| graph.constant(number));
        graph.outputs = [solved, &ends, stored, &[one, minus_one]].concat();
        let entries =
            |array: usize, count: usize| (0..count).map(move |index| Entry { array, index });
        let form = LoopForm {
            loops: Loops {
                arrays: [
                    captured.nodes.len(),
                    2 * rows,
                    2 * rows,
                    2 * rows,
                    LAST_SCALE + 1,
                    after.len(),
                ]
                .map(Array::flat)
                .to_vec(),
                stored: Vec::new(),
                steps: vec![Step::Loop(Loop {
                    table: ITERATION,
                    reversed: false,
                    end: Some(solver(END)),
                    steps: vec![
                        Step::Call(advance_call),
                        Step::Loop(Loop {
                            table: EVALUATION,
                            reversed: false,
                            end: Some(solver(SEARCH_END)),
                            steps: vec![Step::Call(search_call)],
                        }),
                    ],
                })],
                results,
            },
            stored: entries(FRONT, captured.nodes.len())
                .chain(entries(NEXT, rows))
                .chain([solver(SCALE), solver(END)])
                .collect(),
        };
        let mut program = Self::with_loops(&graph, &form, arguments, execution);
        program.tables = [MAX_ITERATIONS, MAX_SEARCH].map(Table::of_length).to_vec();
        program.routines = [advance, search]
            .into_iter()
            .map(|piece| {
                Ok(Routine {
                    program: Self::try_new(&pass(piece.graph), piece.reads.len(), execution)?,
                    constants: 0,
                    never_inline: false,
                })
            })
            .collect::<Result<_, _>>()?;
        program.finished()
    }
}

impl Table {
    /// Returns a table of empty rows, for a loop that runs so many times.
    fn of_length(rows: usize) -> Self {
        Self { rows: vec![Row::default(); rows] }
    }
}

fn split(lanes: &[Lane], middle: usize) -> [&[Lane]; 2] {
    let (first, rest) = lanes.split_at(middle);
    [first, rest]
}
