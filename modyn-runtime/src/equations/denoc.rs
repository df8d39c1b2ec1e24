//! The decoupled natural orthogonal complement (DeNOC) matrices, dense, for study: (1)-(5),
//! A.1 and A.2.

use alloc::{vec, vec::Vec};

use super::Workspace;
use crate::Scalar;
use crate::model::prepare::Prepared;
use crate::spatial::Twist;

/// A dense matrix by rows, to be handed to whatever linear algebra is at hand.
#[derive(Clone, Debug, PartialEq)]
pub struct Dense<S> {
    /// Number of rows.
    pub rows: usize,
    /// Number of columns.
    pub columns: usize,
    /// Its entries, row by row.
    pub entries: Vec<S>,
}

impl<S: Scalar> Dense<S> {
    /// All zeros.
    #[must_use]
    pub fn zero(rows: usize, columns: usize) -> Self {
        Self { rows, columns, entries: vec![S::zero(); rows * columns] }
    }

    /// The entry in row `i` and column `j`, if it exists.
    #[must_use]
    pub fn get(&self, i: usize, j: usize) -> Option<S> {
        (j < self.columns).then(|| self.entries.get(i * self.columns + j).copied()).flatten()
    }

    fn set(&mut self, i: usize, j: usize, value: S) {
        self.entries[i * self.columns + j] = value;
    }
}

/// M, N_l and N_d with the GIM = N_d^T N_l^T M N_l N_d, (5a).
///
/// Rows and columns stand link by link, in each link's own (turned) axes, angular before linear;
/// modules are consecutive links, so these are the module-level matrices of (4) as well.
#[derive(Clone, Debug, PartialEq)]
pub struct DeNoc<S> {
    /// The 6n times 6n mass matrix of the free links, (1)-(2).
    pub mass: Dense<S>,
    /// The 6n times 6n matrix of twist propagations, (A.12).
    pub propagation: Dense<S>,
    /// The 6n times n matrix of joint-motion propagations, (A.5).
    pub joints: Dense<S>,
}

/// The DeNOC matrices at `q`.
#[must_use]
pub fn denoc<S: Scalar>(model: &Prepared<S>, q: &[S], workspace: &mut Workspace<S>) -> DeNoc<S> {
    workspace.move_to(model, q);
    let n = model.bodies.len();
    let mut mass = Dense::zero(6 * n, 6 * n);
    let mut propagation = Dense::zero(6 * n, 6 * n);
    let mut joints = Dense::zero(6 * n, n);
    for (i, body) in model.bodies.iter().enumerate() {
        let inertia = body.inertia.articulated();
        for row in 0..6 {
            propagation.set(6 * i + row, 6 * i + row, S::one());
            for column in row..6 {
                let entry = inertia.entry(row, column);
                mass.set(6 * i + row, 6 * i + column, entry);
                mass.set(6 * i + column, 6 * i + row, entry);
            }
        }
        joints.set(6 * i + workspace.motions[i].component(), i, S::one());
        // A row of blocks is the parent's, carried on: A_ij = A_ip A_pj.
        if let Some(parent) = body.parent {
            for column in 0..6 * (parent + 1) {
                let at = |row: usize| propagation.entries[(6 * parent + row) * 6 * n + column];
                let mut twist = Twist::zero();
                twist.angular.0 = core::array::from_fn(&at);
                twist.linear.0 = core::array::from_fn(|k| at(3 + k));
                let carried = body.twist_to_child(&workspace.motions[i], twist).components();
                for (row, entry) in carried.into_iter().enumerate() {
                    propagation.set(6 * i + row, column, entry);
                }
            }
        }
    }
    DeNoc { mass, propagation, joints }
}

#[cfg(test)]
mod tests {
    use super::Dense;

    #[test]
    fn entries_are_found_by_row_and_column() {
        let mut matrix = Dense::<f64>::zero(2, 3);
        matrix.set(1, 0, 5.0);
        matrix.set(0, 2, 7.0);
        assert_eq!(matrix.entries, [0.0, 0.0, 7.0, 5.0, 0.0, 0.0]);
        assert_eq!((matrix.get(1, 0), matrix.get(0, 2)), (Some(5.0), Some(7.0)));
        assert_eq!((matrix.get(2, 0), matrix.get(0, 3)), (None, None));
    }
}
