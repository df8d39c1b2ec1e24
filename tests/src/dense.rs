//! Dense matrices for tests.

use modyn_runtime::equations::paper::Dense;
use nalgebra::DMatrix;

/// Returns a square matrix from its numbers by columns.
///
/// # Panics
///
/// Panics if the number of entries is not a square.
#[must_use]
pub fn square(columns: &[f64]) -> DMatrix<f64> {
    let n = columns.len().isqrt();
    assert_eq!(n * n, columns.len(), "a square matrix");
    DMatrix::from_column_slice(n, n, columns)
}

/// Returns one of the DeNOC matrices.
#[must_use]
pub fn dense(matrix: &Dense<f64>) -> DMatrix<f64> {
    DMatrix::from_row_slice(matrix.rows, matrix.columns, &matrix.entries)
}

/// Returns the entries of an identity matrix.
#[must_use]
pub fn identity(n: usize) -> Vec<f64> {
    DMatrix::<f64>::identity(n, n).as_slice().to_vec()
}

/// Returns the product of a matrix (by columns) and a vector.
#[must_use]
pub fn times(columns: &[f64], x: &[f64]) -> Vec<f64> {
    let mut product = vec![0.0; x.len()];
    for (column, x) in columns.chunks(product.len().max(1)).zip(x) {
        product.iter_mut().zip(column).for_each(|(sum, a)| *sum += a * x);
    }
    product
}

/// Returns the scalar product.
#[must_use]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
