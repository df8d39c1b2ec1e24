//! Ground whose height is given on a grid.

use crate::robot::SurfaceSettings;
use crate::scalar::positive;
use crate::setting_range::{SettingError, SettingPlace, SettingRange};
use crate::spatial::{Matrix3, Pose, Vector3};
use crate::{Robot, Scalar, ShapeCenter, functions};

/// Ground whose height is given on a grid in the xy plane of the world, and interpolated
/// bilinearly. Beyond the grid the ground goes on level at the height of the border.
///
/// ```
/// use modyn_runtime::simulate::HeightField;
///
/// // A ramp along x: 10 cm higher after each metre.
/// let heights = [0.0, 0.1, 0.2, 0.0, 0.1, 0.2];
/// let ramp = HeightField::new([0.0, -5.0], [1.0, 10.0], 3, &heights).expect("two rows of three");
/// let plane = ramp.plane([0.5, 0.0]);
/// assert!((plane.translation[2] - 0.05_f64).abs() < 1e-12);
/// assert!((plane.rotation[0][2] / plane.rotation[2][2] + 0.1).abs() < 1e-12);
///
/// // A camera often leaves cells unknown.
/// let unknown = [0.0, 0.1, f64::NAN, 0.0, 0.1, 0.2];
/// let error = HeightField::new([0.0; 2], [1.0; 2], 3, &unknown).expect_err("one cell is NaN");
/// assert_eq!(error.to_string(), "`heights`[0, 2] of the height field is NaN; expected a finite number");
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeightField<'a, T = f64> {
    grid: HeightGrid<T>,
    /// The heights, m: row by row, along x within a row.
    heights: &'a [T],
}

/// The grid of a height field: the places of heights, in the xy plane of the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeightGrid<T = f64> {
    /// The x and y of the first height, m.
    origin: [T; 2],
    /// The distances of neighbours along x and y, m.
    spacing: [T; 2],
    /// The number of heights along x, and along y.
    counts: [usize; 2],
}

/// The cell of a grid along one axis.
struct Cell<T> {
    /// The index of its first height.
    first: usize,
    /// The place within the cell, 0 to 1.
    part: T,
    /// 1 / its size; 0 beyond the grid, where the ground is level.
    slope: T,
}

impl<'a, T: Scalar + Into<f64>> HeightField<'a, T> {
    /// Returns the field of these heights (m): rows of `columns` heights along x, whose first is at
    /// `origin`, with these distances of neighbours along x and y (m).
    ///
    /// # Errors
    ///
    /// If there are not two full rows of at least two heights, if a number is not finite, or if a
    /// distance is not above zero.
    pub fn new(
        origin: [T; 2],
        spacing: [T; 2],
        columns: usize,
        heights: &'a [T],
    ) -> Result<Self, SettingError> {
        let rows = heights.len().checked_div(columns).unwrap_or_default();
        if rows * columns != heights.len() {
            return Err(no_grid(heights.len()));
        }
        let grid = HeightGrid::new(origin, spacing, [columns, rows])?;
        (0..heights.len()).try_for_each(|k| grid.check_height(heights, k))?;
        Ok(Self { grid, heights })
    }

    /// Returns the plane that touches the ground below a point at this x and y (m): its z axis is
    /// the normal of the ground, its origin is on the ground, and its x axis is above the x axis of
    /// the world.
    #[must_use]
    pub fn plane(&self, point: [T; 2]) -> Pose<T> {
        self.grid.plane(self.heights, point)
    }

    /// Returns the plane below a point of a link: `pose` is the link's pose, and `place` the point in
    /// the link's axes, m.
    #[must_use]
    pub fn plane_below(&self, pose: Pose<T>, place: [T; 3]) -> Pose<T> {
        self.plane(above(pose, place))
    }

    /// Returns `settings` with the plane below the centre of each shape that touches the ground, for a
    /// step from the coordinates `q` on.
    #[must_use]
    pub fn under<R>(&self, q: &R::Q<T>, settings: &SurfaceSettings<R, T>) -> SurfaceSettings<R, T>
    where
        R: Robot + functions::LinkPoses,
    {
        let poses = R::link_poses(q);
        let mut settings = *settings;
        let centers = R::TOUCHING_SHAPE_CENTERS;
        for (surface, ShapeCenter { link, place }) in
            settings.surfaces.as_mut().iter_mut().zip(centers)
        {
            surface.plane = self.plane_below(poses.as_ref()[*link], place.map(T::from_f64));
        }
        settings
    }
}

