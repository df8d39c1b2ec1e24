//! The centre of mass of the moving links.

use super::first_moment::{accumulate_masses, first_moment};
use super::kinematic_path;
use crate::Scalar;
use crate::equations::Workspace;
use crate::mechanism::Mechanism;
use crate::spatial::{RigidInertia, SpatialAxis, Vector3};

/// Returns the mass of the moving links, kg.
pub fn total_mass<S: Scalar>(model: &Mechanism<S>) -> S {
    model.bodies.iter().fold(S::zero(), |sum, body| sum + body.inertia.mass)
}

/// Returns the centre of mass of the moving links in world axes, m. It is NaN if their mass is
/// zero.
pub fn center_of_mass<S: Scalar>(
    model: &Mechanism<S>,
    q: &[S],
    workspace: &mut Workspace<S>,
) -> Vector3<S> {
    workspace.move_to(model, q);
    at_joints(model, workspace)
}

/// Returns the centre of mass in world axes, m. Expects the joint transforms at q.
pub(in crate::equations) fn at_joints<S: Scalar>(
    model: &Mechanism<S>,
    workspace: &mut Workspace<S>,
) -> Vector3<S> {
    let share = total_mass(model).recip();
    let moving = first_moment(model, workspace, |body| shared(&body.base_inertia, share));
    moving + model.static_inertia.first_moment.scale(share)
}

/// Computes the Jacobian of the centre of mass, world axes, into `columns`, one for each entry of
/// qd. A column is the linear momentum of a unit rate divided by the total mass.
pub fn center_of_mass_jacobian<S: Scalar>(
    model: &Mechanism<S>,
    q: &[S],
    workspace: &mut Workspace<S>,
    columns: &mut [Vector3<S>],
) {
    workspace.move_to(model, q);
    let share = total_mass(model).recip();
    accumulate_masses(model, workspace, |body| shared(&body.base_inertia, share));
    columns.fill(Vector3::zero());
    for (i, body) in model.bodies.iter().enumerate() {
        kinematic_path::rotate_axes(model, i, workspace);
        let axes = kinematic_path::joint_axes(model, i, workspace);
        let RigidInertia { mass, first_moment, .. } = workspace.composite[i];
        let first_moment = if body.elementary_joint.has_axis() {
            workspace.motions[i].to_parent(first_moment)
        } else {
            first_moment
        };
        for dof in model.dofs_of(i) {
            let along = match dof.axis() {
                SpatialAxis::Linear(k) => axes.column(k).scale(mass),
                SpatialAxis::Angular(k) => axes.mul_vector(Vector3::unit(k).cross(first_moment)),
            };
            columns[dof.v] += dof.multiplier.map_or(along, |multiplier| along.scale(multiplier));
        }
    }
}

/// Returns mass and first moment divided by the total mass. Where inertias are constants, the
/// compiler folds the division.
fn shared<S: Scalar>(inertia: &RigidInertia<S>, share: S) -> RigidInertia<S> {
    RigidInertia {
        mass: inertia.mass * share,
        first_moment: inertia.first_moment.scale(share),
        ..*inertia
    }
}
