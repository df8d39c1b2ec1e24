//! A block that falls, bounces, slides, and stays on a slope.

use modyn::ContactTarget;
use modyn::simulate::{Ground, HeightField, State};
use modyn::spatial::{Pose, Vector3};

use super::{Block, GRAVITY, HINGE, STANDING, STEP, heights, hold, lowest, on, rotation};

/// Returns the energy of the block and of the spring of its flap, J.
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
    let (settings, ground) =
        (on(ContactTarget { friction: 0.6, ..ContactTarget::<f64>::GROUND }), Ground::default());
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
        deepest = deepest.min(lowest(&state, &settings));
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
    let target = ContactTarget { pose, restitution, friction: 0.5, ..ContactTarget::<f64>::GROUND };
    let settings = on(target);
    let mut q = Block::NEUTRAL;
    (0..3).for_each(|k| q[k] = pose.translation[k] + (STANDING + 0.1) * rows[k][2]);
    q[3..7].copy_from_slice(&quaternion);
    let mut state = State::<Block>::at_rest(q);
    let (ground, step) = (Ground::default(), 1e-4);
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

/// Coulomb friction stops a block on level ground after the distance v^2 / (2 mu g).
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
    let (settings, ground) =
        (on(ContactTarget { friction, ..ContactTarget::<f64>::GROUND }), Ground::default());
    for _ in 0..600 {
        state = state.step_on_ground(STEP, &hold(&state), &ground, &settings).state;
    }
    let distance = f64::hypot(state.q[0], state.q[1]);
    let expected = speed * speed / (2.0 * friction * GRAVITY);
    assert!((distance - expected).abs() < 0.01 * expected, "{distance} m, expected {expected} m");
    assert!(state.qd[..6].iter().all(|v| v.abs() < 1e-3), "{state:?}");
}

/// On a height field whose slope is even, a block slides as on a plane of this slope.
#[test]
fn a_block_slides_on_a_height_field_as_on_a_plane() {
    let (slopes, friction) = ([0.3, -0.2], 0.2);
    let (columns, spacing, origin) = (9, [0.5, 0.7], [-2.0, -2.1]);
    let heights: Vec<f64> = (0..9 * 7)
        .map(|k| {
            let place = [f64::from(k % 9), f64::from(k / 9)];
            (0..2).map(|i| slopes[i] * (origin[i] + spacing[i] * place[i])).sum()
        })
        .collect();
    let field = HeightField::new(origin, spacing, columns, &heights).expect("a grid");
    let plane = field.plane([0.1, 0.2]);
    let normal = plane.rotation.map(|row| row[2]);
    let mut q = Block::NEUTRAL;
    (0..3).for_each(|k| q[k] = plane.translation[k] + STANDING * normal[k]);
    let turn =
        nalgebra::Rotation3::from_matrix(&nalgebra::Matrix3::from(plane.rotation).transpose());
    q[3..7].copy_from_slice(nalgebra::UnitQuaternion::from(turn).coords.as_slice());
    let on_plane = on(ContactTarget { pose: plane, friction, ..ContactTarget::<f64>::GROUND });
    let mut states = [State::<Block>::at_rest(q), State::<Block>::at_rest(q)];
    let ground = Ground::default();
    for _ in 0..400 {
        let [a, b] = &mut states;
        *a = a.step_on_ground(STEP, &hold(a), &ground, &on_plane).state;
        let below = field.under::<Block>(&b.q, &on_plane);
        *b = b.step_on_ground(STEP, &hold(b), &ground, &below).state;
    }
    let [a, b] = states.map(|state| state.q);
    let apart = (0..3).map(|k| (a[k] - b[k]).abs()).fold(0.0, f64::max);
    let moved = (0..3).map(|k| (a[k] - q[k]).powi(2)).sum::<f64>().sqrt();
    assert!(moved > 0.05 && apart < 1e-6, "{moved} m, {apart} m apart");
}

/// A block on a slope in general position slides down with the acceleration g (sin - mu cos), or stays if that is
/// negative.
#[test]
fn a_slope_holds_a_block_up_to_the_angle_of_friction() {
    let (angle, time) = (0.5_f64, 0.6);
    let (rows, quaternion) = rotation([0.6, -0.8, 0.0], angle);
    let place = [0.3, -0.2, 0.7];
    let normal = rows.map(|row| row[2]);
    let pose = Pose { rotation: rows, translation: place };
    let mut q = Block::NEUTRAL;
    (0..3).for_each(|k| q[k] = place[k] + STANDING * normal[k]);
    q[3..7].copy_from_slice(&quaternion);
    for friction in [0.2, 0.8] {
        let mut state = State::<Block>::at_rest(q);
        let ground = Ground::default();
        let settings = on(ContactTarget { pose, friction, ..ContactTarget::<f64>::GROUND });
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
