//! The tests of kernels, one module a topic.

mod common;
mod compiled;
mod contacts;
mod kernels;
mod rollouts;
mod validation;
