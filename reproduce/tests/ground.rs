//! Robots on the ground: a drop, a bounce, a block that slides and one that stays, joint stops, a quadruped that stands.

use modyn::simulate::{Ground, SpringGround, State, limit_effort};
use modyn::spatial::{Pose, Vector3};
use modyn::{ConstraintSettings, ContactTarget, Robot};

modyn::modyn! {
    "mechanisms/block.urdf",
    base = floating,
    functions = [default, constraint_jacobian],
    contacts = [
        "a": point("body", [0.15, 0.1, -0.05]),
        "b": point("body", [-0.15, 0.1, -0.05]),
        "c": point("body", [0.15, -0.1, -0.05]),
        "d": point("body", [-0.15, -0.1, -0.05]),
    ]
}

modyn::modyn! {
    "../../robots/quadruped.urdf",
    base = floating,
    functions = [default, constraint_jacobian],
    contacts = [
        "fl": point("front_left_foot"),
        "fr": point("front_right_foot"),
        "hl": point("hind_left_foot"),
        "hr": point("hind_right_foot"),
    ]
}

type Settings = ConstraintSettings<f64, [ContactTarget<f64>; 4]>;

const GRAVITY: f64 = 9.81;
const STEP: f64 = 0.001;
/// The height of the block's origin on the ground, m.
const STANDING: f64 = 0.05;
/// The stiffness and the damping that hold the flap, N m/rad and N m s/rad.
const HINGE: [f64; 2] = [10.0, 0.1];

/// Returns the rotation by the angle about an axis: the matrix by rows, and the quaternion x y z w.
fn rotation(axis: [f64; 3], angle: f64) -> ([[f64; 3]; 3], [f64; 4]) {
    let axis = nalgebra::Unit::new_normalize(nalgebra::Vector3::from(axis));
    let quaternion = nalgebra::UnitQuaternion::from_axis_angle(&axis, angle);
    let matrix = quaternion.to_rotation_matrix();
    let rows = core::array::from_fn(|i| core::array::from_fn(|j| matrix[(i, j)]));
    (rows, quaternion.coords.into())
}

/// Returns settings with this ground under all contacts.
fn on(ground: ContactTarget<f64>) -> Settings {
    ConstraintSettings { contacts: [ground; 4], ..Settings::DEFAULT }
}

/// Returns the torque that holds the flap at angle zero.
fn hold(state: &State<Block>) -> [f64; 7] {
    let [stiffness, damping] = HINGE;
    [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -stiffness * state.q[7] - damping * state.qd[6]]
}

/// Returns the heights of the contacts above their targets, m.
fn heights<R>(state: &State<R>, settings: &Settings) -> [f64; 4]
where
    R: Robot<PerContact<ContactTarget<f64>> = [ContactTarget<f64>; 4]>
        + modyn::functions::ConstraintResidual,
{
    let found = R::constraint_residual(&state.q, &state.qd, settings).displacements;
    core::array::from_fn(|k| {
        let normal = Vector3(settings.contacts[k].pose.rotation.map(|row| row[2]));
        normal.dot(found.as_ref()[k].linear)
    })
}

fn energy(state: &State<Block>) -> f64 {
    let spring = HINGE[0] * state.q[7] * state.q[7] / 2.0;
    Block::kinetic_energy(&state.q, &state.qd) + Block::potential_energy(&state.q) + spring
}

/// A block that falls in a general orientation loses energy alone, comes to rest flat on the ground, and the ground then
/// carries its weight.
#[test]
fn a_block_that_falls_comes_to_rest() {
    let (_, quaternion) = rotation([0.3, 1.0, -0.4], 0.6);
    let mut q = Block::NEUTRAL;
    q[2] = 0.4;
    q[3..7].copy_from_slice(&quaternion);
    let mut state = State::<Block>::at_rest(q);
    let (settings, ground) = (on(ContactTarget::<f64>::GROUND), Ground::with_friction(0.6));
    let (mut most, mut deepest) = (energy(&state), 0.0_f64);
    let start = most;
    let mut carried = 0.0;
    for _ in 0..1200 {
        let step = state.step_on_ground(STEP, &hold(&state), &ground, &settings);
        state = step.state;
        carried = step.forces.iter().map(|force| force[2]).sum();
        assert!(step.forces.iter().all(|force| force[2] >= 0.0), "the ground pulls");
        // Free fall of semi-implicit Euler is off by m g v dt / 2.
        assert!(energy(&state) < most + 0.03, "{} J after {most} J", energy(&state));
        most = most.min(energy(&state));
        deepest = heights(&state, &settings).into_iter().fold(deepest, f64::min);
    }
    assert!(deepest > -0.01, "{deepest} m in the ground");
    assert!(heights(&state, &settings).iter().all(|h| h.abs() < 1e-4), "{state:?}");
    assert!(state.qd.iter().all(|v| v.abs() < 1e-3), "{state:?}");
    assert!(energy(&state) < start - 5.0);
    let weight = 2.3 * GRAVITY;
    assert!((carried - weight).abs() < 1e-3 * weight, "{carried} N of {weight} N");
}

