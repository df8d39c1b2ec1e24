//! Perturbations of accelerations.

use super::Vector3;
use crate::Scalar;

/// A change of the accelerations of all points after a joint. At the point p with velocity v, the
/// change is gradient × p + coriolis × 2 v + uniform.
///
/// The change is in the axes of the joint's body, about the body's origin; v is relative to fixed
/// axes. The displacement of the points themselves is left out.
#[derive(Clone, Copy, Debug)]
pub struct AccelerationPerturbation<S> {
    /// The factor of the position p.
    pub gradient: Vector3<S>,
    /// gradient - 2 omega × coriolis, with the body's angular velocity omega. It replaces the
    /// gradient where v is relative to the body, since 2 omega × (coriolis × p) then is a separate
    /// term.
    pub relative: Vector3<S>,
    /// Half the factor of the velocity v: the Coriolis term.
    pub coriolis: Vector3<S>,
    /// The term that is the same for all points.
    pub uniform: Vector3<S>,
}

impl<S: Scalar> AccelerationPerturbation<S> {
    /// Returns the zero perturbation.
    #[must_use]
    pub fn zero() -> Self {
        let zero = Vector3::zero();
        Self { gradient: zero, relative: zero, coriolis: zero, uniform: zero }
    }
}
