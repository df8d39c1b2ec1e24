//! The graph of a step with soft constraints, before it is cut into what runs once and what runs in
//! each iteration of the solver.

use modyn_runtime::Scalar;
use modyn_runtime::equations::actuation::{ActuationWorkspace, ActuatorInput};
use modyn_runtime::equations::brge::UduLayout;
use modyn_runtime::equations::dynamics::Elimination;
use modyn_runtime::equations::factorization::MergedUduLayout;
use modyn_runtime::equations::soft_constraints::{
    ActuatedForces, ActuatedInput, Advance, DampingMatrix, Iterate, JointParameters, Progress,
    Search, SoftModel, SoftMotion, StepConstraints, StepDrive, StepInput, StepProblem,
    StopParameters, has_closed_form, next_state, state_derivatives, state_derivatives_by_newton,
};
use modyn_runtime::equations::{TimeStepInput, Workspace};
use modyn_runtime::mechanism::{BodyTree, Mechanism, MergedMechanism};
use modyn_runtime::model::{Impedance, Model, Softness};
use modyn_runtime::{ContactSurface, StepSettings};

use super::limbs::TouchingPacking;
use super::{LimbPacking, Tracer};
use crate::graph::step::{Part, SEARCH, SolverParts, StepGraph};
use crate::graph::{Expr, Graph};

/// The solver of each robot with these constraints.
pub type EliminationOf<'a> = &'a dyn Fn(&SoftModel<f64>) -> Elimination;

/// The forces that drive a robot in a step.
#[derive(Clone, Copy)]
pub enum Drive<'a> {
    /// Joint forces.
    Forces,
    /// The actuators of a model, and applied joint forces.
    Actuators(&'a Model),
}

/// The form of the derivatives of a step.
#[derive(Clone, Copy)]
pub struct DerivativeForm<'a> {
    /// The layout of the factors of the mass matrix.
    pub layout: &'a UduLayout,
    /// The number of columns that are computed at a time, in the lanes of a pack.
    pub column_lanes: usize,
}

/// The arguments of a step under controls.
struct Controls<'a> {
    described: &'a Model,
    ctrl: Vec<Expr>,
    act: Vec<Expr>,
    applied: Vec<Expr>,
}

/// The arguments of a step.
struct StepArguments<'a> {
    q: Vec<Expr>,
    qd: Vec<Expr>,
    dt: Expr,
    /// The controls; `None` for a step under joint forces.
    controls: Option<Controls<'a>>,
    /// All joint forces.
    tau: Vec<Expr>,
    /// The velocity gains of actuators that act with the velocities after the step.
    dampers: DampingMatrix<Expr>,
    /// The activations after the step; none for a step under joint forces.
    next_act: Vec<Expr>,
    warm_start: Vec<Expr>,
    settings: Vec<Expr>,
}

impl StepArguments<'_> {
    /// Returns the derivatives of the state after a step with these accelerations of its solution,
    /// by columns.
    fn derivatives(
        &self,
        model: &Mechanism<Expr>,
        elimination: &Elimination,
        soft: &SoftModel<f64>,
        form: DerivativeForm<'_>,
        qdd: &[Expr],
    ) -> Vec<Expr> {
        let settings = settings_of(&self.settings);
        let soft = soft.map(Expr::from_f64);
        let model = &soft.mechanism(model);
        let constraints = StepConstraints { soft: &soft, settings: &settings };
        let input = StepInput { warm_start: qdd, ..self.input() };
        let drive = match &self.controls {
            None => StepDrive::Forces(&self.tau),
            Some(Controls { described, ctrl, act, applied }) => {
                let actuators = ActuatorInput { q: &self.q, qd: &self.qd, ctrl, act, dt: self.dt };
                let input = ActuatedInput { actuators, applied, warm_start: qdd };
                StepDrive::Actuators(described, input)
            }
        };
        let columns = match has_closed_form(model, &soft) {
            true => {
                let tree = &MergedMechanism::with_column_lanes(model.clone(), form.column_lanes);
                let layout = &MergedUduLayout::new(tree, form.layout.clone());
                let mut workspace = Workspace::new(tree);
                let problem =
                    StepProblem::new(tree, elimination, input, constraints, &mut workspace)
                        .damped_by(&self.dampers);
                state_derivatives(problem, constraints, layout, drive)
            }
            false => state_derivatives_by_newton(model, elimination, input, constraints, drive),
        };
        columns.concat()
    }

    fn input(&self) -> StepInput<'_, Expr> {
        let Self { q, qd, dt, tau, warm_start, .. } = self;
        StepInput { step: TimeStepInput { q, qd, tau, dt: *dt }, warm_start }
    }
}

