//! The graphs of products with derivatives: vector times Jacobian (vjp), and Jacobian times vector (jvp).
//!
//! Derivatives of forward dynamics go through inverse dynamics. With tau = ID(q, qd, qdd) and the mass matrix M, a change
//! of the accelerations is M^-1 (d tau - d ID) at constant accelerations. The product with M^-1 is the derivative of
//! forward dynamics with respect to tau, in which forward dynamics is linear, so it shares the factorization.

use std::ops::Range;

use super::Tracer;
use crate::graph::{Graph, Id, Node};
use crate::passes::{jvp, optimize, vjp};

/// A graph of several graphs, with groups of inputs.
pub(super) struct Composition {
    pub(super) graph: Graph,
    inputs: u32,
}

impl Composition {
    pub(super) fn new() -> Self {
        Self { graph: Graph::default(), inputs: 0 }
    }

    /// Returns the next `count` inputs.
    pub(super) fn inputs(&mut self, count: usize) -> Vec<Id> {
        let first = self.inputs;
        self.inputs += u32::try_from(count).expect("fewer than 2^32 inputs");
        (first..self.inputs).map(|number| self.graph.make(Node::Input(number))).collect()
    }

    /// Adds a graph with these groups of inputs, and returns its outputs.
    pub(super) fn add(&mut self, graph: &Graph, groups: &[&[Id]]) -> Vec<Id> {
        self.graph.compose(graph, &groups.concat())
    }

    pub(super) fn negated(&mut self, x: &[Id]) -> Vec<Id> {
        x.iter().map(|&x| self.graph.make(Node::Neg(x))).collect()
    }

    pub(super) fn difference(&mut self, a: &[Id], b: &[Id]) -> Vec<Id> {
        a.iter().zip(b).map(|(&a, &b)| self.graph.make(Node::Sub(a, b))).collect()
    }

    pub(super) fn sums(&mut self, a: &[Id], b: &[Id]) -> Vec<Id> {
        a.iter().zip(b).map(|(&a, &b)| self.sum(a, b)).collect()
    }

    pub(super) fn sum(&mut self, a: Id, b: Id) -> Id {
        self.graph.make(Node::Add(a, b))
    }

    pub(super) fn product(&mut self, a: Id, b: Id) -> Id {
        self.graph.make(Node::Mul(a, b))
    }

    pub(super) fn constant(&mut self, value: f64) -> Id {
        self.graph.constant(value)
    }

    /// Returns the product of two square matrices of `n` columns, by columns. Consecutive columns share the lanes of a pack.
    pub(super) fn multiply_columns(
        &mut self,
        a: &[Id],
        b: &[Id],
        n: usize,
        lanes: usize,
    ) -> Vec<Id> {
        let mut product = Vec::with_capacity(n * n);
        for columns in b.chunks((n * lanes).max(1)) {
            let columns: Vec<&[Id]> = columns.chunks(n).collect();
            let packed: Vec<Id> = (0..n)
                .map(|k| self.pack(&columns.iter().map(|column| column[k]).collect::<Vec<_>>()))
                .collect();
            let sums = self.multiply_rows((a, n), &packed, n, 0..n);
            for lane in 0..columns.len() {
                product.extend(sums.iter().map(|&sum| self.lane(sum, lane)));
            }
        }
        product
    }

    /// Returns the pack of these numbers; copies of the last one fill it up to a power of two.
    pub(super) fn pack(&mut self, numbers: &[Id]) -> Id {
        let (&[first, ..], Some(&last)) = (numbers, numbers.last()) else {
            unreachable!("a pack has numbers")
        };
        if numbers.len() == 1 {
            return first;
        }
        let width = numbers.len().next_power_of_two();
        let at = |k: usize| numbers.get(k).copied().unwrap_or(last);
        let halves = [0, width / 2].map(|start| (start..start + width / 2).map(at).collect());
        let [a, b]: [Id; 2] = halves.map(|half: Vec<Id>| self.pack(&half));
        self.graph.make(Node::Pack(a, b, u8::try_from(width).expect("few lanes")))
    }

