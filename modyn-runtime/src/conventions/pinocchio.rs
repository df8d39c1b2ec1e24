//! Pinocchio: conversions for the unbounded revolute joint (URDF: continuous).
//!
//! Pinocchio's free-flyer and spherical joint have the same coordinates and velocities as modyn's
//! floating and spherical joint. The unbounded revolute joint and the planar joint differ.
//!
//! Source:
//! [the free-flyer's documentation](https://docs.ros.org/en/jazzy/p/pinocchio/generated/function_namespacepinocchio_1aa5005bfe0ffbbdc62952c3c432e4eab7.html):
//! coordinates translation and quaternion x, y, z, w from child to parent; velocities linear and
//! angular in the child's frame, after Featherstone; and `joint-revolute-unbounded.hpp`.

use crate::Scalar;

/// Returns Pinocchio's two coordinates of an unbounded revolute joint, (cos, sin), from the angle
/// in rad.
#[must_use]
pub fn cos_sin_from_angle<T: Scalar>(angle: T) -> [T; 2] {
    let (sin, cos) = angle.sin_cos();
    [cos, sin]
}

/// Returns the angle in rad, in [-pi, pi], from Pinocchio's two coordinates of an unbounded
/// revolute joint.
///
/// ```
/// use modyn_runtime::conventions::pinocchio::{angle_from_cos_sin, cos_sin_from_angle};
///
/// assert!((angle_from_cos_sin(cos_sin_from_angle(2.5_f64)) - 2.5).abs() < 1e-15);
/// ```
#[must_use]
pub fn angle_from_cos_sin<T: Scalar>([cos, sin]: [T; 2]) -> T {
    sin.atan2(cos)
}
