//! Several numbers side by side in one register, as a scalar: a lane is a state.
//!
//! Each instruction set has a file of its own with its vectors, and one function that is compiled for
//! it. The vectors can't be named from outside: they reach generic code as the type parameter of
//! [`BatchTask::run`] only, which is called only where the processor has what they need, so that their
//! operations need no proof each time. All of it is inlined into that one function: what were
//! not would lose the instruction set, and with it the speed. (A function that has the instruction set itself,
//! as `fused` has, loses nothing but the call.)

#[cfg(target_arch = "x86_64")]
#[allow(dead_code)] // Left out where the program counts on more.
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
mod level;
#[cfg(target_arch = "aarch64")]
#[allow(dead_code)] // Left out where the target lacks it.
mod neon;
#[cfg(any(target_arch = "x86_64", target_arch = "aarch64"))]
mod pair;
#[cfg(any(target_arch = "x86_64", target_arch = "aarch64"))]
mod simd;
mod single;
#[cfg(target_arch = "x86_64")]
#[allow(dead_code)] // Left out where the program counts on more.
mod sse2;
#[cfg(any(target_arch = "x86_64", target_arch = "aarch64"))]
mod vector;

use crate::Scalar;
pub use crate::scalar::simd::Chunk;
use crate::scalar::simd::SimdTask;
use crate::scalar::trig::Precision;
pub use level::{SimdLevel, force_level, level};

/// Numbers side by side, which the same operations are applied to.
pub trait Lanes: Scalar {
    /// Each of them.
    type Lane: Float;

    /// How many.
    const LANES: usize;

    /// The same number in all lanes.
    #[must_use]
    fn splat(number: Self::Lane) -> Self;

    /// Does part of the work in a function of its own, compiled for the same instructions: what is too
    /// long for one takes the compiler more than linear time.
    fn outlined<P: Chunk>(part: P) -> P::Output;

    /// The numbers from `from` on.
    ///
    /// # Safety
    ///
    /// [`LANES`](Self::LANES) numbers can be read there.
    #[allow(unsafe_code)] // It reads through a pointer.
    #[doc(hidden)]
    #[must_use]
    unsafe fn load(from: *const Self::Lane) -> Self;

    /// Puts the numbers from `to` on.
    ///
    /// # Safety
    ///
    /// [`LANES`](Self::LANES) numbers can be written there.
    #[allow(unsafe_code)] // It writes through a pointer.
    #[doc(hidden)]
    unsafe fn store(self, to: *mut Self::Lane);
}

/// A floating-point number that there are lanes of: `f64` or `f32`.
#[allow(private_bounds)] // Nobody else can implement it.
pub trait Float: Scalar + Precision + Send + Sync {
    /// Runs `work` on as many lanes as the processor has.
    #[doc(hidden)]
    fn dispatch(work: impl BatchTask<Self>);
}

/// What can be done on any lanes. Its `run` must be `#[inline(always)]`, and all that it calls.
#[doc(hidden)]
pub trait BatchTask<F> {
    /// Does it.
    fn run<L: Lanes<Lane = F>>(self);
}

/// Most lanes of any vector.
pub(crate) const MAX_LANES: usize = 16;

macro_rules! dispatch {
    ($($float:ident by $run_simd:ident)*) => {$(
        /// Runs `work` on the best vectors for numbers of one state, or without. There is no way on SSE2: it
        /// would be as much work for rustc as each of the others, and gains little by two lanes. Where the
        /// program counts on AVX2, there is no way without.
        #[inline]
        #[allow(unsafe_code)] // Calls of functions for the instructions found to be there.
        pub(crate) fn $run_simd<W: SimdTask<$float>>(work: W) -> W::Output {
            // Few lanes gain nothing by longer vectors.
            #[cfg(target_arch = "x86_64")]
            if cfg!(all(target_feature = "avx2", target_feature = "fma")) || level() >= SimdLevel::Avx2 {
                // SAFETY: the program counts on AVX2 and FMA, or `level` has found them; AVX-512 includes both.
                return unsafe { avx2::$run_simd(work) };
            }
            // All code fuses products there, and nothing is gained for numbers alone.
            #[cfg(all(target_arch = "aarch64", target_feature = "neon"))]
            if W::HAS_PACKS {
                return neon::$run_simd(work);
            }
            work.scalar()
        }

        impl Float for $float {
            #[inline]
            #[allow(unsafe_code)] // Calls of functions for the instructions found to be there.
            fn dispatch(work: impl BatchTask<Self>) {
                match level() {
                    // SAFETY: `level` names what the processor has.
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
