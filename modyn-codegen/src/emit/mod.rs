//! Back ends: from a [`Plan`] to text, one folder for each language. Back ends make no decisions.

mod c;
mod casadi;
mod gpu;
pub(crate) mod rust;
mod support;

pub use c::CSource;
pub use casadi::CasadiSource;
pub use gpu::{
    GpuArgument, GpuKernel, GpuLanguage, GpuRollout, GpuSource, RolloutBuffer, RolloutForces,
    RolloutOptions, RolloutSource,
};

use modyn_runtime::model::{Model, ModuleTree};

use crate::diagnostics::Diagnostic;
use crate::names;
use crate::plan::{CasadiPlan, Constants, Plan};

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

/// The generated text of a robot.
#[non_exhaustive]
pub struct Emitted {
    /// Rust items.
    pub text: String,
    /// The header of the functions for C; `None` without such functions.
    pub c_header: Option<String>,
    /// The name of the type.
    pub type_name: String,
}

/// Returns the Rust text of a robot with its programs and constants.
#[must_use]
pub fn emit(
    robot: (&Model, &ModuleTree),
    plan: &Plan,
    constants: &Constants,
    options: &EmitOptions,
) -> Emitted {
    let type_name = options.type_name(robot.0);
    let (text, c_header) = rust::print(robot, (plan, constants), options, &type_name);
    Emitted { text, c_header, type_name }
}

/// Returns the C99 text of a robot: a header and a source file. `header` is the name of the header's file; by default it
/// is derived from the type's name.
#[must_use]
pub fn emit_c(model: &Model, plan: &Plan, options: &EmitOptions, header: Option<&str>) -> CSource {
    let prefix = options.prefix(model);
    let header = header.map_or_else(|| format!("{prefix}.h"), String::from);
    c::print(plan, model, (&prefix, &header), options.scalar)
}

/// Returns the Rust text of a robot whose functions are in an object file.
#[must_use]
pub fn emit_wrapper(
    robot: (&Model, &ModuleTree),
    plan: &Plan,
    constants: &Constants,
    options: &EmitOptions,
    code: &MachineCode,
) -> String {
    rust::print_for_object(robot, (plan, constants), options, &options.type_name(robot.0), code)
}

/// Returns the C header of a robot whose functions are in an object file.
#[must_use]
pub fn emit_object_header(
    model: &Model,
    plan: &Plan,
    options: &EmitOptions,
    code: &MachineCode,
) -> String {
    c::print_object_header(plan, model, options.scalar, code)
}

/// Returns kernels of a robot for graphics processors, whose names begin with the type's name in snake case.
#[must_use]
pub fn emit_gpu(
    model: &Model,
    plan: &Plan,
    options: &EmitOptions,
    language: GpuLanguage,
) -> GpuSource {
    let prefix = options.prefix(model);
    gpu::print(plan, model, &prefix, language, options.scalar)
}

/// Returns kernels for graphics processors that integrate motions over many time steps, whose names begin with the type's
/// name in snake case.
#[must_use]
pub fn emit_rollouts(
    model: &Model,
    plan: &Plan,
    options: &EmitOptions,
    language: GpuLanguage,
    rollouts: &RolloutOptions,
) -> RolloutSource {
    let prefix = options.prefix(model);
    gpu::print_rollout(plan, model, &prefix, (language, options.scalar), rollouts)
}

/// Returns the C99 text of the functions that `CasADi` loads. `prefix` is the one of their names.
#[must_use]
pub fn emit_casadi(model: &Model, plan: CasadiPlan, prefix: String) -> CasadiSource {
    casadi::print(plan, model, prefix)
}
