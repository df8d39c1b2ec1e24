//! Functions of arrays of plain numbers, and their derivatives of any order. Libraries call them
//! that differentiate with respect to every entry of an array, such as JAX and PyTorch.
//!
//! A function of the table or a fused function becomes one whose inputs are its arguments, then the
//! run-time parameters if it depends on them. The function scales quaternions to length 1 first, and
//! its derivatives by the four entries of a quaternion include this scaling. A derivative is a
//! function of arrays with further inputs, so derivatives can follow one another.

use std::ops::Range;

use modyn_runtime::quantities::{Argument, ArgumentKind, Function, Shape};

use super::context::PlanContext;
use super::functions::{CForm, GraphSource, Lowering};
use super::fused::{FusedFunction, Graphs};
use super::packing;
use super::planned::Planned;
use super::programs::StepForm;
use crate::graph::Graph;
use crate::passes::{jvp, matrix, optimize, vjp};
use crate::trace::{EntryForm, Gains, Tracer, second_derivatives};

/// The largest number of operations of second derivatives that are not made by differentiation of a
/// graph.
const MAX_HESSIAN: usize = 400_000;

/// A function of arrays of plain numbers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EntryFunction {
    /// The function of a robot that computes the results.
    pub source: EntrySource,
    /// The arrays that the result consists of: for each the places of its numbers among those of
    /// the function's result, in the order in which they are returned.
    pub results: Vec<Vec<usize>>,
    /// The gains of a time step with a feedback, which has three more arguments: `gains`, `q_ref` and
    /// `qd_ref`. The forces are then `tau` + `gains` (x_ref - x), with the difference of coordinates
    /// in tangent space, then the difference of velocities.
    pub feedback: Option<Gains>,
    /// Whether a function of a time step has a quadratic cost: a third array of the state, `cost`,
    /// and after the arguments of the step and of its feedback `q_goal`, `qd_goal`, `state_weights`
    /// (2 nv) and `control_weights` (nv). The step adds the sum of `state_weights` (x_goal - x)^2
    /// over the state after the step and of `control_weights` forces^2.
    pub cost: bool,
    /// The derivatives, the innermost first.
    pub derivatives: Vec<Derivative>,
}

/// The function of a robot that a function of arrays has its results from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum EntrySource {
    /// A function of the table.
    Table {
        /// The function.
        function: Function,
        /// The link of a function of one link, by its index among the links of the description.
        link: Option<usize>,
    },
    /// A fused function, by its name.
    Fused(String),
}

/// The function that an [`EntrySource`] names.
#[derive(Clone, Copy)]
pub(super) enum Source<'a> {
    /// A function of the table, and the link of a function of one link.
    Table(Function, Option<usize>),
    Fused(&'a FusedFunction),
}

impl Source<'_> {
    /// Returns the name.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Table(function, _) => function.name(),
            Self::Fused(fused) => fused.name,
        }
    }

    /// Returns a number of operations that the function takes at least.
    pub(super) fn least_operations(self, context: &PlanContext<'_>) -> usize {
        match self {
            Self::Table(function, _) => context.least_operations(function),
            Self::Fused(fused) => context.least_operations_fused(fused),
        }
    }

    fn docs(self) -> &'static str {
        match self {
            Self::Table(function, _) => function.row().docs,
            Self::Fused(fused) => fused.docs(),
        }
    }

    fn arguments(self) -> Vec<Argument> {
        match self {
            Self::Table(function, _) => function.row().arguments.to_vec(),
            Self::Fused(fused) => fused.arguments(),
        }
    }

    fn depends_on_parameters(self) -> bool {
        match self {
            Self::Table(function, _) => function.row().depends_on_parameters,
            Self::Fused(fused) => fused.depends_on_parameters(),
        }
    }

    /// Returns the function of the table whose solver is a loop, if it is one.
    fn with_solver(self) -> Option<Function> {
        match self {
            Self::Table(function, _) => Some(function).filter(|function| function.row().has_solver),
            Self::Fused(_) => None,
        }
    }
}

/// A derivative of a function of arrays.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Derivative {
    /// The form of the derivative.
    pub mode: DerivativeMode,
    /// The inputs that vary, by their indices, in ascending order.
    pub variables: Vec<usize>,
}

