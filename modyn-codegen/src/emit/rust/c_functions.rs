//! Rust functions that C can call: with pointers to arrays whose sizes are in their types.

use std::fmt::Write as _;

use super::Robot;
use super::quantity::Quantity;
use super::shape::Shape;
use crate::plan::{CForm, Kernels};

impl Robot<'_> {
    /// Prints `extern "C"` functions named `prefix_function`, for all functions that C can call.
    pub(super) fn c_functions(&self, text: &mut String, prefix: &str, quantities: &[Quantity<'_>]) {
        let upper = prefix.to_uppercase();
        let nq = self.model.nq();
        let nv = self.model.nv();
        let name = self.name;
        let links = self.model.links().len();
        let _ = writeln!(
            text,
            "\n/// The length of the coordinate vector.\npub const {upper}_NQ: usize = {nq};\n\
             /// The length of the velocity vector.\npub const {upper}_NV: usize = {nv};\n\
             /// The number of links.\npub const {upper}_LINKS: usize = {links};\n\
             const _: () = assert!({upper}_NQ == {name}::NQ && {upper}_NV == {name}::NV);"
        );
        for quantity in quantities.iter().filter(|quantity| in_c(quantity)) {
            let called = quantity.name;
            match quantity.with_numbers_of_contacts() {
                Some(of_numbers) => {
                    self.c_function(text, prefix, &of_numbers, &name_of_numbers(called));
                }
                None => self.c_function(text, prefix, quantity, called),
            }
        }
    }

    /// Prints the type's own function that a function for C calls, if sets of contacts are numbers
    /// there: a set of booleans has no NaN.
    pub(super) fn function_of_numbers(&self, text: &mut String, quantity: &Quantity<'_>) {
        if self.options.c_prefix.is_none() || !in_c(quantity) {
            return;
        }
        let Some(of_numbers) = quantity.with_numbers_of_contacts() else { return };
        let float = self.options.scalar.name();
        let _ = writeln!(
            text,
            "fn {}({}) -> {} {{\n    {}\n}}",
            name_of_numbers(quantity.name),
            self.typed(&of_numbers, None, float),
            quantity.shape.type_of(float),
            self.call(&of_numbers, &self.default_parameters()),
        );
    }

    /// Prints a function for C that calls the type's own function `called`.
    fn c_function(&self, text: &mut String, prefix: &str, quantity: &Quantity<'_>, called: &str) {
        let name = self.name;
        let float = self.options.scalar.name();
        let function = quantity.name;
        let by_link = matches!(quantity.kernels, Kernels::ByLink(_));
        let scalar = matches!(quantity.shape, Shape::Scalar);
        let mut parameters: Vec<String> = quantity
            .parameters
            .iter()
            .filter(|p| !p.shape.is_empty())
            .map(|p| format!("{}: &[{float}; {}]", p.name, p.shape.len()))
            .collect();
        let mut arguments = Vec::new();
        let mut lets = String::new();
        for parameter in &quantity.parameters {
            if parameter.is_contacts() {
                arguments.push(self.contacts_type());
            } else if parameter.shape.is_empty() {
                arguments.push("&[]".into());
            } else if matches!(parameter.shape, Shape::Scalar) {
                arguments.push(format!("{}[0]", parameter.name));
            } else if parameter.shape.is_vector() {
                arguments.push(parameter.name.to_string());
            } else {
                let names = numbered(parameter.name, parameter.shape.len());
                let _ = writeln!(lets, "let [{}] = *{};", names.join(", "), parameter.name);
                arguments.push(format!("&{}", parameter.shape.value(&names)));
            }
        }
        let mut notes = String::new();
        if by_link {
            parameters.push("link: usize".into());
            arguments.push("link".into());
            notes += "///\n/// `link` is an index in the description's order. Returns false, and \
                      writes nothing, if there is no such link.\n";
        }
        let returned = match (scalar, by_link) {
            (true, _) => format!(" -> {float}"),
            (false, true) => " -> bool".into(),
            (false, false) => String::new(),
        };
        if !scalar {
            parameters.push(format!("out: &mut [{float}; {}]", quantity.shape.len()));
            notes += &format!("///\n/// The layout of `out`: {}.\n", quantity.result.in_words());
        }
        let docs: String = quantity.docs.lines().map(|line| format!("/// {line}\n")).collect();
        let _ = writeln!(
            text,
            "\n{docs}{notes}#[allow(unsafe_code)]\n#[unsafe(no_mangle)]\n\
             pub extern \"C\" fn {prefix}_{function}({}){returned} {{",
            parameters.join(", ")
        );
        if quantity.uses_spatial() {
            let path = &self.options.crate_path;
            let _ = writeln!(text, "#[allow(unused_imports)]\nuse {path} as __modyn;");
        }
        text.push_str(&lets);
        if by_link {
            let _ = writeln!(
                text,
                "let ::core::option::Option::Some(&link) = {name}Link::ALL.get(link) else {{\nreturn false;\n}};"
            );
        }
        let call = format!("{name}::{called}({})", arguments.join(", "));
        if scalar {
            let _ = writeln!(text, "{call}");
        } else if quantity.shape.is_vector() {
            let _ = writeln!(text, "*out = {call};");
        } else {
            let names = numbered("x", quantity.shape.len());
            let _ = writeln!(
                text,
                "let {} = {call};\n*out = [{}];",
                quantity.shape.value(&names),
                names.join(", ")
            );
        }
        text.push_str(if by_link { "true\n}\n" } else { "}\n" });
    }
}

/// Returns the name of the type's own function that takes a number for each contact. Functions of
/// users have no such names.
fn name_of_numbers(function: &str) -> String {
    format!("__{function}")
}

/// Returns whether C can call the function. The results of the others are Rust types.
pub(super) fn in_c(quantity: &Quantity<'_>) -> bool {
    quantity.c_form == CForm::SourceAndExport
}

impl Quantity<'_> {
    /// Returns whether a parameter or the result has a structure of the runtime.
    fn uses_spatial(&self) -> bool {
        let mut shapes = self.parameters.iter().map(|p| &p.shape).chain([&self.shape]);
        shapes.any(Shape::has_runtime_structures)
    }
}

impl Shape {
    /// Returns whether the shape has no scalars: C has no such array.
    pub(super) fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns whether the shape is a structure of the runtime, or contains one.
    fn has_runtime_structures(&self) -> bool {
        match self {
            Self::Scalar => false,
            Self::Array(element, _) => element.has_runtime_structures(),
            Self::Struct { path, fields, .. } => {
                path.starts_with("__modyn")
                    || fields.iter().any(|(_, field)| field.has_runtime_structures())
            }
        }
    }

    /// Returns whether the shape is an array of scalars.
    fn is_vector(&self) -> bool {
        matches!(self, Self::Array(of, _) if matches!(**of, Self::Scalar))
    }
}

fn numbered(name: &str, count: usize) -> Vec<String> {
    (0..count).map(|i| format!("{name}{i}")).collect()
}
