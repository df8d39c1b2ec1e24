//! The graphs of functions of plain numbers, and of their derivatives by every entry of their
//! inputs.
//!
//! Other graphs of derivatives are in tangent space. A library that differentiates by plain
//! numbers, as `CasADi` does, has four entries for a quaternion, whose length is 1 at a solution
//! only. Here a function scales quaternions to length 1 first. So it has a value at any length, and
//! its derivatives by all four entries are the derivatives of this value: the derivative along the
//! quaternion is zero.
//!
//! A *family* is a function with the functions of its derivatives. The Jacobian of forward dynamics
//! is the closed form, with each quaternion's tangent written in its entries. The Hessian goes
//! through second derivatives of inverse dynamics.

use modyn_runtime::equations::brge::UduLayout;
use modyn_runtime::mechanism::coordinates::CoordinateSpace;

use super::Tracer;
use super::composition::Composition;
use super::products::ForwardDynamics;
use crate::graph::step::StepGraph;
use crate::graph::{Graph, Id, Node};
use crate::passes::{hessian, jacobian, jvp, optimize, vjp};

/// The gains of the feedback of a time step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Gains {
    /// A matrix: the forces by the difference of states.
    Matrix,
    /// For the force of each entry of the velocities a gain of its own difference of coordinates, in the
    /// first row, and of its own difference of velocities, in the second row.
    Diagonal,
}

impl Gains {
    /// Returns the number of rows and of columns.
    #[must_use]
    pub fn shape(self, nv: usize) -> [usize; 2] {
        match self {
            Self::Matrix => [nv, 2 * nv],
            Self::Diagonal => [2, nv],
        }
    }

    /// Returns the number of gains.
    #[must_use]
    pub fn count(self, nv: usize) -> usize {
        self.shape(nv).into_iter().product()
    }
}

/// The graphs of a function and of its derivatives with respect to its inputs, plain numbers.
pub struct EntryDerivatives {
    /// The function.
    pub value: Graph,
    /// The derivatives of the outputs, by columns: a column for each input.
    pub jacobian: Graph,
    /// The change of the outputs. Further inputs: the changes of all inputs.
    pub forward: Graph,
    /// The gradient of a weighted sum of the outputs. Further inputs: the weights.
    pub adjoint: Graph,
    /// The second derivatives of a weighted sum of the outputs, a symmetric matrix by columns.
    /// Further inputs: the weights. `None` if they take too many operations.
    pub hessian: Option<Graph>,
}

/// A derivative of a function of plain numbers, as [`EntryDerivatives`] has them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EntryForm {
    /// [`EntryDerivatives::jacobian`].
    Jacobian,
    /// [`EntryDerivatives::forward`].
    Forward,
    /// [`EntryDerivatives::adjoint`].
    Adjoint,
    /// [`EntryDerivatives::hessian`].
    Hessian,
}

impl EntryDerivatives {
    /// Returns the graphs of a function of `inputs` numbers, by differentiation of its graph. The
    /// second derivatives have at most `max_operations` operations, or are left out.
    #[must_use]
    pub fn new(value: Graph, inputs: usize, max_operations: usize) -> Self {
        let jacobian = jacobian(&value, inputs, 0..inputs);
        Self::with_jacobian(value, inputs, jacobian, max_operations)
    }

    fn with_jacobian(value: Graph, inputs: usize, jacobian: Graph, max_operations: usize) -> Self {
        let adjoint = vjp(&value, inputs, 0..inputs);
        Self {
            forward: jvp(&value, inputs, 0..inputs),
            hessian: hessian(&adjoint, inputs + value.outputs.len(), max_operations),
            value,
            jacobian,
            adjoint,
        }
    }
}

/// Returns the graph of the Jacobian of a gradient by the function's inputs and then by the
/// weights, by columns: the Hessian, then the transposed Jacobian. `columns` is the number of
/// inputs, `rows` the number of results.
#[must_use]
pub fn second_derivatives(hessian: &Graph, jacobian: &Graph, columns: usize, rows: usize) -> Graph {
    let mut all = Graph::default();
    let given = all.inputs(0..columns + rows);
    let mut outputs = all.compose(hessian, &given);
    let first = all.compose(jacobian, &given);
    outputs.extend(
        (0..rows)
            .flat_map(|row| (0..columns).map(move |x| (row, x)))
            .map(|(row, column)| first[column * rows + row]),
    );
    all.outputs = outputs;
    all
}

