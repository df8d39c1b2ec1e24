//! Elimination of square matrices that are not symmetric, from the last row to the first.
//!
//! The derivatives of joint forces have the zeros of the mass matrix. The elimination in this order
//! keeps them, as the elimination of the mass matrix does. There is no search for pivots, since the
//! order of operations must not depend on values.

use crate::Scalar;

/// Factorizes a matrix N of `n` columns as U L in place, with an upper triangular U and a unit
/// lower triangular L. The diagonal then has the reciprocals of the pivots.
///
/// No pivot vanishes if the symmetric part of N is positive definite.
pub(in crate::equations) fn factor_ul<S: Scalar>(matrix: &mut [S], n: usize) {
    for k in (0..n).rev() {
        let reciprocal = matrix[k * n + k].recip();
        matrix[k * n + k] = reciprocal;
        for j in 0..k {
            let factor = matrix[j * n + k] * reciprocal;
            matrix[j * n + k] = factor;
            for i in 0..k {
                matrix[j * n + i] = matrix[j * n + i] - matrix[k * n + i] * factor;
            }
        }
    }
}

/// Replaces the right-hand side `x` by the solution of N x = rhs, with the factors of
/// [`factor_ul`].
pub(in crate::equations) fn solve_ul<S: Scalar>(factors: &[S], x: &mut [S]) {
    let n = x.len();
    for k in (0..n).rev() {
        x[k] = x[k] * factors[k * n + k];
        for i in 0..k {
            x[i] = x[i] - factors[k * n + i] * x[k];
        }
    }
    for k in 0..n {
        for j in 0..k {
            x[k] = x[k] - factors[j * n + k] * x[j];
        }
    }
}
