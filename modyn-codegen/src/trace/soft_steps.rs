//! The graph of a step with soft constraints, before it is cut into what runs once and what runs in
//! each iteration of the solver.

use std::ops::Range;

use modyn_runtime::Scalar;
use modyn_runtime::equations::Workspace;
use modyn_runtime::equations::dynamics::Elimination;
use modyn_runtime::equations::soft_constraints::{
    Advance, Iterate, JointParameters, Progress, Search, SoftModel, SoftMotion, StepInput,
    StepProblem, moved,
};
use modyn_runtime::mechanism::{BodyTree, Mechanism};
use modyn_runtime::model::{Impedance, Softness};
use modyn_runtime::{ContactSurface, StepSettings};

use super::limbs::TouchingPacking;
use super::{LimbPacking, Tracer};
use crate::graph::{Expr, Graph};

/// The parts of a step, as one graph. Its inputs after the arguments belong to one part each.
pub struct StepGraph {
    /// The graph.
    pub graph: Graph,
    /// The number of rows of the constraints.
    pub rows: usize,
    /// The full step of an iteration. Inputs: the accelerations and balances of the rows, the
    /// scale, the number of iterations. Outputs: accelerations and balances; scale, iterations,
    /// residual, end; the search.
    pub advance: Part,
    /// An evaluation of a line search. Inputs: accelerations and balances of the start and of the
    /// full step, the search without its end, the scale. Outputs: accelerations and balances; the
    /// search.
    pub search: Part,
    /// The accelerations of the rows before the first iteration. They have no inputs.
    pub first: Part,
    /// The state and forces after the step. Inputs: the accelerations of the rows.
    pub solution: Part,
}

/// The inputs and outputs of a part of a graph.
pub struct Part {
    /// The numbers of the inputs.
    pub inputs: Range<usize>,
    /// The indices of the outputs.
    pub outputs: Range<usize>,
}

/// The numbers of a search: both ends, the slope at which it ends, and its end.
pub const SEARCH: usize = 6;

impl Tracer<'_> {
    /// Returns the parts of a step. Arguments: q, qd, tau, dt, the accelerations to start from, the
    /// settings.
    #[must_use]
    pub fn step(&self, elimination: &Elimination, soft: &SoftModel<f64>) -> StepGraph {
        let nq = self.model.nq;
        let nv = self.model.nv;
        let surfaces = ContactSurface::<Expr>::COUNT * soft.contacts.len();
        let settings = StepSettings::<Expr>::COUNT + surfaces;
        let first_input = nq + 3 * nv + 1 + settings + self.parameters.len();
        let mut step = None;
        let groups = [nq, nv, nv, 1, nv, settings];
        let graph = self.trace_groups(groups, |model, groups| {
            let (parts, outputs) = match self.limbs {
                None => on_scalars(model, elimination, soft, groups, first_input),
                Some(limbs) => {
                    let robot = PackedRobot { model: self.model, whole: model, limbs };
                    robot.step(elimination, soft, groups, first_input)
                }
            };
            step = Some(parts);
            outputs
        });
        let Parts { rows, parts: [first, advance, search, solution] } =
            step.expect("the parts are traced");
        StepGraph { graph, rows, advance, search, first, solution }
    }
}

impl Tracer<'_> {
    /// Returns the results of a step whose accelerations are known, up to one step of Newton's
    /// method: its derivatives are the derivatives of the step. Arguments: the arguments of a step,
    /// with the accelerations of its solution to start from.
    #[must_use]
    pub fn refined_step(&self, elimination: &Elimination, soft: &SoftModel<f64>) -> Graph {
        let nq = self.model.nq;
        let nv = self.model.nv;
        let surfaces = ContactSurface::<Expr>::COUNT * soft.contacts.len();
        let groups = [nq, nv, nv, 1, nv, StepSettings::<Expr>::COUNT + surfaces];
        self.trace_groups(groups, |model, [q, qd, tau, dt, warm_start, settings]| {
            let input = StepInput { q: &q, qd: &qd, tau: &tau, warm_start: &warm_start, dt: dt[0] };
            let settings = settings_of(&settings);
            let soft = soft.map(Expr::from_f64);
            let model = &soft.mechanism(model);
            let mut workspace = Workspace::new(model);
            let problem = (&soft, &settings);
            let motion =
                StepProblem::new(model, elimination, input, problem, &mut workspace).refined();
            let ends = [Expr::zero(), Expr::zero()];
            [results(model, input, motion), ends.to_vec()].concat()
        })
    }
}

