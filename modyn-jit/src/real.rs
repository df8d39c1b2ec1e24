//! The types of numbers for machine code.

use std::cell::Cell;
use std::fmt::{Debug, Display, LowerExp};
use std::thread::LocalKey;

use modyn_runtime::batch::Float;

/// A floating-point type of machine code: `f64` or `f32`.
pub trait Real: Float + PartialOrd + Default + Debug + Display + LowerExp + sealed::Sealed {
    /// Returns the bits of the number.
    #[doc(hidden)]
    fn bits(self) -> u64;

    /// Returns whether the number is neither infinite nor NaN.
    #[doc(hidden)]
    fn has_value(self) -> bool;

    /// Calls `work` with this many numbers, whose values are those that earlier calls have left.
    #[doc(hidden)]
    fn with_scratch(length: usize, work: impl FnOnce(&mut [Self]));
}

/// The memory of a thread for the numbers of a call.
type Scratch<S> = LocalKey<Cell<Vec<S>>>;

fn with_scratch<S: Real>(scratch: &'static Scratch<S>, length: usize, work: impl FnOnce(&mut [S])) {
    let mut numbers = scratch.take();
    if numbers.len() < length {
        numbers.resize(length, S::default());
    }
    work(&mut numbers[..length]);
    scratch.set(numbers);
}

mod sealed {
    pub trait Sealed {}

    impl Sealed for f64 {}
    impl Sealed for f32 {}
}

impl Real for f64 {
    fn bits(self) -> u64 {
        self.to_bits()
    }

    fn has_value(self) -> bool {
        self.is_finite()
    }

    fn with_scratch(length: usize, work: impl FnOnce(&mut [Self])) {
        thread_local!(static SCRATCH: Cell<Vec<f64>> = const { Cell::new(Vec::new()) });
        with_scratch(&SCRATCH, length, work);
    }
}

impl Real for f32 {
    fn bits(self) -> u64 {
        self.to_bits().into()
    }

    fn has_value(self) -> bool {
        self.is_finite()
    }

    fn with_scratch(length: usize, work: impl FnOnce(&mut [Self])) {
        thread_local!(static SCRATCH: Cell<Vec<f32>> = const { Cell::new(Vec::new()) });
        with_scratch(&SCRATCH, length, work);
    }
}
