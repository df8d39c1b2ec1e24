//! Graphs that are put together from graphs.

use crate::graph::{Graph, Id, Node};

/// A graph of several graphs, with groups of inputs.
pub(super) struct Composition {
    pub(super) graph: Graph,
    inputs: usize,
}

impl Composition {
    pub(super) fn new() -> Self {
        Self { graph: Graph::default(), inputs: 0 }
    }

    /// Returns the next `count` inputs.
    pub(super) fn inputs(&mut self, count: usize) -> Vec<Id> {
        let first = self.inputs;
        self.inputs += count;
        self.graph.inputs(first..self.inputs)
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

    /// Returns the product of two square matrices of `n` columns, by columns.
    pub(super) fn multiply(&mut self, a: &[Id], b: &[Id], n: usize) -> Vec<Id> {
        let mut dot = |i: usize, j: usize| {
            self.graph.sum_of_products((0..n).map(|k| (a[k * n + i], b[j * n + k])))
        };
        (0..n * n).map(|k| dot(k % n, k / n)).collect()
    }

    /// Returns the graph with these groups of outputs.
    pub(super) fn with_outputs(mut self, groups: &[&[Id]]) -> Graph {
        self.graph.outputs = groups.concat();
        self.graph
    }
}
