//! The choice of loops for the dense parts of functions of contacts and closed loops.
//!
//! *Rows.* Nearly all states have independent constraint rows. Their equations are a third of those of rows of any rank, so
//! straight-line code has these alone. The others are solved by loops, which a state without dependent rows does not run.
//!
//! *Products.* Derivatives under constraints are the products of one matrix with many columns. The matrix and the columns have the
//! robot's structure, the products have not.

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

/// The least number of multiplications of products for which they are loops unless the user chooses short code. A quadruped on four feet has
/// 32,000: loops have half of the code, and take no longer. The derivatives of a quadruped on a floating base have 6,000: with loops they
/// take nine tenths of the time in a tight loop, seven tenths where code is not in the cache, and half of the text (`lab/benches/chains`).
/// An arm with one contact has a thousand, the derivatives of an arm 700: straight-line code is as quick when called cold.
pub(super) const MIN_PRODUCTS: usize = 2_500;

/// Returns the programs of a function with dense parts, or of its form for many states. `None` for other functions, and where the user
/// has chosen straight-line code.
pub(super) fn kernels(
    function: Function,
    context: &PlanContext<'_>,
    scalars: usize,
) -> Option<Kernels> {
    if context.code == CodeForm::Fast || context.share || context.has_threads() {
        return None;
    }
    let Lowering { rows: Some(rows), products, .. } = Lowering::of(function) else { return None };
    let products =
        products.filter(|_| function.batched().is_none() || context.code == CodeForm::Small);
    let by_products = products.map(|trace| (trace(&context.tracer, context, scalars), trace));
    let is_wanted = |(dense, _): &(DenseGraph, _)| {
        dense.products.as_ref().is_some_and(|products| {
            let columns = products.targets.len() * context.sizes.nv;
            let least = if context.code == CodeForm::Small { 0 } else { MIN_PRODUCTS };
            products.rows >= ROW_LANES && products.rows * products.terms * columns > least
        })
    };
    let by_rows = || Some((rows(&context.tracer, context, scalars), rows));
    let by_rows = || by_rows().filter(|(dense, _)| dense.rows.is_some());
    let (mut dense, trace) = by_products.filter(is_wanted).or_else(by_rows)?;
    dense.graph = packing::balanced(optimize(dense.graph));
    let graph = dense.graph.clone();
    let program = |graph: Graph, execution| {
        let of = DenseGraph { graph, ..dense.clone() };
        Program::with_dense_parts(&of, scalars, execution).ok()
    };
    if function.batched().is_some() {
        return program(graph, Execution::Batch).map(Kernels::of);
    }
    let packed = packing::packed_by(function, context, &graph, &|tracer| {
        trace(tracer, context, scalars).with_zeros_of(&dense).graph
    });
    // Products are on vectors also where nothing else is.
    let is_simd = dense.products.is_some() && context.has_vectors();
    let packed = packed.or_else(|| is_simd.then(|| graph.clone()));
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
    let rows = "loops for dependent rows of constraints, which few states have";
    let products = program.products.as_ref().map(|products| {
        let count = products.multiplications(Execution::Scalar);
        format!("products of matrices in loops, since they have {count} multiplications")
    });
    let both: Vec<String> = has_rows.then(|| rows.into()).into_iter().chain(products).collect();
    (!both.is_empty()).then(|| both.join("; "))
}