impl Tracer<'_> {
    /// Returns the graph of a function of `inputs` numbers with quaternions of length 1.
    /// `coordinates` are the first inputs of the function's vectors of coordinates.
    #[must_use]
    pub fn with_unit_quaternions(
        &self,
        graph: &Graph,
        coordinates: &[usize],
        inputs: usize,
    ) -> Graph {
        let normalize_configuration = self.normalize_configuration();
        let mut all = Composition::new();
        let mut given = all.inputs(inputs);
        for &first in coordinates {
            let q = first..first + self.model.nq;
            let unit = all.add(&normalize_configuration, &[&given[q.clone()]]);
            given[q].copy_from_slice(&unit);
        }
        let outputs = all.add(graph, &[&given]);
        all.with_outputs(&[&outputs])
    }

    /// Returns the graph of a time step with the extras of a rollout. `step` and `difference` are
    /// the graphs of the step and of the difference of coordinates.
    ///
    /// With a feedback, the forces are `controls` + `gains` (x_ref - x), where the difference of
    /// states has the difference of the coordinates in tangent space, then the difference of the
    /// velocities. With a cost, the state has one number more, which grows by the sum of
    /// `state_weights` (x_goal - x)^2 over the state after the step and of `control_weights`
    /// forces^2.
    ///
    /// Inputs: `q`, `qd`; of a cost `cost`; `controls`, `dt`, and as many `settings`; of a feedback
    /// `gains` (by rows), `q_ref`, `qd_ref`; of a cost `q_goal`, `qd_goal`,
    /// `state_weights`, `control_weights`; the parameters.
    #[must_use]
    pub fn with_extras(
        &self,
        feedback: Option<Gains>,
        cost: bool,
        settings: usize,
        step: &Graph,
        difference: &Graph,
    ) -> Graph {
        let nq = self.model.nq;
        let nv = self.model.nv;
        let mut all = Composition::new();
        let [q, qd] = [nq, nv].map(|count| all.inputs(count));
        let before = all.inputs(usize::from(cost));
        let [controls, dt, settings] = [nv, 1, settings].map(|count| all.inputs(count));
        let reference =
            feedback.map(|gains| [gains.count(nv), nq, nv].map(|count| all.inputs(count)));
        let goal = cost.then(|| [nq, nv, 2 * nv, nv].map(|count| all.inputs(count)));
        let parameters = all.inputs(self.parameters.len());
        let forces = match &reference {
            None => controls,
            Some(reference) => {
                let state = [&*q, &*qd, &*parameters];
                self.fed_back(&mut all, difference, &controls, state, reference)
            }
        };
        let next = all.add(step, &[&q, &qd, &forces, &dt, &settings, &parameters]);
        let Some([q_goal, qd_goal, state_weights, control_weights]) = goal else {
            return all.with_outputs(&[&next]);
        };
        let mut error = all.add(difference, &[&next[..nq], &q_goal, &parameters]);
        error.extend(all.difference(&qd_goal, &next[nq..]));
        let numbers = [error, forces].concat();
        let weights = [state_weights, control_weights].concat();
        let weighted: Vec<Id> =
            weights.iter().zip(&numbers).map(|(&weight, &x)| all.product(weight, x)).collect();
        let added = all.dot(&weighted, &numbers);
        let after = all.sums(&before, &[added]);
        all.with_outputs(&[&next, &after])
    }

    /// Returns a step with soft constraints and a feedback, which
    /// [`with_extras`](Self::with_extras) describes: `gains`, `q_ref` and `qd_ref` are inputs after
    /// the settings.
    #[must_use]
    pub fn step_with_feedback(
        &self,
        step: StepGraph,
        gains: Gains,
        difference: &Graph,
    ) -> StepGraph {
        let nq = self.model.nq;
        let nv = self.model.nv;
        let arguments = step.arguments();
        let others = arguments - self.parameters.len() - nq - 2 * nv;
        let mut all = Composition::new();
        let [q, qd, controls, others] = [nq, nv, nv, others].map(|count| all.inputs(count));
        let reference = [gains.count(nv), nq, nv].map(|count| all.inputs(count));
        let added: usize = reference.iter().map(Vec::len).sum();
        let parameters = all.inputs(self.parameters.len());
        let of_parts = all.inputs(step.results.inputs.end - arguments);
        let state = [&*q, &*qd, &*parameters];
        let forces = self.fed_back(&mut all, difference, &controls, state, &reference);
        let groups = [&*q, &*qd, &*forces, &*others, &*parameters, &*of_parts];
        let outputs = all.add(&step.graph, &groups);
        let graph = all.with_outputs(&[&outputs]);
        step.in_graph(graph, added)
    }

    /// Returns the joint forces `controls` + `gains` (x_ref - x). The state is `q`, `qd` and the
    /// parameters, the reference `gains`, `q_ref` and `qd_ref`.
    fn fed_back(
        &self,
        all: &mut Composition,
        difference: &Graph,
        controls: &[Id],
        [q, qd, parameters]: [&[Id]; 3],
        [gains, q_ref, qd_ref]: &[Vec<Id>; 3],
    ) -> Vec<Id> {
        let mut error = all.add(difference, &[q, q_ref, parameters]);
        error.extend(all.difference(qd_ref, qd));
        let nv = self.model.nv;
        // With one velocity both forms have the same two gains.
        let feedback: Vec<Id> = if gains.len() == Gains::Diagonal.count(nv) {
            let entry = |k: usize| all.dot(&[gains[k], gains[nv + k]], &[error[k], error[nv + k]]);
            (0..nv).map(entry).collect()
        } else {
            gains.chunks(2 * nv).map(|row| all.dot(row, &error)).collect()
        };
        all.sums(controls, &feedback)
    }

    /// Returns the graph of inverse dynamics with quaternions of length 1.
    #[must_use]
    pub fn inverse_dynamics_of_entries(&self) -> Graph {
        let inputs = self.dynamics_inputs();
        self.with_unit_quaternions(&optimize(self.inverse_dynamics()), &[0], inputs.all)
    }

    /// Returns inverse dynamics and its derivatives. The Jacobian has the derivatives in closed
    /// form. The second derivatives have at most `max_operations` operations, or are left out.
    #[must_use]
    pub fn inverse_dynamics_by_entries(&self, max_operations: usize) -> EntryDerivatives {
        let value = self.inverse_dynamics_of_entries();
        let jacobian = self.inverse_dynamics_jacobian_by_entries(&value);
        EntryDerivatives::with_jacobian(value, self.dynamics_inputs().all, jacobian, max_operations)
    }

    /// Returns the derivatives of inverse dynamics in closed form, by columns: a column for each
    /// input. `value` is the graph of inverse dynamics with quaternions of length 1.
    #[must_use]
    pub fn inverse_dynamics_jacobian_by_entries(&self, value: &Graph) -> Graph {
        let nv = self.model.nv;
        let inputs = self.dynamics_inputs();
        let mut all = Composition::new();
        let x = all.inputs(inputs.all);
        let (q, rest) = x.split_at(inputs.q.end);
        let unit = all.add(&self.normalize_configuration(), &[q]);
        let derivative_graph = optimize(self.inverse_dynamics_derivatives());
        let derivatives = all.add(&derivative_graph, &[&unit, rest]);
        let (dq, dqd) = derivatives.split_at(nv * nv);
        let dq = self.by_entries(&mut all, q, &unit, dq);
        let parameters = &x[inputs.last.end..];
        let mass = all.add(&optimize(self.mass_matrix()), &[&unit, parameters]);
        let graph = jacobian(value, inputs.all, inputs.last.end..inputs.all);
        let by_parameters = all.add(&graph, &[&x]);
        all.with_outputs(&[&dq, dqd, &mass, &by_parameters])
    }

    /// Returns one graph of the derivatives of forward dynamics, as [`forward_dynamics_by_entries`]
    /// does; `None` if there are second derivatives of more than `max_operations`.
    ///
    /// [`forward_dynamics_by_entries`]: Self::forward_dynamics_by_entries
    #[must_use]
    pub fn forward_dynamics_form_by_entries(
        &self,
        form: EntryForm,
        forward: &Graph,
        layout: &UduLayout,
        max_operations: usize,
    ) -> Option<Graph> {
        let value = || self.with_unit_quaternions(forward, &[0], self.dynamics_inputs().all);
        let inverse = self.inverse_dynamics_of_entries();
        match form {
            EntryForm::Jacobian => {
                let mut jacobian = self.forward_dynamics_in_closed_form(&inverse, layout);
                jacobian.outputs.drain(..self.model.nv);
                Some(jacobian)
            }
            EntryForm::Forward => Some(self.forward_change(&value(), &inverse)),
            EntryForm::Adjoint => Some(self.forward_adjoint(&value(), &inverse)),
            EntryForm::Hessian => {
                let closed = self.forward_dynamics_in_closed_form(&inverse, layout);
                self.forward_hessian(&closed, &inverse, max_operations)
            }
        }
    }

    /// Returns forward dynamics and its derivatives. `forward` is the graph of forward dynamics,
    /// and `layout` the factorization of the mass matrix for the derivatives in closed form. The
    /// second derivatives have at most `max_operations` operations, or are left out.
    ///
    /// With tau = ID(z, qdd), where z are `q`, `qd` and the parameters, the derivatives of the
    /// accelerations go through inverse dynamics. mu is the product of the inverse mass matrix and
    /// the weights, and D the Jacobian of the accelerations. The Hessian of the weighted
    /// accelerations then is -(A + C^T D + D^T C), where A and C are the second derivatives of mu^T
    /// ID by z and z, and by qdd and z. Forward dynamics itself is differentiated by nothing but
    /// `tau`.
    #[must_use]
    pub fn forward_dynamics_by_entries(
        &self,
        forward: &Graph,
        layout: &UduLayout,
        max_operations: usize,
    ) -> EntryDerivatives {
        let nv = self.model.nv;
        let inputs = self.dynamics_inputs();
        let value = self.with_unit_quaternions(forward, &[0], inputs.all);
        let inverse = self.inverse_dynamics_of_entries();
        let closed = self.forward_dynamics_in_closed_form(&inverse, layout);
        let mut jacobian = closed.clone();
        jacobian.outputs.drain(..nv);
        EntryDerivatives {
            forward: self.forward_change(&value, &inverse),
            adjoint: self.forward_adjoint(&value, &inverse),
            hessian: self.forward_hessian(&closed, &inverse, max_operations),
            value,
            jacobian,
        }
    }

    /// Returns the graph of the accelerations, then of their derivatives by all inputs, by columns.
    fn forward_dynamics_in_closed_form(&self, inverse: &Graph, layout: &UduLayout) -> Graph {
        let nv = self.model.nv;
        let inputs = self.dynamics_inputs();
        let mut all = Composition::new();
        let x = all.inputs(inputs.all);
        let (q, rest) = x.split_at(inputs.q.end);
        let unit = all.add(&self.normalize_configuration(), &[q]);
        let graph = optimize(self.forward_dynamics_derivatives(layout));
        let derivatives = all.add(&graph, &[&unit, rest]);
        let (qdd, matrices) = derivatives.split_at(nv);
        let (dq, matrices) = matrices.split_at(nv * nv);
        let (_, dtau) = matrices.split_at(nv * nv);
        let dq = self.by_entries(&mut all, q, &unit, dq);
        let by_parameters = jacobian(inverse, inputs.all, inputs.last.end..inputs.all);
        let forces = all.add(&by_parameters, &[&inputs.with_accelerations(&x, qdd)]);
        let mut by_parameters = Vec::new();
        for column in forces.chunks(nv) {
            by_parameters.extend((0..nv).map(|row| {
                let products = (0..nv).map(|k| (dtau[k * nv + row], column[k]));
                let sum = all.graph.sum_of_products(products);
                all.graph.make(Node::Neg(sum))
            }));
        }
        all.with_outputs(&[qdd, &dq, matrices, &by_parameters])
    }

    /// Returns the graph of the change of the accelerations.
    fn forward_change(&self, value: &Graph, inverse: &Graph) -> Graph {
        let inputs = self.dynamics_inputs();
        let mut all = Composition::new();
        let x = all.inputs(inputs.all);
        let dx = all.inputs(inputs.all);
        let dynamics = ForwardDynamics::new(&mut all, inputs.clone(), value, inverse, x);
        let zeros = vec![all.constant(0.0); dynamics.qdd.len()];
        let dz = inputs.with_accelerations(&dx, &zeros);
        let change = dynamics.change(&mut all, &dx[inputs.last], 0..inputs.all, &dz);
        all.with_outputs(&[&change])
    }

    /// Returns the graph of the gradient of weighted accelerations.
    fn forward_adjoint(&self, value: &Graph, inverse: &Graph) -> Graph {
        let inputs = self.dynamics_inputs();
        let mut all = Composition::new();
        let x = all.inputs(inputs.all);
        let weights = all.inputs(self.model.nv);
        let dynamics = ForwardDynamics::new(&mut all, inputs.clone(), value, inverse, x);
        let (by_tau, gradients) = dynamics.gradients(&mut all, &weights, 0..inputs.all);
        all.with_outputs(&[&inputs.with_accelerations(&gradients, &by_tau)])
    }

    /// Returns the graph of the second derivatives of weighted accelerations. `closed` is the graph
    /// of the accelerations and their derivatives. Returns `None` if it takes more than
    /// `max_operations`.
    fn forward_hessian(
        &self,
        closed: &Graph,
        inverse: &Graph,
        max_operations: usize,
    ) -> Option<Graph> {
        let nv = self.model.nv;
        let inputs = self.dynamics_inputs();
        let size = inputs.all;
        let mut all = Composition::new();
        let x = all.inputs(size);
        let weights = all.inputs(nv);
        let results = all.add(closed, &[&x]);
        let (qdd, d) = results.split_at(nv);
        let by_tau = &d[inputs.last.start * nv..inputs.last.end * nv];
        let mu: Vec<Id> = (by_tau.chunks(nv))
            .map(|column| {
                let products = column.iter().copied().zip(weights.iter().copied());
                all.graph.sum_of_products(products)
            })
            .collect();
        let gradient = vjp(inverse, size, 0..size);
        let mut change = jvp(&gradient, size + nv, 0..size);
        let changes = std::mem::take(&mut change.outputs);
        let motion = inputs.with_accelerations(&x, qdd);
        // For each input of inverse dynamics but the accelerations, the change of the gradient by
        // the inputs from there on, which is a column of A, and of the gradient by the
        // accelerations, which is a column of C.
        let mut a = vec![Vec::new(); size];
        let mut c = vec![Vec::new(); size];
        for column in (0..size).filter(|column| !inputs.last.contains(column)) {
            let of_c = &changes[inputs.last.clone()];
            change.outputs = [&changes[column..], of_c].concat();
            let unit = all.graph.unit_vector(size, column);
            a[column] = all.add(&change, &[&motion, &mu, &unit]);
            c[column] = a[column].split_off(size - column);
            all.graph.outputs.extend(a[column].iter().chain(&c[column]));
            if all.graph.takes_more_than(max_operations) {
                return None;
            }
        }
        let mut matrix = vec![0; size * size];
        for column in 0..size {
            for row in column..size {
                let by = |x: usize| (0..nv).map(move |k| d[x * nv + k]);
                let products = |x: usize, y: usize| c[x].iter().copied().zip(by(y));
                let terms = products(row, column).chain(products(column, row));
                let mut sum = all.graph.sum_of_products(terms);
                if !inputs.last.contains(&row)
                    && let Some(&second) = a[column].get(row - column)
                {
                    sum = all.graph.make(Node::Add(sum, second));
                }
                let entry = all.graph.make(Node::Neg(sum));
                matrix[column * size + row] = entry;
                matrix[row * size + column] = entry;
            }
            all.graph.outputs.extend(&matrix[column * size..][..size]);
            if all.graph.takes_more_than(max_operations) {
                return None;
            }
        }
        Some(all.with_outputs(&[&matrix]))
    }

    /// Returns a matrix of derivatives by the entries of `q`, from the derivatives in tangent space
    /// at the coordinates `unit` with quaternions of length 1; both by columns.
    ///
    /// The rates of coordinates are T v. For a quaternion n of length 1, T^T T is 1/4, for other
    /// coordinates 1. So a change of the entries of a quaternion q = |q| n is 4 T^T dq / |q| in
    /// tangent space; the part along n has no effect.
    fn by_entries(&self, all: &mut Composition, q: &[Id], unit: &[Id], dq: &[Id]) -> Vec<Id> {
        let nq = self.model.nq;
        let nv = self.model.nv;
        let graph = self.velocity_to_qdot();
        let rates: Vec<Vec<Id>> = (0..nv)
            .map(|k| {
                let velocity = all.graph.unit_vector(nv, k);
                all.add(&graph, &[unit, &velocity])
            })
            .collect();
        let mut scales = vec![None; nq];
        for block in &self.model.coordinates {
            let first = match block.space {
                CoordinateSpace::Line { .. } => continue,
                CoordinateSpace::Rotation => block.q,
                CoordinateSpace::Pose => block.q + 3,
            };
            let entries = first..first + 4;
            let squares = entries.clone().map(|i| (q[i], q[i]));
            let square = all.graph.sum_of_products(squares);
            let length = all.graph.make(Node::Sqrt(square));
            let inverse = all.graph.make(Node::Recip(length));
            let four = all.graph.constant(4.0);
            scales[entries].fill(Some(all.graph.make(Node::Mul(four, inverse))));
        }
        let mut columns = Vec::with_capacity(nq * nv);
        for (entry, scale) in scales.into_iter().enumerate() {
            for row in 0..nv {
                let products = (0..nv).map(|k| (rates[k][entry], dq[k * nv + row]));
                let sum = all.graph.sum_of_products(products);
                columns.push(scale.map_or(sum, |scale| all.graph.make(Node::Mul(scale, sum))));
            }
        }
        columns
    }
}
