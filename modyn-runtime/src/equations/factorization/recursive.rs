//! The block reverse Gaussian elimination of one module, (35)-(49).
//!
//! Inside a module inertia is accumulated as a rigid composite (10 numbers). From a link with
//! eliminated child modules on, their articulated inertia (21 numbers) is accumulated as well. The
//! module's pivot block is I_hat = N^T Psi, (46), with Psi = M_hat N, (47), plus the rotors'
//! inertia on its diagonal. The block is factorized as V Delta V^T by reverse Gaussian elimination.
//! The module's parent receives Phi M_hat, (48)-(49): M_hat - Psi I_hat^-1 Psi^T.
//!
//! The robot must not have mimic joints: each degree of freedom is an entry of the joint vectors.

use super::blocks::{factor_udu, solve_lower, solve_upper};
use super::layout::UduLayout;
use super::matrix::store_v;
use super::partition::{ModuleBlock, factor};
use crate::Scalar;
use crate::equations::Workspace;
use crate::mechanism::{BodyTree, Mechanism, RootwardAccumulator};
use crate::spatial::{ArticulatedInertia, Wrench};

/// Sets each composite inertia to the body's own inertia, and each articulated inertia to the one
/// that soft constraints add.
pub(in crate::equations) fn start<S: Scalar>(model: &Mechanism<S>, workspace: &mut Workspace<S>) {
    for (composite, body) in workspace.composite.iter_mut().zip(&model.bodies) {
        *composite = body.base_inertia;
    }
    workspace.articulated.copy_from_slice(&workspace.added_inertia);
}

/// Computes the module's pivot block and its columns Psi at the module's first body, and
/// accumulates the inertias of the module's bodies there.
pub(in crate::equations) fn pivot<S: Scalar, T: BodyTree<S>>(
    tree: &T,
    block: &ModuleBlock,
    workspace: &mut Workspace<S>,
) {
    let model = tree.mechanism();
    let start = block.dofs.start;
    let size = block.dofs.len();
    for i in block.bodies.clone().rev() {
        let composite = workspace.composite[i];
        let articulated = workspace.articulated[i];
        let whole = articulated.map(|a| a + composite.articulated());
        for d in model.bodies[i].dofs.clone() {
            let dof = &model.dofs[d];
            let mut wrench = match &whole {
                Some(whole) => whole.column(dof.component),
                None => composite.column(dof.component),
            };
            let j = d - start;
            let mut inertia = wrench.components()[dof.component];
            if let Some(armature) = dof.armature {
                inertia = inertia + armature;
            }
            if let Some(added) = workspace.added_armature[d] {
                inertia = inertia + added;
            }
            workspace.pivots[block.pivot + j * size + j] = inertia;
            let mut at = i;
            for row in (0..j).rev() {
                let other = &model.dofs[start + row];
                while at > other.body {
                    wrench = model.bodies[at].wrench_to_parent(&workspace.motions[at], wrench);
                    at -= 1;
                }
                let force = wrench.components()[other.component];
                workspace.pivots[block.pivot + row * size + j] = force;
                workspace.pivots[block.pivot + j * size + row] = force;
            }
            for (column, component) in workspace.columns.iter_mut().zip(wrench.components()) {
                column[d] = component;
            }
        }
        if i == block.bodies.start {
            continue;
        }
        if let Some(whole) = whole {
            propagate_to_parent(tree, workspace, i, &whole);
        } else {
            let at_parent = model.bodies[i].rigid_to_parent(&workspace.motions[i], &composite);
            workspace.composite[i - 1] = workspace.composite[i - 1] + at_parent;
        }
    }
}

/// Factorizes the module's pivot block as V Delta V^T in place.
pub(in crate::equations) fn split<S: Scalar>(block: &ModuleBlock, workspace: &mut Workspace<S>) {
    let size = block.dofs.len();
    let v = &mut workspace.pivots[block.pivot..block.pivot + size * size];
    factor_udu(v, size, &mut workspace.reciprocals[block.dofs.clone()]);
}

/// Returns the motion subspace of the module's first joint: for each component of the twist, the
/// degree of freedom that moves along it. The joint transmits no force along its motion subspace to
/// the parent. (A joint with rotor inertia or a soft constraint does, so its components are left
/// out.)
pub(in crate::equations) fn motion_subspace<S: Scalar>(
    model: &Mechanism<S>,
    block: &ModuleBlock,
    workspace: &Workspace<S>,
) -> [Option<usize>; 6] {
    let mut subspace = [None; 6];
    for d in model.bodies[block.bodies.start].dofs.clone() {
        if model.dofs[d].armature.is_none() && workspace.added_armature[d].is_none() {
            subspace[model.dofs[d].component] = Some(d);
        }
    }
    subspace
}

