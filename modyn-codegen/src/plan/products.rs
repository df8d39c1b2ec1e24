//! The choice between products of matrices in straight-line code and in loops.

use modyn_runtime::quantities::Function;

use super::code_form::CodeForm;
use super::context::PlanContext;
use super::dense::MIN_PRODUCTS;
use super::functions::Lowering;
use super::packing;
use super::planned::Kernels;
use crate::graph::Graph;
use crate::passes::optimize;
use crate::program::{Execution, Program, ROW_LANES};
use crate::trace::{DenseGraph, Tracer};

/// Returns the programs of a function whose products of matrices are loops: without packs, and on vectors where that is
/// profitable, or with a state in each lane. `None` for functions without products, and where straight-line code is taken. `straight` are
/// the graphs of straight-line code: on scalars, and packed.
pub(super) fn kernels(
    function: Function,
    context: &PlanContext<'_>,
    straight: (&Graph, Option<&Graph>),
    scalars: usize,
) -> Option<Kernels> {
    // Functions of constraints are those of `dense`.
    let Lowering { products: Some(trace), rows: None, .. } = Lowering::of(function) else {
        return None;
    };
    let is_batch = function.batched().is_some();
    // Many states gain nothing from rows in lanes, and loops take more operations.
    let is_wanted = match context.code {
        CodeForm::Fast => false,
        CodeForm::Auto => !is_batch && !context.has_threads(),
        CodeForm::Small => true,
    };
    if !is_wanted || context.share || context.sizes.nv < ROW_LANES {
        return None;
    }
    let mut dense = trace(&context.tracer, context, scalars);
    dense.graph = optimize(dense.graph);
    let program = |graph: Graph, execution| {
        let of = DenseGraph { graph, ..dense.clone() };
        Program::with_dense_parts(&of, scalars, execution).ok()
    };
    let execution = if is_batch { Execution::Batch } else { context.without_packs() };
    let scalar = program(dense.graph.clone(), execution)?;
    let count = scalar.products.as_ref()?.multiplications(execution);
    if context.code == CodeForm::Auto && count < MIN_PRODUCTS {
        return None;
    }
    let trace = |tracer: &Tracer<'_>| {
        let packed = trace(tracer, context, scalars);
        packed.with_zeros_of(&dense).graph
    };
    let packed = packing::packed_by(function, context, &dense.graph, &trace);
    let simd = match packed.filter(|_| !is_batch) {
        Some(packed) => Some(program(packed, Execution::Simd)?),
        None => None,
    };
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
    is_taken.then(|| match is_batch {
        true => Kernels::of(scalar),
        false => Kernels::Straight { scalar, simd },
    })
}
