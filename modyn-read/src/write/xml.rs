//! Elements with attributes, and their text.

use std::fmt::Write as _;

use crate::diagnostics::{is_unprintable, sanitize_for_display};

/// An element of XML.
pub struct Element {
    name: &'static str,
    attributes: Vec<(&'static str, String)>,
    pub children: Vec<Element>,
}

impl Element {
    /// Returns an element without attributes.
    pub fn new(name: &'static str) -> Self {
        Self { name, attributes: Vec::new(), children: Vec::new() }
    }

    /// Returns the element with another attribute.
    pub fn with(mut self, name: &'static str, value: impl Into<String>) -> Self {
        self.attributes.push((name, value.into()));
        self
    }

    /// Returns the element with an attribute of numbers.
    pub fn numbers(self, name: &'static str, numbers: &[f64]) -> Self {
        let words: Vec<String> = numbers.iter().copied().map(number).collect();
        self.with(name, words.join(" "))
    }

    /// Returns the element with this child.
    pub fn child(mut self, child: Element) -> Self {
        self.children.push(child);
        self
    }

    /// Returns the element with this child, if there is one.
    pub fn maybe(mut self, child: Option<Element>) -> Self {
        self.children.extend(child);
        self
    }

    /// Returns whether the element has this name.
    pub fn is(&self, name: &str) -> bool {
        self.name == name
    }

    /// Returns the element of this name, in this one at any depth, that has this value of the
    /// attribute `name`.
    pub fn find(&mut self, element: &str, name: &str) -> Option<&mut Element> {
        let mut open: Vec<&mut Element> = self.children.iter_mut().collect();
        while let Some(child) = open.pop() {
            if child.is(element) && child.attributes.contains(&("name", name.into())) {
                return Some(child);
            }
            open.extend(child.children.iter_mut());
        }
        None
    }

    /// Returns a value of an attribute, here or in a child, that XML cannot have.
    pub fn unwritable(&self) -> Option<&str> {
        let is_forbidden =
            |c: char| c < ' ' && !"\t\n\r".contains(c) || matches!(c, '\u{fffe}' | '\u{ffff}');
        let mut open = vec![self];
        while let Some(element) = open.pop() {
            let mut values = element.attributes.iter().map(|(_, value)| value);
            if let Some(forbidden) = values.find(|value| value.contains(is_forbidden)) {
                return Some(forbidden);
            }
            open.extend(&element.children);
        }
        None
    }

    /// Prints the element with its children. Nesting takes no stack.
    pub fn print(&self, text: &mut String) {
        let mut open = vec![(self, 0, false)];
        while let Some((element, depth, is_end)) = open.pop() {
            let indent = "  ".repeat(depth.min(40));
            if is_end {
                let _ = writeln!(text, "{indent}</{}>", element.name);
                continue;
            }
            let _ = write!(text, "{indent}<{}", element.name);
            for (name, value) in &element.attributes {
                let _ = write!(text, " {name}=\"{}\"", escaped(value));
            }
            if element.children.is_empty() {
                text.push_str("/>\n");
                continue;
            }
            text.push_str(">\n");
            open.push((element, depth, true));
            open.extend(element.children.iter().rev().map(|child| (child, depth + 1, false)));
        }
    }
}

impl Drop for Element {
    /// Drops the children one after the other: nesting takes no stack.
    fn drop(&mut self) {
        let mut open = std::mem::take(&mut self.children);
        while let Some(mut element) = open.pop() {
            open.append(&mut element.children);
        }
    }
}

/// Prints a comment.
pub fn comment(comment: &str, text: &mut String) {
    // Two dashes would end the comment.
    let comment = sanitize_for_display(comment).replace("--", "- -").replace("--", "- -");
    let _ = writeln!(text, "<!-- {comment} -->");
}

/// Returns a text as the value of an attribute in double quotes.
fn escaped(value: &str) -> String {
    let mut text = String::with_capacity(value.len());
    for c in value.chars() {
        match c {
            '&' => text.push_str("&amp;"),
            '<' => text.push_str("&lt;"),
            '>' => text.push_str("&gt;"),
            '"' => text.push_str("&quot;"),
            // Tabs and ends of lines would become spaces; others could control a terminal.
            c if is_unprintable(c) => {
                let _ = write!(text, "&#{};", u32::from(c));
            }
            c => text.push(c),
        }
    }
    text
}

/// Returns the shortest text of a number that is read as the same number.
pub fn number(x: f64) -> String {
    // Negative zero is zero.
    let x = x + 0.0;
    let size = x.abs();
    if x != 0.0 && !(1e-5..1e16).contains(&size) { format!("{x:e}") } else { format!("{x}") }
}