/// The parts of a step: the first accelerations, the full step, the search, the solution.
struct Parts {
    rows: usize,
    parts: [Part; 4],
}

/// The arguments of a step: q, qd, tau, dt, the accelerations to start from, the settings.
type Arguments = [Vec<Expr>; 6];

/// Traces a step of a robot whose limbs are not merged.
fn on_scalars(
    model: &Mechanism<Expr>,
    elimination: &Elimination,
    soft: &SoftModel<f64>,
    [q, qd, tau, dt, warm_start, settings]: Arguments,
    first_input: usize,
) -> (Parts, Vec<Expr>) {
    let input = StepInput { q: &q, qd: &qd, tau: &tau, warm_start: &warm_start, dt: dt[0] };
    let settings = settings_of(&settings);
    let soft = soft.map(Expr::from_f64);
    let model = &soft.mechanism(model);
    let mut workspace = Workspace::new(model);
    let problem = StepProblem::new(model, elimination, input, (&soft, &settings), &mut workspace);
    let rows = vec![vec![true]; problem.rows()];
    parts(problem, &rows, first_input, |motion| results(model, input, motion))
}

/// Returns the results of a step but the residual and the number of iterations.
fn results(
    model: &Mechanism<Expr>,
    input: StepInput<'_, Expr>,
    motion: SoftMotion<Expr>,
) -> Vec<Expr> {
    let [next_q, next_qd] = moved(model, input, &motion.damped);
    [next_q, next_qd, motion.qdd, motion.forces.concat()].concat()
}

/// A robot with merged limbs.
struct PackedRobot<'a> {
    model: &'a Mechanism<f64>,
    /// The robot without merged limbs, on expressions.
    whole: &'a Mechanism<Expr>,
    limbs: &'a LimbPacking,
}

