//! modyn's compiler: from a robot description (URDF) to specialised Rust.
//!
//! ```text
//! URDF text ─ urdf ─▶ Model ─ modules ─▶ equations on Expr (trace) ─▶ Graph ─ passes ─▶ emit ─▶ Rust
//! ```
//!
//! The macro `modyn::modyn!`, build scripts and anyone who wants the text all come in through
//! [`Builder`].
//!
//! Stable are [`Builder`] with its options and result, [`error`], [`urdf`], `mjcf` and [`names`]. The other
//! modules (`emit`, `expr`, `partition`, `passes`, `source`, `trace`) are public for tests and
//! measurements, and may change in any release.

mod builder;
mod condition;
pub mod emit;
pub mod error;
pub mod expr;
mod functions;
#[cfg(feature = "mjcf")]
pub mod mjcf;
pub mod names;
pub mod partition;
pub mod passes;
mod size;
pub mod source;
mod tame;
pub mod trace;
pub mod urdf;

pub use builder::{Builder, Generated, ModuleChoice};
pub use condition::{CARRIED_BY_F32, condition_number};
pub use emit::FloatType;
pub use functions::Function;
pub use tame::tame;
pub use urdf::nearest::nearest;
