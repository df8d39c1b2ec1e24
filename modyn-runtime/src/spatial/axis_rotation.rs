//! Rotations about a coordinate axis.

use super::{Matrix3, Symmetric3, Vector3};
use crate::Scalar;

/// The coordinate axis of a rotation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// The x axis.
    X,
    /// The z axis.
    Z,
}

impl Axis {
    /// Returns the indices of the rotated plane (first axis towards second), and of the axis
    /// itself.
    fn indices(self) -> (usize, usize, usize) {
        match self {
            Self::X => (1, 2, 0),
            Self::Z => (0, 1, 2),
        }
    }
}

/// A rotation R about a coordinate axis: it maps components in the rotated frame to components in
/// the original frame.
///
/// Quarter turns only exchange and negate components. They are a variant of their own: exact,
/// without products.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AxisRotation<S> {
    /// This many quarter turns, 0 to 3.
    Quarters(u8),
    /// Any other angle.
    Angle {
        /// The cosine of the angle.
        cos: S,
        /// The sine of the angle.
        sin: S,
    },
}

impl<S: Scalar> AxisRotation<S> {
    /// Returns the identity.
    #[must_use]
    pub fn none() -> Self {
        Self::Quarters(0)
    }

    /// Returns the inverse rotation.
    #[must_use]
    pub fn inverse(self) -> Self {
        match self {
            Self::Quarters(n) => Self::Quarters((4 - n) % 4),
            Self::Angle { cos, sin } => Self::Angle { cos, sin: -sin },
        }
    }

    /// Returns the rotation with `f` applied to its numbers.
    pub fn map<T>(self, mut f: impl FnMut(S) -> T) -> AxisRotation<T> {
        match self {
            Self::Quarters(n) => AxisRotation::Quarters(n),
            Self::Angle { cos, sin } => AxisRotation::Angle { cos: f(cos), sin: f(sin) },
        }
    }

    /// Returns two components in the plane, rotated.
    fn planar(self, x: S, y: S) -> (S, S) {
        match self {
            Self::Quarters(0) => (x, y),
            Self::Quarters(1) => (-y, x),
            Self::Quarters(2) => (-x, -y),
            Self::Quarters(_) => (y, -x),
            Self::Angle { cos, sin } => (cos * x - sin * y, sin * x + cos * y),
        }
    }

    /// Returns R v.
    #[must_use]
    pub fn vector(self, about: Axis, v: Vector3<S>) -> Vector3<S> {
        let (i, j, _) = about.indices();
        let mut rotated = v;
        (rotated[i], rotated[j]) = self.planar(v[i], v[j]);
        rotated
    }

    /// Returns M R: each row of the matrix is rotated by R^T.
    #[must_use]
    pub fn columns(self, about: Axis, m: &Matrix3<S>) -> Matrix3<S> {
        Matrix3(m.0.map(|row| self.inverse().vector(about, Vector3(row)).0))
    }

    /// Returns R M R^T.
    ///
    /// With k = s (m_ii - m_jj) + c (m_ij + m_ji), the entries in the rotated plane are m_ii - s k,
    /// c k - m_ji, c k - m_ij, m_jj + s k: four products instead of eight.
    #[must_use]
    pub fn matrix(self, about: Axis, m: &Matrix3<S>) -> Matrix3<S> {
        let (i, j, k) = about.indices();
        let m = &m.0;
        let mut rotated = *m;
        (rotated[i][k], rotated[j][k]) = self.planar(m[i][k], m[j][k]);
        (rotated[k][i], rotated[k][j]) = self.planar(m[k][i], m[k][j]);
        ((rotated[i][i], rotated[i][j]), (rotated[j][i], rotated[j][j])) = match self {
            Self::Quarters(0) => ((m[i][i], m[i][j]), (m[j][i], m[j][j])),
            Self::Quarters(2) => ((m[i][i], m[i][j]), (m[j][i], m[j][j])),
            Self::Quarters(_) => ((m[j][j], -m[j][i]), (-m[i][j], m[i][i])),
            Self::Angle { cos, sin } => {
                let mix = sin * (m[i][i] - m[j][j]) + cos * (m[i][j] + m[j][i]);
                let s = sin * mix;
                let c = cos * mix;
                ((m[i][i] - s, c - m[j][i]), (c - m[i][j], m[j][j] + s))
            }
        };
        Matrix3(rotated)
    }

    /// Returns R M R^T of a symmetric matrix.
    #[must_use]
    pub fn symmetric(self, about: Axis, m: &Symmetric3<S>) -> Symmetric3<S> {
        let (i, j, k) = about.indices();
        let m = m.full().0;
        let mut rotated = m;
        (rotated[i][k], rotated[j][k]) = self.planar(m[i][k], m[j][k]);
        (rotated[i][i], rotated[i][j], rotated[j][j]) = match self {
            Self::Quarters(0 | 2) => (m[i][i], m[i][j], m[j][j]),
            Self::Quarters(_) => (m[j][j], -m[i][j], m[i][i]),
            Self::Angle { cos, sin } => {
                let mix = sin * (m[i][i] - m[j][j]) + (cos + cos) * m[i][j];
                let s = sin * mix;
                (m[i][i] - s, cos * mix - m[i][j], m[j][j] + s)
            }
        };
        // Either (i, j, k) = (0, 1, 2) or (1, 2, 0): each entry is read from where it was stored.
        match about {
            Axis::Z => Symmetric3 {
                xx: rotated[0][0],
                xy: rotated[0][1],
                xz: rotated[0][2],
                yy: rotated[1][1],
                yz: rotated[1][2],
                zz: rotated[2][2],
            },
            Axis::X => Symmetric3 {
                xx: rotated[0][0],
                xy: rotated[1][0],
                xz: rotated[2][0],
                yy: rotated[1][1],
                yz: rotated[1][2],
                zz: rotated[2][2],
            },
        }
    }
}
