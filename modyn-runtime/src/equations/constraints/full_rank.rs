//! The factorization of J M^-1 J^T where all rows are independent.
//!
//! L D L^T in the order of the rows, without exchanges. A row that is zero, such as that of an inactive contact, is left out.
//! Whether the pivoted factorization would find a dependent row is known from this one. Before a constraint's rows are
//! eliminated, their block of the matrix is S, in any order of the constraints' own rows. The remaining diagonal of row i is least
//! if all other rows of its constraint are eliminated before it: then it is 1 / (S^-1)_ii. So all rows are independent where
//! each of these numbers is above its row's threshold.

use alloc::{vec, vec::Vec};

use crate::Scalar;
use crate::solve::place;

/// The factors of a symmetric matrix whose rows are independent or zero.
#[derive(Clone, Debug)]
pub(super) struct FullRank<S> {
    /// L below the diagonal, in the lower triangle by rows.
    factor: Vec<S>,
    /// The reciprocals of D; zero for a zero row.
    reciprocals: Vec<S>,
    /// For each row one, or zero if the row is zero.
    present: Vec<S>,
    /// The largest of numbers that are negative for independent rows.
    excess: S,
}

impl<S: Scalar> FullRank<S> {
    /// Factorizes a matrix, of which the lower triangle is stored by rows. `blocks` are the numbers of rows of the constraints.
    pub(super) fn new(matrix: &[S], thresholds: &[S], blocks: &[usize]) -> Self {
        let rows = thresholds.len();
        let (mut factor, zeros) = (matrix.to_vec(), vec![S::zero(); rows]);
        let (mut reciprocals, mut present) = (zeros.clone(), zeros);
        let mut excess = -S::one();
        for k in (0..rows).filter(|&k| !matrix[place(k, k)].is_constant_zero()) {
            let is_zero = -matrix[place(k, k)];
            let diagonal = is_zero.select_nonnegative(S::one(), factor[place(k, k)]);
            excess = excess.max(thresholds[k] - diagonal);
            present[k] = is_zero.select_nonnegative(S::zero(), S::one());
            reciprocals[k] = is_zero.select_nonnegative(S::zero(), diagonal.recip());
            // From the last row on, so that the column's entries of earlier rows are not yet divided.
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
        let mut own = Self { factor, reciprocals, present, excess };
        let mut end = 0;
        for rows in blocks {
            end += rows;
            for (i, &threshold) in thresholds.iter().enumerate().take(end).skip(end - rows) {
                let largest = threshold * own.inverse_diagonal(i, end);
                own.excess = own.excess.max(largest - S::one());
            }
        }
        own
    }

    /// Returns entry (i, i) of the inverse of L D L^T, of the rows i to `end` alone.
    fn inverse_diagonal(&self, i: usize, end: usize) -> S {
        let mut column: Vec<S> = vec![S::one()];
        let mut sum = self.reciprocals[i];
        for k in i + 1..end {
            let known = column.iter().enumerate();
            let entry =
                -known.fold(S::zero(), |sum, (j, &x)| sum + self.factor[place(k, i + j)] * x);
            sum = sum + entry * entry * self.reciprocals[k];
            column.push(entry);
        }
        sum
    }

    /// Computes the inverse by columns; the rows and the columns of zero rows are zero.
    pub(super) fn inverse(&self, columns: &mut [S]) {
        let Self { factor, reciprocals, .. } = self;
        let rows = reciprocals.len();
        // The inverse of L, in the same triangle; its diagonal is one.
        let mut lower = factor.clone();
        for j in 0..rows {
            for i in j + 1..rows {
                let known = (j + 1..i).map(|k| factor[place(i, k)] * lower[place(k, j)]);
                lower[place(i, j)] = -known.fold(factor[place(i, j)], |sum, x| sum + x);
            }
        }
        for i in 0..rows {
            for j in 0..=i {
                let own = |k: usize| lower[place(k, i)] * reciprocals[k];
                let first =
                    if i == j { reciprocals[i] } else { reciprocals[i] * lower[place(i, j)] };
                let terms = (i + 1..rows).map(|k| own(k) * lower[place(k, j)]);
                let sum = terms.fold(first, |sum, x| sum + x);
                (columns[j * rows + i], columns[i * rows + j]) = (sum, sum);
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

    /// Replaces a right-hand side b by the solution x, and fills in the residual A x - b, which only zero rows have.
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
