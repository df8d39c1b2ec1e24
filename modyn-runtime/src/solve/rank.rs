//! The pseudo-inverse of a matrix of constraint rows by a rank-revealing factorization, without a
//! branch on a value.
//!
//! The symmetric matrix A is factorized as P Delta P^T. In each step the row with the largest
//! remaining diagonal, of all rows of all constraints, becomes the pivot: it exchanges its place
//! with the next row. Diagonals are compared relative to the scales of their constraints. A row
//! that is small after some rows, such as the row along a stretched leg, is therefore a pivot only
//! if no later row makes it redundant, and the pivots do not depend on the order of the
//! constraints. Selections between numbers exchange the two rows, so that no index depends on a
//! value. The pivot's column divided by its diagonal becomes a column of P, and its outer product
//! is subtracted from the matrix. A pivot at or below its threshold leaves a column of zeros: its
//! row depends on earlier rows. In the order of the pivots P is lower triangular with a diagonal of
//! ones. The columns of P are well conditioned for any Delta. With the Gram matrix G = P^T P the
//! pseudo-inverse is (Courrieu 2005, "Fast computation of Moore-Penrose inverse matrices")
//!
//! ```text
//! A^+ = P G^-1 Delta^-1 G^-1 P^T
//! ```
//!
//! The pseudo-inverse does not depend on which of several dependent rows became pivots. The
//! multipliers have the smallest norm. The residuals of contradictory rows have the smallest sum of
//! squares.
//!
//! The memory is lists of the caller: arrays of generated code ([`RowEquations`]), or vectors of a
//! robot that is known at run time.

use crate::scalar::{Chunk, Scalar};

/// Two rows that change places where `larger` is not negative.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Exchange<S> {
    rows: [usize; 2],
    larger: S,
}

impl<S: Scalar> Exchange<S> {
    /// Returns no exchange.
    pub(crate) fn none() -> Self {
        Self { rows: [0, 0], larger: -S::one() }
    }

    /// Returns the numbers of the two rows, exchanged where the rows change places.
    #[inline(always)]
    fn apply(&self, [a, b]: [S; 2]) -> [S; 2] {
        [self.larger.select_nonnegative(b, a), self.larger.select_nonnegative(a, b)]
    }

    /// Exchanges the entries of a vector with an entry for each row.
    #[inline(always)]
    fn in_vector(&self, vector: &mut [S]) {
        let [a, b] = self.rows;
        [vector[a], vector[b]] = self.apply([vector[a], vector[b]]);
    }

    /// Exchanges the rows and the columns of a symmetric matrix of `count` rows, of which the lower
    /// triangle is stored.
    #[inline(always)]
    pub(crate) fn in_matrix(&self, matrix: &mut [S], count: usize) {
        let [a, b] = self.rows;
        for i in (0..count).filter(|&i| i != a && i != b) {
            let [at_a, at_b] = [place(a, i), place(b, i)];
            [matrix[at_a], matrix[at_b]] = self.apply([matrix[at_a], matrix[at_b]]);
        }
        let [at_a, at_b] = [place(a, a), place(b, b)];
        [matrix[at_a], matrix[at_b]] = self.apply([matrix[at_a], matrix[at_b]]);
    }
}

/// The rows and the exchanges of a factorization that exist.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Counts {
    /// The number of pivots.
    pub pivots: usize,
    /// The number of exchanges.
    pub exchanges: usize,
}

/// The factorization P Delta P^T of a symmetric matrix of constraint rows. Unless they are
/// triangles, lists have an entry for each row.
#[derive(Debug)]
pub(crate) struct RankFactorization<'a, S> {
    /// For each constraint the number of its rows, and an upper bound of the number of its pivots.
    pub blocks: &'a [(usize, usize)],
    /// The lower triangle of A, reduced by each step's outer product; then P below the diagonal,
    /// where a pivot's column belongs to the pivot's row. Row k has k + 1 entries, from
    /// `row_start(k)` on.
    pub matrix: &'a mut [S],
    /// For each row, the remaining diagonal at or below which the row is dependent.
    pub thresholds: &'a mut [S],
    /// For each row, the reciprocal of its constraint's scale; one if there is one constraint.
    pub units: &'a mut [S],
    /// The rows that are not zero for all inputs.
    pub moving: &'a mut [usize],
    /// The exchanges of rows, in their order: as many as a triangle has entries at most.
    pub exchanges: &'a mut [Exchange<S>],
    /// For each pivot, its row after all exchanges, ascending.
    pub pivots: &'a mut [usize],
    /// For each pivot, 1 / Delta; zero for a dependent pivot.
    pub reciprocals: &'a mut [S],
    /// For each pivot, one if it is independent, else zero.
    pub independent: &'a mut [S],
    /// The lower triangle of G, then its factor L below the diagonal.
    pub gram: &'a mut [S],
    /// The reciprocals of the pivots of G; zero for a dependent pivot.
    pub gram_reciprocals: &'a mut [S],
    /// The right-hand side for each pivot.
    pub reduced: &'a mut [S],
    /// The numbers of pivots and exchanges.
    pub counts: &'a mut Counts,
}

