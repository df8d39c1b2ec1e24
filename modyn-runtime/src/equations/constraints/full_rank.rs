//! The factorization of J M^-1 J^T where all rows are independent.
//!
//! L D L^T in the order of the rows, without exchanges. A row that is zero, such as the row of an
//! inactive contact, is left out. Whether the pivoted factorization would find a dependent row is
//! known from this one. The remaining diagonal of row i is least if all other rows are eliminated
//! before it: then it is 1 / (A^-1)_ii. So in any order of the rows all are independent where each
//! of these numbers is above its row's threshold. These numbers do not depend on the order of the
//! rows either.

use alloc::{vec, vec::Vec};

use crate::Scalar;
use crate::solve::place;

/// The factors of a symmetric matrix whose rows are independent or zero.
#[derive(Clone, Debug)]
pub(super) struct FullRank<S> {
    /// L below the diagonal, in the lower triangle by rows.
    factor: Vec<S>,
    /// The inverse of L below the diagonal, in the same order.
    lower: Vec<S>,
    /// The reciprocals of D; zero for a zero row.
    reciprocals: Vec<S>,
    /// For each row one, or zero if the row is zero.
    present: Vec<S>,
    /// The largest of numbers that are negative for independent rows.
    excess: S,
}

impl<S: Scalar> FullRank<S> {
    /// Factorizes a matrix, of which the lower triangle is stored by rows.
    pub(super) fn new(matrix: &[S], thresholds: &[S]) -> Self {
        let rows = thresholds.len();
        let mut factor = matrix.to_vec();
        let zeros = vec![S::zero(); rows];
        let mut reciprocals = zeros.clone();
        let mut present = zeros;
        let mut excess = -S::one();
        for k in (0..rows).filter(|&k| !matrix[place(k, k)].is_constant_zero()) {
            let is_zero = -matrix[place(k, k)];
            let diagonal = is_zero.select_nonnegative(S::one(), factor[place(k, k)]);
            excess = excess.max(thresholds[k] - diagonal);
            present[k] = is_zero.select_nonnegative(S::zero(), S::one());
            reciprocals[k] = is_zero.select_nonnegative(S::zero(), diagonal.recip());
            // From the last row on, so that the column's entries of earlier rows are not yet
            // divided.
            for i in (k + 1..rows).rev() {
                let scaled = factor[place(i, k)] * reciprocals[k];
                for j in k + 1..=i {
                    let product = scaled * factor[place(j, k)];
                    let entry = &mut factor[place(i, j)];
                    *entry = *entry - product;
                }
                factor[place(i, k)] = scaled;
            }
        }
        let lower = inverse_of_triangle(&factor, rows);
        let mut factors = Self { factor, lower, reciprocals, present, excess };
        for (i, &threshold) in thresholds.iter().enumerate() {
            factors.excess = factors.excess.max(threshold * factors.inverse_entry(i, i) - S::one());
        }
        factors
    }

    /// Returns entry (i, j) of the inverse of the matrix, where j is at most i.
    fn inverse_entry(&self, i: usize, j: usize) -> S {
        let Self { lower, reciprocals, .. } = self;
        let first = if i == j { reciprocals[i] } else { reciprocals[i] * lower[place(i, j)] };
        let terms = (i + 1..reciprocals.len())
            .map(|k| lower[place(k, i)] * reciprocals[k] * lower[place(k, j)]);
        terms.fold(first, |sum, x| sum + x)
    }

    /// Computes the inverse by columns; the rows and the columns of zero rows are zero.
    pub(super) fn inverse(&self, columns: &mut [S]) {
        let rows = self.reciprocals.len();
        for i in 0..rows {
            for j in 0..=i {
                let entry = self.inverse_entry(i, j);
                (columns[j * rows + i], columns[i * rows + j]) = (entry, entry);
            }
        }
    }

    /// Returns a number that is not negative only if no row is dependent but rows that are zero.
    pub(super) fn margin(&self) -> S {
        -self.excess
    }

    /// Returns the number of rows that are not zero.
    pub(super) fn rank(&self) -> S {
        self.present.iter().fold(S::zero(), |sum, &one| sum + one)
    }

    /// Replaces a right-hand side b by the solution x, and fills in the residual A x - b, which
    /// only zero rows have.
    pub(super) fn solve(&self, x: &mut [S], residual: &mut [S]) {
        let Self { factor, reciprocals, present, .. } = self;
        for ((residual, &present), &b) in residual.iter_mut().zip(present).zip(&*x) {
            *residual = (present - S::one()) * b;
        }
        for k in 0..x.len() {
            x[k] = (0..k).fold(x[k], |sum, j| sum - factor[place(k, j)] * x[j]);
        }
        for (x, &reciprocal) in x.iter_mut().zip(reciprocals) {
            *x = *x * reciprocal;
        }
        for k in (0..x.len()).rev() {
            x[k] = (k + 1..x.len()).fold(x[k], |sum, i| sum - factor[place(i, k)] * x[i]);
        }
    }
}

/// Returns the inverse of a triangle whose diagonal is one, of which the entries below are stored
/// by rows.
fn inverse_of_triangle<S: Scalar>(triangle: &[S], rows: usize) -> Vec<S> {
    let mut inverse = triangle.to_vec();
    for j in 0..rows {
        for i in j + 1..rows {
            let terms = (j + 1..i).map(|k| triangle[place(i, k)] * inverse[place(k, j)]);
            inverse[place(i, j)] = -terms.fold(triangle[place(i, j)], |sum, x| sum + x);
        }
    }
    inverse
}
