//! A step with soft constraints as a program: statements that run once, and the iterations of a
//! solver as loops.
//!
//! ```text
//! statements                what no iteration changes
//! for each solver, at most once
//!     for at most 100 iterations
//!         call advance      a full step of Newton's method
//!         for at most 30 evaluations
//!             call search   an evaluation of the line search
//!     call solution         the accelerations and forces
//! statements                the state after the step
//! ```
//!
//! A robot with joint limits has two solvers, of which one runs: limits that do not act in a step
//! have no rows in the first one, so that fewer limbs depend on the iterate.
//!
//! All parts are one graph. A node belongs to the part whose inputs it depends on. A node of the
//! full step that only the solution needs, such as the acceleration of a limb that touches nothing,
//! runs with the solution.
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
use crate::graph::step::{SEARCH, SolverParts, StepGraph};
use crate::graph::{Graph, Id, Node};

/// The arrays of the loops: numbers that no iteration changes; the accelerations and balances of
/// the rows at the start of an iteration and at the end of its full step; the numbers of the
/// solver; the numbers of the last full step that the solution needs; the solution; for each
/// solver, the accelerations and balances where the next iteration starts.
const FRONT: usize = 0;
const START: usize = 1;
const FULL: usize = 2;
const SOLVER: usize = 3;
const AFTER: usize = 4;
const SOLUTION: usize = 5;
const NEXT: usize = 6;

/// The numbers of the solver: the scale of the next iteration, the number of iterations, the
/// residual, the end; the numbers of the search, of which the last is its end; the scale of this
/// iteration; for each solver, whether it is left out.
const SCALE: usize = 0;
const ITERATIONS: usize = 1;
const RESIDUAL: usize = 2;
const END: usize = 3;
const SEARCH_START: usize = 4;
const SEARCH_END: usize = SEARCH_START + SEARCH - 1;
const LAST_SCALE: usize = SEARCH_START + SEARCH;
const SKIP: usize = LAST_SCALE + 1;

/// The tables of the loops.
const ONCE: usize = 0;
const ITERATION: usize = 1;
const EVALUATION: usize = 2;

