//! Dense symmetric blocks: V Delta V^T by reverse Gaussian elimination, and solving with it.

use crate::Scalar;

/// Splits a block by rows as V Delta V^T in place: V above the diagonal, Delta's reciprocals aside.
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

/// x := V^-1 x, backwards; `v(row, column)` is V above its diagonal.
pub(in crate::equations) fn solve_upper<S: Scalar>(v: impl Fn(usize, usize) -> S, x: &mut [S]) {
    for a in (0..x.len()).rev() {
        for b in 0..a {
            x[b] = x[b] - v(b, a) * x[a];
        }
    }
}

/// x := V^-T x, forwards.
pub(in crate::equations) fn solve_lower<S: Scalar>(v: impl Fn(usize, usize) -> S, x: &mut [S]) {
    for a in 0..x.len() {
        for b in 0..a {
            x[a] = x[a] - v(b, a) * x[b];
        }
    }
}
