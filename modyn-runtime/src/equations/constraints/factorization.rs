//! The pseudo-inverse of J M^-1 J^T by a rank-revealing factorization, without a branch on a value.
//!
//! The symmetric matrix A is factorized as P Delta P^T, constraint by constraint. In each step the row
//! of the constraint with the largest remaining diagonal becomes the pivot: it exchanges its place with
//! the next row. Selections between numbers exchange the two rows, so that no index depends on a value.
//! The pivot's column divided by its diagonal becomes a column of P, and its outer product is subtracted
//! from the matrix. A pivot at or below its threshold leaves a column of zeros: its row depends on
//! earlier rows. In the order of the pivots P is lower triangular with a diagonal of ones. The columns
//! of P are well conditioned for any Delta. With the Gram matrix G = P^T P the pseudo-inverse is
//! (Courrieu 2005, "Fast computation of Moore-Penrose inverse matrices")
//!
//! ```text
//! A^+ = P G^-1 Delta^-1 G^-1 P^T
//! ```
//!
//! The pseudo-inverse does not depend on which of several dependent rows became pivots. The
//! multipliers have the smallest norm. The residuals of contradictory rows have the smallest sum of
//! squares.

use alloc::{vec, vec::Vec};
use core::cmp::Ordering;
use core::ops::Range;

use super::lanes::packed;
use crate::Scalar;
use crate::mechanism::BodyTree;

/// The rows of one constraint, and the number of pivots that are searched for among them.
#[derive(Clone, Debug)]
struct RowBlock {
    rows: Range<usize>,
    pivots: usize,
}

/// Two rows that change places where `larger` is not negative.
#[derive(Clone, Copy, Debug)]
struct Exchange<S> {
    rows: [usize; 2],
    larger: S,
}

impl<S: Scalar> Exchange<S> {
    /// Returns the numbers of the two rows, exchanged where the rows change places.
    fn apply(&self, [a, b]: [S; 2]) -> [S; 2] {
        [self.larger.select_nonnegative(b, a), self.larger.select_nonnegative(a, b)]
    }

    /// Exchanges the entries of a vector with an entry for each row.
    fn in_vector(&self, vector: &mut [S]) {
        let [a, b] = self.rows;
        [vector[a], vector[b]] = self.apply([vector[a], vector[b]]);
    }

    /// Exchanges the rows and the columns of a symmetric matrix of `count` rows, of which the lower triangle is stored.
    fn in_matrix(&self, matrix: &mut [S], count: usize) {
        let [a, b] = self.rows;
        for i in (0..count).filter(|&i| i != a && i != b) {
            let [at_a, at_b] = [place(a, i), place(b, i)];
            [matrix[at_a], matrix[at_b]] = self.apply([matrix[at_a], matrix[at_b]]);
        }
        let [at_a, at_b] = [place(a, a), place(b, b)];
        [matrix[at_a], matrix[at_b]] = self.apply([matrix[at_a], matrix[at_b]]);
    }
}

/// The factorization P Delta P^T of a symmetric matrix of constraint rows.
#[derive(Clone, Debug)]
pub(super) struct RankFactorization<S> {
    blocks: Vec<RowBlock>,
    rows: usize,
    /// The lower triangle of A, reduced by each step's outer product; then P below the diagonal, whose column of a pivot is
    /// that of the pivot's row. Row k has k + 1 entries, from `row_start(k)` on.
    matrix: Vec<S>,
    /// For each row, the remaining diagonal at or below which the row is dependent.
    thresholds: Vec<S>,
    /// The rows of one constraint that are not zero for all inputs.
    moving: Vec<usize>,
    /// The exchanges of rows, in their order.
    exchanges: Vec<Exchange<S>>,
    /// For each pivot, its row after all exchanges, ascending.
    pivots: Vec<usize>,
    /// For each pivot, 1 / Delta; zero for a dependent pivot.
    reciprocals: Vec<S>,
    /// For each pivot, one if it is independent, else zero.
    independent: Vec<S>,
    /// The lower triangle of G, then its factor L below the diagonal.
    gram: Vec<S>,
    /// The reciprocals of the pivots of G; zero for a dependent pivot.
    gram_reciprocals: Vec<S>,
    /// The right-hand side for each pivot.
    reduced: Vec<S>,
    /// G^-1 P^T by columns; each column has an entry for each pivot.
    expansion: Vec<S>,
    /// The lower triangle of A^+.
    inverse: Vec<S>,
}

/// Returns the index of the first entry of row `k` in a lower triangle.
fn row_start(k: usize) -> usize {
    k * (k + 1) / 2
}

/// Returns the index of an entry of a symmetric matrix in its lower triangle.
fn place(i: usize, j: usize) -> usize {
    row_start(i.max(j)) + i.min(j)
}

