//! The factorization of the mass matrix from its entries, block by block.

use super::blocks::{factor_udu, solve_lower, solve_upper};
use super::layout::UduLayout;
use super::limb_coupling::FactorLayout;
use super::partition::factor;
use crate::Scalar;

/// Fills `factors` with D, the factors of its blocks, and U, from the mass matrix by columns:
/// (16)-(45). The matrix is overwritten. The elimination uses its sparsity pattern, and no other
/// structure.
pub fn factorize_matrix<S: Scalar, L: FactorLayout<S>>(
    limbs: &L,
    matrix: &mut [S],
    pivots: &mut [S],
    factors: &mut [S],
) {
    let layout = limbs.layout();
    let n = layout.n();
    for (m, block) in layout.blocks().iter().enumerate().rev() {
        let start = block.dofs.start;
        let size = block.dofs.len();
        for (row, entries) in factors[layout.d(m)].chunks_mut(size.max(1)).enumerate() {
            for (column, entry) in entries.iter_mut().enumerate() {
                *entry = matrix[(start + column) * n + start + row];
            }
        }
        pivots[layout.d(m)].copy_from_slice(&factors[layout.d(m)]);
        let reciprocals = layout.reciprocals();
        let range = reciprocals.start + start..reciprocals.start + start + size;
        factor_udu(&mut pivots[layout.d(m)], size, &mut factors[range.clone()]);
        store_v(layout, m, pivots, factors);
        let v = factor(block, pivots);
        for (dof, row) in layout.rows(m) {
            let row = layout.u().start + row;
            for j in 0..size {
                factors[row + j] = matrix[(start + j) * n + dof];
            }
            let (before, after) = factors.split_at_mut(row);
            let entries = &mut after[..size];
            solve_upper(v, entries);
            for (entry, &reciprocal) in entries.iter_mut().zip(&before[range.clone()]) {
                *entry = *entry * reciprocal;
            }
            solve_lower(v, entries);
        }
        for (a, row) in layout.rows(m) {
            let row = &factors[layout.u().start + row..][..size];
            for &b in layout.ancestors(m).iter().filter(|&&b| b <= a) {
                let taken = (0..size).map(|j| row[j] * matrix[(start + j) * n + b]);
                if let Some(taken) = taken.reduce(|sum, x| sum + x) {
                    let count = limbs.summed_limbs(m, a).min(limbs.summed_limbs(m, b));
                    let taken = limbs.sum_limbs(taken, count);
                    let left = matrix[a * n + b] - taken;
                    (matrix[a * n + b], matrix[b * n + a]) = (left, left);
                }
            }
        }
    }
}

/// Stores V of a factorized pivot block in `factors`.
pub(super) fn store_v<S: Scalar>(layout: &UduLayout, m: usize, pivots: &[S], factors: &mut [S]) {
    let block = &layout.blocks()[m];
    let v = factor(block, pivots);
    let mut entries = factors[layout.v_start(m)..].iter_mut();
    for column in 0..block.dofs.len() {
        for (row, entry) in (0..column).zip(&mut entries) {
            *entry = v(row, column);
        }
    }
}
