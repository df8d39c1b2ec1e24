//! A robot as a URDF, with modyn's extensions: `<loop_joint>`, `<contact_frame>`, `<axis2>`, the
//! joint type `spherical`, and `armature`.

use modyn_runtime::ContactSurface;
use modyn_runtime::joint::JointType;
use modyn_runtime::model::{
    ContactComponents, Inertial, Joint, JointDynamics, LoopConstraintEnd, Model, TouchingShape,
};
use modyn_runtime::spatial::Pose;

use super::xml::Element;
use super::{Document, Names, is_massless, range, shapes};
use crate::description::UNLIMITED;
use crate::diagnostics::{Code, Diagnostic, listed};

/// Returns the document of a robot.
pub fn document(model: &Model) -> Document {
    let mut document = Document::new(Element::new("robot").with("name", model.name()));
    let links = model.moving_links();
    let frames = model.links();
    let mut names = Names::new(
        frames.iter().map(|frame| &*frame.name).chain(links.iter().map(|link| &*link.name)),
    );
    let fixed_frame =
        frames.iter().find(|frame| frame.moving_link.is_none() && frame.pose == Pose::identity());
    let root = fixed_frame.map_or_else(|| names.unique("world".into()), |frame| frame.name.clone());
    let elements = &mut document.root.children;
    if model.link_index(&root).is_none() {
        elements.push(Element::new("link").with("name", &*root));
        document.notes.push(format!(
            "The link `{root}` is added: the robot is connected to it, as a URDF needs it."
        ));
    }
    let mut left_out = Vec::new();
    let mut collisions: Vec<Vec<Element>> = frames.iter().map(|_| Vec::new()).collect();
    for shape in shapes::solids(model) {
        match collision(shape) {
            Some(element) => collisions[shape.end.link].push(element),
            None => left_out.push(shape),
        }
    }
    for (frame, collisions) in frames.iter().zip(collisions) {
        let mut element = link(&frame.name, &frame.inertial);
        element.children.extend(collisions);
        elements.push(element);
    }
    for moving in links.iter().filter(|moving| model.link_index(&moving.name).is_none()) {
        elements.push(link(&moving.name, &moving.inertial));
    }
    let mut joints = Names::new(links.iter().map(|link| &*link.joint.name));
    for moving in links {
        let parent = moving.parent.map_or(&*root, |parent| &links[parent].name);
        elements.push(joint(model, &moving.joint, parent, &moving.name));
    }
    for frame in frames {
        let carrier = frame.moving_link.map_or(&*root, |link| &links[link].name);
        if carrier == frame.name {
            continue;
        }
        let name = joints.unique(format!("{}_fixed", frame.name));
        let fixed = Element::new("joint").with("name", name).with("type", "fixed");
        elements.push(
            fixed
                .maybe(origin(&frame.pose))
                .child(end("parent", carrier))
                .child(end("child", &frame.name)),
        );
    }
    refuse_passive_forces(model, &mut document.errors);
    note_extensions(model, &mut document.notes);
    document.notes.extend(shapes::notes(model, &left_out, true));
    document.notes.extend(note_on_laws(model));
    let elements = &mut document.root.children;
    elements.extend(frictions(model));
    let frame_name = |end: &LoopConstraintEnd| &*frames[end.link].name;
    for constraint in model.loop_constraints() {
        let kind = constraint.kind;
        let mut element =
            Element::new("loop_joint").with("name", &*constraint.name).with("type", kind.name());
        for (name, loop_end) in ["link1", "link2"].into_iter().zip(&constraint.ends) {
            element.children.push(placed(end(name, frame_name(loop_end)), &loop_end.pose));
        }
        let axis = kind.axis().map(|axis| Element::new("axis").numbers("xyz", &axis));
        elements.push(element.maybe(axis));
    }
    for contact in model.contacts() {
        let element = Element::new("contact_frame")
            .with("name", &*contact.name)
            .with("type", contact.kind.name())
            .with("link", frame_name(&contact.end));
        elements.push(placed(element, &contact.end.pose));
    }
    document
}

