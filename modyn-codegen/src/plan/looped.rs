//! The choice between straight-line code and loops over the bodies.

use super::Function;
use super::code_form::CodeForm;
use super::context::PlanContext;
use super::functions::Lowering;
use crate::graph::Graph;
use crate::passes::{balance, optimize};
use crate::program::{Program, RecursionSizes};

/// The largest number of operations of straight-line code for which loops are not taken unless the
/// user chooses them. An operation takes about 7 bytes. From this length on, some 45 joints, loops
/// take at most a sixth more time than straight-line code on processors that fetch instructions
/// quickly (`docs/data/chains.tsv`), and less on others; in the first call they take a fifth
/// everywhere.
pub(super) const MAX_STRAIGHT: usize = 16_000;

/// The smallest mean number of bodies in a loop for which loops are taken unless the user chooses
/// them: in a branched tree of few bodies in each limb, loops are short, and straight-line code is
/// quicker at any length.
const MIN_BODIES_IN_LOOP: usize = 8;

/// Returns the program in loops of a function, if the user has chosen loops or straight-line code
/// would be too long; `None` for functions that are no recursions over bodies, and robots that
/// loops do not suit. `straight` are the graphs of straight-line code: on scalars, and packed.
pub(super) fn recursion(
    function: Function,
    context: &PlanContext<'_>,
    straight: &Graph,
    packed: Option<&Graph>,
) -> Option<Program> {
    let recursion = Lowering::of(function).recursion?();
    let is_wanted = match context.code {
        CodeForm::Unrolled => false,
        CodeForm::Looped => true,
        CodeForm::Auto => packed.is_none() && straight.takes_more_than(MAX_STRAIGHT),
    };
    if !is_wanted {
        return None;
    }
    let mut graphs = context.tracer.body_graphs(&recursion)?;
    for kind in &mut graphs.kinds {
        kind.graph = optimize(std::mem::take(&mut kind.graph));
    }
    // The bodies of a chain wait for each other: a sweep takes as long as its critical path.
    let sizes = RecursionSizes {
        nq: context.sizes.nq,
        nv: context.sizes.nv,
        parameters: graphs.parameters,
    };
    let program = Program::over_bodies(&graphs, sizes, balance);
    let has_long_loops = graphs.bodies.len() >= MIN_BODIES_IN_LOOP * program.tables.len();
    (context.code == CodeForm::Looped || has_long_loops).then_some(program)
}
