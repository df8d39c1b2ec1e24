//! The actuators of an MJCF.

use modyn_runtime::model::{
    Activation, ActivationDynamics, Actuator, AffineLaw, Model, Transmission,
};

use super::xml::Element;
use crate::description::UNLIMITED;
use crate::diagnostics::listed;

/// The actuators of a robot in an MJCF.
pub struct WrittenActuators {
    /// The element `<actuator>`.
    pub section: Element,
    /// A sentence about each kind of actuator, and each part of one, that is left out.
    pub notes: Vec<String>,
}

/// Returns the actuators of a robot.
pub fn of_mjcf(model: &Model) -> WrittenActuators {
    let mut section = Element::new("actuator");
    let mut left_out = Vec::new();
    for actuator in &model.actuation().actuators {
        match element(model, actuator) {
            Some(element) => section.children.push(element),
            None => left_out.push(actuator.name.as_str()),
        }
    }
    let actuators = || model.actuation().actuators.iter();
    let names = |has: fn(&Actuator) -> bool| -> Vec<&str> {
        let such = actuators().filter(|actuator| has(actuator));
        let names = such.map(|actuator| actuator.name.as_str());
        names.filter(|name| !left_out.contains(name)).collect()
    };
    let lines = names(|actuator| actuator.torque_speed_line.is_some());
    let delays = names(|actuator| actuator.delay > 0);
    let listed = |names: Vec<&str>| listed("actuator", names.into_iter());
    let mut notes = Vec::new();
    if !left_out.is_empty() {
        notes.push(format!("Left out: {}.", listed(left_out.clone())));
    }
    if !lines.is_empty() {
        notes.push(format!("The torque-speed line is left out for {}.", listed(lines)));
    }
    if !delays.is_empty() {
        notes.push(format!(
            "The delay in steps is left out for {}: MuJoCo's delay is a time.",
            listed(delays)
        ));
    }
    WrittenActuators { section, notes }
}

/// Returns the element of an actuator, without its torque-speed line and its delay; `None` for an
/// actuator that is disabled or moves a tendon, and for a damping that MuJoCo takes for a damping
/// ratio.
fn element(model: &Model, actuator: &Actuator) -> Option<Element> {
    let Transmission::Joint(link) = actuator.transmission else { return None };
    let AffineLaw { length: slope, velocity: rate, .. } = actuator.bias;
    let is_ratio = actuator.gain.constant == -slope && rate > 0.0;
    if !actuator.enabled || is_ratio {
        return None;
    }
    let joint = &*model.moving_links()[link].joint.name;
    let lawful =
        law(actuator, |kind| Element::new(kind).with("name", &*actuator.name).with("joint", joint));
    let geared = match actuator.gear {
        1.0 => lawful,
        gear => lawful.numbers("gear", &[gear]),
    };
    let ranges = [("ctrlrange", actuator.control_range), ("forcerange", actuator.force_range)];
    let activation_range = actuator.activation.and_then(|activation| activation.range);
    let written = ranges.into_iter().chain([("actrange", activation_range)]);
    let with_ranges = written.fold(geared, |element, (name, range)| match range {
        Some(range) => element.numbers(name, &range.map(|end| end.clamp(-UNLIMITED, UNLIMITED))),
        None => element,
    });
    Some(with_ranges)
}

/// Returns the element with the attributes of the law, which `new` makes of its kind.
fn law(actuator: &Actuator, new: impl Fn(&'static str) -> Element) -> Element {
    let numbers = |law: AffineLaw| [law.constant, law.length, law.velocity];
    let [gain, bias] = [actuator.gain, actuator.bias].map(numbers);
    match (actuator.activation, gain, bias) {
        (None, [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]) => new("motor"),
        (None, [kp, 0.0, 0.0], [0.0, length, rate]) if length == -kp && kp != 0.0 => {
            let servo = new("position").numbers("kp", &[kp]);
            if rate == 0.0 { servo } else { servo.numbers("kv", &[-rate]) }
        }
        (None, [kv, 0.0, 0.0], [0.0, 0.0, rate]) if rate == -kv => {
            new("velocity").numbers("kv", &[kv])
        }
        (activation, gain, bias) => {
            let general = new("general")
                .with("gaintype", "affine")
                .numbers("gainprm", &gain)
                .with("biastype", "affine")
                .numbers("biasprm", &bias);
            match activation {
                Some(activation) => with_activation(general, activation),
                None => general,
            }
        }
    }
}

/// Returns the element with the attributes of an activation.
fn with_activation(element: Element, activation: Activation) -> Element {
    let (kind, time) = match activation.dynamics {
        ActivationDynamics::Integrator => ("integrator", None),
        ActivationDynamics::Filter(time) => ("filter", Some(time)),
        ActivationDynamics::ExactFilter(time) => ("filterexact", Some(time)),
    };
    let typed = element.with("dyntype", kind);
    let timed = match time {
        Some(time) => typed.numbers("dynprm", &[time]),
        None => typed,
    };
    if activation.early { timed.with("actearly", "true") } else { timed }
}

/// Returns whether the actuators of a joint have at most this sum of forces.
pub fn are_within(model: &Model, link: usize, effort: f64) -> bool {
    let actuators = model.actuation().actuators.iter();
    let of_joint = actuators
        .filter(|one| one.enabled && one.transmission == Transmission::Joint(link))
        .map(|actuator| actuator.gear.abs() * largest_force(actuator));
    of_joint.sum::<f64>() <= effort
}

/// Returns the largest force of an actuator by its ranges.
fn largest_force(actuator: &Actuator) -> f64 {
    let constant = AffineLaw { constant: actuator.gain.constant, ..AffineLaw::default() };
    let is_motor = actuator.activation.is_none()
        && actuator.bias == AffineLaw::default()
        && actuator.gain == constant;
    let factor = if is_motor { constant.constant.abs() } else { f64::INFINITY };
    let largest = |range: Option<[f64; 2]>| {
        range.map_or(f64::INFINITY, |[low, high]| high.abs().max(low.abs()))
    };
    largest(actuator.force_range).min(factor * largest(actuator.control_range))
}
