//! What composites are made of: inertia, moments of velocities, wrenches.

use crate::Scalar;
use crate::equations::Workspace;
use crate::mechanism::{Body, Prepared};
use crate::spatial::{Twist, Vector3, VelocityMoments, Wrench};

/// Fills in the bodies' angular velocities alone.
pub(super) fn angular_velocities<S: Scalar>(
    model: &Prepared<S>,
    qd: &[S],
    workspace: &mut Workspace<S>,
) {
    for (i, body) in model.bodies.iter().enumerate() {
        let angular = body.to_child(&workspace.motions[i], parents_turn(body, workspace));
        let twist = model.add_rates(i, Twist { angular, ..Twist::zero() }, qd);
        workspace.fields[i].omega = twist.angular;
    }
}

/// The angular velocity of what a body hangs on.
fn parents_turn<S: Scalar>(body: &Body<S>, workspace: &Workspace<S>) -> Vector3<S> {
    let of = |parent: usize| workspace.fields[parent].omega;
    Vector3(body.from_parents(|parent| parent.map_or_else(Vector3::zero, of).0))
}

/// Gathers the bodies' inertias to composites, and how these move against the composites' bodies;
/// and how fast the bodies' origins move over their parents'. Expects angular velocities.
///
/// A body that is rigid with its frame contributes no velocity: joints do, one after the other.
pub(super) fn gather<S: Scalar>(model: &Prepared<S>, qd: &[S], workspace: &mut Workspace<S>) {
    for (composite, body) in workspace.composite.iter_mut().zip(&model.bodies) {
        *composite = body.minimal;
    }
    workspace.velocities.fill(VelocityMoments::zero());
    for (i, body) in model.bodies.iter().enumerate().rev() {
        if body.parent.is_none() {
            continue;
        }
        let (motion, rates) = (&workspace.motions[i], model.rates(i, qd));
        let composite = workspace.composite[i];
        body.rigid_to_parents(motion, &composite, |parent, carried| {
            workspace.composite[parent] = workspace.composite[parent] + carried;
        });
        let velocities = &workspace.velocities[i];
        let velocities = body.velocities_to_parent(motion, velocities, &composite, &rates);
        body.to_parents(
            |sum| velocities.map(sum),
            |parent, carried| {
                workspace.velocities[parent] = workspace.velocities[parent] + carried;
            },
        );

        let to_parent = |v| body.placement.to_parent(v);
        let mut origin = body.placement.origin();
        if let Some(displacement) = motion.displacement() {
            origin += to_parent(displacement);
        }
        let mut lever = parents_turn(body, workspace).cross(origin + origin);
        if let Some(drift) = motion.drift(&rates) {
            lever += to_parent(drift + drift);
        }
        workspace.levers[i] = lever;
    }
}

/// Gathers the bodies' own wrenches to those of composites. `known` is what is known anyway of what
/// a degree of freedom feels.
pub(super) fn gather_wrenches<S: Scalar>(
    model: &Prepared<S>,
    known: impl Fn(usize) -> Option<S>,
    workspace: &mut Workspace<S>,
) {
    for (i, body) in model.bodies.iter().enumerate().rev() {
        let mut felt = workspace.wrenches[i].components();
        for d in body.dofs.clone() {
            let felt = &mut felt[model.dofs[d].component];
            *felt = known(d).unwrap_or(*felt);
        }
        workspace.wrenches[i] = Wrench::from_components(felt);
        let wrench = workspace.wrenches[i];
        body.wrench_to_parents(&workspace.motions[i], wrench, |parent, carried| {
            workspace.wrenches[parent] += carried;
        });
    }
}
