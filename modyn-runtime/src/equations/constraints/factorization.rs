//! The factorization of J M^-1 J^T, and its pseudo-inverse.

use alloc::{vec, vec::Vec};
use core::cmp::Ordering;

use super::full_rank::FullRank;
use super::lanes::packed;
use crate::Scalar;
use crate::mechanism::BodyTree;
use crate::solve::{Counts, Exchange, RankFactorization, dot, place, row_start};

/// The factorization of a symmetric matrix of constraint rows.
#[derive(Clone, Debug)]
pub(super) struct Factorization<S> {
    /// For each constraint the number of its rows, and an upper bound of its rank.
    blocks: Vec<(usize, usize)>,
    /// The lower triangle of the matrix, by rows; then of its factor.
    matrix: Vec<S>,
    /// The memory of a [`RankFactorization`]: lists with an entry for each row, and triangles.
    thresholds: Vec<S>,
    units: Vec<S>,
    moving: Vec<usize>,
    exchanges: Vec<Exchange<S>>,
    pivots: Vec<usize>,
    reciprocals: Vec<S>,
    independent: Vec<S>,
    gram: Vec<S>,
    gram_reciprocals: Vec<S>,
    reduced: Vec<S>,
    counts: Counts,
    /// G^-1 P^T by columns; each column has an entry for each pivot.
    expansion: Vec<S>,
    /// The lower triangle of A^+.
    inverse: Vec<S>,
    /// The solution where rows may be dependent, if it is computed elsewhere.
    apart: Option<Apart<S>>,
}

/// The equations A x = b of constraint rows, for one or more right-hand sides b.
#[derive(Clone, Debug)]
pub struct RowSystem<S> {
    /// For each constraint, the number of its rows.
    pub blocks: Vec<usize>,
    /// The lower triangle of A, by rows.
    pub matrix: Vec<S>,
    /// The right-hand sides, one after the other.
    pub sides: Vec<S>,
    /// For each constraint, the scale of its thresholds.
    pub scales: Vec<S>,
    /// A row is dependent where its remaining diagonal is at most the first of these times its
    /// constraint's scale, plus the second times its diagonal in A.
    pub tolerances: [S; 2],
}

impl<S: Scalar> RowSystem<S> {
    /// Returns x = A^+ b for each right-hand side, then A x - b for each, then the rank of A.
    #[must_use]
    pub fn solve(&self) -> Vec<S> {
        let mut factorization = Factorization::new(self.blocks.iter().map(|&rows| (rows, rows)));
        factorization.matrix.copy_from_slice(&self.matrix);
        let [tolerance, rounding] = self.tolerances;
        factorization.factorize(&self.scales, tolerance, rounding);
        let mut x = self.sides.clone();
        let mut residuals = self.sides.clone();
        let rows = self.blocks.iter().sum::<usize>().max(1);
        for (x, residual) in x.chunks_mut(rows).zip(residuals.chunks_mut(rows)) {
            factorization.solve(x, residual);
        }
        x.into_iter().chain(residuals).chain([factorization.rank()]).collect()
    }
}

/// A solution that counts where rows may be dependent, and is computed elsewhere.
#[derive(Clone, Debug)]
struct Apart<S> {
    /// The results of [`RowSystem::solve`].
    given: Vec<S>,
    /// The equations.
    system: RowSystem<S>,
    /// The factors where all rows are independent.
    full: FullRank<S>,
}

impl<S: Scalar> Apart<S> {
    /// Adds a right-hand side, and returns the index of its first number.
    fn add_side(&mut self, side: &[S]) -> usize {
        self.system.sides.extend_from_slice(side);
        self.system.sides.len() - side.len()
    }

    /// Replaces numbers by given ones where rows may be dependent.
    fn choose(&self, numbers: &mut [S], given: &[S]) {
        for (x, &given) in numbers.iter_mut().zip(given) {
            *x = self.full.margin().select_nonnegative(*x, given);
        }
    }
}

