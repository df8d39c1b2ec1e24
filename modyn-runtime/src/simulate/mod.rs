//! Simulation and control, for any robot.
//!
//! ```no_run
//! use modyn_runtime::simulate::{Gains, Reference, State};
//! use modyn_runtime::{Robot, functions};
//!
//! /// A second of computed torque towards `goal`.
//! fn steer<R: Robot + functions::Defaults>(mut state: State<R>, goal: R::Q<f64>) -> State<R> {
//!     let reference = Reference::<R>::at_rest(goal);
//!     for _ in 0..1000 {
//!         state = state.runge_kutta_4(0.001, |state| {
//!             let gains = Gains { kp: 225.0, kd: 30.0 };
//!             let tau = state.computed_torque(&reference, gains);
//!             R::forward_dynamics(&state.q, &state.qd, &tau)
//!         });
//!     }
//!     state
//! }
//! ```
//!
//! Nothing here allocates. The caller computes the accelerations in a function of the state, and
//! can add external forces and payloads there.
//!
//! [`rollout::rollout`] moves many motions over many time steps, with the accelerations of a batch
//! function.
//!
//! [`State::step`] is a step with contacts, joint limits and dry joint friction by MuJoCo's law.
//! [`SpringGround`] is the simple alternative: a force for each point, for
//! [`State::semi_implicit_euler`].

mod ground;
mod height_field;
pub mod rollout;
mod step;

pub use ground::{SpringGround, limit_effort};
pub use height_field::{HeightField, HeightGrid};
pub use step::SolvedStep;

use core::fmt;

use crate::{Array, Robot, Scalar, functions};

/// The coordinates and velocities of a robot.
pub struct State<R: Robot, T: Scalar = f64> {
    /// The coordinates.
    pub q: R::Q<T>,
    /// The velocities.
    pub qd: R::V<T>,
}

/// The desired motion of a robot at an instant.
pub struct Reference<R: Robot, T: Scalar = f64> {
    /// The desired coordinates.
    pub q: R::Q<T>,
    /// The desired velocities.
    pub qd: R::V<T>,
    /// The desired accelerations.
    pub qdd: R::V<T>,
}

/// The gains of a proportional-derivative controller, from errors to accelerations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gains<T = f64> {
    /// The proportional gain: the acceleration per displacement, 1/s^2.
    pub kp: T,
    /// The derivative gain: the acceleration per velocity error, 1/s.
    pub kd: T,
}

/// Returns a + factor b, entry by entry.
fn add_scaled<T: Scalar, V: Array<T>>(a: &V, factor: T, b: &V) -> V {
    let mut sum = *a;
    for (sum, &b) in sum.as_mut().iter_mut().zip(b.as_ref()) {
        *sum = *sum + factor * b;
    }
    sum
}

/// Returns a + (b + 2 c + 2 d + e) factor.
fn add_weighted<T: Scalar, V: Array<T>>(a: &V, factor: T, [b, c, d, e]: [&V; 4]) -> V {
    let twice = factor + factor;
    let sum = add_scaled(&add_scaled(a, factor, b), twice, c);
    add_scaled(&add_scaled(&sum, twice, d), factor, e)
}

impl<R: Robot, T: Scalar> State<R, T> {
    /// Returns the state at rest at the coordinates `q`.
    #[must_use]
    pub fn at_rest(q: R::Q<T>) -> Self {
        Self { q, qd: R::V::<T>::from_fn(|_| T::zero()) }
    }

    /// Returns the state after the time `dt` (s), by the semi-implicit Euler method of first order:
    /// the new velocities move the robot. `accelerations` (rad/s^2, m/s^2) is evaluated once.
    ///
    /// The energy error of an undamped oscillation of angular frequency w stays bounded if w `dt`
    /// is below 2. With a stiffer spring the motion diverges, as with any explicit method.
    ///
    /// ```
    /// use modyn_runtime::simulate::State;
    /// use modyn_runtime::{Robot, functions};
    ///
    /// /// A millisecond of free fall.
    /// fn fall<R: Robot + functions::Defaults>(state: &State<R>, tau: &R::V<f64>) -> State<R> {
    ///     state.semi_implicit_euler(0.001, |state| R::forward_dynamics(&state.q, &state.qd, tau))
    /// }
    /// ```
    #[must_use]
    pub fn semi_implicit_euler(&self, dt: T, accelerations: impl FnOnce(&Self) -> R::V<T>) -> Self
    where
        R: functions::Integrate,
    {
        let qd = add_scaled(&self.qd, dt, &accelerations(self));
        let zero = R::V::<T>::from_fn(|_| T::zero());
        Self { q: R::integrate(&self.q, &add_scaled(&zero, dt, &qd)), qd }
    }

