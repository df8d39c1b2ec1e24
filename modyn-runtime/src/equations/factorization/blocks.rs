//! Dense symmetric blocks: the factorization V Delta V^T by reverse Gaussian elimination, and its
//! triangular solves.

use crate::Scalar;

/// Factorizes a symmetric block, stored by rows, as V Delta V^T in place. V is stored above the
/// diagonal, the reciprocals of Delta in `reciprocals`.
pub(in crate::equations) fn factor_udu<S: Scalar>(v: &mut [S], size: usize, reciprocals: &mut [S]) {
    for a in (0..size).rev() {
        let reciprocal = v[a * size + a].recip();
        reciprocals[a] = reciprocal;
        for b in 0..a {
            let factor = v[b * size + a] * reciprocal;
            for c in 0..=b {
                v[c * size + b] = v[c * size + b] - factor * v[c * size + a];
            }
        }
        for b in 0..a {
            v[b * size + a] = v[b * size + a] * reciprocal;
        }
    }
}

/// Replaces x by V^-1 x (backward substitution); `v(row, column)` returns V above its diagonal.
pub(in crate::equations) fn solve_upper<S: Scalar>(v: impl Fn(usize, usize) -> S, x: &mut [S]) {
    for a in (0..x.len()).rev() {
        for b in 0..a {
            x[b] = x[b] - v(b, a) * x[a];
        }
    }
}

/// Replaces x by V^-T x (forward substitution); `v(row, column)` returns V above its diagonal.
pub(in crate::equations) fn solve_lower<S: Scalar>(v: impl Fn(usize, usize) -> S, x: &mut [S]) {
    for a in 0..x.len() {
        for b in 0..a {
            x[a] = x[a] - v(b, a) * x[b];
        }
    }
}
