//! The errors of the interpreter.

use core::fmt;

/// A vector or matrix argument has the wrong length.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct ShapeError {
    /// The name of the parameter.
    pub parameter: &'static str,
    /// The required number of entries.
    pub expected: usize,
    /// The number of entries that were given.
    pub found: usize,
}

impl ShapeError {
    /// Returns the error of a `parameter` with `found` entries instead of `expected`.
    #[must_use]
    pub const fn new(parameter: &'static str, expected: usize, given: usize) -> Self {
        Self { parameter, expected, found: given }
    }
}

impl fmt::Display for ShapeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { parameter, expected, found: given } = self;
        write!(f, "`{parameter}` must hold {expected} numbers but holds {given}")
    }
}

impl core::error::Error for ShapeError {}

pub(crate) fn check<T>(
    parameter: &'static str,
    given: &[T],
    expected: usize,
) -> Result<(), ShapeError> {
    let length = given.len();
    if length == expected { Ok(()) } else { Err(ShapeError::new(parameter, expected, length)) }
}

/// The modules, or the factorization, belong to another model.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct ModuleMismatch {}

impl fmt::Display for ModuleMismatch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "the modules or the factorization belong to another model; create them from this model"
        )
    }
}

impl core::error::Error for ModuleMismatch {}

/// An error of a function for one link, or of the [evaluation](crate::Interpreter::evaluate) of any
/// function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum LinkError {
    /// There is no link with this index.
    NoLink {
        /// The index.
        link: usize,
        /// The number of links of the description.
        count: usize,
    },
    /// A slice has the wrong length.
    Shape(ShapeError),
    /// The function needs inertia, and a joint moves none.
    NoInertia {
        /// The joint, as an index into [`Model::links`](crate::model::Model::links).
        joint: usize,
    },
}

impl fmt::Display for LinkError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoLink { link, count } => {
                write!(f, "there is no link {link}; the description has {count}")
            }
            Self::Shape(error) => error.fmt(f),
            Self::NoInertia { joint } => write!(
                f,
                "the function needs inertia, and moving joint {joint} moves none, since its link has none; kinematic \
                 functions need none"
            ),
        }
    }
}

impl core::error::Error for LinkError {
    fn source(&self) -> Option<&(dyn core::error::Error + 'static)> {
        match self {
            Self::NoLink { .. } | Self::NoInertia { .. } => None,
            Self::Shape(error) => Some(error),
        }
    }
}

impl From<ShapeError> for LinkError {
    fn from(error: ShapeError) -> Self {
        Self::Shape(error)
    }
}

/// The reason why there is no block decomposition in the paper's matrices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum DecompositionError {
    /// `q` has the wrong length.
    Shape(ShapeError),
    /// The robot has mimic joints, which couple modules across the tree.
    Mimics,
}

impl fmt::Display for DecompositionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Shape(error) => error.fmt(f),
            Self::Mimics => write!(
                f,
                "the robot has mimic joints, which couple modules across the tree; `brge` factorizes such models"
            ),
        }
    }
}

impl core::error::Error for DecompositionError {
    fn source(&self) -> Option<&(dyn core::error::Error + 'static)> {
        match self {
            Self::Shape(error) => Some(error),
            Self::Mimics => None,
        }
    }
}

/// The reason why a factorization cannot be updated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum UpdateError {
    /// The factorization belongs to another model or to other modules.
    Modules(ModuleMismatch),
    /// `q` has the wrong length.
    Shape(ShapeError),
}

impl fmt::Display for UpdateError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Modules(error) => error.fmt(f),
            Self::Shape(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for UpdateError {
    fn source(&self) -> Option<&(dyn core::error::Error + 'static)> {
        match self {
            Self::Modules(error) => Some(error),
            Self::Shape(error) => Some(error),
        }
    }
}
