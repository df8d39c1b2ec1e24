//! The type of what is known at run time only.

use std::fmt::Write as _;

use modyn_runtime::model::Inertial;

use super::{Robot, docs};
use crate::names;

impl Robot<'_> {
    /// The names of the fields for payloads, and what they are called in the description.
    fn payload_fields(&self) -> Vec<(String, &str)> {
        let links = self.link_names();
        let names: Vec<&str> =
            self.plan.parameters.payload.iter().map(|payload| links[payload.frame]).collect();
        names::fields(&names, &["gravity"]).into_iter().zip(names).collect()
    }

    /// The structure of the parameters, without its functions; nothing if there are none.
    pub(super) fn parameters_type(&self, text: &mut String) {
        let parameters = &self.plan.parameters;
        if parameters.is_empty() {
            return;
        }
        let (name, vis) = (self.name, &self.options.visibility);
        let _ = writeln!(
            text,
            "/// What of [`{name}`] can be changed at run time; by default as in the description.\n\
             #[allow(dead_code)]\n\
             #[derive(Clone, Copy, Debug, PartialEq)]\n\
             {vis} struct {name}Params {{"
        );
        if parameters.gravity {
            let _ = writeln!(
                text,
                "    /// The acceleration of free fall in world axes, m/s^2.\n    pub gravity: [f64; 3],"
            );
        }
        for (field, link) in self.payload_fields() {
            let _ = writeln!(
                text,
                "    /// The inertia of link {} alone, in its own frame.\n    pub {field}: {}::Payload,",
                docs::code(link),
                self.options.krate,
            );
        }
        text.push_str("}\n\n");
    }

    /// Its functions.
    pub(super) fn parameters(&self, text: &mut String) {
        let parameters = &self.plan.parameters;
        if parameters.is_empty() {
            return;
        }
        let name = self.name;
        let (mut defaults, mut lets) = (String::new(), String::new());
        let mut numbers: Vec<String> = Vec::new();
        if parameters.gravity {
            let _ = write!(defaults, "gravity: {:?}, ", self.model.gravity());
            lets += "    let [gx, gy, gz] = self.gravity;\n";
            numbers.extend(["gx", "gy", "gz"].map(String::from));
        }
        for (k, ((field, _), payload)) in
            self.payload_fields().iter().zip(&parameters.payload).enumerate()
        {
            let Inertial { mass, center_of_mass, inertia } = payload.described;
            let _ = write!(
                defaults,
                "{field}: __modyn::Payload::as_described(__modyn::Inertial {{ mass: {mass:?}, \
                 center_of_mass: {center_of_mass:?}, inertia: {inertia:?} }}), "
            );
            let names: Vec<String> = (0..10).map(|i| format!("p{k}_{i}")).collect();
            let _ = writeln!(
                lets,
                "    let __modyn::Inertial {{ mass: {}, center_of_mass: [{}], inertia: [{}] }} = self.{field}.inertial();",
                names[0],
                names[1..4].join(", "),
                names[4..].join(", "),
            );
            numbers.extend(names);
        }
        let numbers: Vec<String> = numbers.iter().map(|n| format!("T::from_f64({n})")).collect();
        let _ = writeln!(
            text,
            "impl {name}Params {{\n\
             /// As in the description.\n\
             pub const DEFAULT: Self = Self {{ {defaults}}};\n\
             fn numbers<T: __modyn::Scalar>(&self) -> [T; {}] {{\n{lets}    [{}]\n}}\n}}\n\
             impl ::core::default::Default for {name}Params {{\n\
             fn default() -> Self {{\n    Self::DEFAULT\n}}\n}}\n",
            numbers.len(),
            numbers.join(", "),
        );
    }
}
