//! Actuators: the limits of their forces, and the laws by which their forces depend on the state,
//! which do not act.

use std::collections::BTreeMap;

use modyn_runtime::model::Limits;

use super::bodies::Bodies;
use super::check::list;
use super::item::Item;
use super::joints::is_limited;
use crate::description::MAX_NUMBER;
use crate::diagnostics::{Code, Place, Subject};

/// The actuators with one law.
struct LawOfActuators {
    places: Vec<Place>,
    /// The joint force in words.
    force: &'static str,
}

/// A law of an actuator's force that depends on the state or on an activation.
struct Law {
    /// The name of the element, with the types of a `<general>`.
    name: String,
    /// The joint force in words.
    force: &'static str,
}

/// The laws by the name of the element. A motor has none: its control is the joint force.
const LAWS: &[(&str, &str)] = &[
    (
        "position",
        "`gear * (kp * (ctrl - gear * q) - kv * gear * qd)`; `kv` follows from `dampratio` if the \
         actuator has that, and \
         `timeconst` delays `ctrl`",
    ),
    ("velocity", "`gear * kv * (ctrl - gear * qd)`"),
    (
        "intvelocity",
        "`gear * (kp * (act - gear * q) - kv * gear * qd)`, where `act` is the integral of `ctrl` \
         over time",
    ),
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
    ("damper", "`-kv * gear * gear * qd * ctrl`"),
    (
        "cylinder",
        "`gear * (area * act + bias[0] + bias[1] * gear * q + bias[2] * gear * qd)`, where the \
         pressure `act` follows `ctrl` with \
         the time constant `timeconst`",
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
const AFFINE_GAIN: &str = "`gear * ((gainprm[0] + gainprm[1] * gear * q + gainprm[2] * gear * qd) \
                           * ctrl + bias)`, where `bias` is \
                           `biasprm[0] + biasprm[1] * gear * q + biasprm[2] * gear * qd` if \
                           `biastype` is `affine`, else 0";
const AFFINE_BIAS: &str =
    "`gear * (gainprm[0] * ctrl + biasprm[0] + biasprm[1] * gear * q + biasprm[2] * gear * qd)`";
const OTHER: &str = "that of these types in MuJoCo";

impl<'e> Bodies<'e, '_, '_> {
    /// Sets the effort limits of joints whose actuators have a limited force, and warns of the laws
    /// that do not act.
    pub fn actuators(&mut self) {
        if !self.models[0].settings.flags.actuation {
            return;
        }
        let mut laws: BTreeMap<String, LawOfActuators> = BTreeMap::new();
        let mut on_contacts: Vec<Place> = Vec::new();
        // For each joint, the sum of its actuators' largest forces; `None` if one has no limit.
        let mut efforts = vec![Some(0.0); self.description.joints.len()];
        let joints = self.description.joints_by_name();
        for item in self.of_section("actuator") {
            let element = item.element();
            let attribute = element.attribute("joint").or(element.attribute("jointinparent"));
            let joint = attribute.map(|joint| item.naming.name(&joint.value));
            let place: Place = (Some(element.at), joint.clone().map(Subject::Joint));
            if element.name == "adhesion" {
                on_contacts.push(place);
            } else if let Some(Law { name, force }) = law(&item) {
                let new = || LawOfActuators { places: Vec::new(), force };
                laws.entry(name).or_insert_with(new).places.push(place);
            }
            if let Some(&index) = joint.and_then(|name| joints.get(name.as_str())) {
                let effort = self.largest_force(&item);
                efforts[index] = efforts[index].zip(effort).map(|(sum, effort)| sum + effort);
            }
        }
        for (joint, effort) in self.description.joints.iter_mut().zip(efforts) {
            let effort = effort.filter(|effort| *effort > 0.0 && *effort < MAX_NUMBER);
            let none = Limits { lower: None, upper: None, velocity: None, effort: None };
            if effort.is_some() && joint.limits.is_none_or(|limits| limits.effort.is_none()) {
                joint.limits = Some(Limits { effort, ..joint.limits.unwrap_or(none) });
            }
        }
        for (name, LawOfActuators { mut places, force }) in laws {
            places.sort_by_key(|(at, _)| *at);
            let message = format!(
                "the law of the actuator ({name}) does not act: the dynamics have the joint force \
                 as an argument"
            );
            let help = format!(
                "compute the force, {force}, within `forcerange`, and pass it as `tau`{}",
                if places.iter().any(|(_, joint)| joint.is_none()) { TRANSMISSION } else { "" }
            );
            self.report.warn_once(Code::NotRead, &places, &message, &help);
        }
        let message = "the forces of `<adhesion>` at contacts are not read";
        let help = "apply them as external wrenches";
        self.report.warn_once(Code::NotRead, &on_contacts, message, help);
    }

    /// Returns the largest force of an actuator on its joint, if it is the same in both directions.
    fn largest_force(&self, item: &Item<'e>) -> Option<f64> {
        let model = &self.models[item.model];
        let first =
            |name| item.text(name).and_then(list).and_then(|numbers| numbers.first().copied());
        let gear = first("gear").unwrap_or(1.0);
        // The force is a multiple of the control.
        let described = match item.element().name.as_str() {
            "motor" => Some(1.0),
            "general" if is_motor(item) => Some(first("gainprm").unwrap_or(1.0)),
            _ => None,
        };
        let gain = described.filter(|_| self.models[0].settings.flags.clamps_controls);
        let ranges =
            [("forcelimited", "forcerange", Some(1.0)), ("ctrllimited", "ctrlrange", gain)];
        let bounds = ranges.into_iter().filter_map(|(limited, range, factor)| {
            let [lower, upper]: [f64; 2] = item.numbers(range)?;
            (is_limited(item, limited, range, model) && -lower == upper && upper > 0.0)
                .then_some(upper * factor?.abs())
        });
        bounds.reduce(f64::min).map(|bound| bound * gear.abs())
    }
}

const TRANSMISSION: &str = "; for an actuator of a tendon, site or crank, `gear * q` is its \
                            length, and the force acts along it";

/// Returns the type of a part of a `<general>`: `dyntype`, `gaintype` or `biastype`.
fn kind<'e>(item: &Item<'e>, part: &str, default: &'static str) -> &'e str {
    item.text(part).unwrap_or(default)
}

/// Returns whether the force of a `<general>` is a multiple of its control, like the force of a
/// `<motor>`, which MuJoCo saves so.
fn is_motor(item: &Item) -> bool {
    let kinds = [("dyntype", "none"), ("gaintype", "fixed"), ("biastype", "none")];
    kinds.into_iter().all(|(part, default)| kind(item, part, default) == default)
}

/// Returns the law of an actuator; `None` if its force is a multiple of its control or of its
/// activation.
fn law(item: &Item) -> Option<Law> {
    let name = item.element().name.as_str();
    if name != "general" {
        let (_, force) = LAWS.iter().find(|(known, _)| *known == name)?;
        return Some(Law { name: format!("`<{name}>`"), force });
    }
    let gain = kind(item, "gaintype", "fixed");
    let bias = kind(item, "biastype", "none");
    let force = match (gain, bias) {
        ("fixed", "none") => return None,
        ("fixed", "affine") => AFFINE_BIAS,
        ("affine", "none" | "affine") => AFFINE_GAIN,
        ("muscle", _) | (_, "muscle") => MUSCLE,
        _ => OTHER,
    };
    let name = format!("`<general>` with `gaintype=\"{gain}\"` and `biastype=\"{bias}\"`");
    Some(Law { name, force })
}
