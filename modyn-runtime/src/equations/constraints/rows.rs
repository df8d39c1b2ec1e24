//! The rows of the constraint Jacobian in units of length, and the mobility of each constraint.
//!
//! A row is one component of a constraint's relative twist. A rotation row is multiplied by the
//! constraint's characteristic length l, so that all rows are velocities in m/s and all multipliers
//! are forces in N. The mobility of a constraint is the trace of G M^-1 G^T. G has a row for each
//! of the six directions of the relative twist, constrained or free, in the same units. The
//! mobility therefore depends neither on the axes nor on which directions are constrained. It is
//! the scale that decides whether a row is independent. (The mobility of a contact on a floating
//! robot is the mobility of the constrained rows: the origin of its frame moves in all directions.)
//!
//! With M = W Delta W^T, the rows of J W^-T are stored. They have the zeros of J: the columns of
//! joints that do not carry the constraint. So J M^-1 J^T needs products over common ancestors
//! only.

use super::ConstraintWorkspace;
use super::contact::ContactFrame;
use super::lanes::packed;
use super::relative_motion::{RelativeMotion, relative_columns};
use crate::Scalar;
use crate::constraint_settings::ContactTarget;
use crate::equations::factorization::limb_coupling::{Factorizable, LimbAccess};
use crate::equations::factorization::solve_upper_within;
use crate::equations::{State, Workspace};
use crate::mechanism::{ConstrainedFrames, ConstraintRow, Mechanism};
use crate::spatial::Twist;

impl<S: Scalar> ConstraintRow<S> {
    /// Returns the component of a twist that the row constrains, rad/s or m/s.
    fn component(&self, twist: Twist<S>) -> S {
        self.direction.dot(if self.angular { twist.angular } else { twist.linear })
    }

    /// Returns the component of a twist that the row constrains, in m/s.
    pub(super) fn scaled_component(&self, twist: Twist<S>, length: S) -> S {
        let component = self.component(twist);
        if self.angular { component * length } else { component }
    }
}

impl<S: Scalar> ConstrainedFrames<S> {
    /// Returns the sum of the rows' directions times `components`, one component for each row.
    /// Further components belong to other constraints and are not taken.
    pub(super) fn along_rows(&self, components: impl Iterator<Item = S>) -> Twist<S> {
        let mut sum = Twist::zero();
        // `zip` asks the rows first, so that no component is taken without a row.
        for (row, component) in self.rows.iter().zip(components) {
            let part = if row.angular { &mut sum.angular } else { &mut sum.linear };
            *part += row.direction.scale(component);
        }
        sum
    }

    /// Returns a twist without its components along the free directions.
    pub(super) fn constrained_part(&self, twist: Twist<S>) -> Twist<S> {
        self.along_rows(self.rows.iter().map(|row| row.component(twist)))
    }

    /// Returns whether rotations are constrained.
    pub(super) fn holds_rotation(&self) -> bool {
        self.rows.iter().any(|row| row.angular)
    }
}

/// Computes the Jacobian rows of all constraints, constrained and free, and two right-hand sides.
/// `target` returns both right-hand sides of a constrained row; its arguments are the constraint's
/// index, the function that returns the row's component of a twist, and the relative motion.
pub(super) fn constraint_rows<S: Scalar>(
    model: &Mechanism<S>,
    State { q, qd }: State<'_, S>,
    targets: &[ContactTarget<S>],
    workspace: &mut Workspace<S>,
    memory: &mut ConstraintWorkspace<S>,
    target: impl Fn(usize, &dyn Fn(Twist<S>) -> S, &RelativeMotion<S>) -> [S; 2],
) {
    let n = model.nv.max(1);
    let (constrained, free) = memory.jacobian.split_at_mut(memory.rows * model.nv);
    let mut constrained = constrained.chunks_mut(n).enumerate();
    let mut free = free.chunks_mut(n);
    let loops = model.constraints.len() - model.contacts();
    memory.frames.clear();
    for (c, constraint) in model.constraints.iter().enumerate() {
        let motion = if constraint.contact {
            let first = &mut memory.columns[0];
            let frame = ContactFrame::new(model, constraint.ends[1], q, workspace, first);
            let surface = constraint.holds_rotation();
            let target = &targets[c - loops];
            let motion = frame.motion(model, target, surface, &*first, qd, workspace);
            memory.frames.push(frame);
            motion
        } else {
            let pose = relative_columns(model, constraint, q, &mut memory.columns);
            let [first, second] = &mut memory.columns;
            for (a, &b) in first.iter_mut().zip(&*second) {
                *a = pose.twist(*a, b);
            }
            RelativeMotion::new(model, constraint, &pose, State { q, qd }, workspace)
        };
        let first = &memory.columns[0];
        let component =
            |row: &ConstraintRow<S>, twist| row.scaled_component(twist, constraint.length);
        let fill = |row: &ConstraintRow<S>, entries: &mut [S]| {
            for (entry, &column) in entries.iter_mut().zip(first) {
                *entry = component(row, column);
            }
        };
        for (row, (k, entries)) in constraint.rows.iter().zip(&mut constrained) {
            fill(row, entries);
            [memory.right_hand_sides[0][k], memory.right_hand_sides[1][k]] =
                target(c, &|twist| component(row, twist), &motion);
        }
        for (row, entries) in constraint.free.iter().zip(&mut free) {
            fill(row, entries);
        }
    }
}

