//! The numbers that the equations and the generated code run on.

pub(crate) mod abreast;
#[cfg(feature = "num-dual")]
mod dual;
mod elementary;
mod float;
mod native;
mod real;
#[cfg(test)]
mod root;
pub(crate) mod trig;

pub use real::Scalar;
pub(crate) use real::epsilon;
