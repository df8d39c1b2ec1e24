//! The plan: which programs each function of a robot consists of, with their arguments and results.
//!
//! ```text
//! functions (the table) ─ trace ─▶ graphs ─ passes ─▶ packing: the cheapest ─ program ─▶ Plan ─▶ printers
//! ```
//!
//! All decisions about profit are made here: the partition into modules ([`partition`]), the packing of limbs and
//! columns, and the balancing of sums (`packing`). A back end receives a [`Plan`] and prints it.

mod bundle;
mod casadi;
mod choices;
mod code_form;
mod constants;
mod factorization;
mod frames;
mod functions;
mod looped;
mod measures;
mod packing;
pub mod partition;
mod planned;
mod programs;
mod tracing;
mod user;
mod wrapped;

use modyn_runtime::OperationCount;
use modyn_runtime::equations::brge::UduLayout;
use modyn_runtime::model::{Model, ModuleTree};
pub(crate) use modyn_runtime::quantities::ARGUMENTS;
pub use modyn_runtime::quantities::{
    Argument, ArgumentKind, BatchForm, Elements, Function, Record, Row, Shape, Sizes,
};

pub use bundle::{Bundle, Member, MemberFunction};
pub use casadi::{CasadiFunction, CasadiMatrix, CasadiPlan};
pub use choices::Choices;
pub use code_form::CodeForm;
pub use constants::{BaseParameterTable, Constants};
pub use factorization::FactorFunction;
pub use frames::{Frames, LinkProgram};
pub use functions::{CForm, GraphSource, Lowering, Packing, unknown_function};
pub(crate) use functions::{estimated_length, signatures};
pub use measures::Measures;
pub use packing::COLUMN_LANES;
pub use planned::{Kernels, Planned};
pub use tracing::{LIMB_LIMITS, Tracing};
pub use user::{
    MAX_USER_OPERATIONS, NamedFunction, TracedForm, TracedFunction, UserForm, UserPlanError,
};

use crate::passes::optimize;
use crate::program::{Execution, InvalidProgram, Program};
use crate::trace::Parameters;
use partition::ChosenPartition;
use programs::ScalarGraphs;
use tracing::TracedRobot;

/// The programs of a robot.
pub struct Plan {
    /// The choices of the user.
    pub choices: Choices,
    /// The functions of one state, in the order of [`Function::ALL`]; then the bundles and the user's functions.
    pub functions: Vec<Planned>,
    /// The functions of many states, in this order.
    pub batches: Vec<Planned>,
    /// The functions of the mass matrix's factors; empty unless a function returns the factors.
    pub factorization: Vec<FactorFunction>,
    /// The layout of the factors.
    pub layout: UduLayout,
    /// The sizes of the robot.
    pub sizes: Sizes,
    /// The run-time parameters.
    pub parameters: Parameters,
    /// The entries of `qd` that would move no inertia if all run-time inertias were zero; and the program that computes
    /// the inertia at each of them, from the scalar's precision and the parameters. `None` if there are no such entries.
    pub inertia_pivots: Option<(Vec<usize>, Program)>,
    /// The links, grouped by their programs.
    pub frames: Frames,
    /// The modules of forward dynamics.
    pub elimination_modules: ModuleTree,
    /// The functions of `CasADi`; empty for other back ends.
    pub casadi: CasadiPlan,
    /// The partitions that were considered, with their operations; the chosen one is first.
    pub candidates: Vec<(&'static str, usize)>,
}

impl Plan {
    /// Returns the plan of `model`'s functions for a back end that runs them in this way; `modules` is the user's partition.
    /// For [`Execution::Simd`] functions of many states have programs as well.
    #[must_use]
    pub fn new(
        model: &Model,
        modules: &ModuleTree,
        choices: &Choices,
        execution: Execution,
    ) -> Self {
        Self::traced(model, modules, choices, execution, |_| CasadiPlan::default())
    }

