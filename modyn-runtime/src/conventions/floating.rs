//! The components of modyn's floating joint.

use crate::Scalar;
use crate::spatial::{Quaternion, Vector3};

/// Returns the rotation of modyn's coordinates: from the link's axes to the joint's axes.
pub(super) fn joint_rotation<T: Scalar>(q: [T; 7]) -> Quaternion<T> {
    Quaternion::from_components(quaternion(q))
}

/// Returns the quaternion of modyn's coordinates.
pub(super) fn quaternion<T>([_, _, _, x, y, z, w]: [T; 7]) -> [T; 4] {
    [x, y, z, w]
}

pub(super) fn halves<T>([a, b, c, d, e, f]: [T; 6]) -> [Vector3<T>; 2] {
    [Vector3([a, b, c]), Vector3([d, e, f])]
}

pub(super) fn concatenate<T>(
    Vector3([a, b, c]): Vector3<T>,
    Vector3([d, e, f]): Vector3<T>,
) -> [T; 6] {
    [a, b, c, d, e, f]
}
