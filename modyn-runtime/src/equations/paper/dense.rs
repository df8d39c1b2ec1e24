//! Dense matrices, for study.

use alloc::{vec, vec::Vec};
use core::ops::Range;

use crate::Scalar;
use crate::equations::factorization::blocks::{factor_udu, solve_lower, solve_upper};
use crate::spatial::Twist;

/// A dense matrix, stored by rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Dense<S> {
    /// The number of rows.
    pub rows: usize,
    /// The number of columns.
    pub columns: usize,
    /// The entries, row by row.
    pub entries: Vec<S>,
}

impl<S: Scalar> Dense<S> {
    /// Returns a matrix of zeros.
    #[must_use]
    pub fn zero(rows: usize, columns: usize) -> Self {
        Self { rows, columns, entries: vec![S::zero(); rows * columns] }
    }

    /// Returns the entry in row `i` and column `j`; `None` outside the matrix.
    #[must_use]
    pub fn get(&self, i: usize, j: usize) -> Option<S> {
        (j < self.columns).then(|| self.entries.get(i * self.columns + j).copied()).flatten()
    }

    /// Returns the transposed matrix.
    #[must_use]
    pub fn transposed(&self) -> Self {
        let mut transposed = Self::zero(self.columns, self.rows);
        for (i, row) in self.entries.chunks(self.columns.max(1)).enumerate() {
            for (j, &entry) in row.iter().enumerate() {
                transposed.set(j, i, entry);
            }
        }
        transposed
    }

    /// Returns the product `self` times `other`, which must have as many rows as `self` has
    /// columns.
    #[must_use]
    pub fn times(&self, other: &Self) -> Self {
        let mut product = Self::zero(self.rows, other.columns);
        let rows = product
            .entries
            .chunks_mut(other.columns.max(1))
            .zip(self.entries.chunks(self.columns.max(1)));
        for (sums, row) in rows {
            for (&factor, terms) in row.iter().zip(other.entries.chunks(other.columns.max(1))) {
                for (sum, &term) in sums.iter_mut().zip(terms) {
                    *sum = *sum + factor * term;
                }
            }
        }
        product
    }

    pub(in crate::equations) fn set(&mut self, i: usize, j: usize, value: S) {
        self.entries[i * self.columns + j] = value;
    }

    /// Writes a twist into column `j`, from row `i` on.
    pub(in crate::equations) fn set_column(&mut self, i: usize, j: usize, twist: Twist<S>) {
        for (k, entry) in twist.components().into_iter().enumerate() {
            self.set(i + k, j, entry);
        }
    }

    /// Returns the n x n identity.
    #[must_use]
    pub fn identity(n: usize) -> Self {
        let mut identity = Self::zero(n, n);
        (0..n).for_each(|i| identity.set(i, i, S::one()));
        identity
    }

    /// Returns the sum with a matrix of the same size.
    #[must_use]
    pub fn plus(&self, other: &Self) -> Self {
        self.entry_by_entry(other, |a, b| a + b)
    }

    /// Returns `self` minus a matrix of the same size.
    #[must_use]
    pub fn minus(&self, other: &Self) -> Self {
        self.entry_by_entry(other, |a, b| a - b)
    }

    fn entry_by_entry(&self, other: &Self, f: impl Fn(S, S) -> S) -> Self {
        let entries = self.entries.iter().zip(&other.entries).map(|(&a, &b)| f(a, b)).collect();
        Self { entries, ..*self }
    }

    /// Returns the submatrix of these rows and columns.
    #[must_use]
    pub fn block(&self, rows: Range<usize>, columns: Range<usize>) -> Self {
        let mut block = Self::zero(rows.len(), columns.len());
        for (i, row) in rows.enumerate() {
            for (j, column) in columns.clone().enumerate() {
                block.set(i, j, self.entries[row * self.columns + column]);
            }
        }
        block
    }

    /// Writes `block` with its first entry at row `i` and column `j`.
    pub(in crate::equations) fn set_block(&mut self, i: usize, j: usize, block: &Self) {
        for row in 0..block.rows {
            for column in 0..block.columns {
                self.set(i + row, j + column, block.entries[row * block.columns + column]);
            }
        }
    }

    /// Returns A^T `self` A.
    #[must_use]
    pub fn congruence(&self, a: &Self) -> Self {
        a.transposed().times(&self.times(a))
    }

    /// Returns the inverse of a symmetric positive definite matrix.
    pub(in crate::equations) fn symmetric_inverse(&self) -> Self {
        let n = self.rows;
        let mut v = self.entries.clone();
        let mut reciprocals = vec![S::zero(); n];
        factor_udu(&mut v, n, &mut reciprocals);
        let factor = |row: usize, column: usize| v[row * n + column];
        let mut inverse = Self::identity(n);
        // The inverse is symmetric, so its columns are rows, too.
        for x in inverse.entries.chunks_mut(n.max(1)) {
            solve_upper(factor, x);
            x.iter_mut().zip(&reciprocals).for_each(|(x, &reciprocal)| *x = *x * reciprocal);
            solve_lower(factor, x);
        }
        inverse
    }
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

    #[test]
    fn products_are_products() {
        let matrix =
            |rows, columns, entries: &[f64]| Dense { rows, columns, entries: entries.to_vec() };
        let a = matrix(2, 3, &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        let b = matrix(3, 1, &[7.0, 8.0, 9.0]);
        assert_eq!(a.times(&b), matrix(2, 1, &[50.0, 122.0]));
        assert_eq!(a.transposed(), matrix(3, 2, &[1.0, 4.0, 2.0, 5.0, 3.0, 6.0]));
        assert_eq!(a.plus(&a).minus(&a), a);
        assert_eq!(a.block(1..2, 1..3), matrix(1, 2, &[5.0, 6.0]));
        assert_eq!(a.times(&Dense::identity(3)), a);
    }

    #[test]
    fn inverses_are_inverses() {
        let entries = [4.0, 1.0, 0.5, 1.0, 3.0, 0.25, 0.5, 0.25, 2.0].to_vec();
        let matrix = Dense { rows: 3, columns: 3, entries };
        let product = matrix.times(&matrix.symmetric_inverse()).minus(&Dense::identity(3));
        assert!(product.entries.iter().all(|x: &f64| x.abs() < 1e-15), "{product:?}");
    }
}
