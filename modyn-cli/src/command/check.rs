//! `modyn check`: reports the errors and warnings of descriptions, with their places.

mod collection;

use std::path::PathBuf;

use clap::Args;
use modyn_codegen::ReadOptions;
use modyn_codegen::diagnostics::Diagnostics;
use serde_json::json;

use crate::command::description::Description;
use crate::command::diagnostics;
use crate::command::options::ReadingOptions;
use crate::command::outcome::{Failure, to_stdout};
use crate::escape;
use crate::report;

/// Report the errors and warnings of descriptions
///
/// The exit code is 0 if all descriptions are valid, 1 if one is rejected, 2 if a file cannot be
/// read.
#[derive(Args)]
pub struct Arguments {
    /// The descriptions (URDF, xacro, SDF or MJCF); `-` for standard input
    #[arg(value_name = "ROBOT.urdf", required = true)]
    paths: Vec<PathBuf>,
    /// Check all descriptions in folders, and print a table: file, format, verdict, and why it is
    /// refused
    ///
    /// A file that cannot be used by itself, and that others of the folder include, is a `part`. A
    /// robot in which nothing moves is `static`. Other XML files are left out.
    #[arg(long)]
    collection: bool,
    /// Also reject descriptions with warnings
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
    description: Option<Description>,
    diagnostics: Diagnostics,
    usable: bool,
}

impl Outcome {
    fn to_json(&self) -> serde_json::Value {
        json!({
            "file": self.name,
            "usable": self.usable,
            "diagnostics": diagnostics::to_json(self.diagnostics.as_slice()),
        })
    }
}

/// Checks all files, in order.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let options = arguments.options.read_options();
    if arguments.collection {
        return collection::run(arguments, &options);
    }
    let mut outcomes = Vec::new();
    let mut unread = false;
    for path in &arguments.paths {
        match Description::open(path) {
            Ok(description) => outcomes.push(check_one(description, &options, arguments)),
            Err(diagnostics) => {
                let refused = diagnostics.iter().any(|one| one.position.is_some());
                unread |= !refused;
                let name = path.display().to_string();
                outcomes.push(Outcome { name, description: None, diagnostics, usable: false });
            }
        }
    }
    to_stdout(&if arguments.json { as_json(&outcomes) } else { as_text(&outcomes) })?;
    if unread {
        return Err(Failure::Usage(String::from("error: not all files could be read")));
    }
    if outcomes.iter().all(|outcome| outcome.usable) { Ok(()) } else { Err(Failure::Reported) }
}

fn check_one(description: Description, options: &ReadOptions, arguments: &Arguments) -> Outcome {
    let (diagnostics, usable) = match description.read(options) {
        Ok(reading) => {
            let usable = !arguments.deny_warnings || reading.warnings.is_empty();
            (Diagnostics::new(reading.warnings), usable)
        }
        Err(diagnostics) => (diagnostics, false),
    };
    Outcome { name: description.name.clone(), description: Some(description), diagnostics, usable }
}

fn as_text(outcomes: &[Outcome]) -> String {
    let mut out = String::new();
    for Outcome { name, description, diagnostics, usable } in outcomes {
        out += &diagnostics::render(diagnostics.as_slice(), description.as_ref());
        out += &report::verdict(name, *usable, diagnostics.as_slice());
    }
    out
}

fn as_json(outcomes: &[Outcome]) -> String {
    let all: Vec<_> = outcomes.iter().map(Outcome::to_json).collect();
    escape::json(&serde_json::Value::from(all))
}
