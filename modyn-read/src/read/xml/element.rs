//! Reads elements and attributes strictly: missing, repeated or misspelt ones are reported with
//! their place.

use roxmltree::Node;

use super::document::PREFIX_END;
use super::numbers::numbers;
use crate::description::{Located, normalized};
use crate::diagnostics::{Code, Report, Severity, Subject, suggest};
use crate::work::counted;

/// The value of an attribute and its place.
#[derive(Clone, Copy)]
pub struct Attribute<'a> {
    pub text: &'a str,
    pub at: usize,
}

impl Attribute<'_> {
    /// Returns the attribute as owned text.
    pub fn located(self) -> Located {
        Located { text: self.text.into(), at: self.at }
    }
}

/// Reads the elements of a document and reports their errors.
pub struct Elements<'a, 't, 'r, 'f> {
    /// The root element.
    pub root: Node<'a, 't>,
    /// The start of the document's file in the report.
    pub start: usize,
    pub report: &'r mut Report<'f>,
}

impl<'a> Elements<'a, '_, '_, '_> {
    /// Returns the offset of an element in the report.
    pub fn at(&self, node: Node) -> usize {
        self.start + node.range().start
    }

    /// Returns an optional attribute.
    pub fn optional(&self, node: Node<'a, '_>, name: &str) -> Option<Attribute<'a>> {
        let Attribute { text, at } = attribute(node, name)?;
        Some(Attribute { text, at: self.start + at })
    }

    /// Returns the text in an element, with the place of its first word; it is empty if there is
    /// none.
    pub fn content(&self, node: Node<'a, '_>) -> Attribute<'a> {
        let text = children(node).find(Node::is_text);
        let words = text.and_then(|text| text.text()).unwrap_or_default();
        let blank = words.len() - words.trim_start().len();
        let at = text.filter(|_| blank < words.len()).map(|text| self.at(text) + blank);
        Attribute { text: words, at: at.unwrap_or(self.at(node)) }
    }

    /// Returns a required attribute, which must not be empty.
    pub fn attribute(
        &mut self,
        node: Node<'a, '_>,
        name: &str,
        subject: Option<&Subject>,
    ) -> Option<Attribute<'a>> {
        let optional = self.optional(node, name);
        if let Some(attribute) = optional
            && !attribute.text.trim().is_empty()
        {
            return Some(attribute);
        }
        let element = written(node);
        let state = if optional.is_some() { "is empty" } else { "is missing" };
        let message = format!("the attribute `{name}` of `<{element}>` {state}");
        let at = optional.map_or(self.at(node), |attribute| attribute.at);
        let help = format!("write `<{element} {name}=\"...\">`");
        self.report.error(Code::MissingAttribute, at, subject, message, help);
        None
    }

    pub fn numbers<const N: usize>(
        &mut self,
        text: Attribute,
        subject: Option<&Subject>,
    ) -> Option<[f64; N]> {
        match numbers(text.text) {
            Ok(values) => Some(values),
            Err(bad) => {
                self.report.error(bad.code, text.at, subject, bad.message, bad.help);
                None
            }
        }
    }

    /// Returns an optional number.
    pub fn number(
        &mut self,
        node: Node<'a, '_>,
        name: &str,
        subject: Option<&Subject>,
    ) -> Option<f64> {
        self.numbers::<1>(self.optional(node, name)?, subject).map(|[value]| value)
    }

    /// Returns the direction of an axis, with a warning if its length is not one; `None` if it is
    /// zero.
    pub fn unit(
        &mut self,
        axis: [f64; 3],
        at: usize,
        subject: Option<&Subject>,
    ) -> Option<[f64; 3]> {
        let Some((unit, length)) = normalized(axis) else {
            let help = "write the direction of the axis, such as `0 0 1`";
            self.report.error(Code::ZeroAxis, at, subject, "the axis is zero", help);
            return None;
        };
        if (length - 1.0).abs() > 1e-6 {
            let message = format!("the axis is of length {length}; it is normalised");
            let help = format!("write `{} {} {}`", unit[0], unit[1], unit[2]);
            self.report.add(Severity::Warning, Code::AxisLength, at, subject, message, help);
        }
        Some(unit)
    }

    /// Returns the child elements of this name.
    pub fn named<'t>(&self, node: Node<'a, 't>, name: &str) -> impl Iterator<Item = Node<'a, 't>> {
        children(node).filter(move |child| is(*child, name))
    }

    /// Returns the child element of this name; several are an error, or a warning if they are axes.
    pub fn single<'t>(
        &mut self,
        node: Node<'a, 't>,
        name: &str,
        subject: Option<&Subject>,
    ) -> Option<Node<'a, 't>> {
        let [first, second] = {
            let mut elements = self.named(node, name);
            [elements.next(), elements.next()]
        };
        if let (Some(first), Some(second)) = (first, second) {
            let line = self.report.position(self.at(first)).line;
            let (severity, counts) = match name {
                // Other readers take the first axis without a word.
                "axis" => (Severity::Warning, ", which counts"),
                _ => (Severity::Error, ""),
            };
            let message =
                format!("a second `<{}>`; the first is in line {line}{counts}", shown(name));
            let code = Code::RepeatedElement;
            let at = self.at(second);
            self.report.add(severity, code, at, subject, message, "keep one of them");
        }
        first
    }

    /// Returns the required child element of this name; none and several are errors. The help shows
    /// the example.
    pub fn required<'t>(
        &mut self,
        node: Node<'a, 't>,
        name: &str,
        example: &str,
        subject: Option<&Subject>,
    ) -> Option<Node<'a, 't>> {
        let element = self.single(node, name, subject);
        if element.is_none() {
            let message = format!("`<{}>` has no `<{}>`", written(node), shown(name));
            let help = format!("write `{example}`");
            let at = self.at(node);
            self.report.error(Code::MissingElement, at, subject, message, help);
        }
        element
    }

    /// Warns of attributes that are not read: the value of a misspelt attribute would silently be
    /// its default.
    pub fn warn_of_unknown_attributes(
        &mut self,
        node: Node<'a, '_>,
        names: &[&str],
        subject: Option<&Subject>,
    ) {
        for attribute in node.attributes() {
            if !is_extension(attribute.name()) && !names.contains(&attribute.name()) {
                let element = node.tag_name().name();
                let message =
                    format!("the attribute `{}` of `<{element}>` is not read", attribute.name());
                let help = format!("`<{element}>` has: {}", names.join(", "));
                let at = self.start + attribute.range().start;
                self.report.add(Severity::Warning, Code::NotRead, at, subject, message, help);
            }
        }
    }

    /// Warns of attributes whose names are similar to one of these. (Other attributes are
    /// extensions.)
    pub fn warn_of_misspelt_attributes(
        &mut self,
        node: Node<'a, '_>,
        names: &[&str],
        subject: Option<&Subject>,
    ) {
        for attribute in node.attributes() {
            let name = attribute.name();
            if !is_extension(name)
                && !names.contains(&name)
                && name.len() > 2
                && let Some(meant) = suggest(name, names.iter().copied())
            {
                let element = node.tag_name().name();
                let message = format!("the attribute `{name}` of `<{element}>` is not read");
                let help = format!("did you mean `{meant}`?");
                let at = self.start + attribute.range().start;
                self.report.add(Severity::Warning, Code::NotRead, at, subject, message, help);
            }
        }
    }

    /// Warns of elements whose names are similar to the name of an optional element, which would
    /// silently be missing. (Other elements are extensions.)
    pub fn warn_of_misspelt_elements(
        &mut self,
        node: Node<'a, '_>,
        known: &[&str],
        optional: &[&str],
        subject: Option<&Subject>,
    ) {
        for child in children(node).filter(Node::is_element) {
            let name = child.tag_name().name();
            if !is_extension(name)
                && !known.contains(&name)
                && let Some(meant) = suggest(name, optional.iter().copied())
            {
                let message = format!("the element `<{name}>` is not read");
                let help = format!("did you mean `<{meant}>`?");
                let at = self.at(child);
                self.report.add(Severity::Warning, Code::NotRead, at, subject, message, help);
            }
        }
    }
}

/// Returns the children of an element, with its texts.
pub fn children<'a, 't>(node: Node<'a, 't>) -> impl DoubleEndedIterator<Item = Node<'a, 't>> {
    counted(node.children())
}

/// Returns an attribute; `None` if it is missing.
pub fn attribute<'a>(node: Node<'a, '_>, name: &str) -> Option<Attribute<'a>> {
    let attribute = node.attribute_node(name)?;
    Some(Attribute { text: attribute.value(), at: attribute.range().start })
}

/// Returns whether `node` is the element of this name.
pub fn is(node: Node, name: &str) -> bool {
    node.is_element() && node.tag_name().name() == name
}

/// Returns whether a name has a prefix: it belongs to an extension of the format.
pub fn is_extension(name: &str) -> bool {
    name.contains(PREFIX_END)
}

/// Returns the name of an element as it is written, with its prefix.
pub fn written(node: Node) -> String {
    shown(node.tag_name().name())
}

/// Returns a name as it is written, with its prefix.
pub fn shown(name: &str) -> String {
    name.replace(PREFIX_END, ":")
}
