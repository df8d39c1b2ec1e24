//! Pictures of a robot: its kinematic modules with the sparsity of its mass matrix.

mod modules;
mod sparsity;

pub use modules::draw;
pub use sparsity::Sparsity;
