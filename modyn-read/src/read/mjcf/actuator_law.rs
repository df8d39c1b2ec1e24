//! The law of an actuator, from its element and the elements of its classes.
//!
//! In MuJoCo, an element such as `<position>` sets the numbers of a `<general>`, also in a class. So
//! the elements of the classes are applied one after the other, then the actuator's own. An element
//! of another kind than the last one starts with the default law; `<general>` keeps every law.

use super::check::list;
use super::element::Element;
use super::item::Item;
use super::models::Model;

/// The numbers and types of an actuator.
#[derive(Clone)]
pub struct ActuatorLaw<'e> {
    /// The name of the last element that was applied, apart from `<general>`.
    kind: &'e str,
    pub gain_type: &'e str,
    pub bias_type: &'e str,
    pub dynamics_type: &'e str,
    /// The factors of the input: constant, by length, by velocity.
    pub gain: [f64; 3],
    /// The force without input: constant, by length, by velocity. A positive last number of a
    /// position servo is a damping ratio.
    pub bias: [f64; 3],
    /// The time constant of a filter, s.
    pub time_constant: f64,
    /// The gear ratio of a transmission with one degree of freedom.
    pub gear: f64,
    pub control: Range,
    pub force: Range,
    pub activation: Range,
    /// Whether the force follows from the activation after the step.
    pub early: bool,
    /// The part of the range of the joint or tendon that is the range of the control or the
    /// activation; 0 without.
    pub inherited_range: f64,
    pub group: f64,
    /// The delay of the control, s.
    pub delay: f64,
    /// The attribute that names the transmission, and the name; the last of several counts.
    pub target: Option<(&'static str, &'e str)>,
}

/// A range, and whether it limits; `None` as `auto`.
#[derive(Clone, Copy, Default)]
pub struct Range {
    limited: Option<bool>,
    pub bounds: [f64; 2],
}

impl Range {
    /// Returns the range of an item by these attributes.
    pub fn of(item: &Item, limited: &str, range: &str) -> Self {
        let mut new = Self::default();
        item.chain.iter().rev().for_each(|element| new.apply(element, limited, range));
        new
    }

    fn apply(&mut self, element: &Element, limited: &str, range: &str) {
        match element.text(limited) {
            Some("auto") => self.limited = None,
            Some(text) => self.limited = Some(text == "true"),
            None => {}
        }
        overwrite(&mut self.bounds, element, range);
    }

    /// Returns the bounds if they limit.
    pub fn limits(&self, model: &Model) -> Option<[f64; 2]> {
        let [low, high] = self.bounds;
        let limits = self.limited.unwrap_or(model.settings.autolimits && low < high);
        limits.then_some(self.bounds)
    }
}

/// The transmissions by the attributes that name them, in MuJoCo's order.
const TARGETS: [&str; 6] = ["joint", "jointinparent", "tendon", "cranksite", "site", "body"];

impl<'e> ActuatorLaw<'e> {
    /// Returns the law of an actuator.
    pub fn of(item: &Item<'e>) -> Self {
        let mut law = Self {
            kind: "general",
            gain_type: "fixed",
            bias_type: "none",
            dynamics_type: "none",
            gain: [1.0, 0.0, 0.0],
            bias: [0.0; 3],
            time_constant: 1.0,
            gear: 1.0,
            control: Range::default(),
            force: Range::default(),
            activation: Range::default(),
            early: false,
            inherited_range: 0.0,
            group: 0.0,
            delay: 0.0,
            target: None,
        };
        item.chain.iter().rev().for_each(|element| law.apply(element));
        law
    }

    /// Returns whether the force is an affine function of the input, of the length and of its rate,
    /// with an activation that is none, an integral or filtered.
    pub fn is_affine(&self) -> bool {
        ["fixed", "affine"].contains(&self.gain_type)
            && ["none", "affine"].contains(&self.bias_type)
            && ["none", "integrator", "filter", "filterexact"].contains(&self.dynamics_type)
    }

    /// Returns the damping ratio of a servo whose damping follows from it.
    pub fn damping_ratio(&self) -> Option<f64> {
        (self.gain[0] == -self.bias[1] && self.bias[2] > 0.0).then_some(self.bias[2])
    }

    /// Returns the range of the control or the activation that follows from the range of the joint
    /// or tendon, if the actuator is a servo.
    pub fn inheriting(&mut self) -> Option<&mut Range> {
        let is_servo = self.gain_type == "fixed"
            && self.bias_type == "affine"
            && self.gain[0] == -self.bias[1]
            && self.inherited_range > 0.0;
        match self.dynamics_type {
            "none" | "filterexact" if is_servo => Some(&mut self.control),
            "integrator" if is_servo => Some(&mut self.activation),
            _ => None,
        }
    }

