//! From bodies with any number of joints to links with one joint each, as in a URDF.

use std::collections::BTreeSet;

use mjcf_rs::body::{Body, InertiaSpec, Joint, JointType as Type};
use mjcf_rs::compiler::InertiaFromGeom;
use modyn_runtime::conventions::rotation_from_quaternion;
use modyn_runtime::joint::JointType;
use modyn_runtime::model::{Inertial, JointDynamics, Limits};
use modyn_runtime::spatial::Pose;
use roxmltree::Node;

use super::classes::Classes;
use super::geoms;
use super::pose::pose;
use crate::description::{
    Description, InertialRecord, JointRecord, Kind, LinkRecord, Located, MAX_NUMBER, normalized,
};
use crate::diagnostics::{Code, Report, Severity, Subject};

/// Returns the description of a model that was read from the XML under `root`; `None` with an error in the report. Names
/// that the file lacks are generated. The elements of `unread` bodies have stand-ins for some of their numbers.
pub fn describe(
    model: &mjcf_rs::Model,
    root: Node,
    unread: &BTreeSet<usize>,
    report: &mut Report<'_>,
) -> Option<Description> {
    Bodies::read(model, root, unread, report).map(|bodies| bodies.description)
}

/// The description so far.
struct Bodies {
    description: Description,
    /// For each link, whether it or one of its ancestors has a moving joint.
    moves: Vec<bool>,
}

impl Bodies {
    fn read(
        model: &mjcf_rs::Model,
        root: Node,
        unread: &BTreeSet<usize>,
        report: &mut Report<'_>,
    ) -> Option<Self> {
        let at = root.range().start;
        let named = model.name.as_deref().filter(|name| !name.trim().is_empty());
        if named.is_none() {
            let message = "the model has no name";
            let help = "write `<mujoco model=\"...\">`; it is called `robot` here";
            report.add(Severity::Warning, Code::MissingAttribute, at, None, message, help);
        }
        let name = named.unwrap_or("robot").into();
        let description = Description {
            name,
            at,
            gravity: None,
            links: Vec::new(),
            joints: Vec::new(),
            loops: Vec::new(),
            contacts: Vec::new(),
        };
        let mut bodies = Self { description, moves: Vec::new() };
        bodies.link("world".into(), at, false);
        // mjcf-rs keeps the order of the text.
        let nodes: Vec<Node> = root
            .children()
            .filter(|node| node.has_tag_name("worldbody"))
            .flat_map(|world| world.descendants().filter(|node| node.has_tag_name("body")))
            .collect();
        if nodes.len() + 1 != model.bodies.len() {
            let message = "its bodies are not those of the text";
            let help = "this is a fault of modyn: please report it with the file";
            report.error(Code::InvalidModel, at, None, message, help);
            return None;
        }
        let classes = Classes::new(root);
        let classes_place_geoms = root
            .descendants()
            .filter(|node| node.has_tag_name("geom"))
            .filter(|node| node.parent().is_some_and(|up| up.has_tag_name("default")))
            .any(|node| node.attributes().any(|one| PLACES.contains(&one.name())));
        // For each body, its link.
        let mut links = vec![0];
        for (entry, node) in model.bodies.iter().skip(1).zip(nodes) {
            let parent = entry.parent.unwrap_or(0);
            let is_read = !unread.contains(&node.range().start);
            let classes = &classes;
            let mut reader = Reader { model, node, is_read, classes, classes_place_geoms, report };
            links.push(bodies.body(&mut reader, &entry.body, links[parent], links.len()));
        }
        Some(bodies)
    }

