//! Products of the derivatives of a step with vectors, by the step of Newton's method that ends at the
//! solution of the step.

use modyn_runtime::Scalar;
use modyn_runtime::equations::kinematics::coordinates;
use modyn_runtime::quantities::{Argument, ArgumentKind, Sizes};

use super::composition::Composition;
use super::{TangentGraphs, TangentInput, Tracer};
use crate::Function;
use crate::graph::step::StepGraph;
use crate::graph::{Expr, Graph, Id};
use crate::passes::vjp;

/// A product of the derivatives of the state after a step with a vector.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StepProduct {
    /// The gradients of a weighted sum.
    Gradients,
    /// The change under changes of the arguments.
    Change,
}

impl StepProduct {
    /// Returns the product that a function has; `None` for other functions.
    #[must_use]
    pub fn of(function: Function) -> Option<Self> {
        match function {
            Function::StepVjp | Function::StepActuatedVjp => Some(Self::Gradients),
            Function::StepJvp | Function::StepActuatedJvp => Some(Self::Change),
            _ => None,
        }
    }
}

/// The arguments of a function with a product, in a graph.
struct Arguments(Vec<(Argument, Vec<Id>)>);

impl Arguments {
    /// Returns the numbers of the arguments of these names that are there, one after the other.
    fn numbers(&self, names: &[&str]) -> Vec<Id> {
        let mut numbers = Vec::new();
        for name in names {
            let given = self.0.iter().filter(|(given, _)| given.name == *name);
            given.for_each(|(_, entries)| numbers.extend(entries));
        }
        numbers
    }

    /// Returns the number of all numbers.
    fn count(&self) -> usize {
        self.0.iter().map(|(_, numbers)| numbers.len()).sum()
    }
}

/// Returns whether derivatives are with respect to an argument of a step.
fn varies(argument: &Argument) -> bool {
    ["q", "qd", "tau", "ctrl", "act"].contains(&argument.name)
}

impl Tracer<'_> {
    /// Returns a step with the product that a function has, as its last results. `refined` is its
    /// [`refined_step`](Self::refined_step).
    #[must_use]
    pub fn step_with_product(
        &self,
        function: Function,
        product: StepProduct,
        step: StepGraph,
        refined: &Graph,
        sizes: &Sizes,
    ) -> StepGraph {
        let of_step = function.row().derivatives_of.expect("a step").row().arguments;
        let mut all = Composition::new();
        let lengths = function.row().arguments.iter().map(|x| (*x, x.shape(sizes).len()));
        let given = Arguments(lengths.map(|(x, length)| (x, all.inputs(length))).collect());
        let parameters = all.inputs(self.parameters.len());
        let before = step.arguments();
        let of_parts = all.inputs(step.results.inputs.end - before);
        let names: Vec<&str> = of_step.iter().map(|argument| argument.name).collect();
        let arguments = given.numbers(&names);
        let mut outputs = all.add(&step.graph, &[&arguments, &parameters, &of_parts]);

        let results = step.results.outputs.clone();
        let (next_q, _) = outputs[results.clone()].split_at(sizes.nq);
        let accelerations = &of_parts[step.results.inputs.start - before..][..sizes.nv];
        let at_solution = of_step.iter().flat_map(|argument| match argument.name {
            "warm_start" => accelerations.to_vec(),
            name => given.numbers(&[name]),
        });
        let solved = Solved {
            next_q: next_q.to_vec(),
            arguments: at_solution.collect(),
            parameters: parameters.clone(),
        };
        let inputs = of_step.iter().map(|argument| TangentInput {
            len: argument.shape(sizes).len(),
            is_coordinates: argument.kind == ArgumentKind::Coordinates,
            varies: varies(argument),
        });
        let states =
            sizes.nq + sizes.nv + if function.row().of_actuators { sizes.activations } else { 0 };
        let mut value = refined.clone();
        value.outputs.truncate(states);
        let graphs = TangentGraphs::new(self, inputs.collect(), value);
        let numbers = match product {
            StepProduct::Gradients => self.gradients_of_step(&mut all, &graphs, &given, &solved),
            StepProduct::Change => self.change_of_step(&mut all, &graphs, &given, &solved),
        };
        let added = given.count() - arguments.len();
        assert_eq!(results.end, outputs.len(), "the results are the last outputs");
        outputs.extend(&numbers);
        let mut step = step.in_graph(all.with_outputs(&[&outputs]), added);
        step.results.outputs.end += numbers.len();
        step
    }

    /// Returns the gradients with respect to the state, then with respect to the joint forces or the
    /// controls.
    fn gradients_of_step(
        &self,
        all: &mut Composition,
        graphs: &TangentGraphs<'_>,
        given: &Arguments,
        Solved { next_q, arguments, parameters }: &Solved,
    ) -> Vec<Id> {
        let nv = self.model.nv;
        let cotangent = given.numbers(&["state_cotangent"]);
        let (of_q, of_qd) = cotangent.split_at(nv);
        let to_velocity = self.qdot_to_velocity();
        let nq = self.model.nq;
        let graph = vjp(&to_velocity, 2 * nq + parameters.len(), nq..2 * nq);
        // The velocity is linear in the rates, which therefore have no effect here.
        let rates = vec![0; nq];
        let of_coordinates = all.add(&graph, &[next_q, &rates, parameters, of_q]);
        let weights = [&of_coordinates[..], of_qd, &given.numbers(&["act_cotangent"])].concat();
        let results = all.add(&graphs.vjp(), &[arguments, &weights, parameters]);
        // The activations are after the controls.
        let (of_state, rest) = results[graphs.value.outputs.len()..].split_at(2 * nv);
        let (of_inputs, of_act) = rest.split_at(graphs.displacements()[2]);
        [of_state, of_act, of_inputs].concat()
    }

    /// Returns the change of the state after the step.
    fn change_of_step(
        &self,
        all: &mut Composition,
        graphs: &TangentGraphs<'_>,
        given: &Arguments,
        Solved { next_q, arguments, parameters }: &Solved,
    ) -> Vec<Id> {
        let changes = given.numbers(&[
            "tangent_q",
            "tangent_qd",
            "tangent_tau",
            "tangent_ctrl",
            "tangent_act",
        ]);
        let change = all.add(&graphs.jvp(), &[arguments, &changes, parameters]);
        let (rates, rest) = change[graphs.value.outputs.len()..].split_at(self.model.nq);
        let displacement = all.add(&self.qdot_to_velocity(), &[next_q, rates, parameters]);
        [&displacement[..], rest].concat()
    }

    /// Returns the graph of the velocities of rates of the coordinates. Inputs: `q` and the rates.
    fn qdot_to_velocity(&self) -> Graph {
        self.trace_groups([self.model.nq; 2], |model, [q, rates]| {
            let mut velocities = vec![Expr::zero(); self.model.nv];
            coordinates::qdot_to_velocity(model, &q, &rates, &mut velocities);
            velocities
        })
    }
}

/// A solved step: the coordinates after it, and its arguments, with the accelerations of the solution
/// to start from.
struct Solved {
    next_q: Vec<Id>,
    arguments: Vec<Id>,
    parameters: Vec<Id>,
}
