//! The scalars of the equations and of the generated code.

#[cfg(feature = "num-dual")]
mod dual;
#[cfg(feature = "alloc")]
mod lane_scalar;
#[cfg(test)]
pub(crate) mod near_pi;
mod portable;
mod real;
pub(crate) mod simd;
pub(crate) mod trig;

#[cfg(feature = "alloc")]
pub use lane_scalar::LaneScalar;
pub use portable::Portable;
pub use real::Scalar;
pub(crate) use real::epsilon;
pub use trig::{SIN_COS_F32, SIN_COS_F64, SinCosNumbers};
