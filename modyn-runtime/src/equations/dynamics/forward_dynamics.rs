//! Forward dynamics by inter- and intra-modular recursion, (60) and Table 6.
//!
//! A Newton-Euler pass first gives the wrenches of the present velocities under gravity with all
//! joints unaccelerated (a floating base in free fall); the recursion then works on the deviations
//! from that motion, so no velocity occurs in it. Any partition into modules gives the same result:
//! one link a module is Table 6 itself (and Featherstone's articulated-body algorithm), one module
//! a serial chain is composite inertia and elimination.
//!
//! Joints that mimic others couple links across the tree, so a robot that has some is solved
//! through the factors of its GIM ([`brge`]).

use super::newton_euler::{Accelerations, free_fall, is_base, link_wrenches};
use super::{Forces, inverse_dynamics};
use crate::Scalar;
use crate::equations::Workspace;
use crate::equations::factorization::brge::{self, Layout};
use crate::equations::factorization::elimination::{
    eliminate, factor, freed, pivot, reduce_columns, solve_lower, solve_upper, split, start,
};
use crate::equations::factorization::partition::{Block, Partition};
use crate::mechanism::Prepared;
use crate::model::ModuleTree;
use crate::spatial::{Twist, Wrench};

/// By which way, and which modules, accelerations are solved for.
#[derive(Clone, Debug)]
pub enum Elimination {
    /// Recursively, by these modules.
    Recursive(Partition),
    /// Through the factors of the GIM, for joints that mimic others.
    Matrix(Layout),
}

impl Elimination {
    /// The way that a model needs, by modules that fit it.
    #[must_use]
    pub fn new<S: Scalar>(model: &Prepared<S>, modules: &ModuleTree) -> Self {
        if model.has_mimics() {
            Self::Matrix(Layout::new(model, modules))
        } else {
            Self::Recursive(Partition::new(model, modules))
        }
    }

    /// Makes room for it.
    pub fn make_room<S: Scalar>(&self, model: &Prepared<S>, workspace: &mut Workspace<S>) {
        match self {
            Self::Recursive(partition) => workspace.make_room(partition.pivots, 0, 0),
            Self::Matrix(layout) => {
                workspace.make_room(layout.pivots(), model.nv * model.nv, layout.size());
            }
        }
    }
}

/// qdd = I(q)^-1 (tau - h(q, qd) + the external `forces`' share).
pub fn forward_dynamics<S: Scalar>(
    model: &Prepared<S>,
    elimination: &Elimination,
    (q, qd, tau): (&[S], &[S], &[S]),
    forces: Option<Forces<'_, S>>,
    workspace: &mut Workspace<S>,
    qdd: &mut [S],
) {
    elimination.make_room(model, workspace);
    match elimination {
        Elimination::Recursive(partition) => {
            recursive(model, partition, (q, qd, tau), forces, workspace, qdd);
        }
        Elimination::Matrix(layout) => {
            inverse_dynamics(model, (q, qd, None), forces, workspace, qdd);
            for (qdd, &tau) in qdd.iter_mut().zip(tau) {
                *qdd = tau - *qdd;
            }
            let mut factors = core::mem::take(&mut workspace.factors);
            brge::factorize(model, layout, q, workspace, &mut factors);
            brge::solve(layout, &factors, qdd);
            workspace.factors = factors;
        }
    }
}

