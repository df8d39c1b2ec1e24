//! A vector type of an instruction set, written once as a macro over the names of the instructions.
//!
//! Unsafe code: the macros expand in the files of the instruction sets, whose headers justify it.
//! `numbers` stores to an array of the vector's own size; callers of `load` and `store` guarantee
//! the room.

/// Defines a vector of `$lanes` numbers in `$register`, whose instructions need `$features`.
///
/// Operations with an instruction of their own are given by its name, others as expressions over
/// registers.
macro_rules! vector {
    (
        $name:ident: [$float:ident; $lanes:literal] in $register:ident $(, $features:literal)?;
        $splat:ident $load:ident $store:ident $add:ident $sub:ident $mul:ident $div:ident $sqrt:ident $abs:ident;
        mul_add($a:ident, $b:ident, $c:ident) $fused:expr;
        max($d:ident, $e:ident) $max:expr;
        select($f:ident, $g:ident, $h:ident) $select:expr;
        below($i:ident, $j:ident) $below:expr;
        flip($k:ident, $l:ident) $flip:expr;
    ) => {
        /// Numbers in a register.
        #[derive(Clone, Copy)]
        #[repr(transparent)]
        pub struct $name($register);

        impl $name {
            #[inline(always)]
            pub(super) fn numbers(self) -> [$float; $lanes] {
                let mut numbers = [0.0; $lanes];
                // SAFETY: the array has `$lanes` entries.
                unsafe { crate::lanes::Lanes::store(self, numbers.as_mut_ptr()) }
                numbers
            }

            #[inline(always)]
            pub(super) fn from_numbers(numbers: [$float; $lanes]) -> Self {
                // SAFETY: the array has `$lanes` entries.
                unsafe { crate::lanes::Lanes::load(numbers.as_ptr()) }
            }

            /// Returns whether all lanes are below the limit of the fast argument reduction.
            #[inline(always)]
            fn reducible(self) -> bool {
                let $i = crate::Scalar::abs(self).0;
                // SAFETY: the processor has the instructions, see the module's header.
                unsafe {
                    let $j = $splat(<$float as crate::scalar::trig::Precision>::LIMIT);
                    $below
                }
            }

            /// Returns sines and cosines of single numbers, computed a vector at a time.
            #[inline(always)]
            #[allow(dead_code)] // Unused for some vectors.
            pub(super) fn sin_cos_of<const N: usize>(angles: [$float; N]) -> [($float, $float); N] {
                let mut all = [(0.0, 0.0); N];
                let mut first = 0;
                // No iterators or closures: they might not be inlined, see the module's header.
                while first < N {
                    let mut lanes = [angles[first]; $lanes];
                    let mut i = 1;
                    while i < $lanes {
                        lanes[i] = angles[if first + i < N { first + i } else { first }];
                        i += 1;
                    }
                    let (sin, cos) = crate::Scalar::sin_cos(Self::from_numbers(lanes));
                    let (sines, cosines) = (sin.numbers(), cos.numbers());
                    i = 0;
                    while i < $lanes && first + i < N {
                        all[first + i] = (sines[i], cosines[i]);
                        i += 1;
                    }
                    first += $lanes;
                }
                all
            }

            /// Returns sine and cosine, corrected in lanes beyond the limit of the fast argument
            /// reduction.
            #[inline(always)]
            fn correct_large_angles(self, (sin, cos): (Self, Self)) -> (Self, Self) {
                let (mut sines, mut cosines) = (sin.numbers(), cos.numbers());
                crate::scalar::trig::correct(&self.numbers(), &mut sines, &mut cosines);
                (Self::from_numbers(sines), Self::from_numbers(cosines))
            }
        }

        impl crate::lanes::Lanes for $name {
            type Lane = $float;
            const LANES: usize = $lanes;

            #[inline(always)]
            fn splat(number: $float) -> Self {
                // SAFETY: the processor has the instructions, see the module's header.
                Self(unsafe { $splat(number) })
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

            #[inline(always)]
            unsafe fn load(from: *const $float) -> Self {
                // SAFETY: as above, and the caller's promise.
                Self(unsafe { $load(from) })
            }

            #[inline(always)]
            unsafe fn store(self, to: *mut $float) {
                // SAFETY: as above, and the caller's promise.
                unsafe { $store(to, self.0) }
            }
        }

        crate::lanes::vector::operator!($name, Add, add, $add);
        crate::lanes::vector::operator!($name, Sub, sub, $sub);
        crate::lanes::vector::operator!($name, Mul, mul, $mul);
        crate::lanes::vector::operator!($name, Div, div, $div);

        impl core::ops::Neg for $name {
            type Output = Self;

            #[inline(always)]
            fn neg(self) -> Self {
                // LLVM recognizes this as a negation and folds it into a fused operation.
                <Self as crate::lanes::Lanes>::splat(-0.0) - self
            }
        }

        impl crate::scalar::trig::FlipSign for $name {
            #[inline(always)]
            fn flip_sign(self, by: Self) -> Self {
                let ($k, $l) = (self.0, by.0);
                // SAFETY: the processor has the instructions, see the module's header.
                Self(unsafe { $flip })
            }
        }

        impl crate::Scalar for $name {
            #[inline(always)]
            #[allow(clippy::cast_possible_truncation)]
            fn from_f64(value: f64) -> Self {
                <Self as crate::lanes::Lanes>::splat(value as $float)
            }

            #[inline(always)]
            fn zero() -> Self {
                <Self as crate::lanes::Lanes>::splat(0.0)
            }

            #[inline(always)]
            fn one() -> Self {
                <Self as crate::lanes::Lanes>::splat(1.0)
            }

            #[inline(always)]
            fn recip(self) -> Self {
                Self::one() / self
            }

            #[inline(always)]
            fn mul_add(self, factor: Self, term: Self) -> Self {
                let ($a, $b, $c) = (self.0, factor.0, term.0);
                // SAFETY: the processor has the instructions, see the module's header.
                Self(unsafe { $fused })
            }

            #[inline(always)]
            fn sin_cos(self) -> (Self, Self) {
                let reduced = <$float as crate::scalar::trig::Precision>::reduced(self);
                if self.reducible() { reduced } else { self.correct_large_angles(reduced) }
            }

            #[inline(always)]
            fn sin_cos_all<const N: usize>(angles: [Self; N]) -> [(Self, Self); N] {
                let mut all = [(Self::zero(), Self::zero()); N];
                let (mut i, mut reducible) = (0, true);
                // No iterators or closures: they might not be inlined, see the module's header.
                while i < N {
                    all[i] = <$float as crate::scalar::trig::Precision>::reduced(angles[i]);
                    reducible &= angles[i].reducible();
                    i += 1;
                }
                if !reducible {
                    i = 0;
                    while i < N {
                        all[i] = angles[i].correct_large_angles(all[i]);
                        i += 1;
                    }
                }
                all
            }

            #[inline(always)]
            fn atan2(self, x: Self) -> Self {
                let (y, x) = (self.numbers(), x.numbers());
                Self::from_numbers(core::array::from_fn(|i| crate::Scalar::atan2(y[i], x[i])))
            }

            #[inline(always)]
            fn sqrt(self) -> Self {
                // SAFETY: the processor has the instructions, see the module's header.
                Self(unsafe { $sqrt(self.0) })
            }

            #[inline(always)]
            fn ln(self) -> Self {
                Self::from_numbers(self.numbers().map(crate::Scalar::ln))
            }

            #[inline(always)]
            fn abs(self) -> Self {
                // SAFETY: the processor has the instructions, see the module's header.
                Self(unsafe { $abs(self.0) })
            }

            #[inline(always)]
            fn max(self, other: Self) -> Self {
                let ($d, $e) = (self.0, other.0);
                // SAFETY: the processor has the instructions, see the module's header.
                Self(unsafe { $max })
            }

            #[inline(always)]
            fn select_nonnegative(self, then: Self, otherwise: Self) -> Self {
                let ($f, $g, $h) = (self.0, then.0, otherwise.0);
                // SAFETY: the processor has the instructions, see the module's header.
                Self(unsafe { $select })
            }

            #[inline(always)]
            fn is_known_nonnegative(self) -> bool {
                let (numbers, mut all, mut i) = (self.numbers(), true, 0);
                while i < $lanes {
                    all &= numbers[i] >= 0.0;
                    i += 1;
                }
                all
            }
        }

    };
}

/// Defines the function that runs work on a vector of many states, compiled with `$features`.
macro_rules! work {
    ($($float:ident on $name:ident $(, $features:literal)?;)*) => {$(
        $(#[target_feature(enable = $features)])?
        #[inline(never)] // Tests look for its name in the compiled code, on every level.
        pub(super) fn $float(work: impl crate::lanes::BatchTask<$float>) {
            work.run::<$name>();
        }
    )*};
}

macro_rules! operator {
    ($name:ident, $trait:ident, $function:ident, $instruction:ident) => {
        impl core::ops::$trait for $name {
            type Output = Self;

            #[inline(always)]
            fn $function(self, other: Self) -> Self {
                // SAFETY: the processor has the instructions, see the module's header.
                Self(unsafe { $instruction(self.0, other.0) })
            }
        }
    };
}

pub(super) use {operator, vector, work};
