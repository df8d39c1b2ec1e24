//! The motion of a joint's parent frame, from the motion of the parent body.

use crate::Scalar;
use crate::equations::Workspace;
use crate::joint::{JointTransform, ParentMotion};
use crate::mechanism::{Body, BodyTree};
use crate::spatial::{Field, Vector3};

/// Returns the motion of the parent frame of body `i`'s joint, in the axes and at the origin of
/// body `i`.
pub(in crate::equations) fn parent_motion<S: Scalar, T: BodyTree<S>>(
    tree: &T,
    i: usize,
    workspace: &Workspace<S>,
) -> ParentMotion<S> {
    let model = tree.mechanism();
    let body = &model.bodies[i];
    let motion = &workspace.motions[i];
    match body.parent {
        None => {
            let zero = Vector3::zero();
            let a = body.to_child(motion, -model.gravity);
            ParentMotion { omega: zero, alpha: zero, a }
        }
        Some(parent) if tree.parents(i).is_none() => {
            parent_motion_at_joint(&workspace.fields[parent], body, motion)
        }
        Some(_) => {
            let at_rest = Field { a: -model.gravity, ..Field::zero() };
            let field_of = |p: Option<usize>| p.map_or(at_rest, |p| workspace.fields[p]);
            let get = |part: fn(&Field<S>) -> Vector3<S>| {
                Vector3(tree.broadcast_from_parents(i, |p| part(&field_of(p)).0))
            };
            let field = Field::rotating(get(|f| f.omega), get(|f| f.alpha));
            parent_motion_at_joint(&Field { a: get(|f| f.a), ..field }, body, motion)
        }
    }
}

/// Returns the motion of the parent frame of `body`'s joint; `parent` is the motion of the parent
/// body.
pub(in crate::equations) fn parent_motion_at_joint<S: Scalar>(
    parent: &Field<S>,
    body: &Body<S>,
    motion: &JointTransform<S>,
) -> ParentMotion<S> {
    let to_child = |v| body.to_child(motion, v);
    let a = parent.a + parent.relative_acceleration(body.placement.origin());
    let omega = to_child(parent.omega);
    let alpha = to_child(parent.alpha);
    ParentMotion { omega, alpha, a: to_child(a) }
}
