//! Moments of the velocities of a body's points.

use super::{Axis, AxisRotation, Matrix3, RigidInertia, Vector3};
use crate::Scalar;

/// Twice the first and second moments of velocity, `2 integral x' dm` and `2 integral x' x^T dm`,
/// of points at x about a frame's origin in its axes: what Coriolis forces on a composite depend
/// on, in 12 numbers.
///
/// The rates x' are against the frame or against fixed axes, as the user has it; [`with_angular_velocity`](Self::with_angular_velocity)
/// goes from the former to the latter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VelocityMoments<S> {
    /// Twice the integral of x', kg m/s.
    pub first: Vector3<S>,
    /// Twice the integral of x' x^T, kg m^2/s.
    pub second: Matrix3<S>,
}

impl<S: Scalar> VelocityMoments<S> {
    /// Nothing moves.
    #[must_use]
    pub fn zero() -> Self {
        Self { first: Vector3::zero(), second: Matrix3::zero() }
    }

    /// Each number through `f`.
    #[must_use]
    pub fn map(&self, mut f: impl FnMut(S) -> S) -> Self {
        let first = Vector3(self.first.0.map(&mut f));
        Self { first, second: Matrix3(self.second.0.map(|row| row.map(&mut f))) }
    }

    /// The same points, of inertia `body`, with half of `twice_omega` x x added to their velocities.
    #[must_use]
    pub fn with_angular_velocity(&self, twice_omega: Vector3<S>, body: &RigidInertia<S>) -> Self {
        let s = body.second_moment.full();
        let columns = [0, 1, 2].map(|j| twice_omega.cross(s.column(j)).0);
        Self {
            first: self.first + twice_omega.cross(body.first_moment),
            second: self.second + Matrix3(columns).transposed(),
        }
    }

    /// The same points, of inertia `body`, with half of `twice` added to their velocities.
    #[must_use]
    pub fn with_linear_velocity(&self, twice: Vector3<S>, body: &RigidInertia<S>) -> Self {
        Self {
            first: self.first + twice.scale(body.mass),
            second: self.second + Matrix3::outer(twice, body.first_moment),
        }
    }

    /// The moments about an origin against which this one stands at `p`.
    #[must_use]
    pub fn shifted(&self, p: Vector3<S>) -> Self {
        Self { first: self.first, second: self.second + Matrix3::outer(self.first, p) }
    }

    /// The moments in turned axes.
    #[must_use]
    pub fn rotated_about(&self, turn: AxisRotation<S>, about: Axis) -> Self {
        Self { first: turn.vector(about, self.first), second: turn.matrix(about, &self.second) }
    }

    /// The moments in axes whose columns, seen from the new ones, are those of `rotation`.
    #[must_use]
    pub fn rotated(&self, rotation: &Matrix3<S>) -> Self {
        Self { first: rotation.mul_vector(self.first), second: rotation.congruence(&self.second) }
    }

    /// What `2 integral x x (g x x') dm` is of g, as a matrix: trace(D) 1 - D of the second moment
    /// D.
    #[must_use]
    pub fn rotational(&self) -> Matrix3<S> {
        let [[xx, xy, xz], [yx, yy, yz], [zx, zy, zz]] = self.second.0;
        Matrix3([[yy + zz, -xy, -xz], [-yx, xx + zz, -yz], [-zx, -zy, xx + yy]])
    }
}

impl<S: Scalar> core::ops::Add for VelocityMoments<S> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { first: self.first + other.first, second: self.second + other.second }
    }
}
