//! Joints of bodies.

use modyn_runtime::conventions::quaternion_from_rotation;
use modyn_runtime::joint::JointType;
use modyn_runtime::model::{JointDynamics, Limits};
use modyn_runtime::spatial::Pose;

use super::item::Item;
use super::models::Model;
use super::pose::about;
use super::settings::Flags;
use crate::description::{
    JointRecord, Kind, Located, MAX_NUMBER, SpringRecord, UNLIMITED, normalized,
};
use crate::diagnostics::{Code, Report, Subject};

/// Returns whether a joint is free.
pub fn is_free(joint: &Item) -> bool {
    joint.element().name == "freejoint" || joint.text("type") == Some("free")
}

/// Reports a free joint whose body is not one of the world or has other joints, and a frame that
/// MuJoCo moves.
pub fn check_free(
    joint: &Item,
    name: &str,
    alone: bool,
    is_leaf: bool,
    model: &Model,
    report: &mut Report<'_>,
) {
    let subject = Subject::Joint(name.into());
    let at = joint.element().at;
    if !alone {
        let message = "a free joint must be the only joint of a body of the world";
        let help = "write the body in `<worldbody>`, with this joint only";
        report.error(Code::NotRead, at, Some(&subject), message, help);
    }
    let align = joint.text("align").unwrap_or(if joint.element().name == "joint" {
        "false"
    } else {
        "auto"
    });
    // The frame of a body with children is not aligned.
    if is_leaf && (align == "true" || align == "auto" && model.settings.align_free) {
        let message =
            "its frame would be moved to the principal axes of inertia, which is not read";
        let help = "write `align=\"false\"`: the coordinates are then those of the body's frame, \
                    not of the frame along its \
                    principal axes of inertia";
        report.error(Code::NotRead, at, Some(&subject), message, help);
    }
}

/// The coordinates of a hinge or a slide; zero for other joints.
#[derive(Clone, Copy, Default)]
pub struct References {
    /// In the pose in which the model is drawn.
    pub drawn: f64,
    /// Where a spring of the joint is at rest.
    pub spring: f64,
}

/// Returns a joint without its links and origin, and its coordinates at rest. `pose` is the body's
/// pose.
pub fn joint(
    item: &Item,
    name: &str,
    pose: &Pose<f64>,
    model: &Model,
    report: &mut Report<'_>,
) -> (JointRecord, References) {
    let subject = Subject::Joint(name.into());
    let at = item.element().at;
    let errors = report.errors();
    let kind = if is_free(item) { "free" } else { item.text("type").unwrap_or("hinge") };
    let single = matches!(kind, "hinge" | "slide");
    let angle = if kind == "hinge" { model.settings.angle } else { 1.0 };
    let actuator_forces =
        if single { actuator_forces(item, model, &subject, report) } else { None };
    // The bound of a symmetric range.
    let bound = actuator_forces.filter(|[lower, upper]| -lower == *upper && *upper < MAX_NUMBER);
    let effort = bound.map(|[_, upper]| upper);
    let mut refuse = |code, message: &str, help: &str| {
        report.error(code, at, Some(&subject), message, help);
    };
    let spring_damper = spring_damper(item);
    if spring_damper.is_some_and(|numbers| numbers.iter().any(|&number| number <= 0.0)) {
        let help = "write a time constant, s, and a damping ratio, both above 0; or `0 0` for none";
        refuse(Code::NegativeJointDynamics, "`springdamper` is not positive", help);
    }
    for name in ["damping", "stiffness"] {
        if polynomial(item, name).1 {
            let message = format!("coefficients of higher powers of `{name}` are not read");
            let help = "write the first value alone, and give their torques with the others";
            refuse(Code::NotRead, &message, help);
        }
    }
    let names = ["armature", "damping", "frictionloss", "stiffness"];
    let numbers = names.map(|name| polynomial(item, name).0);
    let [armature, damping, friction, stiffness] = numbers;
    if numbers.iter().any(|&number| number < 0.0) {
        let help = "write numbers of at least 0: damping and friction oppose the motion, and springs pull back";
        let message = "`armature`, `damping`, `frictionloss` or `stiffness` is negative";
        refuse(Code::NegativeJointDynamics, message, help);
    }
    if kind == "free" && friction != 0.0 {
        // MuJoCo's acts along the axes of the world, modyn's along the axes of the body.
        let message = "`frictionloss` of a free joint is not read";
        refuse(Code::NotRead, message, "write 0, or the class that the joint should have");
    }
    let Flags { springs, dampers, friction: rubs, .. } = model.settings.flags;
    let dynamics = JointDynamics {
        armature,
        damping: if dampers { damping } else { 0.0 },
        friction: if rubs { friction } else { 0.0 },
    };
    let has_spring = stiffness > 0.0 || spring_damper.is_some();
    let spring = (has_spring && springs)
        .then(|| SpringRecord { stiffness, reference: spring_reference(item, kind, angle, pose) });
    let direction = item.numbers("axis").unwrap_or([0.0, 0.0, 1.0]);
    let axis =
        if single { normalized(direction).map(|(unit, _)| unit) } else { Some([0.0, 0.0, 1.0]) };
    if axis.is_none() {
        refuse(
            Code::ZeroAxis,
            "the axis is zero",
            "write the direction of the axis, such as `0 0 1`",
        );
    }
    let described =
        item.numbers("range").filter(|_| single && is_limited(item, "limited", "range", model));
    let range = described.map(|range: [f64; 2]| range.map(|bound| angle * bound));
    let joint_type = match kind {
        "slide" => JointType::Prismatic,
        "ball" => JointType::Spherical,
        "free" => JointType::Floating,
        _ if range.is_none() => JointType::Continuous,
        _ => JointType::Revolute,
    };
    if range.is_some_and(|[lower, upper]| lower > upper) {
        let help = "write the lower limit first";
        refuse(Code::InvertedLimits, "the lower limit is above the upper one", help);
    }
    let limits = (range.is_some() || effort.is_some()).then(|| Limits {
        lower: range.map(|[lower, _]| lower).filter(|lower| *lower > -UNLIMITED),
        upper: range.map(|[_, upper]| upper).filter(|upper| *upper < UNLIMITED),
        velocity: None,
        effort,
    });
    let given = axis.unwrap_or([0.0, 0.0, 1.0]);
    let axis = if single { item.frame.rotate(given) } else { given };
    let sound = model.is_sound(&item.chain) && report.errors() == errors;
    let kind = Kind::Moving(joint_type);
    let record = fixed(name.into(), at);
    let references = match single {
        true => References {
            drawn: angle * item.number("ref").unwrap_or(0.0),
            spring: single_reference(item, angle),
        },
        false => References::default(),
    };
    let record = JointRecord { kind, axis, limits, dynamics, spring, sound, ..record };
    (JointRecord { actuator_forces, ..record }, references)
}

