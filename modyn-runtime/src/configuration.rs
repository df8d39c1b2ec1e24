//! Whether numbers are the coordinates of a configuration.

use core::fmt;

use crate::Scalar;
use crate::scalar::epsilon;

/// Why coordinates `q` are not those of a configuration.
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
    /// `q` holds another number of coordinates than the model has.
    Shape {
        /// How many numbers `q` must hold.
        expected: usize,
        /// How many it holds.
        found: usize,
    },
}

impl<S: fmt::Display, Name: fmt::Display> fmt::Display for ConfigurationError<S, Name> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Quaternion { joint, length } => write!(
                f,
                "the quaternion of joint `{joint}` has length {length}, not 1; `normalize` makes it 1"
            ),
            Self::Shape { expected, found } => {
                write!(f, "`q` must hold {expected} numbers but holds {found}")
            }
        }
    }
}

impl<S: fmt::Debug + fmt::Display, Name: fmt::Debug + fmt::Display> core::error::Error
    for ConfigurationError<S, Name>
{
}

/// Checks that each of the `quaternions` (the name of its joint, and where it begins in `q`) has length 1, to half of the
/// scalar's digits: to 1.5e-8 in `f64`, to 3.5e-4 in `f32`.
///
/// # Errors
///
/// The first one that has another length.
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
