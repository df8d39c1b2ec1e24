//! Forward dynamics by inter- and intra-modular recursion, (60) and Table 6.
//!
//! A Newton-Euler pass first gives the wrenches of the present velocities under gravity with all
//! joints unaccelerated; the recursion then works on the deviations from that motion, so no
//! velocity occurs in it. Any partition into modules gives the same result: one link a module is
//! Table 6 itself (and Featherstone's articulated-body algorithm), one module a serial chain is
//! composite inertia and elimination.

use super::elimination::{
    eliminate, factor, freed, pivot, reduce_columns, solve_lower, solve_upper, split, start,
};
use super::newton_euler::link_wrenches;
use super::partition::Block;
use super::{Partition, Workspace};
use crate::Scalar;
use crate::model::prepare::Prepared;
use crate::spatial::{Twist, Wrench};

/// qdd = I(q)^-1 (tau - h(q, qd)).
pub fn forward_dynamics<S: Scalar>(
    model: &Prepared<S>,
    partition: &Partition,
    (q, qd, tau): (&[S], &[S], &[S]),
    workspace: &mut Workspace<S>,
    qdd: &mut [S],
) {
    workspace.move_to(model, q);
    link_wrenches(model, qd, None, workspace);
    start(model, workspace);
    for block in partition.blocks.iter().rev() {
        // phi_hat = U^-1 phi and phi_tilde = D^-1 phi_hat, steps (i) and (ii) of (60).
        let first = block.links.start;
        for i in block.links.clone().rev() {
            let wrench = workspace.wrenches[i];
            workspace.torques[i] = tau[i] - workspace.motions[i].project(&wrench);
            if i > first {
                let carried = model.bodies[i].wrench_to_parent(&workspace.motions[i], wrench);
                workspace.wrenches[i - 1] += carried;
            }
        }
        pivot(model, block, workspace);
        split(block, workspace);
        let torques = &mut workspace.torques[block.links.clone()];
        solve_upper(factor(block, &workspace.pivots), torques);
        if let Some(parent) = model.bodies[first].parent {
            reduce_columns(block, workspace);
            eliminate(model, block, workspace);
            let left = wrench_left(block, workspace, tau[first]);
            let carried = model.bodies[first].wrench_to_parent(&workspace.motions[first], left);
            workspace.wrenches[parent] += carried;
        }
        for i in block.links.clone() {
            workspace.torques[i] = workspace.torques[i] * workspace.reciprocals[i];
        }
    }
    for block in &partition.blocks {
        // qdd = U^-T phi_tilde, step (iii).
        let first = block.links.start;
        let carried = model.bodies[first].parent.map(|parent| {
            model.bodies[first].twist_to_child(&workspace.motions[first], workspace.twists[parent])
        });
        let freed = freed(block, workspace);
        for i in block.links.clone() {
            qdd[i] = workspace.torques[i];
            if let Some(carried) = &carried {
                let felt = (0..6)
                    .filter(|&row| row != freed)
                    .map(|row| workspace.gains[row][i] * carried.components()[row])
                    .reduce(|sum, x| sum + x);
                qdd[i] = felt.map_or(qdd[i], |felt| qdd[i] - felt);
            }
        }
        solve_lower(factor(block, &workspace.pivots), &mut qdd[block.links.clone()]);
        // So far the first joint's figure holds what its module is carried along with.
        let mut components = carried.unwrap_or_else(Twist::zero).components();
        let along = core::mem::replace(&mut components[freed], qdd[first]);
        if carried.is_some() {
            qdd[first] = qdd[first] - along;
        }
        workspace.twists[first] = Twist::from_components(components);
        if block.has_children {
            for i in block.links.clone().skip(1) {
                let motion = &workspace.motions[i];
                let carried = model.bodies[i].twist_to_child(motion, workspace.twists[i - 1]);
                workspace.twists[i] = motion.add_rate(carried, qdd[i]);
            }
        }
    }
}

/// What the module's first joint passes on: the wrench of the unaccelerated motion and the
/// elimination's share of the torques; along the joint itself just the joint's torque.
fn wrench_left<S: Scalar>(block: &Block, workspace: &Workspace<S>, torque: S) -> Wrench<S> {
    let freed = freed(block, workspace);
    let mut left = workspace.wrenches[block.links.start].components();
    for (row, entry) in left.iter_mut().enumerate() {
        if row == freed {
            *entry = torque;
            continue;
        }
        let shares = block.links.clone().map(|i| workspace.gains[row][i] * workspace.torques[i]);
        if let Some(share) = shares.reduce(|sum, x| sum + x) {
            *entry = *entry + share;
        }
    }
    Wrench::from_components(left)
}
