//! Factors out: a b + a c becomes a (b + c) if the products have no other use.

use crate::graph::{Graph, Id, Node};

/// The largest number of rounds.
const ROUNDS: usize = 6;

pub(super) fn factor(graph: &Graph) -> Graph {
    let mut graph = graph.clone();
    for _ in 0..ROUNDS {
        let (next, changed) = round(&graph);
        graph = next;
        if !changed {
            break;
        }
    }
    graph
}

fn round(graph: &Graph) -> (Graph, bool) {
    let (live, uses) = (graph.live(), graph.uses());
    let mut rewritten = Graph::default();
    let mut changed = false;
    let mut ids: Vec<Id> = Vec::with_capacity(graph.nodes().len());
    for (&node, live) in graph.nodes().iter().zip(live) {
        let at = |id: Id| ids[id as usize];
        let id = match (node, common_factor(graph, &uses, node)) {
            _ if !live => 0,
            (Node::Add(..), Some((factor, b, c))) => {
                changed = true;
                let sum = rewritten.make(Node::Add(at(b), at(c)));
                rewritten.make(Node::Mul(at(factor), sum))
            }
            (Node::Sub(..), Some((factor, b, c))) => {
                changed = true;
                let difference = rewritten.make(Node::Sub(at(b), at(c)));
                rewritten.make(Node::Mul(at(factor), difference))
            }
            _ => rewritten.make(node.map(at)),
        };
        ids.push(id);
    }
    rewritten.outputs = graph.outputs.iter().map(|&id| ids[id as usize]).collect();
    (rewritten, changed)
}

/// Returns a, b and c of a sum or difference of products a b and a c that are not used elsewhere.
fn common_factor(graph: &Graph, uses: &[u32], node: Node) -> Option<(Id, Id, Id)> {
    let (Node::Add(x, y) | Node::Sub(x, y)) = node else { return None };
    let (Node::Mul(a, b), Node::Mul(c, d)) = (graph.node(x), graph.node(y)) else { return None };
    if uses[x as usize] != 1 || uses[y as usize] != 1 {
        return None;
    }
    match () {
        () if a == c => Some((a, b, d)),
        () if a == d => Some((a, b, c)),
        () if b == c => Some((b, a, d)),
        () if b == d => Some((b, a, c)),
        () => None,
    }
}
