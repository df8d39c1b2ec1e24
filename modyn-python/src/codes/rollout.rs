//! Many time steps in one call, and their products with derivatives: the states stay in lanes from
//! the first step to the last.
//!
//! A step is a function of arrays whose first results are the state: each is an argument of the next
//! step. Of the other arguments, some have numbers for each step, and the others are the same for
//! all steps. Backwards, the states of a part of the steps are computed again from the state at the
//! start of the part, so that few are stored.
//!
//! A step with a solver carries the accelerations, from which the solver of the next step starts.
//! Its derivatives are those at the solution: backwards, the solver starts from the accelerations of
//! its own solution, and no gradient flows through the start.

use std::ops::Range;
use std::sync::Arc;

use super::kernel::{ArrayShapes, Arrays, Kernel, Lanes, StateFunction};
use crate::number::Number;
use crate::pool::{Pool, Questions};

/// The steps whose states are stored at a time. A longer motion is divided into parts, whose first
/// states are stored.
const MAX_STORED: usize = 128;

/// A rollout of a step.
pub struct Rollout<S: Number + 'static> {
    /// The step.
    pub step: Arc<StateFunction<S>>,
    /// The arguments of the step that are the state, in the order of its first results.
    pub state: Vec<usize>,
    /// The argument of the state from which a solver starts.
    pub start: Option<usize>,
    /// For each argument of the step, whether it has numbers for each step.
    pub is_sequence: Vec<bool>,
    /// The number of steps.
    pub steps: usize,
    /// Whether there are results of all steps, or only of the last one, with the largest of all
    /// steps for numbers that are not of the state.
    pub trajectory: bool,
    /// Products of weights and derivatives, in place of the states.
    pub reverse: Option<Reverse<S>>,
    /// The shapes of its arrays.
    pub shapes: ArrayShapes,
}

/// The derivatives of a rollout.
pub struct Reverse<S: Number + 'static> {
    /// The products of the step with respect to the state without the solver's start, and the
    /// `variables`.
    pub step: Arc<StateFunction<S>>,
    /// The arguments of the step with respect to which derivatives are taken, in ascending order.
    pub variables: Vec<usize>,
}

/// A rollout, ready to be called.
pub struct Ready<'a, S: Number + 'static> {
    rollout: &'a Rollout<S>,
    /// The rows of each array of the state among the rows of the arguments.
    state_rows: Vec<Range<usize>>,
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
        let [arguments, _] = self.step.shapes().rows();
        let rows_of = |&k: &usize| {
            let first: usize = arguments[..k].iter().sum();
            first..first + arguments[k]
        };
        let state_rows = self.state.iter().map(rows_of).collect();
        Ok(Ready { rollout: self, state_rows, step: self.step.kernel()?, reverse })
    }
}

/// The memory of a group of motions, with a motion in each lane.
struct Memory<'p, S> {
    /// The arguments of a step; backwards, then the weights of the results.
    numbers: Vec<S>,
    /// The results of the step, the state first.
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

/// A group of motions, one in each lane. Lanes from the motion `end` on repeat the last motion, and
/// have no results.
struct Group {
    motions: Range<usize>,
    end: usize,
}

/// The gradients of a group of motions, in lanes.
struct Gradients<S> {
    /// The gradients by the arguments of a step.
    of_step: Vec<S>,
    /// The sums of the gradients by arguments that are the same for all steps.
    sums: Vec<S>,
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

    /// Returns what was wrong with the arguments that it read in place, if anything was.
    pub fn fault(&self) -> Option<String> {
        self.step.fault().or_else(|| self.reverse.as_ref()?.fault())
    }

