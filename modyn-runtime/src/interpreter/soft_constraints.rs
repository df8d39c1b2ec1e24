//! Steps with soft constraints.

use super::Interpreter;
use super::errors::{ShapeError, check};
use crate::equations::dynamics::Elimination;
use crate::equations::soft_constraints::{
    SoftParameters, SoftStep, StepInput, StepProblem, soft_step,
};
use crate::solve::Decide;

impl<S: Decide> Interpreter<S> {
    /// Returns the state after a step of the time `input.dt` (s) with contacts, joint limits and dry joint friction by MuJoCo's law, and
    /// the forces of the contacts. Each call allocates memory. `None` for robots with mimic joints.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn soft_step(
        &mut self,
        input: StepInput<'_, S>,
        parameters: &SoftParameters<S>,
    ) -> Result<Option<SoftStep<S>>, ShapeError> {
        let Self { mechanism, elimination, workspace, .. } = self;
        check("q", input.q, mechanism.nq)?;
        check("qd", input.qd, mechanism.nv)?;
        check("tau", input.tau, mechanism.nv)?;
        check("warm", input.warm, mechanism.nv)?;
        check("contacts", &parameters.contacts, mechanism.contacts())?;
        check("joints", &parameters.joints, mechanism.nv)?;
        let Elimination::Recursive(partition) = elimination else { return Ok(None) };
        let problem = StepProblem::new(mechanism, partition, input, parameters, workspace);
        Ok(Some(soft_step(problem, parameters.tolerance)))
    }
}
