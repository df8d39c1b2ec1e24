//! `modyn generate`: writes a robot's dynamics as Rust, C, C++, CUDA, WGSL, C for CasADi, MATLAB or
//! machine code, and a header for Rust functions that C calls.

use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use clap::builder::PossibleValue;
use clap::{Args, ValueEnum};
use modyn_codegen::diagnostics::Diagnostics;
use modyn_codegen::diagnostics::sanitize_for_display;
use modyn_codegen::{Builder, GpuLanguage, RolloutForces, RolloutOptions, Target, names};
use modyn_jit::object::{ObjectBuilder, ObjectFormat, ObjectOptions};
use modyn_jit::{CompileError, InstructionSet};

use crate::command::description::Description;
use crate::command::options::CodeOptions;
use crate::command::outcome::{
    Failure, Written, may_write, to_file, to_stderr, to_stdout, write_all,
};
use crate::command::progress::Progress;
use crate::command::robot::Robot;
use modyn_codegen::output::{Replaces, has_content};

/// The report on a file that differs from what would be written.
const STALE: &str = "stale: it is missing or was edited, or the description, an option or modyn has changed; \
                     generate it again without `--check`";

/// Compile a description to Rust, C, C++, CUDA, WGSL, C for CasADi, MATLAB or machine code
///
/// The exit code is 0 if the file was written (with `--check`, if it is up to date), 1 if the
/// description is rejected (with `--check`, if the file is stale), 2 if an option or a file is
/// invalid.
#[derive(Args)]
pub struct Arguments {
    /// The file to write; standard output without it
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Write nothing, but report whether FILE (and the header) is up to date: exit code 0, or 1 if
    /// it is stale
    #[arg(long, requires = "output")]
    check: bool,
    /// The language: Rust; C99 that needs `<math.h>` only, FILE.c with its header FILE.h; C++17 with
    /// Eigen, FILE.hpp with the two files of C that it calls; kernels for graphics processors, CUDA
    /// C++ or WGSL, with a thread for each state; C99 for `casadi.external`, one file with all
    /// derivatives; MATLAB (and GNU Octave), the folder of a package, +FILE; or an object file of
    /// x86-64 machine code, FILE.o (or a static library, FILE.a) with a C header FILE.h and a Rust
    /// text FILE.rs that calls it
    #[arg(long, value_enum, default_value_t)]
    target: Output,
    /// Write the header of the functions for C; without `--c-functions` their prefix is the robot's
    /// name
    #[arg(long, value_name = "FILE.h", requires = "output")]
    c_header: Option<PathBuf>,
    /// The vector instructions of `--target object`; processors without them cannot run the code.
    /// sse2 (the default): every x86-64 processor has them; avx2: AVX2 and FMA; avx512: AVX-512 (F,
    /// DQ and VL)
    #[arg(long, value_enum)]
    instruction_set: Option<VectorInstructions>,
    /// The format of `--target object`; by default this system's format. elf: Linux; mach-o: macOS;
    /// coff: Windows
    #[arg(long, value_enum)]
    object_format: Option<Format>,
    #[command(flatten)]
    rollout: Rollout,
    #[command(flatten)]
    code: CodeOptions,
    #[command(flatten)]
    robot: Robot,
}

#[derive(Args)]
#[command(next_help_heading = "Rollouts of `--target cuda` and `--target wgsl`")]
struct Rollout {
    /// Instead of kernels of the functions, write a kernel for each time step among them
    /// (`step_semi_implicit`), which integrates a motion over many steps in each thread; the other
    /// functions become device functions
    #[arg(long)]
    rollout: bool,
    /// The text of the function `cost`, which the kernels sum up over the steps
    #[arg(long, value_name = "FILE", requires = "rollout")]
    cost: Option<PathBuf>,
    /// The text of the function `forces`: the joint forces from the state and the controls of a
    /// step
    #[arg(long, value_name = "FILE", requires_all = ["rollout", "controls"])]
    forces: Option<PathBuf>,
    /// The text of the function `active_contacts`, which proposes the active contacts of a step; with it
    /// and the functions `constrained_forward_dynamics` and `integrate` there is a kernel of steps
    /// that hold them
    #[arg(long, value_name = "FILE", requires = "rollout")]
    active_contacts: Option<PathBuf>,
    /// The number of controls of a step
    #[arg(long, value_name = "N", requires = "forces")]
    controls: Option<usize>,
}

impl Rollout {
    /// Returns the functions of the user; `None` without rollouts.
    fn options(&self) -> Result<Option<RolloutOptions>, Failure> {
        let read = |path: &PathBuf| {
            std::fs::read_to_string(path).map_err(|error| {
                let path = sanitize_for_display(&path.display().to_string());
                Failure::usage(format!("error: cannot read {path}: {error}"))
            })
        };
        let cost = self.cost.as_ref().map(read).transpose()?;
        let forces = match (&self.forces, self.controls) {
            (Some(path), Some(controls)) => Some(RolloutForces { text: read(path)?, controls }),
            _ => None,
        };
        let active_contacts = self.active_contacts.as_ref().map(read).transpose()?;
        Ok(self.rollout.then_some(RolloutOptions { cost, forces, active_contacts }))
    }
}

