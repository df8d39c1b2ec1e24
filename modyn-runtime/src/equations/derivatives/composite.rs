//! Composite inertias, velocity moments and wrenches: sums over a body and its descendants.

use crate::Scalar;
use crate::equations::Workspace;
use crate::mechanism::BodyTree;
use crate::spatial::{Twist, Vector3, VelocityMoments, Wrench};

/// Computes the angular velocity of each body, and nothing else of its motion.
pub(super) fn angular_velocities<S: Scalar, T: BodyTree<S>>(
    tree: &T,
    qd: &[S],
    workspace: &mut Workspace<S>,
) {
    let model = tree.mechanism();
    for (i, body) in model.bodies.iter().enumerate() {
        let angular =
            body.to_child(&workspace.motions[i], parent_angular_velocity(tree, i, workspace));
        let twist = model.add_rates(i, Twist { angular, ..Twist::zero() }, qd);
        workspace.fields[i].omega = twist.angular;
    }
}

/// Returns the angular velocity of a body's parent; zero for the world.
fn parent_angular_velocity<S: Scalar, T: BodyTree<S>>(
    tree: &T,
    body: usize,
    workspace: &Workspace<S>,
) -> Vector3<S> {
    let omega = |parent: usize| workspace.fields[parent].omega;
    Vector3(tree.broadcast_from_parents(body, |parent| parent.map_or_else(Vector3::zero, omega).0))
}

/// Computes composite inertias, the velocity moments of the composites relative to their bodies,
/// and twice the velocity of each body's origin relative to its parent (`relative_velocities`).
/// Expects angular velocities.
///
/// A rigid body does not move relative to its own frame. Velocity moments therefore arise at the
/// joints of its descendants only.
pub(super) fn accumulate_composites<S: Scalar, T: BodyTree<S>>(
    tree: &T,
    qd: &[S],
    workspace: &mut Workspace<S>,
) {
    let model = tree.mechanism();
    for (composite, body) in workspace.composite.iter_mut().zip(&model.bodies) {
        *composite = body.base_inertia;
    }
    workspace.velocities.fill(VelocityMoments::zero());
    for (i, body) in model.bodies.iter().enumerate().rev() {
        if body.parent.is_none() {
            continue;
        }
        let motion = &workspace.motions[i];
        let rates = model.rates(i, qd);
        let composite = workspace.composite[i];
        tree.rigid_to_parents(i, motion, &composite, |parent, at_parent| {
            workspace.composite[parent] = workspace.composite[parent] + at_parent;
        });
        let own_velocities = &workspace.velocities[i];
        let velocities = body.velocities_to_parent(motion, own_velocities, &composite, &rates);
        tree.to_parents(
            i,
            |sum| velocities.map(sum),
            |parent, at_parent| {
                workspace.velocities[parent] = workspace.velocities[parent] + at_parent;
            },
        );

        let to_parent = |v| body.placement.to_parent(v);
        let mut origin = body.placement.origin();
        if let Some(displacement) = motion.displacement() {
            origin += to_parent(displacement);
        }
        let mut lever = parent_angular_velocity(tree, i, workspace).cross(origin + origin);
        if let Some(drift) = motion.origin_velocity(&rates) {
            lever += to_parent(drift + drift);
        }
        workspace.relative_velocities[i] = lever;
    }
}

/// Sums the bodies' wrenches to the wrenches of composites. `given` returns the force along a
/// degree of freedom if that force is given.
pub(super) fn accumulate_wrenches<S: Scalar, T: BodyTree<S>>(
    tree: &T,
    given: impl Fn(usize) -> Option<S>,
    workspace: &mut Workspace<S>,
) {
    let model = tree.mechanism();
    for (i, body) in model.bodies.iter().enumerate().rev() {
        let mut components = workspace.wrenches[i].components();
        for d in body.dofs.clone() {
            let force = &mut components[model.dofs[d].component];
            *force = given(d).unwrap_or(*force);
        }
        workspace.wrenches[i] = Wrench::from_components(components);
        let wrench = workspace.wrenches[i];
        tree.wrench_to_parents(i, &workspace.motions[i], wrench, |parent, at_parent| {
            workspace.wrenches[parent] += at_parent;
        });
    }
}
