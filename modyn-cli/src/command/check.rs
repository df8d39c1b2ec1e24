//! `modyn check`: reports the faults of descriptions, with their places.

use std::path::PathBuf;

use clap::Args;
use modyn_codegen::ReadOptions;
use modyn_codegen::diagnostics::sanitize_for_display;
use modyn_codegen::diagnostics::{Diagnostics, Severity};
use serde_json::json;

use crate::command::diagnostics;
use crate::command::options::ReadingOptions;
use crate::command::outcome::{Failure, to_stdout};
use crate::command::robot::Description;

/// Report the faults of descriptions
///
/// The exit code is 0 if all descriptions are valid, 1 if one is rejected, 2 if a file cannot be read.
#[derive(Args)]
pub struct Arguments {
    /// The descriptions (URDF or MJCF); `-` for standard input
    #[arg(value_name = "ROBOT.urdf", required = true)]
    paths: Vec<PathBuf>,
    /// Reject descriptions with warnings, too
    #[arg(long)]
    deny_warnings: bool,
    /// Print JSON: for each file its name, whether it is valid, and the diagnostics
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    options: ReadingOptions,
}

/// The result of one file.
struct Outcome {
    name: String,
    text: Option<String>,
    found: Diagnostics,
    usable: bool,
}

/// Checks all files, in order.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let options = arguments.options.read_options();
    let mut answers = Vec::new();
    let mut unread = false;
    for path in &arguments.paths {
        match Description::open(path) {
            Ok(description) => answers.push(check_one(description, &options, arguments)),
            Err(found) => {
                let refused = found.iter().any(|one| one.position.is_some());
                unread |= !refused;
                let name = path.display().to_string();
                answers.push(Outcome { name, text: None, found, usable: false });
            }
        }
    }
    to_stdout(&if arguments.json { as_json(&answers) } else { as_text(&answers) })?;
    if unread {
        return Err(Failure::Usage(String::from("error: not all files could be read")));
    }
    if answers.iter().all(|answer| answer.usable) { Ok(()) } else { Err(Failure::Said) }
}

fn check_one(description: Description, options: &ReadOptions, arguments: &Arguments) -> Outcome {
    let (found, usable) = match description.read(options) {
        Ok(reading) => {
            let usable = !arguments.deny_warnings || reading.warnings.is_empty();
            (Diagnostics::new(reading.warnings), usable)
        }
        Err(found) => (found, false),
    };
    let Description { name, text, .. } = description;
    Outcome { name, text: Some(text), found, usable }
}

fn as_text(answers: &[Outcome]) -> String {
    let mut out = String::new();
    for Outcome { name, text, found, usable } in answers {
        out += &diagnostics::render(found.as_slice(), text.as_deref());
        let count = |severity, what: &str| {
            let count = found.iter().filter(|one| one.severity == severity).count();
            match count {
                0 => String::new(),
                1 => format!(", 1 {what}"),
                _ => format!(", {count} {what}s"),
            }
        };
        let errors = count(Severity::Error, "error");
        let warnings = count(Severity::Warning, "warning");
        let verdict = if *usable { "usable" } else { "refused" };
        out += &format!("{}: {verdict}{errors}{warnings}\n", sanitize_for_display(name));
    }
    out
}

fn as_json(answers: &[Outcome]) -> String {
    let all: Vec<_> = answers
        .iter()
        .map(|answer| {
            json!({
                "file": answer.name,
                "usable": answer.usable,
                "diagnostics": diagnostics::to_json(answer.found.as_slice()),
            })
        })
        .collect();
    format!("{:#}\n", serde_json::Value::from(all))
}
