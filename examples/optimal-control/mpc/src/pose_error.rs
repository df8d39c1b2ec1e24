//! The error of a pose, and its derivative.

use modyn::spatial::{Matrix3, Quaternion, Vector3, inverse_rotation_jacobian};
use modyn::{Array as _, Pose, Robot, functions};

/// Returns the error of a pose: the displacement from the target to the pose in world axes, m, then the rotation vector
/// from the target to the pose in the target's axes, rad.
#[must_use]
pub fn pose_error(pose: &Pose<f64>, target: &Pose<f64>) -> [f64; 6] {
    let [a, b, c] = rotation_vector(pose, target).0;
    let [x, y, z] = core::array::from_fn(|i| pose.translation[i] - target.translation[i]);
    [x, y, z, a, b, c]
}

/// Returns the derivative of [`pose_error`] of the frame `link` with respect to the coordinates in tangent space: a row
/// for each number of the error. `pose` is the pose of the frame at q, and `error` its error.
///
/// The Jacobian of the link maps velocities to a twist in world axes; the inverse Jacobian of the exponential map takes
/// the angular velocity in the link's axes to the rate of the rotation vector.
pub fn pose_error_derivative<R>(
    q: &R::Q<f64>,
    link: R::Link,
    pose: &Pose<f64>,
    error: &[f64; 6],
) -> [R::V<f64>; 6]
where
    R: Robot + functions::Jacobian,
{
    let [.., a, b, c] = *error;
    let to_rate = inverse_rotation_jacobian(Vector3([a, b, c]));
    let to_link = Matrix3(pose.rotation).transposed();
    let jacobian = R::jacobian(q, link);
    let mut rows = [R::V::<f64>::from_fn(|_| 0.0); 6];
    for (j, twist) in jacobian.as_ref().iter().enumerate() {
        let rate = to_rate.mul_vector(to_link.mul_vector(twist.angular));
        for i in 0..3 {
            rows[i].as_mut()[j] = twist.linear.0[i];
            rows[3 + i].as_mut()[j] = rate.0[i];
        }
    }
    rows
}

/// Returns the rotation vector from the target to the pose in the target's axes.
fn rotation_vector(pose: &Pose<f64>, target: &Pose<f64>) -> Vector3<f64> {
    let rotation = Matrix3(target.rotation).transposed().times(&Matrix3(pose.rotation));
    let entry = |i: usize, j: usize| rotation.0[i][j];
    // Four times a component of the quaternion, times the quaternion: the largest component has no cancellation (Shepperd
    // 1978, "Quaternion from rotation matrix").
    let trace = entry(0, 0) + entry(1, 1) + entry(2, 2);
    let squares = [entry(0, 0), entry(1, 1), entry(2, 2), trace];
    let largest = (0..4).fold(0, |best, i| if squares[i] > squares[best] { i } else { best });
    let mut components = [0.0; 4];
    for (i, component) in components.iter_mut().enumerate() {
        *component = if i == largest {
            1.0 + 2.0 * squares[i] - trace
        } else if i == 3 || largest == 3 {
            let [a, b] = [[1, 2], [2, 0], [0, 1]][i.min(largest)];
            entry(b, a) - entry(a, b)
        } else {
            entry(i, largest) + entry(largest, i)
        };
    }
    Quaternion::from_components(components).log()
}
