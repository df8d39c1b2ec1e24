//! The scalars of the equations and of the generated code.

#[cfg(feature = "num-dual")]
mod dual;
#[cfg(feature = "alloc")]
mod lane_scalar;
#[cfg(test)]
pub(crate) mod near_pi;
mod portable;
#[cfg(feature = "alloc")]
mod tangent;
mod traits;
pub(crate) mod trig;

#[cfg(feature = "alloc")]
pub use lane_scalar::LaneScalar;
pub use portable::Portable;
#[cfg(feature = "alloc")]
pub(crate) use tangent::Tangent;
pub use traits::{Chunk, Pack, Scalar, SimdBackend, SimdTask};
pub(crate) use traits::{at_least, at_most, epsilon, positive};
pub use trig::{FRAC_1_PI_BITS, PI_BITS, SIN_COS_F32, SIN_COS_F64, SinCosNumbers};
