//! Steps with contacts, joint limits and dry joint friction.

use super::State;
use crate::robot::SurfaceSettings;
use crate::spatial::Vector3;
use crate::{Array, Robot, Scalar, StepSolution, functions};

/// The state after a step with contacts, the forces in it, and how its solver ended.
pub struct SolvedStep<R: Robot, T: Scalar = f64> {
    /// The state.
    pub state: State<R, T>,
    /// The accelerations in the step, from which the solver of the next step starts, rad/s^2 or
    /// m/s^2.
    pub qdd: R::V<T>,
    /// The force of the ground on each point that can touch it, along the x and y axes of its plane,
    /// then along the normal, N.
    pub forces: R::PerTouchingPoint<Vector3<T>>,
    /// The largest mismatch between the forces and their laws, divided by the sum of the robot's
    /// weight and the largest force.
    pub residual: T,
    /// The number of iterations of Newton's method.
    pub iterations: T,
}

impl<R: Robot, T: Scalar> State<R, T> {
    /// Returns the state after the time `dt` (s) under the joint forces `tau`, with contacts, joint
    /// limits and dry joint friction: the function [`step`](crate::Robot::step), whose solver starts
    /// from zero accelerations. [`SolvedStep::step`] starts from the accelerations of the last step,
    /// which mostly takes fewer iterations.
    ///
    /// ```
    /// use modyn_runtime::simulate::State;
    /// use modyn_runtime::{ContactSurface, Robot, StepSettings, functions};
    ///
    /// /// A second of steps of two milliseconds.
    /// fn slide<R>(
    ///     state: &State<R>,
    ///     settings: &StepSettings<f64, R::PerTouchingShape<ContactSurface<f64>>>,
    /// ) -> State<R>
    /// where
    ///     R: Robot + functions::Step,
    /// {
    ///     let no_torques = state.qd;
    ///     let mut step = state.step(0.002, &no_torques, settings);
    ///     for _ in 1..500 {
    ///         step = step.step(0.002, &no_torques, settings);
    ///     }
    ///     step.state
    /// }
    /// ```
    #[must_use]
    pub fn step(&self, dt: T, tau: &R::V<T>, settings: &SurfaceSettings<R, T>) -> SolvedStep<R, T>
    where
        R: functions::Step,
    {
        self.solved_from(&R::V::<T>::from_fn(|_| T::zero()), dt, tau, settings)
    }

    fn solved_from(
        &self,
        warm_start: &R::V<T>,
        dt: T,
        tau: &R::V<T>,
        settings: &SurfaceSettings<R, T>,
    ) -> SolvedStep<R, T>
    where
        R: functions::Step,
    {
        let StepSolution { q, qd, qdd, forces, residual, iterations } =
            R::step(&self.q, &self.qd, tau, dt, warm_start, settings);
        SolvedStep { state: Self { q, qd }, qdd, forces, residual, iterations }
    }
}

impl<R: Robot + functions::Step, T: Scalar> SolvedStep<R, T> {
    /// Returns the step after this one: [`State::step`], whose solver starts from the accelerations
    /// of this step.
    #[must_use]
    pub fn step(&self, dt: T, tau: &R::V<T>, settings: &SurfaceSettings<R, T>) -> Self {
        self.state.solved_from(&self.qdd, dt, tau, settings)
    }
}
