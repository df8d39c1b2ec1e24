//! `modyn generate`: writes a robot's dynamics as Rust, C, CUDA, WGSL or C for CasADi, and a header for Rust functions that C calls.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use modyn_codegen::diagnostics::sanitize_for_display;
use modyn_codegen::diagnostics::{Diagnostic, Diagnostics};
use modyn_codegen::{Builder, GpuLanguage, names};

use crate::command::options::CodeOptions;
use crate::command::outcome::{Failure, to_file, to_stderr, to_stdout};
use crate::command::progress::Progress;
use crate::command::robot::{Description, Robot};

/// The report on a file that differs from what would be written.
const STALE: &str = "stale: it is missing or was edited, or the description, an option or modyn has changed; \
                     generate it again without `--check`";

/// Compile a description to Rust, C, CUDA, WGSL or C for CasADi
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
    /// The language: Rust; C99 that needs `<math.h>` only, FILE.c with its header FILE.h; kernels for graphics
    /// processors, CUDA C++ or WGSL, with a thread for each state; or C99 for `casadi.external`, one file with all
    /// derivatives
    #[arg(long, value_enum, default_value_t)]
    target: Target,
    /// Write the header of the functions for C; without `--c-functions` their prefix is the robot's name
    #[arg(long, value_name = "FILE.h", requires = "output")]
    c_header: Option<PathBuf>,
    #[command(flatten)]
    code: CodeOptions,
    #[command(flatten)]
    robot: Robot,
}

#[derive(Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
enum Target {
    #[default]
    Rust,
    C,
    Cuda,
    Wgsl,
    Casadi,
}

impl Target {
    /// The language, if it is one for graphics processors.
    fn gpu(self) -> Option<GpuLanguage> {
        match self {
            Self::Rust | Self::C | Self::Casadi => None,
            Self::Cuda => Some(GpuLanguage::Cuda),
            Self::Wgsl => Some(GpuLanguage::Wgsl),
        }
    }
}

/// Writes, or compares.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let description = arguments.robot.open()?;
    let builder = arguments.builder(&description)?;
    let named = |found: Diagnostics| description.failure(arguments.robot.named(found));
    if arguments.target == Target::C {
        return c_source(arguments, &builder, &description, &named);
    }
    if let Some(language) = arguments.target.gpu() {
        let text = || builder.generate_gpu(language).map(|(source, found)| (source.text, found));
        return one_file(arguments, text, &description, &named);
    }
    if arguments.target == Target::Casadi {
        let text = || builder.generate_casadi().map(|(source, found)| (source.text, found));
        return one_file(arguments, text, &description, &named);
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

/// Refuses options that only Rust has.
fn refuse_rust_options(arguments: &Arguments, target: &str) -> Result<(), Failure> {
    let of_rust = ["c_functions", "visibility", "crate", "self_contained"];
    let given = of_rust.into_iter().find(|name| arguments.code.has(name));
    if let Some(option) = given.or(arguments.c_header.as_ref().map(|_| "c_header")) {
        let option = option.replace('_', "-");
        let message = format!("error: `--{option}` is about Rust, not `--target {target}`");
        return Err(Failure::usage(message));
    }
    Ok(())
}

/// Writes a text that is one file, or checks the file.
fn one_file(
    arguments: &Arguments,
    text: impl FnOnce() -> Result<(String, Vec<Diagnostic>), Diagnostics>,
    description: &Description,
    named: &impl Fn(Diagnostics) -> Failure,
) -> Result<(), Failure> {
    let target = arguments.target.to_possible_value();
    refuse_rust_options(arguments, target.as_ref().map_or("c", |value| value.get_name()))?;
    let mut progress = Progress::start("compiling");
    let (text, warnings) = text().map_err(named)?;
    progress.stop();
    description.warn(arguments.robot.named(Diagnostics::new(warnings)));
    let Some(output) = &arguments.output else { return to_stdout(&text) };
    let current = std::fs::read_to_string(output).is_ok_and(|found| found == text);
    if arguments.check {
        let found = if current { "up to date" } else { "stale" };
        to_stderr(&format!("{} is {found}\n", sanitize_for_display(&output.display().to_string())));
        return if current { Ok(()) } else { Err(Failure::Said) };
    }
    if current { Ok(()) } else { to_file(output, &text) }
}

/// Writes the C files, or checks them.
fn c_source(
    arguments: &Arguments,
    builder: &Builder,
    description: &Description,
    named: &impl Fn(Diagnostics) -> Failure,
) -> Result<(), Failure> {
    refuse_rust_options(arguments, "c")?;
    let Some(output) = &arguments.output else {
        let message = "error: `--target c` writes two files: name the first with `--output FILE.c`";
        return Err(Failure::usage(message));
    };
    let mut progress = Progress::start("compiling");
    if arguments.check {
        let stale = builder.is_stale_c(output).map_err(named)?;
        progress.stop();
        let found = if stale { STALE } else { "up to date" };
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
        let what = if stale { STALE } else { "up to date" };
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
        let builder = self.code.configure(self.robot.builder(description));
        if self.c_header.is_none() || self.code.has("c_functions") {
            return Ok(builder);
        }
        // Without a prefix the functions for C begin with the robot's name.
        let reading = description.read(&self.robot.options.read_options());
        let reading = reading.map_err(|found| description.failure(found))?;
        Ok(builder.c_functions(names::snake(reading.model.name())))
    }
}
