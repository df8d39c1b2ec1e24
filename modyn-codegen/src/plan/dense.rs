//! The choice of loops for the dense parts of functions.
//!
//! *Rows.* Nearly all states have independent constraint rows. Their equations are a third of those
//! of rows of any rank, so straight-line code has these alone. The others are solved by loops,
//! which a state without dependent rows does not run. Machine code has straight-line code for them,
//! too.
//!
//! *Products.* Derivatives, and a part of Hessians, are the products of one matrix with many
//! columns. The matrix and the columns have the robot's structure, the products have not.

use modyn_runtime::quantities::Function;

use super::code_form::CodeForm;
use super::context::PlanContext;
use super::functions::Lowering;
use super::packing;
use super::planned::Kernels;
use crate::graph::dense::{DenseParts, RowForm};
use crate::graph::{Graph, is_exceeded};
use crate::passes::optimize;
use crate::program::{Execution, Program, ROW_LANES};
use crate::trace::{DenseLoops, Tracer};

/// The least number of multiplications of products for which they are loops unless the user chooses
/// short code. A quadruped on four feet has 32,000: loops have half of the code, and take no
/// longer. The derivatives of a quadruped on a floating base have 6,000: with loops they take nine
/// tenths of the time in a tight loop, seven tenths where code is not in the cache, and half of the
/// text (`lab/benches/chains`). An arm with one contact has a thousand, the derivatives of an arm
/// 700: straight-line code is as quick when called cold.
const MIN_PRODUCTS: usize = 2_500;

/// The most operations, by their order, that machine code has for rows of any rank beside the
/// operations for independent rows: they are not counted among the operations of a robot. It is
/// reached by 48 rows.
const MAX_ANY_RANK: usize = 125_000;

/// Returns the programs of a function of constraints, or of its form for many states. `None` for
/// other functions, and where the user has chosen straight-line code.
pub(super) fn of_constraints(
    function: Function,
    context: &PlanContext<'_>,
    scalars: usize,
) -> Option<Kernels> {
    let Lowering { has_rows: true, has_products, .. } = Lowering::of(function) else {
        return None;
    };
    let with_products = has_products && may_have_products(function, context);
    let choices: &[bool] = if with_products { &[true, false] } else { &[false] };
    choices.iter().find_map(|&products| {
        kernels(function, context, scalars, DenseLoops { rows: Some(scalars), products })
    })
}

/// Returns the programs of another function with products, or of its form for many states, if loops
/// take more operations out of the text than they add to a call: for short code, if the text is
/// shorter. `straight` are the graphs of straight-line code: on scalars, and packed.
pub(super) fn by_products(
    function: Function,
    context: &PlanContext<'_>,
    straight: (&Graph, Option<&Graph>),
    scalars: usize,
) -> Option<Kernels> {
    let Lowering { has_rows: false, has_products: true, .. } = Lowering::of(function) else {
        return None;
    };
    if !may_have_products(function, context) {
        return None;
    }
    let loops = DenseLoops { rows: None, products: true };
    let kernels = kernels(function, context, scalars, loops)?;
    let Kernels::Straight { scalar, simd } = &kernels else { return None };
    let is_taken = if context.code == CodeForm::Looped {
        let looped = [Some(scalar), simd.as_ref()].into_iter().flatten();
        let length: usize = looped.map(|program| program.static_operations().total()).sum();
        let graphs = [Some(straight.0), straight.1].into_iter().flatten();
        length < graphs.map(|graph| graph.count().total()).sum()
    } else {
        let (graph, program) = straight.1.zip(simd.as_ref()).unwrap_or((straight.0, scalar));
        let text = program.static_operations();
        let call = program.operations_per_call();
        text.total() + call.total() < 2 * graph.count().total()
    };
    is_taken.then_some(kernels)
}

/// Returns whether products may be loops: for many states in short code alone. A vector of states
/// gains nothing from rows in lanes, and loops take more operations.
fn may_have_products(function: Function, context: &PlanContext<'_>) -> bool {
    match context.code {
        CodeForm::Unrolled => false,
        CodeForm::Auto => function.batched().is_none(),
        CodeForm::Looped => true,
    }
}

/// Returns the programs of a function that leaves these parts to loops. `None` if it has none of
/// them, and where straight-line code is taken.
fn kernels(
    function: Function,
    context: &PlanContext<'_>,
    scalars: usize,
    loops: DenseLoops,
) -> Option<Kernels> {
    let is_straight =
        context.share_limbs || context.code == CodeForm::Unrolled && !context.machine_code;
    if is_straight || is_exceeded() {
        return None;
    }
    let trace = |tracer: &Tracer<'_>| context.graph(function, &tracer.with_loops(loops));
    let graph = trace(&context.tracer);
    let DenseParts { rows, products } = &graph.dense;
    let has_products = match products {
        Some(products) if products.rows < ROW_LANES => return None,
        None if rows.is_none() => return None,
        products => products.is_some(),
    };
    let is_long = |form: &RowForm| {
        let rows: usize = form.blocks.iter().sum();
        rows * rows * (rows + 4 * form.sides) > MAX_ANY_RANK
    };
    if context.machine_code && rows.as_ref().is_some_and(is_long) {
        return None;
    }
    let graph = packing::balanced(optimize(graph));
    let program = |graph: &Graph, execution| Program::try_new(graph, scalars, execution).ok();
    if function.batched().is_some() {
        return program(&graph, Execution::Batch).map(Kernels::of);
    }
    let scalar = program(&graph, context.without_packs())?;
    let is_short = scalar
        .products
        .as_ref()
        .is_some_and(|products| products.multiplications(Execution::Scalar) < MIN_PRODUCTS);
    if is_short && context.code != CodeForm::Looped {
        return None;
    }
    let packed = packing::packed_by(function, context, &graph, &|tracer| {
        trace(tracer).with_zeros_of(&graph)
    });
    // Products are on vectors also where nothing else is.
    let is_simd = has_products && context.has_vectors();
    let packed = packed.or_else(|| is_simd.then(|| graph.clone()));
    let simd = match packed {
        Some(packed) => Some(program(&packed, Execution::Simd)?),
        None => None,
    };
    Some(Kernels::Straight { scalar, simd })
}

/// Returns the loops of a program with dense parts, and the reason for them.
pub(super) fn loops(program: &Program) -> Option<String> {
    let rows = "loops for dependent rows of constraints, which few states have";
    let products = program.products.as_ref().map(|products| {
        let count = products.multiplications(Execution::Scalar);
        format!("products of matrices in loops, since they have {count} multiplications")
    });
    let both: Vec<String> =
        program.has_row_equations().then(|| rows.into()).into_iter().chain(products).collect();
    (!both.is_empty()).then(|| both.join("; "))
}
