//! The choice of loops for the dense parts of functions of contacts and closed loops.
//!
//! *Rows.* Nearly all states have independent constraint rows. Their equations are a third of those of rows of any rank, so
//! straight-line code has these alone. The others are solved by loops, which a state without dependent rows does not run.
//!
//! *Columns.* Derivatives are the products of one matrix with many columns. The matrix and the columns have the robot's structure, the
//! products have not.

use modyn_runtime::quantities::Function;

use super::code_form::CodeForm;
use super::context::PlanContext;
use super::functions::Lowering;
use super::packing;
use super::planned::Kernels;
use crate::graph::Graph;
use crate::passes::optimize;
use crate::program::{Execution, Operation, Program, ROW_LANES};
use crate::trace::DenseGraph;

/// The least number of products of a map's entries, in all its columns, for which it is taken unless the user chooses short code. A
/// quadruped on four feet has 32,000: loops have half of the code, and take no longer. An arm with one contact has a thousand.
const MIN_PRODUCTS: usize = 4_000;

/// Returns the programs of a function with dense parts, or of its form for many states. `None` for other functions, and where the user
/// has chosen straight-line code.
pub(super) fn kernels(
    function: Function,
    context: &PlanContext<'_>,
    scalars: usize,
) -> Option<Kernels> {
    if context.code == CodeForm::Fast || context.share {
        return None;
    }
    let Lowering { rows, map, .. } = Lowering::of(function);
    let map = map.filter(|_| function.batched().is_none());
    let by_map = map.map(|trace| (trace(&context.tracer, context, scalars), trace));
    let is_wanted = |(dense, _): &(DenseGraph, _)| {
        dense.map.as_ref().is_some_and(|map| {
            let columns = map.targets.len() * context.sizes.nv;
            let least = if context.code == CodeForm::Small { 0 } else { MIN_PRODUCTS };
            map.rows >= ROW_LANES && map.rows * map.terms * columns > least
        })
    };
    let by_rows = || Some((rows?(&context.tracer, context, scalars), rows?));
    let by_rows = || by_rows().filter(|(dense, _)| dense.rows.is_some());
    let (dense, trace) = by_map.filter(is_wanted).or_else(by_rows)?;
    let graph = packing::balanced(optimize(dense.graph.clone()));
    let program = |graph: Graph, execution| {
        let of = DenseGraph { graph, rows: dense.rows.clone(), map: dense.map.clone() };
        Program::with_dense_parts(&of, scalars, execution).ok()
    };
    if function.batched().is_some() {
        return program(graph, Execution::Batch).map(Kernels::of);
    }
    let packed = packing::packed_by(function, context, &graph, &|tracer| {
        trace(tracer, context, scalars).graph
    });
    // Products are on vectors also where nothing else is.
    let packed =
        packed.or_else(|| (dense.map.is_some() && context.has_vectors()).then(|| graph.clone()));
    let simd = match packed {
        Some(packed) => Some(program(packed, Execution::Simd)?),
        None => None,
    };
    Some(Kernels::Straight { scalar: program(graph, context.without_packs())?, simd })
}

/// Returns the loops of a program with dense parts, and the reason for them.
pub(super) fn loops(program: &Program) -> Option<String> {
    let is_one = |operation: &Operation| matches!(operation, Operation::RowEquations(_));
    let has_rows = program.statements.iter().any(|statement| is_one(&statement.operation));
    let rows = has_rows.then_some("loops for dependent rows of constraints, which few states have");
    let map =
        program.map.is_some().then_some("products of derivatives in loops, since they are dense");
    let both: Vec<&str> = rows.into_iter().chain(map).collect();
    (!both.is_empty()).then(|| both.join("; "))
}