impl PackedRobot<'_> {
    /// Traces a step. The last parts are in the robot's own order.
    fn step(
        &self,
        elimination: &Elimination,
        soft: &SoftModel<f64>,
        [q, qd, tau, dt, warm_start, settings]: Arguments,
        first_input: usize,
    ) -> (Parts, Vec<Expr>) {
        let Self { model, whole, limbs } = *self;
        let Elimination::Recursive(partition) = elimination else {
            unreachable!("robots with mimic joints have no merged limbs")
        };
        let nv = model.nv;
        let packing = limbs.touching(soft);
        let merged = limbs.merged(&soft.mechanism(model), whole.gravity);
        let elimination = Elimination::Recursive(limbs.partition(partition));
        let given = StepInput { q: &q, qd: &qd, tau: &tau, warm_start: &warm_start, dt: dt[0] };
        let [packed_qd, packed_tau, packed_warm] =
            [&qd, &tau, &warm_start].map(|vector| limbs.vector(vector));
        let input = StepInput {
            q: &limbs.coordinates(&q),
            qd: &packed_qd,
            tau: &packed_tau,
            warm_start: &packed_warm,
            dt: dt[0],
        };
        let (common, surfaces) = settings.split_at(StepSettings::<Expr>::COUNT);
        let surfaces = packing.surfaces(surfaces);
        let settings = settings_of(&[common, &surfaces].concat());
        let merged_soft = self.soft_model(soft, &packing);
        let mut workspace = Workspace::new(&merged);
        let soft = (&merged_soft, &settings);
        let problem = StepProblem::new(&merged, &elimination, input, soft, &mut workspace);
        let joints = problem.joints_of_rows().map(|dof| {
            let (lanes, _) = limbs.velocities().nth(dof).expect("a joint of the merged robot");
            lanes.iter().map(Option::is_some).collect()
        });
        let rows: Vec<Vec<bool>> = packing.rows().chain(joints).collect();
        parts(problem, &rows, first_input, |motion| {
            let qdd = limbs.unpack_vector(&motion.qdd, nv);
            let damped = limbs.unpack_vector(&motion.damped, nv);
            let [next_q, next_qd] = moved(whole, given, &damped);
            let forces = packing.unpack(&motion.forces.concat(), 3);
            [next_q, next_qd, qdd, forces].concat()
        })
    }

    /// Returns what the soft constraints have beside the settings, in lanes. A limb without a joint's limit has a
    /// limit that is out of reach.
    fn soft_model(&self, soft: &SoftModel<f64>, packing: &TouchingPacking<'_>) -> SoftModel<Expr> {
        const OUT_OF_REACH: f64 = 1e10;
        let pack = |numbers: Vec<f64>| {
            Expr::pack(&numbers.into_iter().map(Expr::from_f64).collect::<Vec<_>>())
        };
        let joints = self.limbs.velocities().map(|(lanes, _)| {
            let each: Vec<Option<&JointParameters<f64>>> =
                lanes.iter().map(|dof| soft.joints[(*dof)?].as_ref()).collect();
            let first = each.iter().flatten().next()?;
            let coordinate = self.limbs.coordinate(first.coordinate);
            let numbers = |get: &dyn Fn(&JointParameters<f64>) -> f64, missing: f64| {
                pack(each.iter().map(|joint| joint.map_or(missing, get)).collect())
            };
            let some = |get: &dyn Fn(&JointParameters<f64>) -> Option<f64>, missing: f64| {
                let is_there = each.iter().flatten().any(|joint| get(joint).is_some());
                is_there.then(|| numbers(&|joint| get(joint).unwrap_or(missing), missing))
            };
            let softness = |get: &dyn Fn(&JointParameters<f64>) -> Softness<f64>| {
                let number = |part: &dyn Fn(&Softness<f64>) -> f64| {
                    numbers(&|joint| part(&get(joint)), part(&get(first)))
                };
                Softness {
                    reference: [0, 1].map(|k| number(&|softness| softness.reference[k])),
                    impedance: Impedance {
                        least: number(&|softness| softness.impedance.least),
                        most: number(&|softness| softness.impedance.most),
                        width: number(&|softness| softness.impedance.width),
                        midpoint: number(&|softness| softness.impedance.midpoint),
                        power: get(first).impedance.power,
                    },
                }
            };
            Some(JointParameters {
                coordinate,
                range: [
                    some(&|joint| joint.range[0], -OUT_OF_REACH),
                    some(&|joint| joint.range[1], OUT_OF_REACH),
                ],
                narrow: each.iter().flatten().any(|joint| joint.narrow),
                margin: numbers(&|joint| joint.margin, 0.0),
                mobility: numbers(&|joint| joint.mobility, first.mobility),
                limit: softness(&|joint| joint.limit),
                dry_friction: some(&|joint| joint.dry_friction, 0.0),
                friction: softness(&|joint| joint.friction),
            })
        });
        SoftModel {
            cone: soft.cone,
            weight: Expr::from_f64(soft.weight),
            contacts: packing.parameters(),
            // The merged robot has the damping of its limbs.
            damping: Vec::new(),
            joints: joints.collect(),
        }
    }
}

