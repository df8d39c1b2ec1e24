//! The operational-space inertia of the constraints.

use super::rows::constraint_rows;
use super::{ConstraintInput, ConstraintWorkspaces, OperationalSpaceInertiaOutputs};
use crate::Scalar;
use crate::constraint_settings::ContactTarget;
use crate::equations::factorization::limb_coupling::{Factorizable, LimbAccess};
use crate::equations::{State, brge};
use crate::spatial::{Matrix3, Pose};

/// Computes the inverse operational-space inertia J M^-1 J^T of the constraint rows (the Delassus
/// matrix), with the compliance of contacts, and its pseudo-inverse, the operational-space inertia
/// (Khatib 1987). Both are arrays of columns. Returns the number of independent rows.
///
/// Each constraint has its constrained displacements, then its constrained rotations: in the first
/// frame's axes for a loop constraint, in world axes for a contact. The rows and columns of
/// inactive contacts are zero. Where rows are redundant, the pseudo-inverse is computed from the
/// rows in units of length: rotations are multiplied by the characteristic length.
///
/// The columns of the pseudo-inverse are computed several at a time where the scalars have lanes.
pub fn operational_space_inertia<S: Scalar, T: Factorizable<S>, C: AsRef<[ContactTarget<S>]>>(
    tree: &T,
    layout: &T::Layout,
    q: &[S],
    ConstraintInput { active, settings }: ConstraintInput<'_, S, C>,
    ConstraintWorkspaces { workspace, memory }: ConstraintWorkspaces<'_, S>,
    OperationalSpaceInertiaOutputs { delassus, inertia }: OperationalSpaceInertiaOutputs<'_, S>,
) -> S {
    let model = tree.mechanism();
    brge::factorize(tree, layout.layout(), q, workspace, &mut memory.factors);
    let targets = settings.targets.as_ref();
    let rest = core::mem::take(&mut memory.rest);
    constraint_rows(model, State { q, qd: &rest }, targets, workspace, memory, |_, _, _| {
        [S::zero(); 2]
    });
    memory.rest = rest;
    memory.rotate_contact_rows(model, |_| Matrix3(Pose::identity().rotation));
    memory.fill(tree, layout, ConstraintInput { active, settings });
    let rows = memory.rows;
    let length = |row: usize| memory.row_length(model, row);
    for (j, column) in delassus.chunks_mut(rows.max(1)).enumerate() {
        for (i, entry) in column.iter_mut().enumerate() {
            *entry = memory.factorization.entry(i, j) * (length(i) * length(j)).recip();
        }
    }
    memory.factorize_filled(tree, settings);
    memory.factorization.inverse(tree, inertia);
    for (j, column) in inertia.chunks_mut(rows.max(1)).enumerate() {
        for (i, entry) in column.iter_mut().enumerate() {
            *entry = *entry * (memory.row_length(model, i) * memory.row_length(model, j));
        }
    }
    memory.factorization.rank()
}
