//! The implicit midpoint rule against its equations, which a plain Newton method with differences solves over textbook dynamics
//! and matrix exponentials: the state, its order, A and B. Then its symmetry, its energy and its stability.

use modyn_runtime::equations::TimeStepInput;
use modyn_runtime::joint::JointType;
use modyn_runtime::mechanism::Mechanism;
use modyn_runtime::model::{JointDynamics, JointFriction, Model};
use modyn_runtime::{Interpreter, ShapeError, StepOutputs};
use modyn_tests::close::assert_close;
use modyn_tests::floating::floated;
use modyn_tests::naive::Naive;
use modyn_tests::quantities::Quantities;
use modyn_tests::random::{self, Random, State};
use nalgebra::{DMatrix, DVector, Matrix3, Matrix4, Quaternion, UnitQuaternion, Vector3};

const LENGTHS: &str = "the lengths are right";

/// Returns the coordinates and velocities after a step.
fn step(robot: &mut Interpreter, [q, qd, tau]: [&[f64]; 3], dt: f64) -> [Vec<f64>; 2] {
    let (mut next_q, mut next_qd) = (q.to_vec(), qd.to_vec());
    robot
        .step_implicit_midpoint(TimeStepInput { q, qd, tau, dt }, &mut next_q, &mut next_qd)
        .expect(LENGTHS);
    [next_q, next_qd]
}

/// Returns the coordinates and velocities after a step, and A and B.
fn derivatives(robot: &mut Interpreter, [q, qd, tau]: [&[f64]; 3], dt: f64) -> [Vec<f64>; 4] {
    let n = qd.len();
    let mut found = [q.len(), n, 4 * n * n, 2 * n * n].map(|length| vec![f64::NAN; length]);
    let [next_q, next_qd, a, b] = &mut found;
    let outputs = StepOutputs { q: next_q, qd: next_qd, a, b };
    robot
        .step_implicit_midpoint_derivatives(TimeStepInput { q, qd, tau, dt }, outputs)
        .expect(LENGTHS);
    found
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

fn attitude(q: &[f64]) -> UnitQuaternion<f64> {
    UnitQuaternion::new_normalize(Quaternion::new(q[3], q[0], q[1], q[2]))
}

/// Returns the coordinates after the displacement `v`: rotations by nalgebra's quaternions, poses by the exponential of
/// matrices.
fn displaced(model: &Model, q: &[f64], v: &[f64]) -> Vec<f64> {
    let mut moved = q.to_vec();
    let rotate = |moved: &mut [f64], w: &[f64]| {
        let rotated =
            attitude(moved) * UnitQuaternion::from_scaled_axis(Vector3::from_row_slice(w));
        moved[..4].copy_from_slice(rotated.coords.as_slice());
    };
    joints(model, |joint_type, at, k| match joint_type {
        JointType::Spherical => rotate(&mut moved[at..at + 4], &v[k..k + 3]),
        JointType::Floating => {
            let w = Vector3::from_row_slice(&v[k + 3..k + 6]);
            let mut twist = Matrix4::zeros();
            twist.fixed_view_mut::<3, 3>(0, 0).copy_from(&w.cross_matrix());
            twist.fixed_view_mut::<3, 1>(0, 3).copy_from_slice(&v[k..k + 3]);
            let shift = twist.exp().fixed_view::<3, 1>(0, 3).into_owned();
            let shift = attitude(&q[at + 3..at + 7]) * shift;
            moved[at..at + 3].iter_mut().zip(shift.iter()).for_each(|(x, d)| *x += d);
            rotate(&mut moved[at + 3..at + 7], &v[k + 3..k + 6]);
        }
        _ => (0..joint_type.nv()).for_each(|i| moved[at + i] += v[k + i]),
    });
    moved
}

/// Returns the small displacement between coordinates, to second order.
fn small_difference(model: &Model, from: &[f64], to: &[f64]) -> Vec<f64> {
    let mut v = vec![0.0; model.nv()];
    let rotation =
        |at: usize| (attitude(&from[at..]).inverse() * attitude(&to[at..])).scaled_axis();
    joints(model, |joint_type, at, k| match joint_type {
        JointType::Spherical => v[k..k + 3].copy_from_slice(rotation(at).as_slice()),
        JointType::Floating => {
            let moved = Vector3::from_fn(|i, _| to[at + i] - from[at + i]);
            let w = rotation(at + 3);
            let moved = attitude(&from[at + 3..]).inverse() * moved;
            let half = Matrix3::identity() - 0.5 * w.cross_matrix();
            v[k..k + 3].copy_from_slice((half * moved).as_slice());
            v[k + 3..k + 6].copy_from_slice(w.as_slice());
        }
        _ => (0..joint_type.nv()).for_each(|i| v[k + i] = to[at + i] - from[at + i]),
    });
    v
}

fn combined(a: &[f64], factor: f64, b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + factor * b).collect()
}

