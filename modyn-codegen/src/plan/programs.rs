//! From a row of the table to programs: a function's graphs are traced, packed and lowered.

use std::collections::{BTreeMap, BTreeSet};

use modyn_runtime::equations::ModulePartition;
use modyn_runtime::equations::dynamics::Elimination;
use modyn_runtime::equations::soft_constraints::SoftModel;
use modyn_runtime::model::ModuleTree;
use modyn_runtime::quantities::{Argument, Function, Shape, Sizes};

use super::context::PlanContext;
use super::dense;
use super::frames::Frames;
use super::functions::{CForm, GraphSource, Lowering};
use super::fused::{FusedFunction, Graphs, Member};
use super::looped;
use super::packing::{self, COLUMN_LANES};
use super::planned::{Kernels, Planned};
use super::user::{TracedForm, TracedFunction};
use super::wrapped::docs_of;
use crate::graph::Graph;
use crate::graph::step::StepGraph;
use crate::intern::intern;
use crate::passes::{balance, optimize};
use crate::program::{Execution, InvalidProgram, Program};
use crate::trace::{DerivativeForm, Drive, EliminationOf, Gains, StepProduct, Tracer};

/// The scalar graphs of the selected functions that also have a selected batch form. Each graph is
/// traced once, for the function and its batch form.
pub(super) struct ScalarGraphs {
    /// The functions with a selected batch form; their graphs are kept.
    batched: BTreeSet<Function>,
    kept: BTreeMap<Function, Graph>,
}

impl ScalarGraphs {
    pub(super) fn new(selected: &[Function]) -> Self {
        let batched = selected.iter().filter_map(|function| function.batched()).collect();
        Self { batched, kept: BTreeMap::new() }
    }

    /// Returns the optimized and balanced graph of a function or of its batch form. The first call
    /// traces the graph.
    fn scalar(&mut self, function: Function, context: &PlanContext<'_>) -> Graph {
        let one = function.batched().unwrap_or(function);
        if let Some(graph) = self.kept.get(&one) {
            return graph.clone();
        }
        let graph = packing::balanced(packing::on_scalars(one, context));
        if self.batched.contains(&one) {
            self.kept.insert(one, graph.clone());
        }
        graph
    }
}

impl Planned {
    /// Returns a function with its programs.
    pub(super) fn new(
        function: Function,
        context: &PlanContext<'_>,
        graphs: &mut ScalarGraphs,
    ) -> Self {
        let row = function.row();
        let lowering = Lowering::of(function);
        let sizes = &context.sizes;
        let arguments = shapes_of(row.arguments, sizes);
        let parameters = context.parameters(row.depends_on_parameters);
        let scalars = count(&arguments, parameters);
        let mut fault = None;
        let kernels = match lowering.source {
            _ if row.by_link => {
                let graph = |tracer: &Tracer<'_>| optimize(context.evaluation(function, tracer));
                let graphs = context.frames.kernels(graph);
                let known_count = context.frames.links_with_own_program().count();
                let program = |(k, graph): (usize, &Graph)| {
                    let placement = if k < known_count { 0 } else { Frames::PLACEMENT };
                    context.program(graph, scalars + placement)
                };
                Kernels::ByLink(graphs.iter().enumerate().map(program).collect())
            }
            GraphSource::Poses if !context.has_threads() && context.frames.any_shared() => {
                let [bodies, placed] = context.frames.poses().map(optimize);
                let placed_arguments = Shape::pose().len() + Frames::PLACEMENT;
                Kernels::Poses {
                    bodies: context.program(&bodies, scalars),
                    placed: Program::new(&placed, placed_arguments, Execution::Scalar),
                    rows: context.frames.rows(),
                }
            }
            GraphSource::Poses => {
                let graph = packing::balanced(optimize(context.all_links.link_poses()));
                Kernels::of(context.program(&graph, scalars))
            }
            GraphSource::Step => context.step(function, scalars, StepForm::Robot),
            GraphSource::Traced(_) | GraphSource::Evaluation => {
                let rows = dense::of_constraints(function, context, scalars);
                rows.unwrap_or_else(|| {
                    let (kernels, invalid) = context.traced(function, graphs, scalars);
                    fault = invalid;
                    kernels
                })
            }
        };
        Self {
            function: Some(function),
            name: function.name(),
            batch_of: row.batch_of.map(Function::name),
            docs: docs_of(function),
            fields: Vec::new(),
            c_form: lowering.c_form,
            arguments,
            parameters,
            result: (row.result)(sizes),
            kernels,
            fault,
        }
    }

