//! The functions of the mass matrix's factors.

use modyn_runtime::equations::brge::UduLayout;

use super::shape::{Shape, Sizes};
use crate::graph::Graph;
use crate::passes::optimize;
use crate::program::{Program, Target};
use crate::trace::Tracer;

/// A function of the factors.
pub struct FactorFunction {
    /// Its name.
    pub name: &'static str,
    /// Its documentation.
    pub docs: &'static str,
    /// Its arguments: the factors, and a right-hand side if it solves for one.
    pub arguments: Vec<(&'static str, Shape)>,
    /// Its result.
    pub result: Shape,
    /// Its program.
    pub program: Program,
}

/// All of them.
pub(super) fn plan(tracer: &Tracer<'_>, layout: &UduLayout, sizes: &Sizes) -> Vec<FactorFunction> {
    let square = || Shape::matrix(sizes.nv, sizes.nv);
    let factors = || ("factors", Shape::vector(layout.size()));
    let rhs = ("rhs", Shape::vector(sizes.nv));
    let function = |name, docs, arguments: Vec<(&'static str, Shape)>, result, graph: Graph| {
        let scalars = arguments.iter().map(|(_, shape)| shape.len()).sum();
        let program = Program::new(&optimize(graph), scalars, Target::Scalar);
        FactorFunction { name, docs, arguments, result, program }
    };
    let of_factors =
        |name, docs, result, graph| function(name, docs, vec![factors()], result, graph);
    vec![
        of_factors(
            "u",
            "The block upper triangular U, (43), an array of columns.",
            square(),
            tracer.u(layout),
        ),
        of_factors(
            "d",
            "The block diagonal D, (45), an array of columns.",
            square(),
            tracer.d(layout),
        ),
        of_factors(
            "u_inverse",
            "U^-1, (54), an array of columns.",
            square(),
            tracer.u_inverse(layout),
        ),
        of_factors(
            "d_inverse",
            "D^-1, (54), an array of columns.",
            square(),
            tracer.d_inverse(layout),
        ),
        of_factors(
            "inverse",
            "The inverse, (50), an array of columns.",
            square(),
            tracer.inverse(layout),
        ),
        of_factors(
            "log_determinant",
            "The natural logarithm of the determinant.",
            Shape::Scalar,
            tracer.log_determinant(layout),
        ),
        function(
            "solve",
            "The x with I x = `rhs`, by the three steps of (60).",
            vec![factors(), rhs],
            Shape::vector(sizes.nv),
            tracer.solve(layout),
        ),
    ]
}
