//! Rejects elements and attributes that change the dynamics but are not read, and trees that are too deep.

use std::collections::BTreeSet;

use roxmltree::{Attribute, Node};

use crate::diagnostics::{Code, Place, Report};

/// The largest nesting depth: deeper trees could overflow the call stack of a recursive reader.
const MAX_DEPTH: usize = 100;

/// The context of an element, which determines its possible children.
#[derive(Clone, Copy, PartialEq)]
enum ElementKind {
    Root,
    Compiler,
    Option,
    Flag,
    Default,
    World,
    Body,
    Frame,
    Equality,
    Tendon,
    Actuator,
    /// An element whose content has no effect on the dynamics, unless it includes other files.
    Ignored,
}

/// Attributes by which a tendon exerts forces, or may do so through its class.
const FORCE_ATTRIBUTES: [&str; 5] = ["stiffness", "damping", "frictionloss", "armature", "class"];

/// Reports all such elements and attributes under `root`.
pub fn scan(root: Node, report: &mut Report<'_>) {
    let classes: BTreeSet<&str> = root
        .descendants()
        .filter(|node| node.has_tag_name("default"))
        .filter_map(|node| node.attribute("class"))
        .chain(["main"])
        .collect();
    let mut unread = UNREAD.map(|_| Vec::new());
    let mut open = vec![(root, ElementKind::Root, 0)];
    while let Some((node, place, depth)) = open.pop() {
        if depth > MAX_DEPTH {
            let message = format!("elements are nested more than {MAX_DEPTH} deep");
            let help = "make the tree less deep, or use URDF for long chains";
            report.error(Code::NotRead, node.range().start, None, message, help);
            return;
        }
        for attribute in node.attributes() {
            check(node, place, attribute, &classes, report);
        }
        for child in node.children().filter(Node::is_element) {
            match kind_of_child(place, child) {
                Ok(inside) => open.push((child, inside, depth + 1)),
                Err(help) => {
                    let name = child.tag_name().name();
                    let message = match place {
                        ElementKind::Equality => {
                            format!("the constraint `<{name}>` of `<equality>` is not read")
                        }
                        _ => format!("`<{name}>` is not read"),
                    };
                    report.error(Code::NotRead, child.range().start, None, message, help);
                }
            }
            if let Some(kind) = UNREAD.iter().position(|kind| kind.contains(place, node, child)) {
                unread[kind].push(child.range().start);
            }
        }
    }
    for (kind, mut places) in UNREAD.iter().zip(unread) {
        places.sort_unstable();
        let places: Vec<Place> = places.into_iter().map(|at| (Some(at), None)).collect();
        report.warn_once(Code::NotRead, &places, kind.message, kind.help);
    }
}

/// Elements that have no effect on the equations of motion and are not read, although a program may need them.
struct Unread {
    /// The elements that contain them.
    parents: &'static [&'static str],
    /// Their names; none for all names.
    names: &'static [&'static str],
    message: &'static str,
    help: &'static str,
}

impl Unread {
    fn contains(&self, place: ElementKind, parent: Node, child: Node) -> bool {
        let name = child.tag_name().name();
        place != ElementKind::Default
            && self.parents.contains(&parent.tag_name().name())
            && (self.names.is_empty() || self.names.contains(&name))
    }
}

const UNREAD: [Unread; 3] = [
    Unread {
        parents: &["actuator"],
        names: &[],
        message: "the actuator is not read, nor is its range of forces",
        help: "compute the joint forces of the actuators, which are the argument `tau` of the dynamics",
    },
    Unread {
        parents: &["worldbody", "body", "frame"],
        names: &["site"],
        message: "the site is not read",
        help: "write a `<body>` without joints in its place: it has poses, velocities and Jacobians",
    },
    Unread {
        parents: &["keyframe"],
        names: &["key"],
        message: "the keyframe is not read",
        help: "copy its `qpos` and `qvel` into the program, and convert those of free and ball joints by the functions of \
               `modyn::conventions::mujoco`",
    },
];