/// The part whose inputs a node depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Zone {
    /// None: the node is computed before the loops.
    Front,
    Advance,
    Search,
    /// The inputs of the solution, or the inputs of a full step whose results no iteration needs.
    Solution,
    Results,
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
    /// Returns the cut around one solver.
    fn new(step: &'a StepGraph, solver: &SolverParts) -> Self {
        let graph = &step.graph;
        let advance = graph.live_from(&graph.outputs[solver.advance.outputs.clone()]);
        let mut zones: Vec<Zone> = Vec::with_capacity(graph.nodes().len());
        for (i, node) in graph.nodes().iter().enumerate() {
            let zone = match *node {
                Node::Input(number) => [
                    (&solver.advance, Zone::Advance),
                    (&solver.search, Zone::Search),
                    (&solver.solution, Zone::Solution),
                    (&step.results, Zone::Results),
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

/// The steps of a solver, and its routines.
struct Solver {
    /// The index among the solvers.
    index: usize,
    /// The number of numbers in the array [`AFTER`].
    after: usize,
    steps: Vec<Step>,
    pieces: [Piece; 3],
}

impl Solver {
    /// Returns the solver with this index, and adds the nodes that it reads to `captured`.
    fn new(step: &StepGraph, index: usize, captured: &mut Captured) -> Self {
        let parts = &step.solvers[index];
        let cut = Cut::new(step, parts);
        let rows = parts.rows;
        let next = NEXT + index;
        let solver = |index: usize| Entry { array: SOLVER, index };

        // The solution, and the nodes of the last full step that it reads.
        let advance_outputs = cut.outputs(&parts.advance.outputs);
        let [full, rest] = split(&advance_outputs, 2 * rows);
        let [numbers, start] = split(rest, LAST_SCALE + 1);
        let ends = [numbers[RESIDUAL], numbers[ITERATIONS]];
        let outputs = [&cut.outputs(&parts.solution.outputs)[..], &ends].concat();
        let solution = cut.piece(&outputs, |zone| zone == Zone::Solution);
        let is_after =
            |lane: &Lane| cut.zones[lane.0 as usize] == Zone::Advance && !ends.contains(lane);
        let after: Vec<Lane> = solution.reads.iter().copied().filter(is_after).collect();
        let solution_reads = solution.reads.iter().map(|&lane| {
            let place = after.iter().position(|&other| other == lane);
            match (place, cut.input(&parts.solution.inputs, lane)) {
                (Some(place), _) => Read::Entry(AFTER, Place::fixed(place)),
                (None, Some(row)) => Read::Entry(next, Place::fixed(row)),
                (None, None) if lane == ends[0] => Read::Entry(SOLVER, Place::fixed(RESIDUAL)),
                (None, None) if lane == ends[1] => Read::Entry(SOLVER, Place::fixed(ITERATIONS)),
                (None, None) => captured.read(&step.graph, lane),
            }
        });
        let solution_call = Call {
            routine: 3 * index + 2,
            reads: solution_reads.collect(),
            writes: to(SOLUTION, outputs.len()).collect(),
        };

        let advance_inputs = parts.advance.inputs.clone();
        let outputs = [start, full, full, numbers, &after].concat();
        let advance = cut.piece(&outputs, |zone| zone == Zone::Advance);
        let advance_call = Call {
            routine: 3 * index,
            reads: (advance.reads.iter())
                .map(|&lane| match cut.input(&advance_inputs, lane) {
                    Some(k) if k < 2 * rows => Read::Entry(next, Place::fixed(k)),
                    Some(k) => Read::Entry(SOLVER, Place::fixed(SCALE + k - 2 * rows)),
                    None => captured.read(&step.graph, lane),
                })
                .collect(),
            writes: to(START, 2 * rows)
                .chain(to(FULL, 2 * rows))
                .chain(to(next, 2 * rows))
                .chain(to(SOLVER, LAST_SCALE + 1))
                .chain(to(AFTER, after.len()))
                .collect(),
        };

        let search = cut.piece(&cut.outputs(&parts.search.outputs), |zone| zone == Zone::Search);
        let search_call = Call {
            routine: 3 * index + 1,
            reads: (search.reads.iter())
                .map(|&lane| match cut.input(&parts.search.inputs, lane) {
                    Some(k) if k < 2 * rows => Read::Entry(START, Place::fixed(k)),
                    Some(k) if k < 4 * rows => Read::Entry(FULL, Place::fixed(k - 2 * rows)),
                    Some(k) if k < 4 * rows + SEARCH - 1 => {
                        Read::Entry(SOLVER, Place::fixed(SEARCH_START + k - 4 * rows))
                    }
                    Some(_) => Read::Entry(SOLVER, Place::fixed(LAST_SCALE)),
                    None => captured.read(&step.graph, lane),
                })
                .collect(),
            writes: to(next, 2 * rows)
                .chain((0..SEARCH).map(|k| Write {
                    array: SOLVER,
                    place: Place::fixed(SEARCH_START + k),
                    adds: false,
                }))
                .collect(),
        };

        let iterations = Step::Loop(Loop {
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
        });
        let solve = vec![iterations, Step::Call(solution_call)];
        let steps = match parts.skip {
            None => solve,
            Some(_) => {
                let end = Some(solver(SKIP + index));
                vec![Step::Loop(Loop { table: ONCE, reversed: false, end, steps: solve })]
            }
        };
        Self { index, after: after.len(), steps, pieces: [advance, search, solution] }
    }
}

/// Returns the destinations of numbers that replace the first entries of an array.
fn to(array: usize, count: usize) -> impl Iterator<Item = Write> {
    (0..count).map(move |index| Write { array, place: Place::fixed(index), adds: false })
}

impl Program {
    /// Returns the program of a step over `arguments` scalars. The results are the outputs of
    /// [`StepGraph::results`], the residual, and the number of iterations. `pass` rewrites the graph
    /// of each routine.
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
        let mut captured = Captured::default();
        let solvers: Vec<Solver> =
            (0..step.solvers.len()).map(|i| Solver::new(step, i, &mut captured)).collect();

        // The statements: results, then what is stored before the loops.
        let cut = Cut::new(step, &step.solvers[0]);
        let results = cut.outputs(&step.results.outputs);
        let first = step.solvers.iter().flat_map(|parts| cut.outputs(&parts.first.outputs));
        let skips = step.solvers.iter().filter_map(|parts| parts.skip);
        let skip_outputs = skips.flat_map(|output| cut.outputs(&(output..output + 1)));
        let stored: Vec<Lane> =
            captured.nodes.iter().copied().chain(first).chain(skip_outputs).collect();
        let is_main = |zone: Zone| zone == Zone::Front || zone == Zone::Results;
        let main = cut.piece(&[&results[..], &stored].concat(), is_main);
        let mut graph = Graph::default();
        let inputs: Vec<Id> = (main.reads.iter())
            .map(|&lane| match (cut.input(&step.results.inputs, lane), step.graph.node(lane.0)) {
                (Some(place), _) => graph.input(arguments + place),
                (None, Node::Input(number)) => graph.input(number as usize),
                (None, _) => unreachable!("what runs before the loops is inside"),
            })
            .collect();
        let outputs = graph.compose(&main.graph, &inputs);
        let (results, stored) = outputs.split_at(results.len());
        let given = step.results.inputs.len();
        let ends = graph.inputs(arguments + given..arguments + given + 2);
        let [one, minus_one] = [1.0, -1.0].map(|number| graph.constant(number));
        graph.outputs = [results, &ends, stored, &[one, minus_one]].concat();

        let rows = step.solvers.iter().map(|parts| parts.rows);
        let most_rows = rows.clone().max().unwrap_or(0);
        let after = solvers.iter().map(|solver| solver.after).max().unwrap_or(0);
        let numbers = SKIP + step.solvers.len();
        let lengths =
            [captured.nodes.len(), 2 * most_rows, 2 * most_rows, numbers, after, given + 2];
        let arrays = lengths.into_iter().chain(rows.clone().map(|rows| 2 * rows));
        let entries =
            |array: usize, count: usize| (0..count).map(move |index| Entry { array, index });
        let solver = |index: usize| Entry { array: SOLVER, index };
        let skipped = solvers.iter().filter(|solver| step.solvers[solver.index].skip.is_some());
        let form = LoopForm {
            stored: entries(FRONT, captured.nodes.len())
                .chain(rows.enumerate().flat_map(|(i, rows)| entries(NEXT + i, rows)))
                .chain(skipped.map(|choice| solver(SKIP + choice.index)))
                .chain([solver(SCALE), solver(END)])
                .collect(),
            loops: Loops {
                arrays: arrays.map(Array::flat).collect(),
                stored: Vec::new(),
                steps: solvers.iter().flat_map(|solver| solver.steps.clone()).collect(),
                results: entries(SOLUTION, given + 2).collect(),
            },
        };
        let mut program = Self::with_loops(&graph, &form, arguments, execution);
        program.tables = [1, MAX_ITERATIONS, MAX_SEARCH].map(Table::of_length).to_vec();
        program.routines = (solvers.into_iter())
            .flat_map(|solver| solver.pieces)
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
