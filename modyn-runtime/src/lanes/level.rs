//! The available vector instructions.

#[cfg(all(feature = "std", target_arch = "x86_64"))]
use core::sync::atomic::{AtomicU8, Ordering};

/// The vector instructions of batches, and of single states with packed limbs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum SimdLevel {
    /// No vectors: one state at a time.
    Single,
    /// x86-64's baseline: 2 `f64` or 4 `f32`.
    Sse2,
    /// AVX2 and FMA: 4 `f64` or 8 `f32`.
    Avx2,
    /// AVX-512 (F and VL): 8 `f64` or 16 `f32`.
    Avx512,
    /// aarch64's baseline: 2 `f64` or 4 `f32`.
    Neon,
}

/// The level that replaces the best one, plus 1; 0 for none.
#[cfg(all(feature = "std", target_arch = "x86_64"))]
static FORCED: AtomicU8 = AtomicU8::new(0);

/// Returns the vector instructions that batches use. With `std` they are the best that the
/// processor has; without `std`, the best that the target guarantees.
#[inline]
#[must_use]
pub fn level() -> SimdLevel {
    #[cfg(all(feature = "std", target_arch = "x86_64"))]
    {
        let forced = FORCED.load(Ordering::Relaxed);
        X86.into_iter().find(|&level| level as u8 + 1 == forced).unwrap_or_else(best_level)
    }
    #[cfg(not(all(feature = "std", target_arch = "x86_64")))]
    best_level()
}

/// Makes batches use `level`, or the best level for `None`. Returns false if the processor lacks
/// the level, or if the program is compiled for another one. For tests and benchmarks.
#[doc(hidden)]
pub fn force_level(level: Option<SimdLevel>) -> bool {
    #[cfg(all(feature = "std", target_arch = "x86_64"))]
    {
        let available = level.is_none_or(|level| (lowest_level()..=best_level()).contains(&level));
        if available {
            FORCED.store(level.map_or(0, |level| level as u8 + 1), Ordering::Relaxed);
        }
        available
    }
    #[cfg(not(all(feature = "std", target_arch = "x86_64")))]
    level.is_none_or(|level| level == best_level())
}

#[cfg(all(feature = "std", target_arch = "x86_64"))]
const X86: [SimdLevel; 3] = [SimdLevel::Sse2, SimdLevel::Avx2, SimdLevel::Avx512];

/// Returns the level that every processor has that can run the program.
#[cfg(target_arch = "x86_64")]
fn lowest_level() -> SimdLevel {
    if cfg!(all(target_feature = "avx512f", target_feature = "avx512vl")) {
        SimdLevel::Avx512
    } else if cfg!(all(target_feature = "avx2", target_feature = "fma")) {
        SimdLevel::Avx2
    } else {
        SimdLevel::Sse2
    }
}

#[cfg(target_arch = "x86_64")]
fn best_level() -> SimdLevel {
    #[cfg(feature = "std")]
    if std::is_x86_feature_detected!("avx512f") && std::is_x86_feature_detected!("avx512vl") {
        return SimdLevel::Avx512;
    } else if std::is_x86_feature_detected!("avx2") && std::is_x86_feature_detected!("fma") {
        return SimdLevel::Avx2;
    }
    lowest_level()
}

#[cfg(not(target_arch = "x86_64"))]
fn best_level() -> SimdLevel {
    // Soft-float targets for kernels have no NEON.
    if cfg!(all(target_arch = "aarch64", target_feature = "neon")) {
        SimdLevel::Neon
    } else {
        SimdLevel::Single
    }
}
