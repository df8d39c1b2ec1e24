//! Rollouts give what the interpreter's steps give in a loop, on any available processor.
//!
//! Rounding errors of a step grow over the next steps, by factors that depend on the robot and its motion. So the bounds
//! come from the interpreter: from the distance of motions that are disturbed in each step by errors of single precision.

use crate::common;
use modyn_runtime::equations::TimeStepInput;

use modyn_codegen::{Base, Builder, Function, RolloutForces, RolloutOptions};
use modyn_gpu::{Gpu, GpuError, Rollout, RolloutArguments};
use modyn_runtime::Interpreter;

use crate::conformance::robot;
use common::{columns, numbers};

const ROLLOUTS: usize = 70;
const STEPS: usize = 25;
const DT: f32 = 0.004;

/// The relative error of a step in single precision: sums of some terms, and sines with errors of 4e-7.
const ERROR: f64 = 6e-7;

/// The joint forces of a state (q, qd) and controls.
type Forces<'a> = dyn Fn(&mut Interpreter<f64>, &[f64], &[f64], &[f64]) -> Vec<f64> + 'a;

/// The cost of a state (q, qd), the controls and the number of the step before it.
type Cost<'a> = dyn Fn(&mut Interpreter<f64>, &[f64], &[f64], &[f64], usize) -> f64 + 'a;

/// The functions of the user.
struct User<'a> {
    forces: &'a Forces<'a>,
    cost: &'a Cost<'a>,
}

/// Returns the states after the steps, q and then qd, and the cost as the last number of all. `noise` disturbs each step.
fn motion(
    interpreter: &mut Interpreter<f64>,
    start: (&[f64], &[f64]),
    controls: &[&[f64]],
    user: &User<'_>,
    noise: Option<&[f64]>,
) -> Vec<f64> {
    let (mut q, mut qd) = (start.0.to_vec(), start.1.to_vec());
    let (nq, nv) = (q.len(), qd.len());
    let (mut all, mut cost) = (Vec::new(), 0.0);
    let mut noise = noise.map(|noise| noise.iter().cycle());
    let mut draw = || noise.as_mut().and_then(Iterator::next).map_or(0.0, |x| ERROR * x);
    for (k, u) in controls.iter().enumerate() {
        let mut tau = (user.forces)(interpreter, &q, &qd, u);
        let mut bias = vec![0.0; nv];
        interpreter.bias_forces(&q, &qd, &mut bias).expect("lengths");
        let scale = tau.iter().chain(&bias).fold(0.0, |most: f64, x| most.max(x.abs()));
        for x in &mut tau {
            *x += draw() * scale;
        }
        let (mut next_q, mut next_qd) = (vec![0.0; nq], vec![0.0; nv]);
        let input = TimeStepInput { q: &q, qd: &qd, tau: &tau, dt: f64::from(DT) };
        interpreter.step_semi_implicit(input, &mut next_q, &mut next_qd).expect("lengths");
        for x in next_q.iter_mut().chain(&mut next_qd) {
            *x += draw() * x.abs().max(1.0);
        }
        (q, qd) = (next_q, next_qd);
        cost += (user.cost)(interpreter, &q, &qd, u, k);
        all.extend(q.iter().chain(&qd));
    }
    all.push(cost);
    all
}

