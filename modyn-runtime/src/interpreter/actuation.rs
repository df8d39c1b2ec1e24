//! The joint forces of actuators.

use super::Interpreter;
use super::errors::{ShapeError, check};
use crate::Scalar;
pub use crate::equations::actuation::ActuatorOutputs;
use crate::equations::actuation::{ActuationWorkspace, ActuatorInput, actuate};

impl<S: Scalar> Interpreter<S> {
    /// Computes the joint forces of the actuators under the controls `ctrl`, and their activations
    /// after the time `dt`. The first call allocates memory.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn actuate(
        &mut self,
        input: ActuatorInput<'_, S>,
        outputs: ActuatorOutputs<'_, S>,
    ) -> Result<(), ShapeError> {
        self.check_actuators(input)?;
        check("outputs.tau", outputs.tau, input.qd.len())?;
        check("outputs.act", outputs.act, input.act.len())?;
        let Self { model, actuation, .. } = self;
        let workspace = actuation.get_or_insert_with(|| ActuationWorkspace::new(model));
        actuate(model, input, workspace, outputs);
        Ok(())
    }

    /// Checks the lengths of the state and of the controls.
    pub(super) fn check_actuators(&self, input: ActuatorInput<'_, S>) -> Result<(), ShapeError> {
        let model = &self.model;
        check("q", input.q, model.nq())?;
        check("qd", input.qd, model.nv())?;
        check("ctrl", input.ctrl, model.actuation().actuators.len())?;
        check("act", input.act, model.actuation().states())
    }
}
