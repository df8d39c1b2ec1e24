//! The check that coordinates are a valid configuration.

use core::fmt;

use crate::Scalar;
use crate::scalar::epsilon;

/// The reason why coordinates `q` are not a valid configuration.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum ConfigurationError<S = f64, Name = &'static str> {
    /// The quaternion of a spherical or floating joint does not have length 1.
    Quaternion {
        /// The name of the joint.
        joint: Name,
        /// The length of its quaternion.
        length: S,
    },
    /// `q` does not have the model's length.
    Shape {
        /// The required number of entries.
        expected: usize,
        /// The number of entries that were given.
        found: usize,
    },
}

impl<S: fmt::Display, Name: fmt::Display> fmt::Display for ConfigurationError<S, Name> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Quaternion { joint, length } => write!(
                f,
                "the quaternion of joint `{joint}` has length {length}, not 1; `normalize_configuration` makes it 1"
            ),
            Self::Shape { expected, found: length } => {
                write!(f, "`q` must hold {expected} numbers but holds {length}")
            }
        }
    }
}

impl<S: fmt::Debug + fmt::Display, Name: fmt::Debug + fmt::Display> core::error::Error
    for ConfigurationError<S, Name>
{
}

/// Checks that each of the `quaternions` (the name of its joint, and its index in `q`) has
/// length 1. The tolerance is half of the scalar's digits: 1.5e-8 in `f64`, 3.5e-4 in `f32`.
///
/// # Errors
///
/// Returns the first quaternion that does not have length 1.
#[doc(hidden)]
pub fn check<S: Scalar + PartialOrd, Name>(
    quaternions: impl Iterator<Item = (Name, usize)>,
    q: &[S],
) -> Result<(), ConfigurationError<S, Name>> {
    let tolerance = epsilon::<S>().sqrt();
    for (joint, at) in quaternions {
        let numbers = q.iter().skip(at).take(4);
        let length = numbers.fold(S::zero(), |sum, &x| sum + x * x).sqrt();
        let close = (length - S::one()).abs() <= tolerance;
        if !close {
            return Err(ConfigurationError::Quaternion { joint, length });
        }
    }
    Ok(())
}
