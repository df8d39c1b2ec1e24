//! Simulation and control, written once for any robot: orders of convergence, energies, goals.

use std::f64::consts::PI;

use modyn::simulate::{Gains, Reference, State};
use modyn::{Array, Robot, Scalar, functions};
use modyn_fleet::ROBOTS;
#[cfg(feature = "whole")]
use modyn_fleet::robots::GoldenSolo12Floating;
use modyn_fleet::robots::{
    Arm6, GoldenDoublePendulum, JointZoo, QuadrupedFloatingShared, Zoo7423_7,
};
#[cfg(feature = "whole")]
use modyn_fleet::robots::{Zoo10153_8Loaded, Zoo10153_8LoadedParams};
use modyn_tests::close::assert_close;
use modyn_tests::random;
use modyn_tests::values::array;

/// Runs `check::<Robot>(name, ...)` for a chain, a floating base, and robots with all joint types.
macro_rules! for_robots {
    ($check:ident($($argument:expr),*)) => {
        $check::<Arm6>("arm6" $(, $argument)*);
        $check::<QuadrupedFloatingShared>("quadruped_floating_shared" $(, $argument)*);
        #[cfg(feature = "whole")]
        $check::<GoldenSolo12Floating>("golden_solo12_floating" $(, $argument)*);
        $check::<JointZoo>("joint_zoo" $(, $argument)*);
        $check::<Zoo7423_7>("zoo7423_7" $(, $argument)*);
        #[cfg(feature = "whole")]
        $check::<Zoo10153_8Loaded>("zoo10153_8_loaded" $(, $argument)*);
    };
}

/// Returns a random state of the fleet's robot with this name.
fn state_of(name: &str, seed: u64) -> random::State {
    let robot = ROBOTS.iter().find(|robot| robot.name() == name);
    random::state(seed, &robot.unwrap_or_else(|| panic!("no {name}")).spec.model())
}

fn start<R: Robot>(name: &str) -> State<R> {
    let random::State { q, qd, .. } = state_of(name, 1);
    State { q: array(&q), qd: array(&qd) }
}

/// Returns the friction torques: the part of the bias forces that changes sign with the velocities.
fn dissipation<R: Robot + functions::Defaults>(State { q, qd }: &State<R>) -> R::V<f64> {
    let back = R::V::<f64>::from_fn(|i| -qd.as_ref()[i]);
    let (there, back) = (R::bias_forces(q, qd), R::bias_forces(q, &back));
    R::V::<f64>::from_fn(|i| 0.5 * (there.as_ref()[i] - back.as_ref()[i]))
}

/// Returns the accelerations of free motion without friction.
fn free<R: Robot + functions::Defaults>(state: &State<R>) -> R::V<f64> {
    R::forward_dynamics(&state.q, &state.qd, &dissipation(state))
}

fn energy<R: Robot + functions::Defaults>(State { q, qd }: &State<R>) -> f64 {
    R::kinetic_energy(q, qd) + R::potential_energy(q)
}

/// A function that returns the state after a step.
type Step<R> = fn(&State<R>, f64) -> State<R>;

fn runge_kutta<R: Robot + functions::Defaults>(state: &State<R>, dt: f64) -> State<R> {
    state.runge_kutta_4(dt, free)
}

fn euler<R: Robot + functions::Defaults>(state: &State<R>, dt: f64) -> State<R> {
    state.semi_implicit_euler(dt, free)
}

fn run<R: Robot>(start: State<R>, step: Step<R>, time: f64, steps: u32) -> State<R> {
    let dt = time / f64::from(steps);
    (0..steps).fold(start, |state, _| step(&state, dt))
}

/// Returns the largest difference of coordinates and velocities.
fn distance<R: Robot + functions::Defaults>(a: &State<R>, b: &State<R>) -> f64 {
    let q = R::difference(&a.q, &b.q);
    let qd = a.qd.as_ref().iter().zip(b.qd.as_ref()).map(|(a, b)| a - b);
    q.as_ref().iter().copied().chain(qd).fold(0.0, |worst, x| worst.max(x.abs()))
}

