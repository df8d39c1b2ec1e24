//! Code that XLA and Python call on many states: a function of arrays, or a rollout.

use std::ops::Range;
use std::sync::Arc;

use super::kernel::{ArrayShapes, Arrays, StateFunction};
use super::rollout::Rollout;
use super::states::{Broadcast, Numbers, Results};
use crate::number::Number;
use crate::pool::{INSTRUCTIONS_PER_THREAD, Pool};

/// A function of arrays, or a rollout of one.
pub enum ArrayCode<S: Number + 'static> {
    /// A function of the arrays of a state.
    Function(Arc<StateFunction<S>>),
    /// A rollout.
    Rollout(Box<Rollout<S>>),
}

impl<S: Number> ArrayCode<S> {
    /// Returns the shapes of the arrays, for one state.
    pub fn shapes(&self) -> &ArrayShapes {
        match self {
            Self::Function(function) => function.shapes(),
            Self::Rollout(rollout) => &rollout.shapes,
        }
    }

    /// Computes the results of all states of a broadcast of arrays, which `pool` shares; not all of
    /// them if the pool must end.
    ///
    /// # Errors
    ///
    /// If the arrays are not the function's arrays, if one is too short, or if a number is outside
    /// of its range: in an argument that stays in place, one that was read.
    pub fn compute(
        &self,
        broadcast: &Broadcast<'_>,
        inputs: &[Numbers<'_, S>],
        outputs: &[Results<'_, S>],
        pool: &dyn Pool,
    ) -> Result<(), String> {
        let arrays = Arrays::new(self.shapes(), broadcast, inputs, outputs)?;
        match self {
            Self::Function(function) => {
                let kernel = function.kernel()?;
                let run =
                    |states: Range<usize>, lanes| kernel.compute(&arrays, states, lanes, pool);
                share(&run, arrays.states(), kernel.cost(), kernel.lanes(), pool);
                kernel.fault().map_or(Ok(()), Err)
            }
            Self::Rollout(rollout) => {
                let ready = rollout.ready()?;
                let run = |states: Range<usize>, lanes| ready.run(&arrays, states, lanes, pool);
                share(&run, arrays.states(), ready.cost(), ready.lanes(), pool);
                ready.fault().map_or(Ok(()), Err)
            }
        }
    }
}

/// Computes all states by `run`, which gets states and the number of states that are computed
/// together. `cost` are the instructions of a state, as they count in threads.
fn share(
    run: &(dyn Fn(Range<usize>, usize) + Sync),
    states: usize,
    cost: usize,
    lanes: usize,
    pool: &dyn Pool,
) {
    let lanes = if states == 1 { 1 } else { lanes };
    let groups = states.div_ceil(lanes);
    let useful = states.saturating_mul(cost).div_ceil(INSTRUCTIONS_PER_THREAD);
    let chunks = if useful > 1 { pool.threads().min(useful).min(groups).max(1) } else { 1 };
    if chunks == 1 {
        return run(0..states, lanes);
    }
    let share = groups.div_ceil(chunks) * lanes;
    pool.share(chunks, &|chunk| {
        let first = (chunk * share).min(states);
        run(first..(first + share).min(states), lanes);
    });
}
