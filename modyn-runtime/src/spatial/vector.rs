//! Vectors with three components.

use core::ops::{Add, AddAssign, Index, IndexMut, Neg, Sub};

use crate::Scalar;

/// A vector with a direction, such as a velocity or a force. (Positions are arrays:
/// [`Pose`](super::Pose), [`Inertial`](crate::Inertial), the centre of mass.)
///
/// ```
/// use modyn_runtime::Vector3;
///
/// let (x, y) = (Vector3([1.0, 0.0, 0.0]), Vector3([0.0, 1.0, 0.0]));
/// assert_eq!(x.cross(y), Vector3([0.0, 0.0, 1.0]));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vector3<S>(pub [S; 3]);

impl<S: Scalar> Vector3<S> {
    /// Returns the zero vector.
    #[must_use]
    pub fn zero() -> Self {
        Self([S::zero(); 3])
    }

    /// Returns the unit vector along axis `k`.
    #[must_use]
    pub fn unit(k: usize) -> Self {
        Self(core::array::from_fn(|i| if i == k { S::one() } else { S::zero() }))
    }

    /// Returns the vector of length `value` along z.
    #[must_use]
    pub fn along_z(value: S) -> Self {
        Self([S::zero(), S::zero(), value])
    }

    /// Returns the scalar product.
    #[must_use]
    pub fn dot(self, other: Self) -> S {
        let [a, b, c] = self.0;
        let [x, y, z] = other.0;
        a * x + b * y + c * z
    }

    /// Returns the cross product `self` x `other`.
    #[must_use]
    pub fn cross(self, other: Self) -> Self {
        let [a, b, c] = self.0;
        let [x, y, z] = other.0;
        Self([b * z - c * y, c * x - a * z, a * y - b * x])
    }

    /// Returns the cross product of `self` and `value` times the z axis.
    #[must_use]
    pub fn cross_z(self, value: S) -> Self {
        let [x, y, _] = self.0;
        Self([y * value, -(x * value), S::zero()])
    }

    /// Returns the vector times `factor`.
    #[must_use]
    pub fn scale(self, factor: S) -> Self {
        Self(self.0.map(|x| x * factor))
    }
}

impl<S> From<[S; 3]> for Vector3<S> {
    fn from(components: [S; 3]) -> Self {
        Self(components)
    }
}

impl<S> From<Vector3<S>> for [S; 3] {
    fn from(vector: Vector3<S>) -> Self {
        vector.0
    }
}

impl<S: Scalar> Add for Vector3<S> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self(core::array::from_fn(|i| self.0[i] + other.0[i]))
    }
}

impl<S: Scalar> AddAssign for Vector3<S> {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<S: Scalar> Sub for Vector3<S> {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self(core::array::from_fn(|i| self.0[i] - other.0[i]))
    }
}

impl<S: Scalar> Neg for Vector3<S> {
    type Output = Self;
    fn neg(self) -> Self {
        Self(self.0.map(|x| -x))
    }
}

impl<S> Index<usize> for Vector3<S> {
    type Output = S;
    fn index(&self, i: usize) -> &S {
        &self.0[i]
    }
}

impl<S> IndexMut<usize> for Vector3<S> {
    fn index_mut(&mut self, i: usize) -> &mut S {
        &mut self.0[i]
    }
}
