//! Back ends: from a [`Plan`] to text, one folder for each language. Back ends make no decisions.

mod c;
mod gpu;
mod rust;

pub use c::CSource;
pub use gpu::{GpuArgument, GpuKernel, GpuLanguage, GpuSource};

use modyn_runtime::OperationCount;
use modyn_runtime::model::{Model, ModuleTree};

use crate::diagnostics::Diagnostic;
use crate::names;
use crate::plan::{Bundle, Choices, Function, Plan, Planned, Strategy};

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

/// The options that the text depends on, besides the model.
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
    /// The prefix of functions for C; `None` for no such functions.
    pub c_prefix: Option<String>,
    /// The selected functions.
    pub functions: Vec<Function>,
    /// The bundles of functions.
    pub bundles: Vec<Bundle>,
    /// Whether gravity is an argument.
    pub runtime_gravity: bool,
    /// Whether equal limbs share one function.
    pub share: bool,
    /// The links whose own inertia is an argument, as indices into the model's frames.
    pub runtime_inertia: Vec<usize>,
    /// The links with a payload that is an argument, as indices into the model's frames.
    pub payload: Vec<usize>,
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
            c_prefix: None,
            functions: Function::DEFAULT.to_vec(),
            bundles: Vec::new(),
            runtime_gravity: false,
            share: false,
            runtime_inertia: Vec::new(),
            payload: Vec::new(),
            warnings: Vec::new(),
        }
    }
}

impl EmitOptions {
    /// Returns the plan for these options. Self-contained files have neither vectors nor batches, which need the runtime.
    pub(crate) fn plan(&self, model: &Model, modules: &ModuleTree) -> Plan {
        let strategy = match (self.share, self.self_contained) {
            (true, _) => Strategy::Routines,
            (false, true) => Strategy::Scalar,
            (false, false) => Strategy::Vectors,
        };
        self.plan_by(model, modules, strategy)
    }

    fn plan_by(&self, model: &Model, modules: &ModuleTree, strategy: Strategy) -> Plan {
        let choices = Choices {
            functions: &self.functions,
            bundles: &self.bundles,
            strategy,
            batches: !self.self_contained && strategy != Strategy::Threads,
            runtime_gravity: self.runtime_gravity,
            runtime_inertia: &self.runtime_inertia,
            payload: &self.payload,
        };
        Plan::new(model, modules, &choices)
    }

    /// Returns the type's name.
    fn type_name(&self, model: &Model) -> String {
        self.type_name.clone().unwrap_or_else(|| names::type_name(model.name()))
    }
}

/// The generated text, and information about it.
#[non_exhaustive]
pub struct Emitted {
    /// Rust items.
    pub text: String,
    /// The header of the functions for C; `None` without such functions.
    pub c_header: Option<String>,
    /// The name of the type.
    pub type_name: String,
    /// The operations of one call of each function, by name.
    pub operations: Vec<(&'static str, OperationCount)>,
    /// The operations in the text of each function of one state, by name.
    pub static_operations: Vec<(&'static str, OperationCount)>,
    /// The modules of forward dynamics, and the operations of each candidate.
    pub partition: (ModuleTree, Vec<(&'static str, usize)>),
}

/// Returns the Rust text of `model`.
#[must_use]
pub fn emit(model: &Model, modules: &ModuleTree, options: &EmitOptions) -> Emitted {
    let (plan, type_name) = (options.plan(model, modules), options.type_name(model));
    let per_call = |p: &Planned| (p.name, p.operations_per_call());
    let operations = plan.functions.iter().chain(&plan.batches).map(per_call).collect();
    let all = |p: &Planned| (p.name, p.static_operations());
    let static_operations = plan.functions.iter().map(all).collect();
    let (text, c_header) = rust::print((model, modules), &plan, options, &type_name);
    let partition = (plan.eliminated, plan.candidates);
    Emitted { text, c_header, type_name, operations, static_operations, partition }
}

/// Returns the C99 text of `model`: a header and a source file. `header` is the name of the header's file; by default it
/// is derived from the type's name. Equal limbs share one function if `options` select it.
#[must_use]
pub fn emit_c(
    model: &Model,
    modules: &ModuleTree,
    options: &EmitOptions,
    header: Option<&str>,
) -> CSource {
    // C has neither vectors nor batches.
    let options = EmitOptions { self_contained: true, ..options.clone() };
    let prefix = names::snake(&options.type_name(model));
    let header = header.map_or_else(|| format!("{prefix}.h"), String::from);
    c::print(&options.plan(model, modules), model, (&prefix, &header), options.scalar)
}

/// Compiles `model` to kernels for graphics processors, whose names begin with the type's name in snake case.
#[must_use]
pub fn emit_gpu(
    model: &Model,
    modules: &ModuleTree,
    options: &EmitOptions,
    language: GpuLanguage,
) -> GpuSource {
    let prefix = names::snake(&options.type_name(model));
    let plan = options.plan_by(model, modules, Strategy::Threads);
    gpu::print(&plan, model, &prefix, language, options.scalar)
}