/// Replaces the columns Psi by V^-1 Psi^T, and computes `scaled_psi` = Psi V^-T Delta^-1. Both are
/// stored by rows; rows of the motion subspace are skipped. Expects the factorized pivot block.
pub(in crate::equations) fn reduce_columns<S: Scalar>(
    model: &Mechanism<S>,
    block: &ModuleBlock,
    workspace: &mut Workspace<S>,
) {
    let subspace = motion_subspace(model, block, workspace);
    let v = factor(block, &workspace.pivots);
    for row in (0..6).filter(|&row| subspace[row].is_none()) {
        solve_upper(v, &mut workspace.columns[row][block.dofs.clone()]);
        for d in block.dofs.clone() {
            workspace.scaled_psi[row][d] = workspace.columns[row][d] * workspace.reciprocals[d];
        }
    }
}

/// Adds the module's inertia, with its joints eliminated, to the parent link: (48).
pub(in crate::equations) fn eliminate<S: Scalar, T: BodyTree<S>>(
    tree: &T,
    block: &ModuleBlock,
    workspace: &mut Workspace<S>,
) {
    let model = tree.mechanism();
    let first = block.bodies.start;
    let subspace = motion_subspace(model, block, workspace);
    if subspace.iter().all(Option::is_some) {
        return;
    }
    let rigid = workspace.composite[first].articulated();
    let whole = workspace.articulated[first].map_or(rigid, |a| a + rigid);
    let left = ArticulatedInertia::from_fn(|row, column| {
        if subspace[row].is_some() || subspace[column].is_some() {
            return S::zero();
        }
        let taken = block
            .dofs
            .clone()
            .map(|d| workspace.columns[row][d] * workspace.scaled_psi[column][d])
            .reduce(|sum, x| sum + x);
        taken.map_or(whole.entry(row, column), |taken| whole.entry(row, column) - taken)
    });
    propagate_to_parent(tree, workspace, first, &left);
}

/// Adds an articulated inertia at body `i` to the articulated inertia of its parent.
fn propagate_to_parent<S: Scalar, T: BodyTree<S>>(
    tree: &T,
    workspace: &mut Workspace<S>,
    i: usize,
    inertia: &ArticulatedInertia<S>,
) {
    tree.articulated_to_parents(i, &workspace.motions[i], inertia, |parent, at_parent| {
        let sum = workspace.articulated[parent].map_or(at_parent, |a| a + at_parent);
        workspace.articulated[parent] = Some(sum);
    });
}

/// Fills `factors` with D, the factors of its blocks, and U at `q`, by recursion over the tree.
pub(in crate::equations) fn factorize_tree<S: Scalar, T: BodyTree<S>>(
    tree: &T,
    layout: &UduLayout,
    q: &[S],
    workspace: &mut Workspace<S>,
    factors: &mut [S],
) {
    let model = tree.mechanism();
    workspace.reserve(layout.pivots(), 0, 0);
    workspace.move_to(model, q);
    start(model, workspace);
    for (m, block) in layout.blocks().iter().enumerate().rev() {
        let first = block.bodies.start;
        pivot(tree, block, workspace);
        factors[layout.d(m)].copy_from_slice(&workspace.pivots[layout.d(m)]);
        split(block, workspace);
        store_v(layout, m, &workspace.pivots, factors);
        for d in block.dofs.clone() {
            factors[layout.reciprocals().start + d] = workspace.reciprocals[d];
        }
        if model.bodies[first].parent.is_none() {
            continue;
        }
        reduce_columns(model, block, workspace);
        eliminate(tree, block, workspace);
        // (46): the columns of Psi I_hat^-1, transformed towards the root; each joint takes its
        // component.
        finish_gains(model, block, workspace);
        for (j, d) in block.dofs.clone().enumerate() {
            let mut wrench =
                Wrench::from_components(core::array::from_fn(|row| workspace.scaled_psi[row][d]));
            let mut at = first;
            let mut path = RootwardAccumulator::new(tree);
            for (other, row) in layout.rows(m).rev() {
                while at != model.dofs[other].body {
                    let body = &model.bodies[at];
                    let at_parent = body.wrench_to_parent(&workspace.motions[at], wrench);
                    let Some(parent) = body.parent else { break };
                    let at_parent = path.accumulate(at, parent, at_parent.components());
                    wrench = Wrench::from_components(at_parent);
                    at = parent;
                }
                let component = model.dofs[other].component;
                factors[layout.u().start + row + j] = wrench.components()[component];
            }
        }
    }
}

/// Replaces the scaled_psi Psi V^-T Delta^-1 by Psi I_hat^-1, all six rows.
fn finish_gains<S: Scalar>(
    model: &Mechanism<S>,
    block: &ModuleBlock,
    workspace: &mut Workspace<S>,
) {
    let subspace = motion_subspace(model, block, workspace);
    for (row, free) in subspace.into_iter().enumerate() {
        let scaled_psi = &mut workspace.scaled_psi[row][block.dofs.clone()];
        if let Some(d) = free {
            // Psi's row along a component of the motion subspace is a row of I_hat itself.
            scaled_psi.fill(S::zero());
            scaled_psi[d - block.dofs.start] = S::one();
        } else {
            solve_lower(factor(block, &workspace.pivots), scaled_psi);
        }
    }
}
