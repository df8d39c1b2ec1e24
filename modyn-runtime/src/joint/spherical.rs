//! Spherical joints: any rotation. The coordinates are a unit quaternion, the velocity is the
//! angular velocity in the child frame.

use super::{JointOffset, ParentMotion};
use crate::Scalar;
use crate::spatial::{Axis, Field, Matrix3, Quaternion, Vector3};

/// Returns the child's axes in the parent frame: the rotation of the unit quaternion x, y, z, w,
/// rotated by the frame's offset.
pub(super) fn rotation<S: Scalar>(offset: JointOffset<S>, quaternion: [S; 4]) -> Matrix3<S> {
    let columns = Quaternion::from_components(quaternion).matrix().transposed().0;
    let about_z = offset.rotation();
    Matrix3(columns.map(|column| about_z.vector(Axis::Z, Vector3(column)).0)).transposed()
}

pub(super) fn accelerate<S: Scalar>(
    ParentMotion { omega, alpha, a }: ParentMotion<S>,
    rates: &[S],
    accelerations: Option<&[S]>,
) -> Field<S> {
    let rate = Vector3([rates[0], rates[1], rates[2]]);
    let mut alpha = alpha + omega.cross(rate);
    if let Some(numbers) = accelerations {
        alpha += Vector3([numbers[0], numbers[1], numbers[2]]);
    }
    Field { a, ..Field::rotating(omega + rate, alpha) }
}