/// Returns the state after a step by the equations of the rule, solved to the last digit.
fn converged(model: &Model, [q, qd, tau]: [&[f64]; 3], dt: f64) -> [Vec<f64>; 2] {
    let n = model.nv();
    let unmet = |a: &DVector<f64>| {
        let v = combined(qd, 0.5 * dt, a.as_slice());
        let scaled: Vec<f64> = v.iter().map(|v| 0.5 * dt * v).collect();
        let middle = displaced(model, q, &scaled);
        let forces = Naive::new(model, &middle).inverse_dynamics(&v, a.as_slice());
        DVector::from_vec(combined(&forces, -1.0, tau))
    };
    let mut a = DVector::zeros(n);
    let mut last = f64::INFINITY;
    for _ in 0..60 {
        let residual = unmet(&a);
        let jacobian = DMatrix::from_columns(
            &(0..n)
                .map(|j| {
                    let h = 1e-5 * (1.0 + a[j].abs());
                    let moved = |h: f64| {
                        let mut a = a.clone();
                        a[j] += h;
                        unmet(&a)
                    };
                    (moved(h) - moved(-h)) / (2.0 * h)
                })
                .collect::<Vec<_>>(),
        );
        let change = jacobian.lu().solve(&residual).expect("regular");
        a -= &change;
        let size = change.amax();
        if size >= last && size < 1e-9 * (1.0 + a.amax()) {
            break;
        }
        last = size;
    }
    assert!(last < 1e-9 * (1.0 + a.amax()), "not converged: {last}");
    let scaled: Vec<f64> = combined(qd, 0.5 * dt, a.as_slice()).iter().map(|v| dt * v).collect();
    [displaced(model, q, &scaled), combined(qd, dt, a.as_slice())]
}

/// Robots in general position, with joints of all types, mimic joints, rotors, damping and smooth friction, or with a
/// floating base; and a state of each.
fn robots(count: u64) -> impl Iterator<Item = (Model, State)> {
    (0..count).map(|seed| {
        let links = 1 + usize::try_from(seed % 6).expect("a digit");
        let model = match seed % 3 {
            2 => floated(&random::general_zoo(seed, links), Random::new(seed).inertial()),
            _ => random::general_zoo(seed, links),
        };
        let state = random::state(seed, &model);
        (model, state)
    })
}

/// Returns the largest difference of two states.
fn error(model: &Model, [q, qd]: &[Vec<f64>; 2], [other_q, other_qd]: &[Vec<f64>; 2]) -> f64 {
    let moved = small_difference(model, other_q, q);
    moved.iter().copied().chain(combined(qd, -1.0, other_qd)).map(f64::abs).fold(0.0, f64::max)
}

