//! Expression graphs: the scalars that the compiler runs the equations on.
//!
//! A [`Graph`] is an arena of nodes addressed by index. Each operation is stored once
//! (hash-consing); constants are folded and signs normalised when nodes are created. An [`Expr`] is
//! an index into the graph that the current thread is [tracing](Graph::trace).

mod arena;
pub mod bodies;
mod compose;
mod count;
pub mod dense;
mod evaluate;
pub(crate) mod limit;
mod node;
mod scalar;
pub mod step;
pub(crate) mod table;
mod vectors;

pub use arena::Graph;
pub(crate) use limit::{is_exceeded, within};
pub use node::{Id, Node};
pub use scalar::{Expr, ForeignExpr};