/// The form of a derivative of a function of arrays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DerivativeMode {
    /// The change of each result. Further inputs: the change of each variable.
    Forward,
    /// The gradient of a weighted sum of the results by each variable. Further inputs: the weights
    /// of each result.
    Reverse,
    /// For each result and each variable the matrix of derivatives, by rows.
    Matrix,
}

/// A graph with the lengths of its arrays of inputs and outputs.
struct Arrays {
    graph: Graph,
    inputs: Vec<usize>,
    outputs: Vec<usize>,
}

impl Arrays {
    /// Returns the number of all inputs.
    fn len(&self) -> usize {
        self.inputs.iter().sum()
    }

    /// Returns the product of the derivatives and a change of the variables. `forward` is its graph
    /// for changes of all inputs.
    fn forward(&self, forward: &Graph, variables: &[usize]) -> Self {
        let all = self.len();
        let places = ranges(&self.inputs);
        let changes: Vec<usize> = variables.iter().map(|&i| self.inputs[i]).collect();
        let mut graph = Graph::default();
        let mut given = graph.inputs(0..all + changes.iter().sum::<usize>());
        let tail = given.split_off(all);
        let mut rest = tail.into_iter();
        let mut change = vec![graph.constant(0.0); all];
        for &variable in variables {
            let entries = &mut change[places[variable].clone()];
            entries.iter_mut().zip(&mut rest).for_each(|(entry, id)| *entry = id);
        }
        graph.outputs = graph.compose(forward, &[given, change].concat());
        Self { graph, inputs: [&*self.inputs, &changes].concat(), outputs: self.outputs.clone() }
    }

    /// Returns the gradients by the variables. `reverse` is the graph of those by all inputs.
    fn reverse(&self, mut reverse: Graph, variables: &[usize]) -> Self {
        let places = ranges(&self.inputs);
        let kept = variables.iter().flat_map(|&i| places[i].clone());
        reverse.outputs = kept.map(|entry| reverse.outputs[entry]).collect();
        Self {
            graph: reverse,
            inputs: [&*self.inputs, &self.outputs].concat(),
            outputs: variables.iter().map(|&i| self.inputs[i]).collect(),
        }
    }

    /// Returns the matrices of derivatives by the variables. `columns` is the graph of one matrix
    /// by columns, with a row for each output, and a column for each entry of the variables.
    fn matrices(&self, mut columns: Graph, variables: &[usize]) -> Self {
        let rows: usize = self.outputs.iter().sum();
        let lengths: Vec<usize> = variables.iter().map(|&i| self.inputs[i]).collect();
        let mut outputs = Vec::new();
        let mut sizes = Vec::new();
        for own_rows in ranges(&self.outputs) {
            for own_columns in ranges(&lengths) {
                sizes.push(own_rows.len() * own_columns.len());
                let entries =
                    own_rows.clone().flat_map(|r| own_columns.clone().map(move |c| (r, c)));
                outputs.extend(entries.map(|(row, column)| columns.outputs[column * rows + row]));
            }
        }
        columns.outputs = outputs;
        Self { graph: columns, inputs: self.inputs.clone(), outputs: sizes }
    }

    /// Returns the derivative, by differentiation of the graph.
    fn differentiated(&self, Derivative { mode, variables }: &Derivative) -> Self {
        let all = self.len();
        let forward = || self.forward(&jvp(&self.graph, all, 0..all), variables);
        let reverse = || self.reverse(vjp(&self.graph, all, 0..all), variables);
        match mode {
            DerivativeMode::Forward => forward(),
            DerivativeMode::Reverse => reverse(),
            DerivativeMode::Matrix => {
                let width = variables.iter().map(|&i| self.inputs[i]).sum();
                let height = self.outputs.iter().sum();
                let columns = matrix(&forward().graph, &reverse().graph, all, height, width);
                self.matrices(columns, variables)
            }
        }
    }

    /// Returns the derivative whose graph for all inputs is `whole`: a product, or a matrix by
    /// columns.
    fn derivative(&self, Derivative { mode, variables }: &Derivative, mut whole: Graph) -> Self {
        match mode {
            DerivativeMode::Forward => self.forward(&whole, variables),
            DerivativeMode::Reverse => self.reverse(whole, variables),
            DerivativeMode::Matrix => {
                let rows: usize = self.outputs.iter().sum();
                let places = ranges(&self.inputs);
                let kept = variables.iter().flat_map(|&i| places[i].clone());
                let columns = kept.flat_map(|column| column * rows..(column + 1) * rows);
                whole.outputs = columns.map(|entry| whole.outputs[entry]).collect();
                self.matrices(whole, variables)
            }
        }
    }
}

