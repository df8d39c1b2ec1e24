//! The pseudo-inverse of J I^-1 J^T by a rank-revealing factorization, without a branch on a value.
//!
//! The symmetric matrix A is factorized as P Delta P^T, constraint by constraint. In each step the row
//! of the constraint with the largest remaining diagonal becomes the pivot: selections between numbers
//! carry its column, so that no index depends on a value. Its column over its diagonal becomes a column
//! of P, and what the pivot explains is subtracted from the matrix. A pivot that is not above its
//! threshold leaves a column of zeros: the row depends on those before it. P has a one in each pivot's
//! own row and zeros there in later columns, so its columns are well conditioned whatever Delta is.
//! With the Gram matrix G = P^T P the pseudo-inverse is (Courrieu 2005, "Fast computation of
//! Moore-Penrose inverse matrices")
//!
//! ```text
//! A^+ = P G^-1 Delta^-1 G^-1 P^T
//! ```
//!
//! It does not depend on which of several dependent rows became pivots: multipliers are those of the
//! smallest norm, and rows that contradict each other are met with the smallest sum of squared
//! residuals.

use alloc::{vec, vec::Vec};
use core::ops::Range;

use crate::Scalar;

/// The rows of one constraint, and the columns of P that it can have.
#[derive(Clone, Debug)]
struct RowBlock {
    rows: Range<usize>,
    pivots: Range<usize>,
}

/// A symmetric matrix of constraint rows as P Delta P^T.
#[derive(Clone, Debug)]
pub(super) struct RankFactorization<S> {
    blocks: Vec<RowBlock>,
    rows: usize,
    /// The lower triangle, of which each step subtracts what its pivot explains: row k has k + 1
    /// entries from `start(k)` on.
    matrix: Vec<S>,
    /// By row: the remaining diagonal below which the row is dependent.
    thresholds: Vec<S>,
    /// P by columns, each as long as there are rows.
    columns: Vec<S>,
    /// By pivot: 1 / Delta, zero for a dependent one.
    reciprocals: Vec<S>,
    /// By pivot: one if it is independent, else zero.
    independent: Vec<S>,
    /// The lower triangle of G, then its factor L below the diagonal.
    gram: Vec<S>,
    /// The reciprocals of the pivots of G.
    gram_reciprocals: Vec<S>,
    /// Right-hand sides by pivot.
    reduced: Vec<S>,
}

/// The first entry of row `k` of a lower triangle.
fn start(k: usize) -> usize {
    k * (k + 1) / 2
}

impl<S: Scalar> RankFactorization<S> {
    /// For constraints of so many rows, of which so many at most are independent.
    pub(super) fn new(constraints: impl Iterator<Item = (usize, usize)>) -> Self {
        let (mut rows, mut pivots) = (0, 0);
        let blocks = constraints.map(|(count, most)| {
            let block =
                RowBlock { rows: rows..rows + count, pivots: pivots..pivots + count.min(most) };
            (rows, pivots) = (block.rows.end, block.pivots.end);
            block
        });
        let blocks = blocks.collect();
        let numbers = |count| vec![S::zero(); count];
        Self {
            blocks,
            rows,
            matrix: numbers(start(rows)),
            thresholds: numbers(rows),
            columns: numbers(rows * pivots),
            reciprocals: numbers(pivots),
            independent: numbers(pivots),
            gram: numbers(start(pivots)),
            gram_reciprocals: numbers(pivots),
            reduced: numbers(pivots),
        }
    }

    /// Sets the matrix: `entry` is called with row and column.
    pub(super) fn fill(&mut self, entry: impl Fn(usize, usize) -> S) {
        for i in 0..self.rows {
            for j in 0..=i {
                self.matrix[start(i) + j] = entry(i, j);
            }
        }
    }

    /// Factorizes the matrix. A row is dependent where its remaining diagonal is at most `tolerance`
    /// times its constraint's number in `scales`, plus `rounding` times its own diagonal.
    pub(super) fn factorize(&mut self, scales: &[S], tolerance: S, rounding: S) {
        for (block, &scale) in self.blocks.iter().zip(scales) {
            for k in block.rows.clone() {
                self.thresholds[k] = tolerance * scale + rounding * self.matrix[start(k) + k];
            }
        }
        self.columns.fill(S::zero());
        for b in 0..self.blocks.len() {
            let RowBlock { rows, pivots } = self.blocks[b].clone();
            for pivot in pivots {
                self.eliminate_largest(rows.clone(), pivot);
            }
        }
        self.factorize_gram();
    }

