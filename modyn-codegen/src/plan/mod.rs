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
mod constants;
mod factorization;
mod frames;
mod functions;
mod measures;
mod packing;
pub mod partition;
mod shape;

use std::collections::{BTreeMap, BTreeSet};

use modyn_runtime::OperationCount;
use modyn_runtime::equations::ModulePartition;
use modyn_runtime::equations::brge::UduLayout;
use modyn_runtime::equations::dynamics::Elimination;
use modyn_runtime::mechanism::Mechanism;
use modyn_runtime::model::{Model, ModuleTree};

pub use bundle::{Bundle, Member};
pub use casadi::{CasadiFunction, CasadiMatrix, CasadiPlan};
pub use choices::{Choices, Execution};
pub use constants::{BaseParameterTable, Constants};
pub use factorization::FactorFunction;
pub use frames::{Frames, LinkCode};
pub use functions::{Argument, CForm, Function, Packing, Row, Trace};
pub use measures::Measures;
pub use shape::{Record, Shape, Sizes};

use crate::graph::Graph;
use crate::names;
use crate::passes::optimize;
use crate::program::{Program, Target};
use crate::trace::{LimbPacking, Parameters, Tracer};
use choices::Strategy;
use partition::ChosenPartition;

/// The programs of a robot.
pub struct Plan {
    /// The choices of the user.
    pub choices: Choices,
    /// The functions of one state, in the order of [`Function::ALL`]; then the bundles.
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
    /// The partitions that were considered, with their operations; the chosen one is first.
    pub candidates: Vec<(&'static str, usize)>,
}

/// A function or a bundle of functions, planned for a robot.
pub struct Planned {
    /// The function; `None` for a bundle.
    pub function: Option<Function>,
    /// The name.
    pub name: &'static str,
    /// The name of the function or bundle of one state, if this is its form for many states.
    pub batch_of: Option<&'static str>,
    /// The documentation, in lines.
    pub docs: &'static str,
    /// The documentation of each field of the result, if the result is a type of the robot's own.
    pub fields: Vec<&'static str>,
    /// The forms that C can call.
    pub c_form: CForm,
    /// The arguments, with their names.
    pub arguments: Vec<(&'static str, Shape)>,
    /// The number of run-time parameters, which are the last argument; zero if the function does not depend on them.
    pub parameters: usize,
    /// The layout of the result.
    pub result: Shape,
    /// The programs.
    pub kernels: Kernels,
}

/// The programs of a function.
pub enum Kernels {
    /// One program.
    One(Program),
    /// A program on scalars and a program on vectors; the processor's features decide at run time.
    Dispatched {
        /// The program on scalars.
        scalar: Program,
        /// The program on vectors.
        simd: Program,
    },
    /// The programs of a function of one link: one for each link with a program of its own, in the order of
    /// [`Frames::links_with_own_program`], then one for each body with a shared program. Shared programs have the
    /// link's placement as a further argument.
    ByLink(Vec<Program>),
    /// The programs of the poses of all links, if some links share a program.
    Poses {
        /// The poses in the order of [`Frames::links_with_own_program`], then of the bodies with a shared program.
        bodies: Program,
        /// The pose of a link with a shared program, from the pose of its body and the link's placement.
        placed: Program,
        /// The number of links with a shared program.
        rows: usize,
    },
}

impl Planned {
    /// Returns the operations of one call on scalars; for a function of one link, those of the most expensive link.
    #[must_use]
    pub fn operations_per_call(&self) -> OperationCount {
        match &self.kernels {
            Kernels::One(program) | Kernels::Dispatched { scalar: program, .. } => {
                program.operations_per_call()
            }
            Kernels::ByLink(all) => {
                let counts = all.iter().map(Program::operations_per_call);
                counts.max_by_key(OperationCount::total).unwrap_or_default()
            }
            Kernels::Poses { bodies, placed, rows } => {
                let placed = std::iter::repeat_n(placed.operations_per_call(), *rows);
                placed.chain([bodies.operations_per_call()]).sum()
            }
        }
    }

