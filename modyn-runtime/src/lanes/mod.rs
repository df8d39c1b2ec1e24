//! SIMD vectors as scalars: several values in one register, usually a state in each lane.
//!
//! Each instruction set has a file with its vector types, and one function that is compiled for it.
//! The vector types cannot be named from outside. Generic code receives them as the type parameter
//! of [`BatchTask::run`], which is called only where the processor has the instructions, so that
//! single operations need no check. All generic code is inlined into that one function: code that
//! is not inlined would be compiled without the instruction set, and be slow. (A function that
//! enables the instruction set itself, as in `fused`, costs only the call.)

#[cfg(target_arch = "x86_64")]
#[allow(dead_code)] // Unused in programs compiled for a higher level.
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
mod level;
#[cfg(target_arch = "aarch64")]
#[allow(dead_code)] // Unused on targets without NEON.
mod neon;
#[cfg(any(target_arch = "x86_64", target_arch = "aarch64"))]
mod pair;
#[cfg(any(target_arch = "x86_64", target_arch = "aarch64"))]
mod simd;
mod single;
#[cfg(target_arch = "x86_64")]
#[allow(dead_code)] // Unused in programs compiled for a higher level.
mod sse2;
#[cfg(any(target_arch = "x86_64", target_arch = "aarch64"))]
mod vector;

use crate::Scalar;
pub use crate::scalar::Chunk;
use crate::scalar::SimdTask;
use crate::scalar::trig::Precision;
pub use level::{SimdLevel, force_level, level};

/// A vector type: the same operation applies to all its lanes.
pub trait Lanes: Scalar {
    /// The type of a lane.
    type Lane: Float;

    /// The number of lanes.
    const LANES: usize;

    /// Returns the vector with `number` in all lanes.
    #[must_use]
    fn splat(number: Self::Lane) -> Self;

    /// Returns the vector of the first numbers of a slice.
    ///
    /// # Panics
    ///
    /// If there are fewer than [`LANES`](Self::LANES).
    #[allow(unsafe_code)] // The length is checked.
    #[doc(hidden)]
    #[inline(always)]
    #[must_use]
    fn read(from: &[Self::Lane]) -> Self {
        assert!(from.len() >= Self::LANES);
        // SAFETY: there are as many numbers.
        unsafe { Self::load(from.as_ptr()) }
    }

    /// Stores the lanes in the first numbers of a slice.
    ///
    /// # Panics
    ///
    /// If there are fewer than [`LANES`](Self::LANES).
    #[allow(unsafe_code)] // The length is checked.
    #[doc(hidden)]
    #[inline(always)]
    fn write(self, to: &mut [Self::Lane]) {
        assert!(to.len() >= Self::LANES);
        // SAFETY: there is room for as many numbers.
        unsafe { self.store(to.as_mut_ptr()) }
    }

    /// Runs part of the work in a function of its own, compiled for the same instructions. rustc
    /// takes more than linear time for long functions.
    fn outlined<P: Chunk>(part: P) -> P::Output;

    /// Returns the vector of the numbers from `from` on.
    ///
    /// # Safety
    ///
    /// [`LANES`](Self::LANES) numbers can be read there.
    #[allow(unsafe_code)] // It reads through a pointer.
    #[doc(hidden)]
    #[must_use]
    unsafe fn load(from: *const Self::Lane) -> Self;

    /// Stores the lanes from `to` on.
    ///
    /// # Safety
    ///
    /// [`LANES`](Self::LANES) numbers can be written there.
    #[allow(unsafe_code)] // It writes through a pointer.
    #[doc(hidden)]
    unsafe fn store(self, to: *mut Self::Lane);
}

/// A floating-point type with vectors: `f64` or `f32`.
#[allow(private_bounds)] // Other crates cannot implement it.
pub trait Float: Scalar + Precision + Send + Sync {
    /// Runs `work` on the widest vectors of the processor.
    #[doc(hidden)]
    fn dispatch(work: impl BatchTask<Self>);
}

/// Work on vectors of any width. `run` and everything that it calls must be `#[inline(always)]`.
#[doc(hidden)]
pub trait BatchTask<F> {
    /// Does the work.
    fn run<L: Lanes<Lane = F>>(self);
}

/// The largest number of lanes of any vector.
pub(crate) const MAX_LANES: usize = 16;

macro_rules! dispatch {
    ($($float:ident by $run_simd:ident)*) => {$(
        /// Runs `work` on the best vectors for values of one state, or on scalars. SSE2 is not
        /// used: it would cost rustc as much as the other levels, and two lanes gain little.
        /// Programs compiled for AVX2 never use scalars.
        #[inline]
        #[allow(unsafe_code)] // Calls functions for instructions that were detected.
        pub(crate) fn $run_simd<W: SimdTask<$float>>(work: W) -> W::Output {
            // Few lanes do not profit from longer vectors.
            #[cfg(target_arch = "x86_64")]
            if cfg!(all(target_feature = "avx2", target_feature = "fma")) || level() >= SimdLevel::Avx2 {
                // SAFETY: the program is compiled for AVX2 and FMA, or `level` has detected them;
                // AVX-512 includes both.
                return unsafe { avx2::$run_simd(work) };
            }
            // On aarch64 all code has fused multiply-add, so single values gain nothing.
            #[cfg(all(target_arch = "aarch64", target_feature = "neon"))]
            if W::HAS_PACKS {
                return neon::$run_simd(work);
            }
            work.scalar()
        }

        impl Float for $float {
            #[inline]
            #[allow(unsafe_code)] // Calls functions for instructions that were detected.
            fn dispatch(work: impl BatchTask<Self>) {
                match level() {
                    // SAFETY: `level` returns a level that the processor has.
                    #[cfg(target_arch = "x86_64")]
                    SimdLevel::Avx512 => unsafe { avx512::$float(work) },
                    // SAFETY: as above.
                    #[cfg(all(target_arch = "x86_64", not(target_feature = "avx512vl")))]
                    SimdLevel::Avx2 => unsafe { avx2::$float(work) },
                    #[cfg(all(target_arch = "x86_64", not(target_feature = "avx2")))]
                    SimdLevel::Sse2 => sse2::$float(work),
                    #[cfg(target_arch = "aarch64")]
                    SimdLevel::Neon => neon::$float(work),
                    _ => single::$float(work),
                }
            }
        }
    )*};
}

dispatch!(f64 by run_simd_f64 f32 by run_simd_f32);

#[cfg(test)]
mod tests;
