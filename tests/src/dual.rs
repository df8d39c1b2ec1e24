//! Dual numbers: forward-mode differentiation, exact within rounding.
//!
//! The interpreter has dual numbers of its own. These are a witness that shares no code with them.

use std::ops::{Add, Div, Mul, Neg, Sub};

use modyn_runtime::Scalar;
use modyn_runtime::joint::JointType;
use modyn_runtime::model::Model;

/// A number and its derivative in one direction.
#[derive(Clone, Copy, Debug)]
pub struct Tangent<S> {
    /// The number.
    pub x: S,
    /// The derivative of the number.
    pub dx: S,
}

impl<S: Scalar> Tangent<S> {
    /// Returns the dual number of a function with value `x` and derivative `slope` at this number.
    fn chain(self, x: S, slope: S) -> Self {
        Self { x, dx: self.dx * slope }
    }
}

impl<S: Scalar> Add for Tangent<S> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { x: self.x + other.x, dx: self.dx + other.dx }
    }
}

impl<S: Scalar> Sub for Tangent<S> {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self { x: self.x - other.x, dx: self.dx - other.dx }
    }
}

impl<S: Scalar> Mul for Tangent<S> {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Self { x: self.x * other.x, dx: self.dx * other.x + self.x * other.dx }
    }
}

impl<S: Scalar> Div for Tangent<S> {
    type Output = Self;
    #[allow(clippy::suspicious_arithmetic_impl)]
    fn div(self, other: Self) -> Self {
        self * other.recip()
    }
}

impl<S: Scalar> Neg for Tangent<S> {
    type Output = Self;
    fn neg(self) -> Self {
        Self { x: -self.x, dx: -self.dx }
    }
}

impl<S: Scalar> Scalar for Tangent<S> {
    fn from_f64(value: f64) -> Self {
        Self { x: S::from_f64(value), dx: S::zero() }
    }

    fn recip(self) -> Self {
        let x = self.x.recip();
        self.chain(x, -(x * x))
    }

    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = self.x.sin_cos();
        (self.chain(sin, cos), self.chain(cos, -sin))
    }

    fn atan2(self, other: Self) -> Self {
        let (y, x) = (self, other);
        let square = y.x * y.x + x.x * x.x;
        Self { x: y.x.atan2(x.x), dx: (x.x * y.dx - y.x * x.dx) * square.recip() }
    }

    fn sqrt(self) -> Self {
        let x = self.x.sqrt();
        self.chain(x, S::from_f64(0.5) * x.recip())
    }

    fn ln(self) -> Self {
        self.chain(self.x.ln(), self.x.recip())
    }

    fn abs(self) -> Self {
        let slope = self.x.select_nonnegative(S::one(), -S::one());
        self.chain(self.x.abs(), slope)
    }

    fn max(self, other: Self) -> Self {
        (self - other).select_nonnegative(self, other)
    }

    fn select_nonnegative(self, then: Self, otherwise: Self) -> Self {
        Self {
            x: self.x.select_nonnegative(then.x, otherwise.x),
            dx: self.x.select_nonnegative(then.dx, otherwise.dx),
        }
    }
}

/// Returns `x` with all derivatives zero.
pub fn constant<S: Scalar>(x: &[S]) -> Vec<Tangent<S>> {
    x.iter().map(|&x| Tangent { x, dx: S::zero() }).collect()
}

/// Returns `x` with the derivatives by its entry `k`.
pub fn along<S: Scalar>(x: &[S], k: usize) -> Vec<Tangent<S>> {
    let mut seeded = constant(x);
    seeded[k].dx = S::one();
    seeded
}

/// Returns the coordinates `q` with the derivatives along velocity `k`: q (w, 0) / 2 for a quaternion, R v for the
/// position of a floating joint, and the velocity itself for other joints.
pub fn along_velocity<S: Scalar>(model: &Model, q: &[S], k: usize) -> Vec<Tangent<S>> {
    let mut seeded = constant(q);
    for (i, link) in model.moving_links().iter().enumerate() {
        if link.joint.mimic.is_some() || !model.v_range(i).contains(&k) {
            continue;
        }
        let (at, k) = (model.q_range(i).start, k - model.v_range(i).start);
        let (linear, angular) = match link.joint.joint_type {
            JointType::Spherical => (None, Some((at, k))),
            JointType::Floating if k < 3 => (Some(k), None),
            JointType::Floating => (None, Some((at + 3, k - 3))),
            _ => {
                seeded[at + k].dx = S::one();
                (None, None)
            }
        };
        if let Some(k) = linear {
            let quaternion: [S; 4] = std::array::from_fn(|c| q[at + 3 + c]);
            for (entry, rate) in seeded[at..at + 3].iter_mut().zip(axis(quaternion, k)) {
                entry.dx = rate;
            }
        }
        if let Some((at, k)) = angular {
            let half: [S; 4] = std::array::from_fn(|c| S::from_f64(0.5) * q[at + c]);
            let [x, y, z, w] = half;
            let rates = [[w, z, -y, -x], [-z, w, x, -y], [y, -x, w, -z]];
            for (entry, rate) in seeded[at..at + 4].iter_mut().zip(rates[k]) {
                entry.dx = rate;
            }
        }
    }
    seeded
}

/// Returns axis `k`, rotated by a unit quaternion.
fn axis<S: Scalar>([x, y, z, w]: [S; 4], k: usize) -> [S; 3] {
    let (one, two) = (S::one(), S::from_f64(2.0));
    match k {
        0 => [one - two * (y * y + z * z), two * (x * y + w * z), two * (x * z - w * y)],
        1 => [two * (x * y - w * z), one - two * (x * x + z * z), two * (y * z + w * x)],
        _ => [two * (x * z + w * y), two * (y * z - w * x), one - two * (x * x + y * y)],
    }
}

/// Returns the blocks (q, q), (q, qd), (qd, qd) and (q, x) of the Hessian by (q, qd, x), by columns; x are accelerations or
/// joint forces, and all have `n` entries. `entry` returns the second derivative along two of all entries.
///
/// # Panics
///
/// If the blocks (qd, x) and (x, x) are not zero within `tolerance`.
pub fn hessian_blocks(
    n: usize,
    mut entry: impl FnMut(usize, usize) -> f64,
    tolerance: f64,
) -> Vec<f64> {
    let mut block = |rows: usize, columns: usize| -> Vec<f64> {
        let entries = (0..n * n).map(|k| (rows * n + k % n, columns * n + k / n));
        // Displacements of one rotation do not commute.
        let symmetric = |(a, b)| match (rows, columns) {
            (0, 0) => 0.5 * (entry(a, b) + entry(b, a)),
            _ => entry(a, b),
        };
        entries.map(symmetric).collect()
    };
    let blocks = [block(0, 0), block(0, 1), block(1, 1), block(0, 2)];
    let size = blocks.concat().iter().fold(1.0, |size: f64, x| size.max(x.abs()));
    for rest in [block(1, 2), block(2, 2)] {
        assert!(rest.iter().all(|x| x.abs() <= tolerance * size), "{rest:?}");
    }
    blocks.concat()
}
