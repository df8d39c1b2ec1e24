//! Joint stops and effort limits.

use modyn::ContactTarget;
use modyn::simulate::{Ground, State, limit_effort};

use super::{Block, STANDING, STEP, on};

// The leader's range is -1 to 1 rad; the limits of the follower, -0.2 <= 0.1 - 0.6 q <= 0.35 rad, are narrower. The third
// joint has limits that contradict its leader's, -1 <= q - 3 <= 1 rad, and that do not count.
modyn::modyn! {
    "../mechanisms/mimic_stops.urdf",
    functions = [default, contact_problem],
    contacts = ["tip": point("second", [0.1, 0.0, 0.0])]
}

/// The flap falls onto its stop, stays there, and the stop carries its weight; without limits it falls through.
#[test]
fn a_joint_stops_at_its_limit() {
    let mut q = Block::NEUTRAL;
    q[2] = STANDING;
    let settings = on(ContactTarget::<f64>::GROUND);
    for joint_limits in [true, false] {
        let ground = Ground { joint_limits, ..Ground::default() };
        let mut state = State::<Block>::at_rest(q);
        let (mut range, mut stops) = ([0.0_f64; 2], [0.0; 7]);
        for _ in 0..700 {
            let step = state.step_on_ground(STEP, &[0.0; 7], &ground, &settings);
            (state, stops) = (step.state, step.stops);
            range = [range[0].min(state.q[7]), range[1].max(state.q[7])];
        }
        if joint_limits {
            assert!(range[0] > -0.4 - 1e-9 && range[1] < 0.7 + 1e-9, "{range:?}");
            let needed = Block::gravity_torques(&state.q)[6];
            assert!(state.qd[6].abs() < 1e-6 && needed.abs() > 0.05);
            assert!((stops[6] - needed).abs() < 1e-3, "{} N m of {needed} N m", stops[6]);
        } else {
            assert!(range[0] < -0.4 || range[1] > 0.7, "{range:?}");
            assert_eq!(stops, [0.0; 7]);
        }
    }
}

/// A joint that starts beyond its limit returns at the rate of the settings, and is not thrown back within a step.
#[test]
fn a_joint_beyond_its_limit_returns_slowly() {
    let settings = on(ContactTarget::<f64>::GROUND);
    for (start, limit) in [(0.9, 0.7), (-0.6, -0.4)] {
        let mut q = Block::NEUTRAL;
        (q[2], q[7]) = (STANDING, start);
        let mut state = State::<Block>::at_rest(q);
        let mut fastest = 0.0_f64;
        for _ in 0..20 {
            state = state.step_on_ground(STEP, &[0.0; 7], &Ground::default(), &settings).state;
            fastest = fastest.max(state.qd[6].abs());
        }
        assert!((state.q[7] - limit).abs() < (start - limit).abs() - 0.05, "{state:?}");
        assert!(fastest < 1.5 * settings.beta * 0.2, "{fastest} rad/s");
    }
}

/// A flap hits its stop, which throws the block about on its corners. Too few iterations leave velocities wrong, and the step
/// says how large they are.
#[test]
fn the_residual_falls_with_the_iterations() {
    let mut q = Block::NEUTRAL;
    (q[2], q[7]) = (STANDING, 0.7);
    let mut state = State::<Block>::at_rest(q);
    state.qd[6] = 5.0;
    let settings = on(ContactTarget::<f64>::GROUND);
    let residuals = [(0, 0), (1, 0), (1, 4), (1, 40)].map(|(sweeps, newton_steps)| {
        let ground = Ground { sweeps, newton_steps, ..Ground::default() };
        let step = state.step_on_ground(STEP, &[0.0; 7], &ground, &settings);
        step.residual
    });
    let largest = residuals.map(|found| found.stops.max(found.contacts));
    assert!((residuals[0].stops - 5.0).abs() < 0.5, "rad/s that the stop takes: {residuals:?}");
    assert!(largest[..3].is_sorted_by(|a, b| a > b) && largest[3] < 1e-9, "{residuals:?}");
}

#[test]
fn efforts_stay_within_their_limits() {
    let tau = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 1.4];
    assert_eq!(limit_effort::<Block, f64>(&tau), tau);
    for (force, limited) in [(7.0, 1.5), (-7.0, -1.5), (f64::INFINITY, 1.5)] {
        let mut tau = tau;
        tau[6] = force;
        assert_eq!(limit_effort::<Block, f64>(&tau)[6], limited);
    }
}

/// The joint stops where its follower reaches a limit. The stop carries the weight of both.
#[test]
fn a_joint_stops_where_a_joint_that_mimics_it_is_at_its_limit() {
    let range = [(0.1 - 0.35) / 0.6, (0.1 + 0.2) / 0.6];
    let [lower, upper] = [MimicStops::LIMITS.lower, MimicStops::LIMITS.upper];
    assert!((lower[0] - range[0]).abs() < 1e-15 && (upper[0] - range[1]).abs() < 1e-15);
    // Far below.
    let mut target = ContactTarget::<f64>::GROUND;
    target.pose.translation[2] = -10.0;
    for (side, sign) in [1.0, -1.0].into_iter().enumerate() {
        let mut state = State::<MimicStops>::at_rest(MimicStops::NEUTRAL);
        let ground = Ground::default();
        let push = [sign * 3.0];
        let (mut reached, mut stops) = ([0.0_f64; 2], [0.0]);
        for _ in 0..1000 {
            let step = state.step_on_ground(STEP, &push, &ground, &on(target));
            (state, stops) = (step.state, step.stops);
            reached = [reached[0].min(state.q[0]), reached[1].max(state.q[0])];
        }
        let bound = range[1 - side];
        assert!((state.q[0] - bound).abs() < 1e-9 && state.qd[0].abs() < 1e-9, "{state:?}");
        assert!(reached[0] > range[0] - 1e-9 && reached[1] < range[1] + 1e-9, "{reached:?}");
        let needed = MimicStops::gravity_torques(&state.q)[0] - push[0];
        assert!((stops[0] - needed).abs() < 1e-6, "{} N m of {needed} N m", stops[0]);
    }
}
