//! How property tests run: the same cases on every host and in every run.

use std::env::var_os;

use modyn_runtime::model::Model;
use proptest::prelude::*;
use proptest::test_runner::{Config, RngSeed};

use crate::random::{general_tree, general_zoo, tree, zoo};

/// That many cases from a fixed seed; `PROPTEST_CASES` and `PROPTEST_RNG_SEED` choose others.
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

/// A random robot, by seed and links, so that a failed case is printed in a line.
#[derive(Clone, Copy, Debug)]
pub enum Robot {
    /// [`tree`].
    Tree(u64, usize),
    /// [`zoo`].
    Zoo(u64, usize),
    /// [`general_tree`].
    GeneralTree(u64, usize),
    /// [`general_zoo`].
    GeneralZoo(u64, usize),
}

impl Robot {
    /// The robot.
    #[must_use]
    pub fn model(self) -> Model {
        match self {
            Self::Tree(seed, links) => tree(seed, links),
            Self::Zoo(seed, links) => zoo(seed, links),
            Self::GeneralTree(seed, links) => general_tree(seed, links),
            Self::GeneralZoo(seed, links) => general_zoo(seed, links),
        }
    }

    /// A seed for whatever else is random.
    #[must_use]
    pub fn seed(self) -> u64 {
        let (Self::Tree(seed, _)
        | Self::Zoo(seed, _)
        | Self::GeneralTree(seed, _)
        | Self::GeneralZoo(seed, _)) = self;
        seed
    }
}

/// Random robots of up to that many links, those with all joint types up to half as many: that is
/// about the same degrees of freedom. Half of the robots are in general position.
pub fn robots(links: usize) -> impl Strategy<Value = Robot> {
    prop_oneof![
        1 => (any::<u64>(), 1..=links).prop_map(|(seed, links)| Robot::Tree(seed, links)),
        1 => (any::<u64>(), 1..=links).prop_map(|(seed, links)| Robot::GeneralTree(seed, links)),
        2 => zoos(links.div_ceil(2)),
    ]
}

/// Random robots with all joint types of up to that many links; half of them in general position.
pub fn zoos(links: usize) -> impl Strategy<Value = Robot> {
    (any::<u64>(), 1..=links, any::<bool>()).prop_map(|(seed, links, general)| match general {
        false => Robot::Zoo(seed, links),
        true => Robot::GeneralZoo(seed, links),
    })
}