/// The value of `--target`: a language, or machine code.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Output {
    Text(Target),
    Object,
}

impl Default for Output {
    fn default() -> Self {
        Self::Text(Target::default())
    }
}

impl ValueEnum for Output {
    fn value_variants<'a>() -> &'a [Self] {
        static ALL: LazyLock<Vec<Output>> = LazyLock::new(|| {
            Target::ALL.map(Output::Text).into_iter().chain([Output::Object]).collect()
        });
        &ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.name()))
    }
}

impl Output {
    fn name(self) -> &'static str {
        match self {
            Self::Text(target) => target.name(),
            Self::Object => "object",
        }
    }

    /// Returns the language, if it is one for graphics processors.
    fn gpu(self) -> Option<GpuLanguage> {
        match self {
            Self::Text(Target::Cuda) => Some(GpuLanguage::Cuda),
            Self::Text(Target::Wgsl) => Some(GpuLanguage::Wgsl),
            Self::Text(_) | Self::Object => None,
        }
    }
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum VectorInstructions {
    Sse2,
    Avx2,
    Avx512,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    Elf,
    MachO,
    Coff,
}

/// Writes, or compares.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let description = arguments.robot.open()?;
    let builder = arguments.builder(&description)?;
    let named = |diagnostics: Diagnostics| description.failure(arguments.robot.named(diagnostics));
    if arguments.rollout.rollout && arguments.target.gpu().is_none() {
        let message = "error: `--rollout` is about `--target cuda` and `--target wgsl`";
        return Err(Failure::usage(message));
    }
    let Output::Text(target) = arguments.target else {
        return object(arguments, &builder, &description, &named);
    };
    let of_objects = [
        ("instruction-set", arguments.instruction_set.is_some()),
        ("object-format", arguments.object_format.is_some()),
    ];
    if let Some((option, _)) = of_objects.into_iter().find(|(_, given)| *given) {
        let message = format!("error: `--{option}` is about `--target object`");
        return Err(Failure::usage(message));
    }
    let rollouts = arguments.rollout.options()?;
    if let (Some(language), Some(rollouts)) = (arguments.target.gpu(), &rollouts) {
        return rollout(arguments, &builder, language, rollouts, &description, &named);
    }
    if target != Target::Rust {
        return source(arguments, &builder, target, &description, &named);
    }
    let mut progress = Progress::start("compiling");
    // Standard output.
    let output = arguments.output.as_ref().filter(|output| *output != Path::new("-"));
    let result = match output {
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
    let inputs = description.inputs(None);
    if let Some(path) = &arguments.c_header {
        may_write(path, &inputs, Replaces::Written)?;
    }
    let generated = builder.write(output).map_err(named)?;
    if let (Some(path), Some(header)) = (&arguments.c_header, &generated.c_header)
        && !has_content(path, header.as_bytes())
    {
        to_file(path, header, &inputs)?;
    }
    description.warn(arguments.robot.named(Diagnostics::new(generated.warnings)));
    Ok(())
}

/// Refuses options that only Rust has.
fn refuse_rust_options(arguments: &Arguments) -> Result<(), Failure> {
    let of_rust = ["c_functions", "visibility", "crate", "self_contained", "embed_model"];
    let given = of_rust.into_iter().find(|name| arguments.code.has(name));
    if let Some(option) = given.or(arguments.c_header.as_ref().map(|_| "c_header")) {
        let option = option.replace('_', "-");
        let message = format!(
            "error: `--{option}` is about Rust, not `--target {}`",
            arguments.target.name()
        );
        return Err(Failure::usage(message));
    }
    Ok(())
}

/// Writes the text of rollouts, or checks the file.
fn rollout(
    arguments: &Arguments,
    builder: &Builder,
    language: GpuLanguage,
    rollouts: &RolloutOptions,
    description: &Description,
    named: &impl Fn(Diagnostics) -> Failure,
) -> Result<(), Failure> {
    refuse_rust_options(arguments)?;
    let mut progress = Progress::start("compiling");
    let (source, warnings) = builder.emit_rollouts(language, rollouts).map_err(named)?;
    progress.stop();
    description.warn(arguments.robot.named(Diagnostics::new(warnings)));
    let Some(output) = &arguments.output else { return to_stdout(&source.text) };
    let current = has_content(output, source.text.as_bytes());
    match (current, arguments.check) {
        (_, true) => checked(output, !current),
        (true, false) => Ok(()),
        (false, false) => to_file(output, &source.text, &description.inputs(None)),
    }
}

