//! Solving with the factors of the mass matrix; the factors and the inverse as full matrices.

use core::ops::Range;

use super::blocks::{solve_lower, solve_upper};
use super::layout::UduLayout;
use super::limb_coupling::{FactorLayout, Limb};
use crate::{Scalar, jacobi};

/// Replaces x by I_hat^-1 x for module `m`.
fn solve_block<S: Scalar>(layout: &UduLayout, factors: &[S], m: usize, x: &mut [S]) {
    let v = layout.v(m, factors);
    let reciprocals = &factors[layout.reciprocals()][layout.blocks()[m].dofs.clone()];
    solve_upper(v, x);
    for (x, &reciprocal) in x.iter_mut().zip(reciprocals) {
        *x = *x * reciprocal;
    }
    solve_lower(v, x);
}

/// Replaces the right-hand side `x` by the solution of M x = rhs, in the three steps of (60).
///
/// Where limbs are merged, the right-hand side has a lane for each limb.
pub fn solve<S: Scalar, L: FactorLayout<S>>(layout: &L, factors: &[S], x: &mut [S]) {
    solve_for(layout, factors, None, x);
}

/// Replaces `x`, a right-hand side that is a column of degree of freedom `column`, by the solution.
///
/// Where limbs are merged, the column of a limb stands for one column of each limb, which is zero
/// on the other limbs. The rows of other limbs are not computed: see
/// [`cross_limb`](super::limb_coupling::cross_limb).
pub fn solve_column<S: Scalar, L: FactorLayout<S>>(
    layout: &L,
    factors: &[S],
    column: usize,
    x: &mut [S],
) {
    solve_for(layout, factors, layout.limb_of_dof(column), x);
}

fn solve_for<S: Scalar, L: FactorLayout<S>>(
    limbs: &L,
    factors: &[S],
    own_limb: Option<Limb>,
    x: &mut [S],
) {
    let layout = limbs.layout();
    let u = &factors[layout.u()];
    let others = |m: usize| {
        own_limb.is_some() && limbs.limb_of_module(m).is_some_and(|limb| own_limb != Some(limb))
    };
    for m in (0..layout.blocks().len()).rev().filter(|&m| !others(m)) {
        subtract_module(limbs, u, m, own_limb.is_none(), x);
    }
    for (m, block) in layout.blocks().iter().enumerate().filter(|(m, _)| !others(*m)) {
        solve_block(layout, factors, m, &mut x[block.dofs.clone()]);
        for (dof, row) in layout.rows(m) {
            for (j, i) in block.dofs.clone().enumerate() {
                x[i] = x[i] - u[row + j] * x[dof];
            }
        }
    }
}

/// Subtracts U's column of module `m` times the module's entries of `x`. If `summed`, `x` has a
/// lane for each limb, and the limbs' shares are summed where they reach the trunk.
fn subtract_module<S: Scalar, L: FactorLayout<S>>(
    limbs: &L,
    u: &[S],
    m: usize,
    summed: bool,
    x: &mut [S],
) {
    let layout = limbs.layout();
    for (dof, row) in layout.rows(m) {
        let over = if summed { limbs.summed_limbs(m, dof) } else { 1 };
        let dofs = layout.blocks()[m].dofs.clone();
        let shares = dofs.enumerate().map(|(j, i)| u[row + j] * x[i]);
        x[dof] = if over == 1 {
            shares.fold(x[dof], |x, share| x - share)
        } else {
            let sum = shares.fold(S::zero(), |sum, x| sum + x);
            x[dof] - limbs.sum_limbs(sum, over)
        };
    }
}

/// Replaces the joint vector x by W^-1 x, with M = W Delta W^T and the unit upper triangular W = U
/// V: the first half of [`solve`].
pub(in crate::equations) fn solve_upper_factor<S: Scalar, L: FactorLayout<S>>(
    limbs: &L,
    factors: &[S],
    x: &mut [S],
) {
    let layout = limbs.layout();
    for m in (0..layout.blocks().len()).rev() {
        subtract_module(limbs, &factors[layout.u()], m, true, x);
        solve_upper(layout.v(m, factors), &mut x[layout.blocks()[m].dofs.clone()]);
    }
}

/// Replaces x, which is zero outside of these modules, by W^-1 x. Expects that the modules include
/// each module that U couples to one of them. Where limbs are merged, x stands for a vector of each
/// limb, which is zero on the other limbs.
pub(in crate::equations) fn solve_upper_within<S: Scalar, L: FactorLayout<S>>(
    limbs: &L,
    factors: &[S],
    modules: impl DoubleEndedIterator<Item = usize>,
    x: &mut [S],
) {
    let layout = limbs.layout();
    for m in modules.rev() {
        subtract_module(limbs, &factors[layout.u()], m, false, x);
        solve_upper(layout.v(m, factors), &mut x[layout.blocks()[m].dofs.clone()]);
    }
}

/// Replaces x by W^-T x: the second half of [`solve`].
pub(in crate::equations) fn solve_lower_factor<S: Scalar>(
    layout: &UduLayout,
    factors: &[S],
    x: &mut [S],
) {
    solve_lower_within(layout, factors, 0..layout.blocks().len(), x);
}

