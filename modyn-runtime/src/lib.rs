//! What modyn's generated code needs at run time, and the equations of motion behind it.
//!
//! Without features this crate is what generated code needs, on `core` and `libm` alone:
//! [`Scalar`], [`Pose`](spatial::Pose), the [`Robot`] trait. Feature `alloc` adds the
//! [`model`], the [`equations`] and the [`Interpreter`] that runs them for any model at run time;
//! `nalgebra` the same calls over nalgebra's types; `serde` (de)serialization of the model.
#![no_std]

#[cfg(feature = "alloc")]
extern crate alloc;
#[cfg(feature = "std")]
extern crate std;

#[cfg(feature = "alloc")]
pub mod equations;
#[cfg(feature = "alloc")]
mod interpreter;
pub mod jacobi;
pub mod joint;
#[cfg(feature = "alloc")]
pub mod model;
#[cfg(feature = "nalgebra")]
mod nalgebra;
mod robot;
mod scalar;
pub mod spatial;

/// nalgebra, in the version whose types [`Nalgebra`] has.
#[cfg(feature = "nalgebra")]
pub use ::nalgebra as na;
#[cfg(feature = "alloc")]
pub use interpreter::{Brge, Interpreter, ModuleMismatch, ShapeError, UpdateError};

#[cfg(feature = "nalgebra")]
pub use crate::nalgebra::Nalgebra;
pub use robot::{Array, Factorization, KinematicModule, OperationCount, Robot};
pub use scalar::Scalar;
