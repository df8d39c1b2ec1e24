//! Moments of the velocities of a body's points.

use super::{Axis, AxisRotation, Matrix3, RigidInertia, Vector3};
use crate::Scalar;

/// Twice the first and second moments of velocity, `2 integral x' dm` and `2 integral x' x^T dm`,
/// of points at x about a frame's origin, in the frame's axes. The Coriolis forces on a composite
/// depend on these 12 numbers.
///
/// The velocities x' are relative to the frame or to fixed axes, by choice of the caller;
/// [`with_angular_velocity`](Self::with_angular_velocity) converts from the former to the latter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VelocityMoments<S> {
    /// Twice the integral of x', kg m/s.
    pub first: Vector3<S>,
    /// Twice the integral of x' x^T, kg m^2/s.
    pub second: Matrix3<S>,
}

impl<S: Scalar> VelocityMoments<S> {
    /// Returns the moments of points at rest.
    #[must_use]
    pub fn zero() -> Self {
        Self { first: Vector3::zero(), second: Matrix3::zero() }
    }

    /// Returns the moments with `f` applied to their numbers.
    #[must_use]
    pub fn map(&self, mut f: impl FnMut(S) -> S) -> Self {
        let first = Vector3(self.first.0.map(&mut f));
        Self { first, second: Matrix3(self.second.0.map(|row| row.map(&mut f))) }
    }

    /// Returns the moments after adding (`twice_omega` / 2) x x to the velocities of points with
    /// inertia `body`.
    #[must_use]
    pub fn with_angular_velocity(&self, twice_omega: Vector3<S>, body: &RigidInertia<S>) -> Self {
        let s = body.second_moment.full();
        let columns = [0, 1, 2].map(|j| twice_omega.cross(s.column(j)).0);
        Self {
            first: self.first + twice_omega.cross(body.first_moment),
            second: self.second + Matrix3(columns).transposed(),
        }
    }

    /// Returns the moments after adding `twice` / 2 to the velocities of points with inertia
    /// `body`.
    #[must_use]
    pub fn with_linear_velocity(&self, twice: Vector3<S>, body: &RigidInertia<S>) -> Self {
        Self {
            first: self.first + twice.scale(body.mass),
            second: self.second + Matrix3::outer(twice, body.first_moment),
        }
    }

    /// Returns the moments about the origin of a parallel frame, in which this frame's origin is at
    /// `p`.
    #[must_use]
    pub fn shifted(&self, p: Vector3<S>) -> Self {
        Self { first: self.first, second: self.second + Matrix3::outer(self.first, p) }
    }

    /// Returns the moments in the original axes, from the axes rotated by `rotation`.
    #[must_use]
    pub fn rotated_about(&self, rotation: AxisRotation<S>, about: Axis) -> Self {
        Self {
            first: rotation.vector(about, self.first),
            second: rotation.matrix(about, &self.second),
        }
    }

    /// Returns the moments in new axes; the columns of `rotation` are the present axes in the new
    /// ones.
    #[must_use]
    pub fn rotated(&self, rotation: &Matrix3<S>) -> Self {
        Self { first: rotation.mul_vector(self.first), second: rotation.congruence(&self.second) }
    }

    /// Returns the matrix that maps g to `2 integral x x (g x x') dm`: trace(D) 1 - D of the second
    /// moment D.
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
