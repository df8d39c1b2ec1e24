//! What gravity does: torques and potential energy, from composite masses and first moments.

use crate::Scalar;
use crate::equations::Workspace;
use crate::mechanism::{Body, Prepared};
use crate::spatial::{RigidInertia, Vector3, Wrench};

/// The joint torques that hold the robot still: bias forces at zero velocity.
pub fn gravity_torques<S: Scalar>(
    model: &Prepared<S>,
    q: &[S],
    workspace: &mut Workspace<S>,
    tau: &mut [S],
) {
    workspace.move_to(model, q);
    // Downwards: the world's acceleration in each link's axes; upwards: composite first moments.
    for (i, body) in model.bodies.iter().enumerate() {
        let of = |p: Option<usize>| p.map_or(-model.gravity, |p| workspace.twists[p].linear);
        let a = Vector3(body.from_parents(|p| of(p).0));
        workspace.twists[i].linear = body.to_child(&workspace.motions[i], a);
    }
    gather(model, workspace, |body| body.minimal);
    tau.fill(S::zero());
    for i in 0..model.bodies.len() {
        let (composite, a) = (&workspace.composite[i], workspace.twists[i].linear);
        let wrench =
            Wrench { moment: composite.first_moment.cross(a), force: a.scale(composite.mass) };
        for dof in model.dofs_of(i) {
            dof.add(wrench.components()[dof.component], tau);
        }
    }
}

/// The potential energy of the moving links under gravity, zero at the world's origin.
///
/// Read from the inertias as they were written: mass on the first axis adds a constant here.
pub fn potential_energy<S: Scalar>(
    model: &Prepared<S>,
    q: &[S],
    workspace: &mut Workspace<S>,
) -> S {
    workspace.move_to(model, q);
    -model.gravity.dot(first_moment(model, workspace, |body| body.inertia))
}

/// The first moment of mass in the world. Expects the joints at q.
pub(in crate::equations) fn first_moment<S: Scalar>(
    model: &Prepared<S>,
    workspace: &mut Workspace<S>,
    inertia: impl Fn(&Body<S>) -> RigidInertia<S>,
) -> Vector3<S> {
    gather(model, workspace, inertia);
    let mut first_moment = Vector3::zero();
    for (i, body) in model.bodies.iter().enumerate() {
        if body.parent.is_none() {
            let own = workspace.composite[i];
            let motion = &workspace.motions[i];
            first_moment += body.mass_to_parent(motion, own.mass, own.first_moment).1;
        }
    }
    first_moment
}

/// Sums masses and first moments towards the root.
pub(in crate::equations) fn gather<S: Scalar>(
    model: &Prepared<S>,
    workspace: &mut Workspace<S>,
    inertia: impl Fn(&Body<S>) -> RigidInertia<S>,
) {
    for (composite, body) in workspace.composite.iter_mut().zip(&model.bodies) {
        *composite = inertia(body);
    }
    for (i, body) in model.bodies.iter().enumerate().rev() {
        let (own, motion) = (workspace.composite[i], &workspace.motions[i]);
        body.mass_to_parents(motion, own.mass, own.first_moment, |parent, (mass, moment)| {
            let composite = &mut workspace.composite[parent];
            composite.mass = composite.mass + mass;
            composite.first_moment += moment;
        });
    }
}