    /// Returns the state after the time `dt` (s), by the classical Runge-Kutta method of fourth
    /// order.
    ///
    /// `accelerations` (rad/s^2, m/s^2) is evaluated four times. Quaternions are integrated as four
    /// numbers and scaled to length 1 at the end of the step, which keeps the order.
    ///
    /// ```
    /// use modyn_runtime::simulate::State;
    /// use modyn_runtime::{Robot, functions};
    ///
    /// /// A second from rest at `q` under the constant joint forces `tau`, in steps of a millisecond.
    /// fn push<R: Robot + functions::Defaults>(q: R::Q<f64>, tau: &R::V<f64>) -> State<R> {
    ///     let mut state = State::<R>::at_rest(q);
    ///     for _ in 0..1000 {
    ///         state = state.runge_kutta_4(0.001, |now| R::forward_dynamics(&now.q, &now.qd, tau));
    ///     }
    ///     state
    /// }
    /// ```
    #[must_use]
    pub fn runge_kutta_4(&self, dt: T, mut accelerations: impl FnMut(&Self) -> R::V<T>) -> Self
    where
        R: functions::VelocityToQdot + functions::NormalizeConfiguration,
    {
        let half = dt * T::from_f64(0.5);
        let mut rates =
            |state: &Self| (R::velocity_to_qdot(&state.q, &state.qd), accelerations(state));
        let moved = |time: T, (q, qd): &(R::Q<T>, R::V<T>)| Self {
            q: add_scaled(&self.q, time, q),
            qd: add_scaled(&self.qd, time, qd),
        };
        let first = rates(self);
        let second = rates(&moved(half, &first));
        let third = rates(&moved(half, &second));
        let last = rates(&moved(dt, &third));
        let sixth = dt * T::from_f64(1.0 / 6.0);
        let q = add_weighted(&self.q, sixth, [&first.0, &second.0, &third.0, &last.0]);
        let qd = add_weighted(&self.qd, sixth, [&first.1, &second.1, &third.1, &last.1]);
        Self { q: R::normalize_configuration(&q), qd }
    }

    /// Returns the joint forces that make the robot follow `reference`: inverse dynamics of the
    /// reference's acceleration plus the feedback of the errors (computed torque control).
    ///
    /// ```
    /// use modyn_runtime::simulate::{Gains, Reference, State};
    /// use modyn_runtime::{Robot, functions};
    ///
    /// /// The joint forces that bring the robot to rest at `goal`, critically damped at 15 rad/s.
    /// fn hold<R: Robot + functions::Defaults>(state: &State<R>, goal: R::Q<f64>) -> R::V<f64> {
    ///     state.computed_torque(&Reference::at_rest(goal), Gains { kp: 225.0, kd: 30.0 })
    /// }
    /// ```
    #[must_use]
    pub fn computed_torque(&self, reference: &Reference<R, T>, gains: Gains<T>) -> R::V<T>
    where
        R: functions::Difference + functions::InverseDynamics,
    {
        self.computed_torque_with(&R::Params::<T>::default(), reference, gains)
    }

    /// Returns the joint forces of computed torque control, with a robot's run-time parameters.
    #[must_use]
    pub fn computed_torque_with(
        &self,
        params: &R::Params<T>,
        reference: &Reference<R, T>,
        gains: Gains<T>,
    ) -> R::V<T>
    where
        R: functions::Difference + functions::InverseDynamics,
    {
        let displacement = R::difference(&self.q, &reference.q);
        let velocity = add_scaled(&reference.qd, -T::one(), &self.qd);
        let pulled = add_scaled(&reference.qdd, gains.kp, &displacement);
        let qdd = add_scaled(&pulled, gains.kd, &velocity);
        R::inverse_dynamics_with(params, &self.q, &self.qd, &qdd)
    }
}

impl<R: Robot, T: Scalar> Reference<R, T> {
    /// Returns the reference to stand still at the coordinates `q`.
    #[must_use]
    pub fn at_rest(q: R::Q<T>) -> Self {
        let zero = R::V::<T>::from_fn(|_| T::zero());
        Self { q, qd: zero, qdd: zero }
    }
}

impl<R: Robot, T: Scalar> Clone for State<R, T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<R: Robot, T: Scalar> Copy for State<R, T> {}

impl<R: Robot, T: Scalar + fmt::Debug> fmt::Debug for State<R, T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let q = self.q.as_ref();
        let qd = self.qd.as_ref();
        f.debug_struct("State").field("q", &q).field("qd", &qd).finish()
    }
}

impl<R: Robot, T: Scalar> Clone for Reference<R, T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<R: Robot, T: Scalar> Copy for Reference<R, T> {}

impl<R: Robot, T: Scalar + fmt::Debug> fmt::Debug for Reference<R, T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let q = self.q.as_ref();
        let qd = self.qd.as_ref();
        let qdd = self.qdd.as_ref();
        f.debug_struct("Reference").field("q", &q).field("qd", &qd).field("qdd", &qdd).finish()
    }
}
