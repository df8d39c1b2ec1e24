//! Quaternions, and the exponential maps of rotations and motions with their inverses.
//!
//! A rotation vector w is the axis times the angle t in rad. The maps need sin(t/2) / (t/2) and the
//! like, which are kept from 0 / 0 by a least t^2 and need no series besides: what a difference
//! loses near t = 0 is multiplied by t^2 again.

use super::Vector3;
use crate::Scalar;

/// The least square of an angle (and of a quaternion's vector): below it, an angle is 0 in any
/// precision. Single precision has it too.
const LEAST: f64 = 1e-30;

/// A quaternion; where it is one of length 1, the rotation of a frame: from its axes to those it
/// is seen from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quaternion<S> {
    /// x, y, z.
    pub vector: Vector3<S>,
    /// w.
    pub scalar: S,
}

impl<S: Scalar> Quaternion<S> {
    /// From x, y, z, w.
    #[must_use]
    pub fn from_components([x, y, z, w]: [S; 4]) -> Self {
        Self { vector: Vector3([x, y, z]), scalar: w }
    }

    /// x, y, z, w.
    #[must_use]
    pub fn components(self) -> [S; 4] {
        let [x, y, z] = self.vector.0;
        [x, y, z, self.scalar]
    }

    /// No rotation.
    #[must_use]
    pub fn identity() -> Self {
        Self { vector: Vector3::zero(), scalar: S::one() }
    }

    /// The rotation by the rotation vector `w`.
    #[must_use]
    pub fn exp(w: Vector3<S>) -> Self {
        let Angle { sinc, cos, .. } = Angle::of(w);
        Self { vector: w.scale(S::from_f64(0.5) * sinc), scalar: cos }
    }

    /// The rotation vector, at most half a turn; the quaternion may have any length but 0.
    #[must_use]
    pub fn log(self) -> Vector3<S> {
        // The quaternion and its negative are the same rotation.
        let shortest = self.scalar.select_nonnegative(S::one(), -S::one());
        let sine = self.vector.dot(self.vector).max(S::from_f64(LEAST)).sqrt();
        let half = sine.atan2(self.scalar.abs());
        self.vector.scale(shortest * ((half + half) / sine))
    }

    /// The rotation back.
    #[must_use]
    pub fn conjugate(self) -> Self {
        Self { vector: -self.vector, ..self }
    }

    /// The rotation `other` in the axes that this one has turned.
    #[must_use]
    pub fn times(self, other: Self) -> Self {
        let (a, b) = (self.vector, other.vector);
        Self {
            vector: a.scale(other.scalar) + b.scale(self.scalar) + a.cross(b),
            scalar: self.scalar * other.scalar - a.dot(b),
        }
    }

    /// A direction of the turned axes, seen from those in front of the rotation.
    #[must_use]
    pub fn rotate(self, v: Vector3<S>) -> Vector3<S> {
        let half = self.vector.cross(v);
        let t = half + half;
        v + t.scale(self.scalar) + self.vector.cross(t)
    }

    /// Its rate of change under the angular velocity `omega` in the turned axes.
    #[must_use]
    pub fn rate(self, omega: Vector3<S>) -> Self {
        self.times(Self { vector: omega.scale(S::from_f64(0.5)), scalar: S::zero() })
    }

    /// Of length 1; none of length 0 becomes the identity.
    #[must_use]
    pub fn normalized(self) -> Self {
        let (square, least) = (self.square(), S::from_f64(LEAST));
        let scaled = self.scale(square.max(least).sqrt().recip());
        let nothing = least - square;
        let or = |usual: S, identity: S| nothing.select_nonnegative(identity, usual);
        Self {
            vector: Vector3(scaled.vector.0.map(|x| or(x, S::zero()))),
            scalar: or(scaled.scalar, S::one()),
        }
    }

    /// The same with a length nearer to 1, if it is near: a Newton step.
    #[must_use]
    pub fn renormalized(self) -> Self {
        self.scale(S::from_f64(1.5) - S::from_f64(0.5) * self.square())
    }

    fn square(self) -> S {
        self.vector.dot(self.vector) + self.scalar * self.scalar
    }

    fn scale(self, factor: S) -> Self {
        Self { vector: self.vector.scale(factor), scalar: self.scalar * factor }
    }
}

/// Where the motion with the constant twist (`w`, `v`) in the moving axes is after a unit of time,
/// in the axes that it starts from: V(w) v.
#[must_use]
pub fn screw_translation<S: Scalar>(w: Vector3<S>, v: Vector3<S>) -> Vector3<S> {
    let Angle { square, sinc, cos } = Angle::of(w);
    let (across, along) = (w.cross(v), w.cross(w.cross(v)));
    let first = S::from_f64(0.5) * (sinc * sinc);
    v + across.scale(first) + along.scale((S::one() - sinc * cos) / square)
}

/// The v with V(w) v = `translation`, for rotations up to half a turn (and until a whole one).
#[must_use]
pub fn screw_velocity<S: Scalar>(w: Vector3<S>, translation: Vector3<S>) -> Vector3<S> {
    let Angle { square, sinc, cos } = Angle::of(w);
    let across = w.cross(translation);
    let second = (S::one() - cos / sinc) / square;
    translation - across.scale(S::from_f64(0.5)) + w.cross(across).scale(second)
}

/// What the maps need of the angle t of a rotation vector.
struct Angle<S> {
    /// t^2, but not 0.
    square: S,
    /// sin(t/2) / (t/2)
    sinc: S,
    /// cos(t/2)
    cos: S,
}

impl<S: Scalar> Angle<S> {
    fn of(w: Vector3<S>) -> Self {
        let square = w.dot(w).max(S::from_f64(LEAST));
        let half = S::from_f64(0.5) * square.sqrt();
        let (sin, cos) = half.sin_cos();
        Self { square, sinc: sin / half, cos }
    }
}
