//! The number of operations of a graph.

use std::collections::BTreeSet;

use modyn_runtime::OperationCount;

use super::{Graph, Node};

impl Graph {
    /// Returns whether the outputs need more than this many operations.
    #[must_use]
    pub fn takes_more_than(&self, operations: usize) -> bool {
        // Every operation is a node, and nodes need no counting.
        self.nodes().len() > operations && self.count().total() > operations
    }

    /// Returns the operations that the outputs need. An operation on lanes counts once; packing and
    /// extracting lanes do not count.
    #[must_use]
    pub fn count(&self) -> OperationCount {
        let mut count = OperationCount::default();
        let mut angles = BTreeSet::new();
        for (node, live) in self.nodes().iter().zip(self.live()) {
            match node {
                _ if !live => {}
                Node::Constant(_)
                | Node::Input(_)
                | Node::Neg(_)
                | Node::Pack(..)
                | Node::ExtractLane(..) => {}
                Node::Add(..) | Node::Sub(..) => count.additions += 1,
                Node::Mul(..) => count.multiplications += 1,
                Node::Recip(_) => count.divisions += 1,
                Node::Sin(angle) | Node::Cos(angle) => _ = angles.insert(*angle),
                Node::Atan2(..)
                | Node::Sqrt(_)
                | Node::Ln(_)
                | Node::Abs(_)
                | Node::Max(..)
                | Node::Select(..) => count.others += 1,
            }
        }
        count.sin_cos = angles.len();
        count
    }
}
