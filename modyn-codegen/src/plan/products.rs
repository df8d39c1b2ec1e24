//! The choice between products of matrices in straight-line code and in loops.

use modyn_runtime::quantities::Function;

use super::code_form::CodeForm;
use super::context::PlanContext;
use super::functions::Lowering;
use super::packing;
use super::planned::Kernels;
use crate::graph::Graph;
use crate::passes::optimize;
use crate::program::{Execution, Program, ROW_LANES, product_blocks};
use crate::trace::ProductGraph;

/// The largest number of operations of straight-line code on vectors for which products in loops are not taken unless the user chooses
/// them. The derivatives of a quadruped on a floating base have 4,800: with loops they take nine tenths of the time in a tight
/// loop, seven tenths where code is not in the cache, and half of the text (`lab/benches/chains`). Those of arms of up to
/// seven joints are as quick when called cold.
const MAX_IN_LANES: usize = 4_000;

/// The same limit on scalars. The derivatives of a humanoid with a fixed base have 29,000, and take as long in loops in a tight loop.
const MAX_ON_SCALARS: usize = 20_000;

/// Returns the largest number of operations of straight-line code for which it is taken, on vectors or on scalars.
pub(super) fn limit(in_lanes: bool) -> usize {
    if in_lanes { MAX_IN_LANES } else { MAX_ON_SCALARS }
}

/// Returns the programs of a function whose products of matrices are loops: without packs, and on vectors where that is
/// profitable. `None` for functions without products, and where straight-line code is taken. `straight` are the graphs of
/// straight-line code: on scalars, and packed.
pub(super) fn kernels(
    function: Function,
    context: &PlanContext<'_>,
    straight: (&Graph, Option<&Graph>),
    scalars: usize,
) -> Option<Kernels> {
    let trace = Lowering::of(function).products?;
    let is_wanted = match context.code {
        CodeForm::Fast => false,
        CodeForm::Small => true,
        CodeForm::Auto => {
            let shortest = straight.1.unwrap_or(straight.0);
            shortest.takes_more_than(limit(straight.1.is_some()))
        }
    };
    if !is_wanted || context.share || context.sizes.nv < ROW_LANES {
        return None;
    }
    let traced = trace(&context.tracer, context);
    let graph = optimize(traced.graph.clone());
    let packed =
        packing::packed_by(function, context, &graph, &|tracer| trace(tracer, context).graph);
    let of = |graph| ProductGraph { graph, products: traced.products.clone(), ..traced };
    let graph = of(graph);
    let blocks = product_blocks(&graph);
    let program = |graph: &ProductGraph, execution| {
        Program::with_products(graph, &blocks, scalars, execution)
    };
    let scalar = program(&graph, context.without_packs()).ok()?;
    let simd = packed.map(|packed| program(&of(packed), Execution::Simd)).transpose().ok()?;
    let is_taken = if context.code == CodeForm::Small {
        let looped = [Some(&scalar), simd.as_ref()].into_iter().flatten();
        let length: usize = looped.map(|program| program.static_operations().total()).sum();
        let graphs = [Some(straight.0), straight.1].into_iter().flatten();
        length < graphs.map(|graph| graph.count().total()).sum()
    } else {
        // Loops take more operations out of the text than they add to a call.
        let (graph, program) = straight.1.zip(simd.as_ref()).unwrap_or((straight.0, &scalar));
        let (text, call) = (program.static_operations(), program.operations_per_call());
        text.total() + call.total() < 2 * graph.count().total()
    };
    is_taken.then_some(Kernels::Straight { scalar, simd })
}