#[test]
fn steps_fulfil_the_equations_of_the_rule() {
    let (mut followers, mut types, mut driven, mut resisted) = (0, Vec::new(), 0, 0);
    for (seed, (model, State { q, qd, tau, .. })) in robots(30).enumerate() {
        followers += model.moving_links().iter().filter(|link| link.joint.mimic.is_some()).count();
        types.extend(model.moving_links().iter().map(|link| link.joint.joint_type.name()));
        let dofs = Mechanism::new(&model).dofs;
        driven += dofs.iter().filter(|dof| dof.armature.is_some()).count();
        resisted += dofs.iter().filter(|dof| dof.friction.is_some()).count();
        let mut robot = Interpreter::new(model.clone());
        for dt in [1e-3, -1e-3] {
            let found = step(&mut robot, [&q, &qd, &tau], dt);
            let left = error(&model, &found, &converged(&model, [&q, &qd, &tau], dt));
            assert!(left < 5e-9, "{seed}: {left}");
        }
    }
    types.sort_unstable();
    types.dedup();
    assert!(followers > 3 && types.len() >= 7, "{followers} mimic joints, {types:?}");
    assert!(driven > 3 && resisted > 3, "{driven} rotors, {resisted} with friction");
}

/// The iterations leave an error of order dt^7: half the time leaves a part in 128.
#[test]
fn the_iterations_gain_two_orders_each() {
    let mut measured = 0;
    for (seed, (model, State { q, qd, tau, .. })) in robots(24).enumerate() {
        // The smooth transition of friction bends within a step.
        if Mechanism::new(&model).dofs.iter().any(|dof| dof.friction.is_some()) {
            continue;
        }
        let mut robot = Interpreter::new(model.clone());
        let mut left = |dt: f64| {
            let found = step(&mut robot, [&q, &qd, &tau], dt);
            error(&model, &found, &converged(&model, [&q, &qd, &tau], dt))
        };
        let (coarse, fine) = (left(0.01), left(0.005));
        // Neither rounding nor accelerations that move the robot far within a step.
        if (1e-10..1e-5).contains(&coarse) {
            measured += 1;
            assert!((70.0..200.0).contains(&(coarse / fine)), "{seed}: {coarse} {fine}");
        }
    }
    assert!(measured >= 5, "{measured} robots");
}

/// The errors over one time with steps of dt, dt/2 and dt/4 fall by 4 each.
#[test]
fn steps_are_of_second_order() {
    for (seed, (model, State { q, qd, tau, .. })) in robots(9).enumerate() {
        let mut robot = Interpreter::new(model.clone());
        let tau: Vec<f64> = tau.iter().map(|tau| 0.1 * tau).collect();
        let time = 0.02;
        let mut after = |steps: u32| {
            let mut state = [q.clone(), qd.clone()];
            for _ in 0..steps {
                let [q, qd] = &state;
                state = step(&mut robot, [q, qd, &tau], time / f64::from(steps));
            }
            state
        };
        let found = [8, 16, 32].map(&mut after);
        let mut fine = [q.clone(), qd.clone()];
        for _ in 0..256 {
            let [q, qd] = &fine;
            let (mut next_q, mut next_qd) = (q.clone(), qd.clone());
            let input = TimeStepInput { q, qd, tau: &tau, dt: time / 256.0 };
            robot.step_rk4(input, &mut next_q, &mut next_qd).expect(LENGTHS);
            fine = [next_q, next_qd];
        }
        let [coarse, middle, best] = found.map(|state| error(&model, &state, &fine));
        for ratio in [coarse / middle, middle / best] {
            assert!((3.9..4.1).contains(&ratio), "{seed}: {coarse} {middle} {best}");
        }
    }
}

/// A step back from the end of a step returns to its start.
#[test]
fn steps_are_symmetric() {
    for (seed, (model, State { q, qd, tau, .. })) in robots(12).enumerate() {
        let mut robot = Interpreter::new(model.clone());
        let [next_q, next_qd] = step(&mut robot, [&q, &qd, &tau], 1e-3);
        let back = step(&mut robot, [&next_q, &next_qd, &tau], -1e-3);
        let found = error(&model, &back, &[q, qd]);
        assert!(found < 1e-11, "{seed}: {found}");
    }
}

