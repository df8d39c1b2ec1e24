//! The values that travel together through the equations.

/// The state of a robot.
#[derive(Clone, Copy, Debug)]
pub struct State<'a, S> {
    /// The coordinates.
    pub q: &'a [S],
    /// The velocities.
    pub qd: &'a [S],
}

/// The motion of a robot.
#[derive(Clone, Copy, Debug)]
pub struct Motion<'a, S> {
    /// The coordinates.
    pub q: &'a [S],
    /// The velocities.
    pub qd: &'a [S],
    /// The accelerations.
    pub qdd: &'a [S],
}

/// The input of forward dynamics: the state of a robot, and its joint forces.
#[derive(Clone, Copy, Debug)]
pub struct ForwardInput<'a, S> {
    /// The coordinates.
    pub q: &'a [S],
    /// The velocities.
    pub qd: &'a [S],
    /// The joint forces, N m or N.
    pub tau: &'a [S],
}

/// The input of a time step: the state of a robot, its joint forces, and the time of the step.
#[derive(Clone, Copy, Debug)]
pub struct TimeStepInput<'a, S> {
    /// The coordinates.
    pub q: &'a [S],
    /// The velocities.
    pub qd: &'a [S],
    /// The joint forces, N m or N.
    pub tau: &'a [S],
    /// The time, s.
    pub dt: S,
}

/// The results of a time step: the state after it.
#[derive(Debug)]
pub struct NextState<'a, S> {
    /// The coordinates.
    pub q: &'a mut [S],
    /// The velocities.
    pub qd: &'a mut [S],
}

impl<'a, S> State<'a, S> {
    /// Returns the state with these accelerations.
    #[must_use]
    pub fn with_accelerations(self, qdd: &'a [S]) -> Motion<'a, S> {
        let Self { q, qd } = self;
        Motion { q, qd, qdd }
    }
}

impl<'a, S> Motion<'a, S> {
    /// Returns the coordinates and velocities.
    #[must_use]
    pub fn state(self) -> State<'a, S> {
        let Self { q, qd, .. } = self;
        State { q, qd }
    }
}

impl<'a, S> ForwardInput<'a, S> {
    /// Returns the coordinates and velocities.
    #[must_use]
    pub fn state(self) -> State<'a, S> {
        let Self { q, qd, .. } = self;
        State { q, qd }
    }
}

impl<'a, S> TimeStepInput<'a, S> {
    /// Returns the input of forward dynamics.
    #[must_use]
    pub fn forward_input(self) -> ForwardInput<'a, S> {
        let Self { q, qd, tau, .. } = self;
        ForwardInput { q, qd, tau }
    }
}
