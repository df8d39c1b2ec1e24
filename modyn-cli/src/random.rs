//! Random numbers: the same for the same seed, on every machine.

/// `SplitMix64` (Steele, Lea and Flood 2014).
pub struct Random(u64);

impl Random {
    /// Returns the generator with this seed.
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// Returns a number uniformly distributed in 0..1.
    pub fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        bits ^= bits >> 31;
        // The upper 53 bits are exact in a double.
        (bits >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Returns a number uniformly distributed in -`most`..`most`.
    #[cfg(feature = "command")]
    pub fn symmetric(&mut self, most: f64) -> f64 {
        most * (2.0 * self.uniform() - 1.0)
    }
}

#[cfg(all(test, feature = "command"))]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_those_of_the_publication() {
        // The first output for seed 0 of the reference implementation is e220a8397b1dcdaf.
        let first = (0xe220_a839_7b1d_cdaf_u64 >> 11) as f64 / (1_u64 << 53) as f64;
        assert!((Random::new(0).uniform() - first).abs() < 1e-16);
        let mut random = Random::new(7);
        let mean = (0..10_000).map(|_| random.symmetric(1.0)).sum::<f64>() / 10_000.0;
        assert!(mean.abs() < 0.03, "{mean}");
    }
}
