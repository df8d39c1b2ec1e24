//! How property tests run: the same cases on every host and in every run.

use std::env::var_os;

use modyn_runtime::model::Model;
use proptest::prelude::*;
use proptest::test_runner::{Config, RngSeed};

use crate::random::{tree, zoo};

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
}

impl Robot {
    /// The robot.
    #[must_use]
    pub fn model(self) -> Model {
        match self {
            Self::Tree(seed, links) => tree(seed, links),
            Self::Zoo(seed, links) => zoo(seed, links),
        }
    }

    /// A seed for whatever else is random.
    #[must_use]
    pub fn seed(self) -> u64 {
        let (Self::Tree(seed, _) | Self::Zoo(seed, _)) = self;
        seed
    }
}

/// Random robots of up to that many links, those with all joint types up to half as many: that is
/// about the same degrees of freedom.
pub fn robots(links: usize) -> impl Strategy<Value = Robot> {
    prop_oneof![
        (any::<u64>(), 1..=links).prop_map(|(seed, links)| Robot::Tree(seed, links)),
        zoos(links.div_ceil(2)),
    ]
}

/// Random robots with all joint types of up to that many links.
pub fn zoos(links: usize) -> impl Strategy<Value = Robot> {
    (any::<u64>(), 1..=links).prop_map(|(seed, links)| Robot::Zoo(seed, links))
}
