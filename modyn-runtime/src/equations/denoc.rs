//! The decoupled natural orthogonal complement (DeNOC) matrices, dense, for study: (1)-(5),
//! A.1 and A.2.

use alloc::{vec, vec::Vec};

use super::Workspace;
use crate::Scalar;
use crate::model::prepare::Prepared;
use crate::spatial::Twist;

/// A dense matrix by rows.
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

    /// The transposed matrix.
    #[must_use]
    pub fn transposed(&self) -> Self {
        let mut transposed = Self::zero(self.columns, self.rows);
        for (k, &entry) in self.entries.iter().enumerate() {
            transposed.set(k % self.columns, k / self.columns, entry);
        }
        transposed
    }

    /// The product with `other` on the right; `None` if the sizes do not fit.
    #[must_use]
    pub fn times(&self, other: &Self) -> Option<Self> {
        if self.columns != other.rows {
            return None;
        }
        let mut product = Self::zero(self.rows, other.columns);
        for i in 0..self.rows {
            for k in 0..self.columns {
                let factor = self.entries[i * self.columns + k];
                for j in 0..other.columns {
                    let at = i * other.columns + j;
                    let term = factor * other.entries[k * other.columns + j];
                    product.entries[at] = product.entries[at] + term;
                }
            }
        }
        Some(product)
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
