//! Inertias and payloads among the run-time parameters of a generated robot.

use core::cmp::Ordering;
use core::{fmt, iter};

use crate::Scalar;
use crate::inertial::{Inertial, InertialDefect, PARAMETERS_PER_LINK};
use crate::scalar::epsilon;

/// The reason why a robot cannot have a run-time inertia or a payload.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum ParameterError<S = f64> {
    /// No rigid body has this inertia.
    Defect(InertialDefect<S>),
    /// A joint would move no inertia, so its acceleration would be infinite.
    NoInertia {
        /// The name of the joint.
        joint: &'static str,
    },
}

impl<S> From<InertialDefect<S>> for ParameterError<S> {
    fn from(defect: InertialDefect<S>) -> Self {
        Self::Defect(defect)
    }
}

impl<S: fmt::Display + fmt::LowerExp> fmt::Display for ParameterError<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Defect(defect) => defect.fmt(f),
            Self::NoInertia { joint } => write_no_inertia(f, joint),
        }
    }
}

/// Writes that a joint would move no inertia.
pub(crate) fn write_no_inertia(f: &mut fmt::Formatter<'_>, joint: &str) -> fmt::Result {
    write!(
        f,
        "no inertia would oppose the motion of joint `{joint}` while the joints after it are free, \
         so its acceleration would be \
         infinite; give a link that it moves a mass, and a rotational inertia if it turns"
    )
}

impl<S: fmt::Debug + fmt::Display + fmt::LowerExp + 'static> core::error::Error
    for ParameterError<S>
{
    fn source(&self) -> Option<&(dyn core::error::Error + 'static)> {
        match self {
            Self::Defect(defect) => Some(defect),
            Self::NoInertia { .. } => None,
        }
    }
}

/// Returns the inertia whose ten numbers start at entry `at` of `numbers`.
#[doc(hidden)]
#[must_use]
pub fn inertial<S: Scalar, const N: usize>(numbers: &[S; N], at: usize) -> Inertial<S> {
    let number = |i: usize| numbers.get(at + i).copied().unwrap_or_else(S::zero);
    Inertial {
        mass: number(0),
        center_of_mass: core::array::from_fn(|i| number(1 + i)),
        inertia: core::array::from_fn(|i| number(4 + i)),
    }
}

/// Returns `numbers` with the ten numbers of `inertial` from entry `at` on.
///
/// # Errors
///
/// If no rigid body has this inertia.
#[doc(hidden)]
pub fn with_inertial<S: Scalar + PartialOrd, const N: usize>(
    numbers: &[S; N],
    at: usize,
    inertial: &Inertial<S>,
) -> Result<[S; N], ParameterError<S>> {
    if let Some(defect) = inertial.defect() {
        return Err(defect.into());
    }
    let mut changed = *numbers;
    let Inertial { mass, center_of_mass, inertia } = *inertial;
    let new = iter::once(mass).chain(center_of_mass).chain(inertia);
    for (number, new) in changed.iter_mut().skip(at).take(PARAMETERS_PER_LINK).zip(new) {
        *number = new;
    }
    Ok(changed)
}

/// Checks that each of the `joints` moves inertia: its entry of `pivots` must not be zero. `pivots`
/// receives the scalar's precision.
///
/// # Errors
///
/// Names the last of the joints that moves no inertia.
#[doc(hidden)]
pub fn check_pivots<S: Scalar + PartialOrd, const N: usize>(
    pivots: impl FnOnce(S) -> [S; N],
    joints: &[&'static str; N],
) -> Result<(), ParameterError<S>> {
    let pivots = pivots(epsilon());
    let positive = |pivot: &S| pivot.partial_cmp(&S::zero()) == Some(Ordering::Greater);
    match pivots.iter().zip(joints).rev().find(|(pivot, _)| !positive(pivot)) {
        None => Ok(()),
        Some((_, &joint)) => Err(ParameterError::NoInertia { joint }),
    }
}
