//! Reads a `<joint>`.

use modyn_runtime::joint::JointType;
use modyn_runtime::model::{JointDynamics, Limits};
use roxmltree::Node;

use super::extensions::KNOWN_IN_JOINT;
use super::reader::Reader;
use crate::description::{JointRecord, Kind, Located, Mimic, MimicRecord, UNLIMITED, are_parallel};
use crate::diagnostics::{Code, Severity, Subject, suggest};
use crate::read::xml::element::{Attribute, attribute, is, is_extension};

const X: [f64; 3] = [1.0, 0.0, 0.0];
const Y: [f64; 3] = [0.0, 1.0, 0.0];
const Z: [f64; 3] = [0.0, 0.0, 1.0];

/// The types of Drake's `<drake:joint>` that are read.
const DRAKES_TYPES: [(&str, JointType); 3] = [
    ("ball", JointType::Spherical),
    ("universal", JointType::Universal),
    ("planar", JointType::Planar),
];

/// Returns whether a joint is Drake's extension.
fn is_drakes(joint: Node) -> bool {
    is(joint, "drake.joint")
}

/// Returns a joint type with its name.
fn named(joint_type: JointType) -> (&'static str, JointType) {
    (joint_type.name(), joint_type)
}

impl<'a> Reader<'a, '_, '_, '_> {
    pub fn joint(&mut self, node: Node<'a, '_>) -> JointRecord {
        let errors = self.xml.report.errors();
        let name = self.xml.attribute(node, "name", None);
        let own_subject = name.map(|name| Subject::Joint(name.text.into()));
        let subject = own_subject.as_ref();
        let kind = self.kind(node, subject);
        let optional = ["origin", "axis", "limit", "mimic", "dynamics"];
        self.unread_elements(node, KNOWN_IN_JOINT, &optional, subject);
        let mut joint = JointRecord {
            name: name.map_or(
                Located { text: String::new(), at: node.range().start },
                Attribute::located,
            ),
            kind,
            parent: self.end(node, "parent", subject).map(Attribute::located),
            child: self.end(node, "child", subject).map(Attribute::located),
            origin: self.origin(node, subject),
            axis: X,
            second_axis: Y,
            limits: None,
            mimic: None,
            dynamics: JointDynamics::default(),
            spring: None,
            actuator_forces: None,
            dynamics_at: node.range().start,
            sound: true,
        };
        // The other elements of a fixed joint have no meaning.
        if kind != Kind::Fixed {
            [joint.axis, joint.second_axis] = self.axes(node, kind, subject);
            (joint.dynamics, joint.dynamics_at) = self.joint_dynamics(node, subject);
        }
        if let Kind::Moving(joint_type) = kind {
            joint.limits = self.limits(node, joint_type, subject);
            joint.mimic = self.mimic(node, subject);
        }
        self.no_second_axis(node, kind, subject);
        joint.sound = self.xml.report.errors() == errors;
        joint
    }

    fn kind(&mut self, node: Node<'a, '_>, subject: Option<&Subject>) -> Kind {
        let Some(text) = self.xml.attribute(node, "type", subject) else {
            return Kind::Unknown;
        };
        let is_drakes = is_drakes(node);
        if text.text == "fixed" && !is_drakes {
            return Kind::Fixed;
        }
        let types = if is_drakes { &DRAKES_TYPES[..] } else { &JointType::ALL.map(named) };
        if let Some((_, kind)) = types.iter().find(|(name, _)| *name == text.text) {
            return Kind::Moving(*kind);
        }
        let mut names: Vec<&str> = types.iter().map(|(name, _)| *name).collect();
        let message = if is_drakes {
            format!("`{}` is not a type of `<drake:joint>` that is read", text.text)
        } else {
            names.push("fixed");
            format!("`{}` is not a joint type", text.text)
        };
        let help = format!("supported are: {}", names.join(", "));
        self.xml.report.error(Code::UnknownJointType, text.at, subject, message, help);
        Kind::Unknown
    }

    fn end(
        &mut self,
        node: Node<'a, '_>,
        name: &str,
        subject: Option<&Subject>,
    ) -> Option<Attribute<'a>> {
        let node = self.xml.required(node, name, &format!("<{name} link=\"...\"/>"), subject)?;
        self.xml.attribute(node, "link", subject)
    }

    /// Returns the axis and the second axis, of unit length.
    fn axes(&mut self, node: Node<'a, '_>, kind: Kind, subject: Option<&Subject>) -> [[f64; 3]; 2] {
        if is_drakes(node) && kind == Kind::Moving(JointType::Universal) {
            // Drake's has the axes x and y.
            return [X, Y];
        }
        if let Kind::Moving(JointType::Spherical | JointType::Floating) = kind {
            // The axis has no meaning here, but many files have one, often zero.
            let axis = self.xml.single(node, "axis", subject);
            if let Some(text) = axis.and_then(|axis| attribute(axis, "xyz")) {
                self.xml.numbers::<3>(text, subject);
            }
            return [Z, Y];
        }
        let first = self.axis(node, "axis", X, subject);
        if kind != Kind::Moving(JointType::Universal) {
            return [first.unwrap_or(X), Y];
        }
        let second = self.axis(node, "axis2", Y, subject);
        // An axis that could not be read is not compared.
        let Some(first) = first else { return [X, Y] };
        let Some(second) = second else { return [X, Y] };
        if are_parallel(first, second) {
            let place = ["axis2", "axis"].iter().find_map(|name| self.xml.named(node, name).next());
            let at = place.unwrap_or(node).range().start;
            let message = "its two axes are parallel";
            let help = "write `<axis2 xyz=\"...\"/>` across `<axis>`: the second axis, by default \
                        `0 1 0`; the first is `1 0 0` by default";
            self.xml.report.error(Code::ParallelAxes, at, subject, message, help);
        }
        [first, second]
    }

    /// Returns an axis of unit length; `None` if it cannot be read.
    pub fn axis(
        &mut self,
        node: Node<'a, '_>,
        name: &str,
        default: [f64; 3],
        subject: Option<&Subject>,
    ) -> Option<[f64; 3]> {
        let Some(node) = self.xml.single(node, name, subject) else {
            return Some(default);
        };
        self.xml.warn_of_unknown_attributes(node, &["xyz"], subject);
        let text = self.xml.attribute(node, "xyz", subject)?;
        let axis = self.xml.numbers::<3>(text, subject)?;
        self.xml.unit(axis, text.at, subject)
    }

    /// Warns of a second axis of a joint that has one axis only.
    fn no_second_axis(&mut self, node: Node<'a, '_>, kind: Kind, subject: Option<&Subject>) {
        if matches!(kind, Kind::Unknown | Kind::Moving(JointType::Universal)) {
            return;
        }
        if let Some(axis) = self.xml.single(node, "axis2", subject) {
            let message = "the element `<axis2>` is not read: only universal joints have two axes";
            let help = "remove it, or make the joint `universal`";
            let at = axis.range().start;
            self.xml.report.add(Severity::Warning, Code::NotRead, at, subject, message, help);
        }
    }

    fn limits(
        &mut self,
        node: Node<'a, '_>,
        joint_type: JointType,
        subject: Option<&Subject>,
    ) -> Option<Limits> {
        let node = self.xml.single(node, "limit", subject)?;
        let names =
            ["lower", "upper", "velocity", "effort", "acceleration", "deceleration", "jerk"];
        self.xml.warn_of_unknown_attributes(node, &names, subject);
        // URDF's default for a missing bound is 0. A missing limit of velocity or effort is an
        // error for some readers and no limit for others; here it is no limit.
        let mut lower = None;
        let mut upper = None;
        if matches!(joint_type, JointType::Revolute | JointType::Prismatic) {
            let mut bound = |name| match attribute(node, name) {
                Some(_) => self.xml.number(node, name, subject),
                None => Some(0.0),
            };
            (lower, upper) = (bound("lower"), bound("upper"));
        }
        if joint_type.nv() > 1 {
            self.no_bounds(node, subject);
        }
        let [velocity, effort] =
            ["velocity", "effort"].map(|name| self.nonnegative_limit(node, name, subject));
        if let (Some(lower), Some(upper)) = (lower, upper)
            && lower > upper
        {
            let at = node.range().start;
            let message = format!("the lower limit {lower} is above the upper limit {upper}");
            let help = "exchange them; the default of both is 0";
            self.xml.report.add(
                Severity::Warning,
                Code::InvertedLimits,
                at,
                subject,
                message,
                help,
            );
        }
        let bounds = [lower, upper, velocity, effort];
        let [lower, upper, velocity, effort] =
            bounds.map(|bound| bound.filter(|bound| bound.abs() < UNLIMITED));
        Some(Limits { lower, upper, velocity, effort })
    }

    /// Returns a velocity or effort limit; `None` if it is missing or negative. Negative limits are
    /// recorded.
    fn nonnegative_limit(
        &mut self,
        node: Node<'a, '_>,
        name: &str,
        subject: Option<&Subject>,
    ) -> Option<f64> {
        let value = self.xml.number(node, name, subject)?;
        if value < 0.0 {
            let at = attribute(node, name).map_or(node.range().start, |text| text.at);
            self.negative_limits.push((Some(at), subject.cloned()));
            return None;
        }
        Some(value)
    }

    /// Warns of position limits of a joint with several coordinates.
    fn no_bounds(&mut self, limit: Node<'a, '_>, subject: Option<&Subject>) {
        for bound in ["lower", "upper"].into_iter().filter_map(|name| limit.attribute_node(name)) {
            let message = format!(
                "the attribute `{}` of `<limit>` is not read: the joint has several coordinates",
                bound.name()
            );
            let help = "remove it; such a joint has velocity and effort limits only";
            let at = bound.range().start;
            self.xml.report.add(Severity::Warning, Code::NotRead, at, subject, message, help);
        }
    }

    fn mimic(&mut self, node: Node<'a, '_>, subject: Option<&Subject>) -> Option<MimicRecord> {
        let node = self.xml.single(node, "mimic", subject)?;
        let at = node.range().start;
        if self.options.mimic == Mimic::Follow {
            return self.mimic_record(node, subject);
        }
        let leader = attribute(node, "joint").unwrap_or(Attribute { text: "", at });
        Some(MimicRecord { leader: leader.located(), multiplier: 1.0, offset: 0.0 })
    }

    /// Returns a `<mimic>` with all its numbers.
    fn mimic_record(
        &mut self,
        node: Node<'a, '_>,
        subject: Option<&Subject>,
    ) -> Option<MimicRecord> {
        self.xml.warn_of_unknown_attributes(node, &["joint", "multiplier", "offset"], subject);
        let multiplier = self.xml.number(node, "multiplier", subject).unwrap_or(1.0);
        let offset = self.xml.number(node, "offset", subject).unwrap_or(0.0);
        if let (Some(text), 0.0) = (attribute(node, "multiplier"), multiplier) {
            let message = "the multiplier is 0, so the joint never moves";
            let help = "write the ratio of the velocities, or make the joint `fixed`";
            let code = Code::MimicMultiplier;
            self.xml.report.add(Severity::Warning, code, text.at, subject, message, help);
        }
        let leader = self.xml.attribute(node, "joint", subject)?.located();
        Some(MimicRecord { leader, multiplier, offset })
    }

    /// Returns armature, damping and friction, and the place of the `<dynamics>`.
    fn joint_dynamics(
        &mut self,
        node: Node<'a, '_>,
        subject: Option<&Subject>,
    ) -> (JointDynamics, usize) {
        let Some(node) = self.xml.single(node, "dynamics", subject) else {
            return (JointDynamics::default(), node.range().start);
        };
        let names = ["damping", "friction", "armature", "rotor_inertia", "gear_ratio"];
        self.unread_dynamics(node, &names, subject);
        let [damping, friction, armature, rotor] =
            ["damping", "friction", "armature", "rotor_inertia"]
                .map(|name| self.dissipation(node, name, subject));
        let gear = self.xml.number(node, "gear_ratio", subject).unwrap_or(1.0);
        self.check_armature(node, subject);
        let dynamics =
            JointDynamics { armature: armature + gear * gear * rotor, damping, friction };
        (dynamics, node.range().start)
    }

    /// Names the attributes of `<dynamics>` that are not read, unless they are zero.
    fn unread_dynamics(&mut self, node: Node<'a, '_>, read: &[&str], subject: Option<&Subject>) {
        self.xml.warn_of_misspelt_attributes(node, read, subject);
        let unread = node.attributes().filter(|attribute| {
            let name = attribute.name();
            let is_zero = attribute.value().trim().parse() == Ok(0.0);
            let is_misspelt = name.len() > 2 && suggest(name, read.iter().copied()).is_some();
            !(read.contains(&name) || is_zero || is_misspelt || is_extension(name))
        });
        let names: Vec<String> =
            unread.map(|attribute| format!("`{}`", attribute.name())).collect();
        if !names.is_empty() {
            let message =
                format!("`<dynamics>` has attributes that are not read: {}", names.join(", "));
            let place = (Some(node.range().start), subject.cloned());
            let help = "describe them by `damping`, `friction` or `armature`, or remove them";
            self.unread.add(message, place, help);
        }
    }

    /// Returns a number of `<dynamics>`, which must be at least zero; zero if it is missing.
    fn dissipation(&mut self, node: Node<'a, '_>, name: &str, subject: Option<&Subject>) -> f64 {
        let value = self.xml.number(node, name, subject).unwrap_or(0.0);
        if let Some(text) = attribute(node, name)
            && value < 0.0
        {
            let message = format!("the attribute `{name}` of `<dynamics>` is {value}");
            let help = "write a number of at least 0: damping and friction oppose the motion";
            self.xml.report.error(Code::NegativeJointDynamics, text.at, subject, message, help);
            return 0.0;
        }
        value
    }

    /// Reports an armature that is given both at the joint, and as a rotor with a gear ratio.
    fn check_armature(&mut self, node: Node<'a, '_>, subject: Option<&Subject>) {
        let armature = attribute(node, "armature");
        let rotor = attribute(node, "rotor_inertia");
        let gear = attribute(node, "gear_ratio");
        if let Some(text) = armature.filter(|_| rotor.is_some() || gear.is_some()) {
            let message = "`armature` is given besides `rotor_inertia` or `gear_ratio`, which define the same armature";
            let help = "keep one: armature = gear_ratio^2 * rotor_inertia";
            self.xml.report.error(Code::RepeatedArmature, text.at, subject, message, help);
        } else if let (Some(text), None) = (gear, rotor) {
            let message =
                "the attribute `gear_ratio` of `<dynamics>` is not read: there is no rotor";
            let help = "write `rotor_inertia` as well: armature = gear_ratio^2 * rotor_inertia";
            self.xml.report.add(Severity::Warning, Code::NotRead, text.at, subject, message, help);
        }
    }
}
