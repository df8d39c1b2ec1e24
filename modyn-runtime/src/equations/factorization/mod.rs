//! U D U^T of the mass matrix by modules: block reverse Gaussian elimination.

pub mod brge;
pub(super) mod elimination;
pub mod limbs;
pub mod partition;
