//! Snapping: constant angles close to a multiple of a quarter turn, and numbers close to zero,
//! become exact.

use crate::spatial::{AxisRotation, RigidInertia, Symmetric3, Vector3};

/// Sines, cosines and components of axes below this become 0, and so do offsets below this fraction
/// of the lengths that they move.
pub(super) const SNAP: f64 = 1e-11;

/// A first or second moment below this fraction of the largest one of the body is a rounding error,
/// and becomes 0. So does an offset below this fraction of the longest path from the root.
pub(super) const ROUNDING: f64 = 1e-14;

/// The cosine and sine of a constant angle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Direction {
    pub cos: f64,
    pub sin: f64,
}

/// The angle zero.
pub(super) const ZERO_ANGLE: Direction = Direction { cos: 1.0, sin: 0.0 };

/// Returns the direction of a vector in the x, y plane; the angle zero if its length in this plane
/// is at most `negligible`.
pub(super) fn direction_of(v: Vector3<f64>, negligible: f64) -> Direction {
    let [x, y, _] = v.0;
    let length = libm::hypot(x, y);
    if length <= negligible {
        return ZERO_ANGLE;
    }
    Direction { cos: x / length, sin: y / length }.snapped()
}

/// Returns a sine, a cosine or a component of an axis, or zero if it is negligible.
pub(super) fn snap(x: f64) -> f64 {
    without(SNAP, x)
}

/// Returns `x`, or zero if its magnitude is at most `negligible`.
pub(super) fn without(negligible: f64, x: f64) -> f64 {
    if x.abs() <= negligible { 0.0 } else { x }
}

impl Direction {
    /// Returns the angle with the opposite sign.
    pub fn inverse(self) -> Self {
        Self { sin: -self.sin, ..self }
    }

    /// Returns the sum of two angles.
    pub fn combine(self, other: Self) -> Self {
        let cos = self.cos * other.cos - self.sin * other.sin;
        let sin = self.sin * other.cos + self.cos * other.sin;
        Self { cos, sin }.snapped()
    }

    /// Returns the direction scaled to length 1, exactly along a coordinate axis if it is nearly
    /// parallel to one.
    pub fn snapped(self) -> Self {
        match (snap(self.cos), snap(self.sin)) {
            (cos, 0.0) => Self { cos: 1.0_f64.copysign(cos), sin: 0.0 },
            (0.0, sin) => Self { cos: 0.0, sin: 1.0_f64.copysign(sin) },
            (cos, sin) => {
                let length = libm::hypot(cos, sin);
                Self { cos: cos / length, sin: sin / length }
            }
        }
    }

    /// Returns the rotation by the angle.
    pub fn rotation(self) -> AxisRotation<f64> {
        let Self { cos, sin } = self;
        if sin == 0.0 {
            AxisRotation::Quarters(if cos > 0.0 { 0 } else { 2 })
        } else if cos == 0.0 {
            AxisRotation::Quarters(if sin > 0.0 { 1 } else { 3 })
        } else {
            AxisRotation::Angle { cos, sin }
        }
    }
}

/// Returns the inertia without moments that are only rounding errors of its rotation.
pub(super) fn without_rounding(inertia: RigidInertia<f64>) -> RigidInertia<f64> {
    let largest = |moments: &[f64]| moments.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let Vector3(first) = inertia.first_moment;
    let Symmetric3 { xx, yy, zz, xy, xz, yz } = inertia.second_moment;
    let of_first = ROUNDING * largest(&first);
    let of_second = ROUNDING * largest(&[xx, yy, zz, xy, xz, yz]);
    let [xx, yy, zz, xy, xz, yz] = [xx, yy, zz, xy, xz, yz].map(|x| without(of_second, x));
    RigidInertia {
        first_moment: Vector3(first.map(|x| without(of_first, x))),
        second_moment: Symmetric3 { xx, yy, zz, xy, xz, yz },
        ..inertia
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_errors_of_moments_become_zero() {
        let second = Symmetric3 { xx: 3.0, xy: -2e-14, xz: 0.25, yy: 2.0, yz: 4e-14, zz: 1.0 };
        let inertia = RigidInertia {
            mass: 2.0,
            first_moment: Vector3([0.5, -4e-15, 1e-9]),
            second_moment: second,
        };
        let kept = without_rounding(inertia);
        assert_eq!(kept.first_moment.0, [0.5, 0.0, 1e-9]);
        let Symmetric3 { xy, xz, yz, .. } = kept.second_moment;
        assert_eq!([xy, xz, yz, kept.mass], [0.0, 0.25, 4e-14, 2.0]);
    }
}
