//! The links and joints as they are written, each figure checked by itself.
//!
//! What could not be read stands in as its default, so that reading can go on and find the next
//! error; the report holds the reason, and nothing is built from it.

use modyn_runtime::{joint::JointType, model::Inertial, spatial::Pose};
use roxmltree::Node;
use rustc_hash::FxHashMap;

use super::{
    ReadOptions,
    document::is,
    joint::{JointPart, Kind},
    loops::LoopPart,
    nearest::nearest,
    numbers::numbers,
    report::{Place, Report},
};
use crate::error::{Code, Severity, Subject};

/// A robot in parts.
pub struct Parts<'a> {
    pub name: &'a str,
    /// Where the robot begins.
    pub at: usize,
    pub links: Vec<LinkPart<'a>>,
    pub joints: Vec<JointPart<'a>>,
    pub loops: Vec<LoopPart<'a>>,
}

impl<'a> Parts<'a> {
    /// The joints' indices by their names; the first of a name counts.
    pub fn joints_by_name(&self) -> FxHashMap<&'a str, usize> {
        let mut indices = FxHashMap::default();
        for (i, joint) in self.joints.iter().enumerate() {
            indices.entry(joint.name.text).or_insert(i);
        }
        indices
    }
}

/// A text and where it stands.
#[derive(Clone, Copy)]
pub struct Located<'a> {
    pub text: &'a str,
    pub at: usize,
}

/// A `<link>`.
pub struct LinkPart<'a> {
    pub name: Located<'a>,
    pub inertial: Option<InertialPart>,
    /// Whether the description does not have it: it stands between two joints of one body, and is massless.
    pub auxiliary: bool,
}

/// An `<inertial>`, in its link's frame.
pub struct InertialPart {
    pub inertial: Inertial,
    /// Where it stands.
    pub at: usize,
    /// Where the mass stands.
    pub mass_at: usize,
    /// Whether all of it could be read.
    pub sound: bool,
}

impl LinkPart<'_> {
    pub fn subject(&self) -> Subject {
        Subject::Link(self.name.text.into())
    }
}

/// Reads the parts of a `<robot>`.
pub fn read<'a>(robot: Node<'a, '_>, options: &ReadOptions, report: &mut Report<'_>) -> Parts<'a> {
    let at = robot.range().start;
    let mut reader = Reader { robot, options, report, negative_limits: Vec::new() };
    let name = robot.attribute("name").unwrap_or("");
    if name.trim().is_empty() {
        let help = "write `<robot name=\"...\">`; it is called `robot` here, and its type `Robot` would \
                    collide with `use modyn::Robot`, unless you name it: `modyn!(pub MyArm = \"...\")`";
        reader.report.add(
            Severity::Warning,
            Code::MissingAttribute,
            at,
            None,
            "the robot has no name",
            help,
        );
    }
    let name = if name.trim().is_empty() { "robot" } else { name };
    let (links, joints, loops) = (Vec::new(), Vec::new(), Vec::new());
    let mut parts = Parts { name, at, links, joints, loops };
    for node in robot.children() {
        if is(robot, node, "link") {
            parts.links.extend(reader.link(node));
        } else if is(robot, node, "joint") {
            parts.joints.push(reader.joint(node));
        } else if is(robot, node, "loop_joint") {
            parts.loops.push(reader.loop_joint(node));
        }
    }
    reader.surprises(&parts);
    parts
}

/// Reads elements; what a `<joint>` has is in `joint`, a `<loop_joint>` in `loops`.
pub struct Reader<'a, 't, 'r, 'f> {
    robot: Node<'a, 't>,
    pub options: &'r ReadOptions,
    pub report: &'r mut Report<'f>,
    /// Where limits of effort or velocity are negative.
    pub negative_limits: Vec<Place>,
}