/// All corners leave the ground at `restitution` times the speed of their impact.
#[test]
fn a_bounce_keeps_the_share_of_the_speed() {
    let restitution = 0.7;
    let (rows, quaternion) = rotation([0.6, -0.8, 0.3], 0.4);
    let pose = Pose { rotation: rows, translation: [0.1, 0.2, -0.3] };
    let settings = on(ContactTarget { pose, restitution, ..ContactTarget::<f64>::GROUND });
    let mut q = Block::NEUTRAL;
    (0..3).for_each(|k| q[k] = pose.translation[k] + (STANDING + 0.1) * rows[k][2]);
    q[3..7].copy_from_slice(&quaternion);
    let mut state = State::<Block>::at_rest(q);
    let (ground, step) = (Ground::with_friction(0.5), 1e-4);
    let speeds = |state: &State<Block>| {
        let found = Block::constraint_residual(&state.q, &state.qd, &settings).velocities;
        found.map(|velocity| Vector3(rows.map(|row| row[2])).dot(velocity.linear))
    };
    let before = loop {
        let before = speeds(&state);
        assert!(before.iter().all(|&speed| speed > -3.0), "the block passes the ground");
        state = state.step_on_ground(step, &hold(&state), &ground, &settings).state;
        if speeds(&state)[0] > 0.0 {
            break before;
        }
    };
    for (after, before) in speeds(&state).into_iter().zip(before) {
        assert!(before < -1.0, "{before} m/s");
        assert!((after + restitution * before).abs() < 1e-3, "{after} m/s after {before} m/s");
    }
}

/// Coulomb friction stops a block after v^2 / (2 mu g), on a plane in general position whose normal is against gravity's
/// only in part: there it slides down with g (sin - mu cos).
#[test]
fn a_block_slides_as_coulomb_says() {
    let (speed, friction) = (1.5, 0.35);
    let mut q = Block::NEUTRAL;
    q[2] = STANDING;
    let (_, quaternion) = rotation([0.0, 0.0, 1.0], 0.8);
    q[3..7].copy_from_slice(&quaternion);
    let mut state = State::<Block>::at_rest(q);
    state.qd[0] = 0.6 * speed;
    state.qd[1] = 0.8 * speed;
    let (settings, ground) = (on(ContactTarget::<f64>::GROUND), Ground::with_friction(friction));
    for _ in 0..600 {
        state = state.step_on_ground(STEP, &hold(&state), &ground, &settings).state;
    }
    let distance = f64::hypot(state.q[0], state.q[1]);
    let expected = speed * speed / (2.0 * friction * GRAVITY);
    assert!((distance - expected).abs() < 0.01 * expected, "{distance} m, expected {expected} m");
    assert!(state.qd[..6].iter().all(|v| v.abs() < 1e-3), "{state:?}");
}

#[test]
fn a_slope_holds_a_block_up_to_the_angle_of_friction() {
    let (angle, time) = (0.5_f64, 0.6);
    let (rows, quaternion) = rotation([0.6, -0.8, 0.0], angle);
    let place = [0.3, -0.2, 0.7];
    let normal = rows.map(|row| row[2]);
    let pose = Pose { rotation: rows, translation: place };
    let settings = on(ContactTarget { pose, ..ContactTarget::<f64>::GROUND });
    let mut q = Block::NEUTRAL;
    (0..3).for_each(|k| q[k] = place[k] + STANDING * normal[k]);
    q[3..7].copy_from_slice(&quaternion);
    for friction in [0.2, 0.8] {
        let mut state = State::<Block>::at_rest(q);
        let ground = Ground::with_friction(friction);
        let steps = 300;
        for _ in 0..steps {
            let dt = time / f64::from(steps);
            state = state.step_on_ground(dt, &hold(&state), &ground, &settings).state;
        }
        let moved: f64 = (0..3).map(|k| (state.q[k] - q[k]).powi(2)).sum::<f64>().sqrt();
        let acceleration = GRAVITY * (angle.sin() - friction * angle.cos());
        let expected = acceleration.max(0.0) * time * time / 2.0;
        assert!(
            (moved - expected).abs() < 0.01 * expected + 1e-3,
            "{moved} m, expected {expected} m"
        );
        assert!(heights(&state, &settings).iter().all(|h| h.abs() < 1e-4));
    }
}

