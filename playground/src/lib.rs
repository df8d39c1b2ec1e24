//! The part of the playground that is not JavaScript: modyn as answers to requests.
//!
//! ```text
//! page (page/*.js) ─ request: JSON, bytes ─▶ exports ─▶ Session ─ read, inspect, generate ─▶ answer: JSON
//!                                                         └────── Motion: steps under gravity, on the ground
//! ```
//!
//! `build` makes the module for browsers. Nothing here depends on the browser: the tests call a
//! [`Session`] as the page does.

#[cfg(target_arch = "wasm32")]
mod exports;
mod motion;
mod session;

pub use motion::{Motion, MotionOptions};
pub use session::Session;
