//! The memory of the derivatives of forward dynamics with constraints, and the sums that loop
//! constraints and contacts add their parts to: F and c of `derivatives`.

use alloc::{vec, vec::Vec};

use super::path::{Path, PathJoint};
use crate::Scalar;
use crate::mechanism::{ConstrainedFrames, ConstraintRow, Mechanism};
use crate::spatial::{Field, Twist};

/// Memory for derivatives.
#[derive(Clone, Debug)]
pub(super) struct DerivativeWorkspace<S> {
    pub(super) residuals: Vec<Twist<S>>,
    /// F with respect to q and qd, by columns.
    pub(super) forces: [Vec<S>; 2],
    /// c with respect to q and qd, by rows.
    pub(super) accelerations: [Vec<S>; 2],
    /// A^+, by columns.
    pub(super) inverse: Vec<S>,
    /// The paths of a constraint's two frames; contacts have the second.
    pub(super) paths: [Path<S>; 2],
    /// The accelerations of the bodies of a loop, relative to the closest common ancestor of its
    /// frames.
    pub(super) fields: Vec<Field<S>>,
    /// The Jacobian of a contact.
    pub(super) columns: Vec<Twist<S>>,
    /// lambda.
    pub(super) multipliers: Vec<S>,
    pub(super) solution: ColumnSolution<S>,
}

/// Memory for the columns that are solved for.
#[derive(Clone, Debug)]
pub(super) struct ColumnSolution<S> {
    /// A column of F, then of d qdd.
    pub(super) x: Vec<S>,
    /// The right-hand side of the constrained rows.
    pub(super) change: Vec<S>,
    /// d lambda.
    pub(super) multipliers: Vec<S>,
}

impl<S: Scalar> DerivativeWorkspace<S> {
    pub(super) fn new(model: &Mechanism<S>, rows: usize) -> Self {
        let n = model.nv;
        let numbers = |count| vec![S::zero(); count];
        let both = |count| [numbers(count), numbers(count)];
        Self {
            residuals: vec![Twist::zero(); model.constraints.len()],
            forces: both(n * n),
            accelerations: both(rows * n),
            inverse: numbers(rows * rows),
            paths: [Path::new(), Path::new()],
            fields: vec![Field::zero(); model.bodies.len()],
            columns: vec![Twist::zero(); n],
            multipliers: numbers(rows),
            solution: ColumnSolution {
                x: numbers(n),
                change: numbers(rows),
                multipliers: numbers(rows),
            },
        }
    }
}

/// A constraint, and its first row among the constrained rows.
#[derive(Clone, Copy)]
pub(super) struct PlacedConstraint<'a, S> {
    pub(super) constraint: &'a ConstrainedFrames<S>,
    pub(super) row: usize,
}

/// The stabilization of a constraint.
#[derive(Clone, Copy)]
pub(super) struct Stabilization<S> {
    pub(super) alpha: S,
    pub(super) beta: S,
}

impl<S: Scalar> Stabilization<S> {
    /// Returns an acceleration plus 2 alpha times a velocity.
    pub(super) fn constrained(self, acceleration: Twist<S>, velocity: Twist<S>) -> Twist<S> {
        acceleration + velocity.scale(self.alpha + self.alpha)
    }
}

/// Adds the change of J^T lambda of a degree of freedom by a coordinate to F, of which it is
/// subtracted.
pub(super) fn add_force<S: Scalar>(
    model: &Mechanism<S>,
    change: S,
    force: &PathJoint<S>,
    coordinate: &PathJoint<S>,
    forces: &mut [S],
) {
    let force = &model.dofs[force.dof];
    let coordinate = &model.dofs[coordinate.dof];
    let sum = &mut forces[coordinate.v * model.nv + force.v];
    *sum = *sum - force.scale(coordinate.scale(change));
}

/// Sets a constraint's rows of c to zero.
pub(super) fn clear_rows<S: Scalar>(
    model: &Mechanism<S>,
    PlacedConstraint { constraint, row }: PlacedConstraint<'_, S>,
    accelerations: &mut [Vec<S>; 2],
) {
    for of_variable in accelerations {
        of_variable[row * model.nv..][..constraint.rows.len() * model.nv].fill(S::zero());
    }
}

/// Adds `changes`, the derivatives of a constraint's acceleration by a joint's coordinate and by
/// its rate, to the constraint's rows of c, which begin at `row`. `in_axes` returns a row in the
/// axes of the derivatives.
pub(super) fn add_to_rows<S: Scalar>(
    model: &Mechanism<S>,
    PlacedConstraint { constraint, row }: PlacedConstraint<'_, S>,
    joint: &PathJoint<S>,
    changes: [Twist<S>; 2],
    in_axes: impl Fn(&ConstraintRow<S>) -> ConstraintRow<S>,
    accelerations: &mut [Vec<S>; 2],
) {
    let dof = &model.dofs[joint.dof];
    for (k, described) in constraint.rows.iter().enumerate() {
        let rotated = in_axes(described);
        for (of_variable, change) in accelerations.iter_mut().zip(changes) {
            let sum = &mut of_variable[(row + k) * model.nv + dof.v];
            *sum = *sum + dof.scale(rotated.scaled_component(change, constraint.length));
        }
    }
}
