//! Vectors of each instruction set for several values of one state, such as those of equal limbs.
//!
//! Unsafe code: the macros expand in the files of the instruction sets, whose headers justify it.

use super::Lanes;

/// A vector type with one lane.
pub trait One: Lanes {
    /// Returns the lane.
    fn number(self) -> Self::Lane;
}

macro_rules! one {
    ($($float:ident)*) => {$(
        impl One for $float {
            #[inline(always)]
            fn number(self) -> $float {
                self
            }
        }
    )*};
}

one!(f64 f32);

/// Implements packs in the first lanes of vectors; the remaining lanes repeat them. The lanes are written out
/// instead of looped over, since rustc would have to unroll a loop at each use.
macro_rules! beside {
    ($($vector:ty: $lanes:literal of $one:ty, [$($apart:literal)*] in [$($lane:literal)*];)*) => {$(
        impl crate::scalar::abreast::Beside<$one, $lanes> for $vector {
            #[inline(always)]
            fn all(number: $one) -> Self {
                <Self as crate::lanes::Lanes>::splat(crate::lanes::abreast::One::number(number))
            }

            #[inline(always)]
            fn beside(numbers: [$one; $lanes]) -> Self {
                Self::from_numbers([$(crate::lanes::abreast::One::number(numbers[$lane])),*])
            }

            #[inline(always)]
            #[allow(clippy::cast_possible_truncation)]
            fn constants(numbers: [f64; $lanes]) -> Self {
                Self::from_numbers([$(numbers[$lane] as _),*])
            }

            #[inline(always)]
            fn apart(self) -> [$one; $lanes] {
                let numbers = self.numbers();
                [$(<$one as crate::lanes::Lanes>::splat(numbers[$apart])),*]
            }
        }
    )*};
}

/// Defines the vector types of an instruction set, and the function that runs work on them, compiled with
/// `$features`.
macro_rules! vectors {
    ($(
        $float:ident by $function:ident on $set:ident $($features:literal)?:
        $one:ty, $two:ty, $four:ty, $eight:ty;
    )*) => {
        $(
            /// The vector types of these instructions.
            pub enum $set {}

            impl crate::scalar::abreast::Vectors for $set {
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
                    crate::lanes::abreast::One::number(one)
                }

                #[inline(always)]
                fn outlined<P: crate::lanes::Part>(part: P) -> P::Output {
                    $(#[target_feature(enable = $features)])?
                    #[inline(never)]
                    fn run<P: crate::lanes::Part>(part: P) -> P::Output {
                        part.run()
                    }
                    // SAFETY: the processor has the instructions, see the module's header.
                    unsafe { run(part) }
                }
            }

            $(#[target_feature(enable = $features)])?
            pub(super) fn $function<W: crate::scalar::abreast::Abreast<$float>>(work: W) -> W::Output {
                work.vectors::<$set>()
            }
        )*
    };
}

pub(super) use {beside, vectors};
