//! 3x3 matrices: general, and symmetric in six numbers.

use core::ops::Add;

use super::Vector3;
use crate::Scalar;

/// A 3x3 matrix, stored by rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Matrix3<S>(pub [[S; 3]; 3]);

impl<S: Scalar> Matrix3<S> {
    /// Returns the zero matrix.
    #[must_use]
    pub fn zero() -> Self {
        Self([[S::zero(); 3]; 3])
    }

    /// Returns the matrix whose column k is `column(k)`.
    #[must_use]
    pub fn from_columns(column: impl FnMut(usize) -> Vector3<S>) -> Self {
        Self(core::array::from_fn(column).map(|column: Vector3<S>| column.0)).transposed()
    }

    /// Returns the matrix of the cross product v x.
    #[must_use]
    pub fn cross(v: Vector3<S>) -> Self {
        let [x, y, z] = v.0;
        let o = S::zero();
        Self([[o, -z, y], [z, o, -x], [-y, x, o]])
    }

    /// Returns the matrix a b^T.
    #[must_use]
    pub fn outer(a: Vector3<S>, b: Vector3<S>) -> Self {
        Self(a.0.map(|a| b.0.map(|b| a * b)))
    }

    /// Returns the matrix times a vector.
    #[must_use]
    pub fn mul_vector(&self, v: Vector3<S>) -> Vector3<S> {
        Vector3(self.0.map(|row| Vector3(row).dot(v)))
    }

    /// Returns `self` times `other`.
    #[must_use]
    pub fn times(&self, other: &Self) -> Self {
        Self(self.0.map(|row| core::array::from_fn(|j| Vector3(row).dot(other.column(j)))))
    }

    /// Returns R M R^T with R = `self`.
    #[must_use]
    pub fn congruence(&self, m: &Self) -> Self {
        self.times(m).times(&self.transposed())
    }

    /// Returns the transposed matrix.
    #[must_use]
    pub fn transposed(&self) -> Self {
        Self(core::array::from_fn(|i| self.column(i).0))
    }

    /// Returns the matrix with all signs changed.
    #[must_use]
    pub fn negated(&self) -> Self {
        Self(self.0.map(|row| row.map(|x| -x)))
    }

    /// Returns column `j`.
    #[must_use]
    pub fn column(&self, j: usize) -> Vector3<S> {
        Vector3(self.0.map(|row| row[j]))
    }

    /// Returns row `i`.
    #[must_use]
    pub fn row(&self, i: usize) -> Vector3<S> {
        Vector3(self.0[i])
    }
}

impl<S: Scalar> Add for Matrix3<S> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self(core::array::from_fn(|i| core::array::from_fn(|j| self.0[i][j] + other.0[i][j])))
    }
}

/// A symmetric 3x3 matrix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Symmetric3<S> {
    /// Row 0, column 0.
    pub xx: S,
    /// Row 0, column 1.
    pub xy: S,
    /// Row 0, column 2.
    pub xz: S,
    /// Row 1, column 1.
    pub yy: S,
    /// Row 1, column 2.
    pub yz: S,
    /// Row 2, column 2.
    pub zz: S,
}

impl<S: Scalar> Symmetric3<S> {
    /// Returns the zero matrix.
    #[must_use]
    pub fn zero() -> Self {
        Self::diagonal(S::zero())
    }

    /// Returns `value` times the identity.
    #[must_use]
    pub fn diagonal(value: S) -> Self {
        let o = S::zero();
        Self { xx: value, xy: o, xz: o, yy: value, yz: o, zz: value }
    }

    /// Returns the matrix with this upper triangle: `entry(row, column)`.
    #[must_use]
    pub fn from_fn(mut entry: impl FnMut(usize, usize) -> S) -> Self {
        Self {
            xx: entry(0, 0),
            xy: entry(0, 1),
            xz: entry(0, 2),
            yy: entry(1, 1),
            yz: entry(1, 2),
            zz: entry(2, 2),
        }
    }

    /// Returns the matrix in nine numbers.
    #[must_use]
    pub fn full(&self) -> Matrix3<S> {
        let Self { xx, xy, xz, yy, yz, zz } = *self;
        Matrix3([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    }

    /// Returns the matrix with `f` applied to its numbers.
    pub fn map<T>(&self, mut f: impl FnMut(S) -> T) -> Symmetric3<T> {
        Symmetric3 {
            xx: f(self.xx),
            xy: f(self.xy),
            xz: f(self.xz),
            yy: f(self.yy),
            yz: f(self.yz),
            zz: f(self.zz),
        }
    }
}

impl<S: Scalar> Add for Symmetric3<S> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            xx: self.xx + other.xx,
            xy: self.xy + other.xy,
            xz: self.xz + other.xz,
            yy: self.yy + other.yy,
            yz: self.yz + other.yz,
            zz: self.zz + other.zz,
        }
    }
}
