//! `modyn generate`: writes a robot's dynamics as Rust or C, and a header for Rust functions that C calls.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use modyn_codegen::diagnostics::Diagnostics;
use modyn_codegen::diagnostics::sanitize_for_display;
use modyn_codegen::{Builder, FloatType, ModuleChoice, names};

use crate::command::choices::{Functions, functions, modules};
use crate::command::outcome::{Failure, to_file, to_stderr, to_stdout};
use crate::command::progress::Progress;
use crate::command::robot::{Description, Robot};

/// Compile a description to Rust or C
///
/// The exit code is 0 if the file was written (with `--check`, if it is up to date), 1 if the description is rejected
/// (with `--check`, if the file is stale), 2 if an option or a file is invalid.
#[derive(Args)]
pub struct Arguments {
    /// The file to write; standard output without it
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Write nothing, but report whether FILE (and the header) is up to date: exit code 0, or 1 if it is stale
    #[arg(long, requires = "output")]
    check: bool,
    /// The language: Rust; or C99 that needs `<math.h>` only, FILE.c with its header FILE.h
    #[arg(long, value_enum, default_value_t)]
    target: Target,
    /// Generate a file that depends on `core` only, not on modyn
    #[arg(long)]
    self_contained: bool,
    /// Make equal limbs (legs, arms, fingers) share one function: the smallest code
    #[arg(long)]
    share: bool,
    /// The functions of the robot: names separated by commas, `default`, `all`
    #[arg(long, value_name = "NAMES", value_parser = functions)]
    functions: Option<Functions>,
    /// The scalar of the type's own functions
    #[arg(long, value_enum, default_value_t)]
    scalar: Scalar,
    /// The kinematic modules: `chains`, `links`, or a list such as [["a", "b"], ["c"]]
    #[arg(long, value_name = "MODULES", value_parser = modules)]
    modules: Option<ModuleChoice>,
    /// A link whose own inertia becomes a run-time parameter, which replaces the description's
    #[arg(long, value_name = "LINK")]
    runtime_inertia: Vec<String>,
    /// A link with a payload: an additional inertia that is a run-time parameter
    #[arg(long, value_name = "LINK")]
    payload: Vec<String>,
    /// Make gravity a run-time parameter
    #[arg(long)]
    runtime_gravity: bool,
    /// The name of the generated type [default: derived from the robot's name]
    #[arg(long, value_name = "NAME")]
    type_name: Option<String>,
    /// The visibility of the generated types, such as `pub(crate)` [default: pub]
    #[arg(long)]
    visibility: Option<String>,
    /// The path of the crate `modyn` in the crate of the file [default: ::modyn]
    #[arg(long = "crate", value_name = "PATH", conflicts_with = "self_contained")]
    krate: Option<String>,
    /// Add functions for C with this prefix: `prefix_forward_dynamics` and so on
    #[arg(long, value_name = "PREFIX")]
    c_functions: Option<String>,
    /// Write the header of the functions for C; without `--c-functions` their prefix is the robot's name
    #[arg(long, value_name = "FILE.h", requires = "output")]
    c_header: Option<PathBuf>,
    #[command(flatten)]
    robot: Robot,
}

#[derive(Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
enum Target {
    #[default]
    Rust,
    C,
}

#[derive(Clone, Copy, Default, ValueEnum)]
enum Scalar {
    #[default]
    F64,
    F32,
}

/// Writes the file, or checks it.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let description = arguments.robot.open()?;
    let builder = arguments.builder(&description)?;
    let named = |found: Diagnostics| description.failure(arguments.robot.named(found));
    if arguments.target == Target::C {
        return c_source(arguments, &builder, &description, &named);
    }
    let mut progress = Progress::start("compiling");
    let result = match &arguments.output {
        Some(output) if arguments.check => stale(arguments, &builder, output, &named),
        Some(output) => write(arguments, &builder, output, &description, &named),
        None => {
            let generated = builder.generate().map_err(named)?;
            progress.stop();
            description.warn(arguments.robot.named(Diagnostics::new(generated.warnings)));
            return to_stdout(&generated.text);
        }
    };
    progress.stop();
    result
}

