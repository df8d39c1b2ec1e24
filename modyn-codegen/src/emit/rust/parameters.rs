//! The type of a robot's run-time parameters.

use std::fmt::Write as _;

use super::function::function;
use super::parameter::Parameter;
use super::shape::Shape;
use super::{FloatType, Robot, docs};
use crate::names;

/// An inertia among the parameters.
struct Field {
    /// The name of the method that returns it.
    name: String,
    /// Its description in one sentence.
    docs: String,
    /// The index of the first of its ten numbers.
    at: usize,
}

impl Robot<'_> {
    /// Returns the run-time inertias and the payloads.
    fn inertia_fields(&self) -> Vec<Field> {
        let parameters = &self.plan.parameters;
        let links = self.link_names();
        let with_inertia: Vec<&str> =
            parameters.inertias.iter().map(|(frame, _)| links[*frame]).collect();
        let payloads: Vec<&str> = parameters.payloads.iter().map(|&frame| links[frame]).collect();
        let field = |what: &'static str, docs: &'static str, first: usize, names: &[&str]| {
            let fields = names::fields(names, &[]).into_iter().zip(names).enumerate();
            let field = |(k, (field, link)): (usize, (String, &&str))| Field {
                name: format!("{what}_of_{field}"),
                docs: docs.replace("{}", &docs::code(link)),
                at: parameters.inertial(first + k),
            };
            fields.map(field).collect::<Vec<Field>>()
        };
        let inertias = field(
            "inertia",
            "the inertia of link {} alone, in its own frame; by default the description's.",
            0,
            &with_inertia,
        );
        let first = inertias.len();
        let payloads = field(
            "payload",
            "the inertia that is added to link {}, in the link's frame; by default none.",
            first,
            &payloads,
        );
        inertias.into_iter().chain(payloads).collect()
    }

    /// Prints the structure of the parameters, without its methods; nothing if there are no
    /// parameters.
    pub(super) fn parameters_type(&self, text: &mut String) {
        let count = self.plan.parameters.len();
        if count == 0 {
            return;
        }
        let name = self.name;
        let vis = &self.options.visibility;
        let float = self.options.scalar.name();
        let kind = format!("{name}Params");
        let lint = names::camel_case_lint([&*kind].into_iter());
        let _ = writeln!(
            text,
            "/// The run-time parameters of [`{name}`]; the defaults are the values in the description. The methods\n\
             /// set parameters, and check their arguments.\n\
             #[allow(dead_code)]\n\
             {lint}#[derive(Clone, Copy, Debug, PartialEq)]\n\
             {vis} struct {kind}<T = {float}> {{\n    numbers: [T; {count}],\n}}\n"
        );
    }

    /// Prints the methods of the parameters.
    pub(super) fn parameters(&self, text: &mut String) {
        let parameters = &self.plan.parameters;
        if parameters.is_empty() {
            return;
        }
        let name = self.name;
        let float = self.options.scalar.name();
        let described = parameters.described(self.model.gravity());
        let constants: Vec<String> = match self.options.scalar {
            FloatType::F64 => described.iter().map(|x| format!("{x:?}")).collect(),
            #[allow(clippy::cast_possible_truncation)] // As `from_f64` rounds them.
            FloatType::F32 => described.iter().map(|x| format!("{:?}", *x as f32)).collect(),
        };
        let generic: Vec<String> =
            described.iter().map(|x| format!("T::from_f64({x:?})")).collect();
        let _ = writeln!(
            text,
            "impl {name}Params<{float}> {{\n\
             /// The parameters of the description.\n\
             pub const DEFAULT: Self = Self {{ numbers: [{}] }};\n}}\n\
             impl<T: __modyn::Scalar> ::core::default::Default for {name}Params<T> {{\n\
             fn default() -> Self {{\n    Self {{ numbers: [{}] }}\n}}\n}}\n\
             impl<T> {name}Params<T> {{\n\
             /// Returns the parameters with `f` applied to each number, for example to convert to \
             another scalar. The\n\
             /// results of `f` are not checked.\n\
             #[must_use]\n\
             pub fn map<U>(self, f: impl ::core::ops::FnMut(T) -> U) -> {name}Params<U> {{\n    \
             {name}Params {{ numbers: self.numbers.map(f) }}\n}}\n}}\n",
            constants.join(", "),
            generic.join(", "),
        );
        if parameters.gravity {
            let _ = writeln!(
                text,
                "impl<T: __modyn::Scalar> {name}Params<T> {{\n\
                 /// Returns the acceleration of free fall in world axes, m/s^2.\n\
                 #[must_use]\n\
                 pub fn gravity(&self) -> [T; 3] {{\n    [self.numbers[0], self.numbers[1], self.numbers[2]]\n}}\n\
                 /// Sets the acceleration of free fall in world axes, m/s^2.\n\
                 pub fn set_gravity(&mut self, gravity: [T; 3]) {{\n    \
                 [self.numbers[0], self.numbers[1], self.numbers[2]] = gravity;\n}}\n}}\n"
            );
        }
        self.inertias(text);
    }

    /// Prints the methods of run-time inertias and payloads.
    fn inertias(&self, text: &mut String) {
        let fields = self.inertia_fields();
        if fields.is_empty() {
            return;
        }
        let name = self.name;
        let mut check = "";
        let mut refused = "";
        if let Some((entries, program)) = &self.plan.inertia_pivots {
            let parameters = [
                Parameter::new("epsilon", Shape::vector(1)),
                Parameter::new("params", Shape::vector(self.plan.parameters.len())),
            ];
            let shape = Shape::vector(entries.len());
            let float = self.options.scalar;
            *text += &function("inertia_pivots", &parameters, &shape, program, float);
            let joints: Vec<&str> = entries.iter().map(|&v| self.joint_of(v)).collect();
            let _ = writeln!(
                text,
                "const NEEDY_JOINTS: [&'static str; {}] = {joints:?};\n",
                joints.len()
            );
            check = "    let pivots = |epsilon: T| inertia_pivots(&[epsilon], &numbers);\n    \
                     __modyn::parameters::check_pivots(pivots, &NEEDY_JOINTS)?;\n";
            refused = ", or if a joint would then move no inertia (its acceleration would be\n/// infinite)";
        }
        let _ =
            writeln!(text, "impl<T: __modyn::Scalar + ::core::cmp::PartialOrd> {name}Params<T> {{");
        for Field { name, docs, at } in &fields {
            let _ = writeln!(
                text,
                "/// Returns {docs}\n\
                 #[must_use]\n\
                 pub fn {name}(&self) -> __modyn::Inertial<T> {{\n    \
                 __modyn::parameters::inertial(&self.numbers, {at})\n}}\n\
                 /// Sets {docs}\n///\n/// # Errors\n///\n\
                 /// If no rigid body has this inertia{refused}. After an error nothing has changed.\n\
                 pub fn set_{name}(&mut self, inertial: __modyn::Inertial<T>) \
                 -> ::core::result::Result<(), __modyn::ParameterError<T>> {{\n    \
                 self.set({at}, &inertial)\n}}"
            );
        }
        let _ = writeln!(
            text,
            "fn set(&mut self, at: usize, inertial: &__modyn::Inertial<T>) \
             -> ::core::result::Result<(), __modyn::ParameterError<T>> {{\n    \
             let numbers = __modyn::parameters::with_inertial(&self.numbers, at, inertial)?;\n{check}    \
             self.numbers = numbers;\n    ::core::result::Result::Ok(())\n}}\n}}\n"
        );
    }

    /// Returns the name of the joint that entry `v` of qd belongs to.
    fn joint_of(&self, v: usize) -> &str {
        let is_independent =
            |i: &usize| self.model.mimic(*i).is_none() && self.model.v_range(*i).contains(&v);
        let link = (0..self.model.moving_links().len()).find(is_independent);
        link.map_or("", |link| self.model.moving_links()[link].joint.name.as_str())
    }
}
