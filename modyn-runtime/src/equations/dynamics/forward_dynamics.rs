//! Forward dynamics by inter- and intra-modular recursion, equation (60) and Table 6 of the paper.
//!
//! A Newton-Euler pass computes the wrenches at the current velocities under gravity, with zero
//! joint accelerations (a floating base is in free fall). The recursion then solves for the
//! deviation from that motion, so it contains no velocities. Every partition into modules gives the
//! same accelerations. Modules of one link give Table 6 itself, which is Featherstone's
//! articulated-body algorithm. One module for a serial chain gives composite inertias and a dense
//! elimination.
//!
//! Mimic joints couple links across the tree. Robots with mimic joints are solved with the factors
//! of their mass matrix.

use alloc::vec::Vec;

use super::newton_euler::{Accelerations, free_fall, is_base, link_wrenches};
use super::{Forces, inverse_dynamics, mass_matrix};
use crate::Scalar;
use crate::equations::factorization::blocks::{solve_lower, solve_upper};
use crate::equations::factorization::partition::factor;
use crate::equations::factorization::recursive::{
    eliminate, motion_subspace, pivot, reduce_columns, split, start,
};
use crate::equations::factorization::{
    ModuleBlock, ModulePartition, UduLayout, factorize_matrix, solve,
};
use crate::equations::{ForwardInput, State, Workspace};
use crate::mechanism::{BodyTree, Mechanism};
use crate::model::ModuleTree;
use crate::spatial::{Twist, Wrench};

/// The solver for joint accelerations.
#[derive(Clone, Debug)]
pub enum Elimination {
    /// The recursion over these modules.
    Recursive(ModulePartition),
    /// The factors of the mass matrix, for robots with mimic joints, and for steps of robots with
    /// loops.
    Matrix(UduLayout),
}

impl Elimination {
    /// Returns the solver for `model`. `modules` must fit the model.
    #[must_use]
    pub fn new<S: Scalar>(model: &Mechanism<S>, modules: &ModuleTree) -> Self {
        if model.has_mimics() {
            Self::Matrix(UduLayout::new(model, modules))
        } else {
            Self::Recursive(ModulePartition::new(model, modules))
        }
    }

    /// Returns the solver for steps of `model`, in which loops are closed and constraint rows couple
    /// these entries of qd.
    #[must_use]
    pub fn of_steps<S: Scalar>(
        model: &Mechanism<S>,
        modules: &ModuleTree,
        couplings: impl Iterator<Item = Vec<usize>>,
    ) -> Self {
        let mut couplings = couplings.peekable();
        match model.constraints.len() > model.contacts() || couplings.peek().is_some() {
            true => Self::Matrix(UduLayout::with_couplings(model, modules, couplings)),
            false => Self::new(model, modules),
        }
    }

    /// Makes the workspace large enough for this solver.
    pub fn reserve<S: Scalar>(&self, model: &Mechanism<S>, workspace: &mut Workspace<S>) {
        match self {
            Self::Recursive(partition) => workspace.reserve(partition.pivots, 0, 0),
            Self::Matrix(layout) => {
                workspace.reserve(layout.pivots(), model.nv * model.nv, layout.size());
            }
        }
    }
}

/// Computes the joint accelerations qdd = I(q)^-1 (tau - h(q, qd) + J^T f) under the joint forces
/// `tau` and the external forces f.
pub fn forward_dynamics<S: Scalar>(
    model: &Mechanism<S>,
    elimination: &Elimination,
    ForwardInput { q, qd, tau }: ForwardInput<'_, S>,
    forces: Option<Forces<'_, S>>,
    workspace: &mut Workspace<S>,
    qdd: &mut [S],
) {
    elimination.reserve(model, workspace);
    match elimination {
        Elimination::Recursive(partition) => {
            workspace.move_with_forces(model, q, Some(qd));
            link_wrenches(model, qd, Accelerations::FreeFall, workspace);
            if let Some(forces) = forces {
                forces.subtract(model, workspace);
            }
            recursion(model, partition, qd, tau, workspace, qdd);
        }
        Elimination::Matrix(layout) => {
            inverse_dynamics(model, State { q, qd }, None, forces, workspace, qdd);
            for (qdd, &tau) in qdd.iter_mut().zip(tau) {
                *qdd = tau - *qdd;
            }
            let mut matrix = core::mem::take(&mut workspace.matrix);
            mass_matrix(model, q, workspace, &mut matrix);
            let Workspace { pivots, factors, .. } = workspace;
            factorize_matrix(layout, &mut matrix, pivots, factors);
            solve(layout, factors, qdd);
            workspace.matrix = matrix;
        }
    }
}

