//! Functions on vectors within one state: which limbs or columns are packed, and when that is profitable.

use modyn_runtime::equations::dynamics::Elimination;

use super::Tracing;
use super::functions::{Function, Trace};
use crate::graph::Graph;
use crate::passes::{balance, optimize};
use crate::trace::{LimbPacking, Tracer};

/// How a function can be packed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Packing {
    /// Not at all.
    Never,
    /// Equal limbs.
    Limbs,
    /// Equal limbs, eliminated by each of several partitions into modules.
    ByModules,
    /// Equal limbs whose parents are on one path to the root: their composites are carried on together.
    OnRootPath,
    /// Derivatives: such limbs, or several columns.
    Derivatives,
}

/// Most operations of a function on scalars for which sums are balanced along its critical path. A longer function
/// keeps all units of a processor busy anyhow.
const MAX_BALANCED: usize = 2000;

/// Most operations of derivatives on scalars that are compiled with several columns in lanes, too.
const MAX_COLUMNS: usize = 20_000;

/// Operations of functions that are compiled for several instruction sets even if nothing is packed: fewer take no
/// longer than the dispatch, more cost the compiler more than they gain.
const DISPATCHED: std::ops::Range<usize> = 100..5000;

/// A packed function is profitable if it takes fewer than so many fifths of the operations on scalars.
const MAX_FIFTHS: usize = 4;

/// The graph with sums balanced along its critical path, where that is profitable.
pub(super) fn balanced(graph: Graph) -> Graph {
    if graph.count().total() <= MAX_BALANCED { balance(&graph) } else { graph }
}

/// The packed graph of a function, if it is profitable compared with `scalar`. A hot function that is not packed is
/// compiled for vectors as it is: products are fused with sums there where the processor can and the program does not
/// count on it.
pub(super) fn packed(function: Function, tracing: &Tracing<'_>, scalar: &Graph) -> Option<Graph> {
    let row = function.row();
    let Trace::One(trace) = row.trace else { return None };
    let operations = |graph: &Graph| graph.count().total();
    let by_limbs = tracing.limbs.iter().flat_map(|limbs| {
        let tracer = tracing.tracer.packed(limbs);
        candidates(row.packing, trace, tracing, (limbs, &tracer))
    });
    let has_columns =
        row.packing == Packing::Derivatives && tracing.vectors && operations(scalar) <= MAX_COLUMNS;
    let columns = has_columns.then(|| trace(&tracing.tracer.column_lanes(), tracing));
    let graphs = by_limbs.chain(columns);
    let cheapest = graphs.map(|graph| balance(&optimize(graph))).min_by_key(operations);
    let is_profitable = |graph: &Graph| operations(graph) * 5 < operations(scalar) * MAX_FIFTHS;
    if let Some(graph) = cheapest.filter(is_profitable) {
        return Some(graph);
    }
    let dispatched = tracing.vectors && row.hot && DISPATCHED.contains(&operations(scalar));
    dispatched.then(|| scalar.clone())
}

/// The graphs with these limbs packed; the cheapest is taken.
fn candidates(
    packing: Packing,
    trace: fn(&Tracer<'_>, &Tracing<'_>) -> Graph,
    tracing: &Tracing<'_>,
    (limbs, tracer): (&LimbPacking, &Tracer<'_>),
) -> Vec<Graph> {
    match packing {
        Packing::ByModules => {
            let by = |partition| Elimination::Recursive(limbs.partition(partition));
            let partitions = tracing.partitions.iter();
            return partitions.map(|p| tracer.forward_dynamics(&by(p))).collect();
        }
        Packing::Limbs => {}
        Packing::OnRootPath | Packing::Derivatives if !limbs.share_root_path(tracer.model()) => {
            return Vec::new();
        }
        // Where limbs move each other, derivatives are written on vectors alone.
        Packing::Derivatives if !(tracing.vectors || tracing.independent) => return Vec::new(),
        Packing::OnRootPath | Packing::Derivatives => {}
        Packing::Never => return Vec::new(),
    }
    vec![trace(tracer, tracing)]
}