    /// Returns the operations of all programs.
    #[must_use]
    pub fn static_operations(&self) -> OperationCount {
        match &self.kernels {
            Kernels::One(program) => program.static_operations(),
            Kernels::Dispatched { scalar, simd } => {
                scalar.static_operations() + simd.static_operations()
            }
            Kernels::ByLink(all) => all.iter().map(Program::static_operations).sum(),
            Kernels::Poses { bodies, placed, .. } => {
                bodies.static_operations() + placed.static_operations()
            }
        }
    }
}

/// The inputs of tracing.
pub struct Tracing<'a> {
    /// The robot on expressions.
    pub tracer: &'a Tracer<'a>,
    /// The robot on expressions, with all its links. `tracer` has links only if some are run-time parameters.
    pub all_links: &'a Tracer<'a>,
    /// The links, grouped by their programs.
    pub frames: &'a Frames,
    /// The solver of forward dynamics.
    pub elimination: &'a Elimination,
    /// The layout of the factorization that users receive.
    pub layout: &'a UduLayout,
    /// The layout of the factorization that derivatives use.
    pub for_derivatives: &'a UduLayout,
    /// The candidates for packing limbs.
    limbs: &'a [LimbPacking],
    /// The partitions of forward dynamics to try with packed limbs.
    partitions: &'a [ModulePartition],
    /// Whether no limb moves another limb.
    independent: bool,
    /// Whether the target language has vectors.
    vectors: bool,
    /// The graph of forward dynamics, from the search for the cheapest partition.
    forward_dynamics: &'a Graph,
}

impl Plan {
    /// Returns the plan of `model`'s functions for a back end that runs them in this way; `modules` is the user's partition.
    #[must_use]
    pub fn new(
        model: &Model,
        modules: &ModuleTree,
        choices: &Choices,
        execution: Execution,
    ) -> Self {
        let strategy = choices.strategy(execution);
        let batches = execution == Execution::Vectors;
        let mechanism = Mechanism::new(model);
        let (inertias, payloads) = (&*choices.runtime_inertia, &*choices.payload);
        let described = inertias.is_empty() && payloads.is_empty();
        let parameters = Parameters::new(model, choices.runtime_gravity, inertias, payloads);
        let frames = Frames::new(&mechanism);
        let all_links = Tracer::with_parameters(&mechanism, parameters.clone());
        // Few functions need links, of which there may be very many. But a link's inertia may be an argument.
        let tracer = match described {
            true => Tracer::with_parameters(frames.mechanism_without_links(), parameters.clone()),
            false => all_links.clone(),
        };
        let ChosenPartition { modules: elimination_modules, graph: forward_dynamics, candidates } =
            partition::choose(model, &mechanism, &tracer);
        let layout = UduLayout::new(&mechanism, modules);
        // Limbs with run-time inertias are never equal.
        let packs = matches!(strategy, Strategy::Routines | Strategy::Vectors) && described;
        let joins = strategy == Strategy::Vectors;
        let limbs = if packs { LimbPacking::candidates(&mechanism, joins) } else { Vec::new() };
        // The cheapest partition on scalars may not be the cheapest for packed limbs.
        let uniform = [ModuleTree::links(model), partition::whole_chains(model)];
        let others =
            uniform.iter().filter(|modules| !limbs.is_empty() && **modules != elimination_modules);
        let partitions: Vec<ModulePartition> = [&elimination_modules]
            .into_iter()
            .chain(others)
            .map(|m| ModulePartition::new(&mechanism, m))
            .collect();
        let sizes = Sizes {
            nq: model.nq(),
            nv: model.nv(),
            links: model.frames().len(),
            moving: model.links().len(),
            constraints: model.constraints(),
            contacts: model.contacts().len(),
            constraint_rows: model.constraint_rows(),
            factors: layout.size(),
        };
        let tracing = Tracing {
            tracer: &tracer,
            all_links: &all_links,
            frames: &frames,
            limbs: &limbs,
            partitions: &partitions,
            independent: limbs.first().is_some_and(|limbs| limbs.independent(&mechanism)),
            vectors: strategy == Strategy::Vectors,
            elimination: &Elimination::new(&mechanism, &elimination_modules),
            layout: &layout,
            for_derivatives: &UduLayout::new(&mechanism, &partition::whole_chains(model)),
            forward_dynamics: &forward_dynamics,
        };
        let selected = |function: &Function| {
            let row = function.row();
            choices.functions.contains(function)
                && (batches || row.batch_of.is_none())
                && function.fits(sizes.constraints, sizes.contacts)
        };
        let selected: Vec<Function> = Function::ALL.iter().copied().filter(selected).collect();
        let mut graphs = Graphs::new(&selected);
        let known = (&tracing, &sizes, parameters.len());
        let planned = |&function: &Function| Planned::new(function, known, strategy, &mut graphs);
        let (mut many, mut functions): (Vec<Planned>, Vec<Planned>) =
            selected.iter().map(planned).partition(|planned| planned.batch_of.is_some());
        for bundle in &choices.bundles {
            let batch = batches && bundle.batch;
            let (one, of_many) = Planned::bundle(bundle, known, strategy, batch);
            functions.push(one);
            many.extend(of_many);
        }
        let bundled = choices.bundles.iter().flat_map(|bundle| &bundle.members);
        let mut all = selected.iter().copied().chain(bundled.map(|member| member.function));
        let factorizes = all.any(|f| matches!(f, Function::Brge | Function::BrgeBatch));
        let factorization =
            if factorizes { factorization::plan(&tracer, &layout, &sizes) } else { Vec::new() };
        let pivots = tracer.inertia_pivots().map(|(entries, graph)| {
            let program = Program::new(&optimize(graph), 1 + parameters.len(), Target::Scalar);
            (entries, program)
        });
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
            candidates,
        }
    }

