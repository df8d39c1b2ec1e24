//! Balances sums of several terms: terms are added in the order in which they are ready, and in
//! pairs where the result is on the critical path.
//!
//! The run time of straight-line code of a few hundred operations is its critical path. A sum of n
//! terms needs n - 1 additions in any order. Products are fused into additions, except one in each
//! partial sum. Partial sums are therefore made only on critical paths.
//!
//! The critical path of forward dynamics becomes 8 % (`arm6`) to 15 % (`arm7`) shorter, in the
//! cycles of the pass, with no more operations (`cargo test -p modyn-codegen balance::`). Long
//! functions are not balanced, since they keep all units of a processor busy.

use crate::graph::{Graph, Id, Node};

/// Cycles until a result can be used, on current processors. A difference of a cycle does not
/// matter here.
mod latency {
    pub const FUSED: u32 = 4;
    pub const SUM: u32 = 3;
    pub const PRODUCT: u32 = 3;
    pub const QUOTIENT: u32 = 13;
    pub const SINE: u32 = 40;
    pub const LANES: u32 = 2;
    pub const OTHER: u32 = 20;
}

/// A sum is critical if the path through it is shorter than the critical path by at most this
/// fraction (1/6).
const CRITICAL_FRACTION: u32 = 6;

/// Returns the graph with balanced sums.
#[must_use]
pub fn balance(graph: &Graph) -> Graph {
    let live = graph.live();
    let uses = graph.uses();
    let ready_at = ready_times(graph, &uses);
    let tail_latency = tail_latency(graph, &live, &ready_at);
    let critical_path = ready_at.iter().zip(&tail_latency).map(|(a, b)| a + b).max().unwrap_or(0);
    let is_part = nested_sums(graph, &live, &uses);
    let mut rewritten = Rewritten { graph: Graph::default(), ready_at: Vec::new() };
    let mut ids: Vec<Id> = Vec::with_capacity(graph.nodes().len());
    for (i, &node) in graph.nodes().iter().enumerate() {
        let at = |id: Id| ids[id as usize];
        let id = match node {
            _ if !live[i] || is_part[i] => 0,
            Node::Add(..) | Node::Sub(..) => {
                let mut terms = Vec::new();
                collect(graph, &is_part, i as Id, false, &mut terms);
                let near = ready_at[i] + tail_latency[i] + critical_path / CRITICAL_FRACTION
                    >= critical_path;
                let term = |(negative, id): (bool, Id)| {
                    let product = uses[id as usize] == 1 && is_product(graph, id);
                    rewritten.term(negative, at(id), product)
                };
                let terms: Vec<Term> = terms.into_iter().map(term).collect();
                if terms.len() == 2 {
                    rewritten.make(node.map(at))
                } else {
                    rewritten.sum(terms, near)
                }
            }
            _ => rewritten.make(node.map(at)),
        };
        ids.push(id);
    }
    rewritten.graph.outputs = graph.outputs.iter().map(|&id| ids[id as usize]).collect();
    rewritten.graph.dense = graph.dense.clone();
    rewritten.graph
}

/// Returns, for each node, whether it is a sum that is only used as a term of another sum.
fn nested_sums(graph: &Graph, live: &[bool], uses: &[u32]) -> Vec<bool> {
    let mut is_part = vec![false; graph.nodes().len()];
    for (i, node) in graph.nodes().iter().enumerate() {
        if !live[i] || !matches!(node, Node::Add(..) | Node::Sub(..)) {
            continue;
        }
        for operand in node.operands() {
            let sum = matches!(graph.node(operand), Node::Add(..) | Node::Sub(..));
            let same = graph.width(operand) == graph.width(i as Id);
            is_part[operand as usize] |= sum && same && uses[operand as usize] == 1;
        }
    }
    is_part
}

/// Collects the terms of a sum.
fn collect(graph: &Graph, is_part: &[bool], id: Id, negative: bool, terms: &mut Vec<(bool, Id)>) {
    let (a, b, minus) = match graph.node(id) {
        Node::Add(a, b) => (a, b, false),
        Node::Sub(a, b) => (a, b, true),
        _ => return terms.push((negative, id)),
    };
    for (operand, negative) in [(a, negative), (b, negative != minus)] {
        if is_part[operand as usize] {
            collect(graph, is_part, operand, negative, terms);
        } else {
            terms.push((negative, operand));
        }
    }
}

fn is_product(graph: &Graph, id: Id) -> bool {
    matches!(graph.node(id), Node::Mul(..))
}

