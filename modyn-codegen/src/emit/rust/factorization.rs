//! The functions of the factorization type.

use std::fmt::Write as _;

use super::function::function;
use super::parameter::Parameter;
use super::shape::Shape;
use super::{Robot, docs};
use crate::plan::{Argument, FactorFunction};

impl Robot<'_> {
    /// Prints the functions of the factorization.
    pub(super) fn factorization(&self, text: &mut String) {
        let name = self.name;
        let layout = &self.plan.layout;
        let float = self.options.scalar;
        let n = self.model.nv();
        let vector = Shape::vector(n).type_of("T");
        let matrix = Shape::vector(n).array(n).type_of("T");
        let shape = |planned: &crate::plan::Shape| Shape::new(planned, name);
        // The functions of the factors only; `solve` has a right-hand side, too.
        let (of_factors, solve): (Vec<_>, Vec<_>) =
            self.plan.factorization.iter().partition(|function| function.arguments.len() == 1);
        let _ = writeln!(
            text,
            "impl<T: __modyn::Scalar> {name}UduFactorization<T> {{\n\
             /// The number of stored entries.\n\
             pub const FACTORS: usize = {size};\n\
             /// Returns the factorization with these stored entries, as [`factors`](Self::factors) returns them.\n\
             #[must_use]\n\
             pub const fn from_factors(factors: [T; {size}]) -> Self {{\n    Self {{ factors }}\n}}\n\
             /// Returns the stored entries: U and D without their zeros, in an internal order.\n\
             #[must_use]\n\
             pub const fn factors(&self) -> &[T; {size}] {{\n    &self.factors\n}}",
            size = layout.size()
        );
        for FactorFunction { name: function_name, docs, result, .. } in of_factors.iter().copied() {
            let _ = writeln!(
                text,
                "/// {docs}\n#[must_use]\npub fn {function_name}(&self) -> {} {{\n    \
                 {function_name}(&self.factors)\n}}",
                shape(result).type_of("T")
            );
        }
        let _ = writeln!(
            text,
            "/// Returns the solution x of M x = `rhs`, with the mass matrix M, by the three steps \
             of equation 60 of the\n\
             /// paper.\n\
             #[must_use]\n\
             pub fn solve(&self, rhs: &{vector}) -> {vector} {{\n    solve(&self.factors, rhs)\n}}"
        );
        let mut condition_numbers = Vec::new();
        for (m, block) in layout.blocks().iter().enumerate() {
            let size = block.dofs.len();
            // Only the entries up to the block's last one are named; the rest is one pattern.
            let entries: Vec<String> = (0..layout.d(m).end)
                .map(|i| if layout.d(m).contains(&i) { format!("d{i}") } else { "_".into() })
                .collect();
            let shown = entries.iter().map(|entry| format!("{entry}, ")).collect::<String>();
            let names = entries[layout.d(m)].join(", ");
            let joints = self.joint_names()[self.modules.modules()[m].links.clone()].join(", ");
            let block_rows: Vec<String> = entries[layout.d(m)]
                .chunks(size.max(1))
                .map(|row| format!("[{}]", row.join(", ")))
                .collect();
            let _ = writeln!(
                text,
                "/// Returns the pivot block of module {m} (joints {}; equation 46 of the paper), an array of\n\
                 /// columns.\n\
                 #[must_use]\n\
                 pub fn pivot_block_{m}(&self) -> [[T; {size}]; {size}] {{\n    \
                 let [{shown}..] = self.factors;\n    [{}]\n}}",
                docs::code(&joints),
                block_rows.join(", ")
            );
            condition_numbers.push(if size == 0 {
                // All joints of the module are mimic joints.
                "T::one()".into()
            } else {
                format!(
                    "{{\n            let [{shown}..] = self.factors;\n            \
                 __modyn::jacobi::condition_number(&mut [{names}], {size})\n        }}"
                )
            });
        }
        let arms: Vec<String> = condition_numbers
            .iter()
            .enumerate()
            .map(|(m, value)| format!("{m} => ::core::option::Option::Some({value}),\n"))
            .collect();
        let _ = writeln!(
            text,
            "/// Returns the condition number (2-norm) of each module's pivot block, by a fixed \
             number of Jacobi sweeps;\n\
             /// infinite where it exceeds the scalar's precision.\n\
             #[must_use]\n\
             pub fn condition_numbers(&self) -> [T; {}] {{\n    [{}]\n}}\n\
             /// Returns the condition number of module `module`'s pivot block; `None` if there is no such module.\n\
             #[must_use]\n\
             pub fn condition_number(&self, module: usize) -> ::core::option::Option<T> {{\n    \
             match module {{\n{}_ => ::core::option::Option::None,\n    }}\n}}\n}}\n",
            condition_numbers.len(),
            condition_numbers.join(", "),
            arms.concat(),
        );
        if !self.options.self_contained {
            let _ = writeln!(
                text,
                "impl<T: __modyn::Scalar> __modyn::Factorization<T> for {name}UduFactorization<T> {{\n\
             type V = {vector};\n\
             type M = {matrix};"
            );
            for FactorFunction { name: function_name, result, .. } in of_factors.iter().copied() {
                let _ = writeln!(
                    text,
                    "fn {function_name}(&self) -> {} {{\n    Self::{function_name}(self)\n}}",
                    shape(result).type_of("T")
                );
            }
            let _ = writeln!(
                text,
                "fn solve(&self, rhs: &{vector}) -> {vector} {{\n    Self::solve(self, rhs)\n}}\n\
             fn condition_number(&self, module: usize) -> ::core::option::Option<T> {{\n    \
             Self::condition_number(self, module)\n}}\n}}\n"
            );
        }
        for FactorFunction { name, arguments, result, program, .. } in
            of_factors.into_iter().chain(solve)
        {
            let parameter = |(argument, given): &(Argument, crate::plan::Shape)| {
                Parameter::new(argument.name, shape(given)).of_kind(argument.kind)
            };
            let parameters: Vec<Parameter> = arguments.iter().map(parameter).collect();
            *text += &function(name, &parameters, &shape(result), program, float);
        }
    }
}
