//! Derivatives of forward dynamics.

use super::composite::{accumulate_composites, accumulate_wrenches, angular_velocities};
use super::inverse::{add_dissipation, add_passive};
use super::perturbation::{perturbations_by_coordinates, perturbations_by_rates};
use super::projection::{Variable, project};
use crate::Scalar;
use crate::equations::dynamics::newton_euler::{Accelerations, free_fall, is_base, link_wrenches};
use crate::equations::factorization::limb_coupling::{LimbAccess, sum_row};
use crate::equations::factorization::{
    FactorLayout, Factorizable, factorize_matrix, inverse, solve, solve_column,
};
use crate::equations::{ForwardInput, Workspace};
use crate::mechanism::{BodyTree, Mechanism};
use crate::spatial::{SpatialAxis, Vector3};

/// The results of [`forward_dynamics_derivatives`]. Matrices are nv x nv, stored by columns.
#[derive(Debug)]
pub struct ForwardDerivatives<'a, S> {
    /// The joint accelerations.
    pub qdd: &'a mut [S],
    /// The derivatives of the accelerations with respect to q, in the tangent space.
    pub dqdd_dq: &'a mut [S],
    /// The derivatives of the accelerations with respect to qd.
    pub dqdd_dqd: &'a mut [S],
    /// The derivatives of the accelerations with respect to tau: the inverse of the mass matrix,
    /// exactly symmetric.
    pub dqdd_dtau: &'a mut [S],
}

/// Computes the joint accelerations under the joint forces `tau`, and their derivatives with
/// respect to q, qd and tau.
///
/// The derivatives are the derivatives of inverse dynamics at these accelerations, multiplied by
/// -M^-1 (Carpentier and Mansard 2018). Products with M^-1 use the factors of the mass matrix.
///
/// d tau / d qd does not depend on the accelerations. The velocity-dependent forces are quadratic
/// in qd, so they are half of (d tau / d qd) qd by Euler's theorem. No pass without accelerations
/// is needed.
///
/// The accelerations of a floating base's origin are relative to free fall, whose derivatives are
/// known. The position and the linear velocity of the base then have no other effect.
pub fn forward_dynamics_derivatives<S: Scalar, T: Factorizable<S>>(
    tree: &T,
    limbs: &T::Layout,
    ForwardInput { q, qd, tau }: ForwardInput<'_, S>,
    workspace: &mut Workspace<S>,
    mut outputs: ForwardDerivatives<'_, S>,
) {
    forward_dynamics_factors(tree, limbs, ForwardInput { q, qd, tau }, workspace, &mut outputs);
    let ForwardDerivatives { qdd, dqdd_dq, dqdd_dqd, dqdd_dtau } = outputs;
    let model = tree.mechanism();
    for columns in [&mut *dqdd_dq, &mut *dqdd_dqd] {
        for (j, column) in columns.chunks_mut(model.nv.max(1)).enumerate() {
            match tree.column_lanes() {
                1 => solve_column(limbs, &workspace.factors, j, column),
                lanes => multiply(tree, dqdd_dtau, lanes, column),
            }
        }
    }
    add_free_fall(tree, qd, workspace, qdd, dqdd_dq, dqdd_dqd);
}

/// Computes the accelerations and the inverse of the mass matrix as
/// [`forward_dynamics_derivatives`] does, and instead of the derivatives by q and qd the matrices
/// that M^-1 multiplies: minus the derivatives of inverse dynamics. A floating base's accelerations
/// are relative to free fall, which [`add_free_fall`] adds.
pub fn forward_dynamics_factors<S: Scalar, T: Factorizable<S>>(
    tree: &T,
    limbs: &T::Layout,
    ForwardInput { q, qd, tau }: ForwardInput<'_, S>,
    workspace: &mut Workspace<S>,
    outputs: &mut ForwardDerivatives<'_, S>,
) {
    let ForwardDerivatives { qdd, dqdd_dq, dqdd_dqd, dqdd_dtau } = outputs;
    let model = tree.mechanism();
    let layout = limbs.layout();
    let n = model.nv;
    workspace.reserve(layout.pivots(), n * n, layout.size());
    workspace.move_with_forces(tree, q, Some(qd));
    angular_velocities(tree, qd, workspace);
    accumulate_composites(tree, qd, workspace);
    perturbations_by_rates(tree, qd, true, workspace);
    let mut matrix = core::mem::take(&mut workspace.matrix);
    let mut factors = core::mem::take(&mut workspace.factors);
    project(tree, Variable::Rates, workspace, dqdd_dqd, Some(&mut matrix[..n * n]));

    qdd.copy_from_slice(tau);
    subtract_forces(tree, limbs, qd, dqdd_dqd, workspace, qdd);
    factorize_matrix(limbs, &mut matrix, &mut workspace.pivots, &mut factors);
    solve(limbs, &factors, qdd);

    link_wrenches(tree, qd, Accelerations::AgainstFall(qdd), workspace);
    let passive = core::mem::take(&mut workspace.passive);
    let given = |d: usize| generalized_force(model, d, passive[d], qd, qdd, tau);
    accumulate_wrenches(tree, given, workspace);
    workspace.passive = passive;
    perturbations_by_coordinates(tree, qd, true, workspace);
    project(tree, Variable::Coordinates, workspace, dqdd_dq, None);
    add_passive(model, q, workspace, dqdd_dq);
    add_dissipation(model, qd, dqdd_dqd);
    inverse(limbs, &factors, dqdd_dtau);
    for columns in [&mut *dqdd_dq, &mut *dqdd_dqd] {
        columns.iter_mut().for_each(|entry| *entry = -*entry);
    }
    (workspace.matrix, workspace.factors) = (matrix, factors);
}

