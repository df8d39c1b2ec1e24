//! The graphs of the factorization of the mass matrix, and of the functions of its factors.

use modyn_runtime::Scalar;
use modyn_runtime::equations::Workspace;
use modyn_runtime::equations::brge::{self, UduLayout};

use super::Tracer;
use crate::graph::{Expr, Graph};

impl Tracer<'_> {
    /// Returns the graph of the packed factors of U D U^T. Inputs: `q`.
    #[must_use]
    pub fn brge(&self, layout: &UduLayout) -> Graph {
        self.trace(|model, [q]| {
            let mut factors = vec![Expr::zero(); layout.size()];
            let workspace = &mut Workspace::new(model);
            brge::factorize(model, layout, &q, workspace, &mut factors);
            factors
        })
    }

    /// Returns the graph of a full matrix by columns. Inputs: the packed factors.
    fn matrix(&self, layout: &UduLayout, fill: impl FnOnce(&[Expr], &mut [Expr])) -> Graph {
        let n = self.model.nv;
        self.trace_groups([layout.size()], |_, [factors]| {
            let mut columns = vec![Expr::zero(); n * n];
            fill(&factors, &mut columns);
            columns
        })
    }

    /// Returns the graph of U. Inputs: the packed factors.
    #[must_use]
    pub fn u(&self, layout: &UduLayout) -> Graph {
        self.matrix(layout, |factors, columns| brge::upper(layout, &factors[layout.u()], columns))
    }

    /// Returns the graph of D. Inputs: the packed factors.
    #[must_use]
    pub fn d(&self, layout: &UduLayout) -> Graph {
        self.matrix(layout, |factors, columns| brge::diagonal(layout, factors, columns))
    }

    /// Returns the graph of U^-1. Inputs: the packed factors.
    #[must_use]
    pub fn u_inverse(&self, layout: &UduLayout) -> Graph {
        self.matrix(layout, |factors, columns| {
            brge::upper_inverse(layout, &factors[layout.u()], columns);
        })
    }

    /// Returns the graph of D^-1. Inputs: the packed factors.
    #[must_use]
    pub fn d_inverse(&self, layout: &UduLayout) -> Graph {
        self.matrix(layout, |factors, columns| brge::diagonal_inverse(layout, factors, columns))
    }

    /// Returns the graph of the inverse of the mass matrix. Inputs: the packed factors.
    #[must_use]
    pub fn inverse(&self, layout: &UduLayout) -> Graph {
        self.matrix(layout, |factors, columns| brge::inverse(layout, factors, columns))
    }

    /// Returns the graph of the solution. Inputs: the packed factors and `rhs`.
    #[must_use]
    pub fn solve(&self, layout: &UduLayout) -> Graph {
        self.trace_groups([layout.size(), self.model.nv], |_, [factors, mut x]| {
            brge::solve(layout, &factors, &mut x);
            x
        })
    }

    /// Returns the graph of the logarithm of the determinant. Inputs: the packed factors.
    #[must_use]
    pub fn log_determinant(&self, layout: &UduLayout) -> Graph {
        self.trace_groups([layout.size()], |_, [factors]| {
            vec![brge::log_determinant(layout, &factors)]
        })
    }
}
