//! The links and joints as they are written, each figure checked by itself.
//!
//! What could not be read stands in as its default, so that reading can go on and find the next
//! error; the report holds the reason, and nothing is built from it.

use modyn_runtime::{
    joint::JointType,
    model::{Inertial, Limits},
    spatial::Pose,
};
use roxmltree::Node;

use super::{Mimic, ReadOptions, document::is, nearest::nearest, numbers::numbers, report::Report};
use crate::error::{Code, Severity, Subject};

/// A robot in parts.
pub struct Parts<'a> {
    pub name: &'a str,
    /// Where the robot begins.
    pub at: usize,
    pub links: Vec<LinkPart<'a>>,
    pub joints: Vec<JointPart<'a>>,
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

/// A `<joint>`.
pub struct JointPart<'a> {
    pub name: Located<'a>,
    pub kind: Kind,
    /// `None` where it is missing.
    pub parent: Option<Located<'a>>,
    /// `None` where it is missing.
    pub child: Option<Located<'a>>,
    pub origin: Pose<f64>,
    /// Of unit length.
    pub axis: [f64; 3],
    pub limits: Option<Limits>,
    /// The joint it mimics.
    pub mimic: Option<Located<'a>>,
}

/// What a joint does.
#[derive(Clone, Copy, PartialEq)]
pub enum Kind {
    Fixed,
    Moving(JointType),
    /// It could not be read.
    Unknown,
}

impl JointPart<'_> {
    pub fn subject(&self) -> Subject {
        Subject::Joint(self.name.text.into())
    }
}

impl LinkPart<'_> {
    pub fn subject(&self) -> Subject {
        Subject::Link(self.name.text.into())
    }
}

/// Reads the parts of a `<robot>`.
pub fn read<'a>(robot: Node<'a, '_>, options: &ReadOptions, report: &mut Report<'_>) -> Parts<'a> {
    let at = robot.range().start;
    let mut reader = Reader { robot, options, report };
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
    let mut parts = Parts { name, at, links: Vec::new(), joints: Vec::new() };
    for node in robot.children() {
        if is(robot, node, "link") {
            parts.links.extend(reader.link(node));
        } else if is(robot, node, "joint") {
            parts.joints.push(reader.joint(node));
        }
    }
    parts
}

struct Reader<'a, 't, 'r, 'f> {
    robot: Node<'a, 't>,
    options: &'r ReadOptions,
    report: &'r mut Report<'f>,
}

