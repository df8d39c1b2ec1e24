//! modyn compiles a robot description (URDF, xacro, SDF, MJCF) to specialised rigid-body dynamics:
//! straight-line, allocation-free, `no_std` Rust for exactly that robot.
//!
//! ```
//! modyn::modyn!("robots/gripper.urdf");
//!
//! let (q, qd, tau) = (Gripper::NEUTRAL, [0.0; Gripper::NV], [0.0; Gripper::NV]);
//! let qdd = Gripper::forward_dynamics(&q, &qd, &tau);
//! assert!(qdd[0] < 0.0);
//! ```
//!
//! The page of the [`modyn!`] macro lists all options. [`Robot`] is the trait of all generated
//! types. [`Interpreter`] computes the same quantities for a [`model`] that is known at run time
//! only. The [`guides`] explain the use of modyn step by step, and [`example`] has a generated
//! type.
//!
//! # Features
//!
//! | feature | default | gives |
//! |---|---|---|
//! | `std` | yes | the standard library; implies `alloc` |
//! | `alloc` | through `std` | the model, the equations and the interpreter |
//! | `nalgebra` | no | the most used functions over `SVector`, `SMatrix`, `Isometry3` |
//! | `num-dual` | no | the numbers of num-dual as scalars, for exact derivatives |
//! | `rayon` | no | batches on all cores |
//! | `serde` | no | serialization and deserialization of the model |
//!
//! Without features, generated code needs `core` and `libm`.
#![no_std]

pub use modyn_macro::modyn;
pub use modyn_runtime::*;

/// The guides and reference pages of modyn.
///
/// Start with [`start`](guides::start), then read the guide for your use: a controller
/// ([`tutorial_controller`](guides::tutorial_controller)), firmware
/// ([`firmware`](guides::firmware)), or sampling ([`batch`](guides::batch)).
/// [`coming_from`](guides::coming_from) compares modyn with other libraries, function by function.
#[cfg(all(doc, not(doctest)))]
pub mod guides {
    modyn_macro::guides!();
}

/// A generated type as the documentation of your crate shows it: the gripper of Shah, Saha and
/// Dutt.
#[cfg(all(doc, not(doctest)))]
pub mod example {
    modyn_macro::modyn!(pub Gripper = "robots/gripper.urdf", crate = crate);
}

/// Includes the text that a build script generated with `modyn_codegen::Builder`:
/// `include_model!(gripper)` defines the robot of `gripper.urdf`.
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
