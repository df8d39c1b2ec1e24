//! How property tests run: the same cases on every host and in every run.

use std::env::var_os;

use proptest::test_runner::{Config, RngSeed};

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