    /// Returns one lane of a pack.
    pub(super) fn lane(&mut self, pack: Id, lane: usize) -> Id {
        self.graph.make(Node::ExtractLane(pack, u8::try_from(lane).expect("few lanes")))
    }

    /// Returns rows of the product of a matrix, given with its number of rows, and a matrix of `n` rows.
    pub(super) fn multiply_rows(
        &mut self,
        (a, height): (&[Id], usize),
        b: &[Id],
        n: usize,
        rows: Range<usize>,
    ) -> Vec<Id> {
        let mut dot = |i: usize, j: usize| {
            (0..n).fold(self.constant(0.0), |sum, k| {
                let product = self.product(a[k * height + i], b[j * n + k]);
                self.sum(sum, product)
            })
        };
        let columns = b.len() / n.max(1);
        let entries = (0..columns).flat_map(|j| rows.clone().map(move |i| (i, j)));
        entries.map(|(i, j)| dot(i, j)).collect()
    }

    /// Returns the scalar product of two vectors.
    pub(super) fn dot(&mut self, a: &[Id], b: &[Id]) -> Id {
        a.iter().zip(b).fold(self.constant(0.0), |sum, (&a, &b)| {
            let product = self.product(a, b);
            self.sum(sum, product)
        })
    }

    /// Returns the vector product.
    pub(super) fn cross(&mut self, a: &[Id], b: &[Id]) -> Vec<Id> {
        let mut entry = |i: usize, j: usize| {
            let (first, second) = (self.product(a[i], b[j]), self.product(a[j], b[i]));
            self.graph.make(Node::Sub(first, second))
        };
        vec![entry(1, 2), entry(2, 0), entry(0, 1)]
    }

    /// Returns factor x, entry by entry.
    pub(super) fn scaled(&mut self, factor: Id, x: &[Id]) -> Vec<Id> {
        x.iter().map(|&x| self.product(factor, x)).collect()
    }

    /// Returns the graph with these groups of outputs.
    pub(super) fn with_outputs(mut self, groups: &[&[Id]]) -> Graph {
        self.graph.outputs = groups.concat();
        self.graph
    }
}

