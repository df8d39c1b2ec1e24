//! The graphs of the derivatives of any function in tangent space.

use std::ops::Range;

use super::Tracer;
use super::composition::Composition;
use crate::graph::{Graph, Id, Node};
use crate::passes::{jvp, matrix, optimize, symmetric_matrix, vjp};

/// An argument of a function: the layout of its numbers.
#[derive(Clone, Copy, Debug)]
pub struct TangentInput {
    /// The number of scalars.
    pub len: usize,
    /// Whether they are coordinates, whose derivatives are in tangent space.
    pub is_coordinates: bool,
    /// Whether derivatives are with respect to them.
    pub varies: bool,
}

/// A function, traced, from which the graphs of its derivatives are made.
///
/// The inputs of all graphs are the arguments, further inputs of the graph, then the robot's
/// run-time parameters. A *displacement* has the entries of all variables one after the other,
/// changes of coordinates in tangent space.
pub struct TangentGraphs<'a> {
    tracer: &'a Tracer<'a>,
    inputs: Vec<TangentInput>,
    /// The number of scalars of all arguments.
    arguments: usize,
    /// The results.
    pub value: Graph,
}

impl<'a> TangentGraphs<'a> {
    /// Returns the graphs of a function with this graph, whose inputs are the arguments and the
    /// run-time parameters.
    pub(super) fn new(tracer: &'a Tracer<'a>, inputs: Vec<TangentInput>, value: Graph) -> Self {
        let arguments = inputs.iter().map(|input| input.len).sum();
        Self { tracer, inputs, arguments, value }
    }

    /// Returns the arguments that vary, each with its range of inputs.
    fn variables(&self) -> impl Iterator<Item = (TangentInput, Range<usize>)> {
        let mut next = 0;
        let ranges = self.inputs.iter().map(move |input| {
            next += input.len;
            (*input, next - input.len..next)
        });
        ranges.filter(|(input, _)| input.varies)
    }

    /// Returns the length of the displacements of each variable.
    #[must_use]
    pub fn displacements(&self) -> Vec<usize> {
        let nv = self.tracer.model.nv;
        self.variables()
            .map(|(input, _)| if input.is_coordinates { nv } else { input.len })
            .collect()
    }

    /// Returns the entries of a displacement that belong to one rotation or pose, for each entry;
    /// the entry alone for all other entries.
    fn groups(&self) -> Vec<Range<usize>> {
        let mut groups: Vec<Range<usize>> = Vec::new();
        for (input, range) in self.variables() {
            let first = groups.len();
            if input.is_coordinates {
                let tangent_groups = self.tracer.groups().into_iter();
                groups.extend(tangent_groups.map(|group| first + group.start..first + group.end));
            } else {
                groups.extend((first..first + range.len()).map(|entry| entry..entry + 1));
            }
        }
        groups
    }

    fn parameters(&self) -> usize {
        self.tracer.parameters.len()
    }

    /// Returns whether the function depends on run-time parameters.
    #[must_use]
    pub fn depends_on_parameters(&self) -> bool {
        let live = self.value.live();
        let inputs = self.arguments..self.arguments + self.parameters();
        let mut inputs_of_value = inputs.filter_map(|number| self.value.find(Node::input(number)));
        inputs_of_value.any(|id| live[id as usize])
    }

    /// Returns the inputs of a graph: the arguments, `further` inputs and the run-time parameters.
    fn inputs(&self, all: &mut Composition, further: usize) -> [Vec<Id>; 3] {
        [self.arguments, further, self.parameters()].map(|count| all.inputs(count))
    }

    /// Returns the changes of all arguments under a displacement; zero for those that are constant.
    fn changes(
        &self,
        all: &mut Composition,
        [arguments, displacement, parameters]: [&[Id]; 3],
    ) -> Vec<Id> {
        let mut changes = vec![all.constant(0.0); self.arguments];
        let rates = self.tracer.velocity_to_qdot();
        let mut rest = displacement;
        for ((input, range), len) in self.variables().zip(self.displacements()) {
            let (changes_of_input, others) = rest.split_at(len);
            rest = others;
            let change = match input.is_coordinates {
                true => all.add(&rates, &[&arguments[range.clone()], changes_of_input, parameters]),
                false => changes_of_input.to_vec(),
            };
            changes[range].copy_from_slice(&change);
        }
        changes
    }

    /// Returns the graph of the change of the results. Inputs: the arguments, the run-time
    /// parameters and a displacement.
    fn change(&self) -> Graph {
        let mut all = Composition::new();
        let [arguments, parameters] =
            [self.arguments, self.parameters()].map(|count| all.inputs(count));
        let displacement = all.inputs(self.displacements().iter().sum());
        let changes = self.changes(&mut all, [&arguments, &displacement, &parameters]);
        let inputs = self.arguments + self.parameters();
        let graph = jvp(&self.value, inputs, 0..self.arguments);
        let change = all.add(&graph, &[&arguments, &parameters, &changes]);
        all.with_outputs(&[&change])
    }

