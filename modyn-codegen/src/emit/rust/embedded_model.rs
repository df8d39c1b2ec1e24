//! The description of a robot as a function of its type, for the option `embed_model`.
//!
//! The text is an expression that makes the model. The runtime's types print themselves (`Debug`)
//! as Rust writes their values, with names that the function imports; texts and infinite limits are
//! the exceptions.

use std::fmt::Write as _;

use modyn_runtime::model::{
    Actuation, ContactShape, JointSum, Limits, Model, MovingLink, SoftConstraints, Spring,
};

use super::Robot;

/// The names in the values of a model.
const IMPORTS: &str = "\
use ::core::option::Option::{None, Some};
    use __modyn::joint::JointType;
    use __modyn::model::{
        Contact, ContactKind, Joint, JointDynamics, JointFriction, Limits, Link, LoopConstraint,
        LoopConstraintEnd, LoopConstraintKind, Mimic, Model, MovingLink,
    };
    use __modyn::{Inertial, Pose};";

impl Robot<'_> {
    /// Prints the implementation of `EmbeddedModel`.
    pub(super) fn embedded_model(&self, text: &mut String) {
        let model = self.model;
        let moving_links = list(model.moving_links().iter().map(moving_link));
        let links = list(model.links().iter().map(|link| {
            format!(
                "Link {{ name: {:?}.into(), moving_link: {:?}, pose: {:?}, inertial: {:?} }}",
                link.name, link.moving_link, link.pose, link.inertial
            )
        }));
        let loops = list(model.loop_constraints().iter().map(|constraint| {
            format!(
                "LoopConstraint {{ name: {:?}.into(), kind: LoopConstraintKind::{:?}, ends: {:?} }}",
                constraint.name, constraint.kind, constraint.ends
            )
        }));
        // Robots without springs and gravity compensation need no lines for them.
        let mut passive = String::new();
        if !model.springs().is_empty() {
            let springs =
                list(model.springs().iter().map(|Spring { link, stiffness, reference }| {
                    format!(
                        "__modyn::model::Spring {{ link: {link}, stiffness: {stiffness:?}, \
                     reference: [{}].into() }}",
                        numbers(reference)
                    )
                }));
            let _ = write!(
                passive,
                "let springs: [__modyn::model::Spring; {}] = {springs};\n    \
                 let model = model.and_then(|model| model.with_springs(springs.into()));\n    ",
                model.springs().len()
            );
        }
        if !model.gravity_compensation().is_empty() {
            let _ = write!(
                passive,
                "let factors = [{}];\n    \
                 let model = model.and_then(|model| model.with_gravity_compensation(factors.into()));\n    ",
                numbers(model.gravity_compensation())
            );
        }
        let soft = soft_constraints(model);
        let actuation = actuation(model);
        let contacts = list(model.contacts().iter().map(|contact| {
            format!(
                "Contact {{ name: {:?}.into(), kind: ContactKind::{:?}, end: {:?} }}",
                contact.name, contact.kind, contact.end
            )
        }));
        let entries = model.keyframes().iter().map(|keyframe| {
            format!(
                "__modyn::model::Keyframe {{ name: {:?}.into(), q: {:?}.into(), qd: {:?}.into(), \
                 ctrl: {:?}.into(), act: {:?}.into() }}",
                keyframe.name, keyframe.q, keyframe.qd, keyframe.ctrl, keyframe.act
            )
        });
        let keyframes = match list(entries).as_str() {
            "[]" => String::new(),
            list => format!(".and_then(|model| model.with_keyframes({list}.into()))\n        "),
        };
        let _ = writeln!(
            text,
            "impl __modyn::EmbeddedModel for {} {{\nfn model() -> __modyn::model::Model {{\n    {IMPORTS}\n    \
             let moving_links: [MovingLink; {}] = {moving_links};\n    \
             let links: [Link; {}] = {links};\n    \
             let loops: [LoopConstraint; {}] = {loops};\n    let contacts: [Contact; {}] = {contacts};\n    \
             let model = Model::new({:?}, {:?}, moving_links.into(), links.into());\n    \
             let model = model.and_then(|model| model.with_joint_friction(JointFriction::{:?}));\n    \
             {passive}let model = model.and_then(|model| model.with_loop_constraints(loops.into()));\n    \
             model\n        .and_then(|model| model.with_contacts(contacts.into()))\n        \
             {soft}{actuation}{keyframes}\
             .expect(\"the model was valid when this was compiled\")\n}}\n}}\n",
            self.name,
            model.moving_links().len(),
            model.links().len(),
            model.loop_constraints().len(),
            model.contacts().len(),
            model.name(),
            model.gravity(),
            model.joint_friction(),
        );
    }
}

