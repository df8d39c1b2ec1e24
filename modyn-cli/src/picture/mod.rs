//! Pictures of a robot: its kinematic modules with the sparsity of its mass matrix, and its skeleton for the
//! [`viewer`](crate::viewer).

mod modules;
mod skeleton;
mod sparsity;

pub use modules::draw;
pub use skeleton::Skeleton;
pub use sparsity::Sparsity;
