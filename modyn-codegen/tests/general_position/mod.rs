//! Closed loops in general position: mechanisms rotated at random and scaled, interpreted and compiled to programs, in double
//! and single precision. They are compared with the aligned mechanism, and with a dense solution by independent means
//! (`reference.rs`).

pub mod mechanisms;
mod reference;

use std::cell::Cell;

use mechanisms::{Mechanism, Random, all, lengths, rotated};
use modyn_codegen::passes::optimize;
use modyn_codegen::program::{Execution, Program};
use modyn_codegen::trace::Tracer;
use modyn_runtime::equations::brge::UduLayout;
use modyn_runtime::equations::constraints::{ConstrainedOutputs, ProjectionOutputs};
use modyn_runtime::equations::{ForwardInput, State};
use modyn_runtime::joint::JointType;
use modyn_runtime::model::{
    Inertial, Joint, Link, LoopConstraint, LoopConstraintEnd, LoopConstraintKind, Model,
    ModuleTree, MovingLink,
};
use modyn_runtime::spatial::{Pose, Twist, Wrench};
use modyn_runtime::{ConstrainedDerivatives, ConstraintSettings, Interpreter, Scalar};
use nalgebra::{Matrix3, Vector3};
use reference::{Reference, Solution};

const ROTATIONS: usize = 20 * SIZES.len();
const SIZES: [f64; 3] = [1.0, 0.02, 50.0];
const ALPHA: f64 = 3.0;
const BETA: f64 = 5.0;

/// A scalar for the computation of mechanisms.
trait Precision: Scalar {
    fn to_f64(self) -> f64;
    fn settings() -> ConstraintSettings<Self>;
}

impl Precision for f64 {
    fn to_f64(self) -> f64 {
        self
    }
    fn settings() -> ConstraintSettings<f64> {
        ConstraintSettings { alpha: ALPHA, beta: BETA, ..ConstraintSettings::<f64>::DEFAULT }
    }
}

impl Precision for f32 {
    fn to_f64(self) -> f64 {
        self.into()
    }
    fn settings() -> ConstraintSettings<f32> {
        let (alpha, beta) = (f32::from_f64(ALPHA), f32::from_f64(BETA));
        ConstraintSettings { alpha, beta, ..ConstraintSettings::<f32>::DEFAULT }
    }
}

fn numbers<S: Precision>(settings: &ConstraintSettings<S>) -> [S; 4] {
    [settings.alpha, settings.beta, settings.tolerance, settings.rounding]
}

fn cast<S: Scalar>(x: &[f64]) -> Vec<S> {
    x.iter().map(|&x| S::from_f64(x)).collect()
}

fn six<S: Precision>(x: [S; 6]) -> [f64; 6] {
    x.map(S::to_f64)
}

/// Returns the interpreter's solution.
fn interpreted<S: Precision>(model: &Model, [q, qd, tau]: &[Vec<f64>; 3]) -> Solution {
    let (n, loops) = (model.nv(), model.loop_constraints().len());
    let mut interpreter = Interpreter::<S>::new(model.clone());
    let mut qdd = vec![S::zero(); n];
    let (mut wrenches, mut residuals) = (vec![Wrench::zero(); loops], vec![Twist::zero(); loops]);
    let into =
        ConstrainedOutputs { qdd: &mut qdd, wrenches: &mut wrenches, residuals: &mut residuals };
    let (q, qd, tau) = (cast(q), cast(qd), cast(tau));
    let solve = Interpreter::constrained_forward_dynamics;
    let rank = solve(
        &mut interpreter,
        ForwardInput { q: &q, qd: &qd, tau: &tau },
        &[],
        &S::settings(),
        into,
    )
    .expect("fits");
    Solution {
        qdd: qdd.into_iter().map(S::to_f64).collect(),
        wrenches: wrenches.iter().map(|w| six(w.components())).collect(),
        residuals: residuals.iter().map(|r| six(r.components())).collect(),
        rank: count(rank.to_f64()),
    }
}

#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
fn count(rank: f64) -> usize {
    assert!(rank >= 0.0 && rank.fract() == 0.0, "{rank}");
    rank as usize
}

/// The programs of forward dynamics and projection that back ends print.
struct Compiled {
    forward_dynamics: Program,
    projection: Program,
    n: usize,
    loops: usize,
}

