//! Poses, motion and Jacobians of the links; the centre of mass; the configuration space.

pub(super) mod acceleration;
pub(super) mod center_of_mass;
pub mod coordinates;
pub(super) mod first_moment;
pub(super) mod kinematic_path;
pub(super) mod links;

pub use {center_of_mass::*, links::*};
