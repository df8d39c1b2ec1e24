//! The scalars of the equations and of the generated code.

#[cfg(feature = "num-dual")]
mod dual;
mod elementary;
mod float;
#[cfg(feature = "alloc")]
mod lane_scalar;
mod native;
#[cfg(test)]
pub(crate) mod near_pi;
mod portable;
mod real;
#[cfg(test)]
mod root;
pub(crate) mod simd;
#[cfg(feature = "std")]
pub mod steps;
pub(crate) mod trig;

#[cfg(feature = "alloc")]
pub use lane_scalar::LaneScalar;
pub use portable::Portable;
pub use real::Scalar;
pub(crate) use real::epsilon;
pub use trig::{SIN_COS_F32, SIN_COS_F64, SinCosNumbers};
