//! The integrator of steps with soft constraints.

/// How the forces of dampers act in a step with soft constraints.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Integrator {
    /// The dampers of joints act with the velocities after the step; the dampers of tendons and the
    /// velocity gains of actuators act with the velocities before it: `MuJoCo`'s default.
    #[default]
    Euler,
    /// All of these act with the velocities after the step, and so does the rotation of free bodies
    /// that carry no other body: `MuJoCo`'s `implicitfast`.
    ImplicitFast,
    /// The dampers of joints and tendons and the velocity gains of actuators act with the velocities
    /// before the step: `MuJoCo`'s `Euler` where the flag `eulerdamp` is disabled.
    ExplicitEuler,
}