/// Computes the joint accelerations by recursion over the modules, without external forces. Limbs
/// of `tree` may be merged. The robot must not have mimic joints.
pub fn recursive_forward_dynamics<S: Scalar, T: BodyTree<S>>(
    tree: &T,
    partition: &ModulePartition,
    ForwardInput { q, qd, tau }: ForwardInput<'_, S>,
    workspace: &mut Workspace<S>,
    qdd: &mut [S],
) {
    workspace.reserve(partition.pivots, 0, 0);
    workspace.move_with_forces(tree, q, Some(qd));
    link_wrenches(tree, qd, Accelerations::FreeFall, workspace);
    recursion(tree, partition, qd, tau, workspace, qdd);
}

/// Solves for the accelerations. Expects the wrenches at zero joint accelerations.
fn recursion<S: Scalar, T: BodyTree<S>>(
    tree: &T,
    partition: &ModulePartition,
    qd: &[S],
    tau: &[S],
    workspace: &mut Workspace<S>,
    qdd: &mut [S],
) {
    let model = tree.mechanism();
    against_fall(tree, partition, qd, tau, workspace, qdd);
    for i in (0..model.bodies.len()).filter(|&i| is_base(model, i)) {
        add_free_fall(model, i, qd, workspace, qdd);
    }
}

/// Solves for the accelerations; the accelerations of floating bases are relative to free fall.
/// Expects the wrenches at zero joint accelerations.
pub(in crate::equations) fn against_fall<S: Scalar, T: BodyTree<S>>(
    tree: &T,
    partition: &ModulePartition,
    qd: &[S],
    tau: &[S],
    workspace: &mut Workspace<S>,
    qdd: &mut [S],
) {
    start(tree.mechanism(), workspace);
    for block in partition.blocks.iter().rev() {
        eliminate_module(tree, block, qd, tau, workspace);
    }
    for block in &partition.blocks {
        accelerate(tree, block, workspace, qdd);
    }
}

/// Adds the acceleration of free fall to the accelerations of floating base `i`, which are relative
/// to it until then.
pub(in crate::equations) fn add_free_fall<S: Scalar>(
    model: &Mechanism<S>,
    i: usize,
    qd: &[S],
    workspace: &Workspace<S>,
    qdd: &mut [S],
) {
    let fall = free_fall(model, i, qd, workspace);
    for (dof, fall) in model.dofs_of(i).iter().zip(fall.0) {
        dof.add(fall, qdd);
    }
}

/// Eliminates the joints of a module, steps (i) and (ii) of (60): computes phi_hat = U^-1 phi and
/// phi_tilde = D^-1 phi_hat, and adds the module's inertia and wrench to its parent.
pub(super) fn eliminate_module<S: Scalar, T: BodyTree<S>>(
    tree: &T,
    block: &ModuleBlock,
    qd: &[S],
    tau: &[S],
    workspace: &mut Workspace<S>,
) {
    let model = tree.mechanism();
    // The joint force without springs, damping and friction.
    let torque = |d: usize, workspace: &Workspace<S>| {
        let dof = &model.dofs[d];
        let dissipation = model.dissipation(dof, qd);
        let left = dissipation.map_or(tau[dof.v], |dissipation| tau[dof.v] - dissipation);
        workspace.passive[d].map_or(left, |passive| left - passive)
    };
    let first = block.bodies.start;
    for i in block.bodies.clone().rev() {
        let wrench = workspace.wrenches[i];
        for d in model.bodies[i].dofs.clone() {
            let force = wrench.components()[model.dofs[d].component];
            workspace.torques[d] = torque(d, workspace) - force;
        }
        if i > first {
            let at_parent = model.bodies[i].wrench_to_parent(&workspace.motions[i], wrench);
            workspace.wrenches[i - 1] += at_parent;
        }
    }
    pivot(tree, block, workspace);
    split(block, workspace);
    let torques = &mut workspace.torques[block.dofs.clone()];
    solve_upper(factor(block, &workspace.pivots), torques);
    if model.bodies[first].parent.is_some() {
        reduce_columns(model, block, workspace);
        eliminate(tree, block, workspace);
        let left = remaining_wrench(model, block, workspace, |d| torque(d, workspace));
        let motion = &workspace.motions[first];
        tree.wrench_to_parents(first, motion, left, |parent, at_parent| {
            workspace.wrenches[parent] += at_parent;
        });
    }
    for d in block.dofs.clone() {
        workspace.torques[d] = workspace.torques[d] * workspace.reciprocals[d];
    }
}