    /// Computes motions; not all of them if the pool must end.
    pub fn run(
        &self,
        arrays: &Arrays<'_, S>,
        motions: Range<usize>,
        lanes: usize,
        pool: &dyn Pool,
    ) {
        let results: usize = self.results().iter().sum();
        let weights = if self.reverse.is_some() { results } else { 0 };
        let count = self.arguments().iter().sum::<usize>() + weights;
        let numbers = vec![S::zero(); count * lanes];
        let next = vec![S::zero(); results * lanes];
        let mut memory = Memory { numbers, next, lanes, questions: Questions::new(pool) };
        for first in motions.clone().step_by(lanes) {
            let group = Group { motions: first..first + lanes, end: motions.end };
            if pool.must_end() {
                return;
            }
            self.read(arrays, &group, None, &mut memory);
            match (&self.reverse, &self.rollout.reverse) {
                (Some(kernel), Some(reverse)) => {
                    self.backward(arrays, &group, kernel, reverse, &mut memory);
                }
                _ => self.forward(arrays, &group, &mut memory),
            }
        }
    }

    /// Returns the numbers of each argument in the rows of the step.
    fn arguments(&self) -> &[usize] {
        let [arguments, _] = self.rollout.step.shapes().rows();
        arguments
    }

    /// Returns the numbers of each result of the step.
    fn results(&self) -> &[usize] {
        let [_, results] = self.rollout.step.shapes().lengths();
        results
    }

    /// Returns the numbers of the state.
    fn state_length(&self) -> usize {
        self.state_rows.iter().map(Range::len).sum()
    }

    /// Copies the state, in the order of the results, to the arguments.
    fn restore(&self, state: &[S], numbers: &mut [S], lanes: usize) {
        let mut rest = state;
        for rows in &self.state_rows {
            let array;
            (array, rest) = rest.split_at(rows.len() * lanes);
            numbers[rows.start * lanes..rows.end * lanes].copy_from_slice(array);
        }
    }

    /// Copies the state among the arguments to `state`, in the order of the results.
    fn save(&self, numbers: &[S], state: &mut [S], lanes: usize) {
        let mut rest = state;
        for rows in &self.state_rows {
            let array;
            (array, rest) = rest.split_at_mut(rows.len() * lanes);
            array.copy_from_slice(&numbers[rows.start * lanes..rows.end * lanes]);
        }
    }

    /// Returns whether a result is a number that is not of the state, such as a residual.
    fn is_number(&self, result: usize) -> bool {
        result >= self.rollout.state.len()
            && self.rollout.step.shapes().outputs()[result].is_empty()
    }

