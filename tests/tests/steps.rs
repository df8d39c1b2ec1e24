//! Discrete dynamics: steps against the accelerations, the order of the Runge-Kutta method, and derivatives against dual
//! numbers and differences.

use modyn_runtime::equations::TimeStepInput;
use modyn_runtime::model::Model;
use modyn_runtime::{Interpreter, Scalar, ShapeError, StepOutputs};
use modyn_tests::close::assert_close;
use modyn_tests::dual::{Tangent, along, along_velocity, constant};
use modyn_tests::floating::floated;
use modyn_tests::golden;
use modyn_tests::quantities::Quantities;
use modyn_tests::random::{self, Random, State};

const LENGTHS: &str = "the lengths are right";

/// The method of a step.
#[derive(Clone, Copy, Debug)]
enum Method {
    SemiImplicit,
    Rk4,
}

/// Returns the coordinates and velocities after a step.
fn step<S: Scalar>(
    robot: &mut Interpreter<S>,
    method: Method,
    state: [&[S]; 3],
    dt: S,
) -> [Vec<S>; 2] {
    let [q, qd, tau] = state;
    let (mut next_q, mut next_qd) = (q.to_vec(), qd.to_vec());
    let input = TimeStepInput { q, qd, tau, dt };
    let done = match method {
        Method::SemiImplicit => robot.step_semi_implicit(input, &mut next_q, &mut next_qd),
        Method::Rk4 => robot.step_rk4(input, &mut next_q, &mut next_qd),
    };
    done.expect(LENGTHS);
    [next_q, next_qd]
}

/// Returns the coordinates and velocities after a step, and A and B.
fn derivatives(
    robot: &mut Interpreter,
    method: Method,
    [q, qd, tau]: [&[f64]; 3],
    dt: f64,
) -> [Vec<f64>; 4] {
    let n = qd.len();
    let mut found = [q.len(), n, 4 * n * n, 2 * n * n].map(|length| vec![f64::NAN; length]);
    let [next_q, next_qd, a, b] = &mut found;
    let outputs = StepOutputs { q: next_q, qd: next_qd, a, b };
    let done = match method {
        Method::SemiImplicit => {
            robot.step_semi_implicit_derivatives(TimeStepInput { q, qd, tau, dt }, outputs)
        }
        Method::Rk4 => robot.step_rk4_derivatives(TimeStepInput { q, qd, tau, dt }, outputs),
    };
    done.expect(LENGTHS);
    found
}

fn difference<S: Scalar>(robot: &Interpreter<S>, from: &[S], to: &[S]) -> Vec<S> {
    let mut v = vec![S::zero(); robot.model().nv()];
    robot.difference(from, to, &mut v).expect(LENGTHS);
    v
}

/// Random robots with joints of all types, and a state of each.
fn robots(count: u64) -> impl Iterator<Item = (Model, State)> {
    (0..count).map(|seed| {
        let links = 2 + usize::try_from(seed % 6).expect("a digit");
        let model = random::mixed_zoo(seed, links);
        let state = random::state(seed, &model);
        (model, state)
    })
}

#[test]
fn a_semi_implicit_step_moves_by_the_new_velocities() {
    for (model, State { q, qd, tau, .. }) in robots(20) {
        let mut robot = Interpreter::new(model);
        let dt = 0.03;
        let [next_q, next_qd] = step(&mut robot, Method::SemiImplicit, [&q, &qd, &tau], dt);
        let qdd = robot.qdd(&q, &qd, &tau);
        let expected: Vec<f64> = qd.iter().zip(&qdd).map(|(v, a)| v + dt * a).collect();
        assert_close("velocities", &next_qd, &expected, 1e-12);
        let moved: Vec<f64> = next_qd.iter().map(|v| dt * v).collect();
        let mut expected = q.clone();
        robot.integrate(&q, &moved, &mut expected).expect(LENGTHS);
        assert_close("coordinates", &next_q, &expected, 1e-12);
    }
}

