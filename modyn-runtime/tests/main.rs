//! The tests of the runtime, one module a topic.

mod borders;
mod coordinates;
mod dissipation;
mod inertias;
mod no_panic;