#[test]
fn runge_kutta_is_of_fourth_order() {
    fn check<R: Robot + functions::Defaults>(name: &str) {
        let start = start::<R>(name);
        let end = |steps| run(start, runge_kutta, 0.05, steps);
        let exact = end(320);
        assert!(distance(&start, &exact) > 0.05, "{name} moves");
        let [coarse, fine] = [10, 20].map(|steps| distance(&end(steps), &exact));
        let ratio = coarse / fine;
        assert!((13.0..=20.0).contains(&ratio), "{name}: {coarse:e}, then {fine:e}: {ratio}");
    }
    for_robots!(check());
}

#[test]
fn semi_implicit_euler_is_of_first_order() {
    fn check<R: Robot + functions::Defaults>(name: &str) {
        let start = start::<R>(name);
        let exact = run(start, runge_kutta, 0.05, 80);
        let [coarse, fine] = [100, 200].map(|n| distance(&run(start, euler, 0.05, n), &exact));
        let ratio = coarse / fine;
        assert!((1.8..=2.2).contains(&ratio), "{name}: {coarse:e}, then {fine:e}: {ratio}");
    }
    for_robots!(check());
}

#[test]
fn free_motion_keeps_its_energy() {
    fn check<R: Robot + functions::Defaults>(name: &str) {
        let start = start::<R>(name);
        let end = run(start, runge_kutta, 0.2, 400);
        let drift = (energy(&end) - energy(&start)).abs() / energy(&start).abs().max(1.0);
        assert!(drift < 1e-8, "{name}: {drift:e}");
        // The quaternion keeps its length.
        assert_close(name, R::normalize_configuration(&end.q).as_ref(), end.q.as_ref(), 1e-15);
    }
    for_robots!(check());
}

/// Small oscillations about the hanging position for minutes: the energy oscillates, without drift.
#[test]
fn semi_implicit_euler_keeps_an_oscillation_going() {
    type R = GoldenDoublePendulum;
    let hanging = [PI, 0.0];
    let rest = energy(&State::<R>::at_rest(hanging));
    let mut state = State::<R> { q: hanging, qd: [0.3, -0.2] };
    let kick = energy(&state) - rest;
    assert!(kick > 0.0);
    let mut worst = [0.0_f64; 2];
    for worst in &mut worst {
        for _ in 0..100_000 {
            state = state.semi_implicit_euler(2e-3, free);
            *worst = worst.max((energy(&state) - rest - kick).abs() / kick);
        }
    }
    let [first, later] = worst;
    assert!(first > 0.0 && first < 0.1 && later < 1.5 * first, "{first:e}, then {later:e}");
}

/// A spring of angular frequency w: the motion is bounded for w dt < 2, and diverges beyond.
#[test]
fn semi_implicit_euler_is_stable_up_to_two_over_the_frequency() {
    type R = GoldenDoublePendulum;
    let farthest = |frequency: f64| {
        let mut state = State::<R> { q: [0.1, 0.0], qd: [0.0; 2] };
        let mut farthest: f64 = 0.0;
        for _ in 0..1000 {
            let spring = |state: &State<R>| state.q.map(|q| -frequency * frequency * q);
            state = state.semi_implicit_euler(1.0, spring);
            farthest = farthest.max(state.q[0].abs());
        }
        farthest
    };
    assert!(farthest(1.9) < 1.0, "{:e}", farthest(1.9));
    assert!(farthest(2.1) > 1e10, "{:e}", farthest(2.1));
}

const GAINS: Gains = Gains { kp: 100.0, kd: 20.0 };

#[test]
fn computed_torque_brings_a_robot_to_its_goal() {
    fn check<R: Robot + functions::Defaults>(name: &str) {
        let random::State { q, .. } = state_of(name, 2);
        let goal = Reference::<R>::at_rest(array(&q));
        let mut state = start::<R>(name);
        let far = R::difference(&state.q, &goal.q);
        assert!(far.as_ref().iter().any(|x| x.abs() > 1.0), "{name}");
        for _ in 0..600 {
            state = state.runge_kutta_4(0.01, |at| {
                R::forward_dynamics(&at.q, &at.qd, &at.computed_torque(&goal, GAINS))
            });
        }
        let left = R::difference(&state.q, &goal.q);
        let rest = vec![0.0; R::NV];
        assert_close(name, left.as_ref(), &rest, 1e-9);
        assert_close(name, state.qd.as_ref(), &rest, 1e-9);
    }
    for_robots!(check());
}

