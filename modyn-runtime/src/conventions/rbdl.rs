//! RBDL: conversions for a floating base, which is a `TranslationXYZ` and a `Spherical` joint.
//!
//! RBDL's `Q` has the position and the quaternion's x, y, z in the joint's six entries; w follows
//! the coordinates of all joints. `QDot` is the linear velocity in world axes, then the angular
//! velocity in the body's axes. `QDDot` is the time derivative of `QDot`, so its linear part is the
//! classical acceleration. `Tau` is the force in world axes, then the moment in the body's axes. A
//! spherical joint has the same quaternion, with w at the end, and the same angular velocity as in
//! modyn.
//!
//! Source: [`rbdl/Joint.h`](https://github.com/rbdl/rbdl/blob/master/include/rbdl/Joint.h), "Joint
//! Singularities" and "Floating-Base Joint", and `rbdl/Quaternion.h`. Its `toMatrix` rotates
//! vectors of the world into the body's axes, so the quaternion rotates from the body to the world.

use super::mujoco;
use crate::Scalar;

/// Returns the six entries of RBDL's `Q` of a floating base, and w. w follows the coordinates of
/// all joints, at `Model::multdof3_w_index` of the spherical joint's body.
///
/// ```
/// use modyn_runtime::conventions::rbdl;
///
/// let q = [1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 1.0];
/// assert_eq!(rbdl::to_q(q), ([1.0, 2.0, 3.0, 0.0, 0.0, 0.0], 1.0));
/// ```
#[must_use]
pub fn to_q<T: Scalar>([x, y, z, qx, qy, qz, qw]: [T; 7]) -> ([T; 6], T) {
    ([x, y, z, qx, qy, qz], qw)
}

/// Returns modyn's coordinates of a floating joint, from the six entries of RBDL's `Q` and w.
#[must_use]
pub fn from_q<T: Scalar>([x, y, z, qx, qy, qz]: [T; 6], qw: T) -> [T; 7] {
    [x, y, z, qx, qy, qz, qw]
}

/// Returns RBDL's `QDot` of a floating base, from modyn's coordinates `q` and velocities `qd`.
#[must_use]
pub fn to_qdot<T: Scalar>(q: [T; 7], qd: [T; 6]) -> [T; 6] {
    mujoco::to_qvel(q, qd)
}

/// Returns modyn's velocities of a floating joint, from modyn's coordinates `q` and RBDL's `QDot`.
#[must_use]
pub fn from_qdot<T: Scalar>(q: [T; 7], qdot: [T; 6]) -> [T; 6] {
    mujoco::from_qvel(q, qdot)
}

/// Returns RBDL's `QDDot` of a floating base, from modyn's coordinates, velocities and
/// accelerations.
#[must_use]
pub fn to_qddot<T: Scalar>(q: [T; 7], qd: [T; 6], qdd: [T; 6]) -> [T; 6] {
    mujoco::to_qacc(q, qd, qdd)
}

/// Returns modyn's accelerations of a floating joint, from modyn's coordinates and velocities and
/// RBDL's `QDDot`.
#[must_use]
pub fn from_qddot<T: Scalar>(q: [T; 7], qd: [T; 6], qddot: [T; 6]) -> [T; 6] {
    mujoco::from_qacc(q, qd, qddot)
}

/// Returns RBDL's `Tau` of a floating base, from modyn's coordinates `q` and forces `tau`.
#[must_use]
pub fn to_tau<T: Scalar>(q: [T; 7], tau: [T; 6]) -> [T; 6] {
    mujoco::to_qfrc(q, tau)
}

/// Returns modyn's forces of a floating joint, from modyn's coordinates `q` and RBDL's `Tau`.
#[must_use]
pub fn from_tau<T: Scalar>(q: [T; 7], tau: [T; 6]) -> [T; 6] {
    mujoco::from_qfrc(q, tau)
}