    /// Returns a fused function, and its form for many states if `batch`.
    pub(super) fn fused(
        fused: &FusedFunction,
        context: &PlanContext<'_>,
        batch: bool,
    ) -> (Self, Option<Self>) {
        let sizes = &context.sizes;
        let arguments = shapes_of(&fused.arguments(), sizes);
        let parameters = context.parameters(fused.depends_on_parameters());
        let scalars = count(&arguments, parameters);
        let graphs = Graphs::new(fused, context, parameters);
        let graph = packing::balanced(optimize(graphs.scalar()));
        let packed = packing::packed_fused(fused, &graphs, context, &graph);
        let (kernels, fault) = context.kernels(&graph, packed, scalars);
        let one = Self {
            function: None,
            name: fused.name,
            batch_of: None,
            docs: fused.docs(),
            fields: fused.members.iter().map(Member::field_docs).collect(),
            c_form: fused.c_form(),
            arguments,
            parameters,
            result: fused.result(sizes),
            kernels,
            fault,
        };
        let many = batch.then(|| one.of_many_states(&graph, scalars));
        (one, many)
    }

    /// Returns a form of a user's function, and the form for many states if `batch`.
    pub(super) fn user(
        function: &TracedFunction,
        form: &TracedForm,
        context: &PlanContext<'_>,
        batch: bool,
    ) -> (Self, Option<Self>) {
        let arguments = shapes_of(&form.arguments, &context.sizes);
        let parameters = context.parameters(function.depends_on_parameters);
        let scalars = count(&arguments, parameters);
        let graph = packing::balanced(optimize(form.graph.clone()));
        let (kernels, fault) = context.kernels(&graph, None, scalars);
        let one = Self {
            function: None,
            name: form.name,
            batch_of: None,
            docs: form.docs,
            fields: form.fields.clone(),
            c_form: CForm::SourceAndExport,
            arguments,
            parameters,
            result: form.result.clone(),
            kernels,
            fault,
        };
        let many = batch.then(|| one.of_many_states(&graph, scalars));
        (one, many)
    }

    /// Returns the form for many states of a function that is none of the table; `graph` has
    /// `scalars` inputs.
    fn of_many_states(&self, graph: &Graph, scalars: usize) -> Self {
        Self {
            function: None,
            name: intern(&format!("{}_batch", self.name)),
            batch_of: Some(self.name),
            docs: self.docs,
            fields: self.fields.clone(),
            c_form: CForm::None,
            arguments: self.arguments.clone(),
            parameters: self.parameters,
            result: self.result.clone(),
            kernels: Kernels::of(Program::new(graph, scalars, Execution::Batch)),
            fault: None,
        }
    }
}