/// The errors of four and of eight steps over one time differ by 2^4.
#[test]
fn runge_kutta_steps_are_of_fourth_order() {
    for name in golden::GENERAL_TREES {
        let model = golden::model(&golden::urdf(name));
        let State { q, qd, tau, .. } = random::state(5, &model);
        let mut robot = Interpreter::new(model);
        let mut after = |steps: u32| {
            let mut state = [q.clone(), qd.clone()];
            for _ in 0..steps {
                let [q, qd] = &state;
                state = step(&mut robot, Method::Rk4, [q, qd, &tau], 0.1 / f64::from(steps));
            }
            state
        };
        let (reference, coarse, fine) = (after(128), after(4), after(8));
        let error = |[q, qd]: &[Vec<f64>; 2]| {
            let moved = difference(&robot, &reference[0], q);
            let rates = reference[1].iter().zip(qd).map(|(a, b)| a - b);
            moved.into_iter().chain(rates).map(f64::abs).fold(0.0, f64::max)
        };
        let ratio = error(&coarse) / error(&fine);
        assert!((11.0..23.0).contains(&ratio), "{name}: {ratio}, {}", error(&fine));
    }
}

/// The derivatives of robots with joints of all types and of a tree on a floating base, by differences at two distances, whose
/// errors of second order cancel (Richardson's extrapolation).
#[test]
fn derivatives_of_runge_kutta_are_limits_of_differences() {
    let dt = 0.05;
    let models = [random::mixed_zoo(4, 6), random::mixed_zoo(7, 5)];
    for model in
        models.into_iter().chain([floated(&random::general_tree(7, 4), Random::new(7).inertial())])
    {
        let State { q, qd, tau, .. } = random::state(3, &model);
        let n = model.nv();
        let mut robot = Interpreter::new(model);
        let [next_q, _, a, b] = derivatives(&mut robot, Method::Rk4, [&q, &qd, &tau], dt);
        let mut column = |k: usize, h: f64| {
            let mut at = |h: f64| {
                let mut state = [q.clone(), qd.clone(), tau.clone()];
                if k < n {
                    let along: Vec<f64> = (0..n).map(|i| if i == k { h } else { 0.0 }).collect();
                    robot.integrate(&q, &along, &mut state[0]).expect(LENGTHS);
                } else {
                    state[k / n][k % n] += h;
                }
                let [q, qd, tau] = &state;
                let [moved, rates] = step(&mut robot, Method::Rk4, [q, qd, tau], dt);
                [difference(&robot, &next_q, &moved), rates].concat()
            };
            let (ahead, back) = (at(h), at(-h));
            ahead.iter().zip(back).map(|(a, b)| (a - b) / (2.0 * h)).collect::<Vec<f64>>()
        };
        for (k, exact) in a.chunks(2 * n).chain(b.chunks(2 * n)).enumerate() {
            let (coarse, fine) = (column(k, 2e-4), column(k, 1e-4));
            let limit: Vec<f64> =
                fine.iter().zip(&coarse).map(|(f, c)| (4.0 * f - c) / 3.0).collect();
            assert_close("column", exact, &limit, 1e-7);
        }
    }
}

/// Numbers follow the classical method of Runge and Kutta.
#[test]
fn joints_with_one_coordinate_follow_the_classical_method() {
    let model = golden::model(&golden::urdf("panda"));
    let State { q, qd, tau, .. } = random::state(8, &model);
    let mut robot = Interpreter::new(model);
    let dt = 0.02;
    let plus = |a: &[f64], h: f64, b: &[f64]| -> Vec<f64> {
        a.iter().zip(b).map(|(a, b)| a + h * b).collect()
    };
    let mut rates = |q: &[f64], qd: &[f64]| [qd.to_vec(), robot.qdd(q, qd, &tau)];
    let mut stages = vec![rates(&q, &qd)];
    for time in [dt / 2.0, dt / 2.0, dt] {
        let [v, a] = stages.last().expect("a stage");
        stages.push(rates(&plus(&q, time, v), &plus(&qd, time, a)));
    }
    let sum = |start: &[f64], part: usize| {
        let weights = [1.0, 2.0, 2.0, 1.0].iter().zip(&stages);
        weights.fold(start.to_vec(), |sum, (w, stage)| plus(&sum, w * dt / 6.0, &stage[part]))
    };
    let expected = [sum(&q, 0), sum(&qd, 1)];
    let found = step(&mut robot, Method::Rk4, [&q, &qd, &tau], dt);
    assert_close("coordinates", &found[0], &expected[0], 1e-14);
    assert_close("velocities", &found[1], &expected[1], 1e-13);
}

