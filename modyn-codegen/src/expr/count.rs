//! Counting operations.

use std::collections::BTreeSet;
use std::fmt;

use super::{Graph, Node};

/// How many operations a graph takes to evaluate; changes of sign are free.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OperationCount {
    /// Multiplications.
    pub multiplications: usize,
    /// Additions and subtractions.
    pub additions: usize,
    /// Divisions.
    pub divisions: usize,
    /// Angles whose sine, cosine or both are taken.
    pub sin_cos: usize,
    /// Square roots and logarithms, absolute values, maxima and selections.
    pub others: usize,
}

impl OperationCount {
    /// Multiplications, additions and divisions together.
    #[must_use]
    pub fn total(&self) -> usize {
        self.multiplications + self.additions + self.divisions
    }
}

impl fmt::Display for OperationCount {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { multiplications, additions, divisions, sin_cos, .. } = self;
        write!(
            f,
            "{} operations ({multiplications} multiplications, {additions} additions, {divisions} divisions) and {sin_cos} sin/cos",
            self.total()
        )
    }
}

impl Graph {
    /// The operations that the outputs need.
    #[must_use]
    pub fn count(&self) -> OperationCount {
        let mut count = OperationCount::default();
        let mut angles = BTreeSet::new();
        for (node, live) in self.nodes().iter().zip(self.live()) {
            match node {
                _ if !live => {}
                Node::Constant(_) | Node::Input(_) | Node::Neg(_) => {}
                Node::Add(..) | Node::Sub(..) => count.additions += 1,
                Node::Mul(..) => count.multiplications += 1,
                Node::Recip(_) => count.divisions += 1,
                Node::Sin(angle) | Node::Cos(angle) => _ = angles.insert(*angle),
                Node::Sqrt(_) | Node::Ln(_) | Node::Abs(_) | Node::Max(..) | Node::Select(..) => {
                    count.others += 1;
                }
            }
        }
        count.sin_cos = angles.len();
        count
    }
}
