//! Writes an expanded tree as XML, and the origin of each part of it.

use std::collections::BTreeMap;
use std::rc::Rc;

use super::tree::{Element, Node, Place};
use crate::diagnostics::Expansion;

/// Returns the text of an element, and the origins of its bytes. The outermost element declares
/// these namespaces.
pub fn write(root: &Element, namespaces: &BTreeMap<Rc<str>, Rc<str>>) -> (String, Expansion) {
    let mut writer = Writer { text: String::new(), expansion: Expansion::default() };
    writer.element(root, Some(namespaces));
    (writer.text, writer.expansion)
}

struct Writer {
    text: String,
    expansion: Expansion,
}

impl Writer {
    /// Marks the origin of the text that follows.
    fn from(&mut self, place: Place) {
        self.expansion.add(self.text.len(), place.at, place.call.unwrap_or(0));
    }

    fn element(&mut self, element: &Element, namespaces: Option<&BTreeMap<Rc<str>, Rc<str>>>) {
        self.from(element.place);
        self.text.push('<');
        self.text += &element.name;
        for (name, value) in namespaces.into_iter().flatten() {
            self.attribute(name, value);
        }
        for attribute in &element.attributes {
            self.from(attribute.place);
            self.attribute(&attribute.name, &attribute.value);
        }
        if element.children.is_empty() {
            self.text += "/>";
            return;
        }
        self.text.push('>');
        for child in &element.children {
            match child {
                Node::Element(child) => self.element(child, None),
                Node::Text(text, place) => {
                    self.from(*place);
                    self.escaped(text, false);
                }
            }
        }
        self.text += "</";
        self.text += &element.name;
        self.text.push('>');
    }

    fn attribute(&mut self, name: &str, value: &str) {
        self.text.push(' ');
        self.text += name;
        self.text += "=\"";
        self.escaped(value, true);
        self.text.push('"');
    }

    fn escaped(&mut self, text: &str, in_quotes: bool) {
        for c in text.chars() {
            match c {
                '<' => self.text += "&lt;",
                '>' => self.text += "&gt;",
                '&' => self.text += "&amp;",
                '"' if in_quotes => self.text += "&quot;",
                '\n' if in_quotes => self.text += "&#10;",
                '\t' if in_quotes => self.text += "&#9;",
                '\r' => self.text += "&#13;",
                // XML has no other control characters.
                c if c.is_control() && c != '\n' && c != '\t' => {}
                c => self.text.push(c),
            }
        }
    }
}
