//! Conversions against numerical derivatives of a motion, and round trips.

use core::f64::consts::PI;

use super::floating::{concatenate, halves, joint_rotation, quaternion};
use super::*;
use crate::Scalar;
use crate::spatial::{Quaternion, Vector3};

fn close<const N: usize>(numbers: [f64; N], expected: [f64; N], within: f64) {
    for i in 0..N {
        assert!((numbers[i] - expected[i]).abs() <= within, "{numbers:?} instead of {expected:?}");
    }
}

fn dot(a: [f64; 6], b: [f64; 6]) -> f64 {
    core::array::from_fn::<f64, 6, _>(|i| a[i] * b[i]).iter().sum()
}

/// Returns the coordinates at time `t` of a smooth motion; the joint's frame is the world.
fn motion(t: f64) -> [f64; 7] {
    let (s, c) = t.sin_cos();
    let [x, y, z, w] = [0.4 * s, 0.3 + 0.2 * c, 0.5 * t, 0.8 - 0.3 * s];
    let length = Scalar::sqrt(x * x + y * y + z * z + w * w);
    let [x, y, z, w] = [x, y, z, w].map(|number| number / length);
    [s + t, 2.0 * c, t * t - s, x, y, z, w]
}

/// Returns the time derivative of `of` at `t`.
fn rate<const N: usize>(t: f64, path: impl Fn(f64) -> [f64; N]) -> [f64; N] {
    let h = 1e-4;
    let [a, b, c, d] = [-2.0, -1.0, 1.0, 2.0].map(|k| path(t + k * h));
    core::array::from_fn(|i| (8.0 * (c[i] - b[i]) - (d[i] - a[i])) / (12.0 * h))
}

/// Returns the angular velocity in world axes, from the rotation matrix alone: R' = [omega x] R.
fn angular(t: f64) -> [f64; 3] {
    let rotation = |t| rotation_from_quaternion(quaternion(motion(t)));
    let r = rotation(t);
    let rates: [[f64; 3]; 3] = core::array::from_fn(|row| rate(t, |t| rotation(t)[row]));
    let entry = |i: usize, j: usize| (0..3).map(|k| rates[i][k] * r[j][k]).sum();
    [entry(2, 1), entry(0, 2), entry(1, 0)]
}

/// Returns the linear and the angular velocity in world axes.
fn velocities(t: f64) -> [Vector3<f64>; 2] {
    let [x, y, z, ..] = rate(t, motion);
    [Vector3([x, y, z]), Vector3(angular(t))]
}

/// Returns modyn's velocities.
fn qd(t: f64) -> [f64; 6] {
    let [linear, angular] =
        velocities(t).map(|part| joint_rotation(motion(t)).conjugate().rotate(part));
    concatenate(linear, angular)
}

#[test]
fn velocities_and_accelerations_are_rates() {
    for t in [-1.0, 0.2, 1.7] {
        let qdd = rate(t, qd);
        let q = motion(t);
        let qd = qd(t);
        let [linear, turning] = velocities(t);
        close(drake::to_v(q, qd), concatenate(turning, linear), 1e-10);
        close(drake::to_vdot(q, qd, qdd), rate(t, |t| drake::to_v(motion(t), self::qd(t))), 1e-6);
        close(mujoco::to_qvel(q, qd), concatenate(linear, halves(qd)[1]), 1e-10);
        let along = |t| mujoco::to_qvel(motion(t), self::qd(t));
        close(mujoco::to_qacc(q, qd, qdd), rate(t, along), 1e-6);
        close(rbdl::to_qdot(q, qd), concatenate(linear, halves(qd)[1]), 1e-10);
        let along = |t| rbdl::to_qdot(motion(t), self::qd(t));
        close(rbdl::to_qddot(q, qd, qdd), rate(t, along), 1e-6);
        // The body's angular velocity, from the quaternion's derivative: 2 conj(q) q'.
        let [x, y, z, w] = quaternion(q);
        let [_, _, _, dx, dy, dz, dw] = rate(t, motion);
        let omega = [
            w * dx - x * dw - (y * dz - z * dy),
            w * dy - y * dw - (z * dx - x * dz),
            w * dz - z * dw - (x * dy - y * dx),
        ];
        close(halves(qd)[1].0, omega.map(|number| 2.0 * number), 1e-10);
    }
}