    /// Returns the operations of one call of each function and bundle, by name.
    #[must_use]
    pub fn operations_per_call(&self) -> Vec<(&'static str, OperationCount)> {
        let planned = self.functions.iter().chain(&self.batches);
        planned.map(|planned| (planned.name, planned.operations_per_call())).collect()
    }

    /// Returns the operations of all programs of each function and bundle of one state, by name.
    #[must_use]
    pub fn static_operations(&self) -> Vec<(&'static str, OperationCount)> {
        self.functions.iter().map(|planned| (planned.name, planned.static_operations())).collect()
    }
}

/// The scalar graphs of the selected functions that also have a selected batch form. Each graph is traced once, for
/// the function and its batch form.
struct Graphs {
    /// The functions with a selected batch form; their graphs are kept.
    batched: BTreeSet<Function>,
    kept: BTreeMap<Function, Graph>,
}

impl Graphs {
    fn new(selected: &[Function]) -> Self {
        let batched = selected.iter().filter_map(|function| function.batched()).collect();
        Self { batched, kept: BTreeMap::new() }
    }

    /// Returns the optimized and balanced graph of a function or of its batch form. The first call traces the graph.
    fn scalar(
        &mut self,
        function: Function,
        trace: fn(&Tracer<'_>, &Tracing<'_>) -> Graph,
        tracing: &Tracing<'_>,
    ) -> Graph {
        let one = function.batched().unwrap_or(function);
        if let Some(graph) = self.kept.get(&one) {
            return graph.clone();
        }
        let graph = packing::balanced(match one {
            // The search for the partition has already optimized this graph.
            Function::ForwardDynamics => tracing.forward_dynamics.clone(),
            _ => optimize(trace(tracing.tracer, tracing)),
        });
        if self.batched.contains(&one) {
            self.kept.insert(one, graph.clone());
        }
        graph
    }
}