/// Writes the files of a language, or checks them; a text that is one file goes to standard output
/// without `--output`.
fn source(
    arguments: &Arguments,
    builder: &Builder,
    target: Target,
    description: &Description,
    named: &impl Fn(Diagnostics) -> Failure,
) -> Result<(), Failure> {
    refuse_rust_options(arguments)?;
    let mut progress = Progress::start("compiling");
    let output = arguments.output.as_ref().filter(|output| *output != Path::new("-"));
    let Some(output) = output else {
        let emitted = builder.emit(target).map_err(named)?;
        progress.stop();
        if let [file] = &*emitted.files {
            description.warn(arguments.robot.named(Diagnostics::new(emitted.warnings)));
            return to_stdout(&file.text);
        }
        let message = format!(
            "error: `--target {}` writes {} files: name them with `--output {}`",
            target.name(),
            emitted.files.len(),
            emitted.output()
        );
        return Err(Failure::usage(message));
    };
    if arguments.check {
        let stale = builder.is_stale_as(target, output).map_err(named)?;
        progress.stop();
        return checked(output, stale);
    }
    let warnings = builder.write_as(target, output).map_err(named)?;
    progress.stop();
    description.warn(arguments.robot.named(Diagnostics::new(warnings)));
    Ok(())
}

/// Reports whether a file is stale.
fn checked(output: &Path, stale: bool) -> Result<(), Failure> {
    let verdict = if stale { STALE } else { "up to date" };
    to_stderr(&format!("{} is {verdict}\n", sanitize_for_display(&output.display().to_string())));
    if stale { Err(Failure::Reported) } else { Ok(()) }
}

/// Writes the object file or the static library, the header and the Rust text, or checks them.
fn object(
    arguments: &Arguments,
    builder: &Builder,
    description: &Description,
    named: &impl Fn(Diagnostics) -> Failure,
) -> Result<(), Failure> {
    if arguments.c_header.is_some() {
        let message = "error: `--c-header` is about Rust; `--target object` writes a header beside the object file";
        return Err(Failure::usage(message));
    }
    let extension = |path: &Path| path.extension()?.to_str().map(str::to_ascii_lowercase);
    let library = match arguments.output.as_deref().and_then(extension).as_deref() {
        Some("o" | "obj") => false,
        Some("a" | "lib") => true,
        _ => {
            let message = "error: `--target object` writes three files: name the first with \
                           `--output FILE.o` (`.obj` on \
                           Windows), or `--output FILE.a` (`.lib`) for a static library";
            return Err(Failure::usage(message));
        }
    };
    let Some(output) = &arguments.output else { return Ok(()) };
    let mut options = ObjectOptions::default();
    match arguments.instruction_set {
        None | Some(VectorInstructions::Sse2) => {}
        Some(VectorInstructions::Avx2) => options.instruction_set = InstructionSet::Avx2,
        Some(VectorInstructions::Avx512) => options.instruction_set = InstructionSet::Avx512,
    }
    match arguments.object_format {
        None => {}
        Some(Format::Elf) => options.format = ObjectFormat::Elf,
        Some(Format::MachO) => options.format = ObjectFormat::MachO,
        Some(Format::Coff) => options.format = ObjectFormat::Coff,
    }
    let mut progress = Progress::start("compiling");
    let object = builder.generate_object(&options).map_err(|error| match error {
        CompileError::Description(diagnostics) => named(diagnostics),
        error => Failure::usage(format!("error: {error}")),
    })?;
    let bytes = match library {
        true => {
            object.static_library().map_err(|reason| Failure::usage(format!("error: {reason}")))?
        }
        false => object.bytes,
    };
    progress.stop();
    description.warn(arguments.robot.named(Diagnostics::new(object.warnings)));
    let header = output.with_extension("h");
    let wrapper = output.with_extension("rs");
    let text =
        |path, text| Written { path, content: str::as_bytes(text), replaces: Replaces::Written };
    let files = [
        Written { path: output, content: &bytes, replaces: Replaces::Any },
        text(&header, &object.header),
        text(&wrapper, &object.wrapper),
    ];
    let is_changed = |file: &Written| !has_content(file.path, file.content);
    let changed: Vec<Written> = files.into_iter().filter(is_changed).collect();
    if arguments.check {
        checked(output, !changed.is_empty())
    } else {
        write_all(&changed, &description.inputs(None))
    }
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
        stale |= is(path, !has_content(path, header.as_bytes()));
    }
    if stale { Err(Failure::Reported) } else { Ok(()) }
}

impl Arguments {
    fn builder(&self, description: &Description) -> Result<Builder, Failure> {
        let builder = self.code.configure(self.robot.builder(description));
        if self.c_header.is_none() || self.code.has("c_functions") {
            return Ok(builder);
        }
        // Without a prefix the functions for C begin with the robot's name.
        let read = description.read(&self.robot.options.read_options());
        let reading = read.map_err(|diagnostics| description.failure(diagnostics))?;
        Ok(builder.c_functions(names::snake(reading.model.name())))
    }
}
