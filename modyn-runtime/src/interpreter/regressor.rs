//! The regressor of the inertial parameters.

use super::Interpreter;
use super::errors::{ShapeError, check};
use crate::Scalar;
use crate::equations::identification::regressor;
use crate::model::PARAMETERS_PER_LINK;

impl<S: Scalar> Interpreter<S> {
    /// The regressor Y of the motion by columns into `columns` (nv times 10 a moving link): tau =
    /// Y pi, gravity included, with the [parameters](crate::model::Model::inertial_parameters) of
    /// all moving links one after the other as pi.
    ///
    /// The torques that rotors, damping and friction take are not part of Y pi. The columns do not
    /// depend on the model's inertias, and not all of them are independent: see
    /// [`BaseParameters`](crate::equations::identification::BaseParameters).
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn regressor(
        &mut self,
        q: &[S],
        qd: &[S],
        qdd: &[S],
        columns: &mut [S],
    ) -> Result<(), ShapeError> {
        let n = self.model.nv();
        check("q", q, self.model.nq())?;
        check("qd", qd, n)?;
        check("qdd", qdd, n)?;
        check("columns", columns, n * PARAMETERS_PER_LINK * self.model.links().len())?;
        let motion = (q, qd, qdd);
        regressor(&self.mechanism, motion, &mut self.workspace, columns);
        Ok(())
    }
}
