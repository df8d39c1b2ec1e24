//! The input of a step with soft constraints.

use crate::equations::TimeStepInput;

/// The input of a time step, and the start of the solver.
#[derive(Clone, Copy, Debug)]
pub struct StepInput<'a, S> {
    /// The state of the robot, its joint forces, and the time of the step.
    pub step: TimeStepInput<'a, S>,
    /// The accelerations from which the solver starts: zeros, or the accelerations of the last step.
    pub warm_start: &'a [S],
}
