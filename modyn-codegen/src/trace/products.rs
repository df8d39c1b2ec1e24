//! The graphs of products with derivatives: vector times Jacobian (vjp), and Jacobian times vector
//! (jvp).
//!
//! Derivatives of forward dynamics go through inverse dynamics. With tau = ID(q, qd, qdd) and the
//! mass matrix M, a change of the accelerations is M^-1 (d tau - d ID) at constant accelerations.
//! The product with M^-1 is the derivative of forward dynamics with respect to tau, in which
//! forward dynamics is linear, so it shares the factorization.
//!
//! Inverse dynamics is differentiated with the accelerations as inputs, and composed with forward
//! dynamics afterwards (`Graph::compose`): composed before, folding could cancel the two.

use std::ops::Range;

use super::Tracer;
use super::composition::Composition;
use crate::graph::{Graph, Id};
use crate::passes::{jvp, optimize, vjp};

/// The inputs of forward and inverse dynamics: `q`, `qd`, then `tau` or the accelerations, then the
/// run-time parameters.
#[derive(Clone)]
pub(super) struct DynamicsInputs {
    pub q: Range<usize>,
    /// The inputs that are joint forces of forward dynamics, and accelerations of inverse dynamics.
    pub last: Range<usize>,
    pub all: usize,
}

impl DynamicsInputs {
    /// Returns the inputs with the accelerations in place of the joint forces.
    pub fn with_accelerations(&self, x: &[Id], qdd: &[Id]) -> Vec<Id> {
        [&x[..self.last.start], qdd, &x[self.last.end..]].concat()
    }
}

/// Forward dynamics at one point, whose derivatives go through inverse dynamics.
pub(super) struct ForwardDynamics<'a> {
    inputs: DynamicsInputs,
    forward: &'a Graph,
    inverse: &'a Graph,
    /// The inputs of forward dynamics.
    point: Vec<Id>,
    /// The accelerations.
    pub qdd: Vec<Id>,
}

impl<'a> ForwardDynamics<'a> {
    /// Adds forward dynamics at `point` to a graph. `forward` and `inverse` are the graphs of
    /// forward and inverse dynamics.
    pub fn new(
        all: &mut Composition,
        inputs: DynamicsInputs,
        forward: &'a Graph,
        inverse: &'a Graph,
        point: Vec<Id>,
    ) -> Self {
        let qdd = all.add(forward, &[&point]);
        Self { inputs, forward, inverse, point, qdd }
    }

    /// Returns the product of the inverse mass matrix and joint forces.
    fn solve(&self, all: &mut Composition, forces: &[Id]) -> Vec<Id> {
        let solve = jvp(self.forward, self.inputs.all, self.inputs.last.clone());
        all.add(&solve, &[&self.point, forces])
    }

    /// Returns the change of the accelerations, M^-1 (d tau - d ID), under the change `dtau` of the
    /// joint forces and the changes `dz` of the inputs `wrt` of inverse dynamics. The accelerations
    /// among these must have no change.
    pub fn change(
        &self,
        all: &mut Composition,
        dtau: &[Id],
        wrt: Range<usize>,
        dz: &[Id],
    ) -> Vec<Id> {
        let motion = self.inputs.with_accelerations(&self.point, &self.qdd);
        let graph = jvp(self.inverse, self.inputs.all, wrt);
        let change = all.add(&graph, &[&motion, dz]);
        let unmet = all.difference(dtau, &change);
        self.solve(all, &unmet)
    }

    /// Returns the gradients of weighted accelerations: by `tau`, mu = M^-1 w, and by the inputs
    /// `wrt` of inverse dynamics, -d (mu^T ID).
    pub fn gradients(
        &self,
        all: &mut Composition,
        weights: &[Id],
        wrt: Range<usize>,
    ) -> (Vec<Id>, Vec<Id>) {
        // M^-1 is symmetric.
        let by_tau = self.solve(all, weights);
        let motion = self.inputs.with_accelerations(&self.point, &self.qdd);
        let gradients = vjp(self.inverse, self.inputs.all, wrt);
        let along_motion = all.add(&gradients, &[&motion, &by_tau]);
        let gradients = all.negated(&along_motion);
        (by_tau, gradients)
    }
}