    /// Returns the plan of `model`'s functions for `CasADi`, with their derivatives: the selected ones that `CasADi` can have.
    #[must_use]
    pub fn for_casadi(model: &Model, modules: &ModuleTree, choices: &Choices) -> Self {
        let straight = Choices {
            functions: Vec::new(),
            share: false,
            code: CodeForm::Fast,
            ..choices.clone()
        };
        let casadi = |tracing: &Tracing<'_>| CasadiPlan::new(tracing, model, &choices.functions);
        Self::traced(model, modules, &straight, Execution::Scalar, casadi)
    }

    fn traced(
        model: &Model,
        modules: &ModuleTree,
        choices: &Choices,
        execution: Execution,
        casadi: impl Fn(&Tracing<'_>) -> CasadiPlan,
    ) -> Self {
        let batches = execution == Execution::Simd;
        let robot = TracedRobot::new(model, choices.parameters(model));
        let tracing =
            Tracing::new(&robot, (model, modules), execution, (choices.share, choices.code));
        let sizes = tracing.sizes;
        let selected = |function: &Function| {
            let row = function.row();
            choices.functions.contains(function)
                && (batches || row.batch_of.is_none())
                && function.fits(sizes.constraints)
        };
        let selected: Vec<Function> = Function::ALL.iter().copied().filter(selected).collect();
        let mut graphs = ScalarGraphs::new(&selected);
        let planned = |&function: &Function| Planned::new(function, &tracing, &mut graphs);
        let (mut many, mut functions): (Vec<Planned>, Vec<Planned>) =
            selected.iter().map(planned).partition(|planned| planned.batch_of.is_some());
        for bundle in &choices.bundles {
            let batch = batches && bundle.batch;
            let (one, of_many) = Planned::bundle(bundle, &tracing, batch);
            functions.push(one);
            many.extend(of_many);
        }
        for user in &choices.user_functions {
            for form in &user.forms {
                let (one, of_many) = Planned::user(user, form, &tracing, batches && user.batch);
                functions.push(one);
                many.extend(of_many);
            }
        }
        let bundled = choices.bundles.iter().flat_map(|bundle| &bundle.members);
        let bundled = bundled.filter_map(|member| member.function.of_table());
        let mut all = selected.iter().copied().chain(bundled);
        let factorizes = all.any(|f| matches!(f, Function::Brge | Function::BrgeBatch));
        let factorization = match factorizes {
            true => factorization::plan(&tracing.tracer, &tracing.layout, &sizes),
            false => Vec::new(),
        };
        let pivots = tracing.tracer.inertia_pivots().map(|(entries, graph)| {
            let arguments = 1 + robot.parameters.len();
            (entries, Program::new(&optimize(graph), arguments, Execution::Scalar))
        });
        let casadi = casadi(&tracing);
        let Tracing { layout, forward_dynamics, .. } = tracing;
        let ChosenPartition { modules: elimination_modules, candidates, .. } = forward_dynamics;
        let TracedRobot { parameters, frames, .. } = robot;
        Self {
            choices: choices.clone(),
            functions,
            batches: many,
            factorization,
            layout,
            sizes,
            parameters,
            inertia_pivots: pivots,
            frames,
            elimination_modules,
            casadi,
            candidates,
        }
    }

    /// Returns the operations of one call of each function and bundle, by name.
    #[must_use]
    pub fn operations_per_call(&self) -> Vec<(&'static str, OperationCount)> {
        let planned = self.functions.iter().chain(&self.batches);
        planned.map(|planned| (planned.name, planned.operations_per_call())).collect()
    }

    /// Returns the functions and bundles whose packed programs are invalid, by name: each has its program on scalars alone. There
    /// are none unless modyn has a fault.
    pub fn faults(&self) -> impl Iterator<Item = (&'static str, &InvalidProgram)> {
        self.functions.iter().filter_map(|planned| Some((planned.name, planned.fault.as_ref()?)))
    }

    /// Returns the operations of all programs of each function and bundle of one state, by name.
    #[must_use]
    pub fn static_operations(&self) -> Vec<(&'static str, OperationCount)> {
        self.functions.iter().map(|planned| (planned.name, planned.static_operations())).collect()
    }
}
