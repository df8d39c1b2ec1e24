//! Evaluating a graph on numbers.

use modyn_runtime::Scalar;

use super::{Graph, Id, Node};

impl Graph {
    /// The outputs for these inputs.
    ///
    /// # Panics
    ///
    /// If an input that the outputs need is not there.
    #[must_use]
    pub fn evaluate<S: Scalar>(&self, inputs: &[S]) -> Vec<S> {
        let live = self.live();
        let mut values: Vec<S> = Vec::with_capacity(self.nodes().len());
        for (node, live) in self.nodes().iter().zip(live) {
            let at = |id: Id| values[id as usize];
            let value = match *node {
                _ if !live => S::zero(),
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
            };
            values.push(value);
        }
        self.outputs.iter().map(|&id| values[id as usize]).collect()
    }
}
