//! The tests of kernels, one module a topic.

mod common;
mod compiled;
#[allow(dead_code)]
#[path = "../../tests/src/conformance/mod.rs"]
mod conformance;
mod contacts;
mod kernels;
mod page;
#[allow(dead_code)]
#[path = "../../tests/src/random.rs"]
mod random;
mod rollouts;
mod suite;
mod validation;
