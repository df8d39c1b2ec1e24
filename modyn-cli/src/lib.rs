//! The command `modyn`, and the [`viewer`] for motions.
//!
//! ```text
//! robot (description and options) ─┬─ check     reports its faults, with places
//!                                  ├─ inspect   describes the robot, and the cost of its functions
//!                                  ├─ generate  writes its dynamics as Rust or C
//!                                  ├─ simulate  computes its motion: table, plots, animation
//!                                  └─ compare   compares its code with the interpreter
//!
//! explain: the cause of a diagnostic, and its remedy
//! ```
//!
//! Without the feature `command` the crate is the viewer only, which has no dependencies.

#[cfg(feature = "command")]
mod command;
mod escape;
pub mod viewer;

#[cfg(feature = "command")]
pub use command::run;
