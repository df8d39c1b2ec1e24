//! Reads the `<robot>` with all its elements, in order.

use modyn_runtime::joint::JointType;
use modyn_runtime::model::Actuation;
use roxmltree::Node;

use super::reader::Reader;
use crate::description::{Description, Kind, LinkRecord, ReadOptions};
use crate::diagnostics::{Code, Place, Report, Severity};
use crate::read::packages::Packages;
use crate::read::visual::Surfaces;
use crate::read::xml::element::{Elements, children, is};
use crate::read::xml::unread::Unread;

/// Reads the elements of a `<robot>`.
pub fn read(robot: Node, options: &ReadOptions, report: &mut Report<'_>) -> Description {
    let at = robot.range().start;
    let mut reader = Reader {
        xml: Elements { root: robot, start: 0, report },
        options,
        has_quaternions: !matches!(
            robot.attribute("version").map(str::trim),
            None | Some("1" | "1.0")
        ),
        ignored_quaternions: Vec::new(),
        dropped_inertias: Vec::new(),
        negative_limits: Vec::new(),
        anisotropic: Vec::new(),
        unread: Unread::default(),
        packages: Packages::default(),
        surfaces: Surfaces::default(),
        materials: None,
        shape_notes: Vec::new(),
    };
    let name = robot.attribute("name").unwrap_or("");
    if name.trim().is_empty() {
        let help = "write `<robot name=\"...\">`; it is called `robot` here, and its type `Robot` would \
                    collide with `use modyn::Robot`, unless you name it: `modyn!(pub MyArm = \"...\")`";
        reader.xml.report.add(
            Severity::Warning,
            Code::MissingAttribute,
            at,
            None,
            "the robot has no name",
            help,
        );
    }
    let name = if name.trim().is_empty() { "robot" } else { name };
    let mut description = Description {
        name: name.into(),
        at,
        gravity: None,
        links: Vec::new(),
        joints: Vec::new(),
        compensated: Vec::new(),
        loops: Vec::new(),
        contacts: Vec::new(),
        keyframes: Vec::new(),
        actuation: Actuation::default(),
        shape_notes: Vec::new(),
        soft: None,
        softnesses: Vec::new(),
        loop_softnesses: Vec::new(),
    };
    for node in children(robot) {
        if is(node, "link") {
            description.links.extend(reader.link(node));
        } else if is(node, "joint") || is(node, "drake.joint") {
            description.joints.push(reader.joint(node));
        } else if is(node, "loop_joint") {
            description.loops.push(reader.loop_joint(node));
        } else if is(node, "contact_frame") {
            description.contacts.push(reader.contact_frame(node));
        }
    }
    description.shape_notes = std::mem::take(&mut reader.shape_notes);
    reader.add_world(&mut description);
    reader.extensions(robot, &mut description);
    reader.collisions(robot, &mut description);
    reader.warn_of_unread_values(&description);
    reader.unread.warn(reader.xml.report);
    description
}

/// The link that Drake's descriptions name without describing it.
const WORLD: &str = "world";

impl<'a> Reader<'a, '_, '_, '_> {
    /// Adds the link `world` if joints name it as their parent and it is not described, as Drake
    /// does.
    fn add_world(&mut self, description: &mut Description) {
        if description.link_names().any(|name| name == WORLD) {
            return;
        }
        let parents = description.joints.iter().filter_map(|joint| joint.parent.as_ref());
        let Some(name) = parents.into_iter().find(|parent| parent.text == WORLD).cloned() else {
            return;
        };
        let message = "the link `world` is not described, and is taken as the world";
        let severity = Severity::Warning;
        let code = Code::UnknownParent;
        let help = "write `<link name=\"world\"/>`";
        self.xml.report.add(severity, code, name.at, None, message, help);
        description.links.insert(0, LinkRecord::new(name, None));
    }

    /// Warns, once for each kind, of elements whose meaning probably differs from what the author
    /// expects.
    fn warn_of_unread_values(&mut self, description: &Description) {
        let message = "a limit of effort or velocity is negative, and is ignored";
        let help = "write its magnitude, or omit the attribute if there is no limit";
        self.xml.report.warn_once(Code::NegativeLimit, &self.negative_limits, message, help);
        let message = "a number of the inertia ends in white space, or numbers are separated by other white space than \
                       spaces; urdfdom, which ROS and Pinocchio use, then drops the whole inertia";
        let help =
            "write numbers without a new line or a tabulator, and nothing after a single number";
        self.xml.report.warn_once(Code::BadNumber, &self.dropped_inertias, message, help);
        let message = "`quat_xyzw` is read, but urdfdom, which ROS and Pinocchio use, ignores it: it is of URDF 1.1";
        let help = "write `<robot version=\"1.2\" ...>`";
        self.xml.report.warn_once(Code::NotRead, &self.ignored_quaternions, message, help);
        let unlimited: Vec<Place> = description
            .joints
            .iter()
            .filter(|joint| {
                let bounded = [JointType::Revolute, JointType::Prismatic].map(Kind::Moving);
                bounded.contains(&joint.kind) && joint.limits.is_none() && joint.mimic.is_none()
            })
            .map(|joint| (Some(joint.name.at), Some(joint.subject())))
            .collect();
        let message = "it has no `<limit>`, so it has no position limits";
        let help = "write `<limit lower=\"...\" upper=\"...\" effort=\"...\" velocity=\"...\"/>`, or make a \
                    joint that rotates without limits `continuous`";
        self.xml.report.warn_once(Code::MissingLimit, &unlimited, message, help);
        let robot = self.xml.root;
        let read = ["link", "joint", "loop_joint", "contact_frame"];
        let part = |node: &Node| read.iter().any(|name| is(*node, name));
        let inside = children(robot).filter(part).flat_map(|part| children(part));
        let included: Vec<Place> = children(robot)
            .chain(inside)
            .filter(|node| node.is_element() && node.tag_name().name().ends_with("include"))
            .map(|node| (Some(node.range().start), None))
            .collect();
        let message =
            "another file is included, which is not read: parts of the robot may be missing";
        let help = "copy the content of that file into this one";
        self.xml.report.warn_once(Code::Include, &included, message, help);
    }
}
