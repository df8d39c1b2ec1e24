//! The rows of the constraint Jacobian in units of length, and the mobility of each constraint.
//!
//! A row is one component of a constraint's relative twist. A rotation row is multiplied by the
//! constraint's characteristic length l, so that all rows are velocities in m/s and all multipliers
//! are forces in N. The mobility of a constraint is the trace of G I^-1 G^T. G has a row for each of
//! the six directions of the relative twist, constrained or free, in the same units. The mobility
//! therefore depends neither on the axes nor on which directions are constrained. It is the scale that
//! decides whether a row is independent.

use super::ConstraintWorkspace;
use super::relative_motion::{RelativeMotion, RelativePose, common_ancestor, relative_to_ancestor};
use crate::Scalar;
use crate::equations::Workspace;
use crate::equations::brge::{self, UduLayout};
use crate::equations::kinematics::links::add_columns;
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
    /// Returns the sum of the rows' directions times `components`, one component for each row. Further
    /// components belong to other constraints and are not taken.
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
}

/// Computes the Jacobian rows of all constraints, constrained and free, and two right-hand sides.
/// `target` returns both right-hand sides of a constrained row.
pub(super) fn constraint_rows<S: Scalar>(
    model: &Mechanism<S>,
    (q, qd): (&[S], &[S]),
    workspace: &mut Workspace<S>,
    room: &mut ConstraintWorkspace<S>,
    target: impl Fn(&dyn Fn(Twist<S>) -> S, &RelativeMotion<S>) -> [S; 2],
) {
    let n = model.nv.max(1);
    let (constrained, free) = room.jacobian.split_at_mut(room.rows * model.nv);
    let mut constrained = constrained.chunks_mut(n).enumerate();
    let mut free = free.chunks_mut(n);
    for constraint in &model.loop_constraints {
        let ancestor = common_ancestor(model, constraint);
        let reach = |end, columns: &mut [Twist<S>]| {
            columns.fill(Twist::zero());
            relative_to_ancestor(model, end, ancestor, q, |i, seen| {
                add_columns(model, i, &seen.axes, seen.point, columns);
            })
        };
        let ([a, b], [first, second]) = (constraint.ends, &mut room.columns);
        let pose = RelativePose::new(&[reach(a, first), reach(b, second)]);
        let motion = RelativeMotion::new(model, constraint, &pose, (q, qd), workspace);
        let component =
            |row: &ConstraintRow<S>, twist| row.scaled_component(twist, constraint.length);
        let fill = |row: &ConstraintRow<S>, entries: &mut [S]| {
            let columns = first.iter().zip(&*second).map(|(&a, &b)| pose.twist(a, b));
            for (entry, column) in entries.iter_mut().zip(columns) {
                *entry = component(row, column);
            }
        };
        for (row, (k, entries)) in constraint.rows.iter().zip(&mut constrained) {
            fill(row, entries);
            [room.right_hand_sides[0][k], room.right_hand_sides[1][k]] =
                target(&|twist| component(row, twist), &motion);
        }
        for (row, entries) in constraint.free.iter().zip(&mut free) {
            fill(row, entries);
        }
    }
}

/// Computes I^-1 J^T, the matrix J I^-1 J^T of the constrained rows, and the mobility of each
/// constraint. Expects the rows and the factors of the mass matrix.
pub(super) fn mobilities<S: Scalar>(
    model: &Mechanism<S>,
    layout: &UduLayout,
    room: &mut ConstraintWorkspace<S>,
) {
    let n = model.nv.max(1);
    let ConstraintWorkspace { jacobian, solved, factorization, mobilities, factors, .. } = room;
    solved.copy_from_slice(jacobian);
    for row in solved.chunks_mut(n) {
        brge::solve(layout, factors, row);
    }
    let entry = |i: usize, j: usize| {
        let products = jacobian[i * n..][..n].iter().zip(&solved[j * n..][..n]);
        products.map(|(&a, &b)| a * b).reduce(|sum, x| sum + x).unwrap_or(S::zero())
    };
    factorization.fill(entry);
    let (mut row, mut free) = (0, room.rows);
    for (mobility, constraint) in mobilities.iter_mut().zip(&model.loop_constraints) {
        let (rows, free_rows) =
            (row..row + constraint.rows.len(), free..free + constraint.free.len());
        (row, free) = (rows.end, free_rows.end);
        let diagonal = rows.chain(free_rows).map(|k| entry(k, k));
        *mobility = diagonal.reduce(|sum, x| sum + x).unwrap_or(S::zero());
    }
}