/// Returns the time constant, s, and the damping ratio from which stiffness and damping of a joint
/// follow; `None` if they are given as such.
pub fn spring_damper(item: &Item) -> Option<[f64; 2]> {
    item.numbers("springdamper").filter(|numbers| *numbers != [0.0; 2])
}

/// Returns the coordinates of the spring of a joint at rest; `pose` is the body's pose, in which
/// the model is drawn.
fn spring_reference(item: &Item, kind: &str, angle: f64, pose: &Pose<f64>) -> Vec<f64> {
    match kind {
        "ball" => vec![0.0, 0.0, 0.0, 1.0],
        "free" => {
            let rotation = quaternion_from_rotation(pose.rotation);
            [&pose.translation[..], &rotation].concat()
        }
        _ => vec![single_reference(item, angle)],
    }
}

/// Returns the coordinate of the spring of a hinge or a slide at rest.
fn single_reference(item: &Item, angle: f64) -> f64 {
    angle * item.number("springref").unwrap_or(0.0)
}

/// Returns the first coefficient of a polynomial, and whether it has others.
pub fn polynomial(item: &Item, name: &str) -> (f64, bool) {
    let coefficients = item.text(name).and_then(super::check::list).unwrap_or_default();
    let others = coefficients.iter().skip(1).any(|coefficient| *coefficient != 0.0);
    (coefficients.first().copied().unwrap_or(0.0), others)
}

/// Returns whether a range holds: by the attribute `limited`, or if the range is there.
pub fn is_limited(item: &Item, limited: &str, range: &str, model: &Model) -> bool {
    match item.text(limited) {
        Some("true") => true,
        Some("false") => false,
        _ => {
            let range: Option<[f64; 2]> = item.numbers(range);
            model.settings.autolimits && range.is_some_and(|[lower, upper]| lower != upper)
        }
    }
}

/// Returns the range of the sum of actuator forces on a joint, N m or N; `None` without a limit.
fn actuator_forces(
    item: &Item,
    model: &Model,
    subject: &Subject,
    report: &mut Report<'_>,
) -> Option<[f64; 2]> {
    let range: [f64; 2] = item.numbers("actuatorfrcrange")?;
    let limits = is_limited(item, "actuatorfrclimited", "actuatorfrcrange", model);
    if !limits || range == [0.0; 2] || !model.settings.flags.actuation {
        return None;
    }
    let [lower, upper] = range;
    if lower >= upper {
        let message = "its `actuatorfrcrange` is empty";
        let help = "write the lower bound, then the upper bound above it";
        report.error(Code::InvertedLimits, item.element().at, Some(subject), message, help);
        return None;
    }
    Some(range)
}

/// Returns the displacement of a joint by its coordinate.
pub fn displacement(kind: Kind, axis: [f64; 3], coordinate: f64) -> Pose<f64> {
    match kind {
        _ if coordinate == 0.0 => Pose::identity(),
        Kind::Moving(JointType::Prismatic) => {
            Pose { translation: axis.map(|x| coordinate * x), ..Pose::identity() }
        }
        Kind::Moving(JointType::Revolute | JointType::Continuous) => {
            Pose { rotation: about(axis, coordinate), ..Pose::identity() }
        }
        _ => Pose::identity(),
    }
}

/// Returns a fixed joint without its links.
pub fn fixed(name: String, at: usize) -> JointRecord {
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
        spring: None,
        actuator_forces: None,
        dynamics_at: at,
        sound: true,
    }
}
