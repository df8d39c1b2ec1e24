//! Graphs in graphs: functions of functions.

use super::{Graph, Id, Node};

impl Graph {
    /// Adds the outputs of `other`, with the nodes `inputs` as its inputs, and returns their nodes.
    /// Nodes that this graph has already are shared. The outputs of this graph do not change.
    ///
    /// # Panics
    ///
    /// If an input that the outputs of `other` need is missing.
    pub fn compose(&mut self, other: &Self, inputs: &[Id]) -> Vec<Id> {
        let mut ids: Vec<Id> = Vec::with_capacity(other.nodes().len());
        for (&node, live) in other.nodes().iter().zip(other.live()) {
            let id = match node {
                _ if !live => 0,
                Node::Input(number) => inputs[number as usize],
                node => self.make(node.map(|operand| ids[operand as usize])),
            };
            ids.push(id);
        }
        other.outputs.iter().map(|&id| ids[id as usize]).collect()
    }
}
