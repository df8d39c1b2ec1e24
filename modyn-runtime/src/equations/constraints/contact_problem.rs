//! The problem of a step on the ground in the space of the contacts' points.

use alloc::{vec, vec::Vec};

use super::lanes::packed;
use super::rows::constraint_rows;
use super::{ConstraintInput, ConstraintWorkspace, ConstraintWorkspaces};
use crate::Scalar;
use crate::constraint_settings::{ConstraintSettings, ContactTarget};
use crate::equations::dynamics::bias_in_free_fall;
use crate::equations::factorization::limb_coupling::{Factorizable, LimbAccess};
use crate::equations::factorization::{solve_lower_factor, solve_lower_within};
use crate::equations::{State, TimeStepInput, brge};
use crate::spatial::{Matrix3, Vector3};

/// The results of [`contact_problem`]. A contact has three rows: two directions in the plane of its
/// target, then the normal.
#[derive(Debug)]
pub struct ContactProblemOutputs<'a, S> {
    /// The velocities after the step without contacts.
    pub qd: &'a mut [S],
    /// The height of each contact's origin above the plane.
    pub heights: &'a mut [S],
    /// The velocity of each contact's origin relative to the plane before the step, in the
    /// directions of its rows.
    pub before: &'a mut [Vector3<S>],
    /// The same after the step without contacts.
    pub free: &'a mut [Vector3<S>],
    /// J M^-1 J^T, a column for each row.
    pub mobility: &'a mut [S],
    /// M^-1 J^T: for each row the change of the velocities by a unit impulse.
    pub responses: &'a mut [S],
}

impl<S> ContactProblemOutputs<'_, S> {
    /// Returns the results for a call.
    pub fn reborrow(&mut self) -> ContactProblemOutputs<'_, S> {
        let Self { qd, heights, before, free, mobility, responses } = self;
        ContactProblemOutputs { qd, heights, before, free, mobility, responses }
    }
}

/// Computes what a step of the time `dt` under the joint forces `tau` needs to find the impulses of
/// its contacts: the motion without them, and the effects of unit impulses on the velocities and on
/// each other. Closed loops are not closed.
///
/// A contact is the origin of its frame on the xy plane of its target, with z as the normal. Its
/// rows are along the columns of the target's rotation.
///
/// Limbs of `tree` may be merged, each group on one body, and their contacts with them. A merged
/// contact then stands for a contact of each limb, in the settings and in `heights`, `before` and
/// `free`. `mobility` and `responses` have the rows of the robot's contacts; a response has the
/// entries of the merged velocities.
///
/// ```text
/// qd' = qd + dt M^-1 (tau - h),  u' = J qd' - u_target,  u = u' + J M^-1 J^T p
/// ```
pub fn contact_problem<S: Scalar, T: Factorizable<S>, C: AsRef<[ContactTarget<S>]>>(
    tree: &T,
    layout: &T::Layout,
    TimeStepInput { q, qd, tau, dt }: TimeStepInput<'_, S>,
    settings: &ConstraintSettings<S, C>,
    ConstraintWorkspaces { workspace, memory }: ConstraintWorkspaces<'_, S>,
    outputs: ContactProblemOutputs<'_, S>,
) {
    let model = tree.mechanism();
    let targets = settings.contacts.as_ref();
    // The acceleration without contacts.
    let rates = outputs.qd;
    bias_in_free_fall(tree, State { q, qd }, workspace, rates);
    for (rate, &tau) in rates.iter_mut().zip(tau) {
        *rate = tau - *rate;
    }
    brge::factorize(tree, layout.layout(), q, workspace, &mut memory.factors);
    memory.set_force(layout, rates);
    memory.set_fall(model, qd, workspace);
    rates.copy_from_slice(&memory.force);
    memory.scale(layout, rates);
    solve_lower_factor(layout.layout(), &memory.factors, rates);
    for (rate, &fall) in rates.iter_mut().zip(&memory.fall) {
        *rate = *rate + fall;
    }

    constraint_rows(model, State { q, qd }, targets, workspace, memory, |_, component, motion| {
        [component(motion.velocity), component(motion.displacement)]
    });
    memory.rotate_contact_rows(model, |contact| Matrix3(targets[contact].pose.rotation));
    let n = model.nv.max(1);
    let mut row = 0;
    let mut contacts = 0..targets.len();
    for (constraint, support) in model.constraints.iter().zip(&memory.supports) {
        row += constraint.rows.len();
        let Some(contact) = constraint.contact.then(|| contacts.next()).flatten() else { continue };
        // The displacements are the last three rows.
        let first = row - 3;
        let side = |side: usize, k: usize| memory.right_hand_sides[side][first + k];
        let faster = |k: usize| {
            let columns = &memory.jacobian[(first + k) * n..][..n];
            support.entries.iter().fold(S::zero(), |sum, &v| sum + columns[v] * rates[v])
        };
        outputs.heights[contact] = side(1, 2);
        outputs.before[contact] = Vector3([0, 1, 2].map(|k| side(0, k)));
        outputs.free[contact] = Vector3([0, 1, 2].map(|k| side(0, k) + dt * faster(k)));
    }
    for (rate, &before) in rates.iter_mut().zip(qd) {
        *rate = before + dt * *rate;
    }

    // All contacts are active and rigid.
    let rigid_targets: Vec<ContactTarget<S>> =
        targets.iter().map(|target| ContactTarget { compliance: S::zero(), ..*target }).collect();
    let rigid = ConstraintSettings::from_numbers(settings.numbers(), rigid_targets);
    memory.fill(
        tree,
        layout,
        ConstraintInput { active: &vec![S::one(); targets.len()], settings: &rigid },
    );
    let rows = point_rows(memory, model.constraints.len() - targets.len());
    for (i, column) in outputs.mobility.chunks_mut(rows.len().max(1)).enumerate() {
        for (&j, entry) in rows.iter().zip(column) {
            *entry = memory.factorization.entry(rows[i], j);
        }
    }
    responses(tree, layout, memory, &rows, outputs.responses);
}

