//! The choice between columns in straight-line code and by calls of one routine.

use modyn_runtime::quantities::Function;

use super::code_form::CodeForm;
use super::context::PlanContext;
use super::functions::Lowering;
use super::packing::COLUMN_LANES;
use super::planned::Kernels;
use crate::graph::Graph;
use crate::program::{Execution, Program};

/// The largest number of operations of straight-line code for which a routine is not taken unless the user chooses it: it is never
/// taken. For a quadruped on four feet the routine has half of the code, but takes 11.0 us where straight-line code takes 9.3 us
/// (x86-64 with AVX2): it does not know the zeros of a column.
pub(super) const MAX_STRAIGHT: usize = usize::MAX;

/// Returns the programs of a function whose columns are results of one routine: without packs, and on vectors. `None` for other
/// functions, and where straight-line code is taken. `straight` is the graph of straight-line code on scalars.
pub(super) fn kernels(
    function: Function,
    context: &PlanContext<'_>,
    straight: &Graph,
    scalars: usize,
) -> Option<Kernels> {
    let trace = Lowering::of(function).columns?;
    let is_wanted = match context.code {
        CodeForm::Fast => false,
        CodeForm::Small => true,
        CodeForm::Auto => straight.takes_more_than(MAX_STRAIGHT),
    };
    if !is_wanted || context.share {
        return None;
    }
    let program = |columns, execution| {
        let tracer = context.tracer.column_lanes(columns);
        Program::with_columns(&trace(&tracer, context), scalars, execution).ok()
    };
    let scalar = program(1, context.without_packs())?;
    let is_shorter = scalar.static_operations().total() < straight.count().total();
    if !is_shorter {
        return None;
    }
    let simd = match context.has_vectors() {
        true => Some(program(COLUMN_LANES, Execution::Simd)?),
        false => None,
    };
    Some(Kernels::Straight { scalar, simd })
}
