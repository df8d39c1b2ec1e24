//! Twists, wrenches and momenta. Their components have one order, everywhere: linear, then angular.

use core::ops::{Add, AddAssign, Sub};

use super::Vector3;
use crate::Scalar;

/// The velocity, or the acceleration, of a link at its origin.
///
/// ```
/// use modyn_runtime::Twist;
///
/// let twist = Twist::from_components([0.5, 0.0, 0.0, 0.0, 0.0, 1.0]);
/// assert_eq!((twist.angular[2], twist.linear[0]), (1.0, 0.5));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Twist<S> {
    /// The linear part: the velocity of the link's origin, m/s, or its acceleration, m/s^2.
    pub linear: Vector3<S>,
    /// The angular part, rad/s or rad/s^2.
    pub angular: Vector3<S>,
}

impl<S: Scalar> Twist<S> {
    /// Returns the twist with these six components, linear first.
    #[must_use]
    pub fn from_components([a, b, c, d, e, f]: [S; 6]) -> Self {
        Self { linear: Vector3([a, b, c]), angular: Vector3([d, e, f]) }
    }

    /// Returns the zero twist.
    #[must_use]
    pub fn zero() -> Self {
        Self { linear: Vector3::zero(), angular: Vector3::zero() }
    }

    /// Returns the twist times `factor`.
    #[must_use]
    pub fn scale(self, factor: S) -> Self {
        Self { linear: self.linear.scale(factor), angular: self.angular.scale(factor) }
    }

    /// Returns the six components, linear first.
    #[must_use]
    pub fn components(&self) -> [S; 6] {
        let [a, b, c] = self.linear.0;
        let [d, e, f] = self.angular.0;
        [a, b, c, d, e, f]
    }
}

impl<S: Scalar> Add for Twist<S> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { linear: self.linear + other.linear, angular: self.angular + other.angular }
    }
}

/// A linear and an angular momentum.
///
/// ```
/// use modyn_runtime::Momentum;
///
/// let momentum = Momentum::from_components([2.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
/// assert_eq!(momentum.scale(0.5).linear[0], 1.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Momentum<S> {
    /// The linear momentum, kg m/s.
    pub linear: Vector3<S>,
    /// The angular momentum about the reference point, kg m^2/s.
    pub angular: Vector3<S>,
}

impl<S: Scalar> Momentum<S> {
    /// Returns the momentum with these six components, linear first.
    #[must_use]
    pub fn from_components([a, b, c, d, e, f]: [S; 6]) -> Self {
        Self { linear: Vector3([a, b, c]), angular: Vector3([d, e, f]) }
    }

    /// Returns zero momentum.
    #[must_use]
    pub fn zero() -> Self {
        Self { linear: Vector3::zero(), angular: Vector3::zero() }
    }

    /// Returns the momentum times `factor`.
    #[must_use]
    pub fn scale(self, factor: S) -> Self {
        Self { linear: self.linear.scale(factor), angular: self.angular.scale(factor) }
    }

    /// Returns the six components, linear first.
    #[must_use]
    pub fn components(&self) -> [S; 6] {
        let [a, b, c] = self.linear.0;
        let [d, e, f] = self.angular.0;
        [a, b, c, d, e, f]
    }
}

impl<S: Scalar> Add for Momentum<S> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { linear: self.linear + other.linear, angular: self.angular + other.angular }
    }
}

/// A force and a moment on a link, at the link's origin.
///
/// ```
/// use modyn_runtime::{Vector3, Wrench};
///
/// let weight = Wrench { force: Vector3([0.0, 0.0, -9.81]), ..Wrench::zero() };
/// assert_eq!(weight.components(), [0.0, 0.0, -9.81, 0.0, 0.0, 0.0]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wrench<S> {
    /// The force, N.
    pub force: Vector3<S>,
    /// The moment about the link's origin, N m.
    pub moment: Vector3<S>,
}

impl<S: Scalar> Wrench<S> {
    /// Returns the zero wrench.
    #[must_use]
    pub fn zero() -> Self {
        Self { force: Vector3::zero(), moment: Vector3::zero() }
    }

    /// Returns the wrench times a number.
    #[must_use]
    pub fn scale(self, factor: S) -> Self {
        Self { force: self.force.scale(factor), moment: self.moment.scale(factor) }
    }

    /// Returns the six components, force first.
    #[must_use]
    pub fn components(&self) -> [S; 6] {
        let [a, b, c] = self.force.0;
        let [d, e, f] = self.moment.0;
        [a, b, c, d, e, f]
    }

    /// Returns the wrench with these six components, force first.
    #[must_use]
    pub fn from_components([a, b, c, d, e, f]: [S; 6]) -> Self {
        Self { force: Vector3([a, b, c]), moment: Vector3([d, e, f]) }
    }
}

impl<S: Scalar> Add for Wrench<S> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { force: self.force + other.force, moment: self.moment + other.moment }
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
        Self { force: self.force - other.force, moment: self.moment - other.moment }
    }
}
