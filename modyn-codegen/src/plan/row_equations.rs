//! The choice between constraint rows of any rank in straight-line code, and independent rows alone.
//!
//! Nearly all states have independent rows. Their equations are a third of those of any rank, so straight-line code has these
//! alone. The others are solved by loops of the runtime, which a state without dependent rows does not run.

use modyn_runtime::quantities::Function;

use super::code_form::CodeForm;
use super::context::PlanContext;
use super::functions::Lowering;
use super::packing;
use super::planned::Kernels;
use crate::graph::Graph;
use crate::passes::optimize;
use crate::program::{Execution, Operation, Program};
use crate::trace::RowEquationsGraph;

/// Returns the programs of a function with equations of constraint rows, or of its form for many states. `None` for other functions,
/// where the user has chosen straight-line code or columns by one routine, and if some rows are dependent in all states.
pub(super) fn kernels(
    function: Function,
    context: &PlanContext<'_>,
    scalars: usize,
) -> Option<Kernels> {
    let Lowering { row_equations, columns, .. } = Lowering::of(function);
    let trace = row_equations?;
    let by_columns = context.code == CodeForm::Small && columns.is_some();
    if context.code == CodeForm::Fast || context.share || by_columns {
        return None;
    }
    let RowEquationsGraph { graph, blocks, sides } = trace(&context.tracer, context, scalars)?;
    let graph = packing::balanced(optimize(graph));
    let program = |graph: Graph, execution| {
        let graph = RowEquationsGraph { graph, blocks: blocks.clone(), sides };
        Program::with_row_equations(&graph, scalars, execution).ok()
    };
    if function.batched().is_some() {
        return program(graph, Execution::Batch).map(Kernels::of);
    }
    let packed = packing::packed_by(function, context, &graph, &|tracer| {
        trace(tracer, context, scalars).map_or_else(|| graph.clone(), |of| of.graph)
    });
    let simd = match packed {
        Some(packed) => Some(program(packed, Execution::Simd)?),
        None => None,
    };
    Some(Kernels::Straight { scalar: program(graph, context.without_packs())?, simd })
}

/// Returns whether a program has equations of constraint rows.
pub(super) fn has_equations(program: &Program) -> bool {
    let is_one = |operation: &Operation| matches!(operation, Operation::RowEquations(_));
    program.statements.iter().any(|statement| is_one(&statement.operation))
}