impl<S: Scalar> RankFactorization<S> {
    /// Returns an empty factorization. Each constraint is a pair: its number of rows, and an upper
    /// bound of its rank.
    pub(super) fn new(constraints: impl Iterator<Item = (usize, usize)>) -> Self {
        let mut rows = 0;
        let blocks = constraints.map(|(count, most)| {
            let block = RowBlock { rows: rows..rows + count, pivots: count.min(most) };
            rows = block.rows.end;
            block
        });
        let blocks: Vec<RowBlock> = blocks.collect();
        let pivots = blocks.iter().map(|block| block.pivots).sum();
        let numbers = |count| vec![S::zero(); count];
        Self {
            blocks,
            rows,
            matrix: numbers(row_start(rows)),
            thresholds: numbers(rows),
            moving: Vec::with_capacity(rows),
            exchanges: Vec::with_capacity(pivots * rows),
            pivots: Vec::with_capacity(pivots),
            reciprocals: Vec::with_capacity(pivots),
            independent: Vec::with_capacity(pivots),
            gram: numbers(row_start(pivots)),
            gram_reciprocals: numbers(pivots),
            reduced: numbers(pivots),
            expansion: numbers(rows * pivots),
            inverse: numbers(row_start(rows)),
        }
    }

    /// Sets the entries of A: `entry(i, j)` returns the entry of row `i` and column `j`.
    pub(super) fn fill(&mut self, entry: impl Fn(usize, usize) -> S) {
        for i in 0..self.rows {
            for j in 0..=i {
                self.matrix[place(i, j)] = entry(i, j);
            }
        }
    }

    /// Factorizes A. A row is dependent where its remaining diagonal is at most the sum of two terms:
    /// `tolerance` times the entry of `scales` for its constraint, and `rounding` times the row's
    /// diagonal in A.
    pub(super) fn factorize(&mut self, scales: &[S], tolerance: S, rounding: S) {
        for (block, &scale) in self.blocks.iter().zip(scales) {
            for k in block.rows.clone() {
                self.thresholds[k] = tolerance * scale + rounding * self.matrix[place(k, k)];
            }
        }
        self.exchanges.clear();
        self.pivots.clear();
        self.reciprocals.clear();
        self.independent.clear();
        for b in 0..self.blocks.len() {
            let RowBlock { rows, pivots } = self.blocks[b].clone();
            // A row whose diagonal is zero for all inputs is zero: A has no negative eigenvalue.
            let is_zero = |k: &usize| self.matrix[place(*k, *k)].is_constant_zero();
            let mut moving = core::mem::take(&mut self.moving);
            moving.clear();
            moving.extend(rows.filter(|k| !is_zero(k)));
            for k in 0..pivots.min(moving.len()) {
                self.eliminate_largest(moving[k], &moving[k + 1..]);
            }
            self.moving = moving;
        }
        self.reduced.resize(self.pivots.len(), S::zero());
        self.factorize_gram();
    }

    /// Performs one step: the row with the largest margin over its threshold, of `pivot` and these others, becomes the
    /// pivot in the place of `pivot`.
    fn eliminate_largest(&mut self, pivot: usize, others: &[usize]) {
        let margin = |own: &Self, k: usize| own.matrix[place(k, k)] - own.thresholds[k];
        let mut largest = margin(self, pivot);
        for &k in others {
            let own = margin(self, k);
            let larger = own - largest;
            largest = larger.select_nonnegative(own, largest);
            let exchange = Exchange { rows: [pivot, k], larger };
            exchange.in_matrix(&mut self.matrix, self.rows);
            exchange.in_vector(&mut self.thresholds);
            self.exchanges.push(exchange);
        }
        let (dependent, diagonal) = (-largest, self.matrix[place(pivot, pivot)]);
        let reciprocal = dependent.select_nonnegative(S::one(), diagonal).recip();
        let reciprocal = dependent.select_nonnegative(S::zero(), reciprocal);
        self.pivots.push(pivot);
        self.reciprocals.push(reciprocal);
        self.independent.push(dependent.select_nonnegative(S::zero(), S::one()));
        // From the last row on, so that the column's entries of earlier rows are not yet divided.
        for i in (pivot + 1..self.rows).rev() {
            let scaled = self.matrix[place(i, pivot)] * reciprocal;
            for j in pivot + 1..=i {
                let product = scaled * self.matrix[place(j, pivot)];
                let entry = &mut self.matrix[place(i, j)];
                *entry = *entry - product;
            }
            self.matrix[place(i, pivot)] = scaled;
        }
    }

