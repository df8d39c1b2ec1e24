//! The reader of a `<robot>`, and the poses of its elements.

use modyn_runtime::spatial::Pose;
use roxmltree::Node;

use crate::description::{ReadOptions, roll_pitch_yaw};
use crate::diagnostics::{Code, Place, Subject};
use crate::read::xml::element::{Elements, attribute};

/// Reads elements: `<link>` in `link`, `<joint>` in `joint`, `<loop_joint>` in `loops`,
/// `<contact_frame>` in `contacts`.
pub struct Reader<'a, 't, 'r, 'f> {
    pub xml: Elements<'a, 't, 'r, 'f>,
    pub options: &'r ReadOptions,
    /// The places of negative effort or velocity limits.
    pub negative_limits: Vec<Place>,
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

    /// Returns the pose of an element's `xyz` and `rpy`.
    pub fn pose(&mut self, node: Node<'a, '_>, subject: Option<&Subject>) -> Pose<f64> {
        if let Some(attribute) = node.attribute_node("quat_xyzw") {
            let message = "`quat_xyzw` is not read, so the rotation would be lost";
            let help = "write the rotation as `rpy=\"roll pitch yaw\"`";
            self.xml.report.error(Code::NotRead, attribute.range().start, subject, message, help);
        }
        let mut three = |name| {
            let text = attribute(node, name)?;
            self.xml.numbers(text, subject)
        };
        let translation = three("xyz").unwrap_or_default();
        let rotation = roll_pitch_yaw(three("rpy").unwrap_or_default());
        Pose { rotation, translation }
    }
}
