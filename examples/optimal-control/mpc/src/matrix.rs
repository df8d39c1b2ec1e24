//! Matrices of fixed sizes, by rows.

use modyn::Scalar;

/// A matrix by rows.
pub type Matrix<const ROWS: usize, const COLUMNS: usize> = [[f64; COLUMNS]; ROWS];

/// Adds `factor` times x to `sum`.
#[inline(always)]
pub fn add_scaled<const N: usize>(sum: &mut [f64; N], factor: f64, x: &[f64; N]) {
    for (sum, x) in sum.iter_mut().zip(x) {
        *sum = Scalar::mul_add(factor, *x, *sum);
    }
}

/// Returns the scalar product.
#[inline(always)]
#[must_use]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |sum, (a, b)| Scalar::mul_add(*a, *b, sum))
}

/// Adds a^T x to `sum`.
#[inline(always)]
pub fn add_transposed_vector<const R: usize, const C: usize>(
    sum: &mut [f64; C],
    a: &Matrix<R, C>,
    x: &[f64; R],
) {
    for (row, x) in a.iter().zip(x) {
        add_scaled(sum, *x, row);
    }
}

/// Adds `factor` a b^T to `sum`.
#[inline(always)]
pub fn add_outer<const R: usize, const C: usize>(
    sum: &mut Matrix<R, C>,
    factor: f64,
    a: &[f64; R],
    b: &[f64; C],
) {
    for (row, a) in sum.iter_mut().zip(a) {
        add_scaled(row, factor * a, b);
    }
}

/// Adds a^T b to `sum`.
#[inline(always)]
pub fn add_transposed_product<const K: usize, const R: usize, const C: usize>(
    sum: &mut Matrix<R, C>,
    a: &Matrix<K, R>,
    b: &Matrix<K, C>,
) {
    let (pairs, rest) = sum.as_chunks_mut::<2>();
    for (pair, rows) in pairs.iter_mut().enumerate() {
        add_rows(rows, 2 * pair, a, b);
    }
    if let [row] = rest {
        add_rows(core::array::from_mut(row), R - 1, a, b);
    }
}

/// Adds the rows of a^T b from row `first` on to `sum`. Two rows and a row of b fit into the registers.
#[inline(always)]
fn add_rows<const K: usize, const R: usize, const C: usize, const ROWS: usize>(
    sum: &mut Matrix<ROWS, C>,
    first: usize,
    a: &Matrix<K, R>,
    b: &Matrix<K, C>,
) {
    let mut rows = *sum;
    for (a, b) in a.iter().zip(b) {
        for (i, row) in rows.iter_mut().enumerate() {
            add_scaled(row, a[first + i], b);
        }
    }
    *sum = rows;
}

/// Returns the transposed matrix.
#[inline(always)]
#[must_use]
pub fn transposed<const R: usize, const C: usize>(a: &Matrix<R, C>) -> Matrix<C, R> {
    core::array::from_fn(|i| core::array::from_fn(|j| a[j][i]))
}

/// Copies the entries above the diagonal below it.
#[inline(always)]
pub fn mirror<const N: usize>(a: &mut Matrix<N, N>) {
    for i in 0..N {
        let (above, below) = a.split_at_mut(i + 1);
        for (offset, row) in below.iter_mut().enumerate() {
            row[i] = above[i][i + 1 + offset];
        }
    }
}