/// Computes qdd = U^-T phi_tilde, step (iii) of (60).
pub(super) fn accelerate<S: Scalar, T: BodyTree<S>>(
    tree: &T,
    block: &ModuleBlock,
    workspace: &mut Workspace<S>,
    qdd: &mut [S],
) {
    let model = tree.mechanism();
    let first = block.bodies.start;
    let body = &model.bodies[first];
    let from_parent = body.parent.is_some().then(|| {
        let twist_of = |p: Option<usize>| p.map_or_else(Twist::zero, |p| workspace.twists[p]);
        let twist = Twist::from_components(
            tree.broadcast_from_parents(first, |p| twist_of(p).components()),
        );
        body.twist_to_child(&workspace.motions[first], twist)
    });
    let subspace = motion_subspace(model, block, workspace);
    for d in block.dofs.clone() {
        qdd[d] = workspace.torques[d];
        if let Some(from_parent) = &from_parent {
            let force = (0..6)
                .filter(|&row| subspace[row].is_none())
                .map(|row| workspace.scaled_psi[row][d] * from_parent.components()[row])
                .reduce(|sum, x| sum + x);
            qdd[d] = force.map_or(qdd[d], |force| qdd[d] - force);
        }
    }
    solve_lower(factor(block, &workspace.pivots), &mut qdd[block.dofs.clone()]);
    // So far the components of the motion subspace are the parent's motion.
    let mut components = from_parent.unwrap_or_else(Twist::zero).components();
    for d in model.bodies[first].dofs.clone() {
        let along = &mut components[model.dofs[d].component];
        if subspace[model.dofs[d].component].is_none() {
            *along = *along + qdd[d];
            continue;
        }
        let along = core::mem::replace(along, qdd[d]);
        if from_parent.is_some() {
            qdd[d] = qdd[d] - along;
        }
    }
    workspace.twists[first] = Twist::from_components(components);
    if block.has_children {
        for i in block.bodies.clone().skip(1) {
            let motion = &workspace.motions[i];
            let from_parent = model.bodies[i].twist_to_child(motion, workspace.twists[i - 1]);
            workspace.twists[i] = model.add_rates(i, from_parent, qdd);
        }
    }
}

/// Returns the wrench that the module's first joint transmits to its parent: the wrench at zero
/// joint accelerations plus the reaction to the module's accelerations. Its components along the
/// motion subspace are the joint's own force.
fn remaining_wrench<S: Scalar>(
    model: &Mechanism<S>,
    block: &ModuleBlock,
    workspace: &Workspace<S>,
    torque: impl Fn(usize) -> S,
) -> Wrench<S> {
    let subspace = motion_subspace(model, block, workspace);
    let mut left = workspace.wrenches[block.bodies.start].components();
    for (row, entry) in left.iter_mut().enumerate() {
        if let Some(d) = subspace[row] {
            *entry = torque(d);
            continue;
        }
        let shares =
            block.dofs.clone().map(|d| workspace.scaled_psi[row][d] * workspace.torques[d]);
        if let Some(share) = shares.reduce(|sum, x| sum + x) {
            *entry = *entry + share;
        }
    }
    Wrench::from_components(left)
}
