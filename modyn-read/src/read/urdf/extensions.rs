//! Reads the elements that other programs add to URDF where they change the dynamics: rotors of
//! `<transmission>`s, springs and gravity switches of `<gazebo>`, and Drake's constraints and
//! joints. Elements that are not read are named once for each kind.

use modyn_runtime::model::LoopConstraintKind;
use modyn_runtime::spatial::Pose;
use roxmltree::Node;
use rustc_hash::FxHashMap;

use super::reader::Reader;
use crate::description::{
    Description, EndRecord, JointRecord, Kind, LoopRecord, SpringRecord, TakenNames,
};
use crate::diagnostics::{Code, Place, Subject, Suggestions, suggest};
use crate::read::xml::element::{Attribute, attribute, children, is, is_extension, shown, written};

/// Elements of a robot, in URDF or SRDF, that have no effect on the equations of motion.
const HARMLESS_IN_ROBOT: &[&str] = &[
    "material",
    "frame",
    "sensor",
    "ros2_control",
    "author",
    "license",
    "version",
    "group",
    "group_state",
    "end_effector",
    "virtual_joint",
    "passive_joint",
    "disable_collisions",
    "enable_collisions",
    "disable_default_collisions",
];

/// Elements of a link that are read, and elements that have no effect on the equations of motion.
pub const KNOWN_IN_LINK: &[&str] = &[
    "inertial",
    "visual",
    "collision",
    "material",
    "sensor",
    "contact",
    "self_collision_checking",
];

/// Elements of a joint that are read, and elements that have no effect on the equations of motion.
pub const KNOWN_IN_JOINT: &[&str] = &[
    "origin",
    "parent",
    "child",
    "axis",
    "axis2",
    "limit",
    "mimic",
    "dynamics",
    "calibration",
    "safety_controller",
    "hardwareInterface",
];

/// Elements of a `<gazebo>` that have no effect on the equations of motion: contacts, sensors,
/// pictures, and settings of solvers.
const HARMLESS_IN_GAZEBO: &[&str] = &[
    "material",
    "visual",
    "collision",
    "sensor",
    "light",
    "projector",
    "audio_sink",
    "audio_source",
    "mu",
    "mu1",
    "mu2",
    "fdir1",
    "kp",
    "kd",
    "maxVel",
    "minDepth",
    "maxContacts",
    "laserRetro",
    "selfCollide",
    "self_collide",
    "stopCfm",
    "stopErp",
    "stopKp",
    "stopKd",
    "initial_joint_position",
    "fudgeFactor",
    "cfmDamping",
    "implicitSpringDamper",
    "provideFeedback",
    "canonicalBody",
    "disableFixedJointLumping",
    "preserveFixedJoint",
    "allow_auto_disable",
    "include",
];

/// Parts of the names of Gazebo's plugins that apply the commanded joint forces, or publish states.
const HARMLESS_PLUGINS: &[&str] = &["control", "publish", "state"];

const PLUGIN_HELP: &str = "apply such forces in the program that uses the robot";
const GAZEBO_HELP: &str = "if it changes the motion, describe it by URDF's elements";
const ELEMENT_HELP: &str =
    "check its spelling; joints, forces and inertias that it adds are missing";
const MUJOCO_HELP: &str =
    "write the inertias and masses that MuJoCo computes, or read the MJCF that it saves";
const CONDITION_HELP: &str = "name a joint with one coordinate, or remove the element";

/// The rotor of a transmission.
struct TransmissionRotor {
    inertia: f64,
    gear_ratio: f64,
    at: usize,
}

/// The description that extensions change.
struct Extended<'d> {
    description: &'d mut Description,
    /// The joints by their names.
    joints: FxHashMap<String, usize>,
    /// The links by their names.
    links: FxHashMap<String, usize>,
    near: Suggestions,
    /// The names of joints and of loops.
    taken: TakenNames,
}

impl<'d> Extended<'d> {
    fn new(description: &'d mut Description) -> Self {
        let index = |names: Vec<&str>| {
            let mut indices = FxHashMap::default();
            for (i, name) in names.into_iter().enumerate() {
                indices.entry(name.to_owned()).or_insert(i);
            }
            indices
        };
        let joints = index(description.joint_names().collect());
        let links = index(description.link_names().collect());
        let taken = TakenNames::new(description.joint_names());
        Self { description, joints, links, near: Suggestions::new(), taken }
    }
}