    /// Returns the graph of the gradient of the results' weighted sum, with the entries of a
    /// displacement. Inputs: the arguments, the run-time parameters and the weights.
    fn gradient(&self) -> Graph {
        let mut all = Composition::new();
        let [arguments, parameters, weights] =
            [self.arguments, self.parameters(), self.value.outputs.len()]
                .map(|count| all.inputs(count));
        let inputs = self.arguments + self.parameters();
        let graph = vjp(&self.value, inputs, 0..self.arguments);
        let gradient = all.add(&graph, &[&arguments, &parameters, &weights]);
        let mut outputs = Vec::new();
        for (input, range) in self.variables() {
            let part = &gradient[range.clone()];
            match input.is_coordinates {
                true => {
                    let q = &arguments[range];
                    outputs.extend(self.tracer.in_tangent_space(&mut all, q, part));
                }
                false => outputs.extend(part),
            }
        }
        all.with_outputs(&[&outputs])
    }

    /// Returns the graph of the results, and of their change. Further inputs: a displacement.
    #[must_use]
    pub fn jvp(&self) -> Graph {
        let mut all = Composition::new();
        let count = self.displacements().iter().sum();
        let [arguments, displacement, parameters] = self.inputs(&mut all, count);
        let value = all.add(&self.value, &[&arguments, &parameters]);
        let change = all.add(&self.change(), &[&arguments, &parameters, &displacement]);
        all.with_outputs(&[&value, &change])
    }

    /// Returns the graph of the results, and of the gradients of their weighted sum. Further
    /// inputs: the weights, unless there is one result, which has the weight 1.
    #[must_use]
    pub fn vjp(&self) -> Graph {
        let mut all = Composition::new();
        let [arguments, weights, parameters] = self.weighted(&mut all);
        let value = all.add(&self.value, &[&arguments, &parameters]);
        let gradient = all.add(&self.gradient(), &[&arguments, &parameters, &weights]);
        all.with_outputs(&[&value, &gradient])
    }

    /// Returns the inputs of a graph with weights.
    fn weighted(&self, all: &mut Composition) -> [Vec<Id>; 3] {
        let results = self.value.outputs.len();
        let [arguments, weights, parameters] =
            self.inputs(all, if results == 1 { 0 } else { results });
        let one = all.constant(1.0);
        [arguments, if results == 1 { vec![one] } else { weights }, parameters]
    }

    /// Returns the graph of the results, and of their derivatives: for each variable a matrix by
    /// columns.
    #[must_use]
    pub fn jacobian(&self) -> Graph {
        let mut all = Composition::new();
        let [arguments, _, parameters] = self.inputs(&mut all, 0);
        let value = all.add(&self.value, &[&arguments, &parameters]);
        let inputs = self.arguments + self.parameters();
        let columns = self.displacements().iter().sum();
        let graph =
            matrix(&self.change(), &self.gradient(), inputs, self.value.outputs.len(), columns);
        let jacobian = all.add(&graph, &[&arguments, &parameters]);
        all.with_outputs(&[&value, &jacobian])
    }

    /// Returns the graphs of the gradient of the results' weighted sum and of its Hessian, by
    /// columns, both with the entries of a displacement. Inputs: the arguments, the run-time
    /// parameters and the weights. Returns `None` if the Hessian takes more than `max_operations`.
    pub(super) fn gradient_and_hessian(&self, max_operations: usize) -> Option<[Graph; 2]> {
        let size: usize = self.displacements().iter().sum();
        let gradient = optimize(self.gradient());
        // The changes of the gradient along a displacement. Inputs: the inputs of the gradient, and
        // the displacement.
        let mut along = Composition::new();
        let [arguments, parameters, weights, displacement] =
            [self.arguments, self.parameters(), self.value.outputs.len(), size]
                .map(|count| along.inputs(count));
        let changes = self.changes(&mut along, [&arguments, &displacement, &parameters]);
        let inputs = self.arguments + self.parameters() + self.value.outputs.len();
        let graph = jvp(&gradient, inputs, 0..self.arguments);
        let change = along.add(&graph, &[&arguments, &parameters, &weights, &changes]);
        let along = along.with_outputs(&[&change]);
        let hessian = symmetric_matrix(along, inputs, &self.groups(), max_operations)?;
        Some([gradient, hessian])
    }

    /// Returns the graph of the results, of the gradients of their weighted sum, and of the blocks
    /// of its Hessian, by columns: the blocks of the first variable and itself, of the first and
    /// the second, and so on, then of the second and itself. Inputs as of [`vjp`](Self::vjp).
    /// Returns `None` if it takes more than `max_operations`.
    #[must_use]
    pub fn hessian(&self, max_operations: usize) -> Option<Graph> {
        let displacements = self.displacements();
        let size: usize = displacements.iter().sum();
        let [gradient, hessian] = self.gradient_and_hessian(max_operations)?;
        let mut all = Composition::new();
        let [arguments, weights, parameters] = self.weighted(&mut all);
        let value = all.add(&self.value, &[&arguments, &parameters]);
        let point = [&arguments[..], &parameters, &weights];
        let gradient = all.add(&gradient, &point);
        let hessian = all.add(&hessian, &point);
        let mut blocks = Vec::new();
        let mut first_row = 0;
        for (i, rows) in displacements.iter().enumerate() {
            let mut column = first_row;
            for columns in &displacements[i..] {
                for j in column..column + columns {
                    blocks.extend(&hessian[j * size + first_row..][..*rows]);
                }
                column += columns;
            }
            first_row += rows;
        }
        Some(all.with_outputs(&[&value, &gradient, &blocks]))
    }
}
