//! Twists, wrenches and momenta.

use core::ops::{Add, AddAssign, Sub};

use super::Vector3;
use crate::Scalar;

/// The velocity, or the acceleration, of a link at its origin.
///
/// ```
/// use modyn_runtime::Twist;
///
/// let twist = Twist::from_components([0.0, 0.0, 1.0, 0.5, 0.0, 0.0]);
/// assert_eq!((twist.angular[2], twist.linear[0]), (1.0, 0.5));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Twist<S> {
    /// The angular part, rad/s or rad/s^2.
    pub angular: Vector3<S>,
    /// The linear part: the velocity of the link's origin, m/s, or its acceleration, m/s^2.
    pub linear: Vector3<S>,
}

impl<S: Scalar> Twist<S> {
    /// Returns the twist with these six components, angular first.
    #[must_use]
    pub fn from_components([a, b, c, d, e, f]: [S; 6]) -> Self {
        Self { angular: Vector3([a, b, c]), linear: Vector3([d, e, f]) }
    }

    /// Returns the zero twist.
    #[must_use]
    pub fn zero() -> Self {
        Self { angular: Vector3::zero(), linear: Vector3::zero() }
    }

    /// Returns the twist times `factor`.
    #[must_use]
    pub fn scale(self, factor: S) -> Self {
        Self { angular: self.angular.scale(factor), linear: self.linear.scale(factor) }
    }

    /// Returns the six components, angular first.
    #[must_use]
    pub fn components(&self) -> [S; 6] {
        let [a, b, c] = self.angular.0;
        let [d, e, f] = self.linear.0;
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
///
/// ```
/// use modyn_runtime::Momentum;
///
/// let momentum = Momentum::from_components([0.0, 0.0, 0.0, 2.0, 0.0, 0.0]);
/// assert_eq!(momentum.scale(0.5).linear[0], 1.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Momentum<S> {
    /// The angular momentum about the reference point, kg m^2/s.
    pub angular: Vector3<S>,
    /// The linear momentum, kg m/s.
    pub linear: Vector3<S>,
}

impl<S: Scalar> Momentum<S> {
    /// Returns the momentum with these six components, angular first.
    #[must_use]
    pub fn from_components([a, b, c, d, e, f]: [S; 6]) -> Self {
        Self { angular: Vector3([a, b, c]), linear: Vector3([d, e, f]) }
    }

    /// Returns zero momentum.
    #[must_use]
    pub fn zero() -> Self {
        Self { angular: Vector3::zero(), linear: Vector3::zero() }
    }

    /// Returns the momentum times `factor`.
    #[must_use]
    pub fn scale(self, factor: S) -> Self {
        Self { angular: self.angular.scale(factor), linear: self.linear.scale(factor) }
    }

    /// Returns the six components, angular first.
    #[must_use]
    pub fn components(&self) -> [S; 6] {
        let [a, b, c] = self.angular.0;
        let [d, e, f] = self.linear.0;
        [a, b, c, d, e, f]
    }
}

impl<S: Scalar> Add for Momentum<S> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { angular: self.angular + other.angular, linear: self.linear + other.linear }
    }
}

/// A moment and a force on a link, at the link's origin.
///
/// ```
/// use modyn_runtime::{Vector3, Wrench};
///
/// let weight = Wrench { force: Vector3([0.0, 0.0, -9.81]), ..Wrench::zero() };
/// assert_eq!(weight.components(), [0.0, 0.0, 0.0, 0.0, 0.0, -9.81]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wrench<S> {
    /// The moment about the link's origin, N m.
    pub moment: Vector3<S>,
    /// The force, N.
    pub force: Vector3<S>,
}

impl<S: Scalar> Wrench<S> {
    /// Returns the zero wrench.
    #[must_use]
    pub fn zero() -> Self {
        Self { moment: Vector3::zero(), force: Vector3::zero() }
    }

    /// Returns the wrench times a number.
    #[must_use]
    pub fn scale(self, factor: S) -> Self {
        Self { moment: self.moment.scale(factor), force: self.force.scale(factor) }
    }

    /// Returns the six components, moment first.
    #[must_use]
    pub fn components(&self) -> [S; 6] {
        let [a, b, c] = self.moment.0;
        let [d, e, f] = self.force.0;
        [a, b, c, d, e, f]
    }

    /// Returns the wrench with these six components, moment first.
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
