//! Vectors of each instruction set for several values of one state, such as the values of equal
//! limbs.
//!
//! Unsafe code: the macros expand in the files of the instruction sets, whose headers justify it.

use super::Lanes;

/// A vector type with one lane.
pub trait SingleLane: Lanes {
    /// Returns the lane.
    fn number(self) -> Self::Lane;
}

macro_rules! one {
    ($($float:ident)*) => {$(
        impl SingleLane for $float {
            #[inline(always)]
            fn number(self) -> $float {
                self
            }
        }
    )*};
}

one!(f64 f32);

/// Implements packs in the first lanes of vectors; the remaining lanes repeat them. The lanes are
/// written out instead of looped over, since rustc would have to unroll a loop at each use.
macro_rules! pack {
    ($($vector:ty: $lanes:literal of $one:ty, [$($unpacked:literal)*] in [$($lane:literal)*];)*) => {$(
        impl crate::scalar::Pack<$one, $lanes> for $vector {
            #[inline(always)]
            fn broadcast(number: $one) -> Self {
                <Self as crate::lanes::Lanes>::splat(crate::lanes::simd::SingleLane::number(number))
            }

            #[inline(always)]
            fn pack(numbers: [$one; $lanes]) -> Self {
                Self::from_numbers([$(crate::lanes::simd::SingleLane::number(numbers[$lane])),*])
            }

            #[inline(always)]
            #[allow(clippy::cast_possible_truncation)]
            fn constants(numbers: [f64; $lanes]) -> Self {
                Self::from_numbers([$(numbers[$lane] as _),*])
            }

            #[inline(always)]
            fn unpack(self) -> [$one; $lanes] {
                let numbers = self.numbers();
                [$(<$one as crate::lanes::Lanes>::splat(numbers[$unpacked])),*]
            }
        }
    )*};
}

/// Defines the vector types of an instruction set, and the function that runs work on them,
/// compiled with `$features`.
macro_rules! backend {
    ($(
        $float:ident by $function:ident on $set:ident $($features:literal)?:
        $one:ty, $two:ty, $four:ty, $eight:ty;
    )*) => {
        $(
            /// The vector types of these instructions.
            pub enum $set {}

            impl crate::scalar::SimdBackend for $set {
                type Number = $float;
                type One = $one;
                type Two = $two;
                type Four = $four;
                type Eight = $eight;

                #[inline(always)]
                fn one(number: $float) -> $one {
                    <$one as crate::lanes::Lanes>::splat(number)
                }

                #[inline(always)]
                fn number(one: $one) -> $float {
                    crate::lanes::simd::SingleLane::number(one)
                }

                #[inline(always)]
                fn outlined<P: crate::lanes::Chunk>(part: P) -> P::Output {
                    $(#[target_feature(enable = $features)])?
                    #[inline(never)]
                    fn run<P: crate::lanes::Chunk>(part: P) -> P::Output {
                        part.run()
                    }
                    // SAFETY: the processor has the instructions, see the module's header.
                    unsafe { run(part) }
                }
            }

            $(#[target_feature(enable = $features)])?
            pub(super) fn $function<W: crate::scalar::SimdTask<$float>>(work: W) -> W::Output {
                work.vectorized::<$set>()
            }
        )*
    };
}

pub(super) use {backend, pack};
