//! RBDL: a floating base is a `TranslationXYZ` and a `Spherical` joint. `Q` has the position and x,
//! y, z of the quaternion in the joint's six places, w after the coordinates of all joints; `QDot`
//! linear velocity in world axes and angular velocity in the body's; `QDDot` the rates of these, so
//! the linear part is the classical acceleration; `Tau` force in world axes and moment in the body's.
//! A spherical joint alone: the same quaternion, w at the end; angular velocity as modyn's.
//!
//! Source: [`rbdl/Joint.h`](https://github.com/rbdl/rbdl/blob/master/include/rbdl/Joint.h), "Joint
//! Singularities" and "Floating-Base Joint", and `rbdl/Quaternion.h`, whose `toMatrix` turns vectors
//! of the world into the body's axes: so the quaternion is that from the body to the world.

use super::mujoco;
use crate::Scalar;

/// The six numbers of `Q` in a floating base's own places, and the w that stands behind the
/// coordinates of all joints: at `Model::multdof3_w_index` of the spherical joint's body.
#[must_use]
pub fn to_q<T: Scalar>([x, y, z, qx, qy, qz, qw]: [T; 7]) -> ([T; 6], T) {
    ([x, y, z, qx, qy, qz], qw)
}

/// A floating joint's coordinates from `Q`: the six numbers in its own places, and w.
#[must_use]
pub fn from_q<T: Scalar>([x, y, z, qx, qy, qz]: [T; 6], qw: T) -> [T; 7] {
    [x, y, z, qx, qy, qz, qw]
}

/// `QDot` of a floating base at the coordinates `q` (modyn's, as everywhere here).
#[must_use]
pub fn to_qdot<T: Scalar>(q: [T; 7], qd: [T; 6]) -> [T; 6] {
    mujoco::to_qvel(q, qd)
}

/// A floating joint's velocities from `QDot`.
#[must_use]
pub fn from_qdot<T: Scalar>(q: [T; 7], qdot: [T; 6]) -> [T; 6] {
    mujoco::from_qvel(q, qdot)
}

/// `QDDot` of a floating base.
#[must_use]
pub fn to_qddot<T: Scalar>(q: [T; 7], qd: [T; 6], qdd: [T; 6]) -> [T; 6] {
    mujoco::to_qacc(q, qd, qdd)
}

/// A floating joint's accelerations from `QDDot`; `qd` are modyn's velocities.
#[must_use]
pub fn from_qddot<T: Scalar>(q: [T; 7], qd: [T; 6], qddot: [T; 6]) -> [T; 6] {
    mujoco::from_qacc(q, qd, qddot)
}

/// `Tau` of a floating base.
#[must_use]
pub fn to_tau<T: Scalar>(q: [T; 7], tau: [T; 6]) -> [T; 6] {
    mujoco::to_qfrc(q, tau)
}

/// A floating joint's forces from `Tau`.
#[must_use]
pub fn from_tau<T: Scalar>(q: [T; 7], tau: [T; 6]) -> [T; 6] {
    mujoco::from_qfrc(q, tau)
}
