//! Back ends: from a [`Plan`] to text, one folder for each language ([`Target`]), which implements
//! [`Backend`]. Back ends make no decisions.
//!
//! The same input gives the same bytes on every host. Constants are folded through `libm`, and
//! nothing depends on an address or on the order of a hash map. Sines of `f64` use fused products
//! where the target has them, so numbers in the text that come from equations (base parameters, the
//! condition number, the mobilities of `step`, inertias in the laws of an MJCF) are computed on
//! `Portable`, which never fuses. `lab/check` compares the text
//! of all robots from compilers built with and without fused products.
//!
//! Helper types begin with two underscores (`names::helper_type`), which no robot's type does.
//! Entries of parameters are called `q_0`, temporaries `x0` (`Parameter::entry`).

mod c;
mod c_types;
mod casadi;
mod gpu;
mod indices;
mod matlab;
pub(crate) mod rust;
mod statements;
mod support;

pub use gpu::{
    GpuArgument, GpuKernel, GpuLanguage, GpuRollout, RolloutBuffer, RolloutForces, RolloutOptions,
    RolloutSource,
};

use modyn_read::diagnostics::Diagnostic;
use modyn_runtime::model::{Model, ModuleTree};
use modyn_runtime::{ConstraintSettings, ContactTarget, StepSettings};

use crate::names;
use crate::plan::{ArgumentKind, Choices, Function, Plan, Planned, TooLong};
use crate::program::Execution;

/// The scalar of the generated type's own functions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FloatType {
    /// Double precision.
    #[default]
    F64,
    /// Single precision.
    F32,
}

impl FloatType {
    /// Returns the scalar's name in Rust.
    fn name(self) -> &'static str {
        match self {
            Self::F64 => "f64",
            Self::F32 => "f32",
        }
    }

    /// Returns the scalar's name in C.
    fn in_c(self) -> &'static str {
        match self {
            Self::F64 => "double",
            Self::F32 => "float",
        }
    }

    /// Returns the settings of constraints or of steps that a robot has by default, as numbers in
    /// the order of the argument. The tolerances are within the reach of the scalar. Other arguments
    /// have no settings: `None`.
    #[must_use]
    pub fn default_settings(self, kind: ArgumentKind, model: &Model) -> Option<Vec<f64>> {
        match kind {
            ArgumentKind::StepSettings => {
                let mut settings = model.step_settings();
                if self == Self::F32 {
                    settings.tolerance = StepSettings::<f32>::DEFAULT.tolerance.into();
                }
                Some(settings.all_numbers())
            }
            ArgumentKind::Settings => {
                let settings = match self {
                    Self::F64 => ConstraintSettings::<f64>::DEFAULT.numbers(),
                    Self::F32 => ConstraintSettings::<f32>::DEFAULT.numbers().map(f64::from),
                };
                let targets = ContactTarget::<f64>::GROUND.numbers().repeat(model.contacts().len());
                Some([settings.to_vec(), targets].concat())
            }
            _ => None,
        }
    }
}

/// Returns the documentation of the number of coordinates, for headers.
fn coordinates_in_c(model: &Model) -> &'static str {
    if model.quaternions().next().is_some() {
        "The length of the coordinate vector. Quaternions in it must have length 1; nothing checks them."
    } else {
        "The length of the coordinate vector."
    }
}

/// The options that the text depends on, besides the plan.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct EmitOptions {
    /// The name of the type; `None` derives it from the model's name.
    pub type_name: Option<String>,
    /// The visibility of the type: `pub`, `pub(crate)` or nothing.
    pub visibility: String,
    /// The path of the crate `modyn`.
    pub crate_path: String,
    /// The scalar of the type's own functions.
    pub scalar: FloatType,
    /// Whether the text carries the parts of the runtime that it needs, and depends on `core` only.
    pub self_contained: bool,
    /// Whether the type has the robot's description.
    pub embed_model: bool,
    /// The prefix of functions for C; `None` for no such functions.
    pub c_prefix: Option<String>,
    /// The warnings about the description, for the documentation.
    pub warnings: Vec<Diagnostic>,
}

impl Default for EmitOptions {
    fn default() -> Self {
        Self {
            type_name: None,
            visibility: "pub".into(),
            crate_path: "::modyn".into(),
            scalar: FloatType::default(),
            self_contained: false,
            embed_model: false,
            c_prefix: None,
            warnings: Vec::new(),
        }
    }
}

impl EmitOptions {
    /// Returns the type's name.
    pub(crate) fn type_name(&self, model: &Model) -> String {
        self.type_name.clone().unwrap_or_else(|| names::type_name(model.name()))
    }

    /// Returns the prefix of functions outside of Rust: the type's name in snake case.
    pub(crate) fn prefix(&self, model: &Model) -> String {
        names::snake(&self.type_name(model))
    }
}

/// The machine code in an object file, as texts that call it must know it.
#[derive(Clone, Debug)]
pub struct MachineCode {
    /// The prefix of the functions' symbols.
    pub prefix: String,
    /// The target.
    pub target: MachineTarget,
    /// The instructions that processors of the target may lack, in words; empty if there are none.
    pub needs: &'static str,
    /// The names of these instruction sets in Rust (`target_feature`).
    pub features: &'static [&'static str],
}

/// The target of machine code.
#[derive(Clone, Copy, Debug)]
pub struct MachineTarget {
    /// The name of the target in words.
    pub words: &'static str,
    /// The condition (`cfg`) of Rust that holds for the target.
    pub cfg: &'static str,
}

/// A generated file.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct File {
    /// The path, relative to the folder of all files.
    pub name: String,
    /// The text.
    pub text: String,
}

impl File {
    fn new(name: impl Into<String>, text: impl Into<String>) -> Self {
        Self { name: name.into(), text: text.into() }
    }
}

