//! The passes: rewrites of whole graphs, one file for each, in the order of this list.
//! `differentiate` makes graphs of products with derivatives, `directions` those along several
//! directions in lanes, `jacobian` graphs of whole matrices. `balance` is for functions that are
//! not long, which the plan decides.

pub(crate) mod balance;
mod differentiate;
mod directions;
pub(crate) mod factor;
mod jacobian;

use crate::graph::Graph;
pub use balance::balance;
pub use differentiate::{jvp, vjp};
pub use directions::{Directional, Displacement, along_directions};
pub use jacobian::{hessian, jacobian, matrix, symmetric_matrix};

/// A rewrite that keeps the outputs.
type Pass = fn(&Graph) -> Graph;

/// All passes, in the order in which they run.
pub const PASSES: &[(&str, Pass)] = &[("factor", factor::factor)];

/// Returns the graph after all passes.
#[must_use]
pub fn optimize(graph: Graph) -> Graph {
    PASSES.iter().fold(graph, |graph, (_, pass)| pass(&graph))
}
