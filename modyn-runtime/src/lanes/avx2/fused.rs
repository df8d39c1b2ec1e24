//! Single values with fused multiply-add, for use beside AVX2's vectors.
//!
//! Unsafe code: these types exist only where the processor has AVX2 and FMA, see the folder's
//! header.
#![allow(unsafe_code)]

use core::arch::x86_64::*;
use core::ops::{Add, Div, Mul, Neg, Sub};

use super::registers::{F32x8, F64x4};
use crate::Scalar;
use crate::lanes::simd::SingleLane;
use crate::lanes::{Chunk, Lanes};
use crate::scalar::trig::{FlipSign, Precision};

macro_rules! fused {
    ($name:ident $float:ident beside $vector:ident: $set:ident $fmadd:ident $first:ident) => {
        /// A single value.
        #[derive(Clone, Copy)]
        #[repr(transparent)]
        pub struct $name($float);

        impl Lanes for $name {
            type Lane = $float;
            const LANES: usize = 1;

            #[inline(always)]
            fn splat(number: $float) -> Self {
                Self(number)
            }

            #[inline(always)]
            fn outlined<P: Chunk>(part: P) -> P::Output {
                #[target_feature(enable = "avx2,fma")]
                #[inline(never)]
                fn run<P: Chunk>(part: P) -> P::Output {
                    part.run()
                }
                // SAFETY: the processor has the instructions, see the header.
                unsafe { run(part) }
            }

            #[inline(always)]
            unsafe fn load(from: *const $float) -> Self {
                // SAFETY: the caller's promise.
                Self(unsafe { *from })
            }

            #[inline(always)]
            unsafe fn store(self, to: *mut $float) {
                // SAFETY: the caller's promise.
                unsafe { *to = self.0 }
            }
        }


        impl SingleLane for $name {
            #[inline(always)]
            fn number(self) -> $float {
                self.0
            }
        }

        impl FlipSign for $name {
            #[inline(always)]
            fn flip_sign(self, by: Self) -> Self {
                Self(self.0.flip_sign(by.0))
            }
        }

        operator!($name Add add, Sub sub, Mul mul, Div div);

        impl Neg for $name {
            type Output = Self;

            #[inline(always)]
            fn neg(self) -> Self {
                Self(-self.0)
            }
        }

        impl Scalar for $name {
            #[inline(always)]
            #[allow(clippy::cast_possible_truncation)]
            fn from_f64(value: f64) -> Self {
                Self(value as $float)
            }

            #[inline(always)]
            fn mul_add(self, factor: Self, term: Self) -> Self {
                // A separate function, so that the instruction is enabled in it.
                #[inline]
                #[target_feature(enable = "avx2,fma")]
                fn fused(a: $float, b: $float, c: $float) -> $float {
                    $first($fmadd($set(a), $set(b), $set(c)))
                }
                // SAFETY: the processor has the instructions, see the header.
                Self(unsafe { fused(self.0, factor.0, term.0) })
            }

            #[inline(always)]
            fn sin_cos(self) -> (Self, Self) {
                // `<` is false for NaN.
                if Scalar::abs(self.0) < <$float as Precision>::LIMIT {
                    <$float as Precision>::reduced(self)
                } else {
                    let (sin, cos) = self.0.unreduced();
                    (Self(sin), Self(cos))
                }
            }

            #[inline(always)]
            fn sin_cos_all<const N: usize>(angles: [Self; N]) -> [(Self, Self); N] {
                let mut numbers = [0.0; N];
                // No iterators or closures: they might not be inlined, and lose the instructions.
                let mut i = 0;
                while i < N {
                    numbers[i] = angles[i].0;
                    i += 1;
                }
                let turns = $vector::sin_cos_of(numbers);
                let mut all = [(Self(0.0), Self(0.0)); N];
                i = 0;
                while i < N {
                    all[i] = (Self(turns[i].0), Self(turns[i].1));
                    i += 1;
                }
                all
            }

            #[inline(always)]
            fn atan2(self, x: Self) -> Self {
                Self(Scalar::atan2(self.0, x.0))
            }

            #[inline(always)]
            fn sqrt(self) -> Self {
                Self(Scalar::sqrt(self.0))
            }

            #[inline(always)]
            fn ln(self) -> Self {
                Self(Scalar::ln(self.0))
            }

            #[inline(always)]
            fn abs(self) -> Self {
                Self(Scalar::abs(self.0))
            }

            #[inline(always)]
            fn max(self, other: Self) -> Self {
                Self(Scalar::max(self.0, other.0))
            }

            #[inline(always)]
            fn select_nonnegative(self, then: Self, otherwise: Self) -> Self {
                if self.0 >= 0.0 { then } else { otherwise }
            }

            #[inline(always)]
            fn is_known_nonnegative(self) -> bool {
                self.0 >= 0.0
            }
        }
    };
}

macro_rules! operator {
    ($name:ident $($trait:ident $function:ident),*) => {$(
        impl $trait for $name {
            type Output = Self;

            #[inline(always)]
            fn $function(self, other: Self) -> Self {
                Self(self.0.$function(other.0))
            }
        }
    )*};
}

fused!(F64x1 f64 beside F64x4: _mm_set_sd _mm_fmadd_sd _mm_cvtsd_f64);
fused!(F32x1 f32 beside F32x8: _mm_set_ss _mm_fmadd_ss _mm_cvtss_f32);
