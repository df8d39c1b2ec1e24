//! The lengths of arguments, checked once for each kind of values.

use super::Interpreter;
use super::errors::{ShapeError, check};
use crate::Scalar;
use crate::equations::{ForwardInput, Motion, State};

/// Slices with their names.
type Named<'a, S> = &'a [(&'static str, &'a [S])];

impl<S: Scalar> Interpreter<S> {
    pub(super) fn check_coordinates(&self, q: &[S]) -> Result<(), ShapeError> {
        check("q", q, self.model.nq())
    }

    pub(super) fn check_state(&self, state: State<'_, S>) -> Result<(), ShapeError> {
        self.check_coordinates(state.q)?;
        self.check_vectors(&[("qd", state.qd)])
    }

    pub(super) fn check_motion(&self, motion: Motion<'_, S>) -> Result<(), ShapeError> {
        self.check_state(motion.state())?;
        self.check_vectors(&[("qdd", motion.qdd)])
    }

    pub(super) fn check_forward_input(&self, input: ForwardInput<'_, S>) -> Result<(), ShapeError> {
        self.check_state(input.state())?;
        self.check_vectors(&[("tau", input.tau)])
    }

    /// Checks vectors with an entry for each degree of freedom.
    pub(super) fn check_vectors(&self, vectors: Named<'_, S>) -> Result<(), ShapeError> {
        vectors.iter().try_for_each(|(name, vector)| check(name, vector, self.model.nv()))
    }

    /// Checks matrices with a row and a column for each degree of freedom.
    pub(super) fn check_matrices(&self, matrices: Named<'_, S>) -> Result<(), ShapeError> {
        let n = self.model.nv();
        matrices.iter().try_for_each(|(name, matrix)| check(name, matrix, n * n))
    }
}
