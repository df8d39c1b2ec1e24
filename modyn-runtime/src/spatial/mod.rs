//! Spatial quantities with named parts.
//!
//! Everything is referred to the origin of a link's frame and given in that frame's axes, as in
//! the paper: the twist is t = [omega; o_dot], the link mass matrix stands about the link's
//! origin, (2).

mod pose;

pub use pose::Pose;

#[cfg(feature = "alloc")]
mod field;
#[cfg(feature = "alloc")]
mod inertia;
#[cfg(feature = "alloc")]
mod matrix;
#[cfg(feature = "alloc")]
mod placement;
#[cfg(feature = "alloc")]
mod turn;
#[cfg(feature = "alloc")]
mod vector;
#[cfg(feature = "alloc")]
mod wrench;

#[cfg(feature = "alloc")]
pub use {
    field::Field,
    inertia::{ArticulatedInertia, RigidInertia},
    matrix::{Matrix3, Symmetric3},
    placement::Placement,
    turn::{Axis, Turn},
    vector::Vector3,
    wrench::{Twist, Wrench},
};