impl<'a> Reader<'a, '_, '_, '_> {
    fn link(&mut self, node: Node<'a, '_>) -> Option<LinkPart<'a>> {
        let name = self.attribute(node, "name", None);
        let subject = name.map(|name| Subject::Link(name.text.into()));
        self.misspelt(node, &["inertial", "visual", "collision"], &["inertial"], subject.as_ref());
        let inertial = self.single(node, "inertial", subject.as_ref());
        let inertial = inertial.map(|node| self.inertial(node, subject.as_ref()));
        Some(LinkPart { name: name?, inertial })
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

    fn joint(&mut self, node: Node<'a, '_>) -> JointPart<'a> {
        let name = self.attribute(node, "name", None);
        let subject = name.map(|name| Subject::Joint(name.text.into()));
        let subject = subject.as_ref();
        let kind = self.kind(node, subject);
        let known = [
            "origin",
            "parent",
            "child",
            "axis",
            "limit",
            "mimic",
            "dynamics",
            "calibration",
            "safety_controller",
        ];
        self.misspelt(node, &known, &["origin", "axis", "limit", "mimic"], subject);
        let mut joint = JointPart {
            name: name.unwrap_or(Located { text: "", at: node.range().start }),
            kind,
            parent: self.end(node, "parent", subject),
            child: self.end(node, "child", subject),
            origin: self.origin(node, subject),
            axis: [1.0, 0.0, 0.0],
            limits: None,
            mimic: None,
        };
        // A fixed joint has none of these, whatever is written.
        if let Kind::Moving(joint_type) = kind {
            joint.axis = self.axis(node, subject);
            joint.limits = self.limits(node, joint_type, subject);
            joint.mimic = self.mimic(node, subject);
        }
        joint
    }

    fn kind(&mut self, node: Node<'a, '_>, subject: Option<&Subject>) -> Kind {
        const SUPPORTED: &str = "supported are: revolute, continuous, prismatic, fixed";
        let Some(text) = self.attribute(node, "type", subject) else {
            return Kind::Unknown;
        };
        match text.text {
            "revolute" => return Kind::Moving(JointType::Revolute),
            "continuous" => return Kind::Moving(JointType::Continuous),
            "prismatic" => return Kind::Moving(JointType::Prismatic),
            "fixed" => return Kind::Fixed,
            "floating" | "planar" | "spherical" => {
                let message = format!("joints of type `{}` are not supported yet", text.text);
                self.report.error(Code::UnsupportedJointType, text.at, subject, message, SUPPORTED);
            }
            other => {
                let message = format!("`{other}` is no joint type");
                self.report.error(Code::UnknownJointType, text.at, subject, message, SUPPORTED);
            }
        }
        Kind::Unknown
    }

    fn end(
        &mut self,
        node: Node<'a, '_>,
        name: &str,
        subject: Option<&Subject>,
    ) -> Option<Located<'a>> {
        let node = self.required(node, name, "link=\"...\"", subject)?;
        self.attribute(node, "link", subject)
    }

    /// The `<origin>` of this element; identity where there is none.
    fn origin(&mut self, node: Node<'a, '_>, subject: Option<&Subject>) -> Pose<f64> {
        let Some(node) = self.single(node, "origin", subject) else {
            return Pose::identity();
        };
        if let Some(attribute) = node.attribute_node("quat_xyzw") {
            let message = "`quat_xyzw` is not read, so the rotation would be lost";
            let help = "write the rotation as `rpy=\"roll pitch yaw\"`";
            self.report.error(Code::NotRead, attribute.range().start, subject, message, help);
        }
        self.known(node, &["xyz", "rpy", "quat_xyzw"], subject);
        let mut three = |name| {
            let text = located(node, name)?;
            self.numbers(text, subject)
        };
        let translation = three("xyz").unwrap_or_default();
        let [roll, pitch, yaw] = three("rpy").unwrap_or_default();
        Pose { rotation: roll_pitch_yaw(roll, pitch, yaw), translation }
    }

    /// The axis, of unit length.
    fn axis(&mut self, node: Node<'a, '_>, subject: Option<&Subject>) -> [f64; 3] {
        const X: [f64; 3] = [1.0, 0.0, 0.0];
        let Some(node) = self.single(node, "axis", subject) else {
            return X;
        };
        self.known(node, &["xyz"], subject);
        let Some(text) = self.attribute(node, "xyz", subject) else {
            return X;
        };
        let Some(axis) = self.numbers::<3>(text, subject) else {
            return X;
        };
        // Scaled first, so that no square overflows or vanishes.
        let largest = axis.iter().fold(0.0, |max: f64, x| max.max(x.abs()));
        if largest == 0.0 {
            let help = "write the direction of the axis, such as `0 0 1`";
            self.report.error(Code::ZeroAxis, text.at, subject, "the axis is zero", help);
            return X;
        }
        let scaled = axis.map(|x| x / largest);
        let scaled_length = libm::sqrt(scaled.iter().map(|x| x * x).sum());
        let unit = scaled.map(|x| x / scaled_length);
        let length = largest * scaled_length;
        if (length - 1.0).abs() > 1e-6 {
            let message = format!("the axis is of length {length}; it is normalised");
            let help = format!("write `{} {} {}`", unit[0], unit[1], unit[2]);
            self.report.add(Severity::Warning, Code::AxisLength, text.at, subject, message, help);
        }
        unit
    }

    fn limits(
        &mut self,
        node: Node<'a, '_>,
        joint_type: JointType,
        subject: Option<&Subject>,
    ) -> Option<Limits> {
        let node = self.single(node, "limit", subject)?;
        let names =
            ["lower", "upper", "velocity", "effort", "acceleration", "deceleration", "jerk"];
        self.known(node, &names, subject);
        let mut figure = |name| {
            let text = located(node, name)?;
            self.numbers::<1>(text, subject).map(|[value]| value)
        };
        // URDF's defaults: a bound that is not written is 0; no figure for speed or effort is
        // refused by some readers and no limit for others: no limit here.
        let (mut lower, mut upper) = (None, None);
        if joint_type != JointType::Continuous {
            lower = Some(figure("lower").unwrap_or(0.0));
            upper = Some(figure("upper").unwrap_or(0.0));
        }
        let velocity = figure("velocity");
        let effort = figure("effort");
        if let (Some(lower), Some(upper)) = (lower, upper)
            && lower > upper
        {
            let at = node.range().start;
            let message = format!("the lower limit {lower} is above the upper limit {upper}");
            let help = "exchange them; a bound that is not written is 0";
            self.report.add(Severity::Warning, Code::InvertedLimits, at, subject, message, help);
        }
        Some(Limits { lower, upper, velocity, effort })
    }

    fn mimic(&mut self, node: Node<'a, '_>, subject: Option<&Subject>) -> Option<Located<'a>> {
        let node = self.single(node, "mimic", subject)?;
        let target = located(node, "joint").unwrap_or(Located { text: "", at: node.range().start });
        if self.options.mimic == Mimic::Refuse {
            let message = format!("it mimics joint `{}`, which is not supported", target.text);
            let help = "remove `<mimic>`, or set the option `mimic = independent`: \
                        the joint is then moved by its own coordinate";
            self.report.error(Code::Mimic, node.range().start, subject, message, help);
        }
        Some(target)
    }

    /// An attribute that must be there and not empty.
    fn attribute(
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

    fn numbers<const N: usize>(
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

    /// The child element of this name; an error where there are several.
    fn single<'t>(
        &mut self,
        node: Node<'a, 't>,
        name: &str,
        subject: Option<&Subject>,
    ) -> Option<Node<'a, 't>> {
        let mut found = node.children().filter(|child| is(self.robot, *child, name));
        let first = found.next()?;
        if let Some(second) = found.next() {
            let line = self.report.position(first.range().start).line;
            let message = format!("a second `<{name}>`; the first is in line {line}");
            let help = "leave one of them";
            self.report.error(Code::RepeatedElement, second.range().start, subject, message, help);
        }
        Some(first)
    }

    /// The same; an error where there is none.
    fn required<'t>(
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
    fn known(&mut self, node: Node<'a, '_>, names: &[&str], subject: Option<&Subject>) {
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

    /// Warns of elements that look like one that is optional: it would silently be missing.
    /// (Others are extensions, which abound.)
    fn misspelt(
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

fn located<'a>(node: Node<'a, '_>, name: &str) -> Option<Located<'a>> {
    let attribute = node.attribute_node(name)?;
    Some(Located { text: attribute.value(), at: attribute.range().start })
}

/// `Rz(yaw) Ry(pitch) Rx(roll)`. Sines are libm's, so that every host has the same figures.
fn roll_pitch_yaw(roll: f64, pitch: f64, yaw: f64) -> [[f64; 3]; 3] {
    let (sr, cr) = libm::sincos(roll);
    let (sp, cp) = libm::sincos(pitch);
    let (sy, cy) = libm::sincos(yaw);
    [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
}
