//! Drake: a quaternion floating joint has `q` = quaternion w, x, y, z and position; `v` = angular
//! velocity and linear velocity of the body's origin, both in world axes (those of the joint's frame
//! F); `vdot` the rates of these, so the classical acceleration; `tau` moment and force, in world
//! axes.
//!
//! Source: Drake's
//! [`QuaternionFloatingJoint`](https://github.com/RobotLocomotion/drake/blob/master/multibody/tree/quaternion_floating_joint.h):
//! `q_FM`, `p_FM`, and `w_FM`, `v_FM`, expressed in F.

use super::floating::{concatenate, halves, joint_rotation, quaternion};
use super::{wxyz_from_xyzw, xyzw_from_wxyz};
use crate::Scalar;

/// `q` of a quaternion floating joint.
#[must_use]
pub fn to_q<T: Scalar>(q: [T; 7]) -> [T; 7] {
    let ([x, y, z, ..], [qw, qx, qy, qz]) = (q, wxyz_from_xyzw(quaternion(q)));
    [qw, qx, qy, qz, x, y, z]
}

/// A floating joint's coordinates from Drake's `q`.
#[must_use]
pub fn from_q<T: Scalar>([qw, qx, qy, qz, x, y, z]: [T; 7]) -> [T; 7] {
    let [qx, qy, qz, qw] = xyzw_from_wxyz([qw, qx, qy, qz]);
    [x, y, z, qx, qy, qz, qw]
}

/// `v` of a quaternion floating joint at the coordinates `q` (modyn's, as everywhere here).
#[must_use]
pub fn to_v<T: Scalar>(q: [T; 7], qd: [T; 6]) -> [T; 6] {
    let [linear, angular] = halves(qd).map(|part| joint_rotation(q).rotate(part));
    concatenate(angular, linear)
}

/// A floating joint's velocities from `v`.
#[must_use]
pub fn from_v<T: Scalar>(q: [T; 7], v: [T; 6]) -> [T; 6] {
    let [angular, linear] = halves(v).map(|part| joint_rotation(q).conjugate().rotate(part));
    concatenate(linear, angular)
}

/// `vdot` of a quaternion floating joint.
#[must_use]
pub fn to_vdot<T: Scalar>(q: [T; 7], qd: [T; 6], qdd: [T; 6]) -> [T; 6] {
    let ([v, omega], [rate, angular]) = (halves(qd), halves(qdd));
    // omega's own rate is the same in both axes: omega x omega is zero.
    to_v(q, concatenate(rate + omega.cross(v), angular))
}

/// A floating joint's accelerations from `vdot`; `qd` are modyn's velocities.
#[must_use]
pub fn from_vdot<T: Scalar>(q: [T; 7], qd: [T; 6], vdot: [T; 6]) -> [T; 6] {
    let ([v, omega], [linear, angular]) = (halves(qd), halves(from_v(q, vdot)));
    concatenate(linear - omega.cross(v), angular)
}

/// `tau` of a quaternion floating joint: moment and force.
#[must_use]
pub fn to_tau<T: Scalar>(q: [T; 7], tau: [T; 6]) -> [T; 6] {
    to_v(q, tau)
}

/// A floating joint's forces from Drake's `tau`.
#[must_use]
pub fn from_tau<T: Scalar>(q: [T; 7], tau: [T; 6]) -> [T; 6] {
    from_v(q, tau)
}