impl<'a> Drive<'a> {
    /// Returns the number of arguments: q, qd, then tau and dt, or the controls, dt, the activations
    /// and the applied forces; the accelerations to start from, and the settings.
    fn count(self, mechanism: &Mechanism<f64>, soft: &SoftModel<f64>) -> usize {
        let Mechanism { nq, nv, .. } = mechanism;
        let surfaces = ContactSurface::<Expr>::COUNT * soft.contacts.len();
        let of_actuators = match self {
            Self::Forces => 0,
            Self::Actuators(model) => {
                let actuation = model.actuation();
                actuation.actuators.len() + actuation.states()
            }
        };
        nq + 3 * nv + 1 + of_actuators + StepSettings::<Expr>::COUNT + surfaces
    }

    /// Returns the arguments of a step of a robot.
    fn arguments(self, mechanism: &Mechanism<Expr>, numbers: &[Expr]) -> StepArguments<'a> {
        let Mechanism { nq, nv, .. } = *mechanism;
        let mut rest = numbers;
        let mut take = |count: usize| {
            let (taken, others) = rest.split_at(count);
            rest = others;
            taken.to_vec()
        };
        let [q, qd] = [nq, nv].map(&mut take);
        match self {
            Self::Forces => {
                let [tau, dt, warm_start] = [nv, 1, nv].map(take);
                StepArguments {
                    dt: dt[0],
                    controls: None,
                    dampers: DampingMatrix::zero(nv),
                    next_act: Vec::new(),
                    settings: rest.to_vec(),
                    q,
                    qd,
                    tau,
                    warm_start,
                }
            }
            Self::Actuators(described) => {
                let actuation = described.actuation();
                let activations = actuation.states();
                let controls = actuation.actuators.len();
                let [ctrl, dt, act, applied, warm_start] =
                    [controls, 1, activations, nv, nv].map(take);
                let actuators = ActuatorInput { q: &q, qd: &qd, ctrl: &ctrl, act: &act, dt: dt[0] };
                let input = ActuatedInput { actuators, applied: &applied, warm_start: &warm_start };
                let ActuatedForces { tau, dampers, act: next_act } =
                    input.forces(described, mechanism, &mut ActuationWorkspace::new(described));
                StepArguments {
                    dt: dt[0],
                    controls: Some(Controls { described, ctrl, act, applied }),
                    settings: rest.to_vec(),
                    q,
                    qd,
                    tau,
                    dampers,
                    next_act,
                    warm_start,
                }
            }
        }
    }
}

impl Tracer<'_> {
    /// Returns the parts of a step. Its `drive` decides its arguments. With `derivatives`, the
    /// derivatives of the state are the last results.
    #[must_use]
    pub fn step(
        &self,
        elimination: EliminationOf<'_>,
        soft: &SoftModel<f64>,
        drive: Drive<'_>,
        derivatives: Option<DerivativeForm<'_>>,
    ) -> StepGraph {
        let count = drive.count(self.model, soft);
        let next_input = count + self.parameters.len();
        let mut parts = Parts { next_input, ..Parts::default() };
        let mut results = None;
        let graph = self.trace_groups([count], |model, [numbers]| {
            let arguments = drive.arguments(model, &numbers);
            let StepArguments { dampers, settings, .. } = &arguments;
            let given = Given { input: arguments.input(), dampers, settings };
            match self.limbs {
                None => parts.on_scalars(model, elimination, soft, given),
                Some(limbs) => {
                    let robot = PackedRobot { model: self.model, whole: model, limbs };
                    robot.solvers(&elimination(soft), soft, given, &mut parts);
                }
            }
            let derive = |qdd: &[Expr]| {
                derivatives.map_or_else(Vec::new, |form| {
                    arguments.derivatives(model, &elimination(soft), soft, form, qdd)
                })
            };
            results = Some(parts.results(model, soft, &arguments, derive));
            std::mem::take(&mut parts.outputs)
        });
        StepGraph { graph, solvers: parts.solvers, results: results.expect("the step is traced") }
    }
}

