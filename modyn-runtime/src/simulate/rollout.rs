//! Motions of many robots over many time steps, whose accelerations are computed in lanes.

use super::State;
use crate::{Array, Robot, functions};

/// The motions that advance together: several vectors of any instruction set, small enough for the
/// first cache.
const BLOCK: usize = 64;

/// The place of a time step in a rollout.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Instant {
    /// The index of the motion.
    pub motion: usize,
    /// The index of the time step.
    pub step: usize,
}

/// Moves each of `motions` by `steps` time steps of `dt` (s), by the semi-implicit Euler method.
///
/// - `forces` returns the joint forces of a time step in the state before it: the controls of a
///   plan, a feedback.
/// - `accelerations` computes the accelerations of several states from their coordinates,
///   velocities and joint forces, such as `forward_dynamics_each` of a generated robot, which has a
///   state in each lane.
/// - `visit` gets the joint forces of each step and the state after it, for costs and trajectories.
///   The steps of a motion come in their order; motions advance in blocks.
///
/// Each thread can have a part of the motions: with rayon, `motions.par_chunks_mut(1024)`.
///
/// # Errors
///
/// Those of `accelerations`. Motions are then at different steps.
///
/// # Example
///
/// ```
/// use modyn_runtime::simulate::{State, rollout};
/// use modyn_runtime::{BatchError, Robot, functions};
///
/// /// The sums of the squared velocities of motions under the forces of `plans`, over 100 steps of
/// /// 10 ms. `accelerations` is `R::forward_dynamics_each`.
/// fn costs<R: Robot + functions::Integrate>(
///     motions: &mut [State<R>],
///     plans: &[Vec<R::V<f64>>],
///     accelerations: impl Fn(&[R::Q<f64>], &[R::V<f64>], &[R::V<f64>], &mut [R::V<f64>]) -> Result<(), BatchError>,
/// ) -> Result<Vec<f64>, BatchError> {
///     let mut costs = vec![0.0; motions.len()];
///     let forces = |at: rollout::Instant, _: &State<R>| plans[at.motion][at.step];
///     rollout::rollout(motions, 100, 0.01, forces, accelerations, |at, _, state| {
///         costs[at.motion] += state.qd.as_ref().iter().map(|v| v * v).sum::<f64>();
///     })?;
///     Ok(costs)
/// }
/// ```
pub fn rollout<R, E>(
    motions: &mut [State<R>],
    steps: usize,
    dt: f64,
    forces: impl Fn(Instant, &State<R>) -> R::V<f64>,
    accelerations: impl Fn(&[R::Q<f64>], &[R::V<f64>], &[R::V<f64>], &mut [R::V<f64>]) -> Result<(), E>,
    mut visit: impl FnMut(Instant, &R::V<f64>, &State<R>),
) -> Result<(), E>
where
    R: Robot + functions::Integrate,
{
    let zero = || [R::V::<f64>::from_fn(|_| 0.0); BLOCK];
    let mut q = [R::Q::<f64>::from_fn(|_| 0.0); BLOCK];
    let [mut qd, mut tau, mut qdd] = [zero(), zero(), zero()];
    for (block, states) in motions.chunks_mut(BLOCK).enumerate() {
        let count = states.len();
        for step in 0..steps {
            let at = |k: usize| Instant { motion: block * BLOCK + k, step };
            for (k, state) in states.iter().enumerate() {
                (q[k], qd[k], tau[k]) = (state.q, state.qd, forces(at(k), state));
            }
            accelerations(&q[..count], &qd[..count], &tau[..count], &mut qdd[..count])?;
            for (k, state) in states.iter_mut().enumerate() {
                *state = state.semi_implicit_euler(dt, |_| qdd[k]);
                visit(at(k), &tau[k], state);
            }
        }
    }
    Ok(())
}
