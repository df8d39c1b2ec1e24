//! Changes of accelerations.

use super::Vector3;
use crate::Scalar;

/// A change of the accelerations of all points behind a joint: at x, moving with x', by
/// gradient x x + turning x 2 x' + uniform.
///
/// In the axes of the joint's body, about its origin, x' against fixed axes. A displacement of the
/// whole with its motion is left out.
#[derive(Clone, Copy, Debug)]
pub struct AccelerationPerturbation<S> {
    /// The factor of the place x.
    pub gradient: Vector3<S>,
    /// gradient - 2 omega x turning, with the body's omega: what is left of the gradient where x'
    /// is against the body, since then there is 2 omega x (turning x x) as well.
    pub relative: Vector3<S>,
    /// Half the factor of the velocity x'.
    pub turning: Vector3<S>,
    /// The part that is the same for all points.
    pub uniform: Vector3<S>,
}

impl<S: Scalar> AccelerationPerturbation<S> {
    /// None.
    #[must_use]
    pub fn zero() -> Self {
        let zero = Vector3::zero();
        Self { gradient: zero, relative: zero, turning: zero, uniform: zero }
    }
}