/// Returns the places of arrays of these lengths that follow one another.
fn ranges(lengths: &[usize]) -> Vec<Range<usize>> {
    let mut next = 0;
    let range = |&length: &usize| {
        next += length;
        next - length..next
    };
    lengths.iter().map(range).collect()
}

impl EntryFunction {
    /// Returns the function among these fused functions; `None` if it is a fused function that is
    /// none of them.
    pub(super) fn source<'a>(&self, fused: &'a [FusedFunction]) -> Option<Source<'a>> {
        match &self.source {
            EntrySource::Table { function, link } => Some(Source::Table(*function, *link)),
            EntrySource::Fused(name) => {
                fused.iter().find(|fused| fused.name == name).map(Source::Fused)
            }
        }
    }

    /// Returns the function without derivatives, and where it is profitable the same function on
    /// vectors.
    fn value(&self, source: Source<'_>, context: &PlanContext<'_>) -> (Arrays, Option<Graph>) {
        let Self { results, feedback, cost, .. } = self;
        let mut inputs = Vec::new();
        let mut coordinates = Vec::new();
        for argument in source.arguments() {
            if argument.kind == ArgumentKind::Coordinates {
                coordinates.push(inputs.iter().sum());
            }
            inputs.push(argument.shape(&context.sizes).len());
        }
        let nq = context.sizes.nq;
        let nv = context.sizes.nv;
        if *cost {
            inputs.insert(2, 1);
        }
        if let Some(gains) = feedback {
            let count = gains.count(nv);
            coordinates.push(inputs.iter().sum::<usize>() + count);
            inputs.extend([count, nq, nv]);
        }
        if *cost {
            coordinates.push(inputs.iter().sum());
            inputs.extend([nq, nv, 2 * nv, nv]);
        }
        let parameters = context.parameters(source.depends_on_parameters());
        inputs.extend((parameters > 0).then_some(parameters));
        let all = inputs.iter().sum();
        let finished = |graph: &Graph| {
            let mut graph = context.tracer.with_unit_quaternions(graph, &coordinates, all);
            graph.outputs = results.iter().flatten().map(|&place| graph.outputs[place]).collect();
            graph
        };
        let (traced, packed) = match source {
            Source::Table(function, Some(link)) => {
                let evaluation = |tracer: &Tracer<'_>| context.evaluation(function, tracer);
                (optimize(context.frames.of_link(link, evaluation)), None)
            }
            Source::Table(function, None) => self.of_table(function, context),
            Source::Fused(fused) => {
                let graphs = Graphs::new(fused, context, parameters);
                let scalar = optimize(graphs.scalar());
                let packing = || packing::packed_fused(fused, &graphs, context, &scalar);
                let packed = self.derivatives.is_empty().then(packing).flatten();
                (scalar, packed)
            }
        };
        let outputs = results.iter().map(Vec::len).collect();
        let value = Arrays { graph: finished(&traced), inputs, outputs };
        (value, packed.as_ref().map(finished))
    }

    /// Returns the graph of a function of the table that is none of one link, and where it is
    /// profitable the same function on vectors.
    fn of_table(&self, function: Function, context: &PlanContext<'_>) -> (Graph, Option<Graph>) {
        let Self { feedback, cost, .. } = self;
        let row = function.row();
        let has_solver = row.has_solver;
        let plain = match has_solver {
            true => context.refined_step(function),
            false => packing::on_scalars(function, context),
        };
        if feedback.is_some() || *cost {
            let difference = packing::on_scalars(Function::Difference, context);
            let tracer = &context.tracer;
            let after_time = row.arguments.iter().skip(4);
            let settings = after_time.map(|argument| argument.shape(&context.sizes).len()).sum();
            let step = tracer.with_extras(*feedback, *cost, settings, &plain, &difference);
            return (optimize(step), None);
        }
        let is_packed = self.derivatives.is_empty()
            && !has_solver
            && !matches!(Lowering::of(function).source, GraphSource::Poses);
        let packed = is_packed.then(|| packing::packed(function, context, &plain)).flatten();
        (plain, packed)
    }

    /// Returns the innermost derivatives that have graphs of their own, which are shorter than
    /// those by differentiation, and the number of these derivatives.
    fn structured(
        &self,
        source: Source<'_>,
        value: &Arrays,
        context: &PlanContext<'_>,
    ) -> Option<(Arrays, usize)> {
        let Source::Table(function, None) = source else { return None };
        let tracer = &context.tracer;
        let layout = &context.for_derivatives;
        let first = self.derivatives.first()?;
        // Graphs of their own have all results in the function's order.
        if !self.results.iter().flatten().copied().eq(0..context.sizes.nv) {
            return None;
        }
        let forward_dynamics = |form: EntryForm| {
            let graph = &context.forward_dynamics.graph;
            tracer.forward_dynamics_form_by_entries(form, graph, layout, MAX_HESSIAN)
        };
        match (function, first.mode) {
            (Function::ForwardDynamics, DerivativeMode::Forward) => {
                let graph = forward_dynamics(EntryForm::Forward)?;
                Some((value.derivative(first, graph), 1))
            }
            (Function::ForwardDynamics, DerivativeMode::Matrix) => {
                let graph = forward_dynamics(EntryForm::Jacobian)?;
                Some((value.derivative(first, graph), 1))
            }
            (Function::ForwardDynamics, DerivativeMode::Reverse) => {
                let next = self.derivatives.get(1);
                let second = next.filter(|second| second.mode == DerivativeMode::Matrix);
                let Some(second) = second else {
                    let graph = forward_dynamics(EntryForm::Adjoint)?;
                    return Some((value.derivative(first, graph), 1));
                };
                let hessian = forward_dynamics(EntryForm::Hessian)?;
                let jacobian = forward_dynamics(EntryForm::Jacobian)?;
                let all = value.len();
                let rows = value.outputs.iter().sum();
                let mut whole = second_derivatives(&hessian, &jacobian, all, rows);
                // The rows of the gradients by the variables, for each column.
                let places = ranges(&value.inputs);
                let kept: Vec<usize> =
                    first.variables.iter().flat_map(|&i| places[i].clone()).collect();
                let columns = whole.outputs.chunks(all);
                whole.outputs =
                    columns.flat_map(|column| kept.iter().map(|&row| column[row])).collect();
                // The gradient itself is not needed: only the lengths of its arrays are.
                let gradient = Arrays {
                    graph: Graph::default(),
                    inputs: [&*value.inputs, &value.outputs].concat(),
                    outputs: first.variables.iter().map(|&i| value.inputs[i]).collect(),
                };
                Some((gradient.derivative(second, whole), 2))
            }
            (Function::InverseDynamics, DerivativeMode::Matrix) => {
                let graph = tracer.inverse_dynamics_jacobian_by_entries(&value.graph);
                Some((value.derivative(first, graph), 1))
            }
            _ => None,
        }
    }
}

