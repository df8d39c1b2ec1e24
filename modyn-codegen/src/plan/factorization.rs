//! The functions of the mass matrix's factors.

use modyn_runtime::equations::brge::UduLayout;

use super::functions::{FACTORS, RHS};
use super::programs::shapes_of;
use super::{Argument, Shape, Sizes};
use crate::graph::Graph;
use crate::passes::optimize;
use crate::program::{Execution, Program};
use crate::trace::Tracer;

/// A function of the factors.
pub struct FactorFunction {
    /// The name.
    pub name: &'static str,
    /// The documentation.
    pub docs: &'static str,
    /// The arguments: the factors, and the right-hand side of `solve`.
    pub arguments: Vec<(Argument, Shape)>,
    /// The layout of the result.
    pub result: Shape,
    /// The program.
    pub program: Program,
}

/// Returns all functions of the factors.
pub(super) fn plan(tracer: &Tracer<'_>, layout: &UduLayout, sizes: &Sizes) -> Vec<FactorFunction> {
    let square = || Shape::matrix(sizes.nv, sizes.nv);
    let function = |name, docs, arguments: &[Argument], result, graph: Graph| {
        let arguments = shapes_of(arguments, sizes);
        let scalars = arguments.iter().map(|(_, shape)| shape.len()).sum();
        let program = Program::new(&optimize(graph), scalars, Execution::Scalar);
        FactorFunction { name, docs, arguments, result, program }
    };
    let of_factors = |name, docs, result, graph| function(name, docs, &[FACTORS], result, graph);
    vec![
        of_factors(
            "u",
            "Returns the block upper triangular U (equation 43 of the paper), an array of columns.",
            square(),
            tracer.u(layout),
        ),
        of_factors(
            "d",
            "Returns the block diagonal D (equation 45 of the paper), an array of columns.",
            square(),
            tracer.d(layout),
        ),
        of_factors(
            "u_inverse",
            "Returns U^-1 (equation 54 of the paper), an array of columns.",
            square(),
            tracer.u_inverse(layout),
        ),
        of_factors(
            "d_inverse",
            "Returns D^-1 (equation 54 of the paper), an array of columns.",
            square(),
            tracer.d_inverse(layout),
        ),
        of_factors(
            "inverse",
            "Returns the inverse of the mass matrix (equation 50 of the paper), an array of columns.",
            square(),
            tracer.inverse(layout),
        ),
        of_factors(
            "log_determinant",
            "Returns the natural logarithm of the mass matrix's determinant.",
            Shape::Scalar,
            tracer.log_determinant(layout),
        ),
        function(
            "solve",
            "Returns the solution x of M x = `rhs`, with the mass matrix M, by the three steps of \
             equation 60 of the paper.",
            &[FACTORS, RHS],
            Shape::vector(sizes.nv),
            tracer.solve(layout),
        ),
    ]
}