#[test]
fn there_and_back() {
    for t in [-1.0, 0.2, 1.7] {
        let q = motion(t);
        let qd = qd(t);
        let x = [1.0, -2.0, 3.0, 0.5, 0.7, -1.1];
        assert_eq!(mujoco::from_qpos(mujoco::to_qpos(q)), q);
        assert_eq!(drake::from_q(drake::to_q(q)), q);
        let (six, w) = rbdl::to_q(q);
        assert_eq!(rbdl::from_q(six, w), q);
        for back in [
            mujoco::from_qvel(q, mujoco::to_qvel(q, x)),
            mujoco::from_qacc(q, qd, mujoco::to_qacc(q, qd, x)),
            mujoco::from_qfrc(q, mujoco::to_qfrc(q, x)),
            drake::from_v(q, drake::to_v(q, x)),
            drake::from_vdot(q, qd, drake::to_vdot(q, qd, x)),
            drake::from_tau(q, drake::to_tau(q, x)),
            rbdl::from_qdot(q, rbdl::to_qdot(q, x)),
            rbdl::from_qddot(q, qd, rbdl::to_qddot(q, qd, x)),
            rbdl::from_tau(q, rbdl::to_tau(q, x)),
        ] {
            close(back, x, 1e-14);
        }
    }
}

#[test]
fn power_is_the_same() {
    for t in [-1.0, 0.2, 1.7] {
        let q = motion(t);
        let qd = qd(t);
        let tau = [1.0, -2.0, 3.0, 0.5, 0.7, -1.1];
        let power = dot(tau, qd);
        for converted in [
            dot(mujoco::to_qfrc(q, tau), mujoco::to_qvel(q, qd)),
            dot(drake::to_tau(q, tau), drake::to_v(q, qd)),
            dot(rbdl::to_tau(q, tau), rbdl::to_qdot(q, qd)),
        ] {
            assert!((converted - power).abs() < 1e-14, "{converted} {power}");
        }
    }
}

/// Each component must be in its place.
#[test]
fn orders() {
    let q = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];
    assert_eq!(mujoco::to_qpos(q), [1.0, 2.0, 3.0, 7.0, 4.0, 5.0, 6.0]);
    assert_eq!(drake::to_q(q), [7.0, 4.0, 5.0, 6.0, 1.0, 2.0, 3.0]);
    assert_eq!(rbdl::to_q(q), ([1.0, 2.0, 3.0, 4.0, 5.0, 6.0], 7.0));
}

#[test]
fn quaternions_come_back_from_their_rotations() {
    let numbers = [-1.0, -0.6, -1e-5, -1e-9, 0.0, 1e-9, 1e-5, 0.6, 1.0];
    for i in 1..numbers.len().pow(4) {
        let digit = |place: u32| numbers[i / numbers.len().pow(place) % numbers.len()];
        let q = [digit(0), digit(1), digit(2), digit(3)];
        let length = Scalar::sqrt(q.iter().map(|x| x * x).sum::<f64>());
        if length == 0.0 {
            continue;
        }
        let q = q.map(|x| x / length);
        let back = quaternion_from_rotation(rotation_from_quaternion(q));
        assert!(back[3] >= 0.0);
        let opposite: f64 = (0..4).map(|i| back[i] * q[i]).sum();
        close(back, q.map(|x| if opposite < 0.0 { -x } else { x }), 1e-15);
    }
}

#[test]
fn rotations_turn_by_the_right_hand() {
    // Sixty degrees about each axis.
    let (s, c) = (PI / 6.0).sin_cos();
    let (sin, cos) = (PI / 3.0).sin_cos();
    for axis in 0..3 {
        let mut q = [0.0, 0.0, 0.0, c];
        q[axis] = s;
        let [next, last] = [(axis + 1) % 3, (axis + 2) % 3];
        let mut v = [0.0; 3];
        v[next] = 1.0;
        let mut expected = [0.0; 3];
        (expected[next], expected[last]) = (cos, sin);
        let turn = Quaternion::from_components(q);
        close(turn.rotate(Vector3(v)).0, expected, 1e-15);
        close(turn.matrix().mul_vector(Vector3(v)).0, expected, 1e-15);
        close(turn.conjugate().rotate(Vector3(expected)).0, v, 1e-15);
    }
}

#[test]
fn angles_come_back_from_their_pairs() {
    for angle in [-3.1, -2.0, -0.5, 0.0, 1.0, 2.5, 3.1] {
        let back = pinocchio::angle_from_cos_sin(pinocchio::cos_sin_from_angle(angle));
        assert!((back - angle).abs() < 1e-15);
    }
    assert_eq!(pinocchio::cos_sin_from_angle(0.0), [1.0, 0.0]);
}
