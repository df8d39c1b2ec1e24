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
pub(super) type Direction = (f64, f64);

/// The angle zero.
pub(super) const ZERO_ANGLE: Direction = (1.0, 0.0);

/// Returns the direction of a vector in the x, y plane; the angle zero if its length in this plane
/// is at most `negligible`.
pub(super) fn direction_of(v: Vector3<f64>, negligible: f64) -> Direction {
    let [x, y, _] = v.0;
    let length = libm::hypot(x, y);
    if length <= negligible { ZERO_ANGLE } else { snapped((x / length, y / length)) }
}

pub(super) fn inverse((cos, sin): Direction) -> Direction {
    (cos, -sin)
}

/// Returns the sum of two angles.
pub(super) fn combine((c, s): Direction, (cos, sin): Direction) -> Direction {
    snapped((c * cos - s * sin, s * cos + c * sin))
}

/// Returns a sine, a cosine or a component of an axis, or zero if it is negligible.
pub(super) fn snap(x: f64) -> f64 {
    without(SNAP, x)
}

/// Returns `x`, or zero if its magnitude is at most `negligible`.
pub(super) fn without(negligible: f64, x: f64) -> f64 {
    if x.abs() <= negligible { 0.0 } else { x }
}

/// Returns a direction scaled to length 1, exactly along a coordinate axis if it is nearly parallel
/// to one.
pub(super) fn snapped((cos, sin): Direction) -> Direction {
    match (snap(cos), snap(sin)) {
        (cos, 0.0) => (1.0_f64.copysign(cos), 0.0),
        (0.0, sin) => (0.0, 1.0_f64.copysign(sin)),
        (cos, sin) => {
            let length = libm::hypot(cos, sin);
            (cos / length, sin / length)
        }
    }
}

pub(super) fn rotation_by((cos, sin): Direction) -> AxisRotation<f64> {
    if sin == 0.0 {
        AxisRotation::Quarters(if cos > 0.0 { 0 } else { 2 })
    } else if cos == 0.0 {
        AxisRotation::Quarters(if sin > 0.0 { 1 } else { 3 })
    } else {
        AxisRotation::Angle { cos, sin }
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
