//! Comparing to scale.

/// The largest difference, against 1 or the largest magnitude expected, whichever is more.
///
/// Infinite where a number is missing or is none.
#[must_use]
pub fn difference(found: &[f64], expected: &[f64]) -> f64 {
    worst(found, expected).1
}

/// Where the largest difference is, and what it is.
fn worst(found: &[f64], expected: &[f64]) -> (usize, f64) {
    if found.len() != expected.len() {
        return (found.len().min(expected.len()), f64::INFINITY);
    }
    let scale = expected.iter().fold(1.0, |scale: f64, x| scale.max(x.abs()));
    let differences = found.iter().zip(expected).map(|(a, b)| (a - b).abs() / scale);
    // No comparison is true of NaN.
    let differences = differences.map(|x| if x.is_nan() { f64::INFINITY } else { x });
    differences.enumerate().fold((0, 0.0), |worst, one| if one.1 > worst.1 { one } else { worst })
}

/// Asserts that `found` is `expected` up to `tolerance`, to scale.
///
/// # Panics
///
/// If it is not.
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
