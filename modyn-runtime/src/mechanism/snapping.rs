//! Constant angles, and numbers that are rounding noise next to a quarter turn or to zero.

use crate::spatial::{AxisRotation, Vector3};

/// Sines, cosines, translations (m) and components of axes nearer to 0 than this are taken for it.
const SNAP: f64 = 1e-11;

/// Cosine and sine of a constant angle.
pub(super) type Direction = (f64, f64);

/// The angle zero.
pub(super) const ZERO_ANGLE: Direction = (1.0, 0.0);

/// The direction of a vector in the x, y plane; the angle zero where it has none.
pub(super) fn direction_of(v: Vector3<f64>) -> Direction {
    let [x, y, _] = v.0;
    let length = libm::hypot(x, y);
    if length < 1e-12 { ZERO_ANGLE } else { snapped((x / length, y / length)) }
}

pub(super) fn inverse((cos, sin): Direction) -> Direction {
    (cos, -sin)
}

/// The sum of the angles.
pub(super) fn combine((c, s): Direction, (cos, sin): Direction) -> Direction {
    snapped((c * cos - s * sin, s * cos + c * sin))
}

pub(super) fn snap(x: f64) -> f64 {
    if x.abs() < SNAP { 0.0 } else { x }
}

/// A direction scaled to length 1 again, along an axis where it is nearly parallel to one.
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
