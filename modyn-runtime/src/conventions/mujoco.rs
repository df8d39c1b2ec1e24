//! MuJoCo: conversions for the free joint.
//!
//! MuJoCo's `qpos` is the position, then the quaternion w, x, y, z. `qvel` is the linear velocity
//! of the body's origin in world axes, then the angular velocity in the body's axes. `qacc` is the
//! time derivative of `qvel`, so its linear part is the classical acceleration. `qfrc_...` is the
//! force in world axes, then the moment in the body's axes. A ball joint has the quaternion w, x,
//! y, z, and the same angular velocity as in modyn.
//!
//! MuJoCo allows free joints at the top level only, so the joint's frame is the world.
//!
//! Sources: MuJoCo's documentation on
//! [floating objects](https://mujoco.readthedocs.io/en/latest/overview.html#floating-objects) and
//! its maintainers in [issue 691](https://github.com/google-deepmind/mujoco/issues/691).

use super::floating::{concatenate, halves, joint_rotation, quaternion};
use super::{wxyz_from_xyzw, xyzw_from_wxyz};
use crate::Scalar;

/// Returns MuJoCo's `qpos` of a free joint.
#[must_use]
pub fn to_qpos<T: Scalar>(q: [T; 7]) -> [T; 7] {
    let [x, y, z, ..] = q;
    let [qw, qx, qy, qz] = wxyz_from_xyzw(quaternion(q));
    [x, y, z, qw, qx, qy, qz]
}

/// Returns modyn's coordinates of a floating joint, from MuJoCo's `qpos`.
#[must_use]
pub fn from_qpos<T: Scalar>([x, y, z, qw, qx, qy, qz]: [T; 7]) -> [T; 7] {
    let [qx, qy, qz, qw] = xyzw_from_wxyz([qw, qx, qy, qz]);
    [x, y, z, qx, qy, qz, qw]
}

/// Returns MuJoCo's `qvel` of a free joint, from modyn's coordinates `q` and velocities `qd`.
#[must_use]
pub fn to_qvel<T: Scalar>(q: [T; 7], qd: [T; 6]) -> [T; 6] {
    let [linear, angular] = halves(qd);
    concatenate(joint_rotation(q).rotate(linear), angular)
}

/// Returns modyn's velocities of a floating joint, from modyn's coordinates `q` and MuJoCo's
/// `qvel`.
#[must_use]
pub fn from_qvel<T: Scalar>(q: [T; 7], qvel: [T; 6]) -> [T; 6] {
    let [linear, angular] = halves(qvel);
    concatenate(joint_rotation(q).conjugate().rotate(linear), angular)
}

/// Returns MuJoCo's `qacc` of a free joint, from modyn's coordinates, velocities and accelerations.
#[must_use]
pub fn to_qacc<T: Scalar>(q: [T; 7], qd: [T; 6], qdd: [T; 6]) -> [T; 6] {
    let [v, omega] = halves(qd);
    let [rate, angular] = halves(qdd);
    concatenate(joint_rotation(q).rotate(rate + omega.cross(v)), angular)
}

/// Returns modyn's accelerations of a floating joint, from modyn's coordinates and velocities and
/// MuJoCo's `qacc`.
#[must_use]
pub fn from_qacc<T: Scalar>(q: [T; 7], qd: [T; 6], qacc: [T; 6]) -> [T; 6] {
    let [v, omega] = halves(qd);
    let [linear, angular] = halves(qacc);
    concatenate(joint_rotation(q).conjugate().rotate(linear) - omega.cross(v), angular)
}

/// Returns MuJoCo's `qfrc_...` of a free joint, from modyn's coordinates `q` and forces `tau`.
#[must_use]
pub fn to_qfrc<T: Scalar>(q: [T; 7], tau: [T; 6]) -> [T; 6] {
    to_qvel(q, tau)
}

/// Returns modyn's forces of a floating joint, from modyn's coordinates `q` and MuJoCo's
/// `qfrc_...`.
#[must_use]
pub fn from_qfrc<T: Scalar>(q: [T; 7], qfrc: [T; 6]) -> [T; 6] {
    from_qvel(q, qfrc)
}
