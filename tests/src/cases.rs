//! The configuration of property tests: the same cases on every host and in every run.

use std::env::var_os;

use modyn_runtime::model::Model;
use proptest::prelude::*;
use proptest::test_runner::{Config, RngSeed};

use crate::random::{general_tree, general_zoo, tree, zoo};

/// Returns a configuration with this number of cases and a fixed seed; `PROPTEST_CASES` and `PROPTEST_RNG_SEED` replace
/// them.
#[must_use]
pub fn cases(cases: u32) -> Config {
    let mut config = Config { failure_persistence: None, ..Config::default() };
    if var_os("PROPTEST_CASES").is_none() {
        config.cases = cases;
    }
    if var_os("PROPTEST_RNG_SEED").is_none() {
        config.rng_seed = RngSeed::Fixed(0x006d_6f64_796e);
    }
    config
}

/// A random robot, given by a seed and a number of links, so that a failed case prints as one line.
#[derive(Clone, Copy, Debug)]
pub enum Robot {
    /// The robot of [`tree`].
    Tree(u64, usize),
    /// The robot of [`zoo`].
    Zoo(u64, usize),
    /// The robot of [`general_tree`].
    GeneralTree(u64, usize),
    /// The robot of [`general_zoo`].
    GeneralZoo(u64, usize),
}

impl Robot {
    /// Returns the robot.
    #[must_use]
    pub fn model(self) -> Model {
        match self {
            Self::Tree(seed, links) => tree(seed, links),
            Self::Zoo(seed, links) => zoo(seed, links),
            Self::GeneralTree(seed, links) => general_tree(seed, links),
            Self::GeneralZoo(seed, links) => general_zoo(seed, links),
        }
    }

    /// Returns a seed for all other random numbers of the test.
    #[must_use]
    pub fn seed(self) -> u64 {
        let (Self::Tree(seed, _)
        | Self::Zoo(seed, _)
        | Self::GeneralTree(seed, _)
        | Self::GeneralZoo(seed, _)) = self;
        seed
    }
}

/// Returns random robots with at most this number of links, and half of it for robots with all joint types, which gives
/// about the same degrees of freedom. Half of the robots are in general position.
pub fn robots(links: usize) -> impl Strategy<Value = Robot> {
    prop_oneof![
        1 => (any::<u64>(), 1..=links).prop_map(|(seed, links)| Robot::Tree(seed, links)),
        1 => (any::<u64>(), 1..=links).prop_map(|(seed, links)| Robot::GeneralTree(seed, links)),
        2 => zoos(links.div_ceil(2)),
    ]
}

/// Returns random robots with all joint types and at most this number of links; half of them are in general position.
pub fn zoos(links: usize) -> impl Strategy<Value = Robot> {
    (any::<u64>(), 1..=links, any::<bool>()).prop_map(|(seed, links, general)| match general {
        false => Robot::Zoo(seed, links),
        true => Robot::GeneralZoo(seed, links),
    })
}
