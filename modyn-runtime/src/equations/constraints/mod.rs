//! Forward dynamics of mechanisms with loop joints: a constraint holds two frames together.
//!
//! | file | content |
//! |---|---|
//! | `relative_motion` | the motion of a constraint's second frame relative to its first |
//! | `rows` | the Jacobian rows in units of length, and the mobility of each constraint |
//! | `factorization` | the pseudo-inverse of J I^-1 J^T, and its rank |
//! | `forward_dynamics` | accelerations and constraint wrenches |
//! | `projection` | steps of coordinates and velocities that satisfy the constraints |
//! | `residual` | displacements and velocities that violate the constraints |
//!
//! A constraint consists of rows J qd = 0. Each row is a component of the second frame's twist relative
//! to the first frame, in the first frame's axes. The time derivative of a row is J qdd + dJ/dt qd. With
//! multipliers lambda (Featherstone 2008, "Rigid Body Dynamics Algorithms", 8.2) and the stabilization
//! of Baumgarte (1972), which drives phi and J qd to zero, the equations are
//!
//! ```text
//! I qdd = tau - h + J^T lambda
//! J qdd = gamma = -dJ/dt qd - 2 alpha J qd - beta^2 phi
//! ```
//!
//! With the accelerations qdd_0 of the tree without constraints, lambda = (J I^-1 J^T)^+ (gamma - J qdd_0)
//! and qdd = qdd_0 + I^-1 J^T lambda. Every product with I^-1 is computed with the factors U D U^T of
//! the mass matrix ([`brge`](super::brge)).
//!
//! Rotation rows are multiplied by the constraint's characteristic length l
//! ([`Model::characteristic_length`](crate::model::Model::characteristic_length)). Where rows are
//! redundant, the multipliers minimize the sum of force^2 + (moment / l)^2 over all constraints. Where
//! rows contradict each other, the accelerations minimize the sum of the squared residuals,
//! linear^2 + (l angular)^2. Neither sum depends on the orientation of the mechanism.

mod factorization;
mod forward_dynamics;
mod projection;
mod relative_motion;
mod residual;
mod rows;

pub use forward_dynamics::constrained_forward_dynamics;
pub use projection::project_constraints;
pub use residual::constraint_residual;

use alloc::{vec, vec::Vec};

use super::brge::UduLayout;
use crate::Scalar;
use crate::mechanism::{ConstrainedFrames, Mechanism};
use crate::results::ConstraintSettings;
use crate::spatial::Twist;
use factorization::RankFactorization;

/// Memory for the intermediate results of constrained dynamics.
#[derive(Clone, Debug)]
pub struct ConstraintWorkspace<S> {
    /// For each of the two frames: its Jacobian in the frame's own axes, a column for each entry of qd.
    columns: [Vec<Twist<S>>; 2],
    /// The number of constrained rows.
    rows: usize,
    /// J and I^-1 J^T: the constrained rows of all constraints, then the free rows. A row has nv
    /// entries.
    jacobian: Vec<S>,
    solved: Vec<S>,
    /// For each constraint, the trace of J I^-1 J^T over all six directions.
    mobilities: Vec<S>,
    /// The factorization of J I^-1 J^T, constrained rows only.
    factorization: RankFactorization<S>,
    /// Two right-hand sides, an entry for each constrained row; `solve` replaces them by multipliers.
    right_hand_sides: [Vec<S>; 2],
    /// For each constrained row, the part of the right-hand side that is not met.
    residuals: Vec<S>,
    /// The factors of the mass matrix.
    factors: Vec<S>,
}

impl<S: Scalar> ConstraintWorkspace<S> {
    /// Returns memory for `model`, whose mass matrix is factorized with `layout`.
    #[must_use]
    pub fn new(model: &Mechanism<S>, layout: &UduLayout) -> Self {
        let constraints = || model.loop_constraints.iter();
        let rows = constraints().map(|constraint| constraint.rows.len()).sum();
        let free: usize = constraints().map(|constraint| constraint.free.len()).sum();
        let blocks = constraints().map(|c| (c.rows.len(), degrees_of_freedom(model, c)));
        let numbers = |count| vec![S::zero(); count];
        Self {
            columns: [vec![Twist::zero(); model.nv], vec![Twist::zero(); model.nv]],
            rows,
            jacobian: numbers((rows + free) * model.nv),
            solved: numbers((rows + free) * model.nv),
            mobilities: numbers(model.loop_constraints.len()),
            factorization: RankFactorization::new(blocks),
            right_hand_sides: [numbers(rows), numbers(rows)],
            residuals: numbers(rows),
            factors: numbers(layout.size()),
        }
    }

    /// Factorizes J I^-1 J^T of the current rows.
    fn factorize(
        &mut self,
        model: &Mechanism<S>,
        layout: &UduLayout,
        settings: &ConstraintSettings<S>,
    ) {
        rows::mobilities(model, layout, self);
        let (tolerance, rounding) = (settings.tolerance, settings.rounding);
        self.factorization.factorize(&self.mobilities, tolerance, rounding);
    }

    /// Replaces right-hand side `side` by its multipliers.
    fn solve(&mut self, side: usize) {
        let Self { factorization, right_hand_sides, residuals, .. } = self;
        factorization.solve(&mut right_hand_sides[side], residuals);
    }

    /// Subtracts J qdd from the first right-hand side.
    fn subtract_accelerations(&mut self, qdd: &[S]) {
        let rows = self.jacobian.chunks(qdd.len().max(1));
        for (b, row) in self.right_hand_sides[0].iter_mut().zip(rows) {
            let products = row.iter().zip(qdd).map(|(&a, &x)| a * x);
            *b = products.reduce(|sum, x| sum + x).map_or(*b, |sum| *b - sum);
        }
    }

    /// Adds I^-1 J^T lambda, the joints' response to the multipliers lambda of right-hand side `side`.
    fn add_response(&self, side: usize, sum: &mut [S]) {
        let rows = self.solved.chunks(sum.len().max(1));
        for (&multiplier, row) in self.right_hand_sides[side].iter().zip(rows) {
            for (sum, &x) in sum.iter_mut().zip(row) {
                *sum = *sum + x * multiplier;
            }
        }
    }
}

/// Returns the number of entries of qd that move the two frames of a constraint relative to each other.
/// The rank of the constraint's rows cannot be higher.
fn degrees_of_freedom<S>(model: &Mechanism<S>, constraint: &ConstrainedFrames<S>) -> usize {
    let ancestor = relative_motion::common_ancestor(model, constraint);
    let mut moving = vec![false; model.nv];
    for end in &constraint.ends {
        let mut body = end.body;
        while let Some(i) = body.filter(|_| body != ancestor) {
            for dof in &model.dofs[model.bodies[i].dofs.clone()] {
                moving[dof.v] = true;
            }
            body = model.bodies[i].parent;
        }
    }
    moving.into_iter().filter(|&moves| moves).count()
}