/// A robot with its programs, as back ends print it.
#[derive(Clone, Copy)]
#[non_exhaustive]
pub struct PlannedRobot<'a> {
    /// The robot.
    pub model: &'a Model,
    /// The user's partition into modules.
    pub modules: &'a ModuleTree,
    /// The programs.
    pub plan: &'a Plan,
    /// The options that the text depends on.
    pub options: &'a EmitOptions,
    /// The name of the files, without an ending.
    pub stem: &'a str,
}

impl PlannedRobot<'_> {
    /// Returns the prefix of names outside of Rust: the type's name in snake case.
    #[must_use]
    pub fn prefix(&self) -> String {
        self.options.prefix(self.model)
    }
}

/// An option that a language does not have.
#[derive(Clone, Copy, Debug)]
pub struct Refused {
    /// The option's name; `function` for the user's functions.
    pub option: &'static str,
    /// The message of the error.
    pub message: &'static str,
    /// The remedy.
    pub help: &'static str,
}

/// A back end: how it runs programs, which options and functions it does not have, and the printer.
pub trait Backend: Sync {
    /// Returns the way that programs run.
    fn execution(&self, options: &EmitOptions) -> Execution;

    /// Prints a robot: all files, the main one first.
    fn print(&self, robot: &PlannedRobot<'_>) -> Vec<File>;

    /// Returns the text of a file with a comment on its origin.
    fn with_origin(&self, text: &str, origin: &str) -> String;

    /// Returns the plan of a robot.
    fn plan(
        &self,
        model: &Model,
        modules: &ModuleTree,
        choices: &Choices,
        options: &EmitOptions,
    ) -> Result<Plan, TooLong> {
        Plan::new(model, modules, choices, self.execution(options))
    }

    /// Returns the scalar of the text, for the scalar that the user chose.
    fn scalar(&self, chosen: FloatType) -> FloatType {
        chosen
    }

    /// Returns the options that are errors.
    fn refused(&self) -> &'static [Refused] {
        &[]
    }

    /// Returns a replacement for a function that the language does not have; `None` for the
    /// functions that it has.
    fn lacks(&self, _: Function) -> Option<&'static str> {
        None
    }

    /// Returns the kernels of a text for graphics processors; none for other languages.
    fn kernels(&self, _: &PlannedRobot<'_>) -> Vec<GpuKernel> {
        Vec::new()
    }
}

/// A language of generated code.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Target {
    /// Rust: the type of a robot.
    #[default]
    Rust,
    /// C99 that needs `<math.h>` only: a source file and a header.
    C,
    /// C++17 over the functions of C: a header with a class that takes and returns matrices of
    /// Eigen, and the two files of C.
    Cpp,
    /// CUDA C++, for NVRTC or nvcc: a kernel for each function, with a thread for each state.
    Cuda,
    /// WGSL, for `WebGPU`, in single precision: a kernel for each function, with a thread for each
    /// state.
    Wgsl,
    /// C99 for `casadi.external`: functions with all derivatives.
    Casadi,
    /// MATLAB, which GNU Octave runs as well: a package with a file for each function, for one
    /// state or many.
    Matlab,
}

impl Target {
    /// All languages.
    pub const ALL: [Self; 7] =
        [Self::Rust, Self::C, Self::Cpp, Self::Cuda, Self::Wgsl, Self::Casadi, Self::Matlab];

    /// Returns the name of the option `target` of the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.row().0
    }

    /// Returns the name in texts.
    #[must_use]
    pub fn title(self) -> &'static str {
        self.row().1
    }

    /// Returns the back end.
    #[must_use]
    pub fn backend(self) -> &'static dyn Backend {
        self.row().2
    }

    fn row(self) -> (&'static str, &'static str, &'static dyn Backend) {
        match self {
            Self::Rust => ("rust", "Rust", &rust::Rust),
            Self::C => ("c", "C", &c::C),
            Self::Cpp => ("cpp", "C++", &c::Cpp),
            Self::Cuda => ("cuda", "CUDA", &gpu::Gpu(GpuLanguage::Cuda)),
            Self::Wgsl => ("wgsl", "WGSL", &gpu::Gpu(GpuLanguage::Wgsl)),
            Self::Casadi => ("casadi", "CasADi", &casadi::Casadi),
            Self::Matlab => ("matlab", "MATLAB", &matlab::Matlab),
        }
    }
}

impl From<GpuLanguage> for Target {
    fn from(language: GpuLanguage) -> Self {
        match language {
            GpuLanguage::Cuda => Self::Cuda,
            GpuLanguage::Wgsl => Self::Wgsl,
        }
    }
}

/// Returns the Rust text of a robot whose functions are in an object file.
#[must_use]
pub fn emit_wrapper(robot: &PlannedRobot<'_>, code: &MachineCode) -> String {
    rust::print_for_object(robot, code)
}

/// Returns the C header of a robot whose functions are in an object file.
#[must_use]
pub fn emit_object_header(robot: &PlannedRobot<'_>, code: &MachineCode) -> String {
    c::print_object_header(robot, code)
}

/// Returns the CUDA text of a function of arrays, as [`Builder::emit_rows`](crate::Builder::emit_rows)
/// documents it.
pub(crate) fn emit_rows(planned: &Planned, lengths: [&[usize]; 2], float: FloatType) -> String {
    gpu::print_rows(planned, lengths, float)
}

/// Returns kernels for graphics processors that integrate motions over many time steps, whose names
/// begin with the type's name in snake case.
#[must_use]
pub fn emit_rollouts(
    robot: &PlannedRobot<'_>,
    language: GpuLanguage,
    rollouts: &RolloutOptions,
) -> RolloutSource {
    gpu::print_rollout(robot, language, rollouts)
}