impl Planned {
    /// Returns a function of arrays with its program, whose only argument is all arrays, one after
    /// the other, and so is the result.
    pub(super) fn entries(
        function: &EntryFunction,
        source: Source<'_>,
        context: &PlanContext<'_>,
    ) -> Self {
        let (value, packed) = function.value(source, context);
        let structured = function.structured(source, &value, context);
        let (mut arrays, done) = structured.unwrap_or((value, 0));
        for derivative in &function.derivatives[done..] {
            arrays.graph = optimize(arrays.graph);
            arrays = arrays.differentiated(derivative);
        }
        let scalars = arrays.len();
        let results = arrays.outputs.iter().sum();
        let graph = packing::balanced(optimize(arrays.graph));
        let solver = source.with_solver().filter(|_| function.derivatives.is_empty());
        let (kernels, fault) = match solver {
            Some(step) => {
                let form = StepForm::Entries { feedback: function.feedback };
                (context.step(step, scalars, form), None)
            }
            None => context.kernels(&graph, packed, scalars),
        };
        let numbers = Argument { name: "arrays", kind: ArgumentKind::Numbers(scalars) };
        Self {
            function: None,
            name: source.name(),
            batch_of: None,
            docs: source.docs(),
            fields: Vec::new(),
            c_form: CForm::None,
            arguments: vec![(numbers, Shape::vector(scalars))],
            parameters: 0,
            result: Shape::vector(results),
            kernels,
            fault,
        }
    }
}
