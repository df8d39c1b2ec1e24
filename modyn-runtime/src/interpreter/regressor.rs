//! The regressor of the inertial parameters.

use super::Interpreter;
use super::errors::{ShapeError, check};
use crate::Scalar;
use crate::equations::Motion;
use crate::equations::identification::regressor;
use crate::model::PARAMETERS_PER_LINK;

impl<S: Scalar> Interpreter<S> {
    /// Computes the regressor Y into `columns`: nv rows, 10 columns for each moving link, by
    /// columns. tau = Y pi, gravity included; pi is the concatenation of all moving links'
    /// [parameters](crate::model::Model::inertial_parameters).
    ///
    /// Y pi excludes the forces of rotors, damping and friction. The columns do not depend on the
    /// model's inertias. Not all columns are independent: see
    /// [`BaseParameters`](crate::equations::identification::BaseParameters). Source: Atkeson, An
    /// and Hollerbach 1986.
    ///
    /// ```
    /// # let model = include!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/pendulum.in"));
    /// use modyn_runtime::Interpreter;
    ///
    /// // A pendulum: 2 kg, 0.5 m below its joint.
    /// let mut pendulum = Interpreter::<f64>::new(model);
    /// let mut columns = [0.0; 10];
    /// pendulum.regressor(&[1.0], &[0.0], &[0.0], &mut columns)?;
    /// let parameters = pendulum.model().inertial_parameters(0).expect("a link");
    /// let tau: f64 = columns.iter().zip(parameters).map(|(y, pi)| y * pi).sum();
    /// assert!((tau - 2.0 * 9.81 * 0.5 * 1.0_f64.sin()).abs() < 1e-12);
    /// # Ok::<(), modyn_runtime::ShapeError>(())
    /// ```
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
        self.check_motion(Motion { q, qd, qdd })?;
        check("columns", columns, n * PARAMETERS_PER_LINK * self.model.moving_links().len())?;
        let motion = Motion { q, qd, qdd };
        regressor(&self.mechanism, motion, &mut self.workspace, columns);
        Ok(())
    }
}