/// Returns the call that gives the robot what its steps with soft constraints have; empty for the
/// default.
fn soft_constraints(model: &Model) -> String {
    let soft = model.soft_constraints();
    if *soft == SoftConstraints::default() {
        return String::new();
    }
    let shapes = list(soft.shapes.iter().map(|shape| {
        let kind = match &shape.shape {
            ContactShape::Points(points) => format!("Points({points:?}.into())"),
            shape => format!("{shape:?}"),
        };
        format!(
            "TouchingShape {{ name: {:?}.into(), end: {:?}, shape: ContactShape::{kind}, \
             components: ContactComponents::{:?}, surface: {:?}, power: {} }}",
            shape.name, shape.end, shape.components, shape.surface, shape.power
        )
    }));
    let joints = list(soft.joints.iter().map(|joint| format!("{joint:?}")));
    let loops = list(soft.loops.iter().map(|softness| format!("{softness:?}")));
    let tendons = list(soft.tendons.iter().map(|tendon| {
        format!(
            "SoftTendon {{ name: {:?}.into(), length: {}, range: {:?}, margin: {:?}, limit: {:?}, \
             dry_friction: {:?}, friction: {:?}, spring: {:?} }}",
            tendon.name,
            joint_sum(&tendon.length),
            tendon.range,
            tendon.margin,
            tendon.limit,
            tendon.dry_friction,
            tendon.friction,
            tendon.spring,
        )
    }));
    let couplings = list(soft.couplings.iter().map(|coupling| {
        let [first, second] = coupling.sums.each_ref().map(joint_sum);
        format!(
            "SoftCoupling {{ name: {:?}.into(), sums: [{first}, {second}], polynomial: {:?}, \
             softness: {:?} }}",
            coupling.name, coupling.polynomial, coupling.softness,
        )
    }));
    let references = &soft.references;
    format!(
        ".and_then(|model| {{\n            use __modyn::ContactSurface;\n            use __modyn::model::{{Cone, \
         ContactComponents, ContactShape, Impedance, JointReference, JointSoftness, JointSum, \
         LoopSoftness, Integrator, SoftConstraints, SoftCoupling, SoftTendon, Softness, TendonJoint, TendonSpring, \
         TouchingShape}};\n            \
         model.with_soft_constraints(SoftConstraints {{ cone: Cone::{:?}, integrator: Integrator::{:?}, \
         time_step: {:?}, impratio: {:?}, \
         shapes: {shapes}.into(), ground: {:?}, joints: {joints}.into(), loops: {loops}.into(), \
         tendons: {tendons}.into(), couplings: {couplings}.into(), \
         references: {references:?}.into(), joint_limits: {}, joint_friction: {} }})\n        }})\n        ",
        soft.cone,
        soft.integrator,
        soft.time_step,
        soft.impratio,
        soft.ground,
        soft.joint_limits,
        soft.joint_friction
    )
}

/// Returns a sum of joint coordinates.
fn joint_sum(sum: &JointSum) -> String {
    format!("JointSum {{ joints: {:?}.into(), offset: {:?} }}", sum.joints, sum.offset)
}

