//! Warnings of actuators that do not act.

use std::collections::BTreeMap;

use modyn_runtime::model::Transmission;

use super::actuator_law::ActuatorLaw;
use super::item::Item;
use crate::diagnostics::{Code, Place, Report, Subject};

/// The reason why an actuator does not act.
pub enum Inert {
    /// The joint or tendon does not exist.
    Missing,
    /// The kind of its transmission.
    Transmission(&'static str),
}

/// The actuators that do not act, by the message about them.
#[derive(Default)]
pub struct InertActuators {
    kinds: BTreeMap<String, InertKind>,
}

/// The actuators with one message.
struct InertKind {
    places: Vec<Place>,
    help: String,
}

/// The laws by the name of the element.
const LAWS: &[(&str, &str)] = &[
    (
        "orientation",
        "`kp * log(q^-1 * target) - kv * qd` in the axes of the child, where `target` is the \
         rotation that `ctrl` gives",
    ),
    (
        "pid",
        "`gear * (kp * (position - gear * q) + kv * (velocity - gear * qd) + ki * integral + \
         feedforward)`, where the integral is \
         that of the position's error",
    ),
    ("muscle", MUSCLE),
    (
        "dcmotor",
        "that of MuJoCo's motor: by voltage, resistance and back EMF `gear * K / R * (ctrl - K * \
         gear * qd)`, with its further \
         states if it has some",
    ),
    ("plugin", "that of the plugin"),
];

const MUSCLE: &str =
    "that of MuJoCo's muscle by length, velocity and activation; it pulls without control as well";
const OTHER: &str = "that of these types in MuJoCo";

impl InertActuators {
    /// Adds an actuator if it does not act or acts without its delay. Returns whether its law acts.
    pub fn add(
        &mut self,
        item: &Item,
        law: &ActuatorLaw,
        transmission: &Result<Transmission, Inert>,
    ) -> bool {
        let element = item.element();
        let target = law.target.filter(|(attribute, _)| attribute.starts_with("joint"));
        let joint = target.map(|(_, name)| Subject::Joint(item.naming.name(name)));
        let place: Place = (Some(element.at), joint);
        if element.name == "adhesion" {
            let message = "the forces of `<adhesion>` at contacts are not read";
            self.push(place, message.into(), "apply them as external wrenches".into());
            return false;
        }
        if element.name == "plugin" || !law.is_affine() {
            let (name, force) = description(element.name.as_str(), law);
            let message = format!(
                "the law of the actuator ({name}) does not act: the dynamics have the joint force \
                 as an argument"
            );
            let help =
                format!("compute the force, {force}, within `forcerange`, and pass it as `tau`");
            self.push(place, message, help);
            return false;
        }
        if let Err(Inert::Transmission(kind)) = transmission {
            let message = format!(
                "the actuators that move {kind} do not act: the dynamics have the joint forces as \
                 an argument"
            );
            let help = "compute the force by the actuator's law, and pass the joint forces as \
                        `tau`: the force times the derivative of the length of its transmission \
                        with respect to the coordinates";
            self.push(place, message, help.into());
            return false;
        }
        if law.delay > 0.0 {
            let message = "the `delay` of the actuator is not read: it acts at once";
            self.push(
                place,
                message.into(),
                "pass the control of the time before the delay".into(),
            );
        }
        true
    }

    fn push(&mut self, place: Place, message: String, help: String) {
        let new = || InertKind { places: Vec::new(), help };
        self.kinds.entry(message).or_insert_with(new).places.push(place);
    }

    /// Reports each kind once.
    pub fn report(self, report: &mut Report<'_>) {
        for (message, InertKind { mut places, help }) in self.kinds {
            places.sort_by_key(|(at, _)| *at);
            report.warn_once(Code::NotRead, &places, &message, &help);
        }
    }
}

/// Returns the name of a law that does not act, and its joint force in words.
fn description(element: &str, law: &ActuatorLaw) -> (String, &'static str) {
    if element != "general"
        && let Some((_, force)) = LAWS.iter().find(|(known, _)| *known == element)
    {
        return (format!("`<{element}>`"), force);
    }
    let ActuatorLaw { gain_type, bias_type, dynamics_type, .. } = law;
    let force = if [*gain_type, *bias_type].contains(&"muscle") { MUSCLE } else { OTHER };
    let dynamics = match *dynamics_type {
        "none" | "integrator" | "filter" | "filterexact" => String::new(),
        other => format!(", `dyntype=\"{other}\"`"),
    };
    let name = format!(
        "`<{element}>` with `gaintype=\"{gain_type}\"`, `biastype=\"{bias_type}\"`{dynamics}"
    );
    (name, force)
}