/// Traces the parts of a problem. `rows` says of each row which lanes it has; `solution` returns the outputs of the last part.
fn parts<T: BodyTree<Expr>>(
    mut problem: StepProblem<'_, Expr, T>,
    rows: &[Vec<bool>],
    first_input: usize,
    solution: impl FnOnce(SoftMotion<Expr>) -> Vec<Expr>,
) -> (Parts, Vec<Expr>) {
    let mut inputs = Inputs { next: first_input, rows };
    let mut outputs = Vec::new();
    let mut part = |inputs: Range<usize>, numbers: Vec<Expr>| {
        let start = outputs.len();
        outputs.extend(numbers);
        Part { inputs, outputs: start..outputs.len() }
    };
    let first = problem.first();
    let first = part(0..0, inputs.unpacked(&first.accelerations));

    let begin = inputs.next;
    let start = inputs.iterate();
    let [scale, iterations] = inputs.array();
    let progress = Progress { scale, iterations, ..Progress::first() };
    let Advance { end, progress, search } = problem.advance(&start, &progress);
    let Progress { scale, iterations, residual, end: ends } = progress;
    let numbers = [
        inputs.unpacked(&end.accelerations),
        inputs.unpacked(&end.balances),
        vec![scale, iterations, residual, ends],
        search_numbers(&search).to_vec(),
    ];
    let advance = part(begin..inputs.next, numbers.concat());

    let begin = inputs.next;
    let [start, end] = [inputs.iterate(), inputs.iterate()];
    let [low_place, low_slope, high_place, high_slope, least, scale] = inputs.array();
    let search = Search {
        low: [low_place, low_slope],
        high: [high_place, high_slope],
        least,
        end: Expr::zero(),
    };
    let (point, search) = problem.search([&start, &end], &search, scale);
    let numbers = [
        inputs.unpacked(&point.accelerations),
        inputs.unpacked(&point.balances),
        search_numbers(&search).to_vec(),
    ];
    let search = part(begin..inputs.next, numbers.concat());

    let begin = inputs.next;
    let end = Iterate { accelerations: inputs.packed(), balances: vec![Expr::zero(); rows.len()] };
    let motion = problem.motion(&end);
    let solution = part(begin..inputs.next, solution(motion));
    let count = rows.iter().flatten().filter(|is_there| **is_there).count();
    (Parts { rows: count, parts: [first, advance, search, solution] }, outputs)
}

/// The next input of a part, and the lanes of each row.
struct Inputs<'a> {
    next: usize,
    rows: &'a [Vec<bool>],
}

impl Inputs<'_> {
    fn array<const N: usize>(&mut self) -> [Expr; N] {
        self.next += N;
        core::array::from_fn(|k| Expr::input(self.next - N + k))
    }

    /// Returns a number for each row, which is an input in each lane that is there.
    fn packed(&mut self) -> Vec<Expr> {
        let Self { next, rows } = self;
        let mut number = |is_there: &bool| {
            if !is_there {
                return Expr::zero();
            }
            *next += 1;
            Expr::input(*next - 1)
        };
        let row =
            |lanes: &Vec<bool>| Expr::pack(&lanes.iter().map(&mut number).collect::<Vec<_>>());
        rows.iter().map(row).collect()
    }

    /// Returns the numbers of the rows in the order of [`packed`](Self::packed).
    fn unpacked(&self, numbers: &[Expr]) -> Vec<Expr> {
        let lanes = |(number, lanes): (&Expr, &Vec<bool>)| -> Vec<Expr> {
            let there = lanes.iter().enumerate().filter(|(_, is_there)| **is_there);
            there.map(|(lane, _)| number.extract_lane(lane)).collect()
        };
        numbers.iter().zip(self.rows).flat_map(lanes).collect()
    }

    fn iterate(&mut self) -> Iterate<Expr> {
        Iterate { accelerations: self.packed(), balances: self.packed() }
    }
}

/// Returns the numbers of a search.
fn search_numbers(search: &Search<Expr>) -> [Expr; SEARCH] {
    let Search { low: [low, low_slope], high: [high, high_slope], least, end } = *search;
    [low, low_slope, high, high_slope, least, end]
}

/// Returns the settings of a step.
fn settings_of(numbers: &[Expr]) -> StepSettings<Expr, Vec<ContactSurface<Expr>>> {
    let (settings, surfaces) = numbers.split_first_chunk().expect("the settings are counted");
    let surfaces = surfaces.as_chunks().0.iter();
    let contacts = surfaces.map(|surface| ContactSurface::from_numbers(*surface)).collect();
    StepSettings::from_numbers(*settings, contacts)
}