/// The part of [`solve_lower_factor`] for the entries of these modules, ascending. Expects the
/// entries of the modules before them, which U couples to them, to be results.
pub(in crate::equations) fn solve_lower_within<S: Scalar>(
    layout: &UduLayout,
    factors: &[S],
    modules: impl Iterator<Item = usize>,
    x: &mut [S],
) {
    let u = &factors[layout.u()];
    for m in modules {
        let dofs = &layout.blocks()[m].dofs;
        solve_lower(layout.v(m, factors), &mut x[dofs.clone()]);
        for (dof, row) in layout.rows(m) {
            for (j, i) in dofs.clone().enumerate() {
                x[i] = x[i] - u[row + j] * x[dof];
            }
        }
    }
}

/// Computes D as a full matrix by columns, (45).
pub fn diagonal<S: Scalar>(layout: &UduLayout, factors: &[S], columns: &mut [S]) {
    let n = layout.n();
    columns.fill(S::zero());
    for block in layout.blocks() {
        let size = block.dofs.len();
        for (j, column) in block.dofs.clone().enumerate() {
            for (i, row) in block.dofs.clone().enumerate() {
                columns[column * n + row] = factors[block.pivot + i * size + j];
            }
        }
    }
}

/// Computes D^-1 as a full matrix by columns, (54).
pub fn diagonal_inverse<S: Scalar>(layout: &UduLayout, factors: &[S], columns: &mut [S]) {
    let n = layout.n();
    columns.fill(S::zero());
    for (m, block) in layout.blocks().iter().enumerate() {
        for column in block.dofs.clone() {
            columns[column * n + column] = S::one();
            let rows = column * n + block.dofs.start..column * n + block.dofs.end;
            solve_block(layout, factors, m, &mut columns[rows]);
        }
        symmetrize(n, block.dofs.clone(), columns);
    }
}

/// Copies the entries above the diagonal of these rows and columns to those below it.
fn symmetrize<S: Scalar>(n: usize, range: Range<usize>, columns: &mut [S]) {
    for column in range.clone() {
        for row in range.start..column {
            columns[row * n + column] = columns[column * n + row];
        }
    }
}

/// Computes U as a full matrix by columns, (43).
pub fn upper<S: Scalar>(layout: &UduLayout, u: &[S], columns: &mut [S]) {
    let n = layout.n();
    unit_upper(layout, u, columns, |columns, column, dof, entry| {
        columns[column * n + dof] = entry;
    });
}

/// Computes U^-1 as a full matrix by columns, (53)-(54): each block column of U is propagated
/// through the block columns of the preceding modules.
pub fn upper_inverse<S: Scalar>(layout: &UduLayout, u: &[S], columns: &mut [S]) {
    let n = layout.n();
    // Column `column` of U^-1 is e minus the sum of U's entries times the preceding columns of
    // U^-1. (With mimic joints U^-1 has more nonzero entries than U.)
    unit_upper(layout, u, columns, |columns, column, dof, factor| {
        for above in 0..=dof {
            let entry = columns[dof * n + above];
            columns[column * n + above] = columns[column * n + above] - factor * entry;
        }
    });
}

/// Computes a unit upper triangular matrix by columns, in the order of the modules: the identity,
/// then `include(columns, column, dof, entry)` for each entry of U beside its diagonal.
fn unit_upper<S: Scalar>(
    layout: &UduLayout,
    u: &[S],
    columns: &mut [S],
    include: impl Fn(&mut [S], usize, usize, S),
) {
    columns.fill(S::zero());
    for (m, block) in layout.blocks().iter().enumerate() {
        for (j, column) in block.dofs.clone().enumerate() {
            columns[column * layout.n() + column] = S::one();
            for (dof, row) in layout.rows(m) {
                include(columns, column, dof, u[row + j]);
            }
        }
    }
}

/// Computes the inverse of the mass matrix as a full matrix by columns, (50): U^-T D^-1 U^-1,
/// applied to each column of the identity.
pub fn inverse<S: Scalar, L: FactorLayout<S>>(layout: &L, factors: &[S], columns: &mut [S]) {
    let n = layout.layout().n();
    columns.fill(S::zero());
    for (j, column) in columns.chunks_mut(n.max(1)).enumerate() {
        column[j] = S::one();
        solve_column(layout, factors, j, column);
    }
    symmetrize(n, 0..n, columns);
}

/// Returns the natural logarithm of the mass matrix's determinant. It is the logarithm of det D,
/// since det U = 1.
pub fn log_determinant<S: Scalar>(layout: &UduLayout, factors: &[S]) -> S {
    let reciprocals = &factors[layout.reciprocals()];
    -reciprocals.iter().fold(S::zero(), |sum, reciprocal| sum + reciprocal.ln())
}

/// Returns the condition number of module `m`'s pivot block, in the 2-norm.
pub fn condition_number<S: Scalar>(layout: &UduLayout, factors: &[S], m: usize) -> S {
    let mut block = factors[layout.d(m)].to_vec();
    jacobi::condition_number(&mut block, layout.blocks()[m].dofs.len())
}
