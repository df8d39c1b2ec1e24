//! modyn compiles a robot description (URDF) to specialised rigid-body dynamics: straight-line,
//! allocation-free, `no_std` Rust for exactly that robot.
//!
//! ```
//! modyn::modyn!("robots/gripper.urdf");
//!
//! let qdd = Gripper::forward_dynamics(&[0.0; 4], &[0.0; 4], &[0.0; 4]);
//! assert!(qdd[0] < 0.0);
//! ```
//!
//! # Features
//!
//! | feature | default | |
//! |---|---|---|
//! | `std` | yes | implies `alloc` |
//! | `alloc` | through `std` | the model, the equations and the interpreter |
//! | `nalgebra` | no | the same calls over `SVector`, `SMatrix`, `Isometry3` |
//! | `num-dual` | no | the numbers of num-dual as scalars: exact derivatives of everything |
//! | `rayon` | no | batches on all cores |
//! | `serde` | no | the model (de)serialized |
//!
//! Without any, generated code needs `core` and `libm`.
#![no_std]

pub use modyn_macro::modyn;
pub use modyn_runtime::*;

/// Includes what a build script compiled with `modyn_codegen::Builder`: `include_model!(gripper)`
/// is the robot of `gripper.urdf`.
#[macro_export]
macro_rules! include_model {
    ($name:ident) => {
        ::core::include!(::core::concat!(
            ::core::env!("OUT_DIR"),
            "/",
            ::core::stringify!($name),
            ".rs"
        ));
    };
}
