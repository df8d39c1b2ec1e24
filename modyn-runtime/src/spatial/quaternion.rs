//! Quaternions, and the exponential maps of SO(3) and SE(3) with their inverses and Jacobians.
//!
//! A rotation vector w is the axis times the angle t in rad. The maps need sin(t/2) / (t/2) and
//! similar functions: closed forms for large t, series for small t. The closed forms are accurate
//! enough for the values at every t. But dual numbers take their derivatives from the same code,
//! and the derivatives of a quotient lose more digits the closer it is to 0 / 0.

use super::{Matrix3, Vector3};
use crate::Scalar;

/// The squared length below which a quaternion counts as zero, in any precision.
const MIN_SQUARE: f64 = 1e-30;

/// The squared angle below which series are used. The series have accurate third derivatives in
/// double precision below it; above it the closed forms lose little.
const SERIES_LIMIT: f64 = 1.0 / 16.0;

/// The squared tangent of half an angle below which series are used.
const SERIES_LIMIT_TANGENT: f64 = 1.0 / 256.0;

/// The coefficients of sin(t/2) / (t/2) in powers of t^2.
const SINC: [f64; 6] =
    [1.0, -1.0 / 24.0, 1.0 / 1920.0, -1.0 / 322_560.0, 1.0 / 92_897_280.0, -1.0 / 40_874_803_200.0];

/// The coefficients of (sin(t/2) / (t/2) - cos(t/2)) / t^2 in powers of t^2.
const SINC_MINUS_COS: [f64; 6] = [
    1.0 / 12.0,
    -1.0 / 480.0,
    1.0 / 53_760.0,
    -1.0 / 11_612_160.0,
    1.0 / 4_087_480_320.0,
    -1.0 / 2_125_489_766_400.0,
];

/// The coefficients of the derivative of [`SINC_MINUS_COS`] by t^2, in powers of t^2.
const SINC_MINUS_COS_DERIVATIVE: [f64; 6] = [
    -1.0 / 480.0,
    2.0 / 53_760.0,
    -3.0 / 11_612_160.0,
    4.0 / 4_087_480_320.0,
    -5.0 / 2_125_489_766_400.0,
    6.0 / 1_530_352_631_808_000.0,
];

/// The coefficients of an angle divided by its tangent, in powers of the squared tangent.
const ARCTANGENT: [f64; 9] = [
    1.0,
    -1.0 / 3.0,
    1.0 / 5.0,
    -1.0 / 7.0,
    1.0 / 9.0,
    -1.0 / 11.0,
    1.0 / 13.0,
    -1.0 / 15.0,
    1.0 / 17.0,
];

/// A quaternion. With length 1 it is a rotation of a frame: it maps components in the rotated frame
/// to components in the reference frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quaternion<S> {
    /// x, y, z.
    pub vector: Vector3<S>,
    /// w.
    pub scalar: S,
}

impl<S: Scalar> Quaternion<S> {
    /// Returns the quaternion with the components x, y, z, w.
    #[must_use]
    pub fn from_components([x, y, z, w]: [S; 4]) -> Self {
        Self { vector: Vector3([x, y, z]), scalar: w }
    }

    /// Returns the components x, y, z, w.
    #[must_use]
    pub fn components(self) -> [S; 4] {
        let [x, y, z] = self.vector.0;
        [x, y, z, self.scalar]
    }

    /// Returns the identity.
    #[must_use]
    pub fn identity() -> Self {
        Self { vector: Vector3::zero(), scalar: S::one() }
    }

    /// Returns the rotation by the rotation vector `w`, rad.
    #[must_use]
    pub fn exp(w: Vector3<S>) -> Self {
        let Angle { sinc, cos, .. } = Angle::of(w);
        Self { vector: w.scale(S::from_f64(0.5) * sinc), scalar: cos }
    }

