//! The operations for which C, CUDA and WGSL have no operator or function of the same results, so
//! that printers define one.

use crate::program::Operation;

/// A function that printers define. They print the definitions in this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Support {
    SinCos,
    Atan2,
    Logarithm,
    Maximum,
}

impl Support {
    /// Returns the function that computes an operation; `None` if the languages have it.
    pub fn of(operation: &Operation) -> Option<Self> {
        match operation {
            Operation::SinCos(_) => Some(Self::SinCos),
            Operation::Atan2(..) => Some(Self::Atan2),
            Operation::Logarithm(_) => Some(Self::Logarithm),
            Operation::Maximum(..) => Some(Self::Maximum),
            _ => None,
        }
    }
}
