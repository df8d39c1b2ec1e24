//! Spatial vectors, inertias and transforms, with named components.
//!
//! Quantities are about the origin of a link's frame and in that frame's axes, as in the paper: so is
//! the mass matrix (2) of a link. The linear part is first; the paper has the angular part first.

mod pose;

pub use pose::Pose;

#[cfg(feature = "alloc")]
mod axis_rotation;
#[cfg(feature = "alloc")]
mod dh_transform;
#[cfg(feature = "alloc")]
mod field;
#[cfg(feature = "alloc")]
mod inertia;
mod matrix;
#[cfg(feature = "alloc")]
mod perturbation;
mod quaternion;
#[cfg(feature = "alloc")]
mod spatial_axis;
mod vector;
#[cfg(feature = "alloc")]
mod velocity;
mod wrench;

#[cfg(feature = "alloc")]
pub use {
    axis_rotation::{Axis, AxisRotation},
    dh_transform::DhTransform,
    field::Field,
    inertia::{ArticulatedInertia, RigidInertia},
    perturbation::AccelerationPerturbation,
    spatial_axis::SpatialAxis,
    velocity::VelocityMoments,
};
pub use {
    matrix::{Matrix3, Symmetric3},
    quaternion::{
        Quaternion, inverse_rotation_jacobian, rotation_jacobian, screw_translation,
        screw_translation_by_rotation, screw_velocity,
    },
    vector::Vector3,
    wrench::{Momentum, Twist, Wrench},
};
