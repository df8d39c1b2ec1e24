//! Finds words that should be numbers, with their places: mjcf-rs has no places, and reads nothing after an error.

use std::collections::BTreeSet;

use roxmltree::Node;

use crate::diagnostics::{Code, Report};

/// The attributes of bodies and their child elements that contain numbers only.
const NUMBERS: [&str; 19] = [
    "pos",
    "quat",
    "axisangle",
    "euler",
    "xyaxes",
    "zaxis",
    "axis",
    "range",
    "ref",
    "armature",
    "damping",
    "frictionloss",
    "mass",
    "diaginertia",
    "fullinertia",
    "size",
    "fromto",
    "density",
    "gravcomp",
];

/// Returns the text with a stand-in for each word that should be a number, and the bodies with such words, by the byte
/// offsets of their elements. The words are reported. Offsets in the text do not change.
pub fn replace_invalid_numbers(
    text: &str,
    root: Node,
    report: &mut Report<'_>,
) -> (String, BTreeSet<usize>) {
    let mut repaired = text.to_string();
    let mut unread = BTreeSet::new();
    let worlds = root.children().filter(|node| node.has_tag_name("worldbody"));
    for node in worlds.flat_map(|world| world.descendants()).filter(Node::is_element) {
        let numbers = node.attributes().filter(|one| NUMBERS.contains(&one.name()));
        for place in numbers.map(|one| one.range_value()) {
            let mut rest = &text[place.clone()];
            while let Some(word) = rest.split_ascii_whitespace().next() {
                let skipped = rest.len() - rest.trim_ascii_start().len();
                let at = place.end - rest.len() + skipped;
                rest = &rest[skipped + word.len()..];
                // mjcf-rs resolves entities.
                if word.contains('&') || word.parse::<f64>().is_ok() {
                    continue;
                }
                let message = format!("`{word}` is not a number");
                let help = "write a decimal number such as `0.25` or `2.5e-1`";
                report.error(Code::BadNumber, at, None, message, help);
                let stand_in = format!("1{}", " ".repeat(word.len() - 1));
                repaired.replace_range(at..at + word.len(), &stand_in);
                let body = node.ancestors().find(|node| node.has_tag_name("body"));
                unread.extend(body.map(|body| body.range().start));
            }
        }
    }
    (repaired, unread)
}
