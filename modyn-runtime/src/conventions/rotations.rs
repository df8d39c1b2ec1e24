//! Quaternions and rotation matrices.

use crate::Scalar;
use crate::spatial::Quaternion;

/// Returns the quaternion x, y, z, w, from w, x, y, z.
///
/// ```
/// assert_eq!(modyn_runtime::conventions::xyzw_from_wxyz([1.0, 2.0, 3.0, 4.0]), [2.0, 3.0, 4.0, 1.0]);
/// ```
#[must_use]
pub fn xyzw_from_wxyz<T>([w, x, y, z]: [T; 4]) -> [T; 4] {
    [x, y, z, w]
}

/// Returns the quaternion w, x, y, z, from x, y, z, w.
///
/// ```
/// assert_eq!(modyn_runtime::conventions::wxyz_from_xyzw([1.0, 2.0, 3.0, 4.0]), [4.0, 1.0, 2.0, 3.0]);
/// ```
#[must_use]
pub fn wxyz_from_xyzw<T>([x, y, z, w]: [T; 4]) -> [T; 4] {
    [w, x, y, z]
}

/// Returns the rotation matrix, by rows, of a unit quaternion `[x, y, z, w]`.
///
/// ```
/// use modyn_runtime::conventions::rotation_from_quaternion;
///
/// let half_a_turn_about_z = rotation_from_quaternion([0.0, 0.0, 1.0, 0.0]);
/// assert_eq!(half_a_turn_about_z, [[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]]);
/// ```
#[must_use]
pub fn rotation_from_quaternion<T: Scalar>(quaternion: [T; 4]) -> [[T; 3]; 3] {
    Quaternion::from_components(quaternion).matrix().0
}

/// Returns the unit quaternion `[x, y, z, w]`, w >= 0, of a rotation matrix by rows.
///
/// It is accurate to rounding for every rotation, since it divides by the largest of the four
/// components.
///
/// ```
/// use modyn_runtime::conventions::quaternion_from_rotation;
///
/// let a_third_of_a_turn = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
/// assert_eq!(quaternion_from_rotation(a_third_of_a_turn), [0.5, 0.5, 0.5, 0.5]);
/// ```
#[must_use]
pub fn quaternion_from_rotation<T: Scalar>(rotation: [[T; 3]; 3]) -> [T; 4] {
    let [[xx, xy, xz], [yx, yy, yz], [zx, zy, zz]] = rotation;
    let one = T::one();
    let sxy = xy + yx;
    let sxz = xz + zx;
    let syz = yz + zy;
    let dx = zy - yz;
    let dy = xz - zx;
    let dz = yx - xy;
    // The quaternion times four times its first, second, third, fourth component.
    let by_x = [one + xx - yy - zz, sxy, sxz, dx];
    let by_y = [sxy, one - xx + yy - zz, syz, dy];
    let by_z = [sxz, syz, one - xx - yy + zz, dz];
    let by_w = [dx, dy, dz, one + xx + yy + zz];
    let either = |which: T, a: [T; 4], b: [T; 4]| -> [T; 4] {
        core::array::from_fn(|i| which.select_nonnegative(a[i], b[i]))
    };
    let by_xy = either(xx - yy, by_x, by_y);
    let by_zw = either(-(xx + yy), by_z, by_w);
    let largest_xy = (xx - yy).select_nonnegative(by_x[0], by_y[1]);
    let largest_zw = (-(xx + yy)).select_nonnegative(by_z[2], by_w[3]);
    let q = either(largest_xy - largest_zw, by_xy, by_zw);
    let [x, y, z, w] = q;
    let length = (x * x + y * y + z * z + w * w).sqrt();
    let scale = w.select_nonnegative(length, -length).recip();
    q.map(|number| number * scale)
}