impl Planned {
    fn new(
        function: Function,
        (tracing, sizes, parameters): (&Tracing<'_>, &Sizes, usize),
        strategy: Strategy,
        graphs: &mut Graphs,
    ) -> Self {
        let row = function.row();
        let arguments = shapes_of(row.arguments, sizes);
        let parameters = if row.depends_on_parameters { parameters } else { 0 };
        let scalars = count(&arguments, parameters);
        let kernels = match row.trace {
            Trace::ByLink(trace) => {
                let graphs = tracing.frames.kernels(|tracer| optimize(trace(tracer)));
                let (own, shared) =
                    graphs.split_at(tracing.frames.links_with_own_program().count());
                let own = own.iter().map(|graph| strategy.scalar_program(graph, scalars));
                let placed = scalars + Frames::PLACEMENT;
                let shared = shared.iter().map(|graph| strategy.scalar_program(graph, placed));
                Kernels::ByLink(own.chain(shared).collect())
            }
            Trace::Poses if strategy != Strategy::Threads && tracing.frames.any_shared() => {
                let [bodies, placed] = tracing.frames.poses().map(optimize);
                let placed_arguments = Shape::pose().len() + Frames::PLACEMENT;
                Kernels::Poses {
                    bodies: strategy.scalar_program(&bodies, scalars),
                    placed: Program::new(&placed, placed_arguments, Target::Scalar),
                    rows: tracing.frames.rows(),
                }
            }
            Trace::Poses => {
                let graph = packing::balanced(optimize(tracing.all_links.link_poses()));
                Kernels::One(strategy.scalar_program(&graph, scalars))
            }
            Trace::One(trace) => {
                let graph = graphs.scalar(function, trace, tracing);
                if row.batch_of.is_some() {
                    Kernels::One(Program::new(&graph, scalars, Target::Batch))
                } else {
                    let packed = packing::packed(function, tracing, &graph);
                    strategy.kernels(&graph, packed, scalars)
                }
            }
        };
        Self {
            function: Some(function),
            name: function.name(),
            batch_of: row.batch_of.map(Function::name),
            docs: row.docs,
            fields: Vec::new(),
            c_form: row.c_form,
            arguments,
            parameters,
            result: (row.result)(sizes),
            kernels,
        }
    }

    /// Returns a bundle, and its form for many states if `batch`.
    fn bundle(
        bundle: &Bundle,
        (tracing, sizes, parameters): (&Tracing<'_>, &Sizes, usize),
        strategy: Strategy,
        batch: bool,
    ) -> (Self, Option<Self>) {
        let arguments = shapes_of(&bundle.arguments(), sizes);
        let parameters = if bundle.any(|row| row.depends_on_parameters) { parameters } else { 0 };
        let scalars = count(&arguments, parameters);
        let graphs = bundle::Graphs::new(bundle, tracing, sizes, parameters);
        let graph = packing::balanced(optimize(graphs.scalar()));
        let packed = packing::packed_bundle(bundle, &graphs, tracing, &graph);
        let one = Self {
            function: None,
            name: bundle.name,
            batch_of: None,
            docs: bundle.docs(),
            fields: bundle.members.iter().map(|member| member.docs).collect(),
            c_form: bundle.c_form(),
            arguments,
            parameters,
            result: bundle.result(sizes),
            kernels: strategy.kernels(&graph, packed, scalars),
        };
        let many = batch.then(|| Self {
            name: names::intern(&format!("{}_batch", bundle.name)),
            batch_of: Some(bundle.name),
            fields: one.fields.clone(),
            arguments: one.arguments.clone(),
            result: one.result.clone(),
            c_form: CForm::None,
            kernels: Kernels::One(Program::new(&graph, scalars, Target::Batch)),
            ..one
        });
        (one, many)
    }
}

impl Strategy {
    /// Returns the program of a graph on scalars.
    fn scalar_program(self, graph: &Graph, scalars: usize) -> Program {
        match self {
            Self::Threads => Program::for_threads(graph, scalars),
            _ => Program::new(graph, scalars, Target::Scalar),
        }
    }

    /// Returns the programs of a graph on scalars and, if packing is profitable, of the same function packed.
    fn kernels(self, graph: &Graph, packed: Option<Graph>, scalars: usize) -> Kernels {
        match packed {
            None => Kernels::One(self.scalar_program(graph, scalars)),
            Some(packed) if self == Self::Routines => {
                Kernels::One(Program::repeated(&packed, scalars))
            }
            Some(packed) => Kernels::Dispatched {
                scalar: Program::new(graph, scalars, Target::Scalar),
                simd: Program::new(&packed, scalars, Target::Simd),
            },
        }
    }
}

/// Returns the layouts of arguments, by name.
fn shapes_of(arguments: &[Argument], sizes: &Sizes) -> Vec<(&'static str, Shape)> {
    arguments.iter().map(|argument| (argument.name, (argument.shape)(sizes))).collect()
}

/// Returns the number of scalars of arguments and run-time parameters.
fn count(arguments: &[(&'static str, Shape)], parameters: usize) -> usize {
    parameters + arguments.iter().map(|(_, shape)| shape.len()).sum::<usize>()
}
