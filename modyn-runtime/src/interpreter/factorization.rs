//! The factorization of the mass matrix by modules.

use alloc::{vec, vec::Vec};

use super::Interpreter;
use super::errors::{ModuleMismatch, ShapeError, UpdateError, check};
use crate::Scalar;
use crate::equations::Workspace;
use crate::equations::brge::{self, UduLayout};
use crate::mechanism::BodyStructure;
use crate::model::ModuleTree;

impl<S: Scalar> Interpreter<S> {
    /// Returns the factorization M = U D U^T of the mass matrix by modules at `q`, (35)-(49) of the
    /// paper. Allocates the result; [`UduFactorization::update`] uses the memory of an earlier one.
    ///
    /// ```
    /// # let model = include!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/pendulum.in"));
    /// use modyn_runtime::Interpreter;
    ///
    /// // A pendulum: 2 kg, 0.5 m below its joint.
    /// let pendulum = Interpreter::<f64>::new(model);
    /// let factors = pendulum.brge(&[1.0])?;
    /// // A force of 1 N m accelerates an inertia of 0.5 kg m^2 by 2 rad/s^2.
    /// assert!((factors.solve(&[1.0])?[0] - 2.0).abs() < 1e-12);
    /// # Ok::<(), modyn_runtime::ShapeError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If `q` does not have the model's length.
    pub fn brge(&self, q: &[S]) -> Result<UduFactorization<S>, ShapeError> {
        self.check_coordinates(q)?;
        let layout = self.layout.clone();
        let factors = vec![S::zero(); layout.size()];
        let workspace = Workspace::new(&self.mechanism);
        let modules = self.modules.clone();
        let structure = self.mechanism.structure().collect();
        let nq = self.model.nq();
        let n = self.model.nv();
        let mut brge = UduFactorization { modules, layout, factors, workspace, structure, nq, n };
        brge.factorize(self, q);
        Ok(brge)
    }

    /// Computes the packed factors of the mass matrix.
    pub(crate) fn factorize(&mut self, q: &[S], factors: &mut [S]) {
        let Self { mechanism, layout, workspace, .. } = self;
        brge::factorize(mechanism, layout, q, workspace, factors);
    }
}

/// The factorization M = U D U^T of the mass matrix by modules. Matrices are returned by columns.
///
/// [`update`](Self::update) and [`solve_in_place`](Self::solve_in_place) do not allocate. Methods
/// that return a vector or matrix allocate it; [`condition_number`](Self::condition_number)
/// allocates a copy of its block.
#[derive(Clone, Debug)]
pub struct UduFactorization<S = f64> {
    modules: ModuleTree,
    layout: UduLayout,
    factors: Vec<S>,
    workspace: Workspace<S>,
    /// For each body, the properties that layout and memory depend on, besides the modules.
    structure: Vec<BodyStructure>,
    nq: usize,
    n: usize,
}

impl<S: Scalar> UduFactorization<S> {
    /// Recomputes the factorization at another `q` without allocation.
    ///
    /// # Errors
    ///
    /// If the factorization belongs to a model with other joints or to other modules, or if `q`
    /// does not have the model's length. (Models that differ in their numbers only may share a
    /// factorization.)
    pub fn update(&mut self, interpreter: &Interpreter<S>, q: &[S]) -> Result<(), UpdateError> {
        let structure = interpreter.mechanism.structure();
        if self.modules != interpreter.modules || !structure.eq(self.structure.iter().copied()) {
            return Err(UpdateError::Modules(ModuleMismatch {}));
        }
        check("q", q, self.nq).map_err(UpdateError::Shape)?;
        self.factorize(interpreter, q);
        Ok(())
    }

    fn factorize(&mut self, interpreter: &Interpreter<S>, q: &[S]) {
        let Self { layout, factors, workspace, .. } = self;
        brge::factorize(&interpreter.mechanism, layout, q, workspace, factors);
    }

    fn matrix(&self, fill: impl FnOnce(&mut [S])) -> Vec<S> {
        let mut columns = vec![S::zero(); self.n * self.n];
        fill(&mut columns);
        columns
    }

    /// Returns the block upper triangular U, (43), nv x nv by columns.
    #[must_use]
    pub fn u(&self) -> Vec<S> {
        self.matrix(|columns| brge::upper(&self.layout, &self.factors[self.layout.u()], columns))
    }

    /// Returns the block diagonal D, (45), nv x nv by columns.
    #[must_use]
    pub fn d(&self) -> Vec<S> {
        self.matrix(|columns| brge::diagonal(&self.layout, &self.factors, columns))
    }

    /// Returns U^-1, (54), nv x nv by columns.
    #[must_use]
    pub fn u_inverse(&self) -> Vec<S> {
        let u = &self.factors[self.layout.u()];
        self.matrix(|columns| brge::upper_inverse(&self.layout, u, columns))
    }

    /// Returns D^-1, (54), nv x nv by columns.
    #[must_use]
    pub fn d_inverse(&self) -> Vec<S> {
        self.matrix(|columns| brge::diagonal_inverse(&self.layout, &self.factors, columns))
    }

    /// Returns the inverse of the mass matrix, (50), nv x nv by columns.
    #[must_use]
    pub fn inverse(&self) -> Vec<S> {
        self.matrix(|columns| brge::inverse(&self.layout, &self.factors, columns))
    }

    /// Returns the solution x of M x = `rhs`, with the mass matrix M, by the three steps of
    /// equation 60 of the paper.
    ///
    /// # Errors
    ///
    /// If `rhs` does not have the model's length.
    pub fn solve(&self, rhs: &[S]) -> Result<Vec<S>, ShapeError> {
        check("rhs", rhs, self.n)?;
        let mut x = rhs.to_vec();
        brge::solve(&self.layout, &self.factors, &mut x);
        Ok(x)
    }

    /// Replaces the right-hand side `x` by the solution of M x = rhs, with the mass matrix M.
    ///
    /// # Errors
    ///
    /// If `x` does not have the model's length.
    pub fn solve_in_place(&self, x: &mut [S]) -> Result<(), ShapeError> {
        check("x", x, self.n)?;
        brge::solve(&self.layout, &self.factors, x);
        Ok(())
    }

    /// Returns the natural logarithm of the mass matrix's determinant.
    #[must_use]
    pub fn log_determinant(&self) -> S {
        brge::log_determinant(&self.layout, &self.factors)
    }

    /// Returns module `module`'s pivot block I_hat, (46), by columns; `None` if there is no such
    /// module.
    #[must_use]
    pub fn pivot_block(&self, module: usize) -> Option<Vec<S>> {
        let exists = module < self.layout.blocks().len();
        exists.then(|| self.factors[self.layout.d(module)].to_vec())
    }

    /// Returns the condition number (2-norm) of module `module`'s pivot block, by a fixed number of
    /// Jacobi sweeps; `None` if there is no such module.
    #[must_use]
    pub fn condition_number(&self, module: usize) -> Option<S> {
        let exists = module < self.layout.blocks().len();
        exists.then(|| brge::condition_number(&self.layout, &self.factors, module))
    }
}
