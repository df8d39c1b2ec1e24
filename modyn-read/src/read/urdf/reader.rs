//! The reader of a `<robot>`, and the poses of its elements.

use modyn_runtime::spatial::Pose;
use roxmltree::Node;
use rustc_hash::FxHashMap;

use crate::description::{ReadOptions, roll_pitch_yaw};
use crate::diagnostics::{Code, Place, Severity, Subject};
use crate::read::packages::Packages;
use crate::read::visual::Surfaces;
use crate::read::xml::element::{Attribute, Elements, attribute};
use crate::read::xml::unread::Unread;

/// Reads elements: `<link>` in `link`, `<joint>` in `joint`, `<loop_joint>` in `loops`,
/// `<contact_frame>` in `contacts`.
pub struct Reader<'a, 't, 'r, 'f> {
    pub xml: Elements<'a, 't, 'r, 'f>,
    pub options: &'r ReadOptions,
    /// Whether the robot says that it is a URDF of version 1.1 or later.
    pub has_quaternions: bool,
    /// The places of quaternions that other readers ignore.
    pub ignored_quaternions: Vec<Place>,
    /// The places of inertias that other readers drop, for white space in numbers.
    pub dropped_inertias: Vec<Place>,
    /// The places of negative effort or velocity limits.
    pub negative_limits: Vec<Place>,
    /// The places of friction that differs between the tangents of a contact.
    pub anisotropic: Vec<Place>,
    /// The elements that are not read and may change the dynamics.
    pub unread: Unread,
    /// The folders of the packages that meshes name.
    pub packages: Packages,
    /// The meshes of visuals and collisions.
    pub surfaces: Surfaces,
    /// The colours of the robot's materials by their names, once a visual needs them; `None` for a
    /// material without a colour.
    pub materials: Option<FxHashMap<&'a str, Option<[f64; 4]>>>,
    /// A sentence for each shape that could not be read.
    pub shape_notes: Vec<String>,
}

impl<'a> Reader<'a, '_, '_, '_> {
    /// Returns the pose of the `<origin>` in an element; identity if there is none.
    pub fn origin(&mut self, node: Node<'a, '_>, subject: Option<&Subject>) -> Pose<f64> {
        let Some(node) = self.xml.single(node, "origin", subject) else {
            return Pose::identity();
        };
        self.xml.warn_of_unknown_attributes(node, &["xyz", "rpy", "quat_xyzw"], subject);
        self.pose(node, subject)
    }

    /// Returns the pose of an element's `xyz` and `rpy`, or `quat_xyzw` of URDF 1.2.
    pub fn pose(&mut self, node: Node<'a, '_>, subject: Option<&Subject>) -> Pose<f64> {
        let mut three = |name| {
            let text = attribute(node, name)?;
            self.xml.numbers(text, subject)
        };
        let translation = three("xyz").unwrap_or_default();
        let angles = three("rpy");
        let described = match attribute(node, "quat_xyzw") {
            Some(text) => {
                if !self.has_quaternions && node.tag_name().name() == "origin" {
                    self.ignored_quaternions.push((Some(text.at), subject.cloned()));
                }
                self.quaternion(text, angles.is_some(), subject)
            }
            None => None,
        };
        let rotation = described.unwrap_or_else(|| roll_pitch_yaw(angles.unwrap_or_default()));
        Pose { rotation, translation }
    }

    /// Returns the rotation of a quaternion of any length.
    fn quaternion(
        &mut self,
        text: Attribute,
        has_angles: bool,
        subject: Option<&Subject>,
    ) -> Option<[[f64; 3]; 3]> {
        if has_angles {
            let message = "the rotation is given twice, by `rpy` and by `quat_xyzw`";
            self.xml.report.error(Code::NotRead, text.at, subject, message, "keep one of them");
            return None;
        }
        let [x, y, z, w] = self.xml.numbers(text, subject)?;
        let length = libm::sqrt(x * x + y * y + z * z + w * w);
        if length < 1e-6 || !length.is_finite() {
            let message = "the quaternion is not of length 1";
            let help = "write four numbers whose squares sum up to 1: `quat_xyzw=\"0 0 0 1\"`";
            self.xml.report.error(Code::NotFinite, text.at, subject, message, help);
            return None;
        }
        if (length - 1.0).abs() > 1e-3 {
            let message = format!("the quaternion is of length {length}; it is normalised");
            let [x, y, z, w] = [x, y, z, w].map(|number| number / length);
            let help = format!("write `{x} {y} {z} {w}`");
            let severity = Severity::Warning;
            self.xml.report.add(severity, Code::AxisLength, text.at, subject, message, help);
        }
        let [x, y, z, w] = [x, y, z, w].map(|number| number / length);
        Some([
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ])
    }
}
