//! Reads a `<contact_frame>`, an extension of modyn: a frame of a link that can touch the world.
//!
//! ```xml
//! <contact_frame name="left_sole" type="surface" link="left_foot" xyz="0.04 0 -0.03" rpy="0 0 0"/>
//! ```

use modyn_runtime::model::ContactKind;
use roxmltree::Node;

use super::reader::Reader;
use crate::description::{ContactRecord, EndRecord};
use crate::diagnostics::{Code, Severity, Subject};
use crate::read::xml::element::children;

impl<'a> Reader<'a, '_, '_, '_> {
    pub fn contact_frame(&mut self, node: Node<'a, '_>) -> ContactRecord {
        let name = self.xml.attribute(node, "name", None);
        let own_subject = name.map(|name| Subject::Contact(name.text.into()));
        let subject = own_subject.as_ref();
        let read = ["name", "type", "link", "xyz", "rpy", "quat_xyzw"];
        self.xml.warn_of_unknown_attributes(node, &read, subject);
        for child in children(node).filter(Node::is_element) {
            let message = format!(
                "the element `<{}>` of `<contact_frame>` is not read",
                child.tag_name().name()
            );
            let help = "a contact frame has attributes alone: `name`, `type`, `link`, `xyz`, `rpy`";
            let at = child.range().start;
            self.xml.report.add(Severity::Warning, Code::NotRead, at, subject, message, help);
        }
        let kind = self.xml.attribute(node, "type", subject).and_then(|kind| {
            let known_kind = ContactKind::from_name(kind.text);
            if known_kind.is_none() {
                let message = format!("`{}` is not a type of contact", kind.text);
                let help = "write `point`, which stops translations, or `surface`, which stops rotations as well";
                self.xml.report.error(Code::ContactFrame, kind.at, subject, message, help);
            }
            known_kind
        });
        let link = self.xml.attribute(node, "link", subject);
        let end = EndRecord {
            link: link.map(|link| link.text.into()),
            at: Some(link.map_or(node.range().start, |link| link.at)),
            pose: self.pose(node, subject),
        };
        let at = name.map_or(node.range().start, |name| name.at);
        ContactRecord { name: name.map_or("", |name| name.text).into(), at: Some(at), kind, end }
    }
}
