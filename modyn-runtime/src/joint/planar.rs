//! Planar joints.

/// Returns the frame of a plane with the unit normal `axis`, as the columns of a rotation matrix.
///
/// Its x and y axes are the axes of the joint's frame, rotated by the smallest rotation that takes
/// z to the axis; its z is the axis. If the axis is -z, the rotation is half a turn about x.
#[must_use]
pub fn plane(axis: [f64; 3]) -> [[f64; 3]; 3] {
    let [x, y, z] = axis;
    let across = x * x + y * y;
    if z < 0.0 && across < ON_Z {
        return [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]];
    }
    // 1 / (1 + z), which cancels near z = -1.
    let by = if z < 0.0 { (1.0 - z) / across } else { 1.0 / (1.0 + z) };
    [[1.0 - x * x * by, -x * y * by, x], [-x * y * by, 1.0 - y * y * by, y], [-x, -y, z]]
}

/// The squared sine below which the direction of an axis perpendicular to z is rounding noise.
const ON_Z: f64 = 1e-24;

#[cfg(test)]
mod tests {
    use super::plane;

    #[test]
    fn coordinate_axes_are_exact() {
        let identity = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        assert_eq!(plane([0.0, 0.0, 1.0]), identity);
        let half = [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]];
        assert_eq!(plane([0.0, 0.0, -1.0]), half);
        assert_eq!(plane([1e-17, 0.0, -1.0]), half);
        // A quarter turn about y, and about -x.
        assert_eq!(plane([1.0, 0.0, 0.0]), [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]);
        assert_eq!(plane([0.0, 1.0, 0.0]), [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]);
    }

    /// The rotation is about a line perpendicular to z and takes z to the axis, so no smaller
    /// rotation does.
    #[test]
    fn it_is_the_smallest_rotation() {
        for (x, y, z) in [
            (0.36, -0.48, 0.8),
            (0.6, 0.64, -0.48),
            (-1e-3, 1e-3, 1.0),
            (2e-5, 1e-5, -1.0),
            (1e-9, 3e-9, -1.0),
        ] {
            let length = libm::sqrt(x * x + y * y + z * z);
            let axis = [x, y, z].map(|x: f64| x / length);
            let r = plane(axis);
            for i in 0..3 {
                assert!((r[i][2] - axis[i]).abs() < 1e-15, "{r:?}");
                for j in 0..3 {
                    let dot: f64 = (0..3).map(|k| r[k][i] * r[k][j]).sum();
                    let unit = if i == j { 1.0 } else { 0.0 };
                    assert!((dot - unit).abs() < 1e-14, "{r:?}");
                }
            }
            // The line along z x axis is invariant: (-y, x, 0).
            let line = [-axis[1], axis[0], 0.0];
            let size = libm::hypot(axis[0], axis[1]);
            for i in 0..3 {
                let moved: f64 = (0..3).map(|k| r[i][k] * line[k]).sum();
                assert!((moved - line[i]).abs() < 1e-15 * size.max(1.0), "{r:?}");
            }
        }
    }
}
