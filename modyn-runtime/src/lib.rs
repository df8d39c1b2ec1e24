//! What modyn's generated code needs at run time, and the equations of motion behind it.
#![no_std]
#![cfg_attr(docsrs, feature(doc_cfg))]

#[cfg(feature = "alloc")]
extern crate alloc;

#[cfg(feature = "alloc")]
pub mod equations;
#[cfg(feature = "alloc")]
mod interpreter;
pub mod joint;
#[cfg(feature = "alloc")]
pub mod model;
mod scalar;
pub mod spatial;

#[cfg(feature = "alloc")]
pub use interpreter::{Brge, Interpreter, ShapeError};
pub use scalar::Scalar;