fn recursive<S: Scalar>(
    model: &Prepared<S>,
    partition: &Partition,
    (q, qd, tau): (&[S], &[S], &[S]),
    forces: Option<Forces<'_, S>>,
    workspace: &mut Workspace<S>,
    qdd: &mut [S],
) {
    workspace.move_to(model, q);
    link_wrenches(model, qd, Accelerations::FreeFall, workspace);
    if let Some(forces) = forces {
        forces.subtract(model, workspace);
    }
    start(model, workspace);
    // What acts along each joint, resistance taken off.
    let torque = |d: usize| {
        let dof = &model.dofs[d];
        model.resistance(dof, qd).map_or(tau[dof.v], |resistance| tau[dof.v] - resistance)
    };
    for block in partition.blocks.iter().rev() {
        // phi_hat = U^-1 phi and phi_tilde = D^-1 phi_hat, steps (i) and (ii) of (60).
        let first = block.bodies.start;
        for i in block.bodies.clone().rev() {
            let wrench = workspace.wrenches[i];
            for d in model.bodies[i].dofs.clone() {
                let felt = wrench.components()[model.dofs[d].component];
                workspace.torques[d] = torque(d) - felt;
            }
            if i > first {
                let carried = model.bodies[i].wrench_to_parent(&workspace.motions[i], wrench);
                workspace.wrenches[i - 1] += carried;
            }
        }
        pivot(model, block, workspace);
        split(block, workspace);
        let torques = &mut workspace.torques[block.dofs.clone()];
        solve_upper(factor(block, &workspace.pivots), torques);
        if model.bodies[first].parent.is_some() {
            reduce_columns(model, block, workspace);
            eliminate(model, block, workspace);
            let left = wrench_left(model, block, workspace, torque);
            let motion = &workspace.motions[first];
            model.bodies[first].wrench_to_parents(motion, left, |parent, carried| {
                workspace.wrenches[parent] += carried;
            });
        }
        for d in block.dofs.clone() {
            workspace.torques[d] = workspace.torques[d] * workspace.reciprocals[d];
        }
    }
    for block in &partition.blocks {
        accelerate(model, block, workspace, qdd);
    }
    // So far floating bases accelerate against free fall.
    for i in (0..model.bodies.len()).filter(|&i| is_base(model, i)) {
        let fall = free_fall(model, i, qd, workspace);
        for (dof, fall) in model.dofs_of(i).iter().zip(fall.0) {
            dof.add(fall, qdd);
        }
    }
}

/// qdd = U^-T phi_tilde, step (iii).
fn accelerate<S: Scalar>(
    model: &Prepared<S>,
    block: &Block,
    workspace: &mut Workspace<S>,
    qdd: &mut [S],
) {
    let first = block.bodies.start;
    let body = &model.bodies[first];
    let carried = body.parent.is_some().then(|| {
        let of = |p: Option<usize>| p.map_or_else(Twist::zero, |p| workspace.twists[p]);
        let twist = Twist::from_components(body.from_parents(|p| of(p).components()));
        body.twist_to_child(&workspace.motions[first], twist)
    });
    let freed = freed(model, block);
    for d in block.dofs.clone() {
        qdd[d] = workspace.torques[d];
        if let Some(carried) = &carried {
            let felt = (0..6)
                .filter(|&row| freed[row].is_none())
                .map(|row| workspace.gains[row][d] * carried.components()[row])
                .reduce(|sum, x| sum + x);
            qdd[d] = felt.map_or(qdd[d], |felt| qdd[d] - felt);
        }
    }
    solve_lower(factor(block, &workspace.pivots), &mut qdd[block.dofs.clone()]);
    // So far the figures of the freed components hold what their module is carried along with.
    let mut components = carried.unwrap_or_else(Twist::zero).components();
    for d in model.bodies[first].dofs.clone() {
        let along = &mut components[model.dofs[d].component];
        if freed[model.dofs[d].component].is_none() {
            *along = *along + qdd[d];
            continue;
        }
        let along = core::mem::replace(along, qdd[d]);
        if carried.is_some() {
            qdd[d] = qdd[d] - along;
        }
    }
    workspace.twists[first] = Twist::from_components(components);
    if block.has_children {
        for i in block.bodies.clone().skip(1) {
            let motion = &workspace.motions[i];
            let carried = model.bodies[i].twist_to_child(motion, workspace.twists[i - 1]);
            workspace.twists[i] = model.add_rates(i, carried, qdd);
        }
    }
}

/// What the module's first joint passes on: the wrench of the unaccelerated motion and the
/// elimination's share of the torques; in the freed components just the joint's torque.
fn wrench_left<S: Scalar>(
    model: &Prepared<S>,
    block: &Block,
    workspace: &Workspace<S>,
    torque: impl Fn(usize) -> S,
) -> Wrench<S> {
    let freed = freed(model, block);
    let mut left = workspace.wrenches[block.bodies.start].components();
    for (row, entry) in left.iter_mut().enumerate() {
        if let Some(d) = freed[row] {
            *entry = torque(d);
            continue;
        }
        let shares = block.dofs.clone().map(|d| workspace.gains[row][d] * workspace.torques[d]);
        if let Some(share) = shares.reduce(|sum, x| sum + x) {
            *entry = *entry + share;
        }
    }
    Wrench::from_components(left)
}