fn compare(
    name: &str,
    builder: &Builder,
    options: &RolloutOptions,
    starts: usize,
    user: &User<'_>,
) {
    let gpu = Gpu::new().expect("a processor: Mesa has one in software");
    let rollout = Rollout::new(&gpu, builder, options).expect("kernels");
    let source = rollout.source();
    let [nq, nv, nu] = [source.nq, source.nv, source.rollouts[0].controls];
    let mut interpreter = Interpreter::<f64>::new(builder.generate().expect("good").model);
    let mut random = numbers(starts * (nq + nv) + ROLLOUTS * STEPS * nu + 997).into_iter();
    let mut vector = |n: usize| random.by_ref().take(n).collect::<Vec<f64>>();
    let single = |x: &f64| f64::from(*x as f32);
    let (mut q, mut qd, mut controls) = (vec![], vec![], vec![]);
    for _ in 0..starts {
        let mut unit = vector(nq);
        interpreter.normalize_configuration(&mut unit).expect("lengths");
        q.push(unit.iter().map(single).collect::<Vec<_>>());
        qd.push(vector(nv));
    }
    for _ in 0..ROLLOUTS {
        controls.push(vector(STEPS * nu));
    }
    let noise = vector(997);
    let upload = |states: &[Vec<f64>]| gpu.upload(&columns(states), states.len()).expect("room");
    let (gq, gqd, gu) = (upload(&q), upload(&qd), upload(&controls));
    let data = gpu.upload(&[0.7, 0.3, 0.2, -0.4, 0.9], 1).expect("room");
    let gravity = gpu.upload(&[0.3, -0.8, -9.1], 1).expect("room");
    let has_functions = options.cost.is_some() || options.forces.is_some();
    let arguments = RolloutArguments {
        data: has_functions.then_some(&data),
        parameters: (source.parameters > 0).then_some(&gravity),
        trajectory: true,
        ..RolloutArguments::new(&gq, &gqd, &gu, DT)
    };
    let results = rollout.run(&arguments).expect("it runs");
    let state = results.state.read().expect("numbers");
    let trajectory = results.trajectory.expect("it was asked for").read().expect("numbers");
    let cost = results.cost.map(|cost| cost.read().expect("numbers"));
    let without =
        rollout.run(&RolloutArguments { trajectory: false, ..arguments }).expect("it runs");
    assert!(without.trajectory.is_none());
    assert_eq!(without.state.read().expect("numbers"), state);
    let (size, last) = (nq + nv, (STEPS - 1) * (nq + nv));
    let (mut worst, mut moved) = (0.0_f64, 0.0_f64);
    for i in 0..ROLLOUTS {
        let start = (&*q[i % starts], &*qd[i % starts]);
        let u: Vec<&[f64]> = controls[i].chunks(nu).collect();
        let expected = motion(&mut interpreter, start, &u, user, None);
        let mut bounds = vec![0.0_f64; expected.len()];
        for k in 0..6 {
            let disturbed = motion(&mut interpreter, start, &u, user, Some(&noise[151 * k..]));
            for ((bound, x), y) in bounds.iter_mut().zip(&disturbed).zip(&expected) {
                *bound = bound.max((x - y).abs());
            }
        }
        let mut check = |found: f32, j: usize| {
            let scale = 1.0 + expected[j].abs();
            let error = (f64::from(found) - expected[j]).abs() / (8.0 * bounds[j] + 4e-6 * scale);
            worst = worst.max(if error.is_nan() { f64::INFINITY } else { error });
        };
        for j in 0..size {
            check(state[j * ROLLOUTS + i], last + j);
            for k in 0..STEPS {
                check(trajectory[(k * size + j) * ROLLOUTS + i], k * size + j);
            }
            let first = q[i % starts].iter().chain(&qd[i % starts]).nth(j).expect("a scalar");
            moved = moved.max((expected[last + j] - first).abs());
        }
        if let Some(cost) = &cost {
            check(cost[i], STEPS * size);
        }
    }
    assert!(worst < 1.0 && moved > 0.1, "{name}: {worst} of the bound, moved by {moved}");
}

/// The controls are the joint forces.
const PLAIN: User<'static> = User { forces: &|_, _, _, u| u.to_vec(), cost: &|_, _, _, _, _| 0.0 };

#[test]
fn an_arm() {
    let builder = robot("arm7").functions([Function::StepSemiImplicit]);
    compare("arm7", &builder, &RolloutOptions::default(), ROLLOUTS, &PLAIN);
}

#[test]
fn a_floating_quadruped_from_three_states() {
    let builder = robot("quadruped").base(Base::Floating).functions([Function::StepSemiImplicit]);
    compare("quadruped", &builder, &RolloutOptions::default(), 3, &PLAIN);
}

