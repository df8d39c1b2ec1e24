//! Conversions of states to and from other libraries.
//!
//! All quantities are in SI units and radians. Angles and displacements of revolute and prismatic
//! joints, and the torques and forces along them, are the same in all libraries. Joints with
//! rotations differ, above all the floating joint. modyn's floating joint has
//!
//! - coordinates `[x, y, z, qx, qy, qz, qw]`: the position of the link's origin in the joint's
//!   frame (for a floating base: the world), and the unit quaternion that rotates the link's axes
//!   into the joint's axes,
//! - velocities `[vx, vy, vz, wx, wy, wz]`: the linear velocity of the link's origin, then the
//!   angular velocity, both in the link's own axes,
//! - accelerations: the time derivatives of these velocities,
//! - forces `[fx, fy, fz, mx, my, mz]`: their scalar product with the velocities is the power.
//!
//! There is a module for each library. Its functions are named after the library's own vectors:
//! `to_...` returns the library's vector, `from_...` returns modyn's. All functions are generic
//! over [`Scalar`](crate::Scalar), so that they can be differentiated. Quaternions must have
//! length 1.
//!
//! ```
//! use modyn_runtime::conventions::mujoco;
//!
//! // The base is upside down (half a turn about x). It moves along its own z axis: downwards.
//! let q = [0.0, 0.0, 0.5, 1.0, 0.0, 0.0, 0.0];
//! let qd = [0.0, 0.0, 2.0, 0.0, 0.0, 0.0];
//! assert_eq!(mujoco::to_qpos(q), [0.0, 0.0, 0.5, 0.0, 1.0, 0.0, 0.0]);
//! assert_eq!(mujoco::to_qvel(q, qd), [0.0, 0.0, -2.0, 0.0, 0.0, 0.0]);
//! ```

pub mod drake;
mod floating;
pub mod mujoco;
pub mod pinocchio;
pub mod rbdl;
mod rotations;
#[cfg(test)]
mod tests;

pub use rotations::{
    quaternion_from_rotation, rotation_from_quaternion, wxyz_from_xyzw, xyzw_from_wxyz,
};
