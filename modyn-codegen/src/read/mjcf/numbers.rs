//! Finds attributes that are not the numbers that they should be, with their places: mjcf-rs has no places, and reads
//! nothing after an error.

use std::collections::BTreeSet;

use roxmltree::{Attribute, Node};

use super::used::{NUMBERS, blank};
use crate::diagnostics::{Code, Report};

/// Returns `used`, the part of the text that is read, without the attributes that should be numbers and are not, and the
/// bodies with such attributes, by the byte offsets of their elements. The attributes are reported. Offsets in the text do
/// not change.
pub fn without_invalid_numbers(
    text: &str,
    mut used: String,
    root: Node,
    report: &mut Report<'_>,
) -> (String, BTreeSet<usize>) {
    let is_body = |node: &Node| node.has_tag_name("body");
    let mut unread = BTreeSet::new();
    let mut is_class_bad = false;
    for node in root.descendants().filter(Node::is_element) {
        for attribute in node.attributes() {
            let row = NUMBERS.iter().find(|(name, _)| *name == attribute.name());
            // An attribute that is not used is blank.
            let is_used = !used[attribute.range()].starts_with(' ');
            let Some((_, count)) = row.filter(|_| is_used) else { continue };
            if is_valid(text, attribute, *count, report) {
                continue;
            }
            blank(&mut used, attribute.range());
            let body = node.ancestors().find(is_body).map(|body| body.range().start);
            is_class_bad |= body.is_none();
            unread.extend(body);
        }
    }
    if is_class_bad {
        // Any body may have elements of the class.
        unread.extend(root.descendants().filter(is_body).map(|body| body.range().start));
    }
    (used, unread)
}

/// Returns whether an attribute has numbers only, and as many as it should; if not, it is reported.
fn is_valid(
    text: &str,
    attribute: Attribute,
    count: Option<usize>,
    report: &mut Report<'_>,
) -> bool {
    let (name, value, place) = (attribute.name(), attribute.value(), attribute.range_value());
    let errors = report.errors();
    let (mut rest, mut found) = (value, 0);
    while let Some(word) = rest.split_ascii_whitespace().next() {
        let skipped = rest.len() - rest.trim_ascii_start().len();
        let offset = value.len() - rest.len() + skipped;
        rest = &rest[skipped + word.len()..];
        found += 1;
        if word.parse::<f64>().is_err() {
            // A value with entities is longer in the text.
            let is_text = text[place.clone()] == *value;
            let at = place.start + if is_text { offset } else { 0 };
            let message = format!("`{word}` is not a number");
            let help = "write a decimal number such as `0.25` or `2.5e-1`";
            report.error(Code::BadNumber, at, None, message, help);
        }
    }
    if let Some(count) = count.filter(|&count| count != found && report.errors() == errors) {
        let message = format!("the number of values of `{name}` is {found}, not {count}");
        let help = match name {
            "damping" | "stiffness" if found > 1 => {
                "write the first value alone: coefficients of higher powers are not read; give their torques with the \
                 others"
            }
            _ => "write a decimal number for each, separated by spaces",
        };
        report.error(Code::NumberCount, place.start, None, message, help);
    }
    report.errors() == errors
}