/// Returns the time at which each node is ready.
pub fn ready_times(graph: &Graph, uses: &[u32]) -> Vec<u32> {
    let mut ready_at: Vec<u32> = Vec::with_capacity(graph.nodes().len());
    for &node in graph.nodes() {
        ready_at.push(ready_time(graph, node, &ready_at, |id| uses[id as usize] == 1));
    }
    ready_at
}

/// Returns the time at which `node` is ready, given its operands. A product that is used `once` is
/// fused.
fn ready_time(graph: &Graph, node: Node, ready_at: &[u32], once: impl Fn(Id) -> bool) -> u32 {
    let at = |id: Id| ready_at[id as usize];
    let last = node.operands().map(at).max().unwrap_or(0);
    match node {
        Node::Constant(_) | Node::Input(_) => 0,
        Node::Neg(_) => last,
        Node::Add(a, b) | Node::Sub(a, b) => {
            // The later of two products is fused.
            let factors = |id: Id| graph.node(id).operands().map(at).max().unwrap_or(0);
            let fused = |product: Id, other: Id| {
                (is_product(graph, product) && once(product))
                    .then(|| factors(product).max(at(other)) + latency::FUSED)
            };
            let all = [fused(a, b), fused(b, a), Some(last + latency::SUM)];
            all.into_iter().flatten().min().expect("one at least")
        }
        Node::Mul(..) => last + latency::PRODUCT,
        Node::Recip(_) => last + latency::QUOTIENT,
        Node::Sin(_) | Node::Cos(_) => last + latency::SINE,
        Node::Pack(..) | Node::ExtractLane(..) => last + latency::LANES,
        _ => last + latency::OTHER,
    }
}

/// Returns the time from each node to the last output.
fn tail_latency(graph: &Graph, live: &[bool], ready_at: &[u32]) -> Vec<u32> {
    let mut tail_latency = vec![0; graph.nodes().len()];
    for (i, node) in graph.nodes().iter().enumerate().rev() {
        if !live[i] {
            continue;
        }
        for operand in node.operands() {
            let wait = ready_at[i].saturating_sub(ready_at[operand as usize]);
            let step = match node {
                Node::Add(..) | Node::Sub(..) => wait.min(latency::FUSED),
                _ => wait.min(latency::SINE),
            };
            let operand = operand as usize;
            tail_latency[operand] = tail_latency[operand].max(tail_latency[i] + step);
        }
    }
    tail_latency
}

/// A term of a sum.
#[derive(Clone, Copy)]
struct Term {
    negative: bool,
    id: Id,
    /// The time at which the term can be added; for a fused product, the time at which its factors
    /// are ready.
    ready: u32,
}

struct Rewritten {
    graph: Graph,
    ready_at: Vec<u32>,
}

impl Rewritten {
    fn make(&mut self, node: Node) -> Id {
        let id = self.graph.make(node);
        for i in self.ready_at.len()..self.graph.nodes().len() {
            let ready_at = ready_time(&self.graph, self.graph.nodes()[i], &self.ready_at, |_| true);
            self.ready_at.push(ready_at);
        }
        id
    }

    /// Returns a term. A `product` that is used only here is fused.
    fn term(&self, negative: bool, id: Id, product: bool) -> Term {
        let ready_at = |id: Id| self.ready_at[id as usize];
        let factors = self.graph.node(id).operands().map(ready_at).max();
        let fused = factors.filter(|_| product && is_product(&self.graph, id));
        Term { negative, id, ready: fused.unwrap_or(ready_at(id)) }
    }

    /// Returns the sum of terms, the earliest first: one after the other, or in pairs.
    fn sum(&mut self, mut terms: Vec<Term>, in_pairs: bool) -> Id {
        let latest_first = |terms: &mut Vec<Term>| {
            terms.sort_by_key(|term| std::cmp::Reverse((term.ready, term.negative)));
        };
        latest_first(&mut terms);
        while let (Some(a), Some(b)) = (terms.pop(), terms.pop()) {
            let sum = self.pair(a, b);
            if terms.is_empty() {
                return if sum.negative { self.make(Node::Neg(sum.id)) } else { sum.id };
            }
            terms.push(sum);
            if in_pairs {
                latest_first(&mut terms);
            }
        }
        unreachable!("a sum has several terms")
    }

    fn pair(&mut self, a: Term, b: Term) -> Term {
        let (negative, node) = match (a.negative, b.negative) {
            (true, false) => (false, Node::Sub(b.id, a.id)),
            (false, true) => (false, Node::Sub(a.id, b.id)),
            (negative, _) => (negative, Node::Add(a.id, b.id)),
        };
        let id = self.make(node);
        self.term(negative, id, false)
    }
}
