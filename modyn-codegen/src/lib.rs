//! modyn's compiler: from a robot description (URDF) to specialised Rust.

pub mod error;
pub mod expr;
pub mod names;
pub mod trace;
pub mod urdf;