impl Tracer<'_> {
    /// Returns the results of a step whose accelerations are known, up to one step of Newton's
    /// method: its derivatives are the derivatives of the step. Arguments: the arguments of a step,
    /// with the accelerations of its solution to start from.
    #[must_use]
    pub fn refined_step(
        &self,
        elimination: &Elimination,
        soft: &SoftModel<f64>,
        drive: Drive<'_>,
    ) -> Graph {
        let count = drive.count(self.model, soft);
        self.trace_groups([count], |model, [numbers]| {
            let arguments = drive.arguments(model, &numbers);
            let input = arguments.input();
            let settings = settings_of(&arguments.settings);
            let soft = soft.map(Expr::from_f64);
            let model = &soft.mechanism(model);
            let mut workspace = Workspace::new(model);
            let constraints = StepConstraints { soft: &soft, settings: &settings };
            let problem = StepProblem::new(model, elimination, input, constraints, &mut workspace);
            let motion = problem.damped_by(&arguments.dampers).refined();
            let ends = [Expr::zero(), Expr::zero()];
            let [next_q, next_qd] =
                next_state(model, &soft, input.step, [&motion.qdd, &motion.damped]);
            let state = [&next_q, &next_qd, &arguments.next_act, &motion.qdd].map(Vec::as_slice);
            [&state[..], &[motion.forces.as_flattened(), &ends]].concat().concat()
        })
    }
}

/// A robot with merged limbs.
struct PackedRobot<'a> {
    model: &'a Mechanism<f64>,
    /// The robot without merged limbs, on expressions.
    whole: &'a Mechanism<Expr>,
    limbs: &'a LimbPacking,
}

impl PackedRobot<'_> {
    /// Traces the solvers. Their solutions are in the robot's own order.
    fn solvers(
        &self,
        elimination: &Elimination,
        soft: &SoftModel<f64>,
        given: Given<'_>,
        parts: &mut Parts,
    ) {
        let Self { model, whole, limbs } = *self;
        let Elimination::Recursive(partition) = elimination else {
            unreachable!("robots with mimic joints have no merged limbs")
        };
        let nv = model.nv;
        let packing = limbs.touching(soft);
        let merged = limbs.merged(&soft.mechanism(model), whole.gravity);
        let elimination = Elimination::Recursive(limbs.partition(partition));
        let StepInput { step, warm_start } = given.input;
        let [qd, tau, warm_start] = [step.qd, step.tau, warm_start].map(|x| limbs.vector(x));
        let step = TimeStepInput { q: &limbs.coordinates(step.q), qd: &qd, tau: &tau, dt: step.dt };
        let input = StepInput { step, warm_start: &warm_start };
        let (common, surfaces) = given.settings.split_at(StepSettings::<Expr>::COUNT);
        let settings = settings_of(&[common, &packing.surfaces(surfaces)].concat());
        let merged_soft = self.soft_model(soft, &packing);
        let dampers = self.dampers(given.dampers);
        let mut workspace = Workspace::new(&merged);
        for soft in merged_soft.solvers() {
            let constraints = StepConstraints { soft: &soft, settings: &settings };
            let problem =
                StepProblem::new(&merged, &elimination, input, constraints, &mut workspace)
                    .damped_by(&dampers);
            let joints = problem.joints_of_rows().map(|joints| {
                let [dof] = joints[..] else { unreachable!("no row couples merged limbs") };
                let (lanes, _) = limbs.velocities().nth(dof).expect("a joint of the merged robot");
                lanes.iter().map(Option::is_some).collect()
            });
            let rows: Vec<Vec<bool>> = packing.rows().chain(joints).collect();
            parts.solver(problem, &rows, |motion| SoftMotion {
                qdd: limbs.unpack_vector(&motion.qdd, nv),
                damped: limbs.unpack_vector(&motion.damped, nv),
                forces: packing.unpack(motion.forces.as_flattened(), 3).as_chunks().0.to_vec(),
            });
        }
    }

    /// Returns dampers in lanes. Dampers that couple joints have no merged limbs.
    fn dampers(&self, dampers: &DampingMatrix<Expr>) -> DampingMatrix<Expr> {
        let numbers: Vec<Expr> =
            dampers.diagonal.iter().map(|entry| entry.unwrap_or_else(Expr::zero)).collect();
        let entries = self.limbs.vector(&numbers).into_iter().zip(self.limbs.velocities());
        let acts = |lanes: &[Option<usize>]| {
            lanes.iter().flatten().any(|&dof| dampers.diagonal[dof].is_some())
        };
        let diagonal = entries.map(|(entry, (lanes, _))| acts(lanes).then_some(entry)).collect();
        DampingMatrix { diagonal, coupled: Vec::new() }
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
            let numbers = |get: &dyn Fn(&StopParameters<f64>) -> f64, missing: f64| {
                pack(each.iter().map(|joint| joint.map_or(missing, |x| get(&x.stops))).collect())
            };
            let some = |get: &dyn Fn(&StopParameters<f64>) -> Option<f64>, missing: f64| {
                let is_there = each.iter().flatten().any(|joint| get(&joint.stops).is_some());
                is_there.then(|| numbers(&|stops| get(stops).unwrap_or(missing), missing))
            };
            let softness = |get: &dyn Fn(&StopParameters<f64>) -> Softness<f64>| {
                let number = |part: &dyn Fn(&Softness<f64>) -> f64| {
                    numbers(&|stops| part(&get(stops)), part(&get(&first.stops)))
                };
                Softness {
                    reference: [0, 1].map(|k| number(&|softness| softness.reference[k])),
                    impedance: Impedance {
                        least: number(&|softness| softness.impedance.least),
                        most: number(&|softness| softness.impedance.most),
                        width: number(&|softness| softness.impedance.width),
                        midpoint: number(&|softness| softness.impedance.midpoint),
                        power: get(&first.stops).impedance.power,
                    },
                }
            };
            let stops = StopParameters {
                range: [
                    some(&|stops| stops.range[0], -OUT_OF_REACH),
                    some(&|stops| stops.range[1], OUT_OF_REACH),
                ],
                narrow: each.iter().flatten().any(|joint| joint.stops.narrow),
                margin: numbers(&|stops| stops.margin, 0.0),
                mobility: numbers(&|stops| stops.mobility, first.stops.mobility),
                limit: softness(&|stops| stops.limit),
                dry_friction: some(&|stops| stops.dry_friction, 0.0),
                friction: softness(&|stops| stops.friction),
            };
            Some(JointParameters { coordinate, stops })
        });
        SoftModel {
            cone: soft.cone,
            integrator: soft.integrator,
            weight: Expr::from_f64(soft.weight),
            contacts: packing.parameters(),
            // The merged robot has the damping of its limbs.
            damping: Vec::new(),
            joints: joints.collect(),
            // Robots with loops, tendons or couplings have no merged limbs.
            loops: Vec::new(),
            tendons: Vec::new(),
            couplings: Vec::new(),
            coupled_dampers: Vec::new(),
            // They are moved after the solver, when the limbs are apart.
            free_bodies: Vec::new(),
        }
    }
}

