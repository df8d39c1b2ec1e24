//! A robot as an MJCF, which MuJoCo reads as well.
//!
//! A moving link is a body. A link without inertia whose only child has the next joint becomes a
//! joint of the child's body, since MuJoCo refuses a body that moves without mass. A link that is
//! fixed to another one is a body without joints if it has mass, else a site.

use modyn_runtime::conventions::mujoco::{to_qpos, to_qvel};
use modyn_runtime::conventions::{
    quaternion_from_rotation, rotation_from_quaternion, wxyz_from_xyzw,
};
use modyn_runtime::joint::{JointType, planar};
use modyn_runtime::model::{
    Cone, Inertial, Integrator, JointDynamics, Keyframe, Link, LoopConstraintEnd,
    LoopConstraintKind, Model,
};
use modyn_runtime::spatial::Pose;

use super::actuators::WrittenActuators;
use super::xml::Element;
use super::{Document, Names, actuators, is_massless, range, shapes};
use crate::description::UNLIMITED;
use crate::diagnostics::{Code, Diagnostic, listed};

/// The mass and the moment of inertia that MuJoCo requires of a moving body, kg and kg m^2.
const MUJOCO_MINIMUM: f64 = 1e-15;

/// The name of the body that does not move.
const WORLD: &str = "world";

/// The maker of a document.
struct Writer<'m> {
    model: &'m Model,
    document: Document,
    /// For each link, the links whose joints are joints of its body, from the root; the last one is
    /// the link itself.
    joints: Vec<Vec<usize>>,
    /// The names of bodies and sites.
    places: Names,
    /// The name of the link `world`, if that is not the world: MuJoCo reserves it.
    world_link: String,
    /// The names of joints.
    names: Names,
}

/// Returns the document of a robot.
pub fn document(model: &Model) -> Document {
    let links = model.moving_links();
    let names = model.links().iter().map(|link| &*link.name);
    let mut document = Document::new(Element::new("mujoco").with("model", model.name()));
    let mut places = Names::new(names.chain(links.iter().map(|link| &*link.name)).chain([WORLD]));
    let mut world_link = WORLD.to_owned();
    let is_world = |frame: &Link| frame.moving_link.is_none() && frame.pose == Pose::identity();
    if model.links().iter().any(|link| link.name == WORLD && !is_world(link)) {
        world_link = places.unique(format!("{WORLD}_frame"));
        document.notes.push(format!(
            "The link `{WORLD}` is called `{world_link}`: MuJoCo reserves the name."
        ));
    }
    let mut writer = Writer {
        model,
        document,
        joints: bodies(model),
        places,
        world_link,
        names: Names::new(links.iter().map(|link| &*link.joint.name)),
    };
    let compiler = Element::new("compiler").with("angle", "radian").with("autolimits", "true");
    let option = writer.option();
    let world = writer.world();
    let (mut world, equality) = writer.equality(world);
    let assets = writer.shapes(&mut world);
    let WrittenActuators { section: actuators, notes } = actuators::of_mjcf(model);
    let keyframes = writer.keyframes(&actuators);
    let Writer { mut document, .. } = writer;
    document.notes.extend(notes);
    document.root.children.extend([compiler, option]);
    let is_full = |section: &Element| !section.children.is_empty();
    document.root.children.extend(Some(assets).filter(is_full));
    document.root.children.push(world);
    document.root.children.extend([equality, actuators, keyframes].into_iter().filter(is_full));
    document
}

/// Returns, for each link, the links whose joints are joints of its body; none for a link without a
/// body.
fn bodies(model: &Model) -> Vec<Vec<usize>> {
    let links = model.moving_links();
    let children = model.children();
    let of_loops = model.loop_constraints().iter().flat_map(|constraint| &constraint.ends);
    let of_contacts = model.contacts().iter().map(|contact| &contact.end);
    let of_shapes = model.soft_constraints().shapes.iter().map(|shape| &shape.end);
    let ends = of_loops.chain(of_contacts).chain(of_shapes);
    let carries = |link: usize, frame: &Link| {
        frame.moving_link == Some(link) && frame.name != links[link].name
    };
    let mut is_needed = vec![false; links.len()];
    ends.filter_map(|end| model.links()[end.link].moving_link)
        .for_each(|link| is_needed[link] = true);
    for frame in model.links() {
        if let Some(link) = frame.moving_link.filter(|&link| carries(link, frame)) {
            is_needed[link] = true;
        }
    }
    let mut joints: Vec<Vec<usize>> = (0..links.len()).map(|i| vec![i]).collect();
    for i in 0..links.len() {
        let is_simple = |link: usize| {
            let kind = links[link].joint.joint_type;
            !matches!(kind, JointType::Spherical | JointType::Floating)
        };
        if let [child] = *children[i]
            && is_massless(&links[i].inertial)
            && !is_needed[i]
            && is_simple(i)
            && is_simple(child)
        {
            // Parents come before their children.
            let own_joints = std::mem::take(&mut joints[i]);
            joints[child].splice(0..0, own_joints);
        }
    }
    joints
}

