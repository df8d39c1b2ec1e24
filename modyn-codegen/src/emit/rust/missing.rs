//! Functions that a robot does not have: calling one is a compile error that names the option
//! `functions`.

use std::fmt::Write as _;

use super::Robot;
use crate::plan::{Function, signatures};

impl Robot<'_> {
    /// Prints the traits of `modyn::functions` that the robot implements; and for each function
    /// that the robot does not have, a function of its name whose bound does not hold.
    pub(super) fn availability(&self, text: &mut String, generated: &[Function]) {
        let name = self.name;
        for function in generated {
            let _ = writeln!(text, "impl __modyn::functions::{function:?} for {name} {{}}");
        }
        let _ = writeln!(text, "impl {name} {{");
        for &function in Function::ALL.iter().filter(|function| !generated.contains(function)) {
            let with_parameters =
                function.depends_on_parameters() && !self.plan.parameters.is_empty();
            for (called, arguments) in signatures(function) {
                missing(text, function, &called, arguments);
                if with_parameters {
                    missing(text, function, &format!("{called}_with"), arguments + 1);
                }
            }
        }
        text.push_str("}\n\n");
    }
}

/// Prints a function that cannot be called. Its bound has a lifetime parameter: otherwise rustc
/// would reject the function instead of its calls.
fn missing(text: &mut String, function: Function, called: &str, arguments: usize) {
    let arguments = vec!["_: impl ::core::marker::Sized"; arguments].join(", ");
    let _ = writeln!(
        text,
        "#[doc(hidden)]\npub fn {called}({arguments}) -> ! \
         where for<'call> Self: __modyn::functions::{function:?} {{ __modyn::functions::not_generated() }}"
    );
}
