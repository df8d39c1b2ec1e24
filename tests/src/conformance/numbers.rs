//! The numbers of references: plain ones, and numbers that fuse products with sums as back ends do.

use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Neg, Sub};

use modyn_codegen::plan::{Frames, Planned};
use modyn_codegen::program::Program;
use modyn_runtime::Scalar;
use modyn_runtime::batch::Float;
use modyn_runtime::trig_steps::{self, Step, Steps};

/// The arithmetic of a back end, by which the reference is computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Arithmetic {
    /// Products and sums are rounded apart: the same bits.
    Separate,
    /// Products are fused into sums, except within sines: the same bits.
    Fused,
    /// Products are fused into sums everywhere: the same bits.
    FusedSines,
    /// The language has its own sine, or an order of its own: results differ as if arguments were rounded by this part.
    Own(f64),
}

/// A floating-point type: `f64` or `f32`.
pub trait Number: Float + PartialOrd + Debug + Into<f64> {
    /// Returns `self a + b`, rounded once.
    #[must_use]
    fn fused(self, a: Self, b: Self) -> Self;

    /// Returns whether the last bit of the mantissa is one.
    #[must_use]
    fn low_bit(self) -> bool;

    /// Returns the number with these bits.
    #[must_use]
    fn of_bits(bits: u64) -> Self;

    /// Returns whether two numbers have the same bits; every NaN equals every other.
    #[must_use]
    fn is_same(self, other: Self) -> bool {
        is_same(self.into(), other.into())
    }
}

macro_rules! number {
    ($($float:ty, $bits:ty;)*) => {$(
        impl Number for $float {
            fn fused(self, a: Self, b: Self) -> Self {
                <$float>::mul_add(self, a, b)
            }

            fn low_bit(self) -> bool {
                self.to_bits() & 1 == 1
            }

            fn of_bits(bits: u64) -> Self {
                Self::from_bits(bits as $bits)
            }
        }
    )*};
}

number! {
    f64, u64;
    f32, u32;
}

/// Returns whether two numbers have the same bits; every NaN equals every other.
#[must_use]
pub fn is_same(a: f64, b: f64) -> bool {
    a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan()
}

/// Programs that are evaluated on any numbers.
pub trait Evaluate {
    /// Returns the results for these arguments, one after the other.
    fn evaluate<S: Scalar>(&self, arguments: &[S]) -> Vec<S>;
}

impl Evaluate for Program {
    fn evaluate<S: Scalar>(&self, arguments: &[S]) -> Vec<S> {
        self.evaluate(arguments)
    }
}

/// A function of a plan as a back end runs it.
pub struct Reference<'a> {
    /// The function.
    pub planned: &'a Planned,
    /// The links of the plan.
    pub frames: &'a Frames,
    /// The link of a function of one link.
    pub link: usize,
    /// Whether the back end runs the program on vectors.
    pub on_vectors: bool,
}

impl Evaluate for Reference<'_> {
    fn evaluate<S: Scalar>(&self, arguments: &[S]) -> Vec<S> {
        match self.planned.kernels.straight() {
            Some((_, simd)) if self.on_vectors => simd.evaluate(arguments),
            _ => self.planned.evaluate(self.frames, self.link, arguments),
        }
    }
}

/// Returns results in the arithmetic of a back end.
pub fn evaluate<F: Number>(of: &impl Evaluate, arithmetic: Arithmetic, arguments: &[F]) -> Vec<F> {
    fn fused<F: Number, const SINES: bool>(of: &impl Evaluate, arguments: &[F]) -> Vec<F> {
        let arguments: Vec<Fused<F, SINES>> = arguments.iter().copied().map(Fused).collect();
        of.evaluate(&arguments).into_iter().map(|x| x.0).collect()
    }
    match arithmetic {
        Arithmetic::Separate | Arithmetic::Own(_) => of.evaluate(arguments),
        Arithmetic::Fused => fused::<F, false>(of, arguments),
        Arithmetic::FusedSines => fused::<F, true>(of, arguments),
    }
}

/// A number that fuses products with sums, also within sines if `SINES`.
#[derive(Clone, Copy, Debug)]
struct Fused<F, const SINES: bool>(F);

macro_rules! operator {
    ($($operator:ident $function:ident,)*) => {$(
        impl<F: Number, const SINES: bool> $operator for Fused<F, SINES> {
            type Output = Self;

            fn $function(self, other: Self) -> Self {
                Self(self.0.$function(other.0))
            }
        }
    )*};
}

operator!(Add add, Sub sub, Mul mul, Div div,);

impl<F: Number, const SINES: bool> Neg for Fused<F, SINES> {
    type Output = Self;

    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl<F: Number, const SINES: bool> Scalar for Fused<F, SINES> {
    fn from_f64(value: f64) -> Self {
        Self(F::from_f64(value))
    }

    fn is_known_nonnegative(self) -> bool {
        self.0.is_known_nonnegative()
    }

    fn mul_add(self, factor: Self, term: Self) -> Self {
        Self(self.0.fused(factor.0, term.0))
    }

    fn sin_cos(self) -> (Self, Self) {
        if !SINES {
            let (sine, cosine) = self.0.sin_cos();
            return (Self(sine), Self(cosine));
        }
        let reduced = if self.0.abs() < trig_steps::limit() {
            run(&Steps::reduction::<F>(), [self; 2])
        } else {
            trig_steps::reduce_far(self.0).map(Self)
        };
        let [sine, cosine] = run(&Steps::polynomials::<F>(), reduced);
        (sine, cosine)
    }

    fn atan2(self, x: Self) -> Self {
        Self(self.0.atan2(x.0))
    }

    fn sqrt(self) -> Self {
        Self(self.0.sqrt())
    }

    fn ln(self) -> Self {
        Self(self.0.ln())
    }

    fn abs(self) -> Self {
        Self(self.0.abs())
    }

    fn max(self, other: Self) -> Self {
        Self(self.0.max(other.0))
    }

    fn select_nonnegative(self, then: Self, otherwise: Self) -> Self {
        Self(self.0.select_nonnegative(then.0, otherwise.0))
    }
}

fn run<F: Number, const SINES: bool>(
    steps: &Steps,
    inputs: [Fused<F, SINES>; 2],
) -> [Fused<F, SINES>; 2] {
    let mut values: Vec<Fused<F, SINES>> = Vec::new();
    for step in &steps.steps {
        values.push(match *step {
            Step::Input(number) => inputs[number],
            Step::Constant(value) => Fused::from_f64(value),
            Step::Add(a, b) => values[a] + values[b],
            Step::Subtract(a, b) => values[a] - values[b],
            Step::Multiply(a, b) => values[a] * values[b],
            Step::MultiplyAdd(a, b, c) => values[a].mul_add(values[b], values[c]),
            Step::FlipSign(a, b) if values[b].0.low_bit() => -values[a],
            Step::FlipSign(a, _) => values[a],
        });
    }
    steps.results.map(|step| values[step])
}
