//! One lane: a number itself, where there are no vectors.
//!
//! Unsafe code: `load` and `store` go through pointers, which is sound by what their callers promise.
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
                // SAFETY: the caller's promise.
                unsafe { *from }
            }

            #[inline(always)]
            unsafe fn store(self, to: *mut Self) {
                // SAFETY: the caller's promise.
                unsafe { *to = self }
            }
        }

        pub(super) fn $float(work: impl BatchTask<$float>) {
            work.run::<$float>();
        }
    )*};
}

single!(f64 f32);