/// Returns the context of a child, or the advice to its author.
fn kind_of_child(place: ElementKind, child: Node) -> Result<ElementKind, &'static str> {
    let inactive = child.attribute("active") == Some("false");
    match (place, child.tag_name().name()) {
        (_, "include" | "attach") | (ElementKind::Ignored, "model") => Err(
            "no other file is read: copy its contents into this file; `mj_saveLastXML` writes such a file",
        ),
        (ElementKind::Root, "compiler") => Ok(ElementKind::Compiler),
        (ElementKind::Root, "option") => Ok(ElementKind::Option),
        (ElementKind::Default, "default") if child.attribute("class").is_none() => {
            Err("write its `class`")
        }
        (ElementKind::Root | ElementKind::Default, "default") => Ok(ElementKind::Default),
        (ElementKind::Root, "worldbody") => Ok(ElementKind::World),
        (ElementKind::Root, "equality") => Ok(ElementKind::Equality),
        (ElementKind::Root, "tendon") => Ok(ElementKind::Tendon),
        (ElementKind::Root, "actuator") => Ok(ElementKind::Actuator),
        (
            ElementKind::Root,
            "size" | "statistic" | "visual" | "custom" | "asset" | "contact" | "sensor"
            | "keyframe",
        )
        | (
            ElementKind::World | ElementKind::Body | ElementKind::Frame,
            "geom" | "site" | "camera" | "light",
        )
        | (ElementKind::Body, "inertial" | "joint" | "freejoint")
        | (ElementKind::Actuator | ElementKind::Ignored, _) => Ok(ElementKind::Ignored),
        (ElementKind::World | ElementKind::Body | ElementKind::Frame, "body") => {
            Ok(ElementKind::Body)
        }
        (ElementKind::World | ElementKind::Body | ElementKind::Frame, "frame") => {
            Ok(ElementKind::Frame)
        }
        (ElementKind::Option, "flag") => Ok(ElementKind::Flag),
        (ElementKind::Equality, _) if inactive => Ok(ElementKind::Ignored),
        (ElementKind::Equality, "connect" | "weld") => Err(
            "remove it, or write `active=\"false\"`, and close the loop by the option `loops`: `\"name\": \
             spherical(\"body1\", [x, y, z], \"body2\", [x, y, z])` for `<connect>`, `fixed(..)` for `<weld>`",
        ),
        (ElementKind::Equality, "joint") => Err(
            "remove it, or write `active=\"false\"`: both joints then move freely. A joint that follows another is \
             `<mimic>` in a URDF; no option makes one of an MJCF",
        ),
        (ElementKind::Equality, _) => Err("remove it, or write `active=\"false\"`"),
        // A tendon without these attributes only measures.
        (ElementKind::Tendon, _) | (ElementKind::Default, "tendon")
            if child.attributes().all(|one| !FORCE_ATTRIBUTES.contains(&one.name())) =>
        {
            Ok(ElementKind::Ignored)
        }
        (ElementKind::Tendon, _) | (ElementKind::Default, "tendon") => {
            Err("tendons that pull are not supported: remove it")
        }
        // The joints of bodies contain everything that matters after classes are resolved.
        (ElementKind::Default, _) => Ok(ElementKind::Ignored),
        (ElementKind::Frame, "inertial" | "joint" | "freejoint") => Err("write it in a `<body>`"),
        _ => Err("it could change the dynamics: remove it, or replace it by supported elements"),
    }
}

/// Reports attributes that change the dynamics but are not read.
fn check(
    node: Node,
    place: ElementKind,
    attribute: Attribute,
    classes: &BTreeSet<&str>,
    report: &mut Report<'_>,
) {
    let (name, value) = (attribute.name(), attribute.value());
    let zero = || value.split_ascii_whitespace().all(|text| text.parse() == Ok(0.0));
    let below = || value.trim().parse().is_ok_and(|number: f64| number <= 0.0);
    let element = node.tag_name().name();
    let help = match (place, name) {
        (ElementKind::Compiler, "settotalmass" | "boundmass" | "boundinertia") if !below() => {
            "remove it, and write the masses and inertias that are meant"
        }
        (ElementKind::Compiler, "balanceinertia" | "alignfree") if value != "false" => {
            "write `false`, and the inertias and frames that are meant"
        }
        (ElementKind::Compiler, "inertiagrouprange") => {
            "remove it, and write an `<inertial>` in each body"
        }
        (ElementKind::Compiler, "eulerseq")
            if value.len() != 3 || !value.bytes().all(|byte| b"xyzXYZ".contains(&byte)) =>
        {
            "write three of the letters x, y, z, X, Y and Z"
        }
        (ElementKind::Ignored, "shellinertia") if value != "false" => {
            "write `false`, and an `<inertial>` in the body"
        }
        (ElementKind::Option, "density" | "viscosity") if !zero() => {
            "forces of a fluid are not supported: write 0"
        }
        (ElementKind::Flag, "gravity") if value != "enable" => {
            "remove it, and write `<option gravity=\"0 0 0\">`"
        }
        (ElementKind::Body, "gravcomp") if node.has_tag_name("body") && !zero() => {
            "forces against gravity are not supported: write 0, and give them as torques"
        }
        // The frame of a body with children is not aligned.
        (ElementKind::Ignored, "align")
            if value == "true" && node.has_tag_name("freejoint") && is_leaf(node.parent()) =>
        {
            "write `align=\"false\"`: the coordinates are then those of the body's frame, not of the frame along its \
             principal axes of inertia"
        }
        (ElementKind::Ignored, "limited" | "actuatorfrclimited")
            if !["true", "false", "auto"].contains(&value) =>
        {
            "write `true`, `false` or `auto`"
        }
        (ElementKind::Compiler, "autolimits") if !["true", "false"].contains(&value) => {
            "write `true` or `false`"
        }
        (ElementKind::Body, "mocap") if value != "false" => {
            "mocap bodies are not supported: remove the attribute or the body"
        }
        (ElementKind::Ignored, "armature" | "damping")
            if node.parent().is_some_and(|parent| parent.has_tag_name("actuator")) && !zero() =>
        {
            "move it to the `<joint>`"
        }
        (ElementKind::Default, "class")
            if value != "main" && node.parent().is_some_and(|up| up.has_tag_name("mujoco")) =>
        {
            "the outermost `<default>` is the class `main`"
        }
        (ElementKind::Body | ElementKind::Frame, "childclass")
        | (ElementKind::Ignored, "class")
            if !classes.contains(value) =>
        {
            "write the class of a `<default>` of this file"
        }
        _ => return,
    };
    let message = format!("`{name}=\"{value}\"` of `<{element}>` is not read");
    report.error(Code::NotRead, attribute.range().start, None, message, help);
}

/// Returns whether a body has no other bodies in it.
fn is_leaf(body: Option<Node>) -> bool {
    body.is_some_and(|body| !body.descendants().skip(1).any(|node| node.has_tag_name("body")))
}
