//! The graph of any function of the table of quantities: its evaluation on expressions.

use modyn_runtime::equations::brge::UduLayout;
use modyn_runtime::equations::dynamics::Elimination;
use modyn_runtime::model::{Model, ModuleTree};
use modyn_runtime::quantities::{Function, Sizes};
use modyn_runtime::{Interpreter, Scalar};

use super::Tracer;
use crate::graph::{Expr, Graph};

/// The solvers of a robot.
#[derive(Clone, Copy)]
pub struct Solvers<'a> {
    /// The solver of forward dynamics.
    pub elimination: &'a Elimination,
    /// The layout of the factorization that users receive.
    pub layout: &'a UduLayout,
    /// The layout of the factorization that derivatives and constrained dynamics use.
    pub for_derivatives: &'a UduLayout,
}

impl Tracer<'_> {
    /// Returns the graph of a function of `model` on scalars, by these solvers or the solvers of
    /// the interpreter. Inputs: its arguments. A function of one link is the function of the
    /// tracer's first link.
    ///
    /// # Panics
    ///
    /// If the tracer has no link, and the function needs one.
    #[must_use]
    pub fn evaluation(
        &self,
        function: Function,
        model: &Model,
        solvers: Option<&Solvers<'_>>,
    ) -> Graph {
        let row = function.row();
        let factors = solvers.map_or_else(
            || UduLayout::new(self.model, &ModuleTree::chains(model)).size(),
            |solvers| solvers.layout.size(),
        );
        let sizes = Sizes::new(model, factors);
        let lengths: Vec<usize> =
            row.arguments.iter().map(|argument| argument.shape(&sizes).len()).collect();
        self.trace_groups([lengths.iter().sum()], |mechanism, [numbers]| {
            let mut rest = &numbers[..];
            let arguments: Vec<&[Expr]> = lengths
                .iter()
                .map(|&length| {
                    let (numbers, others) = rest.split_at(length);
                    rest = others;
                    numbers
                })
                .collect();
            let mut result = vec![Expr::zero(); (row.result)(&sizes).len()];
            let mut robot = Interpreter::with_mechanism(model.clone(), mechanism.clone());
            if let Some(Solvers { elimination, layout, for_derivatives }) = solvers.copied() {
                let elimination = elimination.clone();
                let layout = layout.clone();
                robot = robot.with_solvers(elimination, layout, for_derivatives.clone());
            }
            robot
                .evaluate(function, &arguments, 0, &mut result)
                .expect("the lengths are those of the row");
            result
        })
    }
}
