//! Packing within one state: which limbs or columns are packed into vectors, and when that is
//! profitable.

use modyn_runtime::equations::dynamics::Elimination;
use modyn_runtime::quantities::Function;

use super::context::PlanContext;
use super::functions::{Lowering, Packing};
use super::fused::{FusedFunction, Graphs};
use crate::graph::{Graph, is_exceeded};
use crate::passes::{balance, optimize};
use crate::trace::{LimbPacking, Tracer};

/// The largest number of operations on scalars for which sums are balanced along the critical path.
/// A longer function keeps all units of a processor busy without balancing.
const MAX_BALANCED: usize = 2000;

/// The number of derivative columns that are computed at a time: the lanes of a vector on most
/// processors.
pub const COLUMN_LANES: usize = 4;

/// The largest number of operations on scalars for which derivatives are also compiled with columns
/// in lanes. They add about half of the text, also for a humanoid's Hessians and its derivatives on
/// its soles.
const MAX_COLUMNS: usize = 200_000;

/// The number of operations of functions that are compiled for several instruction sets without
/// packing. Shorter functions take no longer than the dispatch; longer functions cost more compile
/// time than they gain.
const DISPATCHED: std::ops::Range<usize> = 100..5000;

/// A packed function is profitable if it needs fewer than this many fifths of the operations on
/// scalars.
const MAX_FIFTHS: usize = 4;

/// Returns the optimized graph of a function of one state on scalars.
pub(super) fn on_scalars(function: Function, context: &PlanContext<'_>) -> Graph {
    match function {
        // The search for the partition has already optimized this graph.
        Function::ForwardDynamics => context.forward_dynamics.graph.clone(),
        _ => optimize(context.graph(function, &context.tracer)),
    }
}

/// Returns the graph with sums balanced along its critical path, if that is profitable.
pub(super) fn balanced(graph: Graph) -> Graph {
    if graph.count().total() <= MAX_BALANCED { balance(&graph) } else { graph }
}

/// Returns the packed graph of a function; `None` if it is not profitable compared with `scalar`. A
/// hot function that is not packed is compiled for vector instruction sets unchanged: products are
/// fused into sums there, even if the program is compiled for processors without fused
/// multiply-add.
pub(super) fn packed(
    function: Function,
    context: &PlanContext<'_>,
    scalar: &Graph,
) -> Option<Graph> {
    packed_by(function, context, scalar, &|tracer| context.graph(function, tracer))
}

/// Returns the packed graph of a function, as [`packed`] does, for a function that `trace` traces
/// in another way.
pub(super) fn packed_by<'a>(
    function: Function,
    context: &PlanContext<'a>,
    scalar: &Graph,
    trace: &dyn Fn(&Tracer<'_>) -> Graph,
) -> Option<Graph> {
    if is_exceeded() {
        return None;
    }
    let packing = Lowering::of(function).packing;
    let by_limbs = context.limbs.iter().flat_map(|limbs| {
        let tracer = context.tracer.packed(limbs);
        candidates(function, context, limbs, &tracer, trace)
    });
    let has_columns =
        packing.has_columns() && context.has_vectors() && operations(scalar) <= MAX_COLUMNS;
    let columns = has_columns.then(|| trace(&context.tracer.column_lanes(COLUMN_LANES)));
    profitable(by_limbs.chain(columns), function.row().hot, context, scalar)
}

/// Returns the packed graph of a fused function, as [`packed`] does: of each member its packed
/// graph, if it has one, else its graph on scalars.
pub(super) fn packed_fused(
    fused: &FusedFunction,
    graphs: &Graphs<'_>,
    context: &PlanContext<'_>,
    scalar: &Graph,
) -> Option<Graph> {
    if is_exceeded() {
        return None;
    }
    let by_limbs = context.limbs.iter().filter_map(|limbs| {
        let tracer = context.tracer.packed(limbs);
        graphs.packed(|function| {
            let trace = |tracer: &Tracer<'_>| context.graph(function, tracer);
            let all = candidates(function, context, limbs, &tracer, &trace);
            all.into_iter().min_by_key(operations)
        })
    });
    let has_columns = context.has_vectors() && operations(scalar) <= MAX_COLUMNS;
    let traced = || {
        graphs.packed(|function| {
            let columns = Lowering::of(function).packing.has_columns();
            columns.then(|| context.graph(function, &context.tracer.column_lanes(COLUMN_LANES)))
        })
    };
    let columns = has_columns.then(traced).flatten();
    profitable(by_limbs.chain(columns), fused.any(|function| function.row().hot), context, scalar)
}

fn operations(graph: &Graph) -> usize {
    graph.count().total()
}

/// Returns the cheapest of several packed graphs after all passes, if it is profitable compared
/// with `scalar`. The cheapest is found before the passes, which take longer than tracing.
fn profitable(
    graphs: impl Iterator<Item = Graph>,
    hot: bool,
    context: &PlanContext<'_>,
    scalar: &Graph,
) -> Option<Graph> {
    let cheapest = graphs.min_by_key(operations).map(|graph| balance(&optimize(graph)));
    if let Some(graph) = cheapest.filter(|graph| is_profitable(graph, scalar)) {
        return Some(graph);
    }
    let dispatched = context.has_vectors() && hot && DISPATCHED.contains(&operations(scalar));
    dispatched.then(|| scalar.clone())
}

/// Returns whether a packed graph is profitable compared with one on scalars.
pub(super) fn is_profitable(packed: &Graph, scalar: &Graph) -> bool {
    operations(packed) * 5 < operations(scalar) * MAX_FIFTHS
}

/// Returns the graphs with packed limbs that `trace` returns; the cheapest is taken.
fn candidates(
    function: Function,
    context: &PlanContext<'_>,
    limbs: &LimbPacking,
    tracer: &Tracer<'_>,
    trace: &dyn Fn(&Tracer<'_>) -> Graph,
) -> Vec<Graph> {
    match Lowering::of(function).packing {
        Packing::ByModules => {
            let by = |partition| Elimination::Recursive(limbs.partition(partition));
            let partitions = context.partitions.iter();
            return partitions.map(|p| tracer.forward_dynamics(&by(p))).collect();
        }
        Packing::Limbs => {}
        Packing::Contacts if !limbs.merges_contacts(tracer.model()) => return Vec::new(),
        Packing::OnRootPath | Packing::Derivatives | Packing::Columns
            if !limbs.share_root_path(tracer.model()) =>
        {
            return Vec::new();
        }
        Packing::Columns if !context.has_vectors() => return Vec::new(),
        // Where limbs move each other, packed derivatives are profitable on vectors only.
        Packing::Derivatives if !(context.has_vectors() || context.independent) => {
            return Vec::new();
        }
        Packing::OnRootPath | Packing::Derivatives | Packing::Columns | Packing::Contacts => {}
        Packing::Never | Packing::ConstrainedColumns => return Vec::new(),
    }
    vec![trace(tracer)]
}
