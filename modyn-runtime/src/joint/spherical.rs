//! Spherical joints: any rotation, by a unit quaternion and the angular velocity behind the joint.

use super::Carried;
use crate::Scalar;
use crate::model::prepare::Zero;
use crate::spatial::{Axis, Field, Matrix3, Vector3};

/// The axes behind the joint, seen from in front of it: those of the unit quaternion x, y, z, w,
/// turned by the frame's own zero.
pub(super) fn rotation<S: Scalar>(zero: Zero<S>, [x, y, z, w]: [S; 4]) -> Matrix3<S> {
    let (x2, y2, z2) = (x + x, y + y, z + z);
    let (xx, yy, zz) = (x * x2, y * y2, z * z2);
    let (xy, xz, yz) = (x * y2, x * z2, y * z2);
    let (wx, wy, wz) = (w * x2, w * y2, w * z2);
    let one = S::one();
    let columns = [
        [one - (yy + zz), xy + wz, xz - wy],
        [xy - wz, one - (xx + zz), yz + wx],
        [xz + wy, yz - wx, one - (xx + yy)],
    ];
    let turn = zero.turn();
    Matrix3(columns.map(|column| turn.vector(Axis::Z, Vector3(column)).0)).transposed()
}

pub(super) fn accelerate<S: Scalar>(
    Carried { omega, alpha, a }: Carried<S>,
    rates: &[S],
    accelerations: Option<&[S]>,
) -> Field<S> {
    let rate = Vector3([rates[0], rates[1], rates[2]]);
    let mut alpha = alpha + omega.cross(rate);
    if let Some(own) = accelerations {
        alpha += Vector3([own[0], own[1], own[2]]);
    }
    Field { a, ..Field::turning(omega + rate, alpha) }
}
