//! Contracted Hessians of a semi-implicit Euler step: the function and the interpreter against num-dual's numbers through
//! forward dynamics and exponential maps that are written out here.

use modyn_codegen::passes::optimize;
use modyn_codegen::plan::COLUMN_LANES;
use modyn_codegen::trace::{Parameters, Tracer};
use modyn_runtime::equations::TimeStepInput;
use modyn_runtime::equations::brge::UduLayout;
use modyn_runtime::joint::JointType;
use modyn_runtime::mechanism::Mechanism;
use modyn_runtime::model::{Model, ModuleTree};
use modyn_runtime::num_dual::{DualNum, HyperDual64};
use modyn_runtime::{Interpreter, ShapeError, StepHessianOutputs};
use modyn_tests::close::assert_close;
use modyn_tests::floating::floated;
use modyn_tests::golden;
use modyn_tests::random::{self, Random, State};

type Number = HyperDual64;
type Vector = [Number; 3];
/// x, y, z, w.
type Quaternion = [Number; 4];

fn zero() -> Number {
    Number::from(0.0)
}

fn dot(a: Vector, b: Vector) -> Number {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Returns a + factor b.
fn sum(a: Vector, factor: Number, b: Vector) -> Vector {
    std::array::from_fn(|i| a[i] + factor * b[i])
}

fn conjugate([x, y, z, w]: Quaternion) -> Quaternion {
    [-x, -y, -z, w]
}

fn product([ax, ay, az, aw]: Quaternion, [bx, by, bz, bw]: Quaternion) -> Quaternion {
    let (a, b) = ([ax, ay, az], [bx, by, bz]);
    let [x, y, z] = sum(sum(cross(a, b), aw, b), bw, a);
    [x, y, z, aw * bw - dot(a, b)]
}

fn rotate(q: Quaternion, v: Vector) -> Vector {
    let [x, y, z, _] = product(product(q, [v[0], v[1], v[2], zero()]), conjugate(q));
    [x, y, z]
}

/// The exponential map by its closed form, for large rotations.
fn exponential(w: Vector, v: Vector) -> (Quaternion, Vector) {
    let angle = dot(w, w).sqrt();
    let (sine, cosine) = (angle.sin(), angle.cos());
    let half = (angle * 0.5).sin() / angle;
    let (first, second) =
        ((-cosine + 1.0) / (angle * angle), (angle - sine) / (angle * angle * angle));
    let across = cross(w, v);
    let moved = sum(sum(v, first, across), second, cross(w, across));
    ([half * w[0], half * w[1], half * w[2], (angle * 0.5).cos()], moved)
}

/// The exponential map to second order, for displacements whose real parts are zero.
fn small_exponential(w: Vector, v: Vector) -> (Quaternion, Vector) {
    let half = Number::from(0.5);
    let scalar = -dot(w, w) * 0.125 + 1.0;
    ([half * w[0], half * w[1], half * w[2], scalar], sum(v, half, cross(w, v)))
}

/// Returns the coordinates after a displacement by one of the exponential maps.
fn displaced(
    model: &Model,
    q: &[Number],
    v: &[Number],
    map: fn(Vector, Vector) -> (Quaternion, Vector),
) -> Vec<Number> {
    let mut moved = q.to_vec();
    let three = |x: &[Number]| -> Vector { std::array::from_fn(|i| x[i]) };
    let four = |x: &[Number]| -> Quaternion { std::array::from_fn(|i| x[i]) };
    joints(model, |joint_type, at, k| match joint_type {
        JointType::Spherical => {
            let (turn, _) = map(three(&v[k..]), [zero(); 3]);
            moved[at..at + 4].copy_from_slice(&product(four(&q[at..]), turn));
        }
        JointType::Floating => {
            let (turn, shift) = map(three(&v[k + 3..]), three(&v[k..]));
            let attitude = four(&q[at + 3..]);
            let position = sum(three(&q[at..]), Number::from(1.0), rotate(attitude, shift));
            moved[at..at + 3].copy_from_slice(&position);
            moved[at + 3..at + 7].copy_from_slice(&product(attitude, turn));
        }
        _ => (0..joint_type.nv()).for_each(|i| moved[at + i] += v[k + i]),
    });
    moved
}

/// Returns the displacement between coordinates with equal real parts, to second order.
fn small_difference(model: &Model, from: &[Number], to: &[Number]) -> Vec<Number> {
    let mut v = vec![zero(); model.nv()];
    let four = |x: &[Number]| -> Quaternion { std::array::from_fn(|i| x[i]) };
    let turn = |at: usize| -> Vector {
        let [x, y, z, _] = product(conjugate(four(&from[at..])), four(&to[at..]));
        [x, y, z].map(|x| x * 2.0)
    };
    joints(model, |joint_type, at, k| match joint_type {
        JointType::Spherical => v[k..k + 3].copy_from_slice(&turn(at)),
        JointType::Floating => {
            let (attitude, w) = (four(&from[at + 3..]), turn(at + 3));
            let moved = std::array::from_fn(|i| to[at + i] - from[at + i]);
            let moved = rotate(conjugate(attitude), moved);
            v[k..k + 3].copy_from_slice(&sum(moved, Number::from(-0.5), cross(w, moved)));
            v[k + 3..k + 6].copy_from_slice(&w);
        }
        _ => (0..joint_type.nv()).for_each(|i| v[k + i] = to[at + i] - from[at + i]),
    });
    v
}

/// Calls `f` with the joint type of each leading joint, and its first entries of q and qd.
fn joints(model: &Model, mut f: impl FnMut(JointType, usize, usize)) {
    let (mut q, mut v) = (0, 0);
    for joint in model.moving_links().iter().map(|link| &link.joint).filter(|j| j.mimic.is_none()) {
        f(joint.joint_type, q, v);
        q += joint.joint_type.nq();
        v += joint.joint_type.nv();
    }
}

/// A step and the multipliers of its result.
struct Step<'a> {
    model: &'a Model,
    state: &'a State,
    dt: f64,
    cotangent: &'a [f64],
}

