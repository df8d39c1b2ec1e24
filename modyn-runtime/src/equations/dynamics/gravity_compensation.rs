//! The joint forces of gravity compensation, and their derivatives.
//!
//! Compensated masses are pushed up by their weight. The joint forces that hold them are minus the
//! gravity torques of these masses, so they are the gradient of a potential energy. Its second
//! derivatives by displacements of different joints are symmetric.

use crate::Scalar;
use crate::equations::Workspace;
use crate::equations::kinematics::first_moment::accumulate_masses;
use crate::mechanism::{BodyTree, Mechanism};
use crate::spatial::{RigidInertia, SpatialAxis, Vector3, Wrench};

/// Computes gravity in the axes of each body (the linear part of `twists`), and the compensated
/// composites (`composite`). Expects the joint transforms at q.
fn accumulate<S: Scalar, T: BodyTree<S>>(tree: &T, workspace: &mut Workspace<S>) {
    let model = tree.mechanism();
    for (i, body) in model.bodies.iter().enumerate() {
        let gravity_in =
            |parent: Option<usize>| parent.map_or(model.gravity, |p| workspace.twists[p].linear);
        let g = Vector3(tree.broadcast_from_parents(i, |parent| gravity_in(parent).0));
        workspace.twists[i].linear = body.to_child(&workspace.motions[i], g);
    }
    accumulate_masses(tree, workspace, |body| body.compensated_inertia());
}

/// Calls `add` for the joint force that each degree of freedom needs against the compensation.
/// Expects the joint transforms at q.
pub(in crate::equations) fn compensation_forces<S: Scalar, T: BodyTree<S>>(
    tree: &T,
    workspace: &mut Workspace<S>,
) {
    let model = tree.mechanism();
    if !model.compensates_gravity() {
        return;
    }
    accumulate(tree, workspace);
    for (d, dof) in model.dofs.iter().enumerate() {
        let composite = &workspace.composite[dof.body];
        let g = workspace.twists[dof.body].linear;
        let force = weight(composite, g).components()[dof.component];
        let passive = &mut workspace.passive[d];
        *passive = Some(passive.map_or(force, |passive| passive + force));
    }
}

/// Adds the derivatives of the [`compensation_forces`] to the derivatives of the joint forces with
/// respect to the coordinates, an nv x nv matrix by columns. Expects the joint transforms at q.
pub(in crate::equations) fn add_compensation_derivatives<S: Scalar>(
    model: &Mechanism<S>,
    workspace: &mut Workspace<S>,
    columns: &mut [S],
) {
    if !model.compensates_gravity() {
        return;
    }
    accumulate(model, workspace);
    let mut add = |row: usize, column: usize, entry: S| {
        let row = &model.dofs[row];
        let column = &model.dofs[column];
        let sum = &mut columns[column.v * model.nv + row.v];
        *sum = *sum + row.scale(column.scale(entry));
    };
    for (d, dof) in model.dofs.iter().enumerate() {
        let composite = workspace.composite[dof.body];
        let g = workspace.twists[dof.body].linear;
        // The change of the composite's weight by the displacement, in the axes before it and about
        // the origin before it; then in the axes of the body, about its origin.
        let (mut change, own_change) = match dof.axis() {
            SpatialAxis::Linear(k) => {
                let moment = Vector3::unit(k).scale(composite.mass).cross(g);
                (Wrench { moment, force: Vector3::zero() }, Wrench::zero())
            }
            SpatialAxis::Angular(k) => {
                let s = Vector3::unit(k);
                let moment = s.cross(composite.first_moment).cross(g);
                (Wrench { moment, force: Vector3::zero() }, weight(&composite, g.cross(s)))
            }
        };
        for row in model.bodies[dof.body].dofs.clone() {
            add(row, d, own_change.components()[model.dofs[row].component]);
        }
        let mut at = dof.body;
        while let Some(parent) = model.bodies[at].parent {
            change = model.bodies[at].wrench_to_parent(&workspace.motions[at], change);
            for row in model.bodies[parent].dofs.clone() {
                let entry = change.components()[model.dofs[row].component];
                add(row, d, entry);
                add(d, row, entry);
            }
            at = parent;
        }
    }
}

/// Returns the wrench that gives a composite the acceleration `a` in uniform translation.
fn weight<S: Scalar>(composite: &RigidInertia<S>, a: Vector3<S>) -> Wrench<S> {
    Wrench { moment: composite.first_moment.cross(a), force: a.scale(composite.mass) }
}
