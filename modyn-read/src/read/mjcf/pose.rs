//! Positions and rotations in the forms that MJCF has.

use modyn_runtime::conventions::rotation_from_quaternion;
use modyn_runtime::spatial::Pose;

use super::item::Item;
use super::settings::Settings;
use crate::description::{cross, normalized};
use crate::diagnostics::{Code, Report};

impl Item<'_> {
    /// Returns the pose of an element by `pos` and the attributes of rotations, in the frame of its
    /// body; its errors are in the report.
    pub fn pose(&self, settings: &Settings, report: &mut Report<'_>) -> Pose<f64> {
        let translation = self.numbers("pos").unwrap_or([0.0; 3]);
        let rotation = self.rotation(settings).unwrap_or_else(|(message, help)| {
            report.error(Code::ZeroAxis, self.element().at, None, message, help);
            Pose::identity().rotation
        });
        self.frame.compose(&Pose { rotation, translation })
    }

    /// Returns the rotation of the element; the nearest of `axisangle`, `euler`, `xyaxes` and
    /// `zaxis` precedes `quat`.
    fn rotation(&self, settings: &Settings) -> Result<[[f64; 3]; 3], (&'static str, &'static str)> {
        let is_form = |name: &str| ["axisangle", "euler", "xyaxes", "zaxis"].contains(&name);
        let form = self.chain.iter().find_map(|element| {
            element.attributes.iter().find(|attribute| is_form(&attribute.name))
        });
        let help = "write the direction of the axis, such as `0 0 1`";
        let normalized_axis = |axis: [f64; 3]| normalized(axis).map(|(unit, _)| unit);
        let unit = |axis| normalized_axis(axis).ok_or(("an axis of the rotation is zero", help));
        Ok(match form.map(|form| form.name.as_str()) {
            Some("axisangle") => match self.numbers("axisangle") {
                Some([x, y, z, angle]) => about(unit([x, y, z])?, settings.angle * angle),
                None => Pose::identity().rotation,
            },
            Some("euler") => euler(self.numbers("euler").unwrap_or([0.0; 3]), settings),
            Some("xyaxes") => match self.numbers("xyaxes") {
                Some([a, b, c, d, e, f]) => {
                    let x = unit([a, b, c])?;
                    let along = x[0] * d + x[1] * e + x[2] * f;
                    let y = unit([d - along * x[0], e - along * x[1], f - along * x[2]])?;
                    let z = cross(x, y);
                    [[x[0], y[0], z[0]], [x[1], y[1], z[1]], [x[2], y[2], z[2]]]
                }
                None => Pose::identity().rotation,
            },
            Some(_) => match self.numbers("zaxis") {
                Some(axis) => to_z_axis(unit(axis)?),
                None => Pose::identity().rotation,
            },
            None => match self.numbers("quat") {
                Some(quaternion) => from_quaternion(quaternion).ok_or((
                    "the quaternion is zero",
                    "write a unit quaternion, such as `1 0 0 0`",
                ))?,
                None => Pose::identity().rotation,
            },
        })
    }
}

/// Returns the rotation of a quaternion w, x, y, z of any length; `None` for zero.
pub fn from_quaternion([w, x, y, z]: [f64; 4]) -> Option<[[f64; 3]; 3]> {
    let largest = [w, x, y, z].iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    if largest == 0.0 {
        return None;
    }
    let scaled = [x, y, z, w].map(|x| x / largest);
    let square: f64 = scaled.iter().map(|x| x * x).sum();
    // A unit quaternion stays as it is written.
    let exact = largest * libm::sqrt(square);
    let length = if (exact - 1.0).abs() < 1e-15 { 1.0 } else { exact };
    Some(rotation_from_quaternion([x, y, z, w].map(|x| x / length)))
}

/// Returns the rotation by an angle, rad, about an axis of unit length. The sine is libm's, so that
/// every host computes the same numbers.
pub fn about([x, y, z]: [f64; 3], angle: f64) -> [[f64; 3]; 3] {
    let (sin, cos) = libm::sincos(0.5 * angle);
    rotation_from_quaternion([x * sin, y * sin, z * sin, cos])
}

/// Returns the rotation of Euler angles, of which lower-case axes move with the frame.
pub fn euler(angles: [f64; 3], settings: &Settings) -> [[f64; 3]; 3] {
    let rotations =
        settings.euler.iter().zip(angles).fold(Pose::identity(), |before, (letter, angle)| {
            let axis = match letter.to_ascii_lowercase() {
                b'x' => [1.0, 0.0, 0.0],
                b'y' => [0.0, 1.0, 0.0],
                _ => [0.0, 0.0, 1.0],
            };
            let one = Pose { rotation: about(axis, settings.angle * angle), translation: [0.0; 3] };
            if letter.is_ascii_lowercase() { before.compose(&one) } else { one.compose(&before) }
        });
    rotations.rotation
}

/// Returns the smallest rotation of the z axis to this direction of unit length.
pub fn to_z_axis([x, y, z]: [f64; 3]) -> [[f64; 3]; 3] {
    match normalized([-y, x, 0.0]) {
        // Opposite directions: about x, as in MuJoCo.
        None if z < 0.0 => [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]],
        None => Pose::identity().rotation,
        Some((axis, sin)) => about(axis, libm::atan2(sin, z)),
    }
}

/// Returns the pose of the frame `of` in the frame `from`.
pub fn relative(from: &Pose<f64>, pose: &Pose<f64>) -> Pose<f64> {
    let columns = from.rotation;
    let rotation = core::array::from_fn(|i| core::array::from_fn(|j| columns[j][i]));
    let inverse = Pose { rotation, translation: [0.0; 3] };
    let translation = inverse.transform_point(from.translation).map(|x| -x);
    Pose { translation, ..inverse }.compose(pose)
}