    fn apply(&mut self, element: &'e Element) {
        // A damper has the damping of an affine gain.
        let damping = if self.gain_type == "affine" { -self.gain[2] } else { 0.0 };
        if !["general", self.kind].contains(&element.name.as_str()) {
            self.kind = &element.name;
            self.gain = [1.0, 0.0, 0.0];
            self.bias = [0.0; 3];
            self.time_constant = 1.0;
            self.inherited_range = 0.0;
            self.set_types("none", "fixed", "none");
        }
        self.control.apply(element, "ctrllimited", "ctrlrange");
        self.force.apply(element, "forcelimited", "forcerange");
        self.activation.apply(element, "actlimited", "actrange");
        overwrite(std::slice::from_mut(&mut self.gear), element, "gear");
        for (number, name) in [
            (&mut self.group, "group"),
            (&mut self.delay, "delay"),
            (&mut self.inherited_range, "inheritrange"),
        ] {
            overwrite(std::slice::from_mut(number), element, name);
        }
        if let Some(early) = element.text("actearly") {
            self.early = early == "true";
        }
        for name in TARGETS {
            if let Some(target) = element.text(name) {
                self.target = Some((name, target));
            }
        }
        self.apply_kind(element, damping);
    }

    /// Applies the attributes that depend on the name of the element; `damping` is what a damper
    /// has without its own.
    fn apply_kind(&mut self, element: &'e Element, damping: f64) {
        let number = |name: &str| element.text(name).and_then(list)?.first().copied();
        match element.name.as_str() {
            "general" => {
                let types = [
                    (&mut self.gain_type, "gaintype"),
                    (&mut self.bias_type, "biastype"),
                    (&mut self.dynamics_type, "dyntype"),
                ];
                for (kind, name) in types {
                    *kind = element.text(name).unwrap_or(kind);
                }
                overwrite(&mut self.gain, element, "gainprm");
                overwrite(&mut self.bias, element, "biasprm");
                overwrite(std::slice::from_mut(&mut self.time_constant), element, "dynprm");
            }
            "motor" => {
                self.gain[0] = 1.0;
                self.set_types("none", "fixed", "none");
            }
            kind @ ("position" | "intvelocity") => {
                self.gain[0] = number("kp").unwrap_or(self.gain[0]);
                self.bias[1] = -self.gain[0];
                let rate = number("kv").map(|kv| -kv).or(number("dampratio"));
                self.bias[2] = rate.unwrap_or(self.bias[2]);
                let mut filter = self.dynamics_type;
                if let Some(time) = number("timeconst") {
                    self.time_constant = time;
                    filter = if time == 0.0 { "none" } else { "filterexact" };
                }
                let dynamics = if kind == "intvelocity" { "integrator" } else { filter };
                self.set_types(dynamics, "fixed", "affine");
            }
            "velocity" => {
                self.gain[0] = number("kv").unwrap_or(self.gain[0]);
                self.bias = [0.0, 0.0, -self.gain[0]];
                self.set_types("none", "fixed", "affine");
            }
            "damper" => {
                self.gain = [0.0, 0.0, -number("kv").unwrap_or(damping)];
                self.control.limited = Some(true);
                self.set_types("none", "affine", "none");
            }
            "cylinder" => {
                self.time_constant = number("timeconst").unwrap_or(self.time_constant);
                overwrite(&mut self.bias, element, "bias");
                let diameter = number("diameter").filter(|diameter| *diameter >= 0.0);
                let area = diameter.map(|x| core::f64::consts::PI / 4.0 * x * x).or(number("area"));
                self.gain[0] = area.unwrap_or(self.gain[0]);
                self.set_types("filter", "fixed", "affine");
            }
            "muscle" => self.set_types("muscle", "muscle", "muscle"),
            "orientation" => self.set_types("none", "so3", "so3"),
            "pid" => self.set_types("none", "pid", "affine"),
            "dcmotor" => self.set_types("dcmotor", "dcmotor", "dcmotor"),
            "adhesion" => {
                self.gain[0] = number("gain").unwrap_or(self.gain[0]);
                self.set_types("none", "fixed", "none");
            }
            _ => {}
        }
    }

    fn set_types(&mut self, dynamics: &'e str, gain: &'e str, bias: &'e str) {
        self.dynamics_type = dynamics;
        self.gain_type = gain;
        self.bias_type = bias;
    }
}

/// Replaces the first of these numbers by the numbers of an attribute; the others stay.
fn overwrite(numbers: &mut [f64], element: &Element, name: &str) {
    let written = element.text(name).and_then(list).unwrap_or_default();
    for (number, written) in numbers.iter_mut().zip(written) {
        *number = written;
    }
}
