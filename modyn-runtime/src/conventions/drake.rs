//! Drake: conversions for the quaternion floating joint.
//!
//! Drake's `q` is the quaternion w, x, y, z, then the position. `v` is the angular velocity, then
//! the linear velocity of the body's origin, both in the axes of the joint's frame F (for a
//! floating base: the world). `vdot` is the time derivative of `v`, so it contains the classical
//! acceleration. `tau` is the moment, then the force, in the axes of F.
//!
//! Source: Drake's
//! [`QuaternionFloatingJoint`](https://github.com/RobotLocomotion/drake/blob/master/multibody/tree/quaternion_floating_joint.h):
//! `q_FM`, `p_FM`, and `w_FM`, `v_FM`, expressed in F.

use super::floating::{concatenate, halves, joint_rotation, quaternion};
use super::{wxyz_from_xyzw, xyzw_from_wxyz};
use crate::Scalar;

/// Returns Drake's `q` of a quaternion floating joint.
///
/// ```
/// use modyn_runtime::conventions::drake;
///
/// let q = [1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 1.0];
/// assert_eq!(drake::to_q(q), [1.0, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0]);
/// assert_eq!(drake::from_q(drake::to_q(q)), q);
/// ```
#[must_use]
pub fn to_q<T: Scalar>(q: [T; 7]) -> [T; 7] {
    let [x, y, z, ..] = q;
    let [qw, qx, qy, qz] = wxyz_from_xyzw(quaternion(q));
    [qw, qx, qy, qz, x, y, z]
}

/// Returns modyn's coordinates of a floating joint, from Drake's `q`.
#[must_use]
pub fn from_q<T: Scalar>([qw, qx, qy, qz, x, y, z]: [T; 7]) -> [T; 7] {
    let [qx, qy, qz, qw] = xyzw_from_wxyz([qw, qx, qy, qz]);
    [x, y, z, qx, qy, qz, qw]
}

/// Returns Drake's `v` of a quaternion floating joint, from modyn's coordinates `q` and velocities
/// `qd`.
#[must_use]
pub fn to_v<T: Scalar>(q: [T; 7], qd: [T; 6]) -> [T; 6] {
    let [linear, angular] = halves(qd).map(|part| joint_rotation(q).rotate(part));
    concatenate(angular, linear)
}

/// Returns modyn's velocities of a floating joint, from modyn's coordinates `q` and Drake's `v`.
#[must_use]
pub fn from_v<T: Scalar>(q: [T; 7], v: [T; 6]) -> [T; 6] {
    let [angular, linear] = halves(v).map(|part| joint_rotation(q).conjugate().rotate(part));
    concatenate(linear, angular)
}

/// Returns Drake's `vdot` of a quaternion floating joint, from modyn's coordinates, velocities and
/// accelerations.
#[must_use]
pub fn to_vdot<T: Scalar>(q: [T; 7], qd: [T; 6], qdd: [T; 6]) -> [T; 6] {
    let [v, omega] = halves(qd);
    let [rate, angular] = halves(qdd);
    // The derivative of omega has the same components in both axes, since omega x omega is zero.
    to_v(q, concatenate(rate + omega.cross(v), angular))
}

/// Returns modyn's accelerations of a floating joint, from modyn's coordinates and velocities and
/// Drake's `vdot`.
#[must_use]
pub fn from_vdot<T: Scalar>(q: [T; 7], qd: [T; 6], vdot: [T; 6]) -> [T; 6] {
    let [v, omega] = halves(qd);
    let [linear, angular] = halves(from_v(q, vdot));
    concatenate(linear - omega.cross(v), angular)
}

/// Returns Drake's `tau` of a quaternion floating joint: the moment, then the force.
#[must_use]
pub fn to_tau<T: Scalar>(q: [T; 7], tau: [T; 6]) -> [T; 6] {
    to_v(q, tau)
}

/// Returns modyn's forces of a floating joint, from modyn's coordinates `q` and Drake's `tau`.
#[must_use]
pub fn from_tau<T: Scalar>(q: [T; 7], tau: [T; 6]) -> [T; 6] {
    from_v(q, tau)
}
