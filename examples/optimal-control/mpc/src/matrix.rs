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

/// Adjacent entries of a row, which fit into a vector register.
#[derive(Clone, Copy)]
#[repr(align(32))]
struct Lanes([f64; LANES]);

const LANES: usize = 4;
/// The most vectors of a row of a product.
const MOST: usize = 16;

impl Lanes {
    const ZERO: Self = Self([0.0; LANES]);

    /// Returns vector `i` of a row, with zeros beyond the row's end.
    #[inline(always)]
    fn load<const C: usize>(row: &[f64; C], i: usize) -> Self {
        let (whole, rest) = row.as_chunks();
        if let Some(whole) = whole.get(i) {
            return Self(*whole);
        }
        Self(core::array::from_fn(|lane| if lane < C % LANES { rest[lane] } else { 0.0 }))
    }

    /// Adds the lanes to vector `i` of a row.
    #[inline(always)]
    fn add_to<const C: usize>(self, row: &mut [f64; C], i: usize) {
        let (whole, rest) = row.as_chunks_mut();
        if let Some(whole) = whole.get_mut(i) {
            add_scaled(whole, 1.0, &self.0);
            return;
        }
        for (x, lane) in rest.iter_mut().zip(self.0) {
            *x += lane;
        }
    }

    #[inline(always)]
    fn mul_add(self, factor: f64, mut sum: Self) -> Self {
        add_scaled(&mut sum.0, factor, &self.0);
        sum
    }
}

/// The rows of a product that are summed at once: as many as the vector registers hold.
const fn rows_at_once(columns: usize) -> usize {
    if cfg!(target_feature = "avx") && columns <= 12 { 4 } else { 2 }
}

/// Adds a^T b to `sum`.
///
/// Not inlined, and with loops over any number of rows: a step of the recursion has a dozen products, which would not fit
/// into the instruction cache.
#[inline(never)]
pub fn add_transposed_product<const R: usize, const C: usize>(
    sum: &mut Matrix<R, C>,
    a: &[[f64; R]],
    b: &[[f64; C]],
) {
    let mut first = 0;
    if rows_at_once(C) == 4 {
        let (groups, _) = sum.as_chunks_mut::<4>();
        for rows in groups {
            add_rows(rows, first, a, b);
            first += 4;
        }
    }
    let (pairs, rest) = sum[first..].as_chunks_mut::<2>();
    for rows in pairs {
        add_rows(rows, first, a, b);
        first += 2;
    }
    if let [row] = rest {
        add_rows(core::array::from_mut(row), first, a, b);
    }
}

/// Adds the rows of a^T b from row `first` on to `sum`.
#[inline(always)]
#[expect(clippy::needless_range_loop, reason = "with iterators, LLVM's code is slower")]
fn add_rows<const R: usize, const C: usize, const ROWS: usize>(
    sum: &mut Matrix<ROWS, C>,
    first: usize,
    a: &[[f64; R]],
    b: &[[f64; C]],
) {
    const { assert!(C <= MOST * LANES, "the rows are too long") };
    // Vectors that end at the ends of the rows: an array of the entries makes LLVM form vectors across rows.
    let mut rows = [[Lanes::ZERO; MOST]; ROWS];
    for (a, b) in a.iter().zip(b) {
        for w in 0..C.div_ceil(LANES) {
            let b = Lanes::load(b, w);
            for i in 0..ROWS {
                rows[i][w] = b.mul_add(a[first + i], rows[i][w]);
            }
        }
    }
    for (sum, row) in sum.iter_mut().zip(&rows) {
        for w in 0..C.div_ceil(LANES) {
            row[w].add_to(sum, w);
        }
    }
}

/// Returns the transposed matrix.
#[inline(never)]
#[must_use]
pub fn transposed<const R: usize, const C: usize>(a: &Matrix<R, C>) -> Matrix<C, R> {
    core::array::from_fn(|i| core::array::from_fn(|j| a[j][i]))
}

/// Copies the entries above the diagonal below it.
#[inline(never)]
pub fn mirror<const N: usize>(a: &mut Matrix<N, N>) {
    for i in 0..N {
        let (above, below) = a.split_at_mut(i + 1);
        for (offset, row) in below.iter_mut().enumerate() {
            row[i] = above[i][i + 1 + offset];
        }
    }
}
