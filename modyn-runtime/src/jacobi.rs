//! Eigenvalues of small symmetric matrices, in a fixed number of steps.

use crate::Scalar;

/// Sweeps over all off-diagonal entries: convergence is quadratic, so matrices of any order met
/// in a module are diagonal to machine precision by then.
const SWEEPS: usize = 10;

/// Makes the symmetric matrix `a` (n times n) diagonal by cyclic Jacobi rotations (Golub and Van
/// Loan, sect. 8.5): its diagonal then holds the eigenvalues.
///
/// Neither the steps nor their number depend on the values; no access can panic.
pub fn diagonalize<S: Scalar>(a: &mut [S], n: usize) {
    for _ in 0..SWEEPS {
        for p in 0..n {
            for q in p + 1..n {
                rotate(a, n, p, q);
            }
        }
    }
}

/// The rotation that makes entry (p, q) zero.
fn rotate<S: Scalar>(a: &mut [S], n: usize, p: usize, q: usize) {
    let at = |a: &[S], i: usize, j: usize| a.get(i * n + j).copied().unwrap_or_else(S::zero);
    let set = |a: &mut [S], i: usize, j: usize, value: S| {
        if let Some(entry) = a.get_mut(i * n + j) {
            *entry = value;
        }
    };
    let (pp, qq, pq) = (at(a, p, p), at(a, q, q), at(a, p, q));
    // t = tan of the angle, the smaller root of t^2 + t (qq - pp) / pq - 1 = 0, in a form that
    // divides by zero nowhere.
    let (difference, twice) = (qq - pp, pq + pq);
    let root = (difference * difference + twice * twice).sqrt();
    let size = difference.abs() + root + S::from_f64(f64::from(f32::MIN_POSITIVE));
    let t = difference.select_nonnegative(twice, -twice) / size;
    let c = (S::one() + t * t).sqrt().recip();
    let s = t * c;
    for k in 0..n {
        let (kp, kq) = (at(a, k, p), at(a, k, q));
        let (new_p, new_q) = (c * kp - s * kq, s * kp + c * kq);
        set(a, k, p, new_p);
        set(a, p, k, new_p);
        set(a, k, q, new_q);
        set(a, q, k, new_q);
    }
    // The four entries of p and q themselves have a form of their own, which is exact about zero.
    set(a, p, p, pp - t * pq);
    set(a, q, q, qq + t * pq);
    set(a, p, q, S::zero());
    set(a, q, p, S::zero());
}

/// The condition number (in the 2-norm) of the symmetric positive definite matrix `a` (n times
/// n), which is overwritten: its largest over its smallest eigenvalue.
pub fn condition_number<S: Scalar>(a: &mut [S], n: usize) -> S {
    diagonalize(a, n);
    let mut diagonal = (0..n).filter_map(|i| a.get(i * (n + 1)).copied());
    let first = diagonal.next().unwrap_or_else(S::one);
    let (largest, negated_smallest) =
        diagonal.fold((first, -first), |(largest, smallest), x| (largest.max(x), smallest.max(-x)));
    -(largest / negated_smallest)
}
