//! The command line: subcommands and exit codes.

mod check;
mod choices;
mod compare;
mod convert;
mod description;
mod diagnostics;
mod explain;
mod generate;
mod inspect;
mod numbers;
mod options;
mod outcome;
mod progress;
mod robot;
mod simulate;
mod table;
mod view;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Rigid-body dynamics from a robot description (URDF, xacro, SDF or MJCF).
///
/// Exit codes: 0 for success; 1 for a negative result (a description is rejected, a file is stale,
/// results differ); 2 if the command line or a file is invalid.
#[derive(Parser)]
#[command(name = "modyn", version, max_term_width = 100)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Inspect(inspect::Arguments),
    Check(check::Arguments),
    Generate(generate::Arguments),
    Simulate(simulate::Arguments),
    View(view::Arguments),
    Compare(compare::Arguments),
    Convert(convert::Arguments),
    Explain(explain::Arguments),
}

/// Runs the command line.
#[must_use]
pub fn run() -> ExitCode {
    let arguments = Arguments::try_parse();
    let result = match arguments.unwrap_or_else(|error| options::explain(error).exit()).command {
        Command::Inspect(arguments) => inspect::run(&arguments),
        Command::Check(arguments) => check::run(&arguments),
        Command::Generate(arguments) => generate::run(&arguments),
        Command::Simulate(arguments) => simulate::run(&arguments),
        Command::View(arguments) => view::run(&arguments),
        Command::Compare(arguments) => compare::run(&arguments),
        Command::Convert(arguments) => convert::run(&arguments),
        Command::Explain(arguments) => explain::run(&arguments),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}
