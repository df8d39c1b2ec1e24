//! The paper's numerical solvers of I qdd = phi, on any scalar: GE-N and RGE-N of Sect. 6.
//!
//! Both eliminate without pivoting, and substitute one term after the other.

use modyn_runtime::Scalar;

/// Gaussian elimination, then back substitution. `matrix` by columns; it is symmetric.
#[must_use]
pub fn gaussian<S: Scalar>(matrix: &[S], phi: &[S]) -> Vec<S> {
    let n = phi.len();
    let (mut a, mut x) = (matrix.to_vec(), phi.to_vec());
    for k in 0..n {
        for i in k + 1..n {
            let factor = a[k * n + i] / a[k * n + k];
            for j in k + 1..n {
                a[j * n + i] = a[j * n + i] - factor * a[j * n + k];
            }
            x[i] = x[i] - factor * x[k];
        }
    }
    for i in (0..n).rev() {
        for j in i + 1..n {
            x[i] = x[i] - a[j * n + i] * x[j];
        }
        x[i] = x[i] / a[i * n + i];
    }
    x
}

/// Reverse Gaussian elimination, from the last column on, then forward substitution.
#[must_use]
pub fn reverse_gaussian<S: Scalar>(matrix: &[S], phi: &[S]) -> Vec<S> {
    let reversed = |x: &[S]| x.iter().rev().copied().collect::<Vec<_>>();
    // The same elimination with all indices reversed.
    reversed(&gaussian(&reversed(matrix), &reversed(phi)))
}

/// The Euclidean norm.
#[must_use]
pub fn norm(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// The condition number in the 2-norm of a symmetric positive definite matrix.
#[must_use]
pub fn condition_number(matrix: &[f64]) -> f64 {
    modyn_runtime::jacobi::condition_number(&mut matrix.to_vec(), matrix.len().isqrt())
}

#[cfg(test)]
mod tests {
    use super::{condition_number, gaussian, reverse_gaussian};

    #[test]
    fn both_ways_solve() {
        let matrix = [4.0, 1.0, 0.5, 1.0, 3.0, 0.2, 0.5, 0.2, 2.0];
        let x = [1.0, -2.0, 3.0];
        let phi: Vec<f64> =
            (0..3).map(|i| (0..3).map(|j| matrix[j * 3 + i] * x[j]).sum()).collect();
        for found in [gaussian(&matrix, &phi), reverse_gaussian(&matrix, &phi)] {
            assert!(found.iter().zip(x).all(|(found, x)| (found - x).abs() < 1e-14), "{found:?}");
        }
        assert!((condition_number(&[2.0, 0.0, 0.0, 5.0]) - 2.5).abs() < 1e-14);
    }
}
