//! The error of a pose, and its derivative.

use modyn::na::{DMatrix, Isometry3, Matrix3, SMatrix, SVector};
use modyn::spatial::{Quaternion, Vector3, inverse_rotation_jacobian};
use modyn::{Pose, Robot, functions};

/// Returns the error of a pose: the displacement from the target to the pose in world axes, m, then the rotation vector
/// from the target to the pose in the target's axes, rad.
pub(crate) fn pose_error(pose: &Pose<f64>, target: &Pose<f64>) -> SVector<f64, 6> {
    let [a, b, c] = rotation_vector(pose, target).0;
    let [x, y, z]: [f64; 3] = core::array::from_fn(|i| pose.translation[i] - target.translation[i]);
    SVector::from([x, y, z, a, b, c])
}

/// Returns the derivative of [`pose_error`] with respect to the coordinates of a robot in tangent space, of the frame
/// `link`: 6 rows and nv columns.
///
/// The Jacobian of the link maps velocities to a twist in world axes; the inverse Jacobian of the exponential map takes
/// the angular velocity to the rate of the rotation vector.
pub(crate) fn pose_error_derivative<R>(
    q: &R::Q<f64>,
    link: R::Link,
    target: &Pose<f64>,
) -> DMatrix<f64>
where
    R: Robot + functions::LinkPose + functions::Jacobian,
{
    let pose = R::link_pose(q, link);
    let rows = inverse_rotation_jacobian(rotation_vector(&pose, target)).0;
    // The rotation's columns are the link's axes in the world: its transpose brings the twist to the link's axes.
    let to_link = Matrix3::from(pose.rotation);
    let by_angular = Matrix3::from(rows).transpose() * to_link;
    let mut by_twist = SMatrix::<f64, 6, 6>::identity();
    by_twist.fixed_view_mut::<3, 3>(3, 3).copy_from(&by_angular);
    let jacobian = R::jacobian(q, link);
    let columns: Vec<SVector<f64, 6>> = jacobian
        .as_ref()
        .iter()
        .map(|twist| by_twist * SVector::<f64, 6>::from(twist.components()))
        .collect();
    DMatrix::from_fn(6, R::NV, |i, j| columns[j][i])
}

fn rotation_vector(pose: &Pose<f64>, target: &Pose<f64>) -> Vector3<f64> {
    let [pose, target] = [pose, target].map(|pose| Isometry3::from(*pose).rotation);
    Quaternion::from_components((target.inverse() * pose).coords.into()).log()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robots::{Arm, ArmLink};

    /// At rotations up to nearly half a turn.
    #[test]
    fn derivative_is_that_of_differences() {
        let q = [0.3, -0.5, 0.7, -1.9, 0.4, 1.3, -0.8];
        let mut largest = 0.0_f64;
        for goal in [
            [0.3, -0.5, 0.7, -1.9, 0.4, 1.3, -0.8 + 1e-3],
            [1.1, 0.2, -0.4, -1.1, -0.6, 2.1, 0.9],
            [-1.3, 0.6, 1.4, -2.4, 1.7, 0.6, 1.2],
        ] {
            let target = Arm::link_pose(&goal, ArmLink::GraspPoint);
            let error = |q: &[f64; 7]| pose_error(&Arm::link_pose(q, ArmLink::GraspPoint), &target);
            largest = largest.max(error(&q).fixed_rows::<3>(3).norm());
            let derivative = pose_error_derivative::<Arm>(&q, ArmLink::GraspPoint, &target);
            for j in 0..7 {
                let at = |step: f64| {
                    let mut q = q;
                    q[j] += step;
                    error(&q)
                };
                let expected = (at(1e-6) - at(-1e-6)) / 2e-6;
                assert!((derivative.column(j) - expected).amax() < 1e-8, "{goal:?}, {j}");
            }
        }
        assert!(largest > 1.5, "{largest}");
    }
}
