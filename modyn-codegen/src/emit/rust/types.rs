//! The public types, and the enums' functions.

use std::fmt::Write as _;
use std::ops::Range;

use super::quantity::Quantity;
use super::shape::Shape;
use super::{Robot, docs};
use crate::names;

impl Robot<'_> {
    /// Prints the public types, without their functions.
    pub(super) fn types(&self, text: &mut String, quantities: &[Quantity<'_>]) {
        let name = self.name;
        let vis = &self.options.visibility;
        let float = self.options.scalar.name();
        let _ = writeln!(
            text,
            "#[allow(dead_code)]\n#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]\n{vis} struct {name};\n"
        );
        for (kind, names, what) in
            [("Joint", self.joint_names(), "joint"), ("Link", self.link_names(), "link")]
        {
            let variants = names::variants(&names);
            let kind = format!("{name}{kind}");
            let own_names = variants.iter().map(String::as_str).chain([&*kind]);
            let lint = names::camel_case_lint(own_names);
            let _ = writeln!(
                text,
                "/// A {what} of [`{name}`].\n\
                 #[allow(dead_code)]\n\
                 {lint}#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]\n\
                 {vis} enum {kind} {{"
            );
            for (variant, original) in variants.iter().zip(&names) {
                let _ = writeln!(text, "    /// {}\n    {variant},", docs::code(original));
            }
            text.push_str("}\n\n");
        }
        self.parameters_type(text);
        self.contact_set(text);
        self.result_types(text, quantities);
        if !self.factorizes() {
            return;
        }
        let kind = format!("{name}UduFactorization");
        let lint = names::camel_case_lint([&*kind].into_iter());
        let _ = writeln!(
            text,
            "/// The factorization U D U^T of the mass matrix of [`{name}`] by kinematic modules.\n\
             #[allow(dead_code)]\n\
             {lint}#[derive(Clone, Copy, Debug, PartialEq)]\n\
             {vis} struct {kind}<T = {float}> {{\n    factors: [T; {}],\n}}\n",
            self.plan.layout.size()
        );
    }

    /// Prints the types of results that are the robot's own.
    fn result_types(&self, text: &mut String, quantities: &[Quantity<'_>]) {
        let vis = &self.options.visibility;
        let float = self.options.scalar.name();
        // The path that `__modyn` stands for in the functions.
        let path = |kind: String| kind.replace("__modyn", &self.options.crate_path);
        for quantity in quantities.iter().filter(|quantity| !quantity.fields.is_empty()) {
            let Shape::Struct { path: kind, fields, .. } = &quantity.shape else { continue };
            let field = |((name, shape), docs): (&(&str, Shape), &&str)| {
                let kind = path(shape.type_of("T"));
                format!("    /// {docs}\n    pub {name}: {kind},\n")
            };
            let fields: String = fields.iter().zip(quantity.fields).map(field).collect();
            let lint = names::camel_case_lint([&**kind].into_iter());
            let _ = writeln!(
                text,
                "/// The results of `{}::{}`.\n\
                 #[allow(dead_code)]\n\
                 {lint}#[derive(Clone, Copy, Debug, PartialEq)]\n\
                 {vis} struct {kind}<T = {float}> {{\n{fields}}}\n",
                self.name, quantity.name
            );
        }
    }

    /// Prints the functions of the enums.
    pub(super) fn enums(&self, text: &mut String) {
        let name = self.name;
        let joints = names::variants(&self.joint_names());
        let ranges = |range: &dyn Fn(usize) -> Range<usize>| {
            let arms =
                joints.iter().enumerate().map(|(i, v)| format!("Self::{v} => {:?},\n", range(i)));
            arms.collect::<String>()
        };
        let _ = writeln!(
            text,
            "impl {name}Joint {{\n\
             /// Returns the entries of `q` of this joint; for a mimic joint the entries of its leader.\n\
             #[must_use]\n\
             pub const fn coordinates(self) -> ::core::ops::Range<usize> {{\n    match self {{\n{}    }}\n}}\n\
             /// Returns the entries of `qd` and `tau` of this joint; for a mimic joint the entries of its leader.\n\
             #[must_use]\n\
             pub const fn velocities(self) -> ::core::ops::Range<usize> {{\n    match self {{\n{}    }}\n}}\n}}\n",
            ranges(&|i| self.model.q_range(i)),
            ranges(&|i| self.model.v_range(i)),
        );
        for (kind, names, constant) in [
            ("Joint", self.joint_names(), "JOINT_NAMES"),
            ("Link", self.link_names(), "LINK_NAMES"),
        ] {
            let variants = names::variants(&names);
            let all: Vec<String> = variants.iter().map(|v| format!("Self::{v}")).collect();
            let arms: Vec<String> = variants
                .iter()
                .zip(&names)
                .map(|(variant, name)| format!("Self::{variant} => {name:?},\n"))
                .collect();
            let _ = writeln!(
                text,
                "impl {name}{kind} {{\n\
                 /// All variants, in the order of `{constant}`.\n\
                 pub const ALL: [Self; {}] = [{}];\n\
                 /// Returns the index in `{constant}`.\n\
                 #[must_use]\n\
                 pub const fn index(self) -> usize {{\n    self as usize\n}}\n\
                 /// Returns the name in the description.\n\
                 #[must_use]\n\
                 pub const fn name(self) -> &'static str {{\n    match self {{\n{}    }}\n}}\n}}\n",
                all.len(),
                all.join(", "),
                arms.concat(),
            );
        }
    }
}