    /// Returns the rotation vector, rad, of length at most pi. The quaternion may have any length
    /// but 0.
    #[must_use]
    pub fn log(self) -> Vector3<S> {
        let square = self.vector.dot(self.vector);
        let sine = square.max(S::from_f64(MIN_SQUARE)).sqrt();
        let half = sine.atan2(self.scalar.abs());
        // The quaternion and its negative are the same rotation.
        let shortest = self.scalar.select_nonnegative(S::one(), -S::one());
        let closed = shortest * ((half + half) / sine);
        let secant = self.scalar.recip();
        let series = (secant + secant) * series(&ARCTANGENT, square * (secant * secant));
        let away = square - S::from_f64(SERIES_LIMIT_TANGENT) * (self.scalar * self.scalar);
        self.vector.scale(away.select_nonnegative(closed, series))
    }

    /// Returns the conjugate; for length 1, the inverse rotation.
    #[must_use]
    pub fn conjugate(self) -> Self {
        Self { vector: -self.vector, ..self }
    }

    /// Returns the product: first `self`, then `other` about the axes that `self` has rotated.
    #[must_use]
    pub fn times(self, other: Self) -> Self {
        let a = self.vector;
        let b = other.vector;
        Self {
            vector: a.scale(other.scalar) + b.scale(self.scalar) + a.cross(b),
            scalar: self.scalar * other.scalar - a.dot(b),
        }
    }

    /// Returns a direction in the reference frame, from its components in the rotated frame.
    #[must_use]
    pub fn rotate(self, v: Vector3<S>) -> Vector3<S> {
        let half = self.vector.cross(v);
        let t = half + half;
        v + t.scale(self.scalar) + self.vector.cross(t)
    }

    /// Returns the matrix of [`rotate`](Self::rotate); its columns are the rotated axes.
    #[must_use]
    pub fn matrix(self) -> Matrix3<S> {
        let [x, y, z] = self.vector.0;
        let w = self.scalar;
        let one = S::one();
        let x2 = x + x;
        let y2 = y + y;
        let z2 = z + z;
        let xx = x * x2;
        let yy = y * y2;
        let zz = z * z2;
        let xy = x * y2;
        let xz = x * z2;
        let yz = y * z2;
        let wx = w * x2;
        let wy = w * y2;
        let wz = w * z2;
        Matrix3([
            [one - (yy + zz), xy - wz, xz + wy],
            [xy + wz, one - (xx + zz), yz - wx],
            [xz - wy, yz + wx, one - (xx + yy)],
        ])
    }

    /// Returns the time derivative at the angular velocity `omega` in the rotated axes, rad/s.
    #[must_use]
    pub fn rate(self, omega: Vector3<S>) -> Self {
        self.times(Self { vector: omega.scale(S::from_f64(0.5)), scalar: S::zero() })
    }

    /// Returns the quaternion scaled to length 1. A quaternion of length 0 becomes the identity.
    #[must_use]
    pub fn normalized(self) -> Self {
        let square = self.square();
        let least = S::from_f64(MIN_SQUARE);
        let scaled = self.scale(square.max(least).sqrt().recip());
        let nothing = least - square;
        let or = |usual: S, identity: S| nothing.select_nonnegative(identity, usual);
        Self {
            vector: Vector3(scaled.vector.0.map(|x| or(x, S::zero()))),
            scalar: or(scaled.scalar, S::one()),
        }
    }