/// Returns the error that this many heights are no two full rows of two.
#[allow(clippy::cast_precision_loss)]
fn no_grid(heights: usize) -> SettingError {
    let place = SettingPlace::HeightField;
    SettingError { name: "heights", place, value: heights as f64, range: SettingRange::Grid }
}

/// Returns the x and y of a point of a link: `pose` is the link's pose, and `place` the point in the
/// link's axes.
fn above<T: Scalar>(pose: Pose<T>, place: [T; 3]) -> [T; 2] {
    let [x, y, _] = pose.rotate(place);
    [x + pose.translation[0], y + pose.translation[1]]
}

impl<T: Scalar + Into<f64>> HeightGrid<T> {
    /// Returns the grid whose first height is at `origin`, with these distances of neighbours along x
    /// and y (m), and these numbers of heights along x and y.
    ///
    /// # Errors
    ///
    /// If there are not two heights along each axis, if a number is not finite, or if a distance is
    /// not above zero.
    pub fn new(origin: [T; 2], spacing: [T; 2], counts: [usize; 2]) -> Result<Self, SettingError> {
        if counts.iter().any(|&count| count < 2) {
            return Err(no_grid(counts[0] * counts[1]));
        }
        let place = SettingPlace::HeightField;
        for (x, distance) in origin.into_iter().zip(spacing) {
            SettingRange::Finite.check("origin", place, x.into())?;
            SettingRange::Positive.check("spacing", place, distance.into())?;
        }
        Ok(Self { origin, spacing, counts })
    }

    /// Checks the height with this index.
    fn check_height(&self, heights: &[T], index: usize) -> Result<(), SettingError> {
        let [columns, _] = self.counts;
        let place = SettingPlace::Height { row: index / columns, column: index % columns };
        SettingRange::Finite.check("heights", place, heights[index].into())
    }

    /// Returns the plane below a point of a link, as [`HeightField::plane_below`] does, on ground with
    /// these heights (m), row by row. Only the four heights around the point are read.
    ///
    /// # Errors
    ///
    /// If one of the four is not finite.
    ///
    /// # Panics
    ///
    /// If there are fewer heights than the grid has.
    pub fn plane_below(
        &self,
        heights: &[T],
        pose: Pose<T>,
        place: [T; 3],
    ) -> Result<Pose<T>, SettingError> {
        let point = above(pose, place);
        let plane = self.plane(heights, point);
        if !plane.translation[2].into().is_finite() {
            let [x, y] = [0, 1].map(|axis| self.cell(axis, point[axis]).first);
            let first = y * self.counts[0] + x;
            let corners = [0, 1, self.counts[0], self.counts[0] + 1];
            corners.iter().try_for_each(|corner| self.check_height(heights, first + corner))?;
        }
        Ok(plane)
    }

    /// Returns the plane that touches the ground below a point, as [`HeightField::plane`] does.
    fn plane(&self, heights: &[T], point: [T; 2]) -> Pose<T> {
        let [x, y] = [0, 1].map(|axis| self.cell(axis, point[axis]));
        let height = |i: usize, j: usize| heights[(y.first + j) * self.counts[0] + x.first + i];
        let mix = |a: T, b: T, part: T| a + (b - a) * part;
        let along = [0, 1].map(|i| mix(height(i, 0), height(i, 1), y.part));
        let across = [0, 1].map(|j| mix(height(0, j), height(1, j), x.part));
        let slopes = [(along[1] - along[0]) * x.slope, (across[1] - across[0]) * y.slope];
        let unit = |v: Vector3<T>| v.scale(v.dot(v).sqrt().recip());
        let normal = unit(Vector3([-slopes[0], -slopes[1], T::one()]));
        let first = unit(Vector3([T::one(), T::zero(), slopes[0]]));
        let axes = [first, normal.cross(first), normal];
        Pose {
            rotation: Matrix3::from_columns(|k| axes[k]).0,
            translation: [point[0], point[1], mix(along[0], along[1], x.part)],
        }
    }

    /// Returns the cell at this coordinate along an axis.
    #[allow(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    fn cell(&self, axis: usize, at: T) -> Cell<T> {
        let place = (at - self.origin[axis]) / self.spacing[axis];
        let last = self.counts[axis] - 2;
        let cells: f64 = place.into();
        let first = (cells.max(0.0) as usize).min(last);
        let part = place - T::from_f64(first as f64);
        let inside = cells >= 0.0 && cells <= (last + 1) as f64;
        let bounded = (part - T::one()).select_nonnegative(T::one(), positive(part));
        let slope = if inside { self.spacing[axis].recip() } else { T::zero() };
        Cell { first, part: bounded, slope }
    }
}
