//! Rotations and directions in descriptions.

use modyn_runtime::spatial::{Matrix3, Pose, Vector3};

/// The smallest magnitude that is rejected: products of such numbers could overflow.
pub const MAX_NUMBER: f64 = 1e60;

/// The magnitude from which a limit is no limit. Other software requires limits where modyn does
/// not.
pub const UNLIMITED: f64 = 1e30;

/// Returns `Rz(yaw) Ry(pitch) Rx(roll)`. Sines are libm's, so that every host computes the same
/// numbers.
pub fn roll_pitch_yaw([roll, pitch, yaw]: [f64; 3]) -> [[f64; 3]; 3] {
    let (sr, cr) = libm::sincos(roll);
    let (sp, cp) = libm::sincos(pitch);
    let (sy, cy) = libm::sincos(yaw);
    [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
}

/// Returns the direction scaled to unit length, and its length; `None` for zero.
pub fn normalized(axis: [f64; 3]) -> Option<([f64; 3], f64)> {
    // Scaled first, so that no square overflows or underflows.
    let largest = axis.iter().fold(0.0, |max: f64, x| max.max(x.abs()));
    if largest == 0.0 {
        return None;
    }
    let scaled = axis.map(|x| x / largest);
    let length = libm::sqrt(scaled.iter().map(|x| x * x).sum());
    Some((scaled.map(|x| x / length), largest * length))
}

/// Returns the vector product.
pub fn cross([ax, ay, az]: [f64; 3], [bx, by, bz]: [f64; 3]) -> [f64; 3] {
    [ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx]
}

/// Returns the frame of a plane through a point with a unit normal. The axes are the axes of
/// `MuJoCo`'s contacts with the plane: z is the normal, x the first tangent.
pub fn contact_plane(point: [f64; 3], normal: [f64; 3]) -> Pose<f64> {
    let normal = Vector3(normal);
    let near = Vector3(if normal.0[1].abs() < 0.5 { [0.0, 1.0, 0.0] } else { [0.0, 0.0, 1.0] });
    let in_plane = near - normal.scale(normal.dot(near));
    let tangent = in_plane.scale(1.0 / libm::sqrt(in_plane.dot(in_plane)));
    let axes = [tangent, normal.cross(tangent), normal];
    Pose { rotation: Matrix3::from_columns(|k| axes[k]).0, translation: point }
}

/// Returns whether two unit vectors are parallel, or nearly so, as for the axes of a universal
/// joint.
pub fn are_parallel(a: [f64; 3], b: [f64; 3]) -> bool {
    let cos: f64 = a.iter().zip(&b).map(|(a, b)| a * b).sum();
    cos.abs() > PARALLEL
}

/// The cosine above which two axes count as parallel, as in [`modyn_runtime::model::Model`].
const PARALLEL: f64 = 1.0 - 1e-6;