/// The arguments of a step.
#[derive(Clone, Copy)]
struct Given<'a> {
    input: StepInput<'a, Expr>,
    dampers: &'a DampingMatrix<Expr>,
    settings: &'a [Expr],
}

/// The parts of a step while they are traced.
#[derive(Default)]
struct Parts {
    next_input: usize,
    outputs: Vec<Expr>,
    solvers: Vec<SolverParts>,
}

impl Parts {
    /// Traces the solvers of a robot whose limbs are not merged.
    fn on_scalars(
        &mut self,
        model: &Mechanism<Expr>,
        elimination: EliminationOf<'_>,
        soft: &SoftModel<f64>,
        given: Given<'_>,
    ) {
        let Given { input, dampers, settings } = given;
        let settings = settings_of(settings);
        let model = &soft.map(Expr::from_f64).mechanism(model);
        let mut workspace = Workspace::new(model);
        for soft in soft.solvers() {
            let elimination = elimination(&soft);
            let soft = soft.map(Expr::from_f64);
            let constraints = StepConstraints { soft: &soft, settings: &settings };
            let problem = StepProblem::new(model, &elimination, input, constraints, &mut workspace)
                .damped_by(dampers);
            let rows = vec![vec![true]; problem.rows()];
            self.solver(problem, &rows, |motion| motion);
        }
    }

