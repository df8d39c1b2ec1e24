//! The type's own functions, which call the private functions.

use std::fmt::Write as _;

use super::Robot;
use super::parameter::Parameter;
use super::quantity::Quantity;
use super::shape::Shape;
use crate::plan::Kernels;

impl Robot<'_> {
    /// Returns the body of a public function: a call of the private function, or one for each link.
    pub(super) fn call(&self, quantity: &Quantity<'_>, params: &str) -> String {
        let name = quantity.name;
        if quantity.takes_source {
            return format!(
                "let mut uniform = uniform;\n    {name}(&::core::array::from_fn(|_| uniform()))"
            );
        }
        let argument = |parameter: &Parameter| match &parameter.shape {
            shape if parameter.is_contacts() && shape.is_empty() => "&[]".into(),
            _ if parameter.is_contacts() => format!("&{}.numbers()", parameter.name),
            Shape::Scalar => format!("&{}", parameter.name),
            _ => parameter.name.into(),
        };
        let mut arguments: Vec<String> = quantity.parameters.iter().map(argument).collect();
        if quantity.runtime_parameter().is_some() {
            arguments.push(params.into());
        }
        let arguments = arguments.join(", ");
        match quantity.kernels {
            Kernels::Straight { .. } | Kernels::Poses { .. } => {
                format!("{name}({arguments})")
            }
            Kernels::ByLink(_) if self.code.is_some() => format!("{name}({arguments}, link)"),
            Kernels::ByLink(_) => {
                let arms: Vec<String> = self
                    .link_variants()
                    .iter()
                    .enumerate()
                    .map(|(i, link)| {
                        let call = self.link_call(name, i, &arguments);
                        format!("{}Link::{link} => {call},\n", self.name)
                    })
                    .collect();
                format!("match link {{\n{}    }}", arms.concat())
            }
        }
    }

    /// Returns the parameters of a public function over scalar `t`, after `first`.
    pub(super) fn typed(&self, quantity: &Quantity<'_>, first: Option<String>, t: &str) -> String {
        if quantity.takes_source {
            return format!("uniform: impl ::core::ops::FnMut() -> {t}");
        }
        let signature = quantity.parameters.iter().map(|parameter| match parameter.shape {
            _ if parameter.is_contacts() => format!("{}: {}", parameter.name, self.contacts_type()),
            Shape::Scalar => format!("{}: {t}", parameter.name),
            _ => parameter.typed(t),
        });
        let link = matches!(quantity.kernels, Kernels::ByLink(_))
            .then(|| format!("link: {}Link", self.name));
        first.into_iter().chain(signature).chain(link).collect::<Vec<_>>().join(", ")
    }

    /// Returns the run-time parameters of the description.
    pub(super) fn default_parameters(&self) -> String {
        format!("&{}Params::DEFAULT.numbers", self.name)
    }

    /// Prints the type's own functions.
    pub(super) fn own_functions(&self, text: &mut String, quantities: &[Quantity<'_>]) {
        let name = self.name;
        let float = self.options.scalar.name();
        let _ = writeln!(text, "impl {name} {{");
        for quantity in quantities {
            let function = quantity.name;
            let lines: Vec<String> =
                quantity.docs.lines().map(|line| format!("/// {line}\n")).collect();
            let docs = lines.concat();
            let returned = quantity.shape.type_of(float);
            let _ = writeln!(
                text,
                "{docs}#[must_use]\npub fn {function}({}) -> {returned} {{\n    {}\n}}",
                self.typed(quantity, None, float),
                self.call(quantity, &self.default_parameters()),
            );
            self.function_of_numbers(text, quantity);
            if quantity.runtime_parameter().is_some() {
                let params = format!("params: &{name}Params");
                let _ = writeln!(
                    text,
                    "{docs}///\n/// The robot has the run-time parameters `params`.\n#[must_use]\n\
                     pub fn {function}_with({}) -> {returned} {{\n    {}\n}}",
                    self.typed(quantity, Some(params), float),
                    self.call(quantity, "&params.numbers"),
                );
            }
        }
        let _ = writeln!(
            text,
            "/// Checks that the quaternions of spherical and floating joints in `q` have length \
             1, to half of the scalar's\n\
             /// digits. No other function checks them, and accelerations are wrong with other lengths.\n///\n\
             /// # Errors\n///\n/// Names the first joint whose quaternion does not have length 1.\n\
             pub fn check_configuration(q: &[{float}; {nq}]) -> \
             ::core::result::Result<(), __modyn::ConfigurationError<{float}>> {{\n    \
             __modyn::configuration::check(Self::QUATERNIONS.iter().copied(), q)\n}}",
            nq = self.model.nq(),
        );
        text.push_str("}\n\n");
    }
}
