//! Snapping: constant angles close to a multiple of a quarter turn, and numbers close to zero, become exact.

use crate::spatial::{AxisRotation, Vector3};

/// Sines, cosines, translations (m) and components of axes below this become 0.
const SNAP: f64 = 1e-11;

/// The cosine and sine of a constant angle.
pub(super) type Direction = (f64, f64);

/// The angle zero.
pub(super) const ZERO_ANGLE: Direction = (1.0, 0.0);

/// Returns the direction of a vector in the x, y plane; the angle zero for a vector along z.
pub(super) fn direction_of(v: Vector3<f64>) -> Direction {
    let [x, y, _] = v.0;
    let length = libm::hypot(x, y);
    if length < 1e-12 { ZERO_ANGLE } else { snapped((x / length, y / length)) }
}

pub(super) fn inverse((cos, sin): Direction) -> Direction {
    (cos, -sin)
}

/// Returns the sum of two angles.
pub(super) fn combine((c, s): Direction, (cos, sin): Direction) -> Direction {
    snapped((c * cos - s * sin, s * cos + c * sin))
}

pub(super) fn snap(x: f64) -> f64 {
    if x.abs() < SNAP { 0.0 } else { x }
}

/// Returns a direction scaled to length 1, exactly along a coordinate axis if it is nearly parallel to one.
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
