//! Many time steps in one call, and their products with derivatives: the states stay in lanes from
//! the first step to the last.
//!
//! A step is a function of arrays whose first arguments are the state, and so are its results. Of
//! its other arguments, some have numbers for each step, and the others are the same for all steps.
//! Backwards, the states of a part of the steps are computed again from the state at the start of
//! the part, so that few are stored.

use std::ops::Range;

use super::kernel::{Arrays, Kernel, StateFunction};
use crate::number::Number;
use crate::pool::{Pool, Questions};

/// The steps whose states are stored at a time. A longer motion is divided into parts, whose first
/// states are stored.
const MAX_STORED: usize = 128;

/// A rollout of a step.
pub struct Rollout<S: Number + 'static> {
    /// The step.
    pub step: &'static StateFunction<S>,
    /// The arrays of the state.
    pub state: usize,
    /// For each argument of the step, whether it has numbers for each step.
    pub is_sequence: Vec<bool>,
    /// The number of steps.
    pub steps: usize,
    /// Whether the results are the states after all steps, or the state after the last one alone.
    pub trajectory: bool,
    /// Products of weights and derivatives, in place of the states.
    pub reverse: Option<Reverse<S>>,
}

/// The derivatives of a rollout.
pub struct Reverse<S: Number + 'static> {
    /// The products of the step with respect to the state and the `variables`.
    pub step: &'static StateFunction<S>,
    /// The arguments of the step with respect to which derivatives are taken, in ascending order.
    pub variables: Vec<usize>,
}

/// A rollout, ready to be called.
pub struct Ready<'a, S: Number + 'static> {
    rollout: &'a Rollout<S>,
    step: Kernel<'a, S>,
    reverse: Option<Kernel<'a, S>>,
}

impl<S: Number> Rollout<S> {
    /// Returns the rollout, ready to be called.
    ///
    /// # Errors
    ///
    /// If the step was not compiled, which no caller can bring about.
    pub fn ready(&self) -> Result<Ready<'_, S>, String> {
        let reverse = self.reverse.as_ref().map(|reverse| reverse.step.kernel()).transpose()?;
        Ok(Ready { rollout: self, step: self.step.kernel()?, reverse })
    }
}

/// The memory of a group of motions, with a motion in each lane.
struct Memory<'p, S> {
    /// The arguments of a step, the state first; backwards, then the weights of the state.
    numbers: Vec<S>,
    /// The state after the step.
    next: Vec<S>,
    lanes: usize,
    questions: Questions<'p>,
}

impl<S: Number> Memory<'_, S> {
    /// Returns whether the work must end after a step of a kernel.
    fn must_end(&mut self, kernel: &Kernel<'_, S>) -> bool {
        self.questions.must_end(kernel.work().saturating_mul(self.lanes))
    }
}