impl<S: Scalar> Factorization<S> {
    /// Returns an empty factorization. Each constraint is a pair: its number of rows, and an upper
    /// bound of its rank.
    pub(super) fn new(constraints: impl Iterator<Item = (usize, usize)>) -> Self {
        let blocks: Vec<_> = constraints.map(|(rows, most)| (rows, rows.min(most))).collect();
        let rows = blocks.iter().map(|(rows, _)| rows).sum();
        let pivots: usize = blocks.iter().map(|(_, pivots)| pivots).sum();
        let numbers = |count| vec![S::zero(); count];
        Self {
            blocks,
            matrix: numbers(row_start(rows)),
            thresholds: numbers(rows),
            units: numbers(rows),
            moving: vec![0; rows],
            exchanges: vec![Exchange::none(); row_start(rows)],
            pivots: vec![0; rows],
            reciprocals: numbers(rows),
            independent: numbers(rows),
            gram: numbers(row_start(rows)),
            gram_reciprocals: numbers(rows),
            reduced: numbers(rows),
            counts: Counts::default(),
            expansion: numbers(rows * pivots),
            inverse: numbers(row_start(rows)),
            apart: None,
        }
    }

    /// Returns the rank-revealing factorization in this memory.
    fn by_rank(&mut self) -> RankFactorization<'_, S> {
        RankFactorization {
            blocks: &self.blocks,
            matrix: &mut self.matrix,
            thresholds: &mut self.thresholds,
            units: &mut self.units,
            moving: &mut self.moving,
            exchanges: &mut self.exchanges,
            pivots: &mut self.pivots,
            reciprocals: &mut self.reciprocals,
            independent: &mut self.independent,
            gram: &mut self.gram,
            gram_reciprocals: &mut self.gram_reciprocals,
            reduced: &mut self.reduced,
            counts: &mut self.counts,
        }
    }

    /// Sets the entries of A: `entry(i, j)` returns the entry of row `i` and column `j`.
    pub(super) fn fill(&mut self, entry: impl Fn(usize, usize) -> S) {
        for i in 0..self.thresholds.len() {
            for j in 0..=i {
                self.matrix[place(i, j)] = entry(i, j);
            }
        }
    }

    /// Returns an entry of the matrix, which is not yet factorized.
    pub(super) fn entry(&self, i: usize, j: usize) -> S {
        self.matrix[place(i, j)]
    }

    /// Returns the trace of the matrix, which is not yet factorized.
    pub(super) fn trace(&self) -> S {
        (0..self.thresholds.len()).fold(S::zero(), |sum, k| sum + self.entry(k, k))
    }

    /// Factorizes A. A row is dependent where its remaining diagonal is at most the sum of two
    /// terms: `tolerance` times the entry of `scales` for its constraint, and `rounding` times the
    /// row's diagonal in A.
    pub(super) fn factorize(&mut self, scales: &[S], tolerance: S, rounding: S) {
        self.by_rank().set_thresholds(scales, tolerance, rounding);
        match &mut self.apart {
            None => self.by_rank().factorize(),
            Some(apart) => {
                apart.full = FullRank::new(&self.matrix, &self.thresholds);
                apart.system.matrix.clone_from(&self.matrix);
                apart.system.sides.clear();
                apart.system.scales = scales.to_vec();
                apart.system.tolerances = [tolerance, rounding];
            }
        }
    }

    /// Replaces the right-hand sides b by the multipliers A^+ b, and fills in the residuals A A^+
    /// b - b. Where the rows do not contradict each other, the residuals are zero within rounding.
    pub(super) fn solve(&mut self, right_hand_sides: &mut [S], residuals: &mut [S]) {
        let Some(apart) = &mut self.apart else {
            return self.by_rank().solve(right_hand_sides, residuals);
        };
        let first = apart.add_side(right_hand_sides);
        apart.full.solve(right_hand_sides, residuals);
        let (solutions, rest) = apart.given.split_at(apart.given.len() / 2);
        apart.choose(right_hand_sides, &solutions[first..]);
        apart.choose(residuals, &rest[first..]);
    }

    /// Returns the number of independent rows.
    pub(super) fn rank(&mut self) -> S {
        match &self.apart {
            None => self.by_rank().rank(),
            Some(Apart { given, full, .. }) => {
                full.margin().select_nonnegative(full.rank(), given[given.len() - 1])
            }
        }
    }

    /// Makes the solutions where rows may be dependent these numbers, in place of a rank-revealing
    /// factorization. They are the results of [`RowSystem::solve`], of which there is an odd
    /// number.
    pub(super) fn set_apart(&mut self, given: Vec<S>) {
        let system = RowSystem {
            blocks: self.blocks.iter().map(|&(rows, _)| rows).collect(),
            matrix: Vec::new(),
            sides: Vec::new(),
            scales: Vec::new(),
            tolerances: [S::zero(); 2],
        };
        self.apart = Some(Apart { given, system, full: FullRank::new(&[], &[]) });
    }

    /// Returns the equations whose solution is computed elsewhere, and a number that is not
    /// negative only if that solution does not count. `None` if some rows are dependent in all
    /// states.
    pub(super) fn system_apart(&mut self) -> Option<(RowSystem<S>, S)> {
        let Apart { system, full, .. } = self.apart.take()?;
        let mut diagonal = (0..self.thresholds.len()).map(|k| self.matrix[place(k, k)]);
        let is_dependent = diagonal.any(S::is_constant_zero)
            || self.blocks.iter().any(|(rows, pivots)| pivots < rows);
        (!is_dependent).then(|| (system, full.margin()))
    }

    /// Computes A^+ by columns: H^T Delta^-1 H with H = G^-1 P^T, `tree.column_lanes()` columns at
    /// a time.
    pub(super) fn inverse<T: BodyTree<S>>(&mut self, tree: &T, columns: &mut [S]) {
        if let Some(apart) = &mut self.apart {
            apart.full.inverse(columns);
            for (j, column) in columns.chunks_mut(self.thresholds.len().max(1)).enumerate() {
                let unit = |i| if i == j { S::one() } else { S::zero() };
                let side: Vec<S> = (0..column.len()).map(unit).collect();
                let first = apart.add_side(&side);
                apart.choose(column, &apart.given[first..]);
            }
            return;
        }
        let rows = self.thresholds.len();
        let pivots = self.counts.pivots;
        let count = tree.column_lanes();
        let group = |r: usize| {
            let first = r - r % count;
            first..rows.min(first + count)
        };
        for first in (0..rows).step_by(count) {
            for (k, &pivot) in self.pivots[..pivots].iter().enumerate() {
                let entry = |r: usize| match r.cmp(&pivot) {
                    Ordering::Less => S::zero(),
                    Ordering::Equal => S::one(),
                    Ordering::Greater => self.matrix[place(r, pivot)],
                };
                self.reduced[k] = packed(tree, group(first), entry);
            }
            self.by_rank().solve_gram();
            self.expansion[first * pivots..][..pivots].copy_from_slice(&self.reduced[..pivots]);
        }
        // The columns of a group of rows are stored as the column of its first row.
        let packs = |r: usize| &self.expansion[(r - r % count) * pivots..][..pivots];
        for i in 0..rows {
            let packs_of_row = packs(i).iter().zip(&self.reciprocals);
            let scaled =
                packs_of_row.map(|(&h, &reciprocal)| tree.extract_lane(h, i % count) * reciprocal);
            self.reduced.iter_mut().zip(scaled).for_each(|(x, h)| *x = h);
            for j in (0..=i).step_by(count) {
                let entries = dot(packs(j), &self.reduced);
                for (lane, j) in group(j).enumerate().filter(|&(_, j)| j <= i) {
                    self.inverse[place(i, j)] = tree.extract_lane(entries, lane);
                }
            }
        }
        for exchange in self.exchanges[..self.counts.exchanges].iter().rev() {
            exchange.in_matrix(&mut self.inverse, rows);
        }
        for j in 0..rows {
            for i in 0..rows {
                columns[j * rows + i] = self.inverse[place(i, j)];
            }
        }
    }
}