    /// Factorizes G as L D L^T. The reciprocal of a dependent pivot is zero, so that solutions do not have it.
    fn factorize_gram(&mut self) {
        let Self { rows, matrix, pivots, gram, gram_reciprocals, independent, .. } = self;
        // The entries of a pivot's column below row `below`.
        let column = |pivot: usize, below: usize| {
            let matrix = &*matrix;
            (below + 1..*rows).map(move |i| matrix[place(i, pivot)])
        };
        for (k, &pivot) in pivots.iter().enumerate() {
            let (before, own) = gram.split_at_mut(row_start(k));
            for (entry, &other) in own.iter_mut().zip(&pivots[..k]) {
                let products = column(pivot, pivot).zip(column(other, pivot)).map(|(a, b)| a * b);
                *entry = products.fold(matrix[place(pivot, other)], |sum, x| sum + x);
            }
            let mut diagonal = column(pivot, pivot).fold(S::one(), |sum, x| sum + x * x);
            for l in 0..k {
                own[l] = own[l] - dot(&own[..l], &before[row_start(l)..][..l]);
            }
            for (entry, &reciprocal) in own[..k].iter_mut().zip(&*gram_reciprocals) {
                let scaled = *entry * reciprocal;
                diagonal = diagonal - *entry * scaled;
                *entry = scaled;
            }
            let dependent = -independent[k];
            let diagonal = dependent.select_nonnegative(S::one(), diagonal);
            gram_reciprocals[k] = independent[k] * diagonal.recip();
        }
    }

    /// Returns an entry of the matrix, which is not yet factorized.
    pub(super) fn entry(&self, i: usize, j: usize) -> S {
        self.matrix[place(i, j)]
    }

    /// Returns the trace of the matrix, which is not yet factorized.
    pub(super) fn trace(&self) -> S {
        (0..self.rows).fold(S::zero(), |sum, k| sum + self.entry(k, k))
    }

    /// Returns the number of independent rows.
    pub(super) fn rank(&self) -> S {
        self.independent.iter().fold(S::zero(), |sum, &one| sum + one)
    }

    /// Computes A^+ by columns: H^T Delta^-1 H with H = G^-1 P^T, `tree.column_lanes()` columns at a time.
    pub(super) fn inverse<T: BodyTree<S>>(&mut self, tree: &T, columns: &mut [S]) {
        let (rows, pivots, count) = (self.rows, self.pivots.len(), tree.column_lanes());
        let group = |r: usize| {
            let first = r - r % count;
            first..rows.min(first + count)
        };
        for first in (0..rows).step_by(count) {
            for (k, &pivot) in self.pivots.iter().enumerate() {
                let entry = |r: usize| match r.cmp(&pivot) {
                    Ordering::Less => S::zero(),
                    Ordering::Equal => S::one(),
                    Ordering::Greater => self.matrix[place(r, pivot)],
                };
                self.reduced[k] = packed(tree, group(first), entry);
            }
            self.solve_gram();
            self.expansion[first * pivots..][..pivots].copy_from_slice(&self.reduced);
        }
        // The columns of a group of rows are stored as that of its first row.
        let packs = |r: usize| &self.expansion[(r - r % count) * pivots..][..pivots];
        for i in 0..rows {
            let own = packs(i).iter().zip(&self.reciprocals);
            let own = own.map(|(&h, &reciprocal)| tree.extract_lane(h, i % count) * reciprocal);
            self.reduced.iter_mut().zip(own).for_each(|(x, h)| *x = h);
            for j in (0..=i).step_by(count) {
                let entries = dot(packs(j), &self.reduced);
                for (lane, j) in group(j).enumerate().filter(|&(_, j)| j <= i) {
                    self.inverse[place(i, j)] = tree.extract_lane(entries, lane);
                }
            }
        }
        for exchange in self.exchanges.iter().rev() {
            exchange.in_matrix(&mut self.inverse, rows);
        }
        for j in 0..rows {
            for i in 0..rows {
                columns[j * rows + i] = self.inverse[place(i, j)];
            }
        }
    }

    /// Replaces the right-hand sides b by the multipliers A^+ b, and fills in the residuals A A^+ b - b.
    /// Where the rows do not contradict each other, the residuals are zero within rounding.
    pub(super) fn solve(&mut self, right_hand_sides: &mut [S], residuals: &mut [S]) {
        for exchange in &self.exchanges {
            exchange.in_vector(right_hand_sides);
        }
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
        for exchange in self.exchanges.iter().rev() {
            exchange.in_vector(right_hand_sides);
            exchange.in_vector(residuals);
        }
    }

    /// Computes G^-1 P^T b into `reduced`.
    fn reduce(&mut self, b: &[S]) {
        for (x, &pivot) in self.reduced.iter_mut().zip(&self.pivots) {
            let below = pivot + 1..self.rows;
            *x = below.fold(b[pivot], |sum, i| sum + self.matrix[place(i, pivot)] * b[i]);
        }
        self.solve_gram();
    }

    /// Replaces `reduced` by G^-1 times `reduced`, zero for dependent pivots.
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
        for (&x, &pivot) in self.reduced.iter().zip(&self.pivots) {
            sum[pivot] = sum[pivot] + x;
            for (i, sum) in sum.iter_mut().enumerate().skip(pivot + 1) {
                *sum = *sum + self.matrix[place(i, pivot)] * x;
            }
        }
    }
}

fn dot<S: Scalar>(a: &[S], b: &[S]) -> S {
    a.iter().zip(b).map(|(&a, &b)| a * b).reduce(|sum, x| sum + x).unwrap_or(S::zero())
}
