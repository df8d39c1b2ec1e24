//! The part of a model that is read. mjcf-rs reads more, and its errors about the rest would have no use and no place.

use std::ops::Range;

use roxmltree::Node;

/// The elements that are read.
const ELEMENTS: [&str; 13] = [
    "mujoco",
    "compiler",
    "option",
    "default",
    "asset",
    "hfield",
    "worldbody",
    "body",
    "frame",
    "inertial",
    "joint",
    "freejoint",
    "geom",
];

/// The attributes that contain numbers only, and how many; `None` if that depends.
pub const NUMBERS: [(&str, Option<usize>); 23] = [
    ("pos", Some(3)),
    ("quat", Some(4)),
    ("axisangle", Some(4)),
    ("euler", Some(3)),
    ("xyaxes", Some(6)),
    ("zaxis", Some(3)),
    ("axis", Some(3)),
    ("range", Some(2)),
    ("actuatorfrcrange", Some(2)),
    ("ref", Some(1)),
    ("armature", Some(1)),
    ("damping", Some(1)),
    ("frictionloss", Some(1)),
    ("stiffness", Some(1)),
    ("springdamper", Some(2)),
    ("mass", Some(1)),
    ("diaginertia", Some(3)),
    ("fullinertia", Some(6)),
    ("size", None),
    ("fromto", Some(6)),
    ("density", Some(1)),
    ("gravcomp", Some(1)),
    ("gravity", Some(3)),
];

/// The attributes that are read, besides those of numbers.
const WORDS: [&str; 14] = [
    "angle",
    "autolimits",
    "childclass",
    "class",
    "coordinate",
    "eulerseq",
    "file",
    "hfield",
    "inertiafromgeom",
    "limited",
    "mesh",
    "model",
    "name",
    "type",
];

/// Returns the text with spaces in place of the elements and attributes that are not read. Offsets in the text do not
/// change.
pub fn without_unused_parts(text: &str, root: Node) -> String {
    let is_used = |name| WORDS.contains(&name) || NUMBERS.iter().any(|(number, _)| *number == name);
    let mut used = text.to_string();
    let mut open = vec![root];
    while let Some(node) = open.pop() {
        if !ELEMENTS.contains(&node.tag_name().name()) {
            blank(&mut used, node.range());
            continue;
        }
        for attribute in node.attributes().filter(|one| !is_used(one.name())) {
            blank(&mut used, attribute.range());
        }
        open.extend(node.children().filter(Node::is_element));
    }
    used
}

/// Replaces a part of the text by spaces.
pub fn blank(text: &mut String, range: Range<usize>) {
    let spaces = " ".repeat(range.len());
    text.replace_range(range, &spaces);
}