impl<'a> Reader<'a, '_, '_, '_> {
    /// Warns, once a kind, of what is written and would silently mean something else.
    fn surprises(&mut self, parts: &Parts<'a>) {
        let (message, help) = (
            "a limit of effort or velocity is negative, and is not read",
            "write its size, or leave the attribute out if there is no limit",
        );
        self.report.warn_once(Code::NegativeLimit, &self.negative_limits, message, help);
        let unlimited: Vec<Place> = parts
            .joints
            .iter()
            .filter(|joint| {
                let bounded = [JointType::Revolute, JointType::Prismatic].map(Kind::Moving);
                bounded.contains(&joint.kind) && joint.limits.is_none() && joint.mimic.is_none()
            })
            .map(|joint| (joint.name.at, Some(joint.subject())))
            .collect();
        let message = "it has no `<limit>`, so it moves without end here";
        let help = "write `<limit lower=\"...\" upper=\"...\" effort=\"...\" velocity=\"...\"/>`, or make a \
                    joint that turns without end `continuous`";
        self.report.warn_once(Code::MissingLimit, &unlimited, message, help);
        let robot = self.robot;
        let read = ["link", "joint", "loop_joint"];
        let part = |node: &Node| read.iter().any(|name| is(robot, *node, name));
        let inside = robot.children().filter(part).flat_map(|part| part.children());
        let included: Vec<Place> = robot
            .children()
            .chain(inside)
            .filter(|node| node.is_element() && node.tag_name().name() == "include")
            .map(|node| (node.range().start, None))
            .collect();
        let message =
            "another file is included, which is not read: parts of the robot may be missing";
        let help = "write what is in that file into this one";
        self.report.warn_once(Code::Include, &included, message, help);
    }

    fn link(&mut self, node: Node<'a, '_>) -> Option<LinkPart<'a>> {
        let name = self.attribute(node, "name", None);
        let subject = name.map(|name| Subject::Link(name.text.into()));
        self.misspelt(node, &["inertial", "visual", "collision"], &["inertial"], subject.as_ref());
        let inertial = self.single(node, "inertial", subject.as_ref());
        let inertial = inertial.map(|node| self.inertial(node, subject.as_ref()));
        Some(LinkPart { name: name?, inertial, auxiliary: false })
    }

    fn inertial(&mut self, node: Node<'a, '_>, subject: Option<&Subject>) -> InertialPart {
        let errors = self.report.errors();
        self.misspelt(node, &["origin", "mass", "inertia"], &["origin"], subject);
        let pose = self.origin(node, subject);
        let (mut mass, mut mass_at) = (0.0, node.range().start);
        if let Some(node) = self.required(node, "mass", "value=\"1.5\"", subject) {
            mass_at = node.range().start;
            self.known(node, &["value"], subject);
            if let Some(value) = self.attribute(node, "value", subject) {
                mass_at = value.at;
                [mass] = self.numbers(value, subject).unwrap_or_default();
            }
        }
        let mut inertia = [0.0; 6];
        let names = ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"];
        let example = "ixx=\"0.1\" ixy=\"0\" ixz=\"0\" iyy=\"0.1\" iyz=\"0\" izz=\"0.1\"";
        if let Some(node) = self.required(node, "inertia", example, subject) {
            self.known(node, &names, subject);
            for (name, entry) in names.into_iter().zip(&mut inertia) {
                if let Some(text) = self.attribute(node, name, subject) {
                    [*entry] = self.numbers(text, subject).unwrap_or_default();
                }
            }
        }
        let own = Inertial { mass, center_of_mass: [0.0; 3], inertia };
        InertialPart {
            inertial: own.transformed(&pose),
            at: node.range().start,
            mass_at,
            sound: self.report.errors() == errors,
        }
    }

    /// The `<origin>` of this element; identity where there is none.
    pub fn origin(&mut self, node: Node<'a, '_>, subject: Option<&Subject>) -> Pose<f64> {
        let Some(node) = self.single(node, "origin", subject) else {
            return Pose::identity();
        };
        self.known(node, &["xyz", "rpy", "quat_xyzw"], subject);
        self.pose(node, subject)
    }

    /// The pose that this element's `xyz` and `rpy` say.
    pub fn pose(&mut self, node: Node<'a, '_>, subject: Option<&Subject>) -> Pose<f64> {
        if let Some(attribute) = node.attribute_node("quat_xyzw") {
            let message = "`quat_xyzw` is not read, so the rotation would be lost";
            let help = "write the rotation as `rpy=\"roll pitch yaw\"`";
            self.report.error(Code::NotRead, attribute.range().start, subject, message, help);
        }
        let mut three = |name| {
            let text = located(node, name)?;
            self.numbers(text, subject)
        };
        let translation = three("xyz").unwrap_or_default();
        let rotation = roll_pitch_yaw(three("rpy").unwrap_or_default());
        Pose { rotation, translation }
    }

    /// An attribute that must be there and not empty.
    pub fn attribute(
        &mut self,
        node: Node<'a, '_>,
        name: &str,
        subject: Option<&Subject>,
    ) -> Option<Located<'a>> {
        let found = located(node, name);
        if let Some(found) = found
            && !found.text.trim().is_empty()
        {
            return Some(found);
        }
        let element = node.tag_name().name();
        let state = if found.is_some() { "is empty" } else { "is missing" };
        let message = format!("the attribute `{name}` of `<{element}>` {state}");
        let at = found.map_or(node.range().start, |found| found.at);
        let help = format!("write `<{element} {name}=\"...\">`");
        self.report.error(Code::MissingAttribute, at, subject, message, help);
        None
    }

    pub fn numbers<const N: usize>(
        &mut self,
        text: Located,
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

    /// A number that need not be there.
    pub fn figure(
        &mut self,
        node: Node<'a, '_>,
        name: &str,
        subject: Option<&Subject>,
    ) -> Option<f64> {
        self.numbers::<1>(located(node, name)?, subject).map(|[value]| value)
    }

    /// The child elements of this name.
    pub fn named<'t>(&self, node: Node<'a, 't>, name: &str) -> impl Iterator<Item = Node<'a, 't>> {
        let robot = self.robot;
        node.children().filter(move |child| is(robot, *child, name))
    }

    /// The child element of this name; an error where there are several.
    pub fn single<'t>(
        &mut self,
        node: Node<'a, 't>,
        name: &str,
        subject: Option<&Subject>,
    ) -> Option<Node<'a, 't>> {
        let [first, second] = {
            let mut found = self.named(node, name);
            [found.next(), found.next()]
        };
        if let (Some(first), Some(second)) = (first, second) {
            let line = self.report.position(first.range().start).line;
            let message = format!("a second `<{name}>`; the first is in line {line}");
            let help = "leave one of them";
            self.report.error(Code::RepeatedElement, second.range().start, subject, message, help);
        }
        first
    }

    /// The same; an error where there is none.
    pub fn required<'t>(
        &mut self,
        node: Node<'a, 't>,
        name: &str,
        example: &str,
        subject: Option<&Subject>,
    ) -> Option<Node<'a, 't>> {
        let found = self.single(node, name, subject);
        if found.is_none() {
            let message = format!("`<{}>` has no `<{name}>`", node.tag_name().name());
            let help = format!("write `<{name} {example}/>`");
            self.report.error(Code::MissingElement, node.range().start, subject, message, help);
        }
        found
    }

    /// Warns of attributes that are not read: a misspelt one would silently count as 0.
    pub fn known(&mut self, node: Node<'a, '_>, names: &[&str], subject: Option<&Subject>) {
        for attribute in node.attributes() {
            if attribute.namespace().is_none() && !names.contains(&attribute.name()) {
                let element = node.tag_name().name();
                let message =
                    format!("the attribute `{}` of `<{element}>` is not read", attribute.name());
                let help = format!("`<{element}>` has: {}", names.join(", "));
                let at = attribute.range().start;
                self.report.add(Severity::Warning, Code::NotRead, at, subject, message, help);
            }
        }
    }

    /// Warns of attributes that look like one of these. (Others are extensions, which abound.)
    pub fn misspelt_attribute(
        &mut self,
        node: Node<'a, '_>,
        names: &[&str],
        subject: Option<&Subject>,
    ) {
        for attribute in node.attributes() {
            let name = attribute.name();
            if attribute.namespace().is_none()
                && !names.contains(&name)
                && name.len() > 2
                && let Some(meant) = nearest(name, names.iter().copied())
            {
                let element = node.tag_name().name();
                let message = format!("the attribute `{name}` of `<{element}>` is not read");
                let help = format!("did you mean `{meant}`?");
                let at = attribute.range().start;
                self.report.add(Severity::Warning, Code::NotRead, at, subject, message, help);
            }
        }
    }

    /// Warns of elements that look like one that is optional: it would silently be missing.
    /// (Others are extensions, which abound.)
    pub fn misspelt(
        &mut self,
        node: Node<'a, '_>,
        known: &[&str],
        optional: &[&str],
        subject: Option<&Subject>,
    ) {
        for child in node.children().filter(Node::is_element) {
            let name = child.tag_name().name();
            let own = child.tag_name().namespace() == self.robot.tag_name().namespace();
            if own
                && !known.contains(&name)
                && let Some(meant) = nearest(name, optional.iter().copied())
            {
                let message = format!("the element `<{name}>` is not read");
                let help = format!("did you mean `<{meant}>`?");
                let at = child.range().start;
                self.report.add(Severity::Warning, Code::NotRead, at, subject, message, help);
            }
        }
    }
}

/// An attribute, if it is there.
pub fn located<'a>(node: Node<'a, '_>, name: &str) -> Option<Located<'a>> {
    let attribute = node.attribute_node(name)?;
    Some(Located { text: attribute.value(), at: attribute.range().start })
}

/// `Rz(yaw) Ry(pitch) Rx(roll)`. Sines are libm's, so that every host has the same figures.
pub fn roll_pitch_yaw([roll, pitch, yaw]: [f64; 3]) -> [[f64; 3]; 3] {
    let (sr, cr) = libm::sincos(roll);
    let (sp, cp) = libm::sincos(pitch);
    let (sy, cy) = libm::sincos(yaw);
    [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
}
