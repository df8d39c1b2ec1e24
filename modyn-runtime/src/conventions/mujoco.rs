//! MuJoCo: a free joint has `qpos` = position and quaternion w, x, y, z; `qvel` = linear velocity of
//! the body's origin in world axes and angular velocity in the body's; `qacc` the rates of these,
//! so the linear part is the classical acceleration; `qfrc_...` force in world axes and moment in
//! the body's. A ball joint: the quaternion w, x, y, z; angular velocity as modyn's.
//!
//! A free joint stands at the top level only, so the joint's frame is the world.
//!
//! Sources: MuJoCo's documentation on
//! [floating objects](https://mujoco.readthedocs.io/en/latest/overview.html#floating-objects) and its
//! maintainers in [issue 691](https://github.com/google-deepmind/mujoco/issues/691).

use super::floating::{concatenate, halves, joint_rotation, quaternion};
use super::{wxyz_from_xyzw, xyzw_from_wxyz};
use crate::Scalar;

/// `qpos` of a free joint.
#[must_use]
pub fn to_qpos<T: Scalar>(q: [T; 7]) -> [T; 7] {
    let ([x, y, z, ..], [qw, qx, qy, qz]) = (q, wxyz_from_xyzw(quaternion(q)));
    [x, y, z, qw, qx, qy, qz]
}

/// A floating joint's coordinates from `qpos`.
#[must_use]
pub fn from_qpos<T: Scalar>([x, y, z, qw, qx, qy, qz]: [T; 7]) -> [T; 7] {
    let [qx, qy, qz, qw] = xyzw_from_wxyz([qw, qx, qy, qz]);
    [x, y, z, qx, qy, qz, qw]
}

/// `qvel` of a free joint at the coordinates `q` (modyn's, as everywhere here).
#[must_use]
pub fn to_qvel<T: Scalar>(q: [T; 7], qd: [T; 6]) -> [T; 6] {
    let [linear, angular] = halves(qd);
    concatenate(joint_rotation(q).rotate(linear), angular)
}

/// A floating joint's velocities from `qvel`.
#[must_use]
pub fn from_qvel<T: Scalar>(q: [T; 7], qvel: [T; 6]) -> [T; 6] {
    let [linear, angular] = halves(qvel);
    concatenate(joint_rotation(q).conjugate().rotate(linear), angular)
}

/// `qacc` of a free joint.
#[must_use]
pub fn to_qacc<T: Scalar>(q: [T; 7], qd: [T; 6], qdd: [T; 6]) -> [T; 6] {
    let ([v, omega], [rate, angular]) = (halves(qd), halves(qdd));
    concatenate(joint_rotation(q).rotate(rate + omega.cross(v)), angular)
}

/// A floating joint's accelerations from `qacc`; `qd` are modyn's velocities.
#[must_use]
pub fn from_qacc<T: Scalar>(q: [T; 7], qd: [T; 6], qacc: [T; 6]) -> [T; 6] {
    let ([v, omega], [linear, angular]) = (halves(qd), halves(qacc));
    concatenate(joint_rotation(q).conjugate().rotate(linear) - omega.cross(v), angular)
}

/// `qfrc_...` of a free joint.
#[must_use]
pub fn to_qfrc<T: Scalar>(q: [T; 7], tau: [T; 6]) -> [T; 6] {
    to_qvel(q, tau)
}

/// A floating joint's forces from `qfrc_...`.
#[must_use]
pub fn from_qfrc<T: Scalar>(q: [T; 7], qfrc: [T; 6]) -> [T; 6] {
    from_qvel(q, qfrc)
}
