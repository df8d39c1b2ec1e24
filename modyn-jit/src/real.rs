//! The numbers that code computes on.

use modyn_runtime::batch::Float;

/// A floating-point number that machine code is made for: `f64` or `f32`.
pub trait Real: Float + PartialOrd + Default + std::fmt::Debug + sealed::Sealed {
    /// The bits of the number.
    #[doc(hidden)]
    fn bits(self) -> u64;
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
}

impl Real for f32 {
    fn bits(self) -> u64 {
        self.to_bits().into()
    }
}
