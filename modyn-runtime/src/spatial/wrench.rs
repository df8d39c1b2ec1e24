//! Twists, wrenches and momenta.

use core::ops::{Add, AddAssign, Sub};

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

    /// The twist times a number.
    #[must_use]
    pub fn scale(self, factor: S) -> Self {
        Self { angular: self.angular.scale(factor), linear: self.linear.scale(factor) }
    }

    /// The six numbers, angular first.
    #[must_use]
    pub fn components(&self) -> [S; 6] {
        let ([a, b, c], [d, e, f]) = (self.angular.0, self.linear.0);
        [a, b, c, d, e, f]
    }
}

impl<S: Scalar> Add for Twist<S> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { angular: self.angular + other.angular, linear: self.linear + other.linear }
    }
}

/// An angular and a linear momentum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Momentum<S> {
    /// Angular part, about the point that the momentum is referred to, kg m^2/s.
    pub angular: Vector3<S>,
    /// Linear part, kg m/s.
    pub linear: Vector3<S>,
}

impl<S: Scalar> Momentum<S> {
    /// From six numbers, angular first.
    #[must_use]
    pub fn from_components([a, b, c, d, e, f]: [S; 6]) -> Self {
        Self { angular: Vector3([a, b, c]), linear: Vector3([d, e, f]) }
    }

    /// At rest.
    #[must_use]
    pub fn zero() -> Self {
        Self { angular: Vector3::zero(), linear: Vector3::zero() }
    }

    /// The momentum times a number.
    #[must_use]
    pub fn scale(self, factor: S) -> Self {
        Self { angular: self.angular.scale(factor), linear: self.linear.scale(factor) }
    }

    /// The six numbers, angular first.
    #[must_use]
    pub fn components(&self) -> [S; 6] {
        let ([a, b, c], [d, e, f]) = (self.angular.0, self.linear.0);
        [a, b, c, d, e, f]
    }
}

impl<S: Scalar> Add for Momentum<S> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { angular: self.angular + other.angular, linear: self.linear + other.linear }
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

impl<S: Scalar> Sub for Wrench<S> {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self { moment: self.moment - other.moment, force: self.force - other.force }
    }
}
