//! The Coriolis matrix.

use super::composite::{accumulate_composites, angular_velocities};
use super::perturbation::perturbations_by_rates;
use super::projection::{Variable, project};
use crate::Scalar;
use crate::equations::{State, Workspace};
use crate::mechanism::Mechanism;
use crate::spatial::{SpatialAxis, Vector3};

/// Computes the Coriolis matrix C(q, qd), nv x nv, by columns. C qd are the Coriolis and
/// centrifugal forces, and dM/dt - 2 C is skew with the mass matrix M. Gravity, damping and
/// friction are not included.
///
/// C is the matrix of Christoffel's symbols in the velocities of the joints. The forces C qd are
/// quadratic in qd, so half of their derivative with respect to qd is the part of C that is
/// symmetric in the two velocities. The rest is half of M times the Lie brackets of the joints'
/// velocities. They are zero for joints with an axis; for spherical and floating joints they are
/// cross products (Marsden and Ratiu 1999, "Introduction to Mechanics and Symmetry").
pub fn coriolis_matrix<S: Scalar>(
    model: &Mechanism<S>,
    State { q, qd }: State<'_, S>,
    workspace: &mut Workspace<S>,
    columns: &mut [S],
) {
    let n = model.nv;
    workspace.reserve(0, n * n, 0);
    workspace.move_to(model, q);
    angular_velocities(model, qd, workspace);
    accumulate_composites(model, qd, workspace);
    perturbations_by_rates(model, qd, false, workspace);
    let mut mass_matrix = core::mem::take(&mut workspace.matrix);
    project(model, Variable::Rates, workspace, columns, Some(&mut mass_matrix[..n * n]));
    for i in 0..model.bodies.len() {
        add_brackets(model, i, qd, &mass_matrix, columns);
    }
    workspace.matrix = mass_matrix;
    let half = S::from_f64(0.5);
    columns.iter_mut().for_each(|entry| *entry = half * *entry);
    model.armature_coriolis(qd, |row, column, entry| {
        let sum = &mut columns[model.dofs[column].v * n + model.dofs[row].v];
        *sum = *sum + entry;
    });
}

/// Adds the mass matrix times the Lie brackets of the velocity of body `i`'s joint and the joint's
/// unit velocities. Rotors are left out: they have Coriolis forces at floating joints alone, where
/// their part is `armature_coriolis`.
fn add_brackets<S: Scalar>(
    model: &Mechanism<S>,
    i: usize,
    qd: &[S],
    mass_matrix: &[S],
    columns: &mut [S],
) {
    if model.bodies[i].elementary_joint.has_axis() {
        return;
    }
    let dofs = model.dofs_of(i);
    let n = model.nv;
    let mut angular = Vector3::zero();
    let mut linear = Vector3::zero();
    for dof in dofs {
        match dof.axis() {
            SpatialAxis::Linear(k) => linear.0[k] = dof.rate(qd),
            SpatialAxis::Angular(k) => angular.0[k] = dof.rate(qd),
        }
    }
    for column in dofs {
        // [(w, v), (s, t)] = (w x s, w x t + v x s)
        let (rotated, moved) = match column.axis() {
            SpatialAxis::Linear(k) => (Vector3::zero(), angular.cross(Vector3::unit(k))),
            SpatialAxis::Angular(k) => {
                let s = Vector3::unit(k);
                (angular.cross(s), linear.cross(s))
            }
        };
        for dof in dofs {
            let bracket = match dof.axis() {
                SpatialAxis::Linear(k) => moved.0[k],
                SpatialAxis::Angular(k) => rotated.0[k],
            };
            for row in 0..n {
                let mut mass = mass_matrix[dof.v * n + row];
                if let Some(armature) = dof.armature.filter(|_| row == dof.v) {
                    mass = mass - armature;
                }
                let sum = &mut columns[column.v * n + row];
                *sum = *sum + mass * bracket;
            }
        }
    }
}