fn write(
    arguments: &Arguments,
    builder: &Builder,
    output: &Path,
    description: &Description,
    named: &impl Fn(Diagnostics) -> Failure,
) -> Result<(), Failure> {
    let generated = builder.write(output).map_err(named)?;
    if let (Some(path), Some(header)) = (&arguments.c_header, &generated.c_header)
        && !std::fs::read_to_string(path).is_ok_and(|found| found == *header)
    {
        to_file(path, header)?;
    }
    description.warn(arguments.robot.named(Diagnostics::new(generated.warnings)));
    Ok(())
}

/// Writes the C files, or checks them.
fn c_source(
    arguments: &Arguments,
    builder: &Builder,
    description: &Description,
    named: &impl Fn(Diagnostics) -> Failure,
) -> Result<(), Failure> {
    let given = [
        ("--c-functions", arguments.c_functions.is_some()),
        ("--c-header", arguments.c_header.is_some()),
        ("--visibility", arguments.visibility.is_some()),
        ("--crate", arguments.krate.is_some()),
        ("--self-contained", arguments.self_contained),
    ];
    if let Some((option, _)) = given.iter().find(|(_, given)| *given) {
        let message = format!("error: `{option}` is about Rust, not `--target c`");
        return Err(Failure::usage(message));
    }
    let Some(output) = &arguments.output else {
        let message = "error: `--target c` writes two files: name the first with `--output FILE.c`";
        return Err(Failure::usage(message));
    };
    let mut progress = Progress::start("compiling");
    if arguments.check {
        let stale = builder.is_stale_c(output).map_err(named)?;
        progress.stop();
        let found = if stale { "stale" } else { "up to date" };
        to_stderr(&format!("{} is {found}\n", sanitize_for_display(&output.display().to_string())));
        return if stale { Err(Failure::Said) } else { Ok(()) };
    }
    let warnings = builder.write_c(output).map_err(named)?;
    progress.stop();
    description.warn(arguments.robot.named(Diagnostics::new(warnings)));
    Ok(())
}

fn stale(
    arguments: &Arguments,
    builder: &Builder,
    output: &Path,
    named: &impl Fn(Diagnostics) -> Failure,
) -> Result<(), Failure> {
    let is = |path: &Path, stale: bool| {
        let what = if stale { "stale" } else { "up to date" };
        to_stderr(&format!("{} is {what}\n", sanitize_for_display(&path.display().to_string())));
        stale
    };
    let mut stale = is(output, builder.is_stale(output).map_err(named)?);
    if let Some(path) = &arguments.c_header {
        let header = builder.generate().map_err(named)?.c_header.unwrap_or_default();
        let found = std::fs::read_to_string(path);
        stale |= is(path, !found.is_ok_and(|found| found.replace("\r\n", "\n") == header));
    }
    if stale { Err(Failure::Said) } else { Ok(()) }
}

impl Arguments {
    fn builder(&self, description: &Description) -> Result<Builder, Failure> {
        let mut builder = self.robot.builder(description).float(self.scalar.into());
        if self.self_contained {
            builder = builder.self_contained();
        }
        if self.share {
            builder = builder.share();
        }
        if let Some(Functions(functions)) = &self.functions {
            builder = builder.functions(functions.iter().copied());
        }
        if let Some(modules) = &self.modules {
            builder = builder.modules(modules.clone());
        }
        if !self.runtime_inertia.is_empty() {
            builder = builder.runtime_inertia(&self.runtime_inertia);
        }
        if !self.payload.is_empty() {
            builder = builder.payload(&self.payload);
        }
        if self.runtime_gravity {
            builder = builder.runtime_gravity();
        }
        if let Some(name) = &self.type_name {
            builder = builder.type_name(name);
        }
        if let Some(visibility) = &self.visibility {
            builder = builder.visibility(visibility);
        }
        if let Some(path) = &self.krate {
            builder = builder.krate(path);
        }
        if self.c_functions.is_some() || self.c_header.is_some() {
            builder = builder.c_functions(self.prefix(description)?);
        }
        Ok(builder)
    }

    /// Returns the prefix of functions for C.
    fn prefix(&self, description: &Description) -> Result<String, Failure> {
        if let Some(prefix) = &self.c_functions {
            return Ok(prefix.clone());
        }
        let reading = description.read(&self.robot.options.read_options());
        let reading = reading.map_err(|found| description.failure(found))?;
        Ok(names::snake(reading.model.name()))
    }
}

impl From<Scalar> for FloatType {
    fn from(scalar: Scalar) -> Self {
        match scalar {
            Scalar::F64 => Self::F64,
            Scalar::F32 => Self::F32,
        }
    }
}
