//! Graphs that are put together from graphs.

use std::ops::Range;

use crate::graph::{Graph, Id, Node};

/// A graph of several graphs, with groups of inputs.
pub(super) struct Composition {
    pub(super) graph: Graph,
    /// The number of inputs.
    pub(super) inputs: usize,
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

    /// Returns the product of two square matrices of `n` columns, by columns. Consecutive columns
    /// share the lanes of a pack.
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
            let sums = self.multiply_rows(a, n, &packed, n, 0..n);
            for lane in 0..columns.len() {
                product.extend(sums.iter().map(|&sum| self.lane(sum, lane)));
            }
        }
        product
    }

    /// Returns the pack of these numbers; copies of the last one fill it up to a power of two.
    pub(super) fn pack(&mut self, numbers: &[Id]) -> Id {
        let (first, last) = match *numbers {
            [number] => return number,
            [first, .., last] => (first, last),
            [] => unreachable!("a pack has numbers"),
        };
        let width = numbers.len().next_power_of_two();
        // The lanes of a pack that are unpacked and packed again.
        if let Node::ExtractLane(whole, _) = self.graph.node(first)
            && usize::from(self.graph.width(whole)) == width
            && (0..).zip(numbers).all(|(k, &x)| self.graph.node(x) == Node::ExtractLane(whole, k))
        {
            return whole;
        }
        let mut lanes = numbers.to_vec();
        lanes.resize(width, last);
        self.graph.pack(&lanes)
    }

    /// Returns one lane of a pack.
    pub(super) fn lane(&mut self, pack: Id, lane: usize) -> Id {
        self.graph.make(Node::ExtractLane(pack, u8::try_from(lane).expect("few lanes")))
    }

    /// Returns rows of the product of a matrix, given with its number of rows, and a matrix of `n`
    /// rows.
    pub(super) fn multiply_rows(
        &mut self,
        a: &[Id],
        height: usize,
        b: &[Id],
        n: usize,
        rows: Range<usize>,
    ) -> Vec<Id> {
        let mut dot = |i: usize, j: usize| {
            self.graph.sum_of_products((0..n).map(|k| (a[k * height + i], b[j * n + k])))
        };
        let columns = b.len() / n.max(1);
        let entries = (0..columns).flat_map(|j| rows.clone().map(move |i| (i, j)));
        entries.map(|(i, j)| dot(i, j)).collect()
    }

    /// Returns the scalar product of two vectors.
    pub(super) fn dot(&mut self, a: &[Id], b: &[Id]) -> Id {
        self.graph.sum_of_products(a.iter().copied().zip(b.iter().copied()))
    }

    /// Returns the vector product.
    pub(super) fn cross(&mut self, a: &[Id], b: &[Id]) -> Vec<Id> {
        let mut entry = |i: usize, j: usize| {
            let first = self.product(a[i], b[j]);
            let second = self.product(a[j], b[i]);
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
