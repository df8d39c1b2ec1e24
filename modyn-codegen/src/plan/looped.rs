//! The choice between straight-line code and loops over the bodies.

use super::functions::Function;
use super::strategy::CodeForm;
use super::tracing::Tracing;
use crate::graph::Graph;
use crate::passes::{balance, optimize};
use crate::program::Recursion;

/// The largest number of operations of straight-line code that stays in the instruction cache of a processor between two
/// calls. An operation takes about 7 bytes, an instruction cache has 32 KiB.
const MAX_CACHED: usize = 5000;

/// Returns the loops of a function, if the user has chosen loops or straight-line code would be too long; `None` for
/// functions that are no recursions over bodies, and robots that loops do not suit. `straight` are the graphs of straight-line
/// code: on scalars, and packed.
pub(super) fn recursion(
    function: Function,
    tracing: &Tracing<'_>,
    (straight, packed): (&Graph, Option<&Graph>),
) -> Option<Recursion> {
    let recursion = function.row().recursion?();
    let is_wanted = match tracing.code {
        CodeForm::Fast => false,
        CodeForm::Small => true,
        CodeForm::Auto => packed.is_none() && straight.takes_more_than(MAX_CACHED),
    };
    if !is_wanted {
        return None;
    }
    let mut graphs = tracing.tracer.body_graphs(&recursion)?;
    for kind in &mut graphs.kinds {
        kind.graph = optimize(std::mem::take(&mut kind.graph));
    }
    // The bodies of a chain wait for each other: a sweep takes as long as its critical path.
    Recursion::new(&graphs, [tracing.sizes.nq, tracing.sizes.nv], balance)
}
