//! Model predictive control with fixed sizes: a solver without a heap and without an operating system, and two problems.
//!
//! - [`solver`]: differential dynamic programming with limits of the inputs, for any robot and any [`Problem`].
//! - [`following`]: an arm whose hand follows a pose.
//! - [`pose_error`]: the error of a pose, and its derivative.
#![no_std]

pub mod following;
pub mod knot;
pub mod matrix;
pub mod pose_error;
pub mod solver;

mod limited;

pub use knot::{Knot, StateCost};
pub use solver::{Motion, Problem, Solver};
