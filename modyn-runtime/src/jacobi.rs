//! Eigenvalues of small symmetric matrices, in a fixed number of steps.

use crate::Scalar;

/// The number of sweeps over all off-diagonal entries. Convergence is eventually quadratic: 6 to 10
/// sweeps diagonalize matrices of the sizes of robots' modules to machine precision.
const SWEEPS: usize = 10;

/// Diagonalizes the symmetric matrix `a` (n x n) by cyclic Jacobi rotations (Golub and Van Loan,
/// sect. 8.5). Its diagonal then holds the eigenvalues.
///
/// Neither the steps nor their number depend on the values, and no access can panic.
pub fn diagonalize<S: Scalar>(a: &mut [S], n: usize) {
    for _ in 0..SWEEPS {
        for p in 0..n {
            for q in p + 1..n {
                rotate(a, n, p, q);
            }
        }
    }
}

/// Applies the rotation that makes entry (p, q) zero.
fn rotate<S: Scalar>(a: &mut [S], n: usize, p: usize, q: usize) {
    let at = |a: &[S], i: usize, j: usize| a.get(i * n + j).copied().unwrap_or_else(S::zero);
    let set = |a: &mut [S], i: usize, j: usize, value: S| {
        if let Some(entry) = a.get_mut(i * n + j) {
            *entry = value;
        }
    };
    let pp = at(a, p, p);
    let qq = at(a, q, q);
    let pq = at(a, p, q);
    // t is the tangent of the angle, the smaller root of t^2 + t (qq - pp) / pq - 1 = 0, in a form
    // that never divides by zero.
    let difference = qq - pp;
    let twice = pq + pq;
    let root = (difference * difference + twice * twice).sqrt();
    let size = (difference.abs() + root).max(S::from_f64(f64::from(f32::MIN_POSITIVE)));
    let t = difference.select_nonnegative(twice, -twice) / size;
    let c = (S::one() + t * t).sqrt().recip();
    let s = t * c;
    for k in 0..n {
        let kp = at(a, k, p);
        let kq = at(a, k, q);
        let new_p = c * kp - s * kq;
        let new_q = s * kp + c * kq;
        set(a, k, p, new_p);
        set(a, p, k, new_p);
        set(a, k, q, new_q);
        set(a, q, k, new_q);
    }
    // The entries of p and q have formulas of their own, which make (p, q) exactly zero.
    set(a, p, p, pp - t * pq);
    set(a, q, q, qq + t * pq);
    set(a, p, q, S::zero());
    set(a, q, p, S::zero());
}

/// Returns the condition number (2-norm) of the symmetric positive definite matrix `a` (n x n): its
/// largest divided by its smallest eigenvalue. `a` is overwritten.
///
/// The result is infinite if the smallest eigenvalue is zero or, by rounding, negative: the
/// condition number then exceeds what the scalar can represent. It is 1 for a matrix without
/// entries.
pub fn condition_number<S: Scalar>(a: &mut [S], n: usize) -> S {
    if n == 0 {
        return S::one();
    }
    // Scaled by its largest entry, so that no square overflows or underflows.
    let largest = a.iter().fold(S::zero(), |largest, x| largest.max(x.abs()));
    let scale = largest.recip();
    a.iter_mut().for_each(|x| *x = *x * scale);
    diagonalize(a, n);
    let diagonal = (0..n).filter_map(|i| a.get(i * (n + 1)).copied());
    let (largest, negated_smallest) =
        diagonal.fold((S::zero(), None), |(largest, smallest): (S, Option<S>), x| {
            (largest.max(x), Some(smallest.map_or(-x, |smallest| smallest.max(-x))))
        });
    largest / (-negated_smallest.unwrap_or_else(S::zero)).max(S::zero())
}

#[cfg(test)]
mod tests {
    use super::condition_number;

    #[test]
    fn scale_does_not_matter() {
        for scale in [1e-30_f32, 1e-23, 1.0, 1e30] {
            let number = condition_number(&mut [2.0 * scale, scale, scale, 2.0 * scale], 2);
            assert!((number - 3.0).abs() < 1e-5, "{scale:e}: {number}");
        }
    }

    #[test]
    fn a_singular_matrix_has_no_finite_one() {
        assert_eq!(condition_number(&mut [1.0_f64, 0.0, 0.0, 0.0], 2), f64::INFINITY);
        let number = condition_number(&mut [1.0_f32, 1.0, 1.0, 1.0 + 1e-9], 2);
        assert!(number > 1e6, "{number}");
    }

    #[test]
    fn a_single_number_is_well_conditioned() {
        assert_eq!(condition_number(&mut [0.1_f64], 1), 1.0);
        assert_eq!(condition_number::<f64>(&mut [], 0), 1.0);
    }
}