impl Tracer<'_> {
    /// Returns the number of inputs of a function of `q` and `vectors` joint vectors.
    fn inputs(&self, vectors: usize) -> usize {
        self.model.nq + vectors * self.model.nv + self.parameters.len()
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

    /// Returns the gradient with respect to displacements of `q`, in tangent space, from that with respect to the
    /// coordinates.
    fn in_tangent_space(&self, all: &mut Composition, q: &[Id], gradient: &[Id]) -> Vec<Id> {
        let rates = vjp(&self.velocity_to_qdot(), self.inputs(1), self.vector_inputs(0));
        // The rates are linear in the velocities, which therefore have no effect here.
        let rest = vec![0; self.inputs(1) - self.model.nq];
        all.add(&rates, &[q, &rest, gradient])
    }

    /// Returns the graph of the weighted gradients of a function of `q` and joint vectors, by `q` (in tangent space) and by
    /// the `vectors` joint vectors. Inputs: `q`, the joint vectors and the weights.
    pub(super) fn gradient(&self, function: &Graph, vectors: usize) -> Graph {
        let (nq, nv) = (self.model.nq, self.model.nv);
        let mut all = Composition::new();
        let [q, state, weights] = [nq, vectors * nv, nv].map(|count| all.inputs(count));
        let parameters = all.inputs(self.parameters.len());
        let gradients = vjp(function, self.inputs(vectors), self.state(vectors));
        let gradients = all.add(&gradients, &[&q, &state, &parameters, &weights]);
        let (by_q, rest) = gradients.split_at(nq);
        let by_q = self.in_tangent_space(&mut all, &q, by_q);
        all.with_outputs(&[&by_q, rest])
    }

    /// Returns the graph of the joint forces, and of their weighted gradients by `q` (in tangent space), `qd` and `qdd`.
    /// Inputs: `q`, `qd`, `qdd` and the weights.
    #[must_use]
    pub fn inverse_dynamics_vjp(&self) -> Graph {
        let (nq, nv) = (self.model.nq, self.model.nv);
        let inverse = optimize(self.inverse_dynamics());
        let mut all = Composition::new();
        let [q, qd, qdd, weights] = [nq, nv, nv, nv].map(|count| all.inputs(count));
        let parameters = all.inputs(self.parameters.len());
        let tau = all.add(&inverse, &[&q, &qd, &qdd, &parameters]);
        let gradients = self.gradient(&inverse, 2);
        let gradients = all.add(&gradients, &[&q, &qd, &qdd, &weights, &parameters]);
        all.with_outputs(&[&tau, &gradients])
    }

    /// Returns the graph of the joint forces, and of their change. Inputs: `q`, `qd`, `qdd` and their changes, that of `q`
    /// in tangent space.
    #[must_use]
    pub fn inverse_dynamics_jvp(&self) -> Graph {
        let (nq, nv) = (self.model.nq, self.model.nv);
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

    /// Returns the graph of the accelerations, and of their weighted gradients by `q` (in tangent space), `qd` and `tau`.
    /// Inputs: `q`, `qd`, `tau` and the weights. `forward` is the graph of forward dynamics.
    #[must_use]
    pub fn forward_dynamics_vjp(&self, forward: &Graph) -> Graph {
        let (nq, nv) = (self.model.nq, self.model.nv);
        let mut all = Composition::new();
        let [q, qd, tau, weights] = [nq, nv, nv, nv].map(|count| all.inputs(count));
        let parameters = all.inputs(self.parameters.len());
        let qdd = all.add(forward, &[&q, &qd, &tau, &parameters]);
        // M^-1 is symmetric.
        let solve = jvp(forward, self.inputs(2), self.vector_inputs(1));
        let by_tau = all.add(&solve, &[&q, &qd, &tau, &parameters, &weights]);
        let inverse = optimize(self.inverse_dynamics());
        let gradients = vjp(&inverse, self.inputs(2), self.state(1));
        let gradients = all.add(&gradients, &[&q, &qd, &qdd, &parameters, &by_tau]);
        let gradients = all.negated(&gradients);
        let (by_q, by_qd) = gradients.split_at(nq);
        let by_q = self.in_tangent_space(&mut all, &q, by_q);
        all.with_outputs(&[&qdd, &by_q, by_qd, &by_tau])
    }

    /// Returns the graph of the accelerations, and of their change. Inputs: `q`, `qd`, `tau` and their changes, that of `q`
    /// in tangent space. `forward` is the graph of forward dynamics.
    #[must_use]
    pub fn forward_dynamics_jvp(&self, forward: &Graph) -> Graph {
        let (nq, nv) = (self.model.nq, self.model.nv);
        let mut all = Composition::new();
        let [q, qd, tau, dq, dqd, dtau] = [nq, nv, nv, nv, nv, nv].map(|count| all.inputs(count));
        let parameters = all.inputs(self.parameters.len());
        let qdd = all.add(forward, &[&q, &qd, &tau, &parameters]);
        let dq = all.add(&self.velocity_to_qdot(), &[&q, &dq, &parameters]);
        let change = jvp(&optimize(self.inverse_dynamics()), self.inputs(2), self.state(1));
        let change = all.add(&change, &[&q, &qd, &qdd, &parameters, &dq, &dqd]);
        let unmet = all.difference(&dtau, &change);
        let solve = jvp(forward, self.inputs(2), self.vector_inputs(1));
        let dqdd = all.add(&solve, &[&q, &qd, &tau, &parameters, &unmet]);
        all.with_outputs(&[&qdd, &dqdd])
    }
}
