//! Rewrites of whole graphs, one file each. Their order is this list.

mod balance;
mod factor;

use crate::graph::Graph;
pub use balance::balance;

/// A rewrite: the same outputs by other operations.
type Pass = fn(&Graph) -> Graph;

/// All passes, in the order in which they run.
pub const PASSES: &[(&str, Pass)] = &[("factor", factor::factor)];

/// The graph after all passes.
#[must_use]
pub fn optimize(graph: Graph) -> Graph {
    PASSES.iter().fold(graph, |graph, (_, pass)| pass(&graph))
}
