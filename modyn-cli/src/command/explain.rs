//! `modyn explain`: prints the cause of a diagnostic and its remedy.

use clap::Args;
use modyn_codegen::diagnostics::Code;
use modyn_codegen::diagnostics::sanitize_for_display;

use crate::command::outcome::{Failure, to_stdout};

/// Print the cause of a diagnostic and its remedy
///
/// The exit code is 0, or 2 for an unknown code.
#[derive(Args)]
pub struct Arguments {
    /// The code in brackets, such as `singular-joint`; without it, all codes are printed
    code: Option<String>,
}

/// Prints the explanation.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Some(name) = &arguments.code else {
        let line = |code: &Code| format!("{code}: {}\n", code.cause());
        return to_stdout(&Code::ALL.iter().map(line).collect::<String>());
    };
    let code = Code::from_name(name).ok_or_else(|| {
        let help = match Code::suggest(name) {
            Some(meant) => format!("did you mean `{meant}`?"),
            None => "`modyn explain` lists all".into(),
        };
        Failure::usage(format!("error: there is no code `{}`; {help}", sanitize_for_display(name)))
    })?;
    to_stdout(&format!("{code}: {}\n\n{}\n", code.cause(), code.remedy()))
}
