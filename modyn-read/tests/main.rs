//! The tests of the reader, one module a topic.

mod actuators;
mod collisions;
mod diagnostics;
mod doubling;
mod hostile;
mod mjcf;
mod reading;
mod sdf;
mod shapes;
mod tendons;
mod touching;
mod units;
mod write;
mod xacro;