#[test]
fn derivatives_are_those_of_dual_numbers() {
    compare_with_dual_numbers(Method::SemiImplicit);
}

#[test]
fn derivatives_of_runge_kutta_are_those_of_dual_numbers() {
    compare_with_dual_numbers(Method::Rk4);
}

fn compare_with_dual_numbers(method: Method) {
    let dt = 0.04;
    for (model, State { q, qd, tau, .. }) in robots(40) {
        let n = model.nv();
        let mut robot = Interpreter::new(model.clone());
        let mut dual = Interpreter::<Tangent<f64>>::new(model.clone());
        let [next_q, next_qd, a, b] = derivatives(&mut robot, method, [&q, &qd, &tau], dt);
        let stepped = step(&mut robot, method, [&q, &qd, &tau], dt);
        assert_close("coordinates", &next_q, &stepped[0], 1e-10);
        assert_close("velocities", &next_qd, &stepped[1], 1e-10);
        let mut column = |q: &[Tangent<f64>], qd: &[Tangent<f64>], tau: &[Tangent<f64>]| {
            let dt = Tangent { x: dt, dx: 0.0 };
            let [moved, rates] = step(&mut dual, method, [q, qd, tau], dt);
            let moved = difference(&dual, &constant(&next_q), &moved);
            moved.into_iter().chain(rates).map(|x| x.dx).collect::<Vec<f64>>()
        };
        let [fixed_q, fixed_qd, fixed_tau] = [&q, &qd, &tau].map(|x| constant(x));
        let by_q = |k| along_velocity(&model, &q, k);
        let mut expected = [Vec::new(), Vec::new()];
        for k in 0..n {
            expected[0].extend(column(&by_q(k), &fixed_qd, &fixed_tau));
        }
        for k in 0..n {
            expected[0].extend(column(&fixed_q, &along(&qd, k), &fixed_tau));
            expected[1].extend(column(&fixed_q, &fixed_qd, &along(&tau, k)));
        }
        assert_close("A", &a, &expected[0], 1e-9);
        assert_close("B", &b, &expected[1], 1e-9);
    }
}

#[test]
fn lengths_are_checked() {
    let (model, State { q, qd, tau, .. }) = robots(1).next().expect("a robot");
    let mut robot = Interpreter::new(model);
    let (mut next_q, mut next_qd, n) = (q.clone(), qd.clone(), qd.len());
    let short = [0.0; 0];
    let error = |name, expected| Err(ShapeError::new(name, expected, 0));
    let found = robot.step_rk4(
        TimeStepInput { q: &q, qd: &short, tau: &tau, dt: 0.1 },
        &mut next_q,
        &mut next_qd,
    );
    assert_eq!(found, error("qd", n));
    let found = robot.step_semi_implicit(
        TimeStepInput { q: &q, qd: &qd, tau: &tau, dt: 0.1 },
        &mut next_q,
        &mut [],
    );
    assert_eq!(found, error("next_qd", n));
    let outputs = StepOutputs { q: &mut next_q, qd: &mut next_qd, a: &mut [], b: &mut [] };
    let found = robot.step_semi_implicit_derivatives(
        TimeStepInput { q: &q, qd: &qd, tau: &tau, dt: 0.1 },
        outputs,
    );
    assert_eq!(found, error("a", 4 * n * n));
    let a = &mut vec![0.0; 4 * n * n];
    let outputs = StepOutputs { q: &mut next_q, qd: &mut next_qd, a, b: &mut [] };
    let found =
        robot.step_rk4_derivatives(TimeStepInput { q: &q, qd: &qd, tau: &tau, dt: 0.1 }, outputs);
    assert_eq!(found, error("b", 2 * n * n));
}