    /// Reads the arguments that are sequences at a step, or those that are not.
    fn read(
        &self,
        arrays: &Arrays<'_, S>,
        group: &Group,
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
                arrays.gather(k, &group.motions, at, rows, |place, number| *place = number);
            }
        }
    }

    /// Does a step from the state among the arguments.
    fn advance(
        &self,
        arrays: &Arrays<'_, S>,
        group: &Group,
        step: usize,
        memory: &mut Memory<'_, S>,
    ) {
        self.read(arrays, group, Some(step), memory);
        let Memory { numbers, next, lanes, .. } = memory;
        let arguments: usize = self.arguments().iter().sum();
        let motions = Lanes::new(arrays, group.motions.clone());
        self.step.run(&numbers[..arguments * *lanes], next, &motions);
        self.restore(&next[..self.state_length() * *lanes], numbers, *lanes);
    }

    fn forward(&self, arrays: &Arrays<'_, S>, group: &Group, memory: &mut Memory<'_, S>) {
        let Rollout { steps, trajectory, .. } = *self.rollout;
        let mut largest = vec![S::zero(); memory.next.len()];
        for step in 0..steps {
            self.advance(arrays, group, step, memory);
            if memory.must_end(&self.step) {
                return;
            }
            if !trajectory {
                self.keep_largest(&mut largest, memory);
            }
            if trajectory || step + 1 == steps {
                self.write(arrays, group, if trajectory { step } else { 0 }, memory);
            }
        }
        if steps == 0 && !trajectory {
            let Memory { numbers, next, lanes, .. } = memory;
            self.save(numbers, &mut next[..self.state_length() * *lanes], *lanes);
            self.write(arrays, group, 0, memory);
        }
    }

    /// Replaces each number of the results that is not of the state by the largest of the steps so
    /// far. NaN stays NaN.
    fn keep_largest(&self, largest: &mut [S], memory: &mut Memory<'_, S>) {
        let mut row = 0;
        for (k, &length) in self.results().iter().enumerate() {
            let rows = row * memory.lanes..(row + length) * memory.lanes;
            row += length;
            if self.is_number(k) {
                let numbers = memory.next[rows.clone()].iter_mut();
                for (now, last) in numbers.zip(&mut largest[rows]) {
                    let last_is_nan = (*last).into().is_nan();
                    if last_is_nan || *last > *now {
                        *now = *last;
                    }
                    *last = *now;
                }
            }
        }
    }

    /// Writes the results of a step.
    fn write(&self, arrays: &Arrays<'_, S>, group: &Group, step: usize, memory: &Memory<'_, S>) {
        let mut rest = &*memory.next;
        for (k, &length) in self.results().iter().enumerate() {
            let rows;
            (rows, rest) = rest.split_at(length * memory.lanes);
            arrays.scatter(k, &group.motions, step * length, rows, group.end);
        }
    }

    fn backward(
        &self,
        arrays: &Arrays<'_, S>,
        group: &Group,
        kernel: &Kernel<'_, S>,
        reverse: &Reverse<S>,
        memory: &mut Memory<'_, S>,
    ) {
        let Rollout { steps, trajectory, start, .. } = *self.rollout;
        let lanes = memory.lanes;
        let state = self.state_length() * lanes;
        let weights = memory.numbers.len() - memory.next.len();
        // The first state of each part, then the states of one part.
        let part = if steps <= MAX_STORED { steps.max(1) } else { steps.isqrt() + 1 };
        let parts = steps.div_ceil(part);
        let mut starts = vec![S::zero(); parts * state];
        for (k, first) in starts.chunks_exact_mut(state.max(1)).enumerate() {
            self.save(&memory.numbers, first, lanes);
            if k + 1 < parts {
                for step in k * part..(k + 1) * part {
                    self.advance(arrays, group, step, memory);
                    if memory.must_end(&self.step) {
                        return;
                    }
                }
            }
        }
        let mut states = vec![S::zero(); (part + 1) * state];
        let results: usize = reverse.step.shapes().lengths()[1].iter().sum();
        let mut gradients = Gradients {
            of_step: vec![S::zero(); results * lanes],
            sums: vec![S::zero(); results * lanes],
        };
        memory.numbers[weights..].fill(S::zero());
        for k in (0..parts).rev() {
            let part_steps = k * part..((k + 1) * part).min(steps);
            self.restore(&starts[k * state..][..state], &mut memory.numbers, lanes);
            for step in part_steps.clone() {
                let at = (step - part_steps.start) * state;
                self.save(&memory.numbers, &mut states[at..][..state], lanes);
                // The derivatives of a solver are those at the solution of the last step, too.
                if step + 1 < part_steps.end || start.is_some() {
                    self.advance(arrays, group, step, memory);
                    self.save(&memory.numbers, &mut states[at + state..][..state], lanes);
                }
                if memory.must_end(&self.step) {
                    return;
                }
            }
            for step in part_steps.clone().rev() {
                if trajectory || step + 1 == steps {
                    self.add_weights(arrays, group, if trajectory { step } else { 0 }, memory);
                }
                let at = (step - part_steps.start) * state;
                self.restore(&states[at..][..state], &mut memory.numbers, lanes);
                if let Some(start) = start {
                    self.start_from(&states[at + state..][..state], start, memory);
                }
                self.read(arrays, group, Some(step), memory);
                let motions = Lanes::new(arrays, group.motions.clone());
                kernel.run(&memory.numbers, &mut gradients.of_step, &motions);
                if memory.must_end(kernel) {
                    return;
                }
                let weights_before = &mut memory.numbers[weights..];
                self.carry_back(reverse, &gradients.of_step, weights_before, lanes);
                self.collect(arrays, group, step, reverse, &mut gradients);
            }
        }
        // Without a step, the last state is the first one and so are its weights.
        if steps == 0 && !trajectory {
            self.add_weights(arrays, group, 0, memory);
        }
        for (k, _, rows) in self.variables(reverse) {
            if let Some(first) = self.first_row(k) {
                let own_rows = rows.start * lanes..rows.end * lanes;
                let weights = &memory.numbers[weights + first * lanes..][..own_rows.len()];
                gradients.sums[own_rows].copy_from_slice(weights);
            }
        }
        self.finish(arrays, group, reverse, &gradients.sums);
    }

    /// Returns the first row, among the rows of the results, of an argument of the state.
    fn first_row(&self, argument: usize) -> Option<usize> {
        let at = self.rollout.state.iter().position(|&k| k == argument)?;
        Some(self.results()[..at].iter().sum())
    }

    /// Sets the argument from which the solver starts to its numbers in a state.
    fn start_from(&self, state: &[S], start: usize, memory: &mut Memory<'_, S>) {
        let lanes = memory.lanes;
        let at = self.rollout.state.iter().position(|&k| k == start);
        if let (Some(at), Some(first)) = (at, self.first_row(start)) {
            let rows = &self.state_rows[at];
            memory.numbers[rows.start * lanes..rows.end * lanes]
                .copy_from_slice(&state[first * lanes..][..rows.len() * lanes]);
        }
    }

    /// Adds the weights of the results of a step to the weights among the numbers.
    fn add_weights(
        &self,
        arrays: &Arrays<'_, S>,
        group: &Group,
        step: usize,
        memory: &mut Memory<'_, S>,
    ) {
        let lanes = memory.lanes;
        let arguments = self.arguments().len();
        let mut row = memory.numbers.len() - memory.next.len();
        for (j, &length) in self.results().iter().enumerate() {
            let rows = &mut memory.numbers[row..row + length * lanes];
            row += length * lanes;
            let add = |place: &mut S, number: S| *place = *place + number;
            arrays.gather(arguments + j, &group.motions, step * length, rows, add);
        }
    }

    /// Sets the weights of the results of the step before to the gradient by the state.
    fn carry_back(&self, reverse: &Reverse<S>, gradient: &[S], weights: &mut [S], lanes: usize) {
        weights.fill(S::zero());
        for (k, _, rows) in self.variables(reverse) {
            if let Some(first) = self.first_row(k) {
                let gradient = &gradient[rows.start * lanes..rows.end * lanes];
                weights[first * lanes..][..gradient.len()].copy_from_slice(gradient);
            }
        }
    }

    /// Returns each variable with its index among the results, or `None` if it is no result, and
    /// its rows in a gradient.
    fn variables<'v>(
        &'v self,
        reverse: &'v Reverse<S>,
    ) -> impl Iterator<Item = (usize, Option<usize>, Range<usize>)> + 'v {
        let arguments = self.arguments();
        let Rollout { state, start, .. } = self.rollout;
        let is_carried = |k: &usize| state.contains(k) && *start != Some(*k);
        let varies = move |k: &usize| is_carried(k) || reverse.variables.contains(k);
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
        group: &Group,
        step: usize,
        reverse: &Reverse<S>,
        gradients: &mut Gradients<S>,
    ) {
        let lanes = group.motions.len();
        let Gradients { of_step, sums } = gradients;
        for (k, result, rows) in self.variables(reverse) {
            let own_rows = rows.start * lanes..rows.end * lanes;
            match result {
                Some(result) if self.rollout.is_sequence[k] => {
                    let at = step * rows.len();
                    let numbers = &of_step[own_rows];
                    arrays.scatter(result, &group.motions, at, numbers, group.end);
                }
                Some(_) if self.first_row(k).is_none() => {
                    let sums = sums[own_rows.clone()].iter_mut();
                    sums.zip(&of_step[own_rows]).for_each(|(sum, &x)| *sum = *sum + x);
                }
                _ => {}
            }
        }
    }

    /// Writes the gradients by the first state and by the arguments of all steps.
    fn finish(&self, arrays: &Arrays<'_, S>, group: &Group, reverse: &Reverse<S>, sums: &[S]) {
        let lanes = group.motions.len();
        for (k, result, rows) in self.variables(reverse) {
            if let Some(result) = result.filter(|_| !self.rollout.is_sequence[k]) {
                let own_rows = &sums[rows.start * lanes..rows.end * lanes];
                arrays.scatter(result, &group.motions, 0, own_rows, group.end);
            }
        }
    }
}
