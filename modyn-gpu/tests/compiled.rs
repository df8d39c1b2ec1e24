//! Robots that `modyn!` compiled: the kernels of their types give what their functions give.

use crate::common;

use modyn::{EmbeddedModel, Robot};
use modyn_codegen::{Builder, Function, RolloutOptions};
use modyn_gpu::{Gpu, GpuError, GpuRobot, Rollout, RolloutArguments};

use common::numbers;

modyn::modyn! {
    Arm7 = "../../robots/arm7.urdf",
    functions = [default, step_semi_implicit],
    gravity = [1.0, -2.0, -9.0],
    embed_model = true,
}
modyn::modyn! {
    Quadruped = "../../robots/quadruped.urdf",
    functions = [forward_dynamics, step_semi_implicit],
    base = floating,
    embed_model = true,
}

const STATES: usize = 150;

/// Coordinates, velocities and joint forces.
type States<R> = (Vec<<R as Robot>::Q<f64>>, Vec<<R as Robot>::V<f64>>, Vec<<R as Robot>::V<f64>>);

/// Returns states in general position, with quaternions of length one.
fn states<R: Robot>() -> States<R> {
    use modyn::Array;
    let mut all = numbers(STATES * (R::NQ + 2 * R::NV)).into_iter();
    let mut number = || all.next().expect("as many as needed");
    let (mut q, mut qd, mut tau) = (vec![], vec![], vec![]);
    for _ in 0..STATES {
        let mut state = <R::Q<f64>>::from_fn(|_| number());
        for &(_, at) in R::QUATERNIONS {
            let quaternion = &mut state.as_mut()[at..at + 4];
            let length = quaternion.iter().map(|x| x * x).sum::<f64>().sqrt();
            quaternion.iter_mut().for_each(|x| *x /= length);
        }
        q.push(state);
        qd.push(<R::V<f64>>::from_fn(|_| number()));
        tau.push(<R::V<f64>>::from_fn(|_| number()));
    }
    (q, qd, tau)
}

/// Compares results of the processor with those of the type's function, relative to the largest number of a state.
fn compare<A: AsRef<[f64]>, B: AsRef<[f64]>>(found: &[A], expected: &[B], tolerance: f64) {
    assert_eq!(found.len(), expected.len());
    let mut moved = 0.0_f64;
    for (state, (found, expected)) in found.iter().zip(expected).enumerate() {
        let (found, expected) = (found.as_ref(), expected.as_ref());
        assert_eq!(found.len(), expected.len());
        let largest = expected.iter().fold(1.0, |most: f64, x| most.max(x.abs()));
        for (x, y) in found.iter().zip(expected) {
            let error = (x - y).abs() / largest;
            assert!(error < tolerance, "state {state}: {x} and {y}");
            moved = moved.max(y.abs());
        }
    }
    assert!(moved > 0.1, "nothing moves");
}

fn forward_dynamics<R>(function: impl Fn(&R::Q<f64>, &R::V<f64>, &R::V<f64>) -> R::V<f64>)
where
    R: Robot + EmbeddedModel,
{
    let gpu = Gpu::new().expect("a processor");
    let builder = Builder::new().robot::<R>().functions([Function::ForwardDynamics]);
    let robot = GpuRobot::new(&gpu, &builder).expect("kernels");
    let (q, qd, tau) = states::<R>();
    let expected: Vec<R::V<f64>> = (0..STATES).map(|i| function(&q[i], &qd[i], &tau[i])).collect();
    let [q, qd, tau] = [gpu.upload_states(&q), gpu.upload_states(&qd), gpu.upload_states(&tau)]
        .map(Result::unwrap);
    let found = robot.run("forward_dynamics", &[&q, &qd, &tau]).expect("it runs");
    compare(&found.read_states::<f64, R::V<f64>>().expect("numbers"), &expected, 1e-3);
}

#[test]
fn forward_dynamics_of_compiled_robots() {
    forward_dynamics::<Arm7>(Arm7::forward_dynamics);
    forward_dynamics::<Quadruped>(Quadruped::forward_dynamics);
}

/// Five steps, with the same forces in each.
#[test]
fn rollouts_of_a_compiled_robot() {
    let gpu = Gpu::new().expect("a processor");
    let builder = Builder::new().robot::<Quadruped>().functions([Function::StepSemiImplicit]);
    let rollout = Rollout::new(&gpu, &builder, &RolloutOptions::default()).expect("kernels");
    let (mut q, mut qd, tau) = states::<Quadruped>();
    let (steps, dt) = (5, 0.001_f32);
    let [gq, gqd, gtau] = [gpu.upload_states(&q), gpu.upload_states(&qd), gpu.upload_states(&tau)]
        .map(Result::unwrap);
    let controls = gtau.read().expect("numbers").repeat(steps);
    let controls = gpu.upload(&controls, STATES).expect("room");
    let results = rollout.run(&RolloutArguments::new(&gq, &gqd, &controls, dt)).expect("it runs");
    let found: Vec<[f64; Quadruped::NQ + Quadruped::NV]> =
        results.state.read_states().expect("numbers");
    for _ in 0..steps {
        for ((q, qd), tau) in q.iter_mut().zip(&mut qd).zip(&tau) {
            let next = Quadruped::step_semi_implicit(q, qd, tau, f64::from(dt));
            (*q, *qd) = (next.q, next.qd);
        }
    }
    let expected: Vec<Vec<f64>> = q.iter().zip(&qd).map(|(q, qd)| [&q[..], qd].concat()).collect();
    compare(&found, &expected, 1e-3);
}

#[test]
fn arrays_of_another_length_are_refused() {
    let gpu = Gpu::new().expect("a processor");
    let array = gpu.upload_states(&[[1.0_f64, 2.0], [3.0, 4.0], [5.0, 6.0]]).expect("room");
    assert_eq!((array.scalars(), array.states()), (2, 3));
    assert_eq!(array.read().expect("numbers"), [1.0, 3.0, 5.0, 2.0, 4.0, 6.0]);
    let back: Vec<[f32; 2]> = array.read_states().expect("numbers");
    assert_eq!(back, [[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]]);
    let error = array.read_states::<f32, [f32; 3]>().expect_err("two numbers");
    assert_eq!(error.to_string(), "a state has 2 numbers, and arrays of 3 were asked for");
    let none: &[[f64; 2]] = &[];
    assert!(matches!(gpu.upload_states(none), Err(GpuError::Length { .. })));
}
