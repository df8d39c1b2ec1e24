//! The command `modyn`, the [`viewer`] for motions, and the pictures of robots.
//!
//! ```text
//! robot (description and options) ─┬─ check     reports its faults, with places
//!                                  ├─ inspect   describes the robot, and the cost of its functions
//!                                  ├─ generate  writes its dynamics as Rust or C
//!                                  ├─ simulate  computes its motion: table, plots, animation
//!                                  ├─ view      shows it, with sliders of its joints
//!                                  └─ compare   compares its code with the interpreter
//!
//! explain: the cause of a diagnostic, and its remedy
//! ```
//!
//! Without the feature `command` the crate is the viewer, which has no dependencies; with the
//! feature `picture` it has the pictures, too.

#[cfg(feature = "command")]
mod command;
#[cfg(feature = "picture")]
pub mod contact_steps;
mod escape;
#[cfg(feature = "picture")]
pub mod loops;
#[cfg(feature = "picture")]
pub mod picture;
#[cfg(feature = "picture")]
mod random;
#[cfg(feature = "report")]
pub mod report;
pub mod viewer;

#[cfg(feature = "command")]
pub use command::run;