impl Compiled {
    fn new(model: &Model) -> Self {
        let mechanism = modyn_runtime::mechanism::Mechanism::new(model);
        let tracer = Tracer::new(&mechanism);
        let layout = UduLayout::new(&mechanism, &ModuleTree::chains(model));
        let settings = numbers(&<f64 as Precision>::settings()).len();
        let (state, forces) = (model.nq() + model.nv(), model.nv());
        let program =
            |graph, arguments| Program::new(&optimize(graph), arguments, Execution::Scalar);
        Self {
            forward_dynamics: program(
                tracer.constrained_forward_dynamics(&layout),
                state + forces + settings,
            ),
            projection: program(tracer.project_constraints(&layout), state + settings),
            n: model.nv(),
            loops: model.loop_constraints().len(),
        }
    }

    fn solve<S: Precision>(&self, state: &[Vec<f64>; 3]) -> Solution {
        let inputs = [cast::<S>(&state.concat()), numbers(&S::settings()).to_vec()].concat();
        let found = self.forward_dynamics.evaluate(&inputs);
        let found: Vec<f64> = found.into_iter().map(S::to_f64).collect();
        let (qdd, rest) = found.split_at(self.n);
        let (wrenches, rest) = rest.split_at(6 * self.loops);
        let (residuals, rank) = rest.split_at(6 * self.loops);
        let sixes = |all: &[f64]| {
            all.chunks(6).map(|six| std::array::from_fn(|k| six[k])).collect::<Vec<[f64; 6]>>()
        };
        Solution {
            qdd: qdd.to_vec(),
            wrenches: sixes(wrenches),
            residuals: sixes(residuals),
            rank: count(rank[0]),
        }
    }
}

/// Returns the solution of the aligned mechanism from the solution of the rotated and scaled one.
fn aligned(solution: &Solution, r: &Matrix3<f64>, scale: f64, lengths: &[bool]) -> Solution {
    let back = |six: &[f64; 6], linear: f64, angular: f64| {
        let to_link = |at: usize| r.transpose() * Vector3::new(six[at], six[at + 1], six[at + 2]);
        let first = to_link(0) / linear;
        let second = to_link(3) / angular;
        [first.x, first.y, first.z, second.x, second.y, second.z]
    };
    let qdd = solution.qdd.iter().zip(lengths);
    Solution {
        qdd: qdd.map(|(x, &length)| if length { x / scale } else { *x }).collect(),
        wrenches: solution.wrenches.iter().map(|w| back(w, scale, scale * scale)).collect(),
        residuals: solution.residuals.iter().map(|r| back(r, scale, 1.0)).collect(),
        rank: solution.rank,
    }
}

/// Returns the sum of the differences of two solutions: of accelerations and of wrenches relative to the largest of their
/// kind, of residuals relative to the largest acceleration or residual. (Where no rows contradict each other, residuals are
/// rounding errors of accelerations.)
fn difference(found: &Solution, expected: &Solution) -> f64 {
    assert_eq!(found.rank, expected.rank);
    let largest =
        |least: f64, numbers: &[f64]| numbers.iter().fold(least, |size, x| size.max(x.abs()));
    let against = |found: &[f64], expected: &[f64], least: f64| {
        assert_eq!(found.len(), expected.len());
        let size = largest(least, expected);
        let pairs = found.iter().zip(expected);
        // A sum propagates NaN.
        pairs.map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt() / size
    };
    let accelerations = largest(1.0, &expected.qdd);
    against(&found.qdd, &expected.qdd, 1.0)
        + against(&found.wrenches.concat(), &expected.wrenches.concat(), 1.0)
        + against(&found.residuals.concat(), &expected.residuals.concat(), accelerations)
}

/// Projects to the closed loops; returns the rank of the last step.
fn project(model: &Model, q: &mut [f64], qd: &mut [f64], steps: usize) -> usize {
    let mut interpreter = Interpreter::new(model.clone());
    let mut step_q = vec![0.0; qd.len()];
    let mut step_qd = vec![0.0; qd.len()];
    let mut rank = 0.0;
    for _ in 0..steps {
        let into = ProjectionOutputs { step_q: &mut step_q, step_qd: &mut step_qd };
        let settings = ConstraintSettings::<f64>::DEFAULT;
        rank =
            interpreter.project_constraints(State { q, qd }, &[], &settings, into).expect("fits");
        let before = q.to_owned();
        interpreter.integrate(&before, &step_q, q).expect("fits");
        qd.iter_mut().zip(&step_qd).for_each(|(v, d)| *v += d);
    }
    count(rank)
}

