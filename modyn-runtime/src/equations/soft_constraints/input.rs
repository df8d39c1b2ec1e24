//! The input of a step with soft constraints.

/// The state of a robot, its joint forces, and the time of a step.
#[derive(Clone, Copy, Debug)]
pub struct StepInput<'a, S> {
    /// The coordinates.
    pub q: &'a [S],
    /// The velocities.
    pub qd: &'a [S],
    /// The joint forces, N m or N.
    pub tau: &'a [S],
    /// The accelerations from which the solver starts: zeros, or the accelerations of the last step.
    pub warm_start: &'a [S],
    /// The time, s.
    pub dt: S,
}
