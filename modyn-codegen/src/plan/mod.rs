//! The plan: which programs each function of a robot consists of, with their arguments and results.
//!
//! ```text
//! functions (the table) ─ trace ─▶ graphs ─ passes ─▶ packing: the cheapest ─ program ─▶ Plan ─▶ printers
//! ```
//!
//! All decisions about profit are made here: the partition into modules ([`partition`]), the
//! packing of limbs and columns, and the balancing of sums (`packing`). A back end receives a
//! [`Plan`] and prints it.

mod casadi;
mod choices;
mod code_form;
mod constants;
mod context;
mod dense;
mod entries;
mod factorization;
mod frames;
mod functions;
mod fused;
mod least;
mod limit;
mod looped;
mod packing;
pub mod partition;
mod planned;
mod programs;
mod user;
mod wrapped;

use modyn_runtime::OperationCount;
use modyn_runtime::equations::brge::UduLayout;
use modyn_runtime::model::{Model, ModuleTree};
pub(crate) use modyn_runtime::quantities::ARGUMENTS;
pub use modyn_runtime::quantities::{
    Argument, ArgumentKind, BatchForm, Elements, Function, Record, Row, Shape, Sizes,
};

pub use crate::trace::Gains;
pub use casadi::{CasadiFunction, CasadiMatrix, CasadiPlan};
pub use choices::Choices;
pub use code_form::CodeForm;
pub use constants::{BaseParameterTable, Constants};
pub use context::{LIMB_LIMITS, PlanContext};
pub use entries::{Derivative, DerivativeMode, EntryFunction, EntrySource};
pub use factorization::FactorFunction;
pub use frames::{Frames, LinkProgram};
pub(crate) use functions::signatures;
pub use functions::{CForm, GraphSource, Lowering, Packing, unknown_function};
pub use fused::{FusedFunction, Member, MemberFunction};
pub use limit::{MAX_LINKS, MAX_OPERATIONS, TooLong};
pub use packing::COLUMN_LANES;
pub use planned::{CARRIED, Kernels, PLANNED, Planned};
pub use user::{
    MAX_USER_OPERATIONS, NamedFunction, TracedForm, TracedFunction, UserForm, UserPlanError,
};

use crate::passes::optimize;
use crate::program::{Execution, InvalidProgram, Program};
use crate::trace::Parameters;
use context::SymbolicRobot;
use limit::Budget;
use partition::ChosenPartition;
use programs::ScalarGraphs;

/// The programs of a robot.
pub struct Plan {
    /// The choices of the user.
    pub choices: Choices,
    /// The functions of one state, in the order of [`Function::ALL`]; then the fused functions and
    /// the user's functions.
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
    /// The entries of `qd` that would move no inertia if all run-time inertias were zero; and the
    /// program that computes the inertia at each of them, from the scalar's precision and the
    /// parameters. `None` if there are no such entries.
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
    /// Returns the plan of `model`'s functions for a back end that runs them in this way; `modules`
    /// is the user's partition. For [`Execution::Simd`] functions of many states have programs as
    /// well.
    ///
    /// # Errors
    ///
    /// If the functions take more than [`MAX_OPERATIONS`].
    pub fn new(
        model: &Model,
        modules: &ModuleTree,
        choices: &Choices,
        execution: Execution,
    ) -> Result<Self, TooLong> {
        Ok(Self::traced(model, modules, choices, execution, |_, _| Ok(()))?.0)
    }

