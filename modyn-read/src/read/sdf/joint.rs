//! Reads a `<joint>`.

use core::f64::consts::TAU;

use modyn_runtime::model::{JointDynamics, Limits};
use roxmltree::Node;

use super::reader::{Reader, trimmed};
use super::world::{Axis, FrameKind, Joint, JointKind, Mimic};
use crate::description::{Located, SpringRecord};
use crate::diagnostics::{Code, Severity, Subject};
use crate::read::xml::element::children;

impl<'a> Reader<'a, '_, '_, '_> {
    /// Reads a `<joint>` of a model or of the world.
    pub fn joint(&mut self, node: Node<'a, '_>, scope: usize) {
        let errors = self.xml.report.errors();
        let attribute = self.xml.attribute(node, "name", None).map(trimmed);
        let name = attribute.unwrap_or(Located { text: String::new(), at: self.xml.at(node) });
        let own_subject = Subject::Joint(name.text.clone());
        let subject = Some(&own_subject);
        let known = [
            "parent",
            "child",
            "gearbox_ratio",
            "gearbox_reference_body",
            "thread_pitch",
            "screw_thread_pitch",
            "axis",
            "axis2",
            "physics",
            "pose",
            "sensor",
            "drake.rotor_inertia",
            "drake.gear_ratio",
            "drake.mimic",
        ];
        self.warn_of_unknown(node, &known, subject);
        let kind = self.joint_kind(node, subject);
        let parent = self.name_in(node, "parent", subject);
        let child = self.name_in(node, "child", subject);
        let (pose, relative_to) = self.pose(node, subject);
        let mut axes = match kind {
            None | Some(JointKind::Fixed | JointKind::Ball) => [None, None],
            Some(JointKind::Universal) => {
                ["axis", "axis2"].map(|name| self.axis(node, name, subject))
            }
            Some(_) => [self.axis(node, "axis", subject), None],
        };
        let armature = self.armature(node, subject);
        for axis in axes.iter_mut().flatten() {
            axis.dynamics.armature = armature;
        }
        if let Some(axis) = &mut axes[0] {
            axis.mimic = axis.mimic.take().or_else(|| self.drakes_mimic(node, subject));
        }
        let pitch = if kind == Some(JointKind::Screw) { self.pitch(node, subject) } else { 0.0 };
        let simbody = self.xml.named(node, "physics").flat_map(|physics| children(physics));
        let element = simbody
            .flat_map(|engine| children(engine))
            .find(|n| n.has_tag_name("must_be_loop_joint"));
        let cut = element
            .and_then(|cut| self.truth(self.xml.content(cut), "must_be_loop_joint", subject));
        let index = self.world.joints.len();
        let frame = self.push(scope, &name, FrameKind::Joint(index), pose, relative_to);
        let sound = self.xml.report.errors() == errors;
        let closes_loop = cut == Some(true);
        self.world.joints.push(Joint {
            frame,
            kind,
            parent,
            child,
            axes,
            pitch,
            closes_loop,
            sound,
        });
    }

    fn joint_kind(&mut self, node: Node<'a, '_>, subject: Option<&Subject>) -> Option<JointKind> {
        let text = self.xml.attribute(node, "type", subject)?;
        let kind = match text.text.trim() {
            "fixed" => JointKind::Fixed,
            "revolute" => JointKind::Revolute,
            "continuous" => JointKind::Continuous,
            "prismatic" => JointKind::Prismatic,
            "universal" | "revolute2" => JointKind::Universal,
            "ball" => JointKind::Ball,
            "screw" => JointKind::Screw,
            other => {
                let (message, help) = if other == "gearbox" {
                    let help =
                        "write two `revolute` joints, one of them with `<mimic>` in its `<axis>`";
                    ("a joint of type `gearbox` is not read".into(), help)
                } else {
                    let help = "supported are: revolute, continuous, prismatic, universal, revolute2, ball, \
                                screw, fixed";
                    (format!("`{other}` is not a joint type"), help)
                };
                self.xml.report.error(Code::UnknownJointType, text.at, subject, message, help);
                return None;
            }
        };
        Some(kind)
    }

    /// Returns the armature by Drake's extensions `rotor_inertia` and `gear_ratio`; zero without
    /// them.
    fn armature(&mut self, joint: Node<'a, '_>, subject: Option<&Subject>) -> f64 {
        let rotor = self.number(joint, "drake.rotor_inertia", subject).unwrap_or(0.0);
        let gear = self.number(joint, "drake.gear_ratio", subject).unwrap_or(1.0);
        if rotor < 0.0 {
            let message = format!("`<drake:rotor_inertia>` is {rotor} kg m^2");
            let code = Code::NegativeJointDynamics;
            let help = "write an inertia of at least 0";
            self.xml.report.error(code, self.xml.at(joint), subject, message, help);
        }
        gear * gear * rotor.max(0.0)
    }

    /// Returns the relation of Drake's extension `mimic`.
    fn drakes_mimic(&mut self, joint: Node<'a, '_>, subject: Option<&Subject>) -> Option<Mimic> {
        let node = self.xml.single(joint, "drake.mimic", subject)?;
        let leader = self.xml.attribute(node, "joint", subject).map(trimmed);
        let multiplier = self.xml.number(node, "multiplier", subject).unwrap_or(1.0);
        let offset = self.xml.number(node, "offset", subject).unwrap_or(0.0);
        Some(Mimic { leader: leader?, multiplier, offset })
    }

    /// Returns the displacement of a screw, m/rad.
    fn pitch(&mut self, node: Node<'a, '_>, subject: Option<&Subject>) -> f64 {
        if let Some(pitch) = self.number(node, "screw_thread_pitch", subject) {
            return pitch / TAU;
        }
        // The older element is in rad/m, and positive for a left-handed thread.
        let pitch = -1.0 / self.number(node, "thread_pitch", subject).unwrap_or(1.0);
        if !pitch.is_finite() {
            let message = "`<thread_pitch>` is 0 rad/m";
            let help = "write `<screw_thread_pitch>` in m per revolution";
            self.xml.report.error(Code::NotFinite, self.xml.at(node), subject, message, help);
            return 0.0;
        }
        pitch
    }

    /// Returns an axis with its limits, damping and friction; `None` with an error in the report.
    fn axis(&mut self, joint: Node<'a, '_>, name: &str, subject: Option<&Subject>) -> Option<Axis> {
        let node = self.xml.required(
            joint,
            name,
            &format!("<{name}><xyz>0 0 1</xyz></{name}>"),
            subject,
        )?;
        let at = self.xml.at(node);
        let known =
            ["initial_position", "xyz", "use_parent_model_frame", "dynamics", "limit", "mimic"];
        self.warn_of_unknown(node, &known, subject);
        let mut direction = [0.0, 0.0, 1.0];
        let mut expressed_in = None;
        if let Some(xyz) = self.xml.single(node, "xyz", subject) {
            expressed_in = self.xml.optional(xyz, "expressed_in").map(trimmed);
            let text = self.xml.content(xyz);
            let axis = self.xml.numbers::<3>(text, subject)?;
            direction = self.xml.unit(axis, text.at, subject)?;
        }
        // Before SDF 1.7, an axis was in the joint's frame or in the model's; before 1.5, always in
        // the model's.
        let of_model = self.flag(node, "use_parent_model_frame", subject) == Some(true);
        if self.version < 105 || self.version < 107 && of_model {
            expressed_in = Some(Located { text: "__model__".into(), at });
        }
        let (dynamics, spring, dynamics_at) = self.dynamics(node, subject);
        let limits = self.limits(node, subject);
        let mimic = self.mimic(node, subject);
        let expressed_in = expressed_in.filter(|frame| !frame.text.is_empty());
        Some(Axis { direction, expressed_in, at, limits, dynamics, spring, dynamics_at, mimic })
    }

    /// Returns damping, friction and spring of an axis, and their place.
    fn dynamics(
        &mut self,
        axis: Node<'a, '_>,
        subject: Option<&Subject>,
    ) -> (JointDynamics, Option<SpringRecord>, usize) {
        let Some(node) = self.xml.single(axis, "dynamics", subject) else {
            return (JointDynamics::default(), None, self.xml.at(axis));
        };
        let at = self.xml.at(node);
        let known = ["damping", "friction", "spring_reference", "spring_stiffness"];
        self.warn_of_unknown(node, &known, subject);
        let names = ["damping", "friction", "spring_stiffness"];
        let [damping, friction, stiffness] = names.map(|name| {
            let value = self.number(node, name, subject).unwrap_or(0.0);
            if value < 0.0 {
                let message = format!("`<{name}>` is {value}");
                let help = "write a number of at least 0: damping and friction oppose the motion, \
                            and springs pull back";
                let code = Code::NegativeJointDynamics;
                self.xml.report.error(code, at, subject, message, help);
            }
            value.max(0.0)
        });
        let reference = self.number(node, "spring_reference", subject).unwrap_or(0.0);
        let spring =
            (stiffness > 0.0).then(|| SpringRecord { stiffness, reference: vec![reference] });
        (JointDynamics { damping, friction, ..JointDynamics::default() }, spring, at)
    }

    /// Returns the limits of an axis. An infinite limit is none, and so is a negative one of effort
    /// or velocity.
    fn limits(&mut self, axis: Node<'a, '_>, subject: Option<&Subject>) -> Limits {
        let none = Limits { lower: None, upper: None, velocity: None, effort: None };
        let Some(node) = self.xml.single(axis, "limit", subject) else { return none };
        self.warn_of_unknown(
            node,
            &["lower", "upper", "effort", "velocity", "stiffness", "dissipation"],
            subject,
        );
        let [lower, upper, velocity, effort] =
            ["lower", "upper", "velocity", "effort"].map(|name| self.finite(node, name, subject));
        if let (Some(lower), Some(upper)) = (lower, upper)
            && lower > upper
        {
            let message = format!("the lower limit {lower} is above the upper limit {upper}");
            let at = self.xml.at(node);
            let code = Code::InvertedLimits;
            self.xml.report.add(Severity::Warning, code, at, subject, message, "exchange them");
        }
        let [velocity, effort] = [velocity, effort].map(|limit| limit.filter(|&most| most >= 0.0));
        Limits { lower, upper, velocity, effort }
    }

    /// Returns the `<mimic>` of an axis.
    fn mimic(&mut self, axis: Node<'a, '_>, subject: Option<&Subject>) -> Option<Mimic> {
        let node = self.xml.single(axis, "mimic", subject)?;
        self.warn_of_unknown(node, &["multiplier", "offset", "reference"], subject);
        let leader = self.xml.attribute(node, "joint", subject).map(trimmed);
        if let Some(axis) =
            self.xml.optional(node, "axis").filter(|axis| axis.text.trim() != "axis")
        {
            let message = format!("it mimics `{}` of a joint with two axes", axis.text);
            let help = "mimic a joint with one axis";
            self.xml.report.error(Code::MimicCoordinates, axis.at, subject, message, help);
        }
        let [multiplier, offset, reference] =
            [("multiplier", 1.0), ("offset", 0.0), ("reference", 0.0)]
                .map(|(name, default)| self.number(node, name, subject).unwrap_or(default));
        let offset = offset - multiplier * reference;
        Some(Mimic { leader: leader?, multiplier, offset })
    }
}
