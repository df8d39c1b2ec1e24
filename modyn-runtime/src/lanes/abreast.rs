//! Vectors of each instruction set for several numbers of one state.
//!
//! Unsafe code: what these macros write stands in the instruction sets' files, and so under their proofs; stores
//! go to arrays of as many places as any vector has.

use super::Lanes;
use crate::Scalar;

/// The numbers of a vector, in as many places as any has.
#[inline(always)]
#[allow(unsafe_code)] // It writes through a pointer.
pub(super) fn numbers<L: Lanes>(lanes: L) -> [L::Lane; super::MOST_LANES] {
    let mut numbers = [L::Lane::zero(); super::MOST_LANES];
    // SAFETY: no vector has more.
    unsafe { lanes.store(numbers.as_mut_ptr()) }
    numbers
}

/// The first lanes of vectors as numbers side by side; what is behind them repeats.
macro_rules! beside {
    ($($vector:ty: $lanes:literal of $one:ty;)*) => {$(
        impl crate::scalar::abreast::Beside<$one, $lanes> for $vector {
            #[inline(always)]
            fn all(number: $one) -> Self {
                let number = crate::lanes::abreast::numbers(number)[0];
                <Self as crate::lanes::Lanes>::splat(number)
            }

            #[inline(always)]
            fn beside(numbers: [$one; $lanes]) -> Self {
                let first = crate::lanes::abreast::numbers(numbers[0])[0];
                let mut lanes = [first; <Self as crate::lanes::Lanes>::LANES];
                let mut i = 1;
                while i < lanes.len() {
                    lanes[i] = crate::lanes::abreast::numbers(numbers[i % $lanes])[0];
                    i += 1;
                }
                Self::from_numbers(lanes)
            }

            #[inline(always)]
            fn apart(self) -> [$one; $lanes] {
                let numbers = self.numbers();
                let mut apart = [<$one as crate::lanes::Lanes>::splat(numbers[0]); $lanes];
                let mut i = 1;
                while i < $lanes {
                    apart[i] = <$one as crate::lanes::Lanes>::splat(numbers[i]);
                    i += 1;
                }
                apart
            }
        }
    )*};
}

/// The vectors of a set of instructions, with the function that works on it, compiled with
/// `$features`.
macro_rules! vectors {
    ($(
        $float:ident by $function:ident on $set:ident $($features:literal)?:
        $one:ty, $two:ty, $four:ty, $eight:ty;
    )*) => {
        $(
            /// The vectors of these instructions.
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
                    crate::lanes::abreast::numbers(one)[0]
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
