//! The inputs of tracing: a robot with its tracers, its solver and its limbs.

use modyn_runtime::equations::ModulePartition;
use modyn_runtime::equations::brge::UduLayout;
use modyn_runtime::equations::dynamics::Elimination;
use modyn_runtime::mechanism::Mechanism;
use modyn_runtime::model::{Model, ModuleTree};
use modyn_runtime::quantities::Sizes;

use super::code_form::{CodeChoices, CodeForm};
use super::frames::Frames;
use super::partition::{self, ChosenPartition};
use crate::program::Execution;
use crate::trace::{LimbLimits, LimbPacking, Parameters, Tracer};

/// The limits of merging limbs: the lanes of the longest vectors, and for limbs on different bodies
/// the lanes of a vector on most processors. The lanes of a joint that a shorter chain lacks do
/// nothing.
pub const LIMB_LIMITS: LimbLimits = LimbLimits { packed: 8, joined: 4, missing: 2 };

/// A robot in the forms that tracers read.
pub(super) struct SymbolicRobot {
    pub mechanism: Mechanism<f64>,
    /// The links, grouped by their programs.
    pub frames: Frames,
    pub parameters: Parameters,
}

impl SymbolicRobot {
    pub fn new(model: &Model, parameters: Parameters) -> Self {
        let mechanism = Mechanism::new(model);
        Self { frames: Frames::new(&mechanism), mechanism, parameters }
    }

    /// Returns whether all links have their described inertias.
    pub fn is_described(&self) -> bool {
        self.parameters.inertias.is_empty() && self.parameters.payloads.is_empty()
    }

    /// Returns the candidates for packing limbs. Limbs with run-time inertias are never equal; with
    /// gravity compensation, limbs are not packed.
    fn limbs(&self, execution: Execution, share_limbs: bool) -> Vec<LimbPacking> {
        let joins = execution == Execution::Simd && !share_limbs;
        let has_candidates = self.is_described() && !self.mechanism.compensates_gravity();
        match (joins || share_limbs) && has_candidates {
            true => LimbPacking::candidates(&self.mechanism, &LIMB_LIMITS, joins),
            false => Vec::new(),
        }
    }
}

/// The inputs of tracing.
pub struct PlanContext<'a> {
    /// The robot as it is described.
    pub(super) model: &'a Model,
    /// The robot on expressions.
    pub tracer: Tracer<'a>,
    /// The robot on expressions, with all its links. `tracer` has links only if some are run-time
    /// parameters.
    pub all_links: Tracer<'a>,
    /// The links, grouped by their programs.
    pub frames: &'a Frames,
    /// The sizes of the robot.
    pub sizes: Sizes,
    /// The cheapest partition of forward dynamics, with its graph.
    pub forward_dynamics: ChosenPartition,
    /// The solver of forward dynamics.
    pub elimination: Elimination,
    /// The layout of the factorization that users receive.
    pub layout: UduLayout,
    /// The layout of the factorization that derivatives and constrained dynamics use.
    pub for_derivatives: UduLayout,
    /// The way that programs run.
    pub(super) execution: Execution,
    /// Whether equal limbs share one routine, with a table of constants for each limb.
    pub(super) share_limbs: bool,
    /// The form of the code of recursions.
    pub(super) code: CodeForm,
    /// Whether the programs are for machine code.
    pub(super) machine_code: bool,
    /// The candidates for packing limbs.
    pub(super) limbs: Vec<LimbPacking>,
    /// The partitions of forward dynamics to try with packed limbs.
    pub(super) partitions: Vec<ModulePartition>,
    /// Whether no limb moves another limb.
    pub(super) independent: bool,
}

impl<'a> PlanContext<'a> {
    /// Returns the inputs of tracing `robot` for a back end that runs programs in this way.
    /// `modules` is the user's partition.
    pub(super) fn new(
        robot: &'a SymbolicRobot,
        model: &'a Model,
        modules: &ModuleTree,
        execution: Execution,
        choices: CodeChoices,
    ) -> Self {
        let CodeChoices { share_limbs, form: code, machine_code } = choices;
        // Threads run straight-line code, one limb after another.
        let has_threads = execution == Execution::Threads;
        let share_limbs = share_limbs && !has_threads;
        let code = if has_threads { CodeForm::Unrolled } else { code };
        let limbs = robot.limbs(execution, share_limbs);
        let SymbolicRobot { mechanism, frames, parameters } = robot;
        let all_links = Tracer::with_parameters(mechanism, parameters.clone());
        // Few functions need links, of which there may be very many. But a link's inertia may be an
        // argument.
        let tracer = match robot.is_described() {
            true => Tracer::with_parameters(frames.mechanism_without_links(), parameters.clone()),
            false => all_links.clone(),
        };
        let forward_dynamics = partition::choose(model, mechanism, &tracer);
        // The cheapest partition on scalars may not be the cheapest for packed limbs.
        let uniform = [ModuleTree::links(model), partition::whole_chains(model)];
        let others = uniform
            .iter()
            .filter(|modules| !limbs.is_empty() && **modules != forward_dynamics.modules);
        let module_trees = [&forward_dynamics.modules].into_iter().chain(others);
        let partitions = module_trees.map(|m| ModulePartition::new(mechanism, m)).collect();
        let layout = UduLayout::new(mechanism, modules);
        Self {
            model,
            tracer,
            all_links,
            frames,
            sizes: Sizes::new(model, layout.size()),
            elimination: Elimination::new(mechanism, &forward_dynamics.modules),
            forward_dynamics,
            layout,
            for_derivatives: UduLayout::new(mechanism, &partition::whole_chains(model)),
            execution,
            share_limbs,
            code,
            machine_code,
            independent: limbs.first().is_some_and(|limbs| limbs.independent(mechanism)),
            limbs,
            partitions,
        }
    }

    /// Returns the number of run-time parameters of a function; zero unless it depends on them.
    pub(super) fn parameters(&self, depends: bool) -> usize {
        if depends { self.tracer.parameters().len() } else { 0 }
    }

    /// Returns whether limbs and columns of one state can be packed into vectors.
    pub(super) fn has_vectors(&self) -> bool {
        self.execution == Execution::Simd && !self.share_limbs
    }

    /// Returns whether programs run in threads of a graphics processor.
    pub(super) fn has_threads(&self) -> bool {
        self.execution == Execution::Threads
    }
}
