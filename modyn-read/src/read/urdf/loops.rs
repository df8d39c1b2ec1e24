//! Reads a `<loop_joint>`, an extension that other tools use, too.
//!
//! ```xml
//! <loop_joint name="pin" type="revolute">
//!   <link1 link="coupler" xyz="0.4 0 0" rpy="0 0 0"/>
//!   <link2 link="rocker" xyz="0 0 0.3"/>
//!   <axis xyz="0 1 0"/>
//! </loop_joint>
//! ```

use modyn_runtime::model::LoopConstraintKind;
use modyn_runtime::spatial::Pose;
use roxmltree::Node;

use super::reader::Reader;
use crate::description::{EndRecord, LoopRecord};
use crate::diagnostics::{Code, Severity, Subject};
use crate::read::xml::element::children;

const TYPES: &str = "supported are: spherical, fixed, revolute, continuous, prismatic";

impl<'a> Reader<'a, '_, '_, '_> {
    pub fn loop_joint(&mut self, node: Node<'a, '_>) -> LoopRecord {
        let name = self.xml.attribute(node, "name", None);
        let own_subject = name.map(|name| Subject::Joint(name.text.into()));
        let subject = own_subject.as_ref();
        self.xml.warn_of_unknown_attributes(node, &["name", "type"], subject);
        let kind = self.loop_kind(node, subject);
        for child in children(node).filter(Node::is_element) {
            let name = child.tag_name().name();
            let axis = kind.is_none_or(|kind| kind.axis().is_some());
            if !(["link1", "link2"].contains(&name) || name == "axis" && axis) {
                let message = format!("the element `<{name}>` of `<loop_joint>` is not read");
                let help =
                    "a loop joint has `<link1>`, `<link2>`, and, if it has an axis, `<axis>`";
                let at = child.range().start;
                self.xml.report.add(Severity::Warning, Code::NotRead, at, subject, message, help);
            }
        }
        let ends = ["link1", "link2"].map(|end| self.loop_end(node, end, subject));
        let at = name.map_or(node.range().start, |name| name.at);
        LoopRecord { name: name.map_or("", |name| name.text).into(), at: Some(at), kind, ends }
    }

    fn loop_kind(
        &mut self,
        node: Node<'a, '_>,
        subject: Option<&Subject>,
    ) -> Option<LoopConstraintKind> {
        let text = self.xml.attribute(node, "type", subject)?;
        let x = [1.0, 0.0, 0.0];
        let Some(kind) = LoopConstraintKind::of_joint(text.text, x) else {
            let message = format!("`{}` is not a type of loop joint", text.text);
            self.xml.report.error(Code::UnknownJointType, text.at, subject, message, TYPES);
            return None;
        };
        if kind.axis().is_none() {
            return Some(kind);
        }
        LoopConstraintKind::of_joint(text.text, self.axis(node, "axis", x, subject)?)
    }

    fn loop_end(&mut self, node: Node<'a, '_>, name: &str, subject: Option<&Subject>) -> EndRecord {
        let example = format!("<{name} link=\"...\" xyz=\"0 0 0\" rpy=\"0 0 0\"/>");
        let Some(end) = self.xml.required(node, name, &example, subject) else {
            return EndRecord { link: None, at: None, pose: Pose::identity() };
        };
        self.xml.warn_of_unknown_attributes(end, &["link", "xyz", "rpy", "quat_xyzw"], subject);
        for child in children(end).filter(Node::is_element) {
            let message = format!("`<{}>` in `<{name}>` is not read", child.tag_name().name());
            let help = format!("write `<{name} link=\"...\" xyz=\"0 0 0\" rpy=\"0 0 0\"/>`");
            self.xml.report.error(Code::NotRead, child.range().start, subject, message, help);
        }
        let pose = self.pose(end, subject);
        let link = self.xml.attribute(end, "link", subject);
        let at = link.map_or(end.range().start, |link| link.at);
        EndRecord { link: link.map(|link| link.text.into()), at: Some(at), pose }
    }
}