    /// Adds a body and its joints, and returns the body's link.
    fn body(&mut self, reader: &mut Reader, body: &Body, parent: usize, index: usize) -> usize {
        let at = reader.node.range().start;
        let name = body.name.clone().unwrap_or_else(|| format!("body_{index}"));
        let is_joint = |node: &Node| ["joint", "freejoint"].contains(&node.tag_name().name());
        let nodes: Vec<Node> = reader.node.children().filter(is_joint).collect();
        reader.pose(&body.pose, &name, at);
        let mut above = parent;
        // The pose of the body's frame in the link that was added last.
        let mut frame = pose(&body.pose);
        for (k, joint) in body.joints.iter().enumerate() {
            let node = nodes.get(k).copied().unwrap_or(reader.node);
            let place = node.range().start;
            let joint_name = joint.name.clone().unwrap_or_else(|| match k {
                0 => format!("{name}_joint"),
                _ => format!("{name}_joint_{}", k + 1),
            });
            let is_only_joint = parent == 0 && body.joints.len() == 1;
            let made = reader.joint(joint, &joint_name, node, is_only_joint);
            let free = joint.type_ == Type::Free;
            let is_sound = joint.pos.iter().all(|x| x.is_finite());
            let anchor = if free || !is_sound { [0.0; 3] } else { joint.pos };
            let origin = if free {
                Pose::identity()
            } else {
                frame.compose(&translation(anchor)).compose(&to_zero_coordinate(joint, made.axis))
            };
            let last = k + 1 == body.joints.len() && anchor == [0.0; 3];
            let link = if last { name.clone() } else { format!("{name}_behind_{joint_name}") };
            let child = self.link(link, place, true);
            self.description.links[child].auxiliary = !last;
            self.push(JointRecord { origin, ..made }, above, child);
            above = child;
            frame = translation(anchor.map(|x| -x));
        }
        // A body without joints, or whose frame is not at its last joint, is fixed to the last link.
        if body.joints.is_empty() || self.description.links[above].name.text != name {
            let child = self.link(name.clone(), at, self.moves[above]);
            let fixed = JointRecord { origin: frame, ..joint(format!("{name}_fixed"), at) };
            self.push(fixed, above, child);
            above = child;
        }
        let errors = reader.report.errors();
        let inertial = reader.inertial(body, &name, self.moves[above]);
        let sound = reader.is_read && reader.report.errors() == errors;
        let inertial = inertial.or_else(|| (!sound).then_some((Inertial::default(), at)));
        self.description.links[above].inertial =
            inertial.map(|(inertial, at)| InertialRecord { inertial, at, mass_at: at, sound });
        above
    }

    fn link(&mut self, name: String, at: usize, moves: bool) -> usize {
        let name = Located { text: name, at };
        self.description.links.push(LinkRecord { name, inertial: None, auxiliary: false });
        self.moves.push(moves);
        self.moves.len() - 1
    }

    /// Adds a joint between two links.
    fn push(&mut self, joint: JointRecord, parent: usize, child: usize) {
        let name = |link: usize| Some(self.description.links[link].name.clone());
        let (parent, child) = (name(parent), name(child));
        self.description.joints.push(JointRecord { parent, child, ..joint });
    }
}

/// Returns a fixed joint without its links.
fn joint(name: String, at: usize) -> JointRecord {
    JointRecord {
        name: Located { text: name, at },
        kind: Kind::Fixed,
        parent: None,
        child: None,
        origin: Pose::identity(),
        axis: [0.0, 0.0, 1.0],
        second_axis: [0.0, 1.0, 0.0],
        limits: None,
        mimic: None,
        dynamics: JointDynamics::default(),
        dynamics_at: at,
        sound: true,
    }
}

/// The attributes that define a pose.
const PLACES: [&str; 6] = ["pos", "quat", "axisangle", "euler", "xyaxes", "zaxis"];

/// The reader of one body's element.
struct Reader<'m, 'n, 'r, 'f> {
    model: &'m mjcf_rs::Model,
    node: Node<'n, 'n>,
    /// Whether all numbers of the body could be read.
    is_read: bool,
    classes: &'m Classes<'n>,
    /// Whether a class sets the position or rotation of geoms: mjcf-rs then loses the other of the two.
    classes_place_geoms: bool,
    report: &'r mut Report<'f>,
}

