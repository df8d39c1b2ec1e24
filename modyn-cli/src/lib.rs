//! The command `modyn`, and the [`viewer`] that it shows motions with.
//!
//! ```text
//! robot (description and options) ─┬─ check     what is wrong with it, where
//!                                  ├─ inspect   what it is, and what its functions cost
//!                                  ├─ generate  its dynamics as Rust, and functions for C
//!                                  ├─ simulate  how it moves: figures, plots, a page to watch
//!                                  └─ compare   its code against the interpreter
//! ```
//!
//! Without the feature `command` this is the viewer alone, which depends on nothing.

#[cfg(feature = "command")]
mod check;
#[cfg(feature = "command")]
mod command;
#[cfg(feature = "command")]
mod compare;
#[cfg(feature = "command")]
mod diagnostics;
mod escape;
#[cfg(feature = "command")]
mod generate;
#[cfg(feature = "command")]
mod header;
#[cfg(feature = "command")]
mod inspect;
#[cfg(feature = "command")]
mod outcome;
#[cfg(feature = "command")]
mod progress;
#[cfg(feature = "command")]
mod random;
#[cfg(feature = "command")]
mod robot;
#[cfg(feature = "command")]
mod simulate;
#[cfg(feature = "command")]
mod table;
pub mod viewer;

#[cfg(feature = "command")]
pub use command::run;