impl Step<'_> {
    /// Returns the numbers of the generated function by num-dual's numbers: the gradients, then the three blocks.
    fn expected(&self) -> Vec<f64> {
        let Self { model, state: State { q, qd, tau, .. }, dt, cotangent } = self;
        let n = model.nv();
        let mut interpreter = Interpreter::<Number>::new((*model).clone());
        let real = |x: &[f64]| -> Vec<Number> { x.iter().map(|&x| Number::from(x)).collect() };
        let mut next = |x: &[Number]| -> [Vec<Number>; 2] {
            let plus = |a: &[f64], b: &[Number]| -> Vec<Number> {
                a.iter().zip(b).map(|(&a, &b)| b + a).collect()
            };
            let q = displaced(model, &real(q), &x[..n], small_exponential);
            let (qd, tau) = (plus(qd, &x[n..2 * n]), plus(tau, &x[2 * n..]));
            let mut qdd = vec![zero(); n];
            interpreter.forward_dynamics(&q, &qd, &tau, &mut qdd).expect("fits");
            let next_qd: Vec<Number> = qd.iter().zip(&qdd).map(|(&v, &a)| v + a * *dt).collect();
            let moved: Vec<Number> = next_qd.iter().map(|&v| v * *dt).collect();
            [displaced(model, &q, &moved, exponential), next_qd]
        };
        let [start, _] = next(&vec![zero(); 3 * n]);
        let start: Vec<Number> = start.iter().map(|x| Number::from(x.re)).collect();
        let mut product = |i: usize, j: usize| -> Number {
            let mut x = vec![zero(); 3 * n];
            x[i].eps1 = 1.0;
            x[j].eps2 = 1.0;
            let [q, qd] = next(&x);
            let state = small_difference(model, &start, &q).into_iter().chain(qd);
            state.zip(*cotangent).fold(zero(), |sum, (x, &weight)| sum + x * weight)
        };
        let gradients: Vec<f64> = (0..3 * n).map(|i| product(i, i).eps1).collect();
        let mut block = |rows: usize, columns: std::ops::Range<usize>| -> Vec<f64> {
            columns
                .flat_map(|j| (0..rows).map(move |i| (i, j)))
                .map(|(i, j)| product(i, j).eps1eps2)
                .collect()
        };
        let (of_state, mixed) = (block(2 * n, 0..2 * n), block(2 * n, 2 * n..3 * n));
        let of_tau = (2 * n..3 * n).flat_map(|j| (2 * n..3 * n).map(move |i| (i, j)));
        let of_tau: Vec<f64> = of_tau.map(|(i, j)| product(i, j).eps1eps2).collect();
        [gradients, of_state, mixed, of_tau].concat()
    }

    /// Returns the same numbers of the interpreter, after the coordinates and velocities.
    fn interpreted(&self) -> Vec<f64> {
        let Self { model, state: State { q, qd, tau, .. }, dt, cotangent } = self;
        let n = model.nv();
        let sizes = [q.len(), n, 2 * n, n, 4 * n * n, 2 * n * n, n * n];
        let mut found = sizes.map(|size| vec![f64::NAN; size]);
        let [next_q, next_qd, grad_x, grad_tau, hess_x_x, hess_x_tau, hess_tau_tau] = &mut found;
        let outputs = StepHessianOutputs {
            q: next_q,
            qd: next_qd,
            grad_x,
            grad_tau,
            hess_x_x,
            hess_x_tau,
            hess_tau_tau,
        };
        let mut interpreter = Interpreter::new((*model).clone());
        interpreter
            .step_semi_implicit_hessian(TimeStepInput { q, qd, tau, dt: *dt }, cotangent, outputs)
            .expect("fits");
        found.concat()
    }

    /// Returns the same numbers of the generated function's graph.
    fn compiled(&self, lanes: bool) -> Vec<f64> {
        let Self { model, state: State { q, qd, tau, .. }, dt, cotangent } = self;
        let mechanism = Mechanism::new(model);
        // Run-time gravity is an input after all others.
        let tracer = Tracer::with_parameters(&mechanism, Parameters::new(model, true, &[], &[]));
        let tracer = if lanes { tracer.column_lanes(COLUMN_LANES) } else { tracer };
        let chains = UduLayout::new(&mechanism, &ModuleTree::chains(model));
        let graph = optimize(tracer.step_semi_implicit_hessian(&chains));
        let inputs = [&q[..], qd, tau, &[*dt], cotangent, &model.gravity()].concat();
        graph.evaluate::<f64>(&inputs)
    }

    fn compare(&self, name: &str) {
        let Self { model, state: State { q, qd, tau, .. }, dt, .. } = self;
        let (nq, n) = (model.nq(), model.nv());
        let (interpreted, compiled) = (self.interpreted(), self.compiled(false));
        let in_lanes = self.compiled(true);
        let (mut next_q, mut next_qd) = (q.clone(), qd.clone());
        let mut robot = Interpreter::<f64>::new((*model).clone());
        robot
            .step_semi_implicit(TimeStepInput { q, qd, tau, dt: *dt }, &mut next_q, &mut next_qd)
            .expect("fits");
        let expected = self.expected();
        for (who, found) in
            [("interpreter", interpreted), ("compiler", compiled), ("lanes", in_lanes)]
        {
            assert_close(&format!("{name}: q, {who}"), &found[..nq], &next_q, 1e-9);
            assert_close(&format!("{name}: qd, {who}"), &found[nq..nq + n], &next_qd, 1e-9);
            let lengths = [2 * n, n, 4 * n * n, 2 * n * n, n * n];
            let (mut found, mut expected) = (&found[nq + n..], &expected[..]);
            for (part, length) in lengths.into_iter().enumerate() {
                let (own, other) = (found.split_at(length), expected.split_at(length));
                assert_close(&format!("{name}: part {part}, {who}"), own.0, other.0, 1e-8);
                (found, expected) = (own.1, other.1);
            }
        }
    }
}