/// The flap falls onto its stop, stays there, and the stop carries its weight; without limits it falls through.
#[test]
fn a_joint_stops_at_its_limit() {
    let mut q = Block::NEUTRAL;
    q[2] = STANDING;
    let settings = on(ContactTarget::<f64>::GROUND);
    for joint_limits in [true, false] {
        let ground = Ground { joint_limits, ..Ground::with_friction(0.9) };
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

/// Returns bent legs with the feet on the ground, and the torques that hold them.
fn posture() -> [f64; 19] {
    let mut q = Quadruped::NEUTRAL;
    for leg in 0..4 {
        let bend = if leg < 2 { 0.6 } else { -0.6 };
        q[7 + 3 * leg + 1] = bend;
        q[7 + 3 * leg + 2] = -2.0 * bend;
    }
    let lowest = heights(&State::<Quadruped>::at_rest(q), &on(ContactTarget::<f64>::GROUND));
    q[2] = 0.02 - lowest.into_iter().fold(f64::INFINITY, f64::min);
    q
}

fn hold_legs(state: &State<Quadruped>, posture: &[f64; 19]) -> [f64; 18] {
    let error = Quadruped::difference(&state.q, posture);
    core::array::from_fn(|i| if i < 6 { 0.0 } else { 20.0 * error[i] - 0.4 * state.qd[i] })
}

/// It falls from 2 cm, stands, and its feet neither sink nor slip. Steps are 2 ms.
#[test]
fn a_quadruped_stands() {
    let posture = posture();
    let mut state = State::<Quadruped>::at_rest(posture);
    let (settings, ground) = (on(ContactTarget::<f64>::GROUND), Ground::with_friction(0.8));
    let (mut carried, mut deepest) = (0.0, 0.0_f64);
    for _ in 0..600 {
        let step = state.step_on_ground(0.002, &hold_legs(&state, &posture), &ground, &settings);
        (state, carried) = (step.state, step.forces.iter().map(|force| force[2]).sum());
        deepest = heights(&state, &settings).into_iter().fold(deepest, f64::min);
    }
    let weight = Quadruped::gravity_torques(&Quadruped::NEUTRAL)[2];
    assert!((carried - weight).abs() < 1e-3 * weight, "{carried} N of {weight} N");
    assert!(state.qd.iter().all(|v| v.abs() < 1e-3), "{:?}", state.qd);
    assert!(deepest > -2e-3, "{deepest} m");
    assert!(heights(&state, &settings).iter().all(|h| h.abs() < 1e-4));
    assert!(
        state.q[2] > 0.2 && state.q[0].abs() < 0.05 && state.q[1].abs() < 0.05,
        "{:?}",
        state.q
    );
}

/// The force of the soft ground, in a plane in general position.
#[test]
fn a_soft_ground_pushes_along_its_normal_and_against_sliding() {
    let (rows, _) = rotation([0.3, -0.7, 0.5], 1.1);
    let columns = [0, 1, 2].map(|k| Vector3(rows.map(|row| row[k])));
    let place = Vector3([0.2, 0.1, -0.4]);
    let plane = Pose { rotation: rows, translation: place.0 };
    let ground =
        SpringGround { plane, stiffness: 1000.0, damping: 10.0, friction: 0.5, slip: 0.01 };
    let at = |depth: f64| place + columns[0].scale(0.3) - columns[2].scale(depth);
    let close = |a: Vector3<f64>, b: Vector3<f64>| {
        let difference = a - b;
        assert!(difference.dot(difference) < 1e-18, "{a:?} instead of {b:?}");
    };
    close(ground.force(at(-0.1), columns[2].scale(-3.0)), Vector3([0.0; 3]));
    close(ground.force(at(0.01), columns[2].scale(-0.2)), columns[2].scale(10.0 + 2.0));
    close(ground.force(at(0.01), columns[2].scale(5.0)), Vector3([0.0; 3]));
    let sliding = ground.force(at(0.01), columns[1].scale(0.01));
    let drag = 0.5 * 10.0 * 0.5_f64.sqrt();
    close(sliding, columns[2].scale(10.0) - columns[1].scale(drag));
}