/// Inverse dynamics with its weighted gradients.
pub(super) struct WeightedInverseDynamics {
    /// The graph of all this.
    pub all: Composition,
    /// The joint forces.
    pub tau: Vec<Id>,
    /// The graph of the gradients, as [`Tracer::gradient`] returns it.
    pub gradient: Graph,
    /// The inputs of that graph: `q`, `qd`, `qdd`, the weights and the run-time parameters.
    pub point: Vec<Id>,
    /// The gradients by `q` (in tangent space), `qd` and `qdd`.
    pub gradients: Vec<Id>,
}

impl Tracer<'_> {
    /// Returns the number of inputs of a function of `q` and `vectors` joint vectors.
    fn inputs(&self, vectors: usize) -> usize {
        self.model.nq + vectors * self.model.nv + self.parameters.len()
    }

    /// Returns the inputs of forward and inverse dynamics.
    pub(super) fn dynamics_inputs(&self) -> DynamicsInputs {
        DynamicsInputs { q: 0..self.model.nq, last: self.vector_inputs(1), all: self.inputs(2) }
    }

    /// Returns the inputs that are `q` and the first `vectors` joint vectors.
    pub(super) fn state(&self, vectors: usize) -> Range<usize> {
        0..self.model.nq + vectors * self.model.nv
    }

    /// Returns the input numbers of joint vector `k`.
    fn vector_inputs(&self, k: usize) -> Range<usize> {
        let first = self.model.nq + k * self.model.nv;
        first..first + self.model.nv
    }

    /// Returns the gradient with respect to displacements of `q`, in tangent space, from that with
    /// respect to the coordinates.
    pub(super) fn in_tangent_space(
        &self,
        all: &mut Composition,
        q: &[Id],
        gradient: &[Id],
    ) -> Vec<Id> {
        let rates = vjp(&self.velocity_to_qdot(), self.inputs(1), self.vector_inputs(0));
        // The rates are linear in the velocities, which therefore have no effect here.
        let rest = vec![0; self.inputs(1) - self.model.nq];
        all.add(&rates, &[q, &rest, gradient])
    }

    /// Returns the graph of the weighted gradients of a function of `q` and joint vectors, by `q`
    /// (in tangent space) and by the `vectors` joint vectors. Inputs: `q`, the joint vectors and
    /// the weights.
    pub(super) fn gradient(&self, function: &Graph, vectors: usize) -> Graph {
        let nq = self.model.nq;
        let nv = self.model.nv;
        let mut all = Composition::new();
        let [q, state, weights] = [nq, vectors * nv, nv].map(|count| all.inputs(count));
        let parameters = all.inputs(self.parameters.len());
        let graph = vjp(function, self.inputs(vectors), self.state(vectors));
        let gradients = all.add(&graph, &[&q, &state, &parameters, &weights]);
        let (by_q, rest) = gradients.split_at(nq);
        let by_q = self.in_tangent_space(&mut all, &q, by_q);
        all.with_outputs(&[&by_q, rest])
    }

    /// Returns inverse dynamics with its weighted gradients. Inputs: `q`, `qd`, `qdd` and the
    /// weights.
    pub(super) fn weighted_inverse_dynamics(&self) -> WeightedInverseDynamics {
        let nq = self.model.nq;
        let nv = self.model.nv;
        let inverse = optimize(self.inverse_dynamics());
        let mut all = Composition::new();
        let [q, qd, qdd, weights] = [nq, nv, nv, nv].map(|count| all.inputs(count));
        let parameters = all.inputs(self.parameters.len());
        let tau = all.add(&inverse, &[&q, &qd, &qdd, &parameters]);
        let gradient = self.gradient(&inverse, 2);
        let point = [q, qd, qdd, weights, parameters].concat();
        let gradients = all.add(&gradient, &[&point]);
        WeightedInverseDynamics { all, tau, gradient, point, gradients }
    }

    /// Returns the graph of the joint forces, and of their weighted gradients by `q` (in tangent
    /// space), `qd` and `qdd`. Inputs: `q`, `qd`, `qdd` and the weights.
    #[must_use]
    pub fn inverse_dynamics_vjp(&self) -> Graph {
        let WeightedInverseDynamics { all, tau, gradients, .. } = self.weighted_inverse_dynamics();
        all.with_outputs(&[&tau, &gradients])
    }

    /// Returns the graph of the joint forces, and of their change. Inputs: `q`, `qd`, `qdd` and
    /// their changes, the change of `q` in tangent space.
    #[must_use]
    pub fn inverse_dynamics_jvp(&self) -> Graph {
        let nq = self.model.nq;
        let nv = self.model.nv;
        let inverse = optimize(self.inverse_dynamics());
        let mut all = Composition::new();
        let [q, qd, qdd, dq, dqd, dqdd] = [nq, nv, nv, nv, nv, nv].map(|count| all.inputs(count));
        let parameters = all.inputs(self.parameters.len());
        let tau = all.add(&inverse, &[&q, &qd, &qdd, &parameters]);
        let dq = all.add(&self.velocity_to_qdot(), &[&q, &dq, &parameters]);
        let change = jvp(&inverse, self.inputs(2), self.state(2));
        let dtau = all.add(&change, &[&q, &qd, &qdd, &parameters, &dq, &dqd, &dqdd]);
        all.with_outputs(&[&tau, &dtau])
    }

    /// Returns the graph of the accelerations, and of their weighted gradients by `q` (in tangent
    /// space), `qd` and `tau`. Inputs: `q`, `qd`, `tau` and the weights. `forward` is the graph of
    /// forward dynamics.
    #[must_use]
    pub fn forward_dynamics_vjp(&self, forward: &Graph) -> Graph {
        let nq = self.model.nq;
        let nv = self.model.nv;
        let mut all = Composition::new();
        let [q, qd, tau, weights] = [nq, nv, nv, nv].map(|count| all.inputs(count));
        let parameters = all.inputs(self.parameters.len());
        let inverse = optimize(self.inverse_dynamics());
        let point = [&q[..], &qd, &tau, &parameters].concat();
        let dynamics =
            ForwardDynamics::new(&mut all, self.dynamics_inputs(), forward, &inverse, point);
        let (by_tau, gradients) = dynamics.gradients(&mut all, &weights, self.state(1));
        let (by_q, by_qd) = gradients.split_at(nq);
        let by_q = self.in_tangent_space(&mut all, &q, by_q);
        all.with_outputs(&[&dynamics.qdd, &by_q, by_qd, &by_tau])
    }

    /// Returns the graph of the accelerations, and of their change. Inputs: `q`, `qd`, `tau` and
    /// their changes, the change of `q` in tangent space. `forward` is the graph of forward
    /// dynamics.
    #[must_use]
    pub fn forward_dynamics_jvp(&self, forward: &Graph) -> Graph {
        let nq = self.model.nq;
        let nv = self.model.nv;
        let mut all = Composition::new();
        let [q, qd, tau, dq, dqd, dtau] = [nq, nv, nv, nv, nv, nv].map(|count| all.inputs(count));
        let parameters = all.inputs(self.parameters.len());
        let inverse = optimize(self.inverse_dynamics());
        let point = [&q[..], &qd, &tau, &parameters].concat();
        let dynamics =
            ForwardDynamics::new(&mut all, self.dynamics_inputs(), forward, &inverse, point);
        let dq = all.add(&self.velocity_to_qdot(), &[&q, &dq, &parameters]);
        let changes = [dq, dqd].concat();
        let dqdd = dynamics.change(&mut all, &dtau, self.state(1), &changes);
        all.with_outputs(&[&dynamics.qdd, &dqdd])
    }
}
