//! The pseudo-inverse of J M^-1 J^T by a rank-revealing factorization, without a branch on a value.
//!
//! The symmetric matrix A is factorized as P Delta P^T, constraint by constraint. In each step the row
//! of the constraint with the largest remaining diagonal becomes the pivot. Selections between numbers
//! copy the pivot's column, so that no index depends on a value. The column divided by its diagonal
//! becomes a column of P, and its outer product is subtracted from the matrix. A pivot at or below its
//! threshold leaves a column of zeros: its row depends on earlier rows. P has a one in each pivot's
//! own row and zeros there in later columns. The columns of P are therefore well conditioned for any
//! Delta. With the Gram matrix G = P^T P the pseudo-inverse is (Courrieu 2005, "Fast computation of
//! Moore-Penrose inverse matrices")
//!
//! ```text
//! A^+ = P G^-1 Delta^-1 G^-1 P^T
//! ```
//!
//! The pseudo-inverse does not depend on which of several dependent rows became pivots. The
//! multipliers have the smallest norm. The residuals of contradictory rows have the smallest sum of
//! squares.

use alloc::{vec, vec::Vec};
use core::ops::Range;

use crate::Scalar;

/// The rows of one constraint, and the columns of P reserved for it.
#[derive(Clone, Debug)]
struct RowBlock {
    rows: Range<usize>,
    pivots: Range<usize>,
}

/// The factorization P Delta P^T of a symmetric matrix of constraint rows.
#[derive(Clone, Debug)]
pub(super) struct RankFactorization<S> {
    blocks: Vec<RowBlock>,
    rows: usize,
    /// The lower triangle of A, reduced by each step's outer product. Row k has k + 1 entries, from
    /// `start(k)` on.
    matrix: Vec<S>,
    /// For each row, the remaining diagonal at or below which the row is dependent.
    thresholds: Vec<S>,
    /// P by columns; each column has an entry for each row.
    columns: Vec<S>,
    /// For each pivot, 1 / Delta; zero for a dependent pivot.
    reciprocals: Vec<S>,
    /// For each pivot, one if it is independent, else zero.
    independent: Vec<S>,
    /// The lower triangle of G, then its factor L below the diagonal.
    gram: Vec<S>,
    /// The reciprocals of the pivots of G.
    gram_reciprocals: Vec<S>,
    /// The right-hand side for each pivot.
    reduced: Vec<S>,
    /// G^-1 P^T by columns; each column has an entry for each pivot.
    expansion: Vec<S>,
}

/// Returns the index of the first entry of row `k` in a lower triangle.
fn row_start(k: usize) -> usize {
    k * (k + 1) / 2
}

