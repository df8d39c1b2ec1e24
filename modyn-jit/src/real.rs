//! The types of numbers for machine code.

use std::fmt::{Debug, Display, LowerExp};

use modyn_runtime::batch::Float;

/// A floating-point type of machine code: `f64` or `f32`.
pub trait Real: Float + PartialOrd + Default + Debug + Display + LowerExp + sealed::Sealed {
    /// Returns the bits of the number.
    #[doc(hidden)]
    fn bits(self) -> u64;

    /// Returns whether the number is neither infinite nor NaN.
    #[doc(hidden)]
    fn has_value(self) -> bool;
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
}

impl Real for f32 {
    fn bits(self) -> u64 {
        self.to_bits().into()
    }

    fn has_value(self) -> bool {
        self.is_finite()
    }
}
