//! One lane: the number itself, for processors without vectors.
//!
//! Unsafe code: `load` and `store` use pointers, which is sound by their callers' contract.
#![allow(unsafe_code)]

use super::{BatchTask, Chunk, Lanes};

macro_rules! single {
    ($($float:ident)*) => {$(
        impl Lanes for $float {
            type Lane = Self;
            const LANES: usize = 1;

            #[inline(always)]
            fn splat(number: Self) -> Self {
                number
            }

            #[inline(never)]
            fn outlined<P: Chunk>(part: P) -> P::Output {
                part.run()
            }

            #[inline(always)]
            unsafe fn load(from: *const Self) -> Self {
                // SAFETY: the caller's contract.
                unsafe { *from }
            }

            #[inline(always)]
            unsafe fn store(self, to: *mut Self) {
                // SAFETY: the caller's contract.
                unsafe { *to = self }
            }
        }

        pub(super) fn $float(work: impl BatchTask<$float>) {
            work.run::<$float>();
        }
    )*};
}

single!(f64 f32);
