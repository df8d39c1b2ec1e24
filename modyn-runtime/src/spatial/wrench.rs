//! Twists and wrenches.

use core::ops::{Add, AddAssign};

use super::Vector3;
use crate::Scalar;

/// A velocity (or an acceleration) of a link at its origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Twist<S> {
    /// Angular part, rad/s.
    pub angular: Vector3<S>,
    /// Linear part, of the link's origin, m/s.
    pub linear: Vector3<S>,
}

impl<S: Scalar> Twist<S> {
    /// From six numbers, angular first.
    #[must_use]
    pub fn from_components([a, b, c, d, e, f]: [S; 6]) -> Self {
        Self { angular: Vector3([a, b, c]), linear: Vector3([d, e, f]) }
    }

    /// No motion.
    #[must_use]
    pub fn zero() -> Self {
        Self { angular: Vector3::zero(), linear: Vector3::zero() }
    }

    /// The six numbers, angular first.
    #[must_use]
    pub fn components(&self) -> [S; 6] {
        let ([a, b, c], [d, e, f]) = (self.angular.0, self.linear.0);
        [a, b, c, d, e, f]
    }
}

/// A moment and a force on a link at its origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wrench<S> {
    /// Moment about the link's origin, N m.
    pub moment: Vector3<S>,
    /// Force, N.
    pub force: Vector3<S>,
}

impl<S: Scalar> Wrench<S> {
    /// Nothing.
    #[must_use]
    pub fn zero() -> Self {
        Self { moment: Vector3::zero(), force: Vector3::zero() }
    }

    /// The six numbers, moment first.
    #[must_use]
    pub fn components(&self) -> [S; 6] {
        let ([a, b, c], [d, e, f]) = (self.moment.0, self.force.0);
        [a, b, c, d, e, f]
    }

    /// From six numbers, moment first.
    #[must_use]
    pub fn from_components([a, b, c, d, e, f]: [S; 6]) -> Self {
        Self { moment: Vector3([a, b, c]), force: Vector3([d, e, f]) }
    }
}

impl<S: Scalar> Add for Wrench<S> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { moment: self.moment + other.moment, force: self.force + other.force }
    }
}

impl<S: Scalar> AddAssign for Wrench<S> {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}
