//! Comparisons relative to the largest number.

/// Returns the largest difference, divided by the largest expected magnitude or 1, whichever is larger.
///
/// The result is infinite if a number is missing or NaN.
#[must_use]
pub fn difference(found: &[f64], expected: &[f64]) -> f64 {
    worst(found, expected).1
}

/// Returns the index of the largest difference, and the difference.
fn worst(found: &[f64], expected: &[f64]) -> (usize, f64) {
    if found.len() != expected.len() {
        return (found.len().min(expected.len()), f64::INFINITY);
    }
    let scale = expected.iter().fold(1.0, |scale: f64, x| scale.max(x.abs()));
    let differences = found.iter().zip(expected).map(|(a, b)| (a - b).abs() / scale);
    // Every comparison with NaN is false.
    let differences = differences.map(|x| if x.is_nan() { f64::INFINITY } else { x });
    differences.enumerate().fold((0, 0.0), |worst, one| if one.1 > worst.1 { one } else { worst })
}

/// Asserts that `found` differs from `expected` by at most `tolerance`, relative to the largest expected number.
///
/// # Panics
///
/// Panics if the difference is larger.
#[track_caller]
pub fn assert_close(what: &str, found: &[f64], expected: &[f64], tolerance: f64) {
    let (at, difference) = worst(found, expected);
    assert!(
        difference <= tolerance,
        "{what}: off by {difference:e}, more than {tolerance:e}: number {at} of {} is {:?}, expected {:?}",
        expected.len(),
        found.get(at),
        expected.get(at)
    );
}

#[cfg(test)]
mod tests {
    use super::difference;

    #[test]
    fn differences_are_to_scale_and_never_overlook_a_number() {
        assert_eq!(difference(&[0.5, 0.0], &[0.0, 0.0]), 0.5);
        assert_eq!(difference(&[0.0, 100.0], &[1.0, 100.0]), 0.01);
        assert_eq!(difference(&[1.0], &[1.0, 0.0]), f64::INFINITY);
        assert_eq!(difference(&[f64::NAN, 0.0], &[0.0, 0.0]), f64::INFINITY);
        assert_eq!(difference(&[0.0], &[f64::NAN]), f64::INFINITY);
        assert_eq!(difference(&[f64::INFINITY], &[f64::INFINITY]), f64::INFINITY);
    }
}