/// Returns the sum of the displacements of all loop constraints.
fn gap(model: &Model, q: &[f64]) -> f64 {
    let mut reference = Reference::new(model);
    (0..model.loop_constraints().len()).map(|c| reference.displacement(q, c).norm()).sum()
}

/// Returns a state of the aligned mechanism, with closed loops if they can be closed.
fn state(mechanism: &Mechanism, random: &mut Random) -> [Vec<f64>; 3] {
    let n = mechanism.model.nv();
    let (mut q, mut qd) = (mechanism.q.clone(), random.vector(n, 1.0));
    if mechanism.closes {
        // An open loop may be locked, so coordinates are projected before velocities.
        project(&mechanism.model, &mut q, &mut vec![0.0; n], 40);
        project(&mechanism.model, &mut q.clone(), &mut qd, 1);
        let gap = gap(&mechanism.model, &q);
        assert!(gap < 1e-13, "{}: {gap}", mechanism.name);
    }
    // The torques accelerate light links no more than heavy ones.
    let mut mass = vec![0.0; n * n];
    let mut interpreter = Interpreter::new(mechanism.model.clone());
    interpreter.mass_matrix(&q, &mut mass).expect("fits");
    let accelerations = random.vector(n, 5.0);
    let tau =
        mass.chunks(n).map(|column| column.iter().zip(&accelerations).map(|(m, a)| m * a).sum());
    let tau = tau.collect();
    [q, qd, tau]
}

/// Returns the same state of the scaled mechanism.
fn scaled([q, qd, tau]: &[Vec<f64>; 3], scale: f64, lengths: &[bool]) -> [Vec<f64>; 3] {
    let by = |x: &[f64], length: f64, angle: f64| {
        let x = x.iter().zip(lengths);
        x.map(|(x, &is)| if is { x * length } else { x * angle }).collect::<Vec<f64>>()
    };
    [by(q, scale, 1.0), by(qd, scale, 1.0), by(tau, scale, scale * scale)]
}

fn for_all(check: impl Fn(&Mechanism, &mut Random)) {
    for mechanism in all() {
        let mut random = Random(11);
        check(&mechanism, &mut random);
    }
}

#[test]
fn double_precision_agrees_with_the_dense_reference() {
    for_all(|mechanism, random| {
        let name = mechanism.name;
        let lengths = lengths(&mechanism.model);
        let at_rest = state(mechanism, random);
        let [q, qd, tau] = &at_rest;
        let expected = Reference::new(&mechanism.model).solve((q, qd, tau), (ALPHA, BETA));
        assert_eq!(expected.rank, mechanism.rank, "{name}");
        let own = interpreted::<f64>(&mechanism.model, &at_rest);
        let found = difference(&own, &expected);
        assert!(found < 1e-9, "{name}: {found:e}");
        for k in 0..ROTATIONS {
            let (r, size) = (random.rotation(), SIZES[k % SIZES.len()]);
            let model = rotated(&mechanism.model, &r, size);
            let there = scaled(&at_rest, size, &lengths);
            let interpreted = interpreted::<f64>(&model, &there);
            let compiled = Compiled::new(&model).solve::<f64>(&there);
            for solution in [&interpreted, &compiled] {
                let found = difference(&aligned(solution, &r, size, &lengths), &own);
                assert!(found < 1e-9, "{name} {k} (size {size}): {found:e}");
            }
        }
    });
}

#[test]
fn single_precision_finds_the_same_ranks() {
    for_all(|mechanism, random| {
        let name = mechanism.name;
        let lengths = lengths(&mechanism.model);
        let at_rest = state(mechanism, random);
        let own = interpreted::<f64>(&mechanism.model, &at_rest);
        for k in 0..ROTATIONS {
            let (r, size) = (random.rotation(), SIZES[k % SIZES.len()]);
            let model = rotated(&mechanism.model, &r, size);
            let there = scaled(&at_rest, size, &lengths);
            let interpreted = interpreted::<f32>(&model, &there);
            let compiled = Compiled::new(&model).solve::<f32>(&there);
            for solution in [&interpreted, &compiled] {
                let found = difference(&aligned(solution, &r, size, &lengths), &own);
                assert!(found < 1e-2, "{name} {k} (size {size}): {found:e}");
            }
        }
    });
}