/// Returns the index of the first entry of row `k` in a lower triangle.
#[inline(always)]
pub(crate) fn row_start(k: usize) -> usize {
    k * (k + 1) / 2
}

/// Returns the index of an entry of a symmetric matrix in its lower triangle.
#[inline(always)]
pub(crate) fn place(i: usize, j: usize) -> usize {
    row_start(i.max(j)) + i.min(j)
}

impl<S: Scalar> RankFactorization<'_, S> {
    /// Returns the number of rows.
    #[inline(always)]
    fn rows(&self) -> usize {
        self.thresholds.len()
    }

    /// Sets the thresholds: `tolerance` times the entry of `scales` for the row's constraint, plus
    /// `rounding` times the row's diagonal in A.
    #[inline(always)]
    pub(crate) fn set_thresholds(&mut self, scales: &[S], tolerance: S, rounding: S) {
        let mut first = 0;
        for (&(rows, _), &scale) in self.blocks.iter().zip(scales) {
            let unit = if self.blocks.len() == 1 { S::one() } else { reciprocal(scale) };
            for k in first..first + rows {
                self.thresholds[k] = tolerance * scale + rounding * self.matrix[place(k, k)];
                self.units[k] = unit;
            }
            first += rows;
        }
    }

    /// Factorizes A. A row is dependent where its remaining diagonal is at most its threshold.
    #[inline(always)]
    pub(crate) fn factorize(&mut self) {
        *self.counts = Counts::default();
        // A row whose diagonal is zero for all inputs is zero: A has no negative eigenvalue.
        let mut count = 0;
        for k in 0..self.rows() {
            if !self.matrix[place(k, k)].is_constant_zero() {
                self.moving[count] = k;
                count += 1;
            }
        }
        let pivots: usize = self.blocks.iter().map(|(_, pivots)| pivots).sum();
        for k in 0..pivots.min(count) {
            self.eliminate_largest(k, count);
        }
        self.factorize_gram();
    }

    /// Returns by how much a row's diagonal exceeds its threshold, relative to its constraint's
    /// scale.
    #[inline(always)]
    fn margin(&self, row: usize) -> S {
        (self.matrix[place(row, row)] - self.thresholds[row]) * self.units[row]
    }

    /// Performs one step: the row with the largest [`margin`](Self::margin) of the moving rows from
    /// `k` to `end` becomes the pivot in the place of row `k`.
    #[inline(always)]
    fn eliminate_largest(&mut self, k: usize, end: usize) {
        let rows = self.rows();
        let pivot = self.moving[k];
        let mut largest = self.margin(pivot);
        for other in k + 1..end {
            let row = self.moving[other];
            let margin = self.margin(row);
            let larger = margin - largest;
            largest = larger.select_nonnegative(margin, largest);
            let exchange = Exchange { rows: [pivot, row], larger };
            exchange.in_matrix(self.matrix, rows);
            exchange.in_vector(self.thresholds);
            exchange.in_vector(self.units);
            self.exchanges[self.counts.exchanges] = exchange;
            self.counts.exchanges += 1;
        }
        let dependent = -largest;
        let diagonal = self.matrix[place(pivot, pivot)];
        let divisor = dependent.select_nonnegative(S::one(), diagonal);
        let reciprocal = dependent.select_nonnegative(S::zero(), divisor.recip());
        let count = self.counts.pivots;
        self.pivots[count] = pivot;
        self.reciprocals[count] = reciprocal;
        self.independent[count] = dependent.select_nonnegative(S::zero(), S::one());
        self.counts.pivots += 1;
        // From the last row on, so that the column's entries of earlier rows are not yet divided.
        for i in (pivot + 1..rows).rev() {
            let scaled = self.matrix[place(i, pivot)] * reciprocal;
            for j in pivot + 1..=i {
                let product = scaled * self.matrix[place(j, pivot)];
                let entry = &mut self.matrix[place(i, j)];
                *entry = *entry - product;
            }
            self.matrix[place(i, pivot)] = scaled;
        }
    }

    /// Factorizes G as L D L^T. The reciprocal of a dependent pivot is zero, so that solutions do
    /// not have it.
    #[inline(always)]
    fn factorize_gram(&mut self) {
        let rows = self.rows();
        let pivots = &self.pivots[..self.counts.pivots];
        let Self { matrix, gram, gram_reciprocals, independent, .. } = self;
        // The entries of a pivot's column below row `below`.
        let column = |pivot: usize, below: usize| {
            let matrix = &*matrix;
            (below + 1..rows).map(move |i| matrix[place(i, pivot)])
        };
        for (k, &pivot) in pivots.iter().enumerate() {
            let (before, row) = gram.split_at_mut(row_start(k));
            for (entry, &other) in row.iter_mut().zip(&pivots[..k]) {
                let products = column(pivot, pivot).zip(column(other, pivot)).map(|(a, b)| a * b);
                *entry = products.fold(matrix[place(pivot, other)], |sum, x| sum + x);
            }
            let mut diagonal = column(pivot, pivot).fold(S::one(), |sum, x| sum + x * x);
            for l in 0..k {
                row[l] = row[l] - dot(&row[..l], &before[row_start(l)..][..l]);
            }
            for (entry, &reciprocal) in row[..k].iter_mut().zip(&**gram_reciprocals) {
                let scaled = *entry * reciprocal;
                diagonal = diagonal - *entry * scaled;
                *entry = scaled;
            }
            let dependent = -independent[k];
            let diagonal = dependent.select_nonnegative(S::one(), diagonal);
            gram_reciprocals[k] = independent[k] * diagonal.recip();
        }
    }

    /// Returns the number of independent rows.
    #[inline(always)]
    pub(crate) fn rank(&self) -> S {
        let independent = &self.independent[..self.counts.pivots];
        independent.iter().fold(S::zero(), |sum, &one| sum + one)
    }

    /// Replaces the right-hand sides b by the multipliers A^+ b, and fills in the residuals A A^+
    /// b - b. Where the rows do not contradict each other, the residuals are zero within rounding.
    #[inline(always)]
    pub(crate) fn solve(&mut self, right_hand_sides: &mut [S], residuals: &mut [S]) {
        let Counts { pivots, exchanges } = *self.counts;
        for exchange in &self.exchanges[..exchanges] {
            exchange.in_vector(right_hand_sides);
        }
        self.reduce(right_hand_sides);
        for (residual, &b) in residuals.iter_mut().zip(&*right_hand_sides) {
            *residual = -b;
        }
        self.expand(residuals, |_, sum, term| sum + term);
        for (x, &reciprocal) in self.reduced[..pivots].iter_mut().zip(&*self.reciprocals) {
            *x = *x * reciprocal;
        }
        self.solve_gram();
        self.set_expanded(right_hand_sides);
        for exchange in self.exchanges[..exchanges].iter().rev() {
            exchange.in_vector(right_hand_sides);
            exchange.in_vector(residuals);
        }
    }

    /// Computes G^-1 P^T b into `reduced`.
    #[inline(always)]
    fn reduce(&mut self, b: &[S]) {
        for (x, &pivot) in self.reduced.iter_mut().zip(&self.pivots[..self.counts.pivots]) {
            let below = pivot + 1..self.thresholds.len();
            *x = below.fold(b[pivot], |sum, i| sum + self.matrix[place(i, pivot)] * b[i]);
        }
        self.solve_gram();
    }

    /// Replaces `reduced` by G^-1 times `reduced`, zero for dependent pivots.
    #[inline(always)]
    pub(crate) fn solve_gram(&mut self) {
        let Self { gram, gram_reciprocals, reduced, counts, .. } = self;
        let reduced = &mut reduced[..counts.pivots];
        for k in 0..reduced.len() {
            reduced[k] = reduced[k] - dot(&reduced[..k], &gram[row_start(k)..][..k]);
        }
        for (x, &reciprocal) in reduced.iter_mut().zip(&**gram_reciprocals) {
            *x = *x * reciprocal;
        }
        for k in (0..reduced.len()).rev() {
            let (before, from_k) = reduced.split_at_mut(k);
            for (x, &entry) in before.iter_mut().zip(&gram[row_start(k)..]) {
                *x = *x - entry * from_k[0];
            }
        }
    }

    /// Sets `product` to P times `reduced`. The first term of a sum is not added to zero, which
    /// would change the sign of a negative zero: a graph has no such sum.
    #[inline(always)]
    fn set_expanded(&self, product: &mut [S]) {
        product.fill(S::zero());
        self.expand(product, |k, sum, term| if k == 0 { term } else { sum + term });
    }

    /// Adds P times `reduced` to `sum`. `add` gets the number of the pivot, the sum and the term.
    #[inline(always)]
    fn expand(&self, sum: &mut [S], add: impl Fn(usize, S, S) -> S) {
        let pivots = &self.pivots[..self.counts.pivots];
        for (k, (&x, &pivot)) in self.reduced.iter().zip(pivots).enumerate() {
            sum[pivot] = add(k, sum[pivot], x);
            for (i, sum) in sum.iter_mut().enumerate().skip(pivot + 1) {
                *sum = add(k, *sum, self.matrix[place(i, pivot)] * x);
            }
        }
    }
}

