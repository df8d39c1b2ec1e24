//! The dense matrices of the method's paper.

use super::Interpreter;
use super::errors::{DecompositionError, ShapeError, check};
use crate::Scalar;
use crate::equations::paper::{DeNoc, Decomposition, denoc};

impl<S: Scalar> Interpreter<S> {
    /// Returns the dense DeNOC matrices at `q`, (1)-(5) of the paper, with the inertias of the
    /// model.
    ///
    /// # Errors
    ///
    /// If `q` does not have the model's length.
    pub fn denoc(&mut self, q: &[S]) -> Result<DeNoc<S>, ShapeError> {
        self.check_coordinates(q)?;
        Ok(denoc(&self.mechanism, q, &mut self.workspace))
    }

    /// Returns the paper's dense matrices of the block decomposition at `q`, (1)-(57), by the
    /// modules of [`brge`](Self::brge), with the inertias of the model.
    ///
    /// # Errors
    ///
    /// If `q` does not have the model's length, or if the robot has mimic joints.
    pub fn decomposition(&mut self, q: &[S]) -> Result<Decomposition<S>, DecompositionError> {
        check("q", q, self.model.nq()).map_err(DecompositionError::Shape)?;
        let Self { mechanism, modules, workspace, .. } = self;
        Decomposition::new(mechanism, modules, q, workspace).ok_or(DecompositionError::Mimics)
    }
}
