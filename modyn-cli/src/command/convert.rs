//! `modyn convert`: writes what modyn understood of a description as a URDF or an MJCF.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use modyn_codegen::diagnostics::{Diagnostics, sanitize_for_display};
use modyn_codegen::{Format, write};

use crate::command::outcome::{Failure, to_file, to_stderr};
use crate::command::robot::Robot;

/// Write a robot as a URDF or an MJCF: its links, joints, inertias, loops, contacts, shapes that
/// touch the ground, and actuators
///
/// Reading the result again gives the same robot. Properties that the format cannot express are
/// said on standard error and at the top of the result.
///
/// The exit code is 1 if the description is rejected, or if the robot's dynamics would differ in
/// the other format.
#[derive(Args)]
pub struct Arguments {
    #[command(flatten)]
    robot: Robot,
    /// The file to write; `-` for standard output
    #[arg(value_name = "OUT")]
    out: PathBuf,
    /// The format to write [default: the format of the file's extension: `.urdf`; `.xml` or `.mjcf`
    /// for an MJCF]
    #[arg(long, value_name = "FORMAT")]
    to: Option<To>,
}

/// The formats that are written.
#[derive(Clone, Copy, ValueEnum)]
enum To {
    Urdf,
    Mjcf,
}

/// Converts a description.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let format = arguments.format()?;
    let Arguments { robot, out, .. } = arguments;
    let description = robot.open()?;
    let read = description.read(&robot.options.read_options());
    let reading = read.map_err(|diagnostics| description.failure(robot.named(diagnostics)))?;
    let inputs = description.inputs(Some(&reading));
    description.warn(robot.named(Diagnostics::new(reading.warnings)));
    let text = write(&reading.model, format);
    let written = text.map_err(|diagnostics| Failure::Diagnostics(diagnostics, None))?;
    for note in &written.notes {
        to_stderr(&format!("note: {}\n", sanitize_for_display(note)));
    }
    to_file(out, &written.text, &inputs)
}

impl Arguments {
    fn format(&self) -> Result<Format, Failure> {
        let given = self.out.extension().and_then(|extension| extension.to_str());
        let extension = given.map(str::to_ascii_lowercase);
        match (self.to, extension.as_deref()) {
            (Some(To::Urdf), _) | (None, Some("urdf")) => Ok(Format::Urdf),
            (Some(To::Mjcf), _) | (None, Some("xml" | "mjcf")) => Ok(Format::Mjcf),
            (None, _) => Err(Failure::usage(format!(
                "error: the format of `{}` is not known: name the file `.urdf` or `.xml`, or add \
                 `--to urdf` or `--to mjcf`",
                sanitize_for_display(&self.out.display().to_string())
            ))),
        }
    }
}