/// The largest number of planes that the masks of geoms tell from each other.
const MAX_PLANES: usize = 31;

impl Writer<'_> {
    /// Returns `<option>`.
    fn option(&self) -> Element {
        let mut option = Element::new("option").numbers("gravity", &self.model.gravity());
        let soft = self.model.soft_constraints();
        if soft.cone == Cone::Elliptic {
            option = option.with("cone", "elliptic");
        }
        for (name, number) in [("timestep", soft.time_step), ("impratio", soft.impratio)] {
            if let Some(number) = number {
                option = option.numbers(name, &[number]);
            }
        }
        match soft.integrator {
            Integrator::Euler => option,
            Integrator::ImplicitFast => option.with("integrator", "implicitfast"),
            Integrator::ExplicitEuler => {
                option.children.push(Element::new("flag").with("eulerdamp", "disable"));
                option
            }
        }
    }

    /// Adds the planes of the ground to the world, and the shapes that touch them to their bodies.
    /// Returns `<asset>` with their meshes.
    fn shapes(&mut self, world: &mut Element) -> Element {
        let model = self.model;
        let shapes = &model.soft_constraints().shapes;
        let mut assets = Element::new("asset");
        let mut left_out = Vec::new();
        let mut names = Names::new(shapes.iter().map(|shape| &*shape.name));
        let planes = shapes::planes(model);
        for (index, plane) in planes.iter().enumerate().take(MAX_PLANES) {
            let ground = Element::new("geom")
                .with("name", names.unique("ground".into()))
                .with("type", "plane")
                .numbers("size", &[0.0, 0.0, 1.0])
                .with("contype", "0")
                .with("conaffinity", (1_u32 << index).to_string());
            world.children.insert(index, placed(ground, plane));
        }
        for shape in shapes {
            let touched =
                planes.iter().take(MAX_PLANES).position(|one| *one == shape.surface.plane);
            let Some(written) = touched.and_then(|plane| shapes::geom(shape, plane)) else {
                left_out.push(shape);
                continue;
            };
            assets.children.extend(written.mesh);
            // The frame is a body, since it carries a shape.
            let name = self.place_name(&model.links()[shape.end.link].name);
            if let Some(body) = world.find("body", name) {
                let at = body.children.iter().position(|child| child.is("body"));
                let geom = placed(written.geom, &shape.end.pose);
                body.children.insert(at.unwrap_or(body.children.len()), geom);
            }
        }
        self.document.notes.extend(shapes::notes(model, &left_out, false));
        assets
    }

    /// Returns `<worldbody>` with all bodies.
    fn world(&mut self) -> Element {
        let links = self.model.moving_links();
        self.say_what_mujoco_refuses();
        let mut frames: Vec<Vec<&Link>> = vec![Vec::new(); links.len()];
        let mut world = Element::new("worldbody");
        for frame in self.model.links() {
            match frame.moving_link {
                Some(link) if frame.name == links[link].name => {}
                Some(link) => frames[link].push(frame),
                None if frame.name == WORLD && frame.pose == Pose::identity() => {}
                None => world.children.push(self.frame(frame)),
            }
        }
        // Children come after their parents, so each body is complete before its parent.
        let mut inside: Vec<Vec<Element>> = (0..links.len()).map(|_| Vec::new()).collect();
        let mut on_world = Vec::new();
        for i in (0..links.len()).rev() {
            let Some(&first) = self.joints[i].first() else { continue };
            let mut body = self.body(i);
            let fixed: Vec<Element> = frames[i].iter().map(|frame| self.frame(frame)).collect();
            body.children.extend(fixed);
            body.children.extend(std::mem::take(&mut inside[i]).into_iter().rev());
            match links[first].parent {
                Some(parent) => inside[parent].push(body),
                None => on_world.push(body),
            }
        }
        world.children.extend(on_world.into_iter().rev());
        world
    }

    /// Returns the body of a link, without the bodies in it.
    fn body(&mut self, link: usize) -> Element {
        let links = self.model.moving_links();
        let own_joints = self.joints[link].clone();
        let origins = own_joints.iter().map(|&i| &links[i].joint.origin);
        let pose = origins.fold(Pose::identity(), |pose, origin| pose.compose(origin));
        let name = self.place_name(&links[link].name);
        // The spring of a floating body is at rest where the body is drawn.
        let rest = self.model.spring(link).and_then(|spring| match *spring.reference {
            [x, y, z, a, b, c, d] => {
                let rotation = rotation_from_quaternion([a, b, c, d]);
                Some(Pose { rotation, translation: [x, y, z] })
            }
            _ => None,
        });
        let mut body = Element::new("body").with("name", name);
        let compensation = self.compensation(self.model.link_index(&links[link].name));
        if compensation != 0.0 {
            body = body.numbers("gravcomp", &[compensation]);
        }
        let mut body = placed(body, &rest.unwrap_or(pose));
        let mut reached = Pose::identity();
        for i in own_joints {
            reached = reached.compose(&links[i].joint.origin);
            // The pose of the joint's frame in the body's.
            let place = relative(&pose, &reached);
            let joints = self.joints_of(i, &place);
            body.children.extend(joints);
        }
        body.maybe(inertial(&own_inertial(self.model, link)))
    }

    /// Returns the elements of a link's joint, whose frame has this pose in the body.
    fn joints_of(&mut self, link: usize, place: &Pose<f64>) -> Vec<Element> {
        let model = self.model;
        let joint = &model.moving_links()[link].joint;
        let spring = model.spring(link);
        let JointDynamics { armature, damping, friction } = joint.dynamics;
        if let Some(velocity) = joint.limits.and_then(|limits| limits.velocity) {
            let note =
                format!("The velocity limit of joint `{}`, {velocity}, is left out.", joint.name);
            self.document.notes.push(note);
        }
        let axes: Vec<(&'static str, [f64; 3])> = match joint.joint_type {
            JointType::Revolute | JointType::Continuous => vec![("hinge", joint.axis)],
            JointType::Prismatic => vec![("slide", joint.axis)],
            JointType::Universal => vec![("hinge", joint.axis), ("hinge", joint.second_axis)],
            JointType::Planar => {
                let plane = planar::plane(joint.axis);
                let column = |k: usize| plane.map(|row| row[k]);
                vec![("slide", column(0)), ("slide", column(1)), ("hinge", joint.axis)]
            }
            JointType::Spherical => vec![("ball", joint.axis)],
            JointType::Floating => return self.floating(link),
        };
        let parts = joint.joint_type.coordinates();
        let is_single = axes.len() == 1;
        let mut elements = Vec::new();
        for (k, (kind, axis)) in axes.into_iter().enumerate() {
            let name = match is_single {
                true => joint.name.clone(),
                false => self.names.unique(format!("{}_{}", joint.name, parts[k])),
            };
            let mut element = Element::new("joint").with("name", name).with("type", kind);
            if place.translation != [0.0; 3] {
                element = element.numbers("pos", &place.translation);
            }
            if kind != "ball" {
                element = element.numbers("axis", &place.rotate(axis));
            }
            if is_single && kind != "ball" {
                element = self.limited(link, element);
            }
            for (name, x) in
                [("damping", damping), ("frictionloss", friction), ("armature", armature)]
            {
                if x != 0.0 {
                    element = element.numbers(name, &[x]);
                }
            }
            if let Some(spring) = spring.filter(|spring| spring.stiffness != 0.0) {
                element = element.numbers("stiffness", &[spring.stiffness]);
                if kind != "ball" {
                    element = element.numbers("springref", &[spring.reference[k]]);
                } else if spring.reference != [0.0, 0.0, 0.0, 1.0] {
                    self.refuse(format!(
                        "the spring of joint `{}` is at rest at a rotation, which MJCF has no words for",
                        joint.name
                    ));
                }
            }
            elements.push(element);
        }
        elements
    }

    /// Returns the part of the weight of a link of the description that is compensated.
    fn compensation(&self, frame: Option<usize>) -> f64 {
        let factors = self.model.gravity_compensation();
        frame.and_then(|frame| factors.get(frame)).copied().unwrap_or(0.0)
    }

    /// Returns the element of a link's joint with its limits.
    fn limited(&mut self, link: usize, mut element: Element) -> Element {
        let joint = &self.model.moving_links()[link].joint;
        if let Some([lower, upper]) = range(joint.limits.as_ref()) {
            if lower < upper {
                element = element.numbers("range", &[lower, upper]);
            } else {
                let note = format!(
                    "The range of joint `{}`, {lower} to {upper}, is left out.",
                    joint.name
                );
                self.document.notes.push(note);
            }
        }
        let mut ranges = self.model.actuation().joint_force_ranges.iter();
        if let Some(forces) = ranges.find(|forces| forces.link == link) {
            let ends = forces.range.map(|end| end.clamp(-UNLIMITED, UNLIMITED));
            return element.numbers("actuatorfrcrange", &ends);
        }
        let Some(effort) = joint.limits.and_then(|limits| limits.effort) else { return element };
        if effort > 0.0 && actuators::are_within(self.model, link, effort) {
            return element.numbers("actuatorfrcrange", &[-effort, effort]);
        }
        let why = if effort > 0.0 { ": its actuators exceed it" } else { "" };
        let note =
            format!("The effort limit of joint `{}`, {effort}, is left out{why}.", joint.name);
        self.document.notes.push(note);
        element
    }

    /// Returns the joint of a floating link.
    fn floating(&mut self, link: usize) -> Vec<Element> {
        let record = &self.model.moving_links()[link];
        let joint = &record.joint;
        let JointDynamics { armature, damping, friction } = joint.dynamics;
        if record.parent.is_some() || joint.origin != Pose::identity() {
            let message = format!(
                "the floating joint `{}` starts at another frame than the world's, which MJCF has no words for",
                joint.name
            );
            self.refuse(message);
        }
        if friction != 0.0 {
            let message = format!(
                "the floating joint `{}` has friction, which MuJoCo applies in other axes",
                joint.name
            );
            self.refuse(message);
        }
        let stiffness = self.model.spring(link).map_or(0.0, |spring| spring.stiffness);
        let forces = [("damping", damping), ("armature", armature), ("stiffness", stiffness)];
        if forces.iter().all(|(_, x)| *x == 0.0) {
            return vec![
                Element::new("freejoint").with("name", &*joint.name).with("align", "false"),
            ];
        }
        let element = Element::new("joint").with("name", &*joint.name).with("type", "free");
        let acting = forces.into_iter().filter(|(_, x)| *x != 0.0);
        vec![acting.fold(element, |element, (name, x)| element.numbers(name, &[x]))]
    }

    /// Returns a link that is fixed to another one, or to the world.
    fn frame(&self, frame: &Link) -> Element {
        let name = self.place_name(&frame.name);
        let index = self.model.link_index(&frame.name);
        let mut shapes = self.model.soft_constraints().shapes.iter();
        let touches = shapes.any(|shape| Some(shape.end.link) == index);
        // The softness of contacts depends on the body of their shape.
        if is_massless(&frame.inertial) && !touches {
            return placed(Element::new("site").with("name", name), &frame.pose);
        }
        let mut body = Element::new("body").with("name", name);
        let compensation = self.compensation(index);
        if compensation != 0.0 {
            body = body.numbers("gravcomp", &[compensation]);
        }
        placed(body, &frame.pose).maybe(inertial(&frame.inertial))
    }

    /// Returns the name of a body or a site: the link's, unless it is the reserved name of the
    /// world.
    fn place_name<'n>(&'n self, name: &'n str) -> &'n str {
        if name == WORLD { &self.world_link } else { name }
    }

    /// Returns `<worldbody>` with the sites of loops and contacts, and `<equality>` with mimic
    /// joints and loops.
    fn equality(&mut self, mut world: Element) -> (Element, Element) {
        let mut equality = Element::new("equality");
        let links = self.model.moving_links();
        for link in links {
            let Some(mimic) = link.joint.mimic else { continue };
            let leader = &links[mimic.leader].joint.name;
            let element = Element::new("joint")
                .with("joint1", &*link.joint.name)
                .with("joint2", &**leader)
                .numbers("polycoef", &[mimic.offset, mimic.multiplier, 0.0, 0.0, 0.0]);
            equality.children.push(element);
        }
        for constraint in self.model.loop_constraints() {
            let kind = match constraint.kind {
                LoopConstraintKind::Point => "connect",
                LoopConstraintKind::Rigid => "weld",
                LoopConstraintKind::Revolute(_) | LoopConstraintKind::Prismatic(_) => {
                    let message = format!(
                        "the loop `{}` is {}, and MJCF has words for spherical and fixed loops alone",
                        constraint.name,
                        constraint.kind.name()
                    );
                    self.refuse(message);
                    continue;
                }
            };
            let mut element = Element::new(kind).with("name", &*constraint.name);
            for (k, end) in constraint.ends.iter().enumerate() {
                let site = self.places.unique(format!("{}_{}", constraint.name, k + 1));
                element = element.with(["site1", "site2"][k], &*site);
                self.add_site(&site, end, &mut world);
            }
            equality.children.push(element);
        }
        let mut contacts = Vec::new();
        for contact in self.model.contacts() {
            let site = self.places.unique(contact.name.clone());
            self.add_site(&site, &contact.end, &mut world);
            contacts.push(format!("\"{}\": {}(\"{site}\")", contact.name, contact.kind.name()));
        }
        if !contacts.is_empty() {
            self.document.notes.push(format!(
                "The format has no contact frames: read the robot with the option `contacts = [{}]`.",
                contacts.join(", ")
            ));
        }
        (world, equality)
    }

    /// Returns `<keyframe>`, with the coordinates in the order of the joints in the text. Its keyframes
    /// have their controls if the text has all actuators and their states.
    fn keyframes(&self, actuators: &Element) -> Element {
        let all = &self.model.actuation().actuators;
        let has_controls =
            actuators.children.len() == all.len() && all.iter().all(|actuator| actuator.delay == 0);
        let links = self.model.moving_links();
        // From the last to the first, the bodies that are still to come; a body is followed by
        // those in it.
        let inside = |body: Option<usize>| {
            let first =
                move |&i: &usize| self.joints[i].first().is_some_and(|&f| links[f].parent == body);
            (0..links.len()).rev().filter(first)
        };
        let mut order = Vec::new();
        let mut open = inside(None).collect::<Vec<_>>();
        while let Some(body) = open.pop() {
            order.extend(&self.joints[body]);
            open.extend(inside(Some(body)));
        }
        let mut section = Element::new("keyframe");
        for keyframe in self.model.keyframes() {
            let of_joint = |&link: &usize| self.coordinates(link, &keyframe.q);
            let numbers: Vec<f64> = order.iter().flat_map(of_joint).collect();
            let mut key =
                Element::new("key").with("name", &*keyframe.name).numbers("qpos", &numbers);
            if !keyframe.qd.is_empty() {
                let of_joint = |&link: &usize| self.velocities(link, keyframe);
                let numbers: Vec<f64> = order.iter().flat_map(of_joint).collect();
                key = key.numbers("qvel", &numbers);
            }
            for (name, numbers) in [("act", &keyframe.act), ("ctrl", &keyframe.ctrl)] {
                if has_controls && !numbers.is_empty() {
                    key = key.numbers(name, numbers);
                }
            }
            section.children.push(key);
        }
        section
    }

    /// Returns the velocities of a link's joint as MuJoCo has them.
    fn velocities(&self, link: usize, keyframe: &Keyframe) -> Vec<f64> {
        if let Some(mimic) = self.model.moving_links()[link].joint.mimic {
            let leader = self.velocities(mimic.leader, keyframe)[0];
            return vec![mimic.multiplier * leader];
        }
        let [q, qd] =
            [&keyframe.q[self.model.q_range(link)], &keyframe.qd[self.model.v_range(link)]];
        match (q, qd) {
            (&[x, y, z, a, b, c, d], &[vx, vy, vz, wx, wy, wz]) => {
                to_qvel([x, y, z, a, b, c, d], [vx, vy, vz, wx, wy, wz]).to_vec()
            }
            (_, numbers) => numbers.to_vec(),
        }
    }

    /// Returns the coordinates of a link's joint as MuJoCo has them.
    fn coordinates(&self, link: usize, q: &[f64]) -> Vec<f64> {
        let joint = &self.model.moving_links()[link].joint;
        if let Some(mimic) = joint.mimic {
            let leader = self.coordinates(mimic.leader, q)[0];
            return vec![mimic.multiplier * leader + mimic.offset];
        }
        match (joint.joint_type, &q[self.model.q_range(link)]) {
            (JointType::Spherical, &[x, y, z, w]) => wxyz_from_xyzw([x, y, z, w]).to_vec(),
            (JointType::Floating, &[x, y, z, a, b, c, d]) => {
                to_qpos([x, y, z, a, b, c, d]).to_vec()
            }
            (_, numbers) => numbers.to_vec(),
        }
    }

    /// Adds a site at the end of a loop or contact to its body.
    fn add_site(&mut self, name: &str, end: &LoopConstraintEnd, world: &mut Element) {
        let frame = &self.model.links()[end.link];
        let site = placed(Element::new("site").with("name", name), &frame.pose.compose(&end.pose));
        let body = match frame.moving_link {
            Some(link) => {
                world.find("body", self.place_name(&self.model.moving_links()[link].name))
            }
            None => Some(world),
        };
        if let Some(body) = body {
            // Before the bodies in it, as people write it.
            let at = body.children.iter().position(|child| child.is("body"));
            body.children.insert(at.unwrap_or(body.children.len()), site);
        }
    }

    /// Adds an error: the dynamics of the robot that is read again would differ.
    fn refuse(&mut self, message: String) {
        let error = Diagnostic::error(Code::Inexpressible, message).with_help("write a URDF");
        self.document.errors.push(error);
    }

    /// Notes links without a body, and bodies that MuJoCo refuses.
    fn say_what_mujoco_refuses(&mut self) {
        let links = self.model.moving_links();
        let is_merged = |i: &usize| self.joints[*i].is_empty();
        let merged: Vec<usize> = (0..links.len()).filter(is_merged).collect();
        let many = merged.len() != 1;
        let notes = &mut self.document.notes;
        let named =
            |links_of: &[usize]| listed("link", links_of.iter().map(|&i| links[i].name.as_str()));
        if !merged.is_empty() {
            let (joints, are) = if many { ("their joints", "are") } else { ("its joint", "is") };
            notes.push(format!(
                "Without inertia, {} {are} no body: the next body has {joints}.",
                named(&merged)
            ));
        }
        let is_refused = |i: &usize| {
            let Inertial { mass, .. } = links[*i].inertial;
            let moves = mass.min(links[*i].inertial.principal_moments()[0]) > MUJOCO_MINIMUM;
            !self.joints[*i].is_empty() && !moves
        };
        let refused: Vec<usize> = (0..links.len()).filter(is_refused).collect();
        if !refused.is_empty() {
            notes.push(format!(
                "MuJoCo refuses bodies that move without mass or rotational inertia, as {} {}; modyn reads them.",
                named(&refused),
                if refused.len() == 1 { "does" } else { "do" },
            ));
        }
    }
}