impl<S: Number> Ready<'_, S> {
    /// Returns the instructions of a motion, as they count in threads.
    pub fn cost(&self) -> usize {
        let step = self.step.cost() + self.reverse.as_ref().map_or(0, Kernel::cost);
        step.saturating_mul(self.rollout.steps)
    }

    /// Returns the motions that are computed together.
    pub fn lanes(&self) -> usize {
        let reverse = self.reverse.as_ref().map_or(usize::MAX, Kernel::lanes);
        if reverse == 1 { 1 } else { self.step.lanes() }
    }

    /// Computes motions; not all of them if the pool must end.
    pub fn run(
        &self,
        arrays: &Arrays<'_, S>,
        motions: Range<usize>,
        lanes: usize,
        pool: &dyn Pool,
    ) {
        let arguments = self.arguments();
        let state: usize = self.state_lengths().iter().sum();
        let weights = if self.reverse.is_some() { state } else { 0 };
        let count = arguments.iter().sum::<usize>() + weights;
        let numbers = vec![S::zero(); count * lanes];
        let next = vec![S::zero(); state * lanes];
        let mut memory = Memory { numbers, next, lanes, questions: Questions::new(pool) };
        for first in motions.clone().step_by(lanes) {
            let group = first..first + lanes;
            if pool.must_end() {
                return;
            }
            self.read(arrays, &group, None, &mut memory);
            match (&self.reverse, &self.rollout.reverse) {
                (Some(kernel), Some(reverse)) => {
                    self.backward(arrays, &group, motions.end, kernel, reverse, &mut memory);
                }
                _ => self.forward(arrays, &group, motions.end, &mut memory),
            }
        }
    }

    /// Returns the numbers of each argument of the step.
    fn arguments(&self) -> &[usize] {
        let [arguments, _] = self.rollout.step.shapes().lengths();
        arguments
    }

    /// Returns the numbers of each array of the state.
    fn state_lengths(&self) -> &[usize] {
        &self.arguments()[..self.rollout.state]
    }

    /// Reads the arguments that are sequences at a step, or those that are not.
    fn read(
        &self,
        arrays: &Arrays<'_, S>,
        group: &Range<usize>,
        step: Option<usize>,
        memory: &mut Memory<'_, S>,
    ) {
        let lanes = memory.lanes;
        let mut row = 0;
        for (k, &length) in self.arguments().iter().enumerate() {
            let rows = row * lanes..(row + length) * lanes;
            row += length;
            if self.rollout.is_sequence[k] == step.is_some() {
                let at = step.unwrap_or_default() * length;
                let rows = &mut memory.numbers[rows];
                arrays.gather(k, group, at, rows, |place, number| *place = number);
            }
        }
    }

    /// Does a step from the state at the start of the numbers.
    fn advance(
        &self,
        arrays: &Arrays<'_, S>,
        group: &Range<usize>,
        step: usize,
        memory: &mut Memory<'_, S>,
    ) {
        self.read(arrays, group, Some(step), memory);
        let Memory { numbers, next, lanes, .. } = memory;
        let arguments: usize = self.arguments().iter().sum();
        self.step.run(&numbers[..arguments * *lanes], next, *lanes);
        numbers[..next.len()].copy_from_slice(next);
    }

    fn forward(
        &self,
        arrays: &Arrays<'_, S>,
        group: &Range<usize>,
        end: usize,
        memory: &mut Memory<'_, S>,
    ) {
        let Rollout { steps, trajectory, .. } = *self.rollout;
        for step in 0..steps {
            self.advance(arrays, group, step, memory);
            if memory.must_end(&self.step) {
                return;
            }
            if trajectory || step + 1 == steps {
                let mut rest = &*memory.next;
                for (k, &length) in self.state_lengths().iter().enumerate() {
                    let rows;
                    (rows, rest) = rest.split_at(length * memory.lanes);
                    let at = if trajectory { step * length } else { 0 };
                    arrays.scatter(k, group, at, rows, end);
                }
            }
        }
        if steps == 0 && !trajectory {
            let mut rest = &*memory.numbers;
            for (k, &length) in self.state_lengths().iter().enumerate() {
                let rows;
                (rows, rest) = rest.split_at(length * memory.lanes);
                arrays.scatter(k, group, 0, rows, end);
            }
        }
    }

    fn backward(
        &self,
        arrays: &Arrays<'_, S>,
        group: &Range<usize>,
        end: usize,
        kernel: &Kernel<'_, S>,
        reverse: &Reverse<S>,
        memory: &mut Memory<'_, S>,
    ) {
        let Rollout { steps, trajectory, .. } = *self.rollout;
        let lanes = memory.lanes;
        let arguments = self.arguments();
        let state = memory.next.len();
        let weights = memory.numbers.len() - state;
        // The first state of each part, then the states of one part.
        let part = if steps <= MAX_STORED { steps.max(1) } else { steps.isqrt() + 1 };
        let parts = steps.div_ceil(part);
        let mut starts = vec![S::zero(); parts * state];
        for (k, start) in starts.chunks_exact_mut(state.max(1)).enumerate() {
            start.copy_from_slice(&memory.numbers[..state]);
            if k + 1 < parts {
                for step in k * part..(k + 1) * part {
                    self.advance(arrays, group, step, memory);
                    if memory.must_end(&self.step) {
                        return;
                    }
                }
            }
        }
        let mut states = vec![S::zero(); part * state];
        let results: usize = reverse.step.shapes().lengths()[1].iter().sum();
        let mut gradient = vec![S::zero(); results * lanes];
        // The sums of the gradients by arguments that are the same for all steps.
        let mut sums = vec![S::zero(); results * lanes];
        memory.numbers[weights..].fill(S::zero());
        let add = |place: &mut S, number: S| *place = *place + number;
        for k in (0..parts).rev() {
            let part_steps = k * part..((k + 1) * part).min(steps);
            memory.numbers[..state].copy_from_slice(&starts[k * state..][..state]);
            for step in part_steps.clone() {
                states[(step - part_steps.start) * state..][..state]
                    .copy_from_slice(&memory.numbers[..state]);
                if step + 1 < part_steps.end {
                    self.advance(arrays, group, step, memory);
                }
                if memory.must_end(&self.step) {
                    return;
                }
            }
            for step in part_steps.clone().rev() {
                if trajectory || step + 1 == steps {
                    let mut row = weights;
                    for (j, &length) in self.state_lengths().iter().enumerate() {
                        let at = if trajectory { step * length } else { 0 };
                        let rows = &mut memory.numbers[row..row + length * lanes];
                        arrays.gather(arguments.len() + j, group, at, rows, add);
                        row += length * lanes;
                    }
                }
                memory.numbers[..state]
                    .copy_from_slice(&states[(step - part_steps.start) * state..][..state]);
                self.read(arrays, group, Some(step), memory);
                kernel.run(&memory.numbers, &mut gradient, lanes);
                if memory.must_end(kernel) {
                    return;
                }
                memory.numbers[weights..].copy_from_slice(&gradient[..state]);
                self.collect(arrays, (group, end), step, (reverse, &gradient, &mut sums), lanes);
            }
        }
        // Without a step, the weights of the last state are those of the first.
        if steps == 0 && !trajectory {
            let mut row = weights;
            for (j, &length) in self.state_lengths().iter().enumerate() {
                let rows = &mut memory.numbers[row..row + length * lanes];
                arrays.gather(arguments.len() + j, group, 0, rows, add);
                row += length * lanes;
            }
        }
        sums[..state].copy_from_slice(&memory.numbers[weights..]);
        self.finish(arrays, group, end, reverse, &sums, lanes);
    }

    /// Returns each variable with its index among the results, or `None` if it is no result, and
    /// its rows in a gradient.
    fn variables<'v>(
        &'v self,
        reverse: &'v Reverse<S>,
    ) -> impl Iterator<Item = (usize, Option<usize>, Range<usize>)> + 'v {
        let arguments = self.arguments();
        let varies = |k: &usize| *k < self.rollout.state || reverse.variables.contains(k);
        let mut row = 0;
        (0..arguments.len()).filter(varies).map(move |k| {
            let rows = row..row + arguments[k];
            row += arguments[k];
            (k, reverse.variables.iter().position(|&variable| variable == k), rows)
        })
    }

    /// Writes the gradients by arguments of one step, and adds those by arguments of all steps to
    /// their sums.
    fn collect(
        &self,
        arrays: &Arrays<'_, S>,
        (group, end): (&Range<usize>, usize),
        step: usize,
        (reverse, gradient, sums): (&Reverse<S>, &[S], &mut [S]),
        lanes: usize,
    ) {
        for (k, result, rows) in self.variables(reverse) {
            let own_rows = rows.start * lanes..rows.end * lanes;
            match result {
                Some(result) if self.rollout.is_sequence[k] => {
                    let at = step * rows.len();
                    arrays.scatter(result, group, at, &gradient[own_rows], end);
                }
                Some(_) if k >= self.rollout.state => {
                    let sums = sums[own_rows.clone()].iter_mut();
                    sums.zip(&gradient[own_rows]).for_each(|(sum, &x)| *sum = *sum + x);
                }
                _ => {}
            }
        }
    }

    /// Writes the gradients by the first state and by the arguments of all steps.
    fn finish(
        &self,
        arrays: &Arrays<'_, S>,
        group: &Range<usize>,
        end: usize,
        reverse: &Reverse<S>,
        sums: &[S],
        lanes: usize,
    ) {
        for (k, result, rows) in self.variables(reverse) {
            if let Some(result) = result.filter(|_| !self.rollout.is_sequence[k]) {
                let own_rows = &sums[rows.start * lanes..rows.end * lanes];
                arrays.scatter(result, group, 0, own_rows, end);
            }
        }
    }
}