/// Replaces `x` by the product of a matrix, stored by columns, and `x`. Computes `lanes` rows at a
/// time.
fn multiply<S: Scalar, T: BodyTree<S>>(tree: &T, columns: &[S], lanes: usize, x: &mut [S]) {
    let n = x.len();
    let factors = x.to_vec();
    for (k, rows) in x.chunks_mut(lanes).enumerate() {
        let packs = columns.chunks(n).map(|column| tree.pack(&column[k * lanes..][..rows.len()]));
        let products = packs.zip(&factors).map(|(column, &factor)| column * factor);
        let sum = products.reduce(|sum, product| sum + product).expect("as many columns as rows");
        for (row, x) in rows.iter_mut().enumerate() {
            *x = tree.extract_lane(sum, row);
        }
    }
}

/// Subtracts velocity-dependent forces, gravity, springs and dissipation from `tau`; a floating
/// base is in free fall. `dtau_dqd` excludes dissipation.
fn subtract_forces<S: Scalar, T: BodyTree<S>>(
    tree: &T,
    limbs: &impl FactorLayout<S>,
    qd: &[S],
    dtau_dqd: &[S],
    workspace: &mut Workspace<S>,
    tau: &mut [S],
) {
    let model = tree.mechanism();
    let half = S::from_f64(0.5);
    for (row, tau) in tau.iter_mut().enumerate() {
        let columns = dtau_dqd.chunks(model.nv.max(1));
        let twice = columns.zip(qd).map(|(column, &rate)| column[row] * rate);
        if let Some(twice) = sum_row(limbs, row, twice) {
            *tau = *tau - half * twice;
        }
    }
    for (i, body) in model.bodies.iter().enumerate() {
        let in_parent = Vector3(tree.broadcast_from_parents(i, |parent| match parent {
            Some(parent) => workspace.twists[parent].linear.0,
            None if is_base(model, i) => Vector3::zero().0,
            None => (-model.gravity).0,
        }));
        let a = body.to_child(&workspace.motions[i], in_parent);
        workspace.twists[i].linear = a;
        for d in body.dofs.clone() {
            let dof = &model.dofs[d];
            let weight = workspace.composite[i].column(dof.component).force.dot(a);
            dof.add(-weight, tau);
            if let Some(dissipation) = model.dissipation(dof, qd) {
                dof.add(-dissipation, tau);
            }
            if let Some(passive) = workspace.passive[d] {
                dof.add(-passive, tau);
            }
        }
    }
}

/// Returns the force of the composite's wrench along degree of freedom `d`, if `tau` determines it.
fn generalized_force<S: Scalar>(
    model: &Mechanism<S>,
    d: usize,
    passive: Option<S>,
    qd: &[S],
    qdd: &[S],
    tau: &[S],
) -> Option<S> {
    let dof = &model.dofs[d];
    if model.has_mimics() {
        return None;
    }
    let mut force = tau[dof.v];
    if let Some(dissipation) = model.dissipation(dof, qd) {
        force = force - dissipation;
    }
    if let Some(passive) = passive {
        force = force - passive;
    }
    if let Some(armature) = dof.armature {
        force = force - armature * dof.rate(qdd);
    }
    Some(force)
}

/// Adds the free fall g - omega x v of floating bases to their accelerations, and its derivatives.
pub fn add_free_fall<S: Scalar, T: BodyTree<S>>(
    tree: &T,
    qd: &[S],
    workspace: &Workspace<S>,
    qdd: &mut [S],
    dqdd_dq: &mut [S],
    dqdd_dqd: &mut [S],
) {
    let model = tree.mechanism();
    let n = model.nv;
    for i in (0..model.bodies.len()).filter(|&i| is_base(model, i)) {
        let rates = model.rates(i, qd);
        let velocity = Vector3([rates[0], rates[1], rates[2]]);
        let omega = workspace.fields[i].omega;
        let g = model.bodies[i].to_child(&workspace.motions[i], model.gravity);
        let dofs = model.dofs_of(i);
        // The entries of a floating base are contiguous, the linear ones first.
        let linear = dofs[0].v..dofs[0].v + 3;
        let add = |column: usize, columns: &mut [S], change: Vector3<S>| {
            let entries = &mut columns[column * n..][linear.clone()];
            for (entry, change) in entries.iter_mut().zip(change.0) {
                *entry = *entry + change;
            }
        };
        add(0, qdd, free_fall(model, i, qd, workspace));
        for dof in dofs {
            match dof.axis() {
                SpatialAxis::Linear(k) => add(dof.v, dqdd_dqd, -omega.cross(Vector3::unit(k))),
                SpatialAxis::Angular(k) => {
                    let s = Vector3::unit(k);
                    add(dof.v, dqdd_dq, g.cross(s));
                    add(dof.v, dqdd_dqd, -s.cross(velocity));
                }
            }
        }
    }
}