/// Returns the robot's constrained rows that are displacements of contacts, which are after `loops`
/// constraints.
fn point_rows<S: Scalar>(memory: &ConstraintWorkspace<S>, loops: usize) -> Vec<usize> {
    let owner = |row: usize| {
        let (row, lane) = memory.lanes.place(row);
        (memory.owner[row], lane)
    };
    let all: Vec<usize> = (0..memory.lanes.count()).collect();
    let of_constraints = all.chunk_by(|&a, &b| owner(a) == owner(b));
    let of_contacts = of_constraints.filter(|rows| owner(rows[0]).0 >= loops);
    of_contacts.flat_map(|rows| rows[rows.len() - 3..].to_vec()).collect()
}

/// Computes M^-1 J^T of these rows of the robot: for each row, an entry for each velocity of
/// `tree`. Expects W^-1 J^T.
///
/// Where limbs are merged, the entries of the trunk are computed in the lanes of the row's limbs.
/// Then they move all limbs.
fn responses<S: Scalar, T: Factorizable<S>>(
    tree: &T,
    limbs: &T::Layout,
    memory: &ConstraintWorkspace<S>,
    rows: &[usize],
    responses: &mut [S],
) {
    let layout = limbs.layout();
    let factors = &memory.factors;
    let n = layout.n();
    let trunk = |m: &usize| limbs.limb_of_module(*m).is_none();
    let modules = 0..layout.blocks().len();
    let mut on_trunk: Vec<Option<Vec<S>>> = vec![None; memory.rows];
    for (&row, response) in rows.iter().zip(responses.chunks_mut(n.max(1))) {
        let (row, lane) = memory.lanes.place(row);
        let own_limb = memory.supports[memory.owner[row]].limb;
        let packs = on_trunk[row].get_or_insert_with(|| {
            let mut packs = memory.reduced[row * n..][..n].to_vec();
            memory.scale(limbs, &mut packs);
            solve_lower_within(layout, factors, modules.clone().filter(trunk), &mut packs);
            packs
        });
        for (v, (x, &pack)) in response.iter_mut().zip(&*packs).enumerate() {
            *x = match limbs.limb_of_dof(v) {
                None => tree.extract_lane(pack, lane),
                Some(limb) if Some(limb) == own_limb => packed(tree, 0..limb.count(), |other| {
                    if other == lane { tree.extract_lane(pack, lane) } else { S::zero() }
                }),
                Some(_) => S::zero(),
            };
        }
        solve_lower_within(layout, factors, modules.clone().filter(|m| !trunk(m)), response);
    }
}
