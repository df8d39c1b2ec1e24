//! The table of quantities: all functions of a robot, each with its arguments, its result and its
//! properties.
//!
//! A row ([`ROWS`]) has everything that is true of a function wherever it is computed. From it follow
//! the trait [`Robot`](crate::Robot) with its [`functions`](crate::functions), the functions that
//! the compiler traces, and the functions of every language.
//! [`Interpreter::evaluate`](crate::Interpreter::evaluate) computes any of them from numbers.

mod arguments;
mod evaluate;
mod function;
mod lookup;
mod row;
mod shape;
#[allow(missing_docs)]
#[doc(hidden)]
pub mod shapes;
mod table;

pub use {
    arguments::{ARGUMENTS, Argument, ArgumentKind, BatchForm},
    function::Function,
    row::Row,
    shape::{Elements, Record, Shape, Sizes},
    table::ROWS,
};