#[test]
fn computed_torque_follows_a_motion() {
    type R = JointZoo;
    // Rotation and translation at constant velocities from the neutral configuration.
    let qd: [f64; R::NV] =
        std::array::from_fn(|i| 0.1 + 0.02 * f64::from(u8::try_from(i).expect("few")));
    let reference = |time: f64| Reference::<R> {
        q: R::integrate(&R::NEUTRAL, &qd.map(|velocity| time * velocity)),
        qd,
        qdd: [0.0; R::NV],
    };
    let mut state = State::<R>::at_rest(R::NEUTRAL);
    let (dt, mut time) = (2e-3, 0.0);
    for _ in 0..1500 {
        let goal = reference(time);
        state = state.runge_kutta_4(dt, |at| {
            R::forward_dynamics(&at.q, &at.qd, &at.computed_torque(&goal, GAINS))
        });
        time += dt;
    }
    let left = R::difference(&state.q, &reference(time).q);
    assert_close("behind", &left, &[0.0; R::NV], 2e-3);
    assert_close("velocities", &state.qd, &qd, 2e-2);
}

#[cfg(feature = "whole")]
#[test]
fn a_controller_may_know_the_payload() {
    type R = Zoo10153_8Loaded;
    let random::State { q, .. } = state_of("zoo10153_8_loaded", 2);
    let goal = Reference::<R>::at_rest(array(&q));
    let mut params = Zoo10153_8LoadedParams::DEFAULT;
    params.set_gravity([0.0, 0.0, -1.62]);
    let load = modyn::Inertial { mass: 2.0, center_of_mass: [0.1, 0.2, 0.3], inertia: [0.0; 6] };
    params.set_payload_of_fixed6(load).expect("a rigid body");
    let state = start::<R>("zoo10153_8_loaded");
    let tau = state.computed_torque_with(&params, &goal, GAINS);
    let found = R::forward_dynamics_with(&params, &state.q, &state.qd, &tau);
    let displacement = R::difference(&state.q, &goal.q);
    let wanted: [f64; R::NV] =
        std::array::from_fn(|i| GAINS.stiffness * displacement[i] - GAINS.damping * state.qd[i]);
    assert_close("accelerations", &found, &wanted, 1e-10);
    assert_ne!(tau, state.computed_torque(&goal, GAINS));
}

#[test]
fn single_precision_gets_there_too() {
    type R = Zoo7423_7;
    let single = |x: &[f64]| x.iter().map(|&x| f32::from_f64(x)).collect::<Vec<_>>();
    let goal: <R as Robot>::Q<f32> = array(&single(&state_of("zoo7423_7", 2).q));
    let goal = Reference::<R, f32>::at_rest(goal);
    let mut state = State::<R, f32>::at_rest(array(&single(&state_of("zoo7423_7", 1).q)));
    let gains = Gains { kp: 100.0, kd: 20.0 };
    for _ in 0..400 {
        state = state.runge_kutta_4(0.01, |at| {
            let tau = at.computed_torque(&goal, gains);
            <R as Robot>::forward_dynamics(&at.q, &at.qd, &tau)
        });
    }
    let left = <R as Robot>::difference(&state.q, &goal.q);
    assert!(left.iter().all(|x| x.abs() < 1e-3), "{left:?}");
}

#[test]
fn states_can_be_looked_at() {
    let state = State::<GoldenDoublePendulum>::at_rest([1.0, 2.0]);
    assert_eq!(format!("{state:?}"), "State { q: [1.0, 2.0], qd: [0.0, 0.0] }");
    let reference = Reference::<GoldenDoublePendulum>::at_rest([1.0, 2.0]);
    let expected = "Reference { q: [1.0, 2.0], qd: [0.0, 0.0], qdd: [0.0, 0.0] }";
    assert_eq!(format!("{reference:?}"), expected);
}