/// Adds an error for springs and for gravity compensation.
fn refuse_passive_forces(model: &Model, errors: &mut Vec<Diagnostic>) {
    let springs = model.springs().iter().filter(|spring| spring.stiffness != 0.0);
    let joints = springs.map(|spring| &*model.moving_links()[spring.link].joint.name);
    let compensated = model.links().iter().zip(model.gravity_compensation());
    let links = compensated
        .filter(|(frame, factor)| {
            **factor != 0.0 && frame.moving_link.is_some() && frame.inertial.mass != 0.0
        })
        .map(|(frame, _)| &*frame.name);
    let unwritten = [
        (listed("joint", joints.clone()), joints.count(), "a spring"),
        (listed("link", links.clone()), links.count(), "gravity compensation"),
    ];
    for (names, count, what) in unwritten.into_iter().filter(|(_, count, _)| *count > 0) {
        let have = if count == 1 { "has" } else { "have" };
        let message = format!("{names} {have} {what}, which URDF has no words for");
        errors.push(Diagnostic::error(Code::Inexpressible, message).with_help("write an MJCF"));
    }
}

/// Notes the parts of a robot that other readers of URDF do not know.
fn note_extensions(model: &Model, notes: &mut Vec<String>) {
    let has =
        |joint_type| model.moving_links().iter().any(|link| link.joint.joint_type == joint_type);
    let features = [
        (has(JointType::Spherical), "joints of type `spherical`"),
        (has(JointType::Universal), "joints of type `universal`"),
        (!model.loop_constraints().is_empty(), "`<loop_joint>`"),
        (!model.contacts().is_empty(), "`<contact_frame>`"),
        (model.moving_links().iter().any(|link| link.joint.dynamics.armature != 0.0), "`armature`"),
    ];
    let used: Vec<&str> =
        features.into_iter().filter(|(used, _)| *used).map(|(_, what)| what).collect();
    if !used.is_empty() {
        notes.push(format!(
            "Extensions of URDF, which other software may not read: {}.",
            used.join(", ")
        ));
    }
}

/// Returns the `<collision>` of a shape; `None` if URDF has no words for it.
fn collision(shape: &TouchingShape) -> Option<Element> {
    let element = Element::new("collision").with("name", &*shape.name);
    Some(element.maybe(origin(&shape.end.pose)).child(shapes::urdf_geometry(shape)?))
}

/// Returns the friction of links by Gazebo's extension, where all shapes of a link have the same.
fn frictions(model: &Model) -> Vec<Element> {
    let mut elements = Vec::new();
    for (index, frame) in model.links().iter().enumerate() {
        let on_frame = |shape: &&TouchingShape| shape.end.link == index;
        let shapes = model.soft_constraints().shapes.iter();
        let mut coefficients = shapes.filter(on_frame).map(|shape| shape.surface.friction);
        let Some(first) = coefficients.next() else { continue };
        if first != ContactSurface::<f64>::GROUND.friction && coefficients.all(|next| next == first)
        {
            let coefficient = |name| Element::new(name).numbers("value", &[first]);
            let gazebo = Element::new("gazebo").with("reference", &*frame.name);
            elements.push(gazebo.child(coefficient("mu1")).child(coefficient("mu2")));
        }
    }
    elements
}

/// Returns a note about contacts that have another law than the contacts of a URDF.
fn note_on_laws(model: &Model) -> Option<String> {
    let default = ContactSurface::<f64>::GROUND;
    let shapes = &model.soft_constraints().shapes;
    let friction = |shape: &TouchingShape| {
        let on_link = shapes.iter().filter(|other| other.end.link == shape.end.link);
        let mut coefficients = on_link.map(|other| other.surface.friction);
        coefficients.all(|other| other == shape.surface.friction)
    };
    let is_default = |shape: &&TouchingShape| {
        let ContactSurface { margin, solref, solimp, .. } = shape.surface;
        let is_soft = (margin, solref, solimp) == (default.margin, default.solref, default.solimp);
        is_soft && shape.components == ContactComponents::Sliding && friction(shape)
    };
    let others = shapes.iter().filter(|shape| !is_default(shape));
    let names = listed("shape", others.map(|shape| &*shape.name));
    let is_any = shapes.iter().any(|shape| !is_default(&shape));
    is_any.then(|| {
        format!(
            "The contacts of {names} have MuJoCo's default law, but for the friction of their link."
        )
    })
}

/// Returns a reference to a link.
fn end(element: &'static str, link: &str) -> Element {
    Element::new(element).with("link", link)
}

