//! The actuators in the output of `modyn inspect`.

use modyn_codegen::diagnostics::sanitize_for_display;
use modyn_runtime::model::{ActivationDynamics, Actuator, AffineLaw, Model, Transmission};
use serde_json::{Value, json};

use crate::command::numbers::four_digits;
use crate::command::table::Table;

/// Returns the actuators as a table.
pub fn table(model: &Model) -> String {
    let mut table = Table::new(&["control", "moves", "force (length x, rate v)"]);
    for actuator in &model.actuation().actuators {
        let name = sanitize_for_display(&actuator.name);
        let gear = match actuator.gear {
            1.0 => String::new(),
            gear => format!("{} ", four_digits(gear)),
        };
        let moved = format!("{gear}{}", sanitize_for_display(target(model, actuator)));
        table.row([name, moved, law(actuator)]);
    }
    table.with_remarks().fitted()
}

/// Returns the actuators as JSON.
pub fn json(model: &Model) -> Value {
    let law = |AffineLaw { constant, length, velocity }| [constant, length, velocity];
    let actuators = model.actuation().actuators.iter().map(|actuator| {
        let line = actuator.torque_speed_line;
        json!({
            "name": actuator.name,
            "moves": target(model, actuator),
            "gear": actuator.gear,
            "gain": law(actuator.gain),
            "bias": law(actuator.bias),
            "control_range": actuator.control_range,
            "stall_force": line.map(|line| line.stall_force),
            "no_load_speed": line.map(|line| line.no_load_speed),
            "force_range": actuator.force_range,
            "delay": actuator.delay,
            "activation": activation(actuator),
        })
    });
    actuators.collect()
}

/// Returns the name of the joint or the tendon that an actuator moves.
fn target<'m>(model: &'m Model, actuator: &Actuator) -> &'m str {
    match actuator.transmission {
        Transmission::Joint(link) => &model.moving_links()[link].joint.name,
        Transmission::Tendon(tendon) => &model.actuation().tendons[tendon].name,
    }
}

/// Returns the name of an actuator's activation dynamics.
fn activation(actuator: &Actuator) -> Option<&'static str> {
    actuator.activation.map(|activation| match activation.dynamics {
        ActivationDynamics::Integrator => "integrator",
        ActivationDynamics::Filter(_) => "filter",
        ActivationDynamics::ExactFilter(_) => "filterexact",
    })
}

/// Returns the force of an actuator in words.
fn law(actuator: &Actuator) -> String {
    if !actuator.enabled {
        return "disabled".into();
    }
    let input = if actuator.activation.is_some() { "act" } else { "ctrl" };
    let gain = match &*sum(actuator.gain) {
        "1" => input.into(),
        gain if gain.contains(' ') => format!("({gain}) {input}"),
        gain => format!("{gain} {input}"),
    };
    let mut law = match &*sum(actuator.bias) {
        "0" => gain,
        bias => match bias.strip_prefix('-') {
            Some(rest) => format!("{gain} - {rest}"),
            None => format!("{gain} + {bias}"),
        },
    };
    if let Some(kind) = activation(actuator) {
        law += &format!("; act by `{kind}`");
    }
    let ranges = [("ctrl", actuator.control_range), ("within", actuator.force_range)];
    for (name, range) in ranges {
        if let Some([low, high]) = range.map(|range| range.map(four_digits)) {
            law += &format!("; {name} {low} to {high}");
        }
    }
    if let Some(line) = actuator.torque_speed_line {
        let [stall, speed] = [line.stall_force, line.no_load_speed].map(four_digits);
        law += &format!("; at most {stall} (1 - v / {speed})");
    }
    match actuator.delay {
        0 => law,
        1 => law + "; 1 step late",
        steps => law + &format!("; {steps} steps late"),
    }
}

/// Returns an affine law of the length x and the rate v.
fn sum(AffineLaw { constant, length, velocity }: AffineLaw) -> String {
    let mut text = String::new();
    for (factor, quantity) in [(constant, ""), (length, " x"), (velocity, " v")] {
        if factor != 0.0 {
            text += match (text.is_empty(), factor < 0.0) {
                (true, false) => "",
                (true, true) => "-",
                (false, false) => " + ",
                (false, true) => " - ",
            };
            text += &format!("{}{quantity}", four_digits(factor.abs()));
        }
    }
    if text.is_empty() { "0".into() } else { text }
}
