//! States to and from other libraries.
//!
//! Everything is in SI units and radians. The same throughout: angles and displacements of revolute
//! and prismatic joints, and the torques and forces along them. What differs is where rotations are
//! involved, and above all the floating joint, whose numbers here are
//!
//! - coordinates `[x, y, z, qx, qy, qz, qw]`: position of the link's origin in the joint's frame (of
//!   a floating base: the world) and unit quaternion from the link to it,
//! - velocities `[vx, vy, vz, wx, wy, wz]`: linear one of the link's origin and angular one, both in
//!   the link's own axes,
//! - accelerations: the rates of these numbers,
//! - forces `[fx, fy, fz, mx, my, mz]`: such that force times velocity is power.
//!
//! There is a module for each library, with functions that are called after the library's own names:
//! `to_...` from modyn's numbers to the library's, `from_...` back. All are generic over [`Scalar`](crate::Scalar),
//! so that they can be compiled and differentiated as well. Quaternions must have length one.
//!
//! ```
//! use modyn_runtime::conventions::mujoco;
//!
//! // Upside down (half a turn about x), the base moves along its own z axis: downwards.
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
