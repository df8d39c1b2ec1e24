//! The wrenches that a motion asks of each body by itself, by Newton and Euler.
//!
//! Accelerations are the classical ones of the bodies' origins, in the bodies' own axes (see
//! [`Field`](crate::spatial::Field)). Gravity is an acceleration of the world upwards.

use crate::Scalar;
use crate::equations::Workspace;
use crate::joint::{Carried, Motion, Primitive};
use crate::mechanism::{Body, Prepared};
use crate::spatial::{Field, Vector3};

/// How the joints accelerate.
#[derive(Clone, Copy, Debug)]
pub(in crate::equations) enum Accelerations<'a, S> {
    /// Not at all.
    None,
    /// Not at all, but a floating base so that its origin is in free fall: see [`free_fall`].
    FreeFall,
    /// So.
    Given(&'a [S]),
    /// So, but a floating base's origin against free fall: its linear numbers are classical
    /// accelerations.
    AgainstFall(&'a [S]),
}

/// Fills `workspace.wrenches` with each body's own wrench, those of its children left out.
///
/// Expects the joints at q.
pub(in crate::equations) fn link_wrenches<S: Scalar>(
    model: &Prepared<S>,
    qd: &[S],
    accelerations: Accelerations<'_, S>,
    workspace: &mut Workspace<S>,
) {
    for (i, body) in model.bodies.iter().enumerate() {
        let carried = carried(model, i, workspace);
        let own = match accelerations {
            Accelerations::Given(qdd) | Accelerations::AgainstFall(qdd) => {
                Some(model.rates(i, qdd))
            }
            _ => None,
        };
        let mut field =
            workspace.motions[i].accelerate(carried, &model.rates(i, qd), own.as_deref());
        if is_base(model, i) {
            match (accelerations, &own) {
                (Accelerations::FreeFall, _) => field.a = Vector3::zero(),
                (Accelerations::AgainstFall(_), Some(own)) => {
                    field.a = Vector3([own[0], own[1], own[2]]);
                }
                _ => {}
            }
        }
        workspace.fields[i] = field;
        workspace.wrenches[i] = field.wrench(&body.minimal);
    }
}

/// What body `i`'s joint has in front of it, from its parent's motion.
pub(in crate::equations) fn carried<S: Scalar>(
    model: &Prepared<S>,
    i: usize,
    workspace: &Workspace<S>,
) -> Carried<S> {
    let (body, motion) = (&model.bodies[i], &workspace.motions[i]);
    match body.parent {
        None => {
            let (zero, a) = (Vector3::zero(), body.to_child(motion, -model.gravity));
            Carried { omega: zero, alpha: zero, a }
        }
        Some(parent) if body.parents.is_empty() => {
            carried_by(&workspace.fields[parent], body, motion)
        }
        Some(_) => {
            let at_rest = Field { a: -model.gravity, ..Field::zero() };
            let of = |p: Option<usize>| p.map_or(at_rest, |p| workspace.fields[p]);
            let get =
                |part: fn(&Field<S>) -> Vector3<S>| Vector3(body.from_parents(|p| part(&of(p)).0));
            let field = Field::turning(get(|f| f.omega), get(|f| f.alpha));
            carried_by(&Field { a: get(|f| f.a), ..field }, body, motion)
        }
    }
}

/// What `body`'s joint has in front of it, where `parent` is its parent's motion.
pub(in crate::equations) fn carried_by<S: Scalar>(
    parent: &Field<S>,
    body: &Body<S>,
    motion: &Motion<S>,
) -> Carried<S> {
    let to_child = |v| body.to_child(motion, v);
    let a = parent.a + parent.over_origin(body.placement.origin());
    let (omega, alpha) = (to_child(parent.omega), to_child(parent.alpha));
    Carried { omega, alpha, a: to_child(a) }
}

/// Whether body `i` is a base that floats in the world. (One with rotors does not fall freely.)
pub(in crate::equations) fn is_base<S: Scalar>(model: &Prepared<S>, i: usize) -> bool {
    let body = &model.bodies[i];
    let floats = body.parent.is_none() && body.primitive == Primitive::Floating;
    floats && model.dofs_of(i).iter().all(|dof| dof.armature.is_none())
}

/// The linear acceleration, as its joint has it, of a floating base `i` in free fall:
/// g - omega x v.
pub(in crate::equations) fn free_fall<S: Scalar>(
    model: &Prepared<S>,
    i: usize,
    qd: &[S],
    workspace: &Workspace<S>,
) -> Vector3<S> {
    let rates = model.rates(i, qd);
    let velocity = Vector3([rates[0], rates[1], rates[2]]);
    let g = model.bodies[i].to_child(&workspace.motions[i], model.gravity);
    g - workspace.fields[i].omega.cross(velocity)
}
