//! External forces on links.

use crate::Scalar;
use crate::equations::Workspace;
use crate::equations::kinematics::kinematic_path;
use crate::mechanism::Mechanism;
use crate::spatial::{Matrix3, Vector3, Wrench};

/// External wrenches, N and N m: one for each link of the description, fixed links included, in the
/// description's order. Each wrench acts at its link's origin.
#[derive(Clone, Copy, Debug)]
pub enum Forces<'a, S> {
    /// Wrenches in the link's own axes.
    InLinkAxes(&'a [Wrench<S>]),
    /// Wrenches in the world's axes.
    InWorldAxes(&'a [Wrench<S>]),
}

impl<S: Scalar> Forces<'_, S> {
    /// Returns the wrenches without their frame.
    #[must_use]
    pub fn wrenches(&self) -> &[Wrench<S>] {
        match self {
            Self::InLinkAxes(wrenches) | Self::InWorldAxes(wrenches) => wrenches,
        }
    }

    /// Subtracts the external wrenches from `workspace.wrenches`. Expects the joint transforms at
    /// q.
    pub(in crate::equations) fn subtract(self, model: &Mechanism<S>, workspace: &mut Workspace<S>) {
        self.for_each(model, workspace, |workspace, body, point, Wrench { moment, force }| {
            let wrench = &mut workspace.wrenches[body];
            *wrench = *wrench - Wrench { moment: moment + point.cross(force), force };
        });
    }

    /// Calls `each` for each wrench on a body, with the body, the wrench in the axes of the body
    /// and the point at which the wrench acts, in the frame of the body. Expects the joint
    /// transforms at q.
    pub(in crate::equations) fn for_each(
        self,
        model: &Mechanism<S>,
        workspace: &mut Workspace<S>,
        mut each: impl FnMut(&mut Workspace<S>, usize, Vector3<S>, Wrench<S>),
    ) {
        let in_world = matches!(self, Self::InWorldAxes(_));
        if in_world {
            (0..model.bodies.len()).for_each(|i| kinematic_path::rotate_axes(model, i, workspace));
        }
        for (wrench, frame) in self.wrenches().iter().zip(&model.frames) {
            let Some(body) = frame.body else { continue };
            let to_body = if in_world {
                workspace.axes[body].transposed()
            } else {
                Matrix3(frame.pose.rotation)
            };
            let wrench = Wrench {
                moment: to_body.mul_vector(wrench.moment),
                force: to_body.mul_vector(wrench.force),
            };
            each(workspace, body, Vector3(frame.pose.translation), wrench);
        }
    }
}
