//! Reads a `<link>`.

use modyn_runtime::model::Inertial;
use roxmltree::Node;

use super::extensions::KNOWN_IN_LINK;
use super::reader::Reader;
use crate::description::{InertialRecord, LinkRecord};
use crate::diagnostics::{Code, Severity, Subject};
use crate::read::xml::element::children;

impl<'a> Reader<'a, '_, '_, '_> {
    pub fn link(&mut self, node: Node<'a, '_>) -> Option<LinkRecord> {
        let name = self.xml.attribute(node, "name", None);
        let subject = name.map(|name| Subject::Link(name.text.into()));
        self.unread_elements(node, KNOWN_IN_LINK, &["inertial"], subject.as_ref());
        let element = self.xml.single(node, "inertial", subject.as_ref());
        let inertial = element.and_then(|node| self.inertial(node, subject.as_ref()));
        let name = name?.located();
        let shapes = if self.options.shapes { self.shapes(node, &name.text) } else { Vec::new() };
        Some(LinkRecord { shapes, ..LinkRecord::new(name, inertial) })
    }

    /// Returns the inertia of a link; `None` if it is zero and has no mass.
    fn inertial(
        &mut self,
        node: Node<'a, '_>,
        subject: Option<&Subject>,
    ) -> Option<InertialRecord> {
        if is_weightless(node) {
            let message =
                "`<inertial>` has no `<mass>`, and its inertia is zero: the link has no mass";
            let help = "write `<mass value=\"1.5\"/>` and its inertia, or remove `<inertial>`; \
                        urdfdom does not read it either";
            let at = node.range().start;
            self.xml.report.add(
                Severity::Warning,
                Code::MissingElement,
                at,
                subject,
                message,
                help,
            );
            return None;
        }
        let errors = self.xml.report.errors();
        self.xml.warn_of_misspelt_elements(
            node,
            &["origin", "mass", "inertia"],
            &["origin"],
            subject,
        );
        let pose = self.origin(node, subject);
        let mut mass = 0.0;
        let mut mass_at = node.range().start;
        if let Some(node) = self.xml.required(node, "mass", "<mass value=\"1.5\"/>", subject) {
            mass_at = node.range().start;
            self.xml.warn_of_unknown_attributes(node, &["value"], subject);
            if let Some(value) = self.xml.attribute(node, "value", subject) {
                mass_at = value.at;
                [mass] = self.xml.numbers(value, subject).unwrap_or_default();
            }
        }
        let mut inertia = [0.0; 6];
        let names = ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"];
        let example =
            "<inertia ixx=\"0.1\" ixy=\"0\" ixz=\"0\" iyy=\"0.1\" iyz=\"0\" izz=\"0.1\"/>";
        if let Some(node) = self.xml.required(node, "inertia", example, subject) {
            self.xml.warn_of_unknown_attributes(node, &names, subject);
            for (name, entry) in names.into_iter().zip(&mut inertia) {
                if let Some(text) = self.xml.attribute(node, name, subject) {
                    [*entry] = self.xml.numbers(text, subject).unwrap_or_default();
                }
            }
        }
        if has_white_space(node) {
            self.dropped_inertias.push((Some(node.range().start), subject.cloned()));
        }
        let about_center = Inertial { mass, center_of_mass: [0.0; 3], inertia };
        Some(InertialRecord {
            inertial: about_center.transformed(&pose),
            at: node.range().start,
            mass_at,
            sound: self.xml.report.errors() == errors,
        })
    }
}

/// Returns whether an `<inertial>` has no `<mass>`, and an `<inertia>` whose numbers are zero.
fn is_weightless(inertial: Node) -> bool {
    let has = |name| children(inertial).filter(move |part| part.has_tag_name(name));
    let is_zero = |text: &str| text.trim().parse() == Ok(0.0);
    has("mass").next().is_none()
        && has("inertia").next().is_some()
        && has("inertia")
            .flat_map(|part| part.attributes())
            .all(|attribute| is_zero(attribute.value()))
}

/// Returns whether a number in an `<inertial>` has white space with which urdfdom does not read it:
/// anything after a single number, and other white space than spaces between several. XML replaces
/// a new line by a space, so this is the text itself.
fn has_white_space(inertial: Node) -> bool {
    let text = inertial.document().input_text();
    let is_white = |c: char| c.is_ascii_whitespace();
    let parts = ["origin", "mass", "inertia"];
    children(inertial).filter(|part| parts.contains(&part.tag_name().name())).any(|part| {
        let is_list = part.tag_name().name() == "origin";
        part.attributes().map(|attribute| &text[attribute.range_value()]).any(|value| match is_list
        {
            true => value.contains(['\n', '\t', '\r']),
            false => value.ends_with(is_white),
        })
    })
}