/// Forces and a cost that call functions of the robot, with run-time gravity.
#[test]
fn functions_of_the_user() {
    let functions = [Function::StepSemiImplicit, Function::GravityTorques, Function::LinkPose];
    let builder = robot("arm7").functions(functions).runtime_gravity();
    let forces = "fn forces(q: array<f32, 7>, qd: array<f32, 7>, u: array<f32, 3>, step: u32) -> array<f32, 7> {
        var tau = arm7_gravity_torques(q);
        tau[0] += data[0] * u[0] - data[1] * qd[0];
        tau[1] += data[0] * u[1] - data[1] * qd[1];
        tau[2] += data[0] * u[2] - data[1] * qd[2];
        tau[3] += data[0] * u[0] - data[1] * qd[3];
        tau[4] += data[0] * u[1] - data[1] * qd[4];
        tau[5] += data[0] * u[2] - data[1] * qd[5];
        tau[6] += data[0] * u[0] - data[1] * qd[6];
        return tau;
    }";
    let cost = "fn cost(q: array<f32, 7>, qd: array<f32, 7>, u: array<f32, 3>, step: u32) -> f32 {
        let pose = arm7_link_pose_hand(q);
        let error = vec3<f32>(pose[9] - data[2], pose[10] - data[3], pose[11] - data[4]);
        return dot(error, error) + f32(step + 1u) * data[0] * u[2] * u[2] + qd[6] * data[1];
    }";
    let forces = RolloutForces { text: forces.into(), controls: 3 };
    let options =
        RolloutOptions { cost: Some(cost.into()), forces: Some(forces), active_contacts: None };
    let model = builder.generate().expect("good").model;
    let hand = model.links().iter().position(|link| link.name == "hand").expect("a hand");
    // The interpreter has the gravity of the description: the run-time gravity becomes its own.
    let [small, large, x, y, z] = [0.7_f32, 0.3, 0.2, -0.4, 0.9].map(f64::from);
    let user = User {
        forces: &|i, q, qd, u| {
            let mut tau = vec![0.0; 7];
            i.gravity_torques(q, &mut tau).expect("lengths");
            (0..7).map(|j| tau[j] + small * u[j % 3] - large * qd[j]).collect()
        },
        cost: &|i, q, qd, u, k| {
            let pose = i.link_pose(q, hand).expect("lengths");
            let [a, b, c] = pose.translation;
            let distance = (a - x).powi(2) + (b - y).powi(2) + (c - z).powi(2);
            distance + (k + 1) as f64 * small * u[2] * u[2] + qd[6] * large
        },
    };
    let builder = builder.gravity([0.3, -0.8, -9.1].map(|x: f32| f64::from(x)));
    compare("arm7 with functions", &builder, &options, ROLLOUTS, &user);
}

#[test]
fn arguments_that_do_not_fit_are_refused() {
    let gpu = Gpu::new().expect("a processor");
    let builder = robot("arm6").functions([Function::StepSemiImplicit]);
    let rollout = Rollout::new(&gpu, &builder, &RolloutOptions::default()).expect("kernels");
    let array = |scalars: usize, states| gpu.upload(&vec![0.0; scalars * states], states);
    let (q, u) = (array(6, 2).expect("room"), array(60, 4).expect("room"));
    let good = RolloutArguments::new(&q, &q, &u, DT);
    assert_eq!(rollout.run(&good).expect("it runs").state.states(), 4);
    let refused = |arguments: &RolloutArguments<'_>| {
        rollout.run(arguments).expect_err("it does not fit").to_string()
    };
    let short = array(59, 4).expect("room");
    assert_eq!(
        refused(&RolloutArguments { controls: &short, ..good }),
        "`arm6_rollout_semi_implicit` takes 6 controls a step, and 59 are no whole number of steps"
    );
    let one = array(6, 1).expect("room");
    let error = refused(&RolloutArguments { qd: &one, ..good });
    assert!(error.contains("2 and for 1 states"), "{error}");
    let error = refused(&RolloutArguments { data: Some(&one), ..good });
    assert!(error.contains("takes 0 numbers a state as `data`, not 6"), "{error}");
    let error = refused(&RolloutArguments { step: Function::StepRk4, ..good });
    assert!(error.contains("no kernel `step_rk4`; it has step_semi_implicit"), "{error}");
    // A mistake in the user's text is shown with its place.
    let options = RolloutOptions {
        cost: Some("fn cost(q: array<f32, 6>) -> f32 { return q[0] + unknown; }".into()),
        ..RolloutOptions::default()
    };
    let error = Rollout::new(&gpu, &builder, &options).expect_err("a mistake");
    assert!(
        matches!(&error, GpuError::Device(_)) && error.to_string().contains("unknown"),
        "{error}"
    );
}
