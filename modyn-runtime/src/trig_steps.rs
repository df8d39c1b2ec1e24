//! Sine and cosine as lists of operations, for back ends that make machine code: recorded by
//! running the functions of `trig` on a scalar that notes each operation. So the polynomials exist
//! once.

use core::ops::{Add, Div, Mul, Neg, Sub};
use std::cell::RefCell;
use std::thread_local;
use std::vec::Vec;

use crate::lanes::Float;
use crate::scalar::Scalar;
use crate::scalar::trig::FlipSign;

/// One operation. Numbers are indices of earlier steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Step {
    /// The input of that number.
    Input(usize),
    /// A constant.
    Constant(f64),
    /// a + b
    Add(usize, usize),
    /// a - b
    Subtract(usize, usize),
    /// a b
    Multiply(usize, usize),
    /// a b + c, rounded once where the target can.
    MultiplyAdd(usize, usize, usize),
    /// Minus the first number where the lowest bit of the second is set.
    FlipSign(usize, usize),
}

/// Operations in order, and the steps that are the two results.
#[derive(Clone, Debug, PartialEq)]
pub struct Steps {
    /// The operations, each after the operations that it reads.
    pub steps: Vec<Step>,
    /// The steps that are the results.
    pub results: [usize; 2],
}

impl Steps {
    /// Returns the reduction of an angle whose absolute value is below [`limit`]. Its results are
    /// the angle in [-pi/2, pi/2] that differs by a multiple of pi, and a number with the
    /// multiple's lowest bit.
    #[must_use]
    pub fn reduction<F: Float>() -> Self {
        record(|[angle, _]| F::reduce_small(angle))
    }

    /// Returns the polynomials of sine and cosine. The inputs are the results of
    /// [`reduction`](Self::reduction).
    #[must_use]
    pub fn polynomials<F: Float>() -> Self {
        record(|[angle, turns]| F::polynomials(angle, turns))
    }
}

/// Returns the absolute value below which [`Steps::reduction`] reduces an angle, rad.
#[must_use]
pub fn limit<F: Float>() -> F {
    F::LIMIT
}

/// Returns the results of [`Steps::reduction`] for an angle of any size; NaN if the angle is not
/// finite.
#[must_use]
pub fn reduce_far<F: Float>(angle: F) -> [F; 2] {
    let (reduced, turns) = angle.reduce_large();
    [reduced, turns]
}

thread_local! {
    static RECORDED: RefCell<Vec<Step>> = const { RefCell::new(Vec::new()) };
}

/// A number that is the result of a step.
#[derive(Clone, Copy)]
struct Recorded(usize);

fn note(step: Step) -> Recorded {
    RECORDED.with_borrow_mut(|steps| {
        steps.push(step);
        Recorded(steps.len() - 1)
    })
}

fn record(function: impl FnOnce([Recorded; 2]) -> (Recorded, Recorded)) -> Steps {
    RECORDED.with_borrow_mut(Vec::clear);
    let (first, second) = function([note(Step::Input(0)), note(Step::Input(1))]);
    Steps { steps: RECORDED.take(), results: [first.0, second.0] }
}

macro_rules! operator {
    ($($operator:ident $function:ident $step:ident,)*) => {$(
        impl $operator for Recorded {
            type Output = Self;

            fn $function(self, other: Self) -> Self {
                note(Step::$step(self.0, other.0))
            }
        }
    )*};
}

operator!(Add add Add, Sub sub Subtract, Mul mul Multiply,);

/// The function is none of sine's or cosine's.
const NOT_USED: &str = "neither the reduction nor the polynomials use it";

impl Div for Recorded {
    type Output = Self;

    fn div(self, _: Self) -> Self {
        unimplemented!("{NOT_USED}")
    }
}

impl Neg for Recorded {
    type Output = Self;

    fn neg(self) -> Self {
        unimplemented!("{NOT_USED}")
    }
}

impl FlipSign for Recorded {
    fn flip_sign(self, by: Self) -> Self {
        note(Step::FlipSign(self.0, by.0))
    }
}

impl Scalar for Recorded {
    fn from_f64(value: f64) -> Self {
        note(Step::Constant(value))
    }

    fn mul_add(self, factor: Self, term: Self) -> Self {
        note(Step::MultiplyAdd(self.0, factor.0, term.0))
    }

    fn sin_cos(self) -> (Self, Self) {
        unimplemented!("{NOT_USED}")
    }

    fn atan2(self, _: Self) -> Self {
        unimplemented!("{NOT_USED}")
    }

    fn sqrt(self) -> Self {
        unimplemented!("{NOT_USED}")
    }

    fn ln(self) -> Self {
        unimplemented!("{NOT_USED}")
    }

    fn abs(self) -> Self {
        unimplemented!("{NOT_USED}")
    }

    fn max(self, _: Self) -> Self {
        unimplemented!("{NOT_USED}")
    }

    fn select_nonnegative(self, _: Self, _: Self) -> Self {
        unimplemented!("{NOT_USED}")
    }
}

#[cfg(test)]
#[allow(clippy::cast_possible_truncation)]
mod tests {
    use alloc::vec::Vec;

    use super::{Float, Scalar, Step, Steps, limit, reduce_far};

    fn run<F: Float>(steps: &Steps, inputs: [F; 2]) -> [F; 2] {
        let mut values: Vec<F> = Vec::new();
        for step in &steps.steps {
            values.push(match *step {
                Step::Input(number) => inputs[number],
                Step::Constant(value) => F::from_f64(value),
                Step::Add(a, b) => values[a] + values[b],
                Step::Subtract(a, b) => values[a] - values[b],
                Step::Multiply(a, b) => values[a] * values[b],
                Step::MultiplyAdd(a, b, c) => values[a].mul_add(values[b], values[c]),
                Step::FlipSign(a, b) => values[a].flip_sign(values[b]),
            });
        }
        steps.results.map(|step| values[step])
    }

    fn same<F: Float + PartialEq + core::fmt::Debug>(number: impl Fn(f64) -> F) {
        let reduction = Steps::reduction::<F>();
        let polynomials = Steps::polynomials::<F>();
        for i in (-4000..4000).map(f64::from) {
            let x = number(i * i * i * 1.7e-2 + 0.3);
            let near = Scalar::abs(x) < limit();
            let reduced = if near { run(&reduction, [x, x]) } else { reduce_far(x) };
            let (sine, cosine) = x.sin_cos();
            assert_eq!(run(&polynomials, reduced), [sine, cosine], "{x:?}");
        }
    }

    #[test]
    fn the_steps_are_sine_and_cosine() {
        same::<f64>(|x| x);
        same::<f32>(|x| x as f32);
    }
}