impl<S: Scalar> RankFactorization<S> {
    /// Returns an empty factorization. Each constraint is a pair: its number of rows, and an upper
    /// bound of its rank.
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
            matrix: numbers(row_start(rows)),
            thresholds: numbers(rows),
            columns: numbers(rows * pivots),
            reciprocals: numbers(pivots),
            independent: numbers(pivots),
            gram: numbers(row_start(pivots)),
            gram_reciprocals: numbers(pivots),
            reduced: numbers(pivots),
            expansion: numbers(rows * pivots),
        }
    }

    /// Sets the entries of A: `entry(i, j)` returns the entry of row `i` and column `j`.
    pub(super) fn fill(&mut self, entry: impl Fn(usize, usize) -> S) {
        for i in 0..self.rows {
            for j in 0..=i {
                self.matrix[row_start(i) + j] = entry(i, j);
            }
        }
    }

    /// Factorizes A. A row is dependent where its remaining diagonal is at most the sum of two terms:
    /// `tolerance` times the entry of `scales` for its constraint, and `rounding` times the row's
    /// diagonal in A.
    pub(super) fn factorize(&mut self, scales: &[S], tolerance: S, rounding: S) {
        for (block, &scale) in self.blocks.iter().zip(scales) {
            for k in block.rows.clone() {
                self.thresholds[k] = tolerance * scale + rounding * self.matrix[row_start(k) + k];
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

    /// Performs one step: the row with the largest margin over its threshold becomes the pivot.
    fn eliminate_largest(&mut self, rows: Range<usize>, pivot: usize) {
        let Self { matrix, thresholds, columns, .. } = self;
        let at = |matrix: &[S], i: usize, j: usize| matrix[row_start(i.max(j)) + i.min(j)];
        // Rows of earlier constraints are eliminated, so the column starts at this constraint.
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
                let entry = &mut matrix[row_start(i) + j];
                *entry = *entry - scaled * column[j];
            }
            column[i] = scaled;
        }
    }

    /// Factorizes G as L D L^T. A column of zeros has a unit pivot.
    fn factorize_gram(&mut self) {
        let Self { rows, columns, gram, gram_reciprocals, independent, .. } = self;
        let column = |k: usize| &columns[k * *rows..][..*rows];
        for k in 0..independent.len() {
            let (before, own) = gram.split_at_mut(row_start(k));
            for (l, entry) in own[..=k].iter_mut().enumerate() {
                *entry = dot(column(k), column(l));
            }
            for l in 0..k {
                own[l] = own[l] - dot(&own[..l], &before[row_start(l)..][..l]);
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

    /// Returns an entry of the matrix, which is not yet factorized.
    pub(super) fn entry(&self, i: usize, j: usize) -> S {
        self.matrix[row_start(i.max(j)) + i.min(j)]
    }

    /// Returns the trace of the matrix, which is not yet factorized.
    pub(super) fn trace(&self) -> S {
        (0..self.rows).fold(S::zero(), |sum, k| sum + self.entry(k, k))
    }

    /// Returns the number of independent rows.
    pub(super) fn rank(&self) -> S {
        self.independent.iter().fold(S::zero(), |sum, &one| sum + one)
    }

    /// Computes A^+ by columns: H^T Delta^-1 H with H = G^-1 P^T.
    pub(super) fn inverse(&mut self, columns: &mut [S]) {
        let (rows, pivots) = (self.rows, self.reduced.len());
        // Column r of H.
        for r in 0..rows {
            for k in 0..pivots {
                self.reduced[k] = self.columns[k * rows + r];
            }
            self.solve_gram();
            self.expansion[r * pivots..][..pivots].copy_from_slice(&self.reduced);
        }
        let column = |r: usize| &self.expansion[r * pivots..][..pivots];
        for j in 0..rows {
            let scaled = column(j).iter().zip(&self.reciprocals);
            self.reduced
                .iter_mut()
                .zip(scaled)
                .for_each(|(x, (&h, &reciprocal))| *x = h * reciprocal);
            for i in 0..=j {
                let entry = dot(column(i), &self.reduced);
                (columns[j * rows + i], columns[i * rows + j]) = (entry, entry);
            }
        }
    }

    /// Replaces the right-hand sides b by the multipliers A^+ b, and fills in the residuals A A^+ b - b.
    /// Where the rows do not contradict each other, the residuals are zero within rounding.
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

    /// Computes G^-1 P^T b into `reduced`.
    fn reduce(&mut self, b: &[S]) {
        for (x, column) in self.reduced.iter_mut().zip(self.columns.chunks(self.rows.max(1))) {
            *x = dot(column, b);
        }
        self.solve_gram();
    }

    /// Replaces `reduced` by G^-1 times `reduced`.
    fn solve_gram(&mut self) {
        let Self { gram, gram_reciprocals, reduced, .. } = self;
        for k in 0..reduced.len() {
            reduced[k] = reduced[k] - dot(&reduced[..k], &gram[row_start(k)..][..k]);
        }
        for (x, &reciprocal) in reduced.iter_mut().zip(&*gram_reciprocals) {
            *x = *x * reciprocal;
        }
        for k in (0..reduced.len()).rev() {
            let (before, own) = reduced.split_at_mut(k);
            for (x, &entry) in before.iter_mut().zip(&gram[row_start(k)..]) {
                *x = *x - entry * own[0];
            }
        }
    }

    /// Adds P times `reduced` to `sum`.
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