impl PlanContext<'_> {
    /// Returns the programs of a function that is traced as a whole, and the fault of packs.
    fn traced(
        &self,
        function: Function,
        graphs: &mut ScalarGraphs,
        scalars: usize,
    ) -> (Kernels, Option<InvalidProgram>) {
        let graph = graphs.scalar(function, self);
        if function.batched().is_some() {
            let products = dense::by_products(function, self, (&graph, None), scalars);
            let straight = || Kernels::of(Program::new(&graph, scalars, Execution::Batch));
            return (products.unwrap_or_else(straight), None);
        }
        let packed = packing::packed(function, self, &graph);
        let straight = (&graph, packed.as_ref());
        let looped = looped::recursion(function, self, &graph, packed.as_ref()).map(Kernels::of);
        let products = || dense::by_products(function, self, straight, scalars);
        match looped.or_else(products) {
            Some(kernels) => (kernels, None),
            None => self.kernels(&graph, packed, scalars),
        }
    }

    /// Returns the graph of a step whose accelerations are known: it has the derivatives of the
    /// step.
    pub(super) fn refined_step(&self, function: Function) -> Graph {
        let soft = SoftModel::of(self.model);
        let elimination = self.elimination_of_steps(&soft);
        optimize(self.tracer.refined_step(&elimination, &soft, self.drive(function)))
    }

    /// Returns the forces that drive a function with a solver.
    fn drive(&self, function: Function) -> Drive<'_> {
        match function.row().of_actuators {
            true => Drive::Actuators(self.model),
            false => Drive::Forces,
        }
    }

    /// Returns the solver for steps with these constraints.
    fn elimination_of_steps(&self, soft: &SoftModel<f64>) -> Elimination {
        match soft.couples_limbs() {
            false => self.elimination.clone(),
            true => Elimination::of_steps(
                self.tracer.model(),
                &ModuleTree::links(self.model),
                soft.coupled_joints(),
            ),
        }
    }

    /// Returns the programs of a step with soft constraints.
    pub(super) fn step(&self, function: Function, scalars: usize, form: StepForm) -> Kernels {
        let soft = SoftModel::of(self.model);
        let drive = self.drive(function);
        let product = StepProduct::of(function);
        let has_derivatives = function.row().derivatives_of.is_some() && product.is_none();
        let refined = product.map(|product| (product, self.refined_step(function)));
        let derivatives = |column_lanes: usize| {
            let layout = &self.for_derivatives;
            has_derivatives.then_some(DerivativeForm { layout, column_lanes })
        };
        let traced = |tracer: &Tracer<'_>, elimination: EliminationOf<'_>, columns: usize| {
            let mut step = tracer.step(elimination, &soft, drive, derivatives(columns));
            if let StepForm::Entries { feedback } = form {
                let mut coordinates = vec![0];
                if let Some(gains) = feedback {
                    let difference = packing::on_scalars(Function::Difference, self);
                    step = self.tracer.step_with_feedback(step, gains, &difference);
                    // `q_ref` is before `qd_ref` and the parameters.
                    let Sizes { nq, nv, .. } = self.sizes;
                    let parameters = self.parameters(true);
                    coordinates.push(step.arguments() - parameters - nv - nq);
                }
                let inputs = step.results.inputs.end;
                step.graph = self.tracer.with_unit_quaternions(&step.graph, &coordinates, inputs);
            }
            if let Some((product, refined)) = &refined {
                let sizes = &self.sizes;
                step = self.tracer.step_with_product(function, *product, step, refined, sizes);
            }
            StepGraph { graph: optimize(step.graph), ..step }
        };
        let of_steps = |soft: &SoftModel<f64>| self.elimination_of_steps(soft);
        let scalar = traced(&self.tracer, &of_steps, 1);
        let links = ModulePartition::new(self.tracer.model(), &ModuleTree::links(self.model));
        let by_links = |_: &SoftModel<f64>| Elimination::Recursive(links.clone());
        let limbs = self.limbs.iter().filter(|limbs| {
            self.has_vectors() && !soft.acts_across_limbs() && limbs.merges_joints(&soft)
        });
        let merged = limbs.map(|limbs| traced(&self.tracer.packed(limbs), &by_links, COLUMN_LANES));
        let has_columns = has_derivatives && self.has_vectors();
        let columns = has_columns.then(|| traced(&self.tracer, &of_steps, COLUMN_LANES));
        let packed = (merged.chain(columns))
            .min_by_key(|step| step.graph.count().total())
            .filter(|packed| packing::is_profitable(&packed.graph, &scalar.graph));
        let simd = packed.and_then(|step| {
            Program::of_step(&step, scalars, Execution::Simd, |graph| balance(&graph)).ok()
        });
        let scalar = Program::of_step(&scalar, scalars, self.without_packs(), packing::balanced);
        Kernels::Straight { scalar: scalar.expect("a fault of modyn: please report it"), simd }
    }

    /// Returns the way that programs without packs run.
    pub(super) fn without_packs(&self) -> Execution {
        without_packs(self.execution)
    }

    /// Returns the program of a graph without packs.
    fn program(&self, graph: &Graph, scalars: usize) -> Program {
        Program::new(graph, scalars, self.without_packs())
    }

    /// Returns the programs of a graph, as [`Kernels::lowered`] does.
    pub(super) fn kernels(
        &self,
        graph: &Graph,
        packed: Option<Graph>,
        scalars: usize,
    ) -> (Kernels, Option<InvalidProgram>) {
        Kernels::lowered(graph, packed, scalars, self.execution, self.share_limbs)
    }
}

/// The form of a step with soft constraints.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum StepForm {
    /// The function of a robot.
    Robot,
    /// A function of arrays of plain numbers, which scales quaternions to length 1 first. With a
    /// feedback of these gains, it has the arguments of
    /// [`EntryFunction`](super::entries::EntryFunction).
    Entries { feedback: Option<Gains> },
}

impl Kernels {
    /// Returns the programs of a graph without packs and, if packing is profitable, of the same
    /// function packed: as routines for equal limbs if `share_limbs`, else on vectors. If the
    /// packed program is invalid, returns the program without packs alone, and the violation.
    #[must_use]
    pub fn lowered(
        graph: &Graph,
        packed: Option<Graph>,
        scalars: usize,
        execution: Execution,
        share_limbs: bool,
    ) -> (Self, Option<InvalidProgram>) {
        let packed = packed.map(|packed| match share_limbs {
            true => Program::repeated(&packed, scalars),
            false => Program::try_new(&packed, scalars, Execution::Simd),
        });
        let scalar = || Program::new(graph, scalars, without_packs(execution));
        match packed {
            Some(Ok(program)) if share_limbs => (Self::of(program), None),
            Some(Ok(simd)) => (Self::Straight { scalar: scalar(), simd: Some(simd) }, None),
            invalid => (Self::of(scalar()), invalid.and_then(Result::err)),
        }
    }
}

/// Returns the way that programs without packs run where packed ones run in this way.
fn without_packs(execution: Execution) -> Execution {
    if execution == Execution::Simd { Execution::Scalar } else { execution }
}

/// Returns arguments with their layouts.
pub(super) fn shapes_of(arguments: &[Argument], sizes: &Sizes) -> Vec<(Argument, Shape)> {
    arguments.iter().map(|argument| (*argument, argument.shape(sizes))).collect()
}

/// Returns the number of scalars of arguments and run-time parameters.
fn count(arguments: &[(Argument, Shape)], parameters: usize) -> usize {
    parameters + arguments.iter().map(|(_, shape)| shape.len()).sum::<usize>()
}