/// A and B are differences of the rule's solution.
#[test]
fn derivatives_are_differences_of_the_rule() {
    let dt = 2e-3;
    let (mut floating, mut compared) = (0, 0);
    for (seed, (model, State { q, qd, tau, .. })) in robots(30).enumerate() {
        let n = model.nv();
        if n > 8 {
            continue;
        }
        compared += 1;
        floating += usize::from(model.nq() > n);
        let mut robot = Interpreter::new(model.clone());
        let [next_q, next_qd, a, b] = derivatives(&mut robot, [&q, &qd, &tau], dt);
        let stepped = step(&mut robot, [&q, &qd, &tau], dt);
        assert_close("coordinates", &next_q, &stepped[0], 1e-12);
        assert_close("velocities", &next_qd, &stepped[1], 1e-12);
        let h = 1e-4;
        let plus = |x: &[f64], k: usize, h: f64| -> Vec<f64> {
            let mut x = x.to_vec();
            x[k] += h;
            x
        };
        let moved = |k: usize, h: f64| -> Vec<f64> {
            let mut v = vec![0.0; n];
            v[k] = h;
            displaced(&model, &q, &v)
        };
        let column = |at: &dyn Fn(f64) -> [Vec<f64>; 2]| -> Vec<f64> {
            let (ahead, back) = (at(h), at(-h));
            let moved = small_difference(&model, &back[0], &ahead[0]);
            let rates = combined(&ahead[1], -1.0, &back[1]);
            moved.into_iter().chain(rates).map(|x| x / (2.0 * h)).collect()
        };
        let by_q = |k| column(&|h| converged(&model, [&moved(k, h), &qd, &tau], dt));
        let by_qd = |k| column(&|h| converged(&model, [&q, &plus(&qd, k, h), &tau], dt));
        let by_tau = |k| column(&|h| converged(&model, [&q, &qd, &plus(&tau, k, h)], dt));
        let expected: Vec<f64> = (0..n).flat_map(by_q).chain((0..n).flat_map(by_qd)).collect();
        assert_close(&format!("{seed}: A"), &a, &expected, 1e-6);
        let expected: Vec<f64> = (0..n).flat_map(by_tau).collect();
        assert_close(&format!("{seed}: B"), &b, &expected, 1e-6);
    }
    assert!(compared >= 10 && floating >= 2, "{compared} robots, {floating} with quaternions");
}

/// Energy does not drift over 10,000 steps of a robot without dissipation. Robots with floating bases do not fall.
#[test]
fn energy_does_not_drift() {
    for seed in 0..6 {
        let model = random::general_tree(seed, 2 + usize::try_from(seed % 3).expect("a digit"));
        let model = match seed % 2 {
            0 => model,
            _ => floated(&model, Random::new(seed).inertial())
                .with_gravity([0.0; 3])
                .expect("a gravity"),
        };
        let State { q, qd, .. } = random::state(seed, &model);
        let tau = vec![0.0; model.nv()];
        let mut robot = Interpreter::new(model);
        // The largest kinetic energy, and the largest change of the energy in the first and the last tenth.
        let changes = |robot: &mut Interpreter, implicit: bool| {
            let mut state = [q.clone(), qd.clone()];
            let energy = |robot: &mut Interpreter, [q, qd]: &[Vec<f64>; 2]| {
                let kinetic = robot.kinetic(q, qd);
                (kinetic, kinetic + robot.potential(q))
            };
            let (mut most, start) = energy(robot, &state);
            let mut changes = [0.0_f64; 2];
            for k in 0..10_000 {
                let [q, qd] = &state;
                if implicit {
                    state = step(robot, [q, qd, &tau], 1e-3);
                } else {
                    let (mut next_q, mut next_qd) = (q.clone(), qd.clone());
                    let input = TimeStepInput { q, qd, tau: &tau, dt: 1e-3 };
                    robot.step_semi_implicit(input, &mut next_q, &mut next_qd).expect(LENGTHS);
                    state = [next_q, next_qd];
                }
                let (kinetic, now) = energy(robot, &state);
                most = most.max(kinetic);
                if let Some(change) =
                    [(0, 0..1000), (1, 9000..10_000)].iter().find(|(_, steps)| steps.contains(&k))
                {
                    changes[change.0] = changes[change.0].max((now - start).abs());
                }
            }
            (most, changes)
        };
        let (most, [first, last]) = changes(&mut robot, true);
        let (_, [other, _]) = changes(&mut robot, false);
        assert!(last < 1e-5 * most, "{seed}: {last} of {most}");
        assert!(20.0 * first < other, "{seed}: {first}, semi-implicit {other}");
    }
}

