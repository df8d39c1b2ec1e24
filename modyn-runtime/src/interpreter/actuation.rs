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
        let Self { model, actuation, .. } = self;
        let actuators = &model.actuation().actuators;
        let activations = model.actuation().activated().count();
        check("q", input.q, model.nq())?;
        check("qd", input.qd, model.nv())?;
        check("ctrl", input.ctrl, actuators.len())?;
        check("act", input.act, activations)?;
        check("outputs.tau", outputs.tau, model.nv())?;
        check("outputs.act", outputs.act, activations)?;
        let workspace = actuation.get_or_insert_with(|| ActuationWorkspace::new(model));
        actuate(model, input, workspace, outputs);
        Ok(())
    }
}