/// Computes W^-1 J^T of all rows, the matrix J M^-1 J^T of the robot's constrained rows, in which
/// the rows of inactive contacts are zero, and the mobility of each constraint. Expects the rows
/// and the factors of the mass matrix.
///
/// Where limbs are merged, the rows of one limb are multiplied in lanes, and so are the rows of two
/// limbs of one merged limb, which have the trunk's entries in common.
pub(super) fn mobilities<S: Scalar, T: Factorizable<S>>(
    tree: &T,
    limbs: &T::Layout,
    active: &[S],
    targets: &[ContactTarget<S>],
    memory: &mut ConstraintWorkspace<S>,
) {
    let model = tree.mechanism();
    let n = model.nv.max(1);
    let ConstraintWorkspace { jacobian, reduced, factorization, mobilities, factors, .. } = memory;
    let owner = &memory.owner;
    let supports = &memory.supports;
    let lanes = &memory.lanes;
    let loops = model.constraints.len() - active.len();
    let contact = |row: usize| owner[row].checked_sub(loops);
    reduced.copy_from_slice(jacobian);
    for (row, &c) in reduced.chunks_mut(n).zip(owner) {
        solve_upper_within(limbs, factors, supports[c].modules.iter().copied(), row);
    }
    let reduced = &*reduced;
    let reciprocals = &factors[limbs.layout().reciprocals()];
    let common = |i: usize, j: usize| {
        let shared = supports[owner[i]].entries.iter().copied();
        shared.filter(move |&k| supports[owner[j]].has[k])
    };
    // The entries of rows of one limb, or of a limb and the trunk.
    let entry = |i: usize, j: usize| {
        sum(common(i, j).map(|k| reduced[i * n + k] * (reduced[j * n + k] * reciprocals[k])))
    };
    let within = |i: usize, j: usize| {
        let sum = entry(i, j);
        match [contact(i), contact(j)] {
            [None, None] => sum,
            [Some(a), None] | [None, Some(a)] => sum * active[a],
            [Some(a), Some(b)] if a == b => {
                let compliant = if i == j { sum + targets[a].compliance } else { sum };
                compliant * active[a]
            }
            [Some(a), Some(b)] => sum * (active[a] * active[b]),
        }
    };
    // The entries of the row of an inactive contact are zero.
    let masked = |i: usize, k: usize| {
        contact(i).map_or(reduced[i * n + k], |contact| reduced[i * n + k] * active[contact])
    };
    let trunk = |i, j| common(i, j).filter(|&k| limbs.limb_of_dof(k).is_none());
    // The entries of the rows of each limb and of the limb `shift` lanes after it, in the lanes of
    // the first.
    let shifted = |i: usize, j: usize, (count, shift): (usize, usize)| {
        let shift =
            |x: S| packed(tree, 0..count, |lane| tree.extract_lane(x, (lane + shift) % count));
        sum(trunk(i, j).map(|k| masked(i, k) * shift(masked(j, k) * reciprocals[k])))
    };
    factorization.fill(|i, j| {
        let (i, a) = lanes.place(i);
        let (j, b) = lanes.place(j);
        match [i, j].map(|row| supports[owner[row]].limb) {
            [Some(limb), Some(other)] if limb == other && a != b => {
                let count = limb.count();
                let [forth, back] = [(b + count - a) % count, (a + count - b) % count];
                // One of the two ways around, so that equal sums are one.
                if (forth, i) <= (back, j) {
                    tree.extract_lane(shifted(i, j, (count, forth)), a)
                } else {
                    tree.extract_lane(shifted(j, i, (count, back)), b)
                }
            }
            [Some(limb), Some(other)] if limb != other => sum(trunk(i, j).map(|k| {
                let scaled = masked(j, k) * reciprocals[k];
                tree.extract_lane(masked(i, k), a) * tree.extract_lane(scaled, b)
            })),
            [None, Some(_)] => tree.extract_lane(within(i, j), b),
            _ => tree.extract_lane(within(i, j), a),
        }
    });
    let mut row = 0;
    let mut free = memory.rows;
    for (mobility, constraint) in mobilities.iter_mut().zip(&model.constraints) {
        let rows = row..row + constraint.rows.len();
        let free_rows = free..free + constraint.free.len();
        (row, free) = (rows.end, free_rows.end);
        *mobility = sum(rows.chain(free_rows).map(|k| entry(k, k)));
    }
}

fn sum<S: Scalar>(terms: impl Iterator<Item = S>) -> S {
    terms.reduce(|sum, x| sum + x).unwrap_or(S::zero())
}
