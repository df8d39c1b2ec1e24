//! The conversion of poses from mjcf-rs.

use modyn_runtime::conventions::rotation_from_quaternion;
use modyn_runtime::spatial::Pose;

/// Returns a pose in modyn's form.
pub fn pose(pose: &mjcf_rs::Pose) -> Pose<f64> {
    let rotation = rotation_from_quaternion(pose.rotation.to_array());
    Pose { rotation, translation: pose.translation.to_array() }
}
