//! Rejects elements and attributes that change the dynamics but are not read, and trees that are too deep.

use std::collections::BTreeSet;

use roxmltree::{Attribute, Node};

use crate::diagnostics::{Code, Report};

/// The largest nesting depth: deeper trees could overflow the call stack of a recursive reader.
const DEEPEST: usize = 100;

/// The context of an element, which determines its possible children.
#[derive(Clone, Copy, PartialEq)]
enum Place {
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
    Beside,
}

/// Attributes by which a tendon exerts forces, or may do so through its class.
const PULLS: [&str; 5] = ["stiffness", "damping", "frictionloss", "armature", "class"];

/// Reports all such elements and attributes under `root`.
pub fn scan(root: Node, report: &mut Report<'_>) {
    let classes: BTreeSet<&str> = root
        .descendants()
        .filter(|node| node.has_tag_name("default"))
        .filter_map(|node| node.attribute("class"))
        .chain(["main"])
        .collect();
    let mut open = vec![(root, Place::Root, 0)];
    while let Some((node, place, depth)) = open.pop() {
        if depth > DEEPEST {
            let message = format!("elements are nested more than {DEEPEST} deep");
            let help = "make the tree less deep, or use URDF for long chains";
            report.error(Code::NotRead, node.range().start, None, message, help);
            return;
        }
        for attribute in node.attributes() {
            check(node, place, attribute, &classes, report);
        }
        for child in node.children().filter(Node::is_element) {
            match place_of(place, child) {
                Ok(inside) => open.push((child, inside, depth + 1)),
                Err(help) => {
                    let message = format!("`<{}>` is not read", child.tag_name().name());
                    report.error(Code::NotRead, child.range().start, None, message, help);
                }
            }
        }
    }
}

/// Returns the context of a child, or the advice to its author.
fn place_of(place: Place, child: Node) -> Result<Place, &'static str> {
    let inactive = child.attribute("active") == Some("false");
    match (place, child.tag_name().name()) {
        (_, "include" | "attach") | (Place::Beside, "model") => Err(
            "no other file is read: copy its contents into this file; `mj_saveLastXML` writes such a file",
        ),
        (Place::Root, "compiler") => Ok(Place::Compiler),
        (Place::Root, "option") => Ok(Place::Option),
        (Place::Default, "default") if child.attribute("class").is_none() => {
            Err("write its `class`")
        }
        (Place::Root | Place::Default, "default") => Ok(Place::Default),
        (Place::Root, "worldbody") => Ok(Place::World),
        (Place::Root, "equality") => Ok(Place::Equality),
        (Place::Root, "tendon") => Ok(Place::Tendon),
        (Place::Root, "actuator") => Ok(Place::Actuator),
        (
            Place::Root,
            "size" | "statistic" | "visual" | "custom" | "asset" | "contact" | "sensor"
            | "keyframe",
        )
        | (Place::World | Place::Body | Place::Frame, "geom" | "site" | "camera" | "light")
        | (Place::Body, "inertial" | "joint" | "freejoint")
        | (Place::Actuator | Place::Beside, _) => Ok(Place::Beside),
        (Place::World | Place::Body | Place::Frame, "body") => Ok(Place::Body),
        (Place::World | Place::Body | Place::Frame, "frame") => Ok(Place::Frame),
        (Place::Option, "flag") => Ok(Place::Flag),
        (Place::Equality, _) if inactive => Ok(Place::Beside),
        (Place::Equality, _) => Err(
            "constraints are not part of a tree's dynamics: remove it, or write `active=\"false\"`",
        ),
        // A tendon without these attributes only measures.
        (Place::Tendon, _) | (Place::Default, "tendon")
            if child.attributes().all(|one| !PULLS.contains(&one.name())) =>
        {
            Ok(Place::Beside)
        }
        (Place::Tendon, _) | (Place::Default, "tendon") => {
            Err("tendons that pull are not supported: remove it")
        }
        // The joints of bodies contain everything that matters after classes are resolved.
        (Place::Default, _) => Ok(Place::Beside),
        (Place::Frame, "inertial" | "joint" | "freejoint") => Err("write it in a `<body>`"),
        _ => Err("it could change the dynamics: remove it, or replace it by supported elements"),
    }
}

/// Reports attributes that change the dynamics but are not read.
fn check(
    node: Node,
    place: Place,
    attribute: Attribute,
    classes: &BTreeSet<&str>,
    report: &mut Report<'_>,
) {
    let (name, value) = (attribute.name(), attribute.value());
    let zero = || value.split_ascii_whitespace().all(|text| text.parse() == Ok(0.0));
    let below = || value.trim().parse().is_ok_and(|number: f64| number <= 0.0);
    let element = node.tag_name().name();
    let help = match (place, name) {
        (Place::Compiler, "settotalmass" | "boundmass" | "boundinertia") if !below() => {
            "write the masses and inertias that are meant"
        }
        (Place::Compiler, "balanceinertia" | "alignfree") if value != "false" => {
            "write the inertias and frames that are meant"
        }
        (Place::Compiler, "inertiagrouprange") => "write an `<inertial>` in each body",
        (Place::Compiler, "eulerseq")
            if value.len() != 3 || !value.bytes().all(|byte| b"xyzXYZ".contains(&byte)) =>
        {
            "write three of the letters x, y, z, X, Y and Z"
        }
        (Place::Beside, "shellinertia") if value != "false" => "write an `<inertial>` in the body",
        (Place::Option, "density" | "viscosity") if !zero() => {
            "forces of a fluid are not supported: write 0"
        }
        (Place::Flag, "gravity") if value != "enable" => "write `<option gravity=\"0 0 0\">`",
        (Place::Body, "gravcomp") if node.has_tag_name("body") && !zero() => {
            "forces against gravity are not supported: give them as torques"
        }
        (Place::Body, "mocap") if value != "false" => {
            "mocap bodies are not supported: remove the attribute or the body"
        }
        (Place::Beside, "armature" | "damping")
            if node.parent().is_some_and(|parent| parent.has_tag_name("actuator")) && !zero() =>
        {
            "write it in the `<joint>`"
        }
        (Place::Default, "class")
            if value != "main" && node.parent().is_some_and(|up| up.has_tag_name("mujoco")) =>
        {
            "the outermost `<default>` is the class `main`"
        }
        (Place::Body | Place::Frame, "childclass") | (Place::Beside, "class")
            if !classes.contains(value) =>
        {
            "write the class of a `<default>` of this file"
        }
        _ => return,
    };
    let message = format!("`{name}=\"{value}\"` of `<{element}>` is not read");
    report.error(Code::NotRead, attribute.range().start, None, message, help);
}