/// Returns 1 / x of a number that is not negative; zero for zero.
#[inline(always)]
fn reciprocal<S: Scalar>(x: S) -> S {
    let is_zero = -x;
    let reciprocal = is_zero.select_nonnegative(S::one(), x).recip();
    is_zero.select_nonnegative(S::zero(), reciprocal)
}

#[inline(always)]
pub(crate) fn dot<S: Scalar>(a: &[S], b: &[S]) -> S {
    a.iter().zip(b).map(|(&a, &b)| a * b).reduce(|sum, x| sum + x).unwrap_or(S::zero())
}

/// The equations A x = b of `N` constraint rows, for each of `B` right-hand sides b. A is
/// symmetric, has no negative eigenvalue, and `T` entries in its lower triangle.
#[derive(Clone, Copy, Debug)]
pub struct RowEquations<S, const N: usize, const T: usize, const C: usize, const B: usize> {
    /// For each of the `C` constraints, the number of its rows.
    pub blocks: [usize; C],
    /// The lower triangle of A, by rows.
    pub matrix: [S; T],
    /// The right-hand sides.
    pub sides: [[S; N]; B],
    /// For each constraint, the scale of its thresholds.
    pub scales: [S; C],
    /// A row is dependent where its remaining diagonal is at most the first of these times its
    /// constraint's scale, plus the second times its diagonal in A.
    pub tolerances: [S; 2],
}