fn link(name: &str, inertial: &Inertial) -> Element {
    let element = Element::new("link").with("name", name);
    if is_massless(inertial) {
        return element;
    }
    let Inertial { mass, center_of_mass, inertia } = *inertial;
    let at = Pose { translation: center_of_mass, ..Pose::identity() };
    let names = ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"];
    let named = names.into_iter().zip(inertia);
    let moments = named
        .fold(Element::new("inertia"), |element, (name, moment)| element.numbers(name, &[moment]));
    element.child(
        Element::new("inertial")
            .maybe(origin(&at))
            .child(Element::new("mass").numbers("value", &[mass]))
            .child(moments),
    )
}

fn joint(model: &Model, joint: &Joint, parent: &str, child: &str) -> Element {
    let element =
        Element::new("joint").with("name", &*joint.name).with("type", joint.joint_type.name());
    let has_axis = !matches!(joint.joint_type, JointType::Spherical | JointType::Floating);
    let axis = has_axis.then(|| Element::new("axis").numbers("xyz", &joint.axis));
    let second = (joint.joint_type == JointType::Universal)
        .then(|| Element::new("axis2").numbers("xyz", &joint.second_axis));
    let mimic = joint.mimic.map(|mimic| {
        Element::new("mimic")
            .with("joint", &*model.moving_links()[mimic.leader].joint.name)
            .numbers("multiplier", &[mimic.multiplier])
            .numbers("offset", &[mimic.offset])
    });
    element
        .maybe(origin(&joint.origin))
        .child(end("parent", parent))
        .child(end("child", child))
        .maybe(axis)
        .maybe(second)
        .maybe(limit(joint))
        .maybe(dynamics(joint))
        .maybe(mimic)
}

/// Returns the limits of a joint. URDF requires all of them for revolute and prismatic joints.
fn limit(joint: &Joint) -> Option<Element> {
    let limits = joint.limits;
    let is_bounded = matches!(joint.joint_type, JointType::Revolute | JointType::Prismatic);
    if limits.is_none() && !is_bounded {
        return None;
    }
    let mut element = Element::new("limit");
    if is_bounded {
        let [lower, upper] = range(limits.as_ref()).unwrap_or([-UNLIMITED, UNLIMITED]);
        element = element.numbers("lower", &[lower]).numbers("upper", &[upper]);
    }
    let number = |limit: Option<f64>| [limit.unwrap_or(UNLIMITED)];
    let effort = number(limits.and_then(|limits| limits.effort));
    let velocity = number(limits.and_then(|limits| limits.velocity));
    Some(element.numbers("effort", &effort).numbers("velocity", &velocity))
}

/// Returns the forces of a joint by itself.
fn dynamics(joint: &Joint) -> Option<Element> {
    let JointDynamics { armature, damping, friction } = joint.dynamics;
    let forces = [("damping", damping), ("friction", friction), ("armature", armature)];
    let nonzero = forces.into_iter().filter(|(_, number)| *number != 0.0);
    let mut acting = nonzero.peekable();
    acting.peek()?;
    Some(acting.fold(Element::new("dynamics"), |element, (name, x)| element.numbers(name, &[x])))
}

/// Returns the element with the attributes of a pose.
fn placed(element: Element, pose: &Pose<f64>) -> Element {
    let element = element.numbers("xyz", &pose.translation);
    element.numbers("rpy", &angles(&pose.rotation))
}

/// Returns the `<origin>` of a pose; `None` for the identity.
fn origin(pose: &Pose<f64>) -> Option<Element> {
    (*pose != Pose::identity()).then(|| placed(Element::new("origin"), pose))
}

/// Returns roll, pitch and yaw of a rotation Rz(yaw) Ry(pitch) Rx(roll), precise also where roll
/// and yaw have the same effect.
fn angles(rotation: &[[f64; 3]; 3]) -> [f64; 3] {
    let [[xx, xy, xz], [yx, yy, yz], [zx, _, _]] = *rotation;
    let yaw = if xx == 0.0 && yx == 0.0 { 0.0 } else { libm::atan2(yx, xx) };
    let sin = libm::sin(yaw);
    let cos = libm::cos(yaw);
    // What is left after the yaw: an error of the yaw becomes one of the roll, with the same
    // product.
    let pitch = libm::atan2(-zx, cos * xx + sin * yx);
    let roll = libm::atan2(sin * xz - cos * yz, cos * yy - sin * xy);
    [roll, pitch, yaw]
}
