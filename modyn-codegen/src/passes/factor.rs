//! Factors out: a b + a c becomes a (b + c) if the products have no other use. Where a sum of two
//! products is known already, a (k u) + b (k v) becomes k (a u + b v): a vector that was scaled and
//! is then rotated is the rotated vector, scaled.

use crate::graph::{Graph, Id, Node};

/// The largest number of rounds.
const ROUNDS: usize = 6;

/// Returns the graph with common factors taken out of sums.
pub fn factor(graph: &Graph) -> Graph {
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
    let live = graph.live();
    let uses = graph.uses();
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
            _ => match multiple_of_known(&rewritten, node.map(at)) {
                Some((factor, known)) => {
                    changed = true;
                    rewritten.make(Node::Mul(factor, known))
                }
                None => rewritten.make(node.map(at)),
            },
        };
        ids.push(id);
    }
    rewritten.outputs = graph.outputs.iter().map(|&id| ids[id as usize]).collect();
    rewritten.dense = graph.dense.clone();
    (rewritten, changed)
}

/// Returns a, b and c of a sum or difference of products a b and a c that are not used elsewhere.
fn common_factor(graph: &Graph, uses: &[u32], node: Node) -> Option<(Id, Id, Id)> {
    let (Node::Add(x, y) | Node::Sub(x, y)) = node else { return None };
    let Node::Mul(a, b) = graph.node(x) else { return None };
    let Node::Mul(c, d) = graph.node(y) else { return None };
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

/// Returns k and the node a u + b v, for a sum or difference of the products a (k u) and b (k v),
/// if the graph has that node.
fn multiple_of_known(graph: &Graph, node: Node) -> Option<(Id, Id)> {
    let (x, y, sum): (Id, Id, fn(Id, Id) -> Node) = match node {
        Node::Add(x, y) => (x, y, |x, y| Node::Add(x.min(y), x.max(y))),
        Node::Sub(x, y) => (x, y, Node::Sub),
        _ => return None,
    };
    let quotients = |product| {
        factors(graph, product)
            .flat_map(|(a, inner)| factors(graph, inner).map(move |(k, u)| (k, a, u)))
    };
    quotients(x).find_map(|(k, a, u)| {
        let equal_factors = quotients(y).filter(|(other, ..)| *other == k);
        let of_y = equal_factors.filter_map(|(_, b, v)| graph.find(product(graph, b, v)));
        let au = graph.find(product(graph, a, u))?;
        of_y.filter_map(|bv| graph.find(sum(au, bv))).next().map(|known| (k, known))
    })
}

/// Returns both orders of the factors of a product; none for other nodes.
fn factors(graph: &Graph, id: Id) -> impl Iterator<Item = (Id, Id)> {
    let both = match graph.node(id) {
        Node::Mul(a, b) => Some([(a, b), (b, a)]),
        _ => None,
    };
    both.into_iter().flatten()
}

/// Returns a product as the graph writes it: a constant comes first.
fn product(graph: &Graph, a: Id, b: Id) -> Node {
    match (graph.value(a), graph.value(b)) {
        (Some(_), _) => Node::Mul(a, b),
        (None, Some(_)) => Node::Mul(b, a),
        (None, None) => Node::Mul(a.min(b), a.max(b)),
    }
}
