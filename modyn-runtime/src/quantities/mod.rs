//! The table of quantities: all functions of a robot, each with its arguments, its result and its
//! evaluation.
//!
//! A row has everything that is true of a function wherever it is computed. From it follow the
//! trait [`Robot`](crate::Robot) with its [`functions`](crate::functions), the functions that the
//! compiler traces, and those of every language.
//! [`Interpreter::evaluate`](crate::Interpreter::evaluate) computes any of them from numbers.

#[cfg(feature = "alloc")]
mod arguments;
#[cfg(feature = "alloc")]
mod evaluate;
pub(crate) mod layouts;
#[cfg(feature = "alloc")]
mod row;
#[cfg(feature = "alloc")]
mod shape;
pub(crate) mod table;

#[cfg(feature = "alloc")]
pub use {
    arguments::{ARGUMENTS, Argument, ArgumentKind, BatchForm},
    row::{Function, Row},
    shape::{Elements, Record, Shape, Sizes, shapes},
};