    /// Returns the quaternion with its length closer to 1, if it is near 1: one Newton step.
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

/// Returns the translation after unit time at the constant twist (`w`, `v`) in the moving axes, in
/// the axes at the start: V(w) v.
#[must_use]
pub fn screw_translation<S: Scalar>(w: Vector3<S>, v: Vector3<S>) -> Vector3<S> {
    let Angle { sinc, cos, lag } = Angle::of(w);
    let across = w.cross(v);
    let along = w.cross(w.cross(v));
    let square = sinc * sinc;
    // (1 - cos t) / t^2 and (t - sin t) / t^3.
    let first = S::from_f64(0.5) * square;
    let second = S::from_f64(0.25) * square - cos * lag;
    v + across.scale(first) + along.scale(second)
}

/// Returns the v with V(w) v = `translation`, for rotations below 2 pi.
#[must_use]
pub fn screw_velocity<S: Scalar>(w: Vector3<S>, translation: Vector3<S>) -> Vector3<S> {
    let Angle { sinc, lag, .. } = Angle::of(w);
    let across = w.cross(translation);
    translation - across.scale(S::from_f64(0.5)) + w.cross(across).scale(lag / sinc)
}

/// Returns the Jacobian of the exponential map of SO(3): its product with a change of the rotation
/// vector `w` is the change of the rotation, in the rotated axes.
#[must_use]
pub fn rotation_jacobian<S: Scalar>(w: Vector3<S>) -> Matrix3<S> {
    Matrix3::from_columns(|k| screw_translation(-w, Vector3::unit(k)))
}

/// Returns the inverse of [`rotation_jacobian`], for rotations below 2 pi.
#[must_use]
pub fn inverse_rotation_jacobian<S: Scalar>(w: Vector3<S>) -> Matrix3<S> {
    Matrix3::from_columns(|k| screw_velocity(-w, Vector3::unit(k)))
}

/// Returns the derivative of [`screw_translation`] by `w`, in the axes after the motion.
#[must_use]
pub fn screw_translation_by_rotation<S: Scalar>(w: Vector3<S>, v: Vector3<S>) -> Matrix3<S> {
    let angle = Angle::of(w);
    let Angle { sinc, cos, lag } = angle;
    let square = sinc * sinc;
    let across = w.cross(v);
    let along = w.cross(w.cross(v));
    let first = S::from_f64(0.5) * square;
    let second = S::from_f64(0.25) * square - cos * lag;
    // The derivatives of these two by t^2.
    let product = sinc * lag;
    let first_slope = S::from_f64(-0.5) * product;
    let second_slope = S::from_f64(-0.125) * product - cos * angle.sinc_minus_cos_derivative(w);
    let slopes = across.scale(first_slope) + along.scale(second_slope);
    let back = Quaternion::exp(w).conjugate();
    Matrix3::from_columns(|k| {
        let unit = Vector3::unit(k);
        let rotated = unit.cross(v);
        let moved = unit.cross(across) + w.cross(rotated);
        back.rotate(rotated.scale(first) + moved.scale(second) + slopes.scale(w.0[k] + w.0[k]))
    })
}

/// The functions of the angle t of a rotation vector that the maps need.
struct Angle<S> {
    /// sin(t/2) / (t/2)
    sinc: S,
    /// cos(t/2)
    cos: S,
    /// (sinc - cos) / t^2
    lag: S,
}

impl<S: Scalar> Angle<S> {
    fn of(w: Vector3<S>) -> Self {
        let square = w.dot(w);
        let near = S::from_f64(SERIES_LIMIT);
        let [sinc, lag] = [series(&SINC, square), series(&SINC_MINUS_COS, square)];
        let series = [sinc, sinc - square * lag, lag];
        // Keeps the closed form away from 0 / 0, whose derivative would be NaN although its value
        // is not selected.
        let far = square.max(near);
        let half = S::from_f64(0.5) * far.sqrt();
        let (sin, cos) = half.sin_cos();
        let sinc = sin / half;
        let closed = [sinc, cos, (sinc - cos) / far];
        let [sinc, cos, lag] =
            core::array::from_fn(|i| (square - near).select_nonnegative(closed[i], series[i]));
        Self { sinc, cos, lag }
    }

    /// Returns the derivative of `lag` by t^2; `w` is the rotation vector.
    fn sinc_minus_cos_derivative(&self, w: Vector3<S>) -> S {
        let square = w.dot(w);
        let near = S::from_f64(SERIES_LIMIT);
        let difference = S::from_f64(0.125) * self.sinc - S::from_f64(1.5) * self.lag;
        let closed = difference / square.max(near);
        (square - near).select_nonnegative(closed, series(&SINC_MINUS_COS_DERIVATIVE, square))
    }
}

fn series<S: Scalar>(coefficients: &[f64], x: S) -> S {
    coefficients.iter().rev().fold(S::zero(), |sum, &c| sum * x + S::from_f64(c))
}

#[cfg(all(test, feature = "num-dual"))]
mod tests {
    use num_dual::Dual3_64;

