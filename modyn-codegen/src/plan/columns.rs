//! The choice between columns in straight-line code and by calls of one routine.

use modyn_runtime::quantities::Function;

use super::code_form::CodeForm;
use super::context::PlanContext;
use super::functions::Lowering;
use super::packing::COLUMN_LANES;
use super::planned::Kernels;
use crate::graph::Graph;
use crate::program::{Execution, Program};

/// Returns the programs of a function whose columns are results of one routine, without packs and on vectors, if the user has chosen
/// short code. `None` for other functions, and where straight-line code is shorter. `straight` is its graph on scalars.
///
/// `auto` does not take the routine: it does not know the zeros of a column, so it computes more than straight-line code does
/// (docs/contacts.md).
pub(super) fn kernels(
    function: Function,
    context: &PlanContext<'_>,
    straight: &Graph,
    scalars: usize,
) -> Option<Kernels> {
    let trace = Lowering::of(function).columns?;
    if context.code != CodeForm::Small || context.share {
        return None;
    }
    let program = |lanes, execution| {
        let tracer = context.tracer.column_lanes(lanes);
        Program::with_columns(&trace(&tracer, context), scalars, execution).ok()
    };
    let scalar = program(1, context.without_packs())?;
    if scalar.static_operations().total() >= straight.count().total() {
        return None;
    }
    let simd = match context.has_vectors() {
        true => Some(program(COLUMN_LANES, Execution::Simd)?),
        false => None,
    };
    Some(Kernels::Straight { scalar, simd })
}