#[test]
fn projection_assembles_mechanisms_in_general_position() {
    for_all(|mechanism, random| {
        if !mechanism.closes {
            return;
        }
        let name = mechanism.name;
        let lengths = lengths(&mechanism.model);
        let [q, _, _] = state(mechanism, random);
        for k in 0..ROTATIONS {
            let (r, size) = (random.rotation(), SIZES[k % SIZES.len()]);
            let model = rotated(&mechanism.model, &r, size);
            let off: Vec<f64> = q.iter().map(|q| q + 0.03 * random.next()).collect();
            let near = [off, random.vector(q.len(), 1.0), vec![0.0; q.len()]];
            let [mut q, mut qd, _] = scaled(&near, size, &lengths);
            let compiled = Compiled::new(&model);
            let settings = <f64 as Precision>::settings();
            let inputs = [q.clone(), qd.clone(), numbers(&settings).to_vec()].concat();
            let step = compiled.projection.evaluate(&inputs);
            let before = (q.clone(), qd.clone());
            project(&model, &mut q, &mut qd, 1);
            let taken: Vec<f64> = q
                .iter()
                .zip(&before.0)
                .chain(qd.iter().zip(&before.1))
                .map(|(a, b)| a - b)
                .collect();
            let size_of = taken.iter().fold(0.0_f64, |size, x| size.max(x.abs()));
            for (a, b) in step.iter().zip(&taken) {
                assert!(
                    (a - b).abs() < 1e-7 * size_of,
                    "{name} {k}: {step:?} instead of {taken:?}"
                );
            }
            let rank = project(&model, &mut q, &mut qd, 30);
            let gap = gap(&model, &q);
            assert!(gap < 1e-12 * size.max(1.0), "{name} {k} (size {size}): {gap:e}");
            let moved = q.iter().zip(&before.0).zip(&lengths);
            let moved =
                moved.map(|((a, b), &length)| ((a - b) / if length { size } else { 1.0 }).abs());
            let moved = moved.fold(0.0, f64::max);
            assert!(moved < 3.0, "{name} {k}: {moved}");
            // A linkage that is assembled close to a singular configuration may leave it.
            assert!(rank == mechanism.rank || name == "flat", "{name} {k}: {rank}");
        }
    });
}

/// Returns the derivatives of the accelerations with respect to q and qd, by columns.
fn derivatives(model: &Model, [q, qd, tau]: &[Vec<f64>; 3]) -> [Vec<f64>; 2] {
    let (n, loops) = (model.nv(), model.loop_constraints().len());
    let (mut qdd, mut wrenches) = (vec![0.0; n], vec![Wrench::zero(); loops]);
    let mut matrices = [0; 3].map(|_| vec![0.0; n * n]);
    let mut changes = [0; 3].map(|_| vec![Wrench::zero(); n * loops]);
    let outputs = ConstrainedDerivatives::new(&mut qdd, &mut wrenches, &mut matrices, &mut changes);
    let mut interpreter = Interpreter::new(model.clone());
    let derive = Interpreter::constrained_forward_dynamics_derivatives;
    let settings = <f64 as Precision>::settings();
    derive(&mut interpreter, ForwardInput { q, qd, tau }, &[], &settings, outputs).expect("fits");
    let [dq, dqd, _] = matrices;
    [dq, dqd]
}