impl<'a> Reader<'a, '_, '_, '_> {
    /// Reads the extensions in a `<robot>`, whose links and joints are in the description.
    pub fn extensions(&mut self, robot: Node<'a, '_>, description: &mut Description) {
        let extended = &mut Extended::new(description);
        for node in children(robot).filter(Node::is_element) {
            match node.tag_name().name() {
                "link" | "joint" | "drake.joint" | "loop_joint" | "contact_frame" => {}
                "transmission" => self.transmission(node, extended),
                "gazebo" => self.gazebo(node, extended),
                "mujoco" => self.mujoco(node),
                "drake.ball_constraint" => {
                    let record = self.ball_constraint(node, extended);
                    extended.description.loops.push(record);
                }
                _ => self.unread_element(node, HARMLESS_IN_ROBOT, None),
            }
        }
    }

    /// Names the elements of a link or joint that are not known. One of them may be an optional
    /// element with a misspelt name, which would silently be missing.
    pub fn unread_elements(
        &mut self,
        node: Node<'a, '_>,
        known: &[&str],
        optional: &[&str],
        subject: Option<&Subject>,
    ) {
        self.xml.warn_of_misspelt_elements(node, known, optional, subject);
        for child in children(node).filter(Node::is_element) {
            if suggest(child.tag_name().name(), optional.iter().copied()).is_none() {
                self.unread_element(child, known, subject);
            }
        }
    }

    /// Names an element that is not known, unless it is an inclusion, which another warning names.
    fn unread_element(&mut self, node: Node, known: &[&str], subject: Option<&Subject>) {
        let name = node.tag_name().name();
        if known.contains(&name) || name.ends_with("include") || is_ignored(name) {
            return;
        }
        let place: Place = (Some(self.xml.at(node)), subject.cloned());
        if !self.unread.add_extension(node, place.clone()) {
            self.unread.add(format!("the element `<{name}>` is not read"), place, ELEMENT_HELP);
        }
    }

    /// Sets the armature of the joint of a `<transmission>` by the inertia of its rotor: Drake's
    /// `rotor_inertia` and `gear_ratio`, or `motorInertia` and `mechanicalReduction`.
    fn transmission(&mut self, node: Node<'a, '_>, extended: &mut Extended) {
        let read = ["drake.rotor_inertia", "drake.gear_ratio"];
        for part in node.descendants().filter(|part| is_extension(part.tag_name().name())) {
            self.unread_element(part, &read, None);
        }
        let Some(rotor) = self.transmission_rotor(node) else { return };
        let at = rotor.at;
        let joints: Vec<_> = self.xml.named(node, "joint").collect();
        let [joint] = joints[..] else {
            let message =
                "the rotor of a `<transmission>` without exactly one `<joint>` is not read";
            let help =
                "give each joint a rotor by `<dynamics armature>`, or by the option `rotors`";
            self.unread.add(message.into(), (Some(at), None), help);
            return;
        };
        let Some(name) = self.xml.attribute(joint, "name", None) else { return };
        let Some(joint) = self.joint_of(name, "`<transmission>`", extended) else { return };
        let subject = joint.subject();
        if !has_one_coordinate(joint) {
            let message =
                "the rotor of a joint that is fixed or has several coordinates is not read";
            self.unread.add(message.into(), (Some(at), Some(subject)), CONDITION_HELP);
        } else if joint.dynamics.armature != 0.0 {
            let message = "its armature is given twice, by `<dynamics>` or by several rotors";
            let help = "keep one: armature = gear_ratio^2 * rotor_inertia";
            self.xml.report.error(Code::RepeatedArmature, at, Some(&subject), message, help);
        } else if rotor.inertia < 0.0 {
            let message = format!("the inertia of its rotor is {} kg m^2", rotor.inertia);
            let help = "write an inertia of at least 0";
            let code = Code::NegativeJointDynamics;
            self.xml.report.error(code, at, Some(&subject), message, help);
        } else {
            joint.dynamics.armature = rotor.gear_ratio * rotor.gear_ratio * rotor.inertia;
            joint.dynamics_at = at;
        }
    }

    /// Returns the rotor of a `<transmission>`; `None` if it has none, or one that cannot be read.
    fn transmission_rotor(&mut self, node: Node<'a, '_>) -> Option<TransmissionRotor> {
        let mut part = |name| {
            let part = node.descendants().find(|part| is(*part, name))?;
            let text = self.value(part);
            let [number] = self.xml.numbers::<1>(text, None)?;
            Some((number, self.xml.at(part)))
        };
        let [drakes, ros] =
            [["drake.rotor_inertia", "drake.gear_ratio"], ["motorInertia", "mechanicalReduction"]]
                .map(|[inertia, gear_ratio]| {
                    let (inertia, at) = part(inertia)?;
                    let gear_ratio = part(gear_ratio).map_or(1.0, |(ratio, _)| ratio);
                    Some(TransmissionRotor { inertia, gear_ratio, at })
                });
        if let (Some(_), Some(second)) = (&drakes, &ros) {
            let message =
                "the rotor is given twice, by `drake:rotor_inertia` and by `motorInertia`";
            let code = Code::RepeatedArmature;
            self.xml.report.error(code, second.at, None, message, "keep one of them");
        }
        drakes.or(ros)
    }

    /// Returns the value of an extension: its attribute `value`, or its text.
    pub fn value(&self, node: Node<'a, '_>) -> Attribute<'a> {
        attribute(node, "value").unwrap_or_else(|| self.xml.content(node))
    }

    /// Returns the joint of this name; `None` with an error in the report.
    fn joint_of<'d>(
        &mut self,
        name: Attribute,
        what: &str,
        extended: &'d mut Extended,
    ) -> Option<&'d mut JointRecord> {
        let Some(&joint) = extended.joints.get(name.text) else {
            let message =
                format!("{what} is about the joint `{}`, which does not exist", name.text);
            let near = extended.near.suggest(name.text, extended.description.joint_names());
            let help = match near {
                Some(near) => format!("did you mean `{near}`?"),
                None => "name a joint of this file, or remove the element".into(),
            };
            self.xml.report.error(Code::NotRead, name.at, None, message, help);
            return None;
        };
        Some(&mut extended.description.joints[joint])
    }

    /// Reads the spring of a joint and the gravity switch of a link in a `<gazebo>`.
    fn gazebo(&mut self, node: Node<'a, '_>, extended: &mut Extended) {
        let reference = attribute(node, "reference");
        for child in children(node).filter(Node::is_element) {
            let name = child.tag_name().name();
            let place: Place = (Some(self.xml.at(child)), None);
            match name {
                // Both are read at the first of them.
                "springReference" | "springStiffness" => {}
                "gravity" | "turnGravityOff" => {
                    let is_off = self.truth(child) == Some(name == "turnGravityOff");
                    if is_off {
                        self.weightless(reference, child, extended);
                    }
                }
                "static" | "kinematic" if self.truth(child) == Some(false) => {}
                "dampingFactor" | "velocity_decay" => {
                    let message = format!(
                        "`<{name}>` in `<gazebo>` is not read: it damps a link in one simulator \
                         only"
                    );
                    self.unread.add(message, place, "write `<dynamics damping>` of the joints");
                }
                "plugin" => {
                    let file = child.attribute("filename").unwrap_or_default();
                    if !HARMLESS_PLUGINS.iter().any(|part| file.contains(part)) {
                        let message = format!(
                            "the plugin `{file}` of `<gazebo>` is not read: forces that it \
                             applies do not act"
                        );
                        self.unread.add(message, place, PLUGIN_HELP);
                    }
                }
                _ if HARMLESS_IN_GAZEBO.contains(&name) || is_ignored(name) => {}
                _ => {
                    let message = format!("`<{}>` in `<gazebo>` is not read", written(child));
                    self.unread.add(message, place, GAZEBO_HELP);
                }
            }
        }
        self.spring(node, reference, extended);
    }

    /// Returns the truth value of an extension; anything else is an error.
    fn truth(&mut self, node: Node<'a, '_>) -> Option<bool> {
        let text = self.value(node);
        match text.text.trim().to_ascii_lowercase().as_str() {
            "true" | "1" | "yes" => Some(true),
            "false" | "0" | "no" => Some(false),
            _ => {
                let message = format!("`<{}>` is neither `true` nor `false`", written(node));
                let help = "write `true` or `false`";
                self.xml.report.error(Code::BadNumber, text.at, None, message, help);
                None
            }
        }
    }

    /// Compensates the weight of the link that a `<gazebo>` is about.
    fn weightless(&mut self, link: Option<Attribute>, node: Node, extended: &mut Extended) {
        if let Some(&link) = link.and_then(|link| extended.links.get(link.text)) {
            extended.description.compensated.push((link, 1.0));
            return;
        }
        let message = format!("`<{}>` in `<gazebo>` names no link", written(node));
        let help = "write the name of a link in `<gazebo reference=\"...\">`";
        self.unread.add(message, (Some(self.xml.at(node)), None), help);
    }

    /// Sets the spring of the joint that a `<gazebo>` is about, if it has one.
    fn spring(
        &mut self,
        node: Node<'a, '_>,
        joint: Option<Attribute<'a>>,
        extended: &mut Extended,
    ) {
        let mut number = |name| {
            let part = self.xml.single(node, name, None)?;
            let text = self.value(part);
            let [number] = self.xml.numbers::<1>(text, None)?;
            Some((number, self.xml.at(part)))
        };
        let reference = number("springReference").map_or(0.0, |(reference, _)| reference);
        let Some((stiffness, at)) = number("springStiffness") else { return };
        if stiffness == 0.0 {
            return;
        }
        let Some(name) = joint else {
            let message = "`<springStiffness>` in `<gazebo>` names no joint";
            let help = "write the name of a joint in `<gazebo reference=\"...\">`";
            self.unread.add(message.into(), (Some(at), None), help);
            return;
        };
        let Some(joint) = self.joint_of(name, "the spring of `<gazebo>`", extended) else { return };
        let subject = joint.subject();
        if stiffness < 0.0 {
            let message = format!("`<springStiffness>` is {stiffness}");
            let code = Code::NegativeJointDynamics;
            let help = "write a number of at least 0: springs pull back";
            self.xml.report.error(code, at, Some(&subject), message, help);
        } else if has_one_coordinate(joint) {
            joint.spring = Some(SpringRecord { stiffness, reference: vec![reference] });
        } else {
            let message =
                "the spring of a joint that is fixed or has several coordinates is not read";
            self.unread.add(message.into(), (Some(at), Some(subject)), CONDITION_HELP);
        }
    }

    /// Names the settings of MuJoCo by which it changes masses, inertias and gravity of a URDF.
    fn mujoco(&mut self, node: Node) {
        let changes = [
            ("boundmass", "0"),
            ("boundinertia", "0"),
            ("settotalmass", "-1"),
            ("balanceinertia", "false"),
            ("inertiafromgeom", "auto"),
            ("gravity", ""),
            ("density", "0"),
            ("viscosity", "0"),
        ];
        for part in children(node).filter(|part| is(*part, "compiler") || is(*part, "option")) {
            for attribute in part.attributes() {
                let default = changes.iter().find(|(name, _)| *name == attribute.name());
                if default.is_some_and(|(_, default)| attribute.value().trim() != *default) {
                    let message = format!("`{}` in `<mujoco>` is not read", attribute.name());
                    let at = attribute.range().start;
                    self.unread.add(message, (Some(at), None), MUJOCO_HELP);
                }
            }
        }
    }

    /// Returns Drake's constraint that two points of links coincide.
    fn ball_constraint(&mut self, node: Node<'a, '_>, extended: &mut Extended) -> LoopRecord {
        let at = self.xml.at(node);
        let ends = ["A", "B"].map(|body| {
            let of_body = format!("drake.ball_constraint_body_{body}");
            let named = self.xml.required(node, &of_body, &example(&of_body, "name=\"...\""), None);
            let link = named.and_then(|named| self.xml.attribute(named, "name", None));
            let of_point =
                format!("drake.ball_constraint_p_{}", if body == "A" { "AP" } else { "BQ" });
            let point =
                self.xml.required(node, &of_point, &example(&of_point, "value=\"0 0 0\""), None);
            let attribute = point.and_then(|point| self.xml.attribute(point, "value", None));
            let point = attribute.and_then(|text| self.xml.numbers::<3>(text, None));
            let translation = point.unwrap_or_default();
            EndRecord {
                link: link.map(|link| link.text.into()),
                at: Some(link.map_or(at, |link| link.at)),
                pose: Pose { translation, ..Pose::identity() },
            }
        });
        let name = extended.taken.numbered("ball_constraint", extended.description.loops.len() + 1);
        LoopRecord { name, at: Some(at), kind: Some(LoopConstraintKind::Point), ends }
    }
}

/// Returns whether a joint has one coordinate.
fn has_one_coordinate(joint: &JointRecord) -> bool {
    matches!(joint.kind, Kind::Moving(joint_type) if joint_type.nq() == 1)
}

/// Returns whether an element of this name is a sensor of old versions of Gazebo, or of a xacro.
fn is_ignored(name: &str) -> bool {
    name.starts_with("sensor.") || name.starts_with("xacro.")
}

/// Returns an element with an attribute, for a help.
fn example(name: &str, attribute: &str) -> String {
    format!("<{} {attribute}/>", shown(name))
}
