//! The command `modyn`, and the [`viewer`] that it shows motions with.
//!
//! ```text
//! robot (description and options) ─┬─ check     what is wrong with it, where
//!                                  ├─ inspect   what it is, and what its functions cost
//!                                  ├─ generate  its dynamics as Rust, and functions for C
//!                                  ├─ simulate  how it moves: figures, plots, a page to watch
//!                                  └─ compare   its code against the interpreter
//!
//! explain: what a diagnostic means
//! ```
//!
//! Without the feature `command` this is the viewer alone, which depends on nothing.

#[cfg(feature = "command")]
mod command;
mod escape;
pub mod viewer;

#[cfg(feature = "command")]
pub use command::run;