impl<'n> Reader<'_, 'n, '_, '_> {
    /// Reports an invalid pose.
    fn pose(&mut self, pose: &mjcf_rs::Pose, name: &str, at: usize) {
        let length: f64 = pose.rotation.to_array().iter().map(|x| x * x).sum();
        let finite = pose.translation.to_array().iter().all(|x| x.is_finite());
        let is_rotation = (length - 1.0).abs() < 1e-9;
        if !finite || !is_rotation {
            let (message, help) = ("its pose is not finite", "write finite numbers in m and rad");
            self.report.error(
                Code::NotFinite,
                at,
                Some(&Subject::Link(name.into())),
                message,
                help,
            );
        }
    }

    /// Returns a joint without its links.
    fn joint(
        &mut self,
        joint: &Joint,
        name: &str,
        node: Node<'n, 'n>,
        is_only_joint: bool,
    ) -> JointRecord {
        let (subject, at) = (Subject::Joint(name.into()), node.range().start);
        let errors = self.report.errors();
        let single = matches!(joint.type_, Type::Hinge | Type::Slide);
        let effort = if single { self.effort(node, &subject) } else { None };
        let mut refuse = |code, message: &str, help: &str| {
            self.report.error(code, at, Some(&subject), message, help);
        };
        if joint.stiffness != 0.0 || joint.springdamper.is_some() {
            let help = "remove `stiffness` and `springdamper`, and give the spring's torque with the others";
            refuse(Code::NotRead, "its spring is not read", help);
        }
        let Joint { armature, damping, frictionloss: friction, .. } = *joint;
        let numbers = [armature, damping, friction];
        if numbers.iter().any(|&number| number < 0.0) {
            let help = "write numbers of at least 0: damping and friction oppose the motion";
            refuse(
                Code::NegativeJointDynamics,
                "`armature`, `damping` or `frictionloss` is negative",
                help,
            );
        }
        if !single && numbers.iter().any(|&number| number != 0.0) {
            let message =
                "`armature`, `damping` and `frictionloss` of a ball or free joint are not read";
            refuse(Code::NotRead, message, "write 0, or the class that the joint should have");
        }
        let dynamics = if single {
            JointDynamics { armature, damping, friction }
        } else {
            JointDynamics::default()
        };
        if joint.type_ == Type::Free && !is_only_joint {
            let message = "a free joint must be the only joint of a body of the world";
            refuse(Code::NotRead, message, "write the body in `<worldbody>`, with this joint only");
        }
        let mut numbers = numbers
            .into_iter()
            .chain(joint.pos)
            .chain(joint.axis)
            .chain([joint.ref_])
            .chain(joint.range.into_iter().flatten());
        if !numbers.all(|number| number.abs() < MAX_NUMBER) {
            refuse(Code::NotFinite, "a number is not finite", "write finite numbers in SI units");
        }
        let axis = if single {
            normalized(joint.axis).map(|(unit, _)| unit)
        } else {
            Some([0.0, 0.0, 1.0])
        };
        if axis.is_none() {
            refuse(
                Code::ZeroAxis,
                "the axis is zero",
                "write the direction of the axis, such as `0 0 1`",
            );
        }
        let range = joint
            .range
            .filter(|_| {
                joint.limited.resolve(self.model.compiler.autolimits, joint.range.is_some())
            })
            .filter(|_| single);
        let kind = Kind::Moving(match joint.type_ {
            Type::Hinge if range.is_none() => JointType::Continuous,
            Type::Hinge => JointType::Revolute,
            Type::Slide => JointType::Prismatic,
            Type::Ball => JointType::Spherical,
            Type::Free => JointType::Floating,
        });
        if range.is_some_and(|[lower, upper]| lower > upper) {
            let help = "write the lower limit first";
            refuse(Code::InvertedLimits, "the lower limit is above the upper one", help);
        }
        let limits = (range.is_some() || effort.is_some()).then(|| Limits {
            lower: range.map(|[lower, _]| lower),
            upper: range.map(|[_, upper]| upper),
            velocity: None,
            effort,
        });
        let axis = axis.unwrap_or([0.0, 0.0, 1.0]);
        let sound = self.is_read && self.report.errors() == errors;
        JointRecord { kind, axis, limits, dynamics, sound, ..self::joint(name.into(), at) }
    }

    /// Returns the largest force of a joint, N m or N, which is the bound of a symmetric `actuatorfrcrange`.
    fn effort(&mut self, node: Node<'n, 'n>, subject: &Subject) -> Option<f64> {
        let attribute = |name| self.classes.attribute(node, name);
        let range = attribute("actuatorfrcrange")?;
        let is_limited = match attribute("actuatorfrclimited") {
            Some("true") => true,
            Some("false") => false,
            _ => self.model.compiler.autolimits,
        };
        // Words that are not numbers are already reported.
        let mut numbers = range.split_ascii_whitespace().filter_map(|word| word.parse().ok());
        let (lower, upper): (f64, f64) = (numbers.next()?, numbers.next()?);
        if !is_limited || lower == 0.0 && upper == 0.0 {
            return None;
        }
        if -lower == upper && upper > 0.0 && upper < MAX_NUMBER {
            return Some(upper);
        }
        let message = "its `actuatorfrcrange` is not read";
        let help = "write the same limit for both directions, as `actuatorfrcrange=\"-20 20\"`, or limit the joint force \
                    where it is computed";
        self.report.add(
            Severity::Warning,
            Code::NotRead,
            node.range().start,
            Some(subject),
            message,
            help,
        );
        None
    }

    /// Returns the inertia of a body in its frame, and the place of the `<inertial>`.
    fn inertial(&mut self, body: &Body, name: &str, moves: bool) -> Option<(Inertial, usize)> {
        let node = self.node.children().find(|node| node.has_tag_name("inertial"));
        let at = node.unwrap_or(self.node).range().start;
        let from_geoms = self.model.compiler.inertia_from_geom;
        let heavy = body.geoms.iter().any(geoms::has_mass);
        if let Some(own) =
            body.inertial.as_ref().filter(|_| from_geoms != InertiaFromGeom::True || !heavy)
        {
            let inertia = match own.inertia {
                InertiaSpec::Diagonal([xx, yy, zz]) => [xx, 0.0, 0.0, yy, 0.0, zz],
                InertiaSpec::Full([xx, yy, zz, xy, xz, yz]) => [xx, xy, xz, yy, yz, zz],
            };
            self.pose(&own.pose, name, at);
            let inertial = Inertial { mass: own.mass, center_of_mass: [0.0; 3], inertia };
            return Some((inertial.transformed(&pose(&own.pose)), at));
        }
        // Bodies that are fixed to the world have no effect on the dynamics.
        if !moves || !heavy || from_geoms == InertiaFromGeom::False {
            return None;
        }
        let inertial = if self.classes_place_geoms {
            Err("the poses of its geoms come from a class, which is not read")
        } else {
            geoms::inertial(&body.geoms, &self.model.assets)
        };
        inertial.map(|inertial| (inertial, at)).map_err(|why| self.no_inertial(name, at, why)).ok()
    }

    fn no_inertial(&mut self, name: &str, at: usize, why: &str) {
        let message = format!("it has no `<inertial>`, and {why}");
        let help = "write `<inertial>`, or give the geoms `mass=\"0\"`; MuJoCo writes each `<inertial>` if it reads the file \
                    with `<compiler saveinertial=\"true\"/>` and `mj_saveLastXML` saves the model";
        let subject = Subject::Link(name.into());
        self.report.error(Code::MissingElement, at, Some(&subject), message, help);
    }
}

/// Returns the displacement from the coordinate `ref`, at which a joint is drawn, to zero.
fn to_zero_coordinate(joint: &Joint, axis: [f64; 3]) -> Pose<f64> {
    let [x, y, z] = axis;
    match joint.type_ {
        Type::Slide => translation(axis.map(|x| -joint.ref_ * x)),
        Type::Hinge if joint.ref_ != 0.0 => {
            let (sin, cos) = libm::sincos(-0.5 * joint.ref_);
            let rotation = rotation_from_quaternion([x * sin, y * sin, z * sin, cos]);
            Pose { rotation, ..Pose::identity() }
        }
        _ => Pose::identity(),
    }
}

fn translation(translation: [f64; 3]) -> Pose<f64> {
    Pose { translation, ..Pose::identity() }
}