/// Returns the inertia of a link by itself, without the links that are fixed to it.
fn own_inertial(model: &Model, link: usize) -> Inertial {
    let link = &model.moving_links()[link];
    let carrier = model.links().iter().find(|frame| frame.name == link.name);
    carrier.map_or(link.inertial, |frame| frame.inertial)
}

/// Returns the `<inertial>` of an inertia; `None` for no inertia.
fn inertial(inertial: &Inertial) -> Option<Element> {
    let Inertial { mass, center_of_mass, inertia: [xx, xy, xz, yy, yz, zz] } = *inertial;
    let element =
        || Element::new("inertial").numbers("pos", &center_of_mass).numbers("mass", &[mass]);
    (!is_massless(inertial)).then(|| match [xy, xz, yz] == [0.0; 3] {
        true => element().numbers("diaginertia", &[xx, yy, zz]),
        false => element().numbers("fullinertia", &[xx, yy, zz, xy, xz, yz]),
    })
}

/// Returns the element with the attributes of a pose, without attributes that are the identity's.
fn placed(mut element: Element, pose: &Pose<f64>) -> Element {
    if pose.translation != [0.0; 3] {
        element = element.numbers("pos", &pose.translation);
    }
    if pose.rotation != Pose::identity().rotation {
        let quaternion = wxyz_from_xyzw(quaternion_from_rotation(pose.rotation));
        element = element.numbers("quat", &quaternion);
    }
    element
}

/// Returns the pose of a frame `inner` in the frame `outer`, both given in the same frame.
fn relative(outer: &Pose<f64>, inner: &Pose<f64>) -> Pose<f64> {
    inverse(outer).compose(inner)
}

/// Returns the inverse of a pose.
fn inverse(pose: &Pose<f64>) -> Pose<f64> {
    let transposed = std::array::from_fn(|i| std::array::from_fn(|j| pose.rotation[j][i]));
    let back = Pose { rotation: transposed, translation: [0.0; 3] };
    Pose { translation: back.rotate(pose.translation).map(|x| -x), ..back }
}
