//! The tests of the paper's equations, and of robots on the ground.

mod contacts;
mod data;
mod decomposition;
mod ground;
mod loops;
mod page;