    /// Traces the solver of a problem. `rows` says of each row which lanes it has; `solution`
    /// returns the solution in the robot's own order.
    fn solver<T: BodyTree<Expr>>(
        &mut self,
        mut problem: StepProblem<'_, Expr, T>,
        rows: &[Vec<bool>],
        solution: impl FnOnce(SoftMotion<Expr>) -> SoftMotion<Expr>,
    ) {
        let first_rows = unpacked(&problem.first().accelerations, rows);
        let first = self.part(self.next_input, first_rows);

        let begin = self.next_input;
        let start = self.iterate(rows);
        let [scale, iterations] = self.inputs();
        let progress_before = Progress { scale, iterations, ..Progress::first() };
        let Advance { end, progress, search } = problem.advance(&start, &progress_before);
        let Progress { scale, iterations, residual, end: ends } = progress;
        let numbers = [
            unpacked(&end.accelerations, rows),
            unpacked(&end.balances, rows),
            vec![scale, iterations, residual, ends],
            search_numbers(&search).to_vec(),
            vec![progress_before.scale],
            unpacked(&start.accelerations, rows),
            unpacked(&start.balances, rows),
        ];
        let advance = self.part(begin, numbers.concat());

        let begin = self.next_input;
        let [start, end] = [self.iterate(rows), self.iterate(rows)];
        let [low_place, low_slope, high_place, high_slope, least, scale] = self.inputs();
        let search = Search {
            low: [low_place, low_slope],
            high: [high_place, high_slope],
            least,
            end: Expr::zero(),
        };
        let (point, search) = problem.search([&start, &end], &search, scale);
        let numbers = [
            unpacked(&point.accelerations, rows),
            unpacked(&point.balances, rows),
            search_numbers(&search).to_vec(),
        ];
        let search = self.part(begin, numbers.concat());

        let begin = self.next_input;
        let end =
            Iterate { accelerations: self.packed(rows), balances: vec![Expr::zero(); rows.len()] };
        let SoftMotion { qdd, damped, forces } = solution(problem.motion(&end));
        let solution = self.part(begin, [&qdd, &damped, forces.as_flattened()].concat());

        let mut skip = None;
        if let Some(unlimited) = self.solvers.last_mut() {
            let [one, zero] = [Expr::one(), Expr::zero()];
            let acts = (zero - problem.limits()).select_nonnegative(zero - one, one);
            unlimited.skip = Some(self.outputs.len());
            skip = Some(self.outputs.len() + 1);
            self.outputs.extend([acts, zero - acts]);
        }
        let rows = rows.iter().flatten().filter(|is_there| **is_there).count();
        self.solvers.push(SolverParts { rows, skip, first, advance, search, solution });
    }

    /// Traces the results of a step but the residual and the number of iterations.
    fn results(
        &mut self,
        model: &Mechanism<Expr>,
        soft: &SoftModel<f64>,
        arguments: &StepArguments<'_>,
        derivatives: impl FnOnce(&[Expr]) -> Vec<Expr>,
    ) -> Part {
        let begin = self.next_input;
        let solution = &self.solvers.last().expect("a step has a solver").solution;
        let numbers: Vec<Expr> = solution.outputs.clone().map(|_| self.input()).collect();
        let (qdd, rest) = numbers.split_at(model.nv);
        let (damped, forces) = rest.split_at(model.nv);
        let model = &soft.map(Expr::from_f64).mechanism(model);
        let [next_q, next_qd] = next_state(model, soft, arguments.input().step, [qdd, damped]);
        let derivatives = derivatives(qdd);
        let state = [&*next_q, &next_qd, &arguments.next_act, qdd];
        self.part(begin, [&state[..], &[forces, &derivatives]].concat().concat())
    }

    /// Returns the part of the inputs since `begin` with these outputs.
    fn part(&mut self, begin: usize, numbers: Vec<Expr>) -> Part {
        let start = self.outputs.len();
        self.outputs.extend(numbers);
        Part { inputs: begin..self.next_input, outputs: start..self.outputs.len() }
    }

    fn input(&mut self) -> Expr {
        self.next_input += 1;
        Expr::input(self.next_input - 1)
    }

    fn inputs<const N: usize>(&mut self) -> [Expr; N] {
        core::array::from_fn(|_| self.input())
    }

    /// Returns a number for each row, which is an input in each lane that is there.
    fn packed(&mut self, rows: &[Vec<bool>]) -> Vec<Expr> {
        let mut number = |is_there: &bool| if *is_there { self.input() } else { Expr::zero() };
        let row =
            |lanes: &Vec<bool>| Expr::pack(&lanes.iter().map(&mut number).collect::<Vec<_>>());
        rows.iter().map(row).collect()
    }

    fn iterate(&mut self, rows: &[Vec<bool>]) -> Iterate<Expr> {
        Iterate { accelerations: self.packed(rows), balances: self.packed(rows) }
    }
}

/// Returns the numbers of the rows in each lane that is there.
fn unpacked(numbers: &[Expr], rows: &[Vec<bool>]) -> Vec<Expr> {
    let lanes = |(number, lanes): (&Expr, &Vec<bool>)| -> Vec<Expr> {
        let there = lanes.iter().enumerate().filter(|(_, is_there)| **is_there);
        there.map(|(lane, _)| number.extract_lane(lane)).collect()
    };
    numbers.iter().zip(rows).flat_map(lanes).collect()
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
