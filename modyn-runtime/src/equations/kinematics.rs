//! Where the links stand.

use super::Workspace;
use crate::Scalar;
use crate::model::prepare::Prepared;
use crate::spatial::{Matrix3, Pose, Vector3};

/// The poses of all links of the description in the world, in the description's order.
pub fn link_poses<S: Scalar>(
    model: &Prepared<S>,
    q: &[S],
    workspace: &mut Workspace<S>,
    body_poses: &mut [Pose<S>],
    poses: &mut [Pose<S>],
) {
    workspace.move_to(model, q);
    for (i, body) in model.bodies.iter().enumerate() {
        let motion = &workspace.motions[i];
        let parent = body.parent.map_or_else(Pose::identity, |p| body_poses[p]);
        let (axes, origin) = (Matrix3(parent.rotation), Vector3(parent.translation));
        let at_joint = body.placement.turn_axes(&axes);
        let mut origin = origin + axes.mul_vector(body.placement.origin());
        if let Some(displacement) = motion.displacement() {
            origin += at_joint.mul_vector(displacement);
        }
        let rotation = motion.turn_axes(&at_joint).0;
        body_poses[i] = Pose { rotation, translation: origin.0 };
    }
    for (pose, frame) in poses.iter_mut().zip(&model.frames) {
        *pose = frame.body.map_or(frame.pose, |body| body_poses[body].compose(&frame.pose));
    }
}
