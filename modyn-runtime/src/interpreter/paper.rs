//! The dense matrices of the method's paper.

use super::Interpreter;
use super::errors::{DecompositionError, ShapeError, check};
use crate::Scalar;
use crate::equations::paper::{DeNoc, Decomposition, denoc};

impl<S: Scalar> Interpreter<S> {
    /// The dense DeNOC matrices at `q`, (1)-(5), with the links' inertias as the model has them.
    ///
    /// # Errors
    ///
    /// If `q` does not have the model's length.
    pub fn denoc(&mut self, q: &[S]) -> Result<DeNoc<S>, ShapeError> {
        check("q", q, self.model.nq())?;
        Ok(denoc(&self.mechanism, q, &mut self.workspace))
    }

    /// The paper's dense matrices of the block decomposition at `q`, (1)-(57), by the modules of
    /// [`brge`](Self::brge), with the links' inertias as the model has them.
    ///
    /// # Errors
    ///
    /// If `q` does not have the model's length, or if joints mimic others.
    pub fn decomposition(&mut self, q: &[S]) -> Result<Decomposition<S>, DecompositionError> {
        check("q", q, self.model.nq()).map_err(DecompositionError::Shape)?;
        let Self { mechanism, modules, workspace, .. } = self;
        Decomposition::new(mechanism, modules, q, workspace).ok_or(DecompositionError::Mimics)
    }
}