/// Returns the robot with dampers at all joints, without gravity.
fn damped(model: &Model, damping: f64) -> Model {
    let mut links = model.moving_links().to_vec();
    for link in &mut links {
        link.joint.dynamics = JointDynamics { damping, ..link.joint.dynamics };
    }
    Model::new(model.name(), [0.0; 3], links, model.links().to_vec())
        .and_then(|model| model.with_joint_friction(JointFriction::Viscous))
        .unwrap_or_else(|errors| panic!("{errors:?}"))
}

/// Stiff dampers stop a robot, where semi-implicit steps of the same length explode.
#[test]
fn stiff_damping_is_stable() {
    for seed in 0..8 {
        let model = damped(&random::general_tree(seed, 4), 2000.0);
        let State { q, qd, .. } = random::state(seed, &model);
        let tau = vec![0.0; model.nv()];
        let mut robot = Interpreter::new(model);
        let start = robot.kinetic(&q, &qd);
        let (mut state, mut energies) = ([q.clone(), qd.clone()], Vec::new());
        for _ in 0..400 {
            state = step(&mut robot, [&state[0], &state[1], &tau], 0.01);
            energies.push(robot.kinetic(&state[0], &state[1]));
        }
        let most = energies.iter().copied().fold(0.0, f64::max);
        assert!(most < 1.01 * start && energies[399] < 0.1 * start, "{seed}: {start} {most}");
        let mut exploding = [q.clone(), qd.clone()];
        for _ in 0..3 {
            let (mut next_q, mut next_qd) = (q.clone(), qd.clone());
            let [q, qd] = &exploding;
            let input = TimeStepInput { q, qd, tau: &tau, dt: 0.01 };
            robot.step_semi_implicit(input, &mut next_q, &mut next_qd).expect(LENGTHS);
            exploding = [next_q, next_qd];
        }
        let energy = robot.kinetic(&exploding[0], &exploding[1]);
        assert!(energy > 1e3 * start, "{seed}: {energy} after {start}");
    }
}

/// Without a time there is no step.
#[test]
fn steps_of_no_time_stay() {
    for (model, State { q, qd, tau, .. }) in robots(6) {
        let n = model.nv();
        let mut robot = Interpreter::new(model);
        let [next_q, next_qd, a, b] = derivatives(&mut robot, [&q, &qd, &tau], 0.0);
        assert_close("coordinates", &next_q, &q, 1e-15);
        assert_close("velocities", &next_qd, &qd, 1e-15);
        let identity: Vec<f64> =
            (0..4 * n * n).map(|k| if k % (2 * n + 1) == 0 { 1.0 } else { 0.0 }).collect();
        assert_close("A", &a, &identity, 1e-15);
        assert!(b.iter().all(|&x| x == 0.0));
    }
}

#[test]
fn lengths_are_checked() {
    let (model, State { q, qd, tau, .. }) = robots(1).next().expect("a robot");
    let mut robot = Interpreter::new(model);
    let (mut next_q, mut next_qd, n) = (q.clone(), qd.clone(), qd.len());
    let found = robot.step_implicit_midpoint(
        TimeStepInput { q: &q, qd: &qd, tau: &[], dt: 0.1 },
        &mut next_q,
        &mut next_qd,
    );
    assert_eq!(found, Err(ShapeError::new("tau", n, 0)));
    let outputs = StepOutputs { q: &mut next_q, qd: &mut next_qd, a: &mut [], b: &mut [] };
    let found = robot.step_implicit_midpoint_derivatives(
        TimeStepInput { q: &q, qd: &qd, tau: &tau, dt: 0.1 },
        outputs,
    );
    assert_eq!(found, Err(ShapeError::new("a", 4 * n * n, 0)));
}