/// The solutions of [`RowEquations`].
#[derive(Clone, Copy, Debug)]
pub struct RowSolutions<S, const N: usize, const B: usize> {
    /// x = A^+ b, for each right-hand side.
    pub solutions: [[S; N]; B],
    /// A x - b, for each right-hand side.
    pub residuals: [[S; N]; B],
    /// The number of independent rows.
    pub rank: S,
}

impl<S: Scalar, const N: usize, const B: usize> RowSolutions<S, N, B> {
    /// Returns zeros.
    #[must_use]
    #[inline(always)]
    pub fn zero() -> Self {
        let zero = S::zero();
        Self { solutions: [[zero; N]; B], residuals: [[zero; N]; B], rank: zero }
    }
}

impl<S: Scalar, const N: usize, const T: usize, const C: usize, const B: usize> Chunk
    for RowEquations<S, N, T, C, B>
{
    type Output = RowSolutions<S, N, B>;

    #[inline(always)]
    fn run(mut self) -> Self::Output {
        let zero = S::zero();
        let mut counts = Counts::default();
        let mut numbers = [[zero; N]; 6];
        let [thresholds, units, reciprocals, independent, gram_reciprocals, reduced] = &mut numbers;
        let mut factorization = RankFactorization {
            blocks: &self.blocks.map(|rows| (rows, rows)),
            matrix: &mut self.matrix,
            thresholds,
            units,
            moving: &mut [0; N],
            exchanges: &mut [Exchange::none(); T],
            pivots: &mut [0; N],
            reciprocals,
            independent,
            gram: &mut [zero; T],
            gram_reciprocals,
            reduced,
            counts: &mut counts,
        };
        let [tolerance, rounding] = self.tolerances;
        factorization.set_thresholds(&self.scales, tolerance, rounding);
        factorization.factorize();
        let mut result = RowSolutions { solutions: self.sides, ..RowSolutions::zero() };
        for (x, residual) in result.solutions.iter_mut().zip(&mut result.residuals) {
            factorization.solve(x, residual);
        }
        result.rank = factorization.rank();
        result
    }
}

impl<S: Scalar, const N: usize, const T: usize, const C: usize, const B: usize>
    RowEquations<S, N, T, C, B>
{
    /// Returns the solutions. The code is not a part of the caller's.
    #[must_use]
    #[cold]
    #[inline(never)]
    pub fn solve(self) -> RowSolutions<S, N, B> {
        self.run()
    }
}