    /// One step: the row of `rows` with the largest diagonal above its threshold becomes the pivot.
    fn eliminate_largest(&mut self, rows: Range<usize>, pivot: usize) {
        let Self { matrix, thresholds, columns, .. } = self;
        let at = |matrix: &[S], i: usize, j: usize| matrix[start(i.max(j)) + i.min(j)];
        // Earlier constraints have nothing left, so the column starts at this one.
        let all = rows.start..self.rows;
        let column = &mut columns[pivot * self.rows..][..self.rows];
        let mut candidates = rows.map(|k| {
            let diagonal = at(matrix, k, k);
            (k, diagonal, diagonal - thresholds[k])
        });
        let Some((first, mut diagonal, mut margin)) = candidates.next() else { return };
        for i in all.clone() {
            column[i] = at(matrix, i, first);
        }
        for (k, own_diagonal, own_margin) in candidates {
            let larger = own_margin - margin;
            margin = larger.select_nonnegative(own_margin, margin);
            diagonal = larger.select_nonnegative(own_diagonal, diagonal);
            for i in all.clone() {
                column[i] = larger.select_nonnegative(at(matrix, i, k), column[i]);
            }
        }
        let dependent = -margin;
        let reciprocal = dependent.select_nonnegative(S::one(), diagonal).recip();
        let reciprocal = dependent.select_nonnegative(S::zero(), reciprocal);
        self.reciprocals[pivot] = reciprocal;
        self.independent[pivot] = dependent.select_nonnegative(S::zero(), S::one());
        for i in all.clone().rev() {
            let scaled = column[i] * reciprocal;
            for j in all.start..=i {
                let entry = &mut matrix[start(i) + j];
                *entry = *entry - scaled * column[j];
            }
            column[i] = scaled;
        }
    }

    /// G as L D L^T; a column of zeros has a unit pivot.
    fn factorize_gram(&mut self) {
        let Self { rows, columns, gram, gram_reciprocals, independent, .. } = self;
        let column = |k: usize| &columns[k * *rows..][..*rows];
        for k in 0..independent.len() {
            let (before, own) = gram.split_at_mut(start(k));
            for (l, entry) in own[..=k].iter_mut().enumerate() {
                *entry = dot(column(k), column(l));
            }
            for l in 0..k {
                own[l] = own[l] - dot(&own[..l], &before[start(l)..][..l]);
            }
            let mut diagonal = own[k] + (S::one() - independent[k]);
            for (entry, &reciprocal) in own[..k].iter_mut().zip(&*gram_reciprocals) {
                let scaled = *entry * reciprocal;
                diagonal = diagonal - *entry * scaled;
                *entry = scaled;
            }
            gram_reciprocals[k] = diagonal.recip();
        }
    }

    /// An entry of the matrix. Expects that it is not factorized.
    pub(super) fn entry(&self, i: usize, j: usize) -> S {
        self.matrix[start(i.max(j)) + i.min(j)]
    }

    /// The sum of the matrix's diagonal. Expects that it is not factorized.
    pub(super) fn trace(&self) -> S {
        (0..self.rows).fold(S::zero(), |sum, k| sum + self.entry(k, k))
    }

    /// The number of independent rows.
    pub(super) fn rank(&self) -> S {
        self.independent.iter().fold(S::zero(), |sum, &one| sum + one)
    }

    /// Replaces the right-hand sides b by the multipliers A^+ b, and gives the residuals A A^+ b - b:
    /// zero but for rounding where the rows do not contradict each other.
    pub(super) fn solve(&mut self, right_hand_sides: &mut [S], residuals: &mut [S]) {
        self.reduce(right_hand_sides);
        for (residual, &b) in residuals.iter_mut().zip(&*right_hand_sides) {
            *residual = -b;
        }
        self.add_expanded(residuals);
        for (x, &reciprocal) in self.reduced.iter_mut().zip(&self.reciprocals) {
            *x = *x * reciprocal;
        }
        self.solve_gram();
        right_hand_sides.fill(S::zero());
        self.add_expanded(right_hand_sides);
    }

    /// reduced := G^-1 P^T b.
    fn reduce(&mut self, b: &[S]) {
        for (x, column) in self.reduced.iter_mut().zip(self.columns.chunks(self.rows.max(1))) {
            *x = dot(column, b);
        }
        self.solve_gram();
    }

    /// reduced := G^-1 reduced.
    fn solve_gram(&mut self) {
        let Self { gram, gram_reciprocals, reduced, .. } = self;
        for k in 0..reduced.len() {
            reduced[k] = reduced[k] - dot(&reduced[..k], &gram[start(k)..][..k]);
        }
        for (x, &reciprocal) in reduced.iter_mut().zip(&*gram_reciprocals) {
            *x = *x * reciprocal;
        }
        for k in (0..reduced.len()).rev() {
            let (before, own) = reduced.split_at_mut(k);
            for (x, &entry) in before.iter_mut().zip(&gram[start(k)..]) {
                *x = *x - entry * own[0];
            }
        }
    }

    /// Adds P times `reduced`.
    fn add_expanded(&self, sum: &mut [S]) {
        for (&x, column) in self.reduced.iter().zip(self.columns.chunks(self.rows.max(1))) {
            for (sum, &entry) in sum.iter_mut().zip(column) {
                *sum = *sum + entry * x;
            }
        }
    }
}

fn dot<S: Scalar>(a: &[S], b: &[S]) -> S {
    a.iter().zip(b).map(|(&a, &b)| a * b).reduce(|sum, x| sum + x).unwrap_or(S::zero())
}
