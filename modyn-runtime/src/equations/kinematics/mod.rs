//! Poses, motion and Jacobians of the links; the centre of mass; the configuration space.

pub(super) mod acceleration;
pub(super) mod center_of_mass;
pub mod coordinates;
pub(super) mod first_moment;
pub(super) mod kinematic_path;
pub(super) mod links;

pub use center_of_mass::{center_of_mass, center_of_mass_jacobian, total_mass};
pub use links::{
    Axes, bias_acceleration, jacobian, jacobian_time_derivative, link_acceleration,
    link_acceleration_from_world, link_pose, link_pose_from_world, link_poses, link_velocity,
};