/// Redundant rows remain consistent only while the loops are closed: along such a motion the accelerations change as the
/// derivatives say.
#[test]
fn derivatives_along_motions_of_closed_mechanisms() {
    let checked = Cell::new(0);
    for_all(|mechanism, random| {
        // The rank of a singular mechanism changes as it moves.
        if !mechanism.closes || mechanism.name == "flat" {
            return;
        }
        let name = mechanism.name;
        let lengths = lengths(&mechanism.model);
        let [q, qd, tau] = state(mechanism, random);
        let n = q.len();
        let (along, faster) = (qd.clone(), random.vector(n, 1.0));
        for (r, size) in
            [(Matrix3::identity(), 1.0), (random.rotation(), 1.0), (random.rotation(), 50.0)]
        {
            let model = rotated(&mechanism.model, &r, size);
            // The state at time s of a motion with closed loops.
            let at = |s: f64| {
                let moved = |x: &[f64], by: &[f64]| -> Vec<f64> {
                    x.iter().zip(by).map(|(x, by)| x + s * by).collect()
                };
                let there = [moved(&q, &along), moved(&qd, &faster), tau.clone()];
                let [mut q, mut qd, tau] = scaled(&there, size, &lengths);
                project(&model, &mut q, &mut vec![0.0; n], 6);
                project(&model, &mut q.clone(), &mut qd, 2);
                let state = [q, qd, tau];
                let found = interpreted::<f64>(&model, &state);
                (state, found)
            };
            let (here, solution) = at(0.0);
            assert_eq!(solution.rank, mechanism.rank, "{name}");
            let step = 1e-3;
            let near = [1.0, -1.0, 2.0, -2.0].map(|k| at(k * step));
            assert!(near.iter().all(|(_, found)| found.rank == mechanism.rank), "{name}");
            let slope = |of: &dyn Fn(usize) -> f64| {
                (8.0 * (of(0) - of(1)) - (of(2) - of(3))) / (12.0 * step)
            };
            let rates: [Vec<f64>; 2] = [0, 1].map(|variable: usize| {
                (0..n).map(|i| slope(&|k| near[k].0[variable][i])).collect()
            });
            let matrices = derivatives(&model, &here);
            let expected: Vec<f64> = (0..n).map(|i| slope(&|k| near[k].1.qdd[i])).collect();
            let found: Vec<f64> = (0..n)
                .map(|i| {
                    let of = |(matrix, rates): (&Vec<f64>, &Vec<f64>)| -> f64 {
                        (0..n).map(|k| matrix[k * n + i] * rates[k]).sum()
                    };
                    matrices.iter().zip(&rates).map(of).sum()
                })
                .collect();
            let scale =
                expected.iter().chain(&solution.qdd).fold(1.0_f64, |most, x| most.max(x.abs()));
            for (a, b) in found.iter().zip(&expected) {
                assert!(
                    (a - b).abs() < 1e-6 * scale,
                    "{name} (size {size}): {a} instead of {b}, of {scale}"
                );
            }
            checked.set(checked.get() + 1);
        }
    });
    assert!(checked.get() >= 24, "{}", checked.get());
}

#[test]
fn the_characteristic_length_is_as_documented() {
    for_all(|mechanism, _| {
        for (size, r) in [(1.0, Matrix3::identity()), (7.0, Random(5).rotation())] {
            let model = rotated(&mechanism.model, &r, size);
            let q = scaled(&[mechanism.q.clone(), vec![], vec![]], size, &lengths(&model));
            let neutral: Vec<f64> = q[0].iter().map(|_| 0.0).collect();
            for c in 0..model.loop_constraints().len() {
                let expected = Reference::new(&model).length(&neutral, c);
                let found = model.characteristic_length(c);
                assert!((found - expected).abs() < 1e-12 * expected, "{}", mechanism.name);
            }
        }
    });
}

#[test]
fn a_loop_without_extent_has_a_length_of_a_metre() {
    let joint = Joint::new("joint", JointType::Spherical, [0.0, 0.0, 1.0], Pose::identity());
    let link =
        MovingLink { name: "link".into(), parent: None, joint, inertial: Inertial::default() };
    let frame = |name: &str, link| Link {
        name: name.into(),
        moving_link: link,
        pose: Pose::identity(),
        inertial: Inertial::default(),
    };
    let end = |frame| LoopConstraintEnd { link: frame, pose: Pose::identity() };
    let constraint = LoopConstraint {
        name: "closed".into(),
        ends: [end(0), end(1)],
        kind: LoopConstraintKind::Rigid,
    };
    let frames = vec![frame("world", None), frame("link", Some(0))];
    let model = Model::new("point", [0.0; 3], vec![link], frames)
        .and_then(|model| model.with_loop_constraints(vec![constraint]))
        .expect("sound parts");
    assert!((model.characteristic_length(0) - 1.0).abs() < 1e-15);
}