    use super::*;

    type Number = Dual3_64;

    /// Angles with series, with closed forms, and around the limit between them.
    const ANGLES: [f64; 12] =
        [0.0, 1e-160, 1e-12, 1e-8, 1e-5, 1e-3, 0.1, 0.124, 0.126, 0.249, 0.251, 2.9];

    fn along(direction: [f64; 3], t: Number) -> Vector3<Number> {
        Vector3(direction.map(|x| t * Number::from_f64(x)))
    }

    fn at(t: f64) -> Number {
        Number::from_re(t).derivative()
    }

    /// Compares the value and three derivatives.
    fn close(number: Number, expected: Number, what: &str) {
        let parts = |x: Number| [x.re, x.v1, x.v2, x.v3];
        for (order, (part, expected)) in parts(number).into_iter().zip(parts(expected)).enumerate()
        {
            let within = [1e-14, 1e-14, 1e-13, 1e-11][order];
            assert!(
                (part - expected).abs() <= within,
                "derivative {order} of {what}: {part} {expected}"
            );
        }
    }

    /// Rotations about an axis and screw motions, against sines and cosines of the angle.
    #[test]
    fn exponentials_have_their_derivatives() {
        let axis = [2.0 / 7.0, -3.0 / 7.0, 6.0 / 7.0];
        let v = [0.4, 1.1, -0.7];
        for angle in ANGLES {
            let t = at(angle);
            let (sin, cos) = (t * Number::from_f64(0.5)).sin_cos();
            let rotation = Quaternion::exp(along(axis, t));
            close(rotation.scalar, cos, &std::format!("w at {angle}"));
            let number = |x: [f64; 3]| Vector3(x.map(Number::from_f64));
            let [axis_, v_] = [number(axis), number(v)];
            for i in 0..3 {
                close(rotation.vector.0[i], axis_.0[i] * sin, &std::format!("x, y, z at {angle}"));
            }
            let (sin, cos) = t.sin_cos();
            let across = axis_.cross(v_);
            let slide = axis_.scale(axis_.dot(v_));
            let expected =
                slide.scale(t) + (v_ - slide).scale(sin) + across.scale(Number::one() - cos);
            let translation = screw_translation(along(axis, t), along(v, t));
            for i in 0..3 {
                close(translation.0[i], expected.0[i], &std::format!("translation at {angle}"));
            }
        }
    }

    #[test]
    fn logarithms_do_not_depend_on_the_length() {
        for angle in [1e-9, 1e-3, 0.124, 0.126, 0.5, 1.5, 2.5, 3.1] {
            let w = Vector3([2.0 / 7.0, -3.0 / 7.0, 6.0 / 7.0].map(|x| angle * x));
            for length in [1e-3, 0.03, 1.0, -7.0, 1e3] {
                let logarithm = Quaternion::exp(w).scale(length).log();
                for (number, expected) in logarithm.0.iter().zip(w.0) {
                    let error = (number - expected).abs();
                    assert!(error <= 1e-14 * angle, "{angle}, {length}: {number} {expected}");
                }
            }
        }
    }

    /// The inverse maps along lines that pass zero at some distance.
    #[test]
    fn inverses_have_their_derivatives() {
        let v = Vector3([0.4, 1.1, -0.7].map(Number::from_f64));
        for angle in ANGLES {
            for distance in [0.0, 1e-9, 1e-4, 0.1, 0.2, 1.0] {
                let what = std::format!("at {angle}, {distance} from zero");
                let aside = Vector3([0.6, 0.0, -0.8].map(|x| Number::from_f64(distance * x)));
                let w = along([0.48, 0.8, 0.36], at(angle)) + aside;
                let rotated = Quaternion::exp(w);
                let backwards = rotated.scale(-Number::one());
                let moved = screw_velocity(w, screw_translation(w, v));
                for i in 0..3 {
                    close(rotated.log().0[i], w.0[i], &what);
                    close(backwards.log().0[i], w.0[i], &what);
                    close(moved.0[i], v.0[i], &what);
                }
                close(rotated.square(), Number::one(), &what);
            }
        }
    }
}