/// Returns the call that gives the robot its actuators; empty without actuators.
fn actuation(model: &Model) -> String {
    let Actuation { actuators, tendons, joint_force_ranges } = model.actuation();
    if *model.actuation() == Actuation::default() {
        return String::new();
    }
    let actuators = list(actuators.iter().map(|actuator| {
        format!(
            "Actuator {{ name: {:?}.into(), transmission: Transmission::{:?}, gear: {:?}, gain: {:?}, \
             bias: {:?}, control_range: {}, torque_speed_line: {:?}, force_range: {}, delay: {}, \
             activation: {}, enabled: {:?} }}",
            actuator.name,
            actuator.transmission,
            actuator.gear,
            actuator.gain,
            actuator.bias,
            range(actuator.control_range),
            actuator.torque_speed_line,
            range(actuator.force_range),
            actuator.delay,
            match &actuator.activation {
                None => "None".into(),
                Some(activation) => format!(
                    "Some(Activation {{ dynamics: ActivationDynamics::{:?}, range: {}, early: {:?} }})",
                    activation.dynamics,
                    range(activation.range),
                    activation.early
                ),
            },
            actuator.enabled,
        )
    }));
    let tendons = list(tendons.iter().map(|tendon| {
        format!(
            "FixedTendon {{ name: {:?}.into(), joints: {:?}.into(), offset: {:?}, force_range: {} }}",
            tendon.name,
            tendon.joints,
            tendon.offset,
            range(tendon.force_range)
        )
    }));
    let ranges = list(joint_force_ranges.iter().map(|joint| {
        format!("JointForceRange {{ link: {}, range: {} }}", joint.link, bounds(joint.range))
    }));
    format!(
        ".and_then(|model| {{\n            use __modyn::model::{{Activation, ActivationDynamics, Actuation, \
         Actuator, AffineLaw, FixedTendon, JointForceRange, TendonJoint, TorqueSpeedLine, Transmission}};\n            \
         model.with_actuation(Actuation {{ actuators: {actuators}.into(), tendons: {tendons}.into(), \
         joint_force_ranges: {ranges}.into() }})\n        }})\n        "
    )
}

/// Returns a range, which may be infinite.
fn range(range: Option<[f64; 2]>) -> String {
    range.map_or_else(|| "None".into(), |range| format!("Some({})", bounds(range)))
}

/// Returns the bounds of a range, which may be infinite.
fn bounds(range: [f64; 2]) -> String {
    let [low, high] = range.map(|bound| match bound {
        f64::INFINITY => "f64::INFINITY".into(),
        f64::NEG_INFINITY => "f64::NEG_INFINITY".into(),
        bound => format!("{bound:?}"),
    });
    format!("[{low}, {high}]")
}

/// Returns an array of these values, a line each.
fn list(values: impl Iterator<Item = String>) -> String {
    let lines: String = values.map(|value| format!("\n        {value},")).collect();
    if lines.is_empty() { "[]".into() } else { format!("[{lines}\n    ]") }
}

/// Returns these numbers, separated by commas.
fn numbers(numbers: &[f64]) -> String {
    numbers.iter().map(|number| format!("{number:?}")).collect::<Vec<_>>().join(", ")
}

fn moving_link(link: &MovingLink) -> String {
    let MovingLink { name, parent, joint, inertial } = link;
    let limits = match &joint.limits {
        None => "None".into(),
        Some(Limits { lower, upper, velocity, effort }) => {
            let [lower, upper, velocity, effort] = [lower, upper, velocity, effort].map(limit);
            format!(
                "Some(Limits {{ lower: {lower}, upper: {upper}, velocity: {velocity}, effort: {effort} }})"
            )
        }
    };
    format!(
        "MovingLink {{ name: {name:?}.into(), parent: {parent:?}, joint: Joint {{ name: {:?}.into(), \
         joint_type: JointType::{:?}, axis: {:?}, second_axis: {:?}, origin: {:?}, limits: {limits}, mimic: {:?}, \
         dynamics: {:?} }}, inertial: {inertial:?} }}",
        joint.name,
        joint.joint_type,
        joint.axis,
        joint.second_axis,
        joint.origin,
        joint.mimic,
        joint.dynamics,
    )
}

/// Returns a limit, which may be infinite.
fn limit(limit: &Option<f64>) -> String {
    match limit {
        Some(x) if *x == f64::INFINITY => "Some(f64::INFINITY)".into(),
        Some(x) if *x == f64::NEG_INFINITY => "Some(f64::NEG_INFINITY)".into(),
        other => format!("{other:?}"),
    }
}