    /// Returns the plan of `model`'s functions for `CasADi`, with their derivatives: the selected
    /// ones that `CasADi` can have.
    ///
    /// # Errors
    ///
    /// If the functions take more than [`MAX_OPERATIONS`].
    pub fn for_casadi(
        model: &Model,
        modules: &ModuleTree,
        choices: &Choices,
    ) -> Result<Self, TooLong> {
        let straight = Choices {
            functions: Vec::new(),
            share_limbs: false,
            code: CodeForm::Unrolled,
            ..choices.clone()
        };
        let casadi = |context: &PlanContext<'_>, budget: &mut Budget| {
            CasadiPlan::new(context, model, &choices.functions, budget)
        };
        let (plan, casadi) = Self::traced(model, modules, &straight, Execution::Scalar, casadi)?;
        Ok(Self { casadi, ..plan })
    }

    /// Returns the plan of one function of arrays of plain numbers, for a back end with vectors. It
    /// has no function if the function's source is a fused function that is none of `choices`.
    ///
    /// # Errors
    ///
    /// If the function takes more than [`MAX_OPERATIONS`].
    pub fn for_entries(
        model: &Model,
        modules: &ModuleTree,
        choices: &Choices,
        execution: Execution,
        function: &EntryFunction,
    ) -> Result<Self, TooLong> {
        let none = Choices {
            functions: Vec::new(),
            fused: Vec::new(),
            user_functions: Vec::new(),
            ..choices.clone()
        };
        let source = function.source(&choices.fused);
        let planned = |context: &PlanContext<'_>, budget: &mut Budget| {
            let planned = source.map(|source| {
                let plan = || Planned::entries(function, source, context);
                budget.spend(source.name(), source.least_operations(context), plan, Planned::length)
            });
            planned.transpose()
        };
        let (mut plan, planned) = Self::traced(model, modules, &none, execution, planned)?;
        plan.functions.extend(planned);
        Ok(plan)
    }

    /// Returns the plan of the chosen functions, and further programs from the same inputs of
    /// tracing.
    fn traced<T>(
        model: &Model,
        modules: &ModuleTree,
        choices: &Choices,
        execution: Execution,
        further: impl FnOnce(&PlanContext<'_>, &mut Budget) -> Result<T, TooLong>,
    ) -> Result<(Self, T), TooLong> {
        let batches = execution == Execution::Simd;
        if model.moving_links().len() > MAX_LINKS {
            return Err(TooLong::Robot);
        }
        let robot = SymbolicRobot::new(model, choices.parameters(model));
        let mut budget = Budget::new();
        let context = PlanContext::new(&robot, model, modules, execution, choices.code());
        let sizes = context.sizes;
        let is_selected = |function: &Function| {
            let row = function.row();
            choices.functions.contains(function)
                && (batches || row.batch_of.is_none())
                && function.fits(&sizes)
        };
        let selected: Vec<Function> = Function::ALL.iter().copied().filter(is_selected).collect();
        let mut graphs = ScalarGraphs::new(&selected);
        let mut many = Vec::new();
        let mut functions = Vec::new();
        for &function in &selected {
            let least = context.least_operations(function);
            let plan = || Planned::new(function, &context, &mut graphs);
            let planned = budget.spend(function.name(), least, plan, Planned::length)?;
            if planned.batch_of.is_some() { &mut many } else { &mut functions }.push(planned);
        }
        let length = |(one, of_many): &(Planned, Option<Planned>)| {
            one.length() + of_many.as_ref().map_or(0, Planned::length)
        };
        for fused in &choices.fused {
            let least = context.least_operations_fused(fused);
            let plan = || Planned::fused(fused, &context, batches && fused.batch);
            let (one, of_many) = budget.spend(fused.name, least, plan, length)?;
            functions.push(one);
            many.extend(of_many);
        }
        for user in &choices.user_functions {
            for form in &user.forms {
                let plan = || Planned::user(user, form, &context, batches && user.batch);
                let (one, of_many) = budget.spend(form.name, 0, plan, length)?;
                functions.push(one);
                many.extend(of_many);
            }
        }
        let members = choices.fused.iter().flat_map(|fused| &fused.members);
        let fused = members.filter_map(|member| member.function.of_table());
        let mut all = selected.iter().copied().chain(fused);
        let factorizes = all.any(|f| matches!(f, Function::Brge | Function::BrgeBatch));
        let factorization = match factorizes {
            true => {
                let plan = || factorization::plan(&context.tracer, &context.layout, &sizes);
                let length = |functions: &Vec<FactorFunction>| {
                    let operations =
                        functions.iter().map(|f| f.program.static_operations().total());
                    operations.sum()
                };
                budget.spend(Function::Brge.name(), 0, plan, length)?
            }
            false => Vec::new(),
        };
        let pivots = context.tracer.inertia_pivots().map(|(entries, graph)| {
            let arguments = 1 + robot.parameters.len();
            (entries, Program::new(&optimize(graph), arguments, Execution::Scalar))
        });
        let further = further(&context, &mut budget)?;
        let PlanContext { layout, forward_dynamics, .. } = context;
        let ChosenPartition { modules: elimination_modules, candidates, .. } = forward_dynamics;
        let SymbolicRobot { parameters, frames, .. } = robot;
        let plan = Self {
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
            casadi: CasadiPlan::default(),
            candidates,
        };
        Ok((plan, further))
    }

    /// Returns the operations of one call of each function, by name.
    #[must_use]
    pub fn operations_per_call(&self) -> Vec<(&'static str, OperationCount)> {
        let planned = self.functions.iter().chain(&self.batches);
        planned.map(|planned| (planned.name, planned.operations_per_call())).collect()
    }

    /// Returns the operations of one call on vectors of each function that has a program
    /// on vectors, by name.
    #[must_use]
    pub fn operations_in_lanes(&self) -> Vec<(&'static str, OperationCount)> {
        let in_lanes = |planned: &Planned| match &planned.kernels {
            Kernels::Straight { simd: Some(simd), .. } => {
                Some((planned.name, simd.operations_per_call()))
            }
            _ => None,
        };
        self.functions.iter().filter_map(in_lanes).collect()
    }

    /// Returns the functions whose packed programs are invalid, by name: each has its
    /// program on scalars alone. There are none unless modyn has a fault.
    pub fn faults(&self) -> impl Iterator<Item = (&'static str, &InvalidProgram)> {
        self.functions.iter().filter_map(|planned| Some((planned.name, planned.fault.as_ref()?)))
    }

    /// Returns the functions that have loops in place of straight-line code, by name: which loops,
    /// and why. Machine code has none.
    #[must_use]
    pub fn loops(&self) -> Vec<(&'static str, String)> {
        if self.choices.machine_code {
            return Vec::new();
        }
        let loops_of = |planned: &Planned| {
            let Kernels::Straight { scalar, .. } = &planned.kernels else { return None };
            if let Some(loops) = dense::loops(scalar) {
                return Some((planned.name, loops));
            }
            if planned.function.is_some_and(|function| function.row().has_solver) {
                return Some((planned.name, "loops for the iterations of its solver".into()));
            }
            // Equal limbs that share code read no arguments in their loops.
            if scalar.loops().all(|loops| loops.arguments().is_empty()) {
                return None;
            }
            let limit = looped::MAX_STRAIGHT;
            let why = match self.choices.code {
                CodeForm::Looped => "the option `code` is `looped`".to_string(),
                _ => format!("straight-line code would have more than {limit} operations"),
            };
            Some((planned.name, format!("loops over the bodies, since {why}")))
        };
        self.functions.iter().filter_map(loops_of).collect()
    }

    /// Returns the operations of all programs of each function of one state, by name.
    #[must_use]
    pub fn static_operations(&self) -> Vec<(&'static str, OperationCount)> {
        self.functions.iter().map(|planned| (planned.name, planned.static_operations())).collect()
    }
}
