//! The input of a step with soft constraints.

use super::rows::SoftModel;
use crate::StepSettings;
use crate::equations::TimeStepInput;

/// The input of a time step, and the start of the solver.
#[derive(Clone, Copy, Debug)]
pub struct StepInput<'a, S> {
    /// The state of the robot, its joint forces, and the time of the step.
    pub step: TimeStepInput<'a, S>,
    /// The accelerations from which the solver starts: zeros, or the accelerations of the last step.
    pub warm_start: &'a [S],
}

/// The soft constraints of a step.
#[derive(Debug)]
pub struct StepConstraints<'a, S, C> {
    /// The parameters that the robot determines.
    pub soft: &'a SoftModel<S>,
    /// The settings, with a surface for each shape that touches the ground.
    pub settings: &'a StepSettings<S, C>,
}

impl<S, C> Clone for StepConstraints<'_, S, C> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<S, C> Copy for StepConstraints<'_, S, C> {}
