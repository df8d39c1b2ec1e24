//! The evaluation of a graph on numbers.

use modyn_runtime::Scalar;

use super::{Graph, Id, Node};

impl Graph {
    /// Returns the outputs for these inputs.
    ///
    /// # Panics
    ///
    /// If an input that the outputs need is missing.
    #[must_use]
    pub fn evaluate<S: Scalar>(&self, inputs: &[S]) -> Vec<S> {
        let live = self.live();
        // For each node, its lanes.
        let mut values: Vec<Vec<S>> = Vec::with_capacity(self.nodes().len());
        for (i, node) in self.nodes().iter().enumerate() {
            let lanes = if live[i] { usize::from(self.width(i as Id)) } else { 0 };
            let lane = |lane: usize| self.lane_of(*node, lane, &values, inputs);
            let value = (0..lanes).map(lane).collect();
            values.push(value);
        }
        self.outputs.iter().map(|&id| values[id as usize][0]).collect()
    }

    /// Returns one lane of a node.
    fn lane_of<S: Scalar>(&self, node: Node, lane: usize, values: &[Vec<S>], inputs: &[S]) -> S {
        // A scalar has the same value in all lanes.
        let lane_of = |id: Id, lane: usize| match &*values[id as usize] {
            [number] => *number,
            lanes => lanes[lane],
        };
        let at = |id: Id| lane_of(id, lane);
        match node {
            Node::Constant(bits) => S::from_f64(f64::from_bits(bits)),
            Node::Input(number) => inputs[number as usize],
            Node::Neg(a) => -at(a),
            Node::Add(a, b) => at(a) + at(b),
            Node::Sub(a, b) => at(a) - at(b),
            Node::Mul(a, b) => at(a) * at(b),
            Node::Recip(a) => at(a).recip(),
            Node::Sin(a) => at(a).sin_cos().0,
            Node::Cos(a) => at(a).sin_cos().1,
            Node::Atan2(a, b) => at(a).atan2(at(b)),
            Node::Sqrt(a) => at(a).sqrt(),
            Node::Ln(a) => at(a).ln(),
            Node::Abs(a) => at(a).abs(),
            Node::Max(a, b) => at(a).max(at(b)),
            Node::Select(a, b, c) => at(a).select_nonnegative(at(b), at(c)),
            Node::Pack(a, b, width) => {
                let half = usize::from(width / 2);
                if lane < half { lane_of(a, lane) } else { lane_of(b, lane - half) }
            }
            Node::ExtractLane(a, lane) => lane_of(a, usize::from(lane)),
        }
    }
}
