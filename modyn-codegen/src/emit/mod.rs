//! Back ends: from a [`Plan`] to text. Each language has a folder, which decides nothing.

mod c;
mod gpu;
mod rust;

pub use c::CSource;
pub use gpu::{GpuArgument, GpuKernel, GpuLanguage, GpuSource};

use modyn_runtime::OperationCount;
use modyn_runtime::model::{Model, ModuleTree};

use crate::diagnostics::Diagnostic;
use crate::names;
use crate::plan::{Choices, Function, Plan, Planned, Strategy};

/// The scalar that generated functions are concrete in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FloatType {
    /// Double precision.
    #[default]
    F64,
    /// Single precision.
    F32,
}

impl FloatType {
    /// Its name in Rust.
    fn name(self) -> &'static str {
        match self {
            Self::F64 => "f64",
            Self::F32 => "f32",
        }
    }
}

/// The options that the text depends on besides the model.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct EmitOptions {
    /// The name of the type; made from the model's name if `None`.
    pub type_name: Option<String>,
    /// Its visibility: `pub`, `pub(crate)` or nothing.
    pub visibility: String,
    /// The path of the crate `modyn`.
    pub krate: String,
    /// The scalar of the type's own functions.
    pub float: FloatType,
    /// Whether the text carries the part of the runtime that it needs, and depends on `core` alone.
    pub self_contained: bool,
    /// The prefix of functions that C can call; there are none if `None`.
    pub c_prefix: Option<String>,
    /// The functions that it has.
    pub functions: Vec<Function>,
    /// Whether gravity is an argument.
    pub runtime_gravity: bool,
    /// Whether equal limbs run through one function.
    pub share: bool,
    /// The links, as indices into the model's frames, whose own inertia is an argument.
    pub runtime_inertia: Vec<usize>,
    /// The links, as indices into the model's frames, to which an inertia is added that is an argument.
    pub payload: Vec<usize>,
    /// Warnings about the description, for the documentation.
    pub warnings: Vec<Diagnostic>,
}

impl Default for EmitOptions {
    fn default() -> Self {
        Self {
            type_name: None,
            visibility: "pub".into(),
            krate: "::modyn".into(),
            float: FloatType::default(),
            self_contained: false,
            c_prefix: None,
            functions: Function::DEFAULT.to_vec(),
            runtime_gravity: false,
            share: false,
            runtime_inertia: Vec::new(),
            payload: Vec::new(),
            warnings: Vec::new(),
        }
    }
}

impl EmitOptions {
    /// The plan for these options. A file of its own has neither vectors nor batches, which are the runtime's.
    fn plan(&self, model: &Model, modules: &ModuleTree) -> Plan {
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
            strategy,
            batches: !self.self_contained && strategy != Strategy::Threads,
            runtime_gravity: self.runtime_gravity,
            runtime_inertia: &self.runtime_inertia,
            payload: &self.payload,
        };
        Plan::new(model, modules, &choices)
    }

    /// The type's name.
    fn type_name(&self, model: &Model) -> String {
        self.type_name.clone().unwrap_or_else(|| names::type_name(model.name()))
    }
}

/// The text, and what is worth reporting about it.
#[non_exhaustive]
pub struct Emitted {
    /// Rust items.
    pub text: String,
    /// The header of the functions for C, if there are some.
    pub c_header: Option<String>,
    /// The name of the type.
    pub type_name: String,
    /// The operations of a call of each function, by name.
    pub operations: Vec<(&'static str, OperationCount)>,
    /// The operations in the text of each function of one state, by name: all that it may call.
    pub static_operations: Vec<(&'static str, OperationCount)>,
    /// The modules of the forward recursion, and the operations of each candidate.
    pub partition: (ModuleTree, Vec<(&'static str, usize)>),
}

/// Compiles `model` to Rust.
#[must_use]
pub fn emit(model: &Model, modules: &ModuleTree, options: &EmitOptions) -> Emitted {
    let (plan, type_name) = (options.plan(model, modules), options.type_name(model));
    let per_call = |p: &Planned| (p.function.name(), p.operations_per_call());
    let operations = plan.functions.iter().chain(&plan.batches).map(per_call).collect();
    let all = |p: &Planned| (p.function.name(), p.static_operations());
    let static_operations = plan.functions.iter().map(all).collect();
    let (text, c_header) = rust::print((model, modules), &plan, options, &type_name);
    let partition = (plan.eliminated, plan.candidates);
    Emitted { text, c_header, type_name, operations, static_operations, partition }
}

/// Compiles `model` to C99: a header and a source file. Equal limbs run through one function if `options` say so. The
/// header file is called `header`; by default after the robot's type.
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
    c::print(&options.plan(model, modules), model, (&prefix, &header), options.float)
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
    gpu::print(&plan, model, &prefix, language, options.float)
}