/// Returns random multipliers.
fn cotangent(seed: u64, model: &Model) -> Vec<f64> {
    let random = &mut Random::new(seed);
    (0..2 * model.nv()).map(|_| random.between(-1.0, 1.0)).collect()
}

fn compare(name: &str, model: &Model, seed: u64) {
    let (state, cotangent) = (random::state(seed, model), cotangent(seed, model));
    Step { model, state: &state, dt: 0.05, cotangent: &cotangent }.compare(name);
}

#[test]
fn hessians_of_random_robots_are_those_of_dual_numbers() {
    let models = (0..24)
        .map(|seed| random::general_zoo(seed, 1 + usize::try_from(seed % 5).expect("a digit")));
    random::for_all_kinds(models, |seed, model| compare(&format!("seed {seed}"), model, seed));
}

#[test]
fn hessians_of_floating_robots_are_those_of_dual_numbers() {
    for seed in 0..6 {
        let links = 1 + usize::try_from(seed % 4).expect("a digit");
        let model = floated(&random::mixed_tree(seed, links), Random::new(seed).inertial());
        compare(&format!("floating, seed {seed}"), &model, seed);
    }
}

/// The Hessian of joints with an axis is that of forward dynamics; then tau enters linearly.
#[test]
fn steps_of_joints_with_axes_are_linear_in_the_forces() {
    let model = golden::model(&golden::urdf("panda"));
    let (state, cotangent) = (random::state(4, &model), cotangent(4, &model));
    let step = Step { model: &model, state: &state, dt: 0.05, cotangent: &cotangent };
    let n = model.nv();
    for found in [step.interpreted(), step.compiled(false), step.compiled(true)] {
        assert!(found[found.len() - n * n..].iter().all(|&x| x == 0.0));
    }
}

#[test]
fn lengths_are_checked() {
    let model = random::general_zoo(3, 4);
    let State { q, qd, tau, .. } = random::state(3, &model);
    let n = model.nv();
    let mut robot = Interpreter::<f64>::new(model);
    let (mut next_q, mut next_qd, mut rest) = (q.clone(), qd.clone(), vec![0.0; 3 * n]);
    let (grad_x, grad_tau) = rest.split_at_mut(2 * n);
    let outputs = StepHessianOutputs {
        q: &mut next_q,
        qd: &mut next_qd,
        grad_x,
        grad_tau,
        hess_x_x: &mut [],
        hess_x_tau: &mut [],
        hess_tau_tau: &mut [],
    };
    let cotangent = vec![0.0; 2 * n];
    let found = robot.step_semi_implicit_hessian(
        TimeStepInput { q: &q, qd: &qd, tau: &tau, dt: 0.1 },
        &cotangent,
        outputs,
    );
    assert_eq!(found, Err(ShapeError::new("hess_x_x", 4 * n * n, 0)));
}
