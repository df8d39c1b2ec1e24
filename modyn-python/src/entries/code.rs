//! The code of a function of arrays or of a rollout, on many states in one call.

use std::cell::Cell;
use std::ops::Range;

use modyn_codegen::Planning;
use modyn_codegen::plan::Planned;
use modyn_codegen::program::Program;
use modyn_jit::{Call, Compiled, Options};

use super::pool::Pool;
use super::rollout::Rollout;
use super::states::{Broadcast, Numbers, Results};
use crate::function::INSTRUCTIONS_PER_THREAD;
use crate::number::Number;

/// The numbers of a state that are computed without memory from the heap.
const SMALL: usize = 256;

/// The shapes of the arrays of a function, for one state.
#[derive(Clone, Hash)]
pub struct ArrayShapes {
    /// The shapes of the arguments.
    pub inputs: Vec<Vec<usize>>,
    /// The shapes of the results.
    pub outputs: Vec<Vec<usize>>,
}

/// A function of arrays: all arguments are one row of numbers, and so are all results.
pub struct ArrayCode<S: Number> {
    kind: Kind<S>,
    shapes: ArrayShapes,
    inputs: Vec<usize>,
    outputs: Vec<usize>,
    /// The reason why there is no machine code, though it was wanted.
    pub reason: Option<String>,
}

enum Kind<S: Number> {
    Machine(Box<Compiled<S>>, &'static str),
    Evaluated(Box<Planned>),
    Rollout(Rollout<S>),
}

impl<S: Number> ArrayCode<S> {
    /// Returns the only function of a planning, with the shapes of its arrays; `None` if nothing was planned.
    pub fn new(planning: Planning, shapes: ArrayShapes, machine: bool) -> Option<Self> {
        let mut options = Options::default();
        options.batches = true;
        let name = planning.plan.functions.first()?.name;
        let compiled = machine.then(|| Compiled::from_plan(&planning, options));
        let (kind, reason) = match compiled {
            Some(Ok(compiled)) => (Kind::Machine(Box::new(compiled), name), None),
            other => {
                let reason = other.and_then(Result::err).map(|error| error.to_string());
                let planned = planning.plan.functions.into_iter().next()?;
                (Kind::Evaluated(Box::new(planned)), reason)
            }
        };
        Some(Self::of(kind, shapes, reason))
    }

    /// Returns the code of a rollout.
    pub fn of_rollout(rollout: Rollout<S>, shapes: ArrayShapes) -> Self {
        Self::of(Kind::Rollout(rollout), shapes, None)
    }

    fn of(kind: Kind<S>, shapes: ArrayShapes, reason: Option<String>) -> Self {
        let lengths = |shapes: &[Vec<usize>]| -> Vec<usize> {
            shapes.iter().map(|shape| shape.iter().product()).collect()
        };
        let (inputs, outputs) = (lengths(&shapes.inputs), lengths(&shapes.outputs));
        Self { kind, shapes, inputs, outputs, reason }
    }

    /// Returns the shapes of the arguments, for one state.
    pub fn input_shapes(&self) -> &[Vec<usize>] {
        &self.shapes.inputs
    }

    /// Returns the shapes of the results, for one state.
    pub fn output_shapes(&self) -> &[Vec<usize>] {
        &self.shapes.outputs
    }

    /// Returns the numbers of one state in each argument.
    pub fn input_lengths(&self) -> &[usize] {
        &self.inputs
    }

    /// Returns the numbers of one state in each result.
    pub fn output_lengths(&self) -> &[usize] {
        &self.outputs
    }

    /// Returns the function, ready to be called.
    ///
    /// # Errors
    ///
    /// If it is a rollout.
    pub fn kernel(&self) -> Result<Kernel<'_, S>, String> {
        match &self.kind {
            Kind::Machine(compiled, name) => {
                let call = compiled.bundle(name).map_err(|error| error.to_string())?;
                Ok(Kernel { call: Some(call), program: None })
            }
            Kind::Evaluated(planned) => {
                let program = planned.kernels.straight().map(|(program, _)| program);
                Ok(Kernel { call: None, program })
            }
            Kind::Rollout(_) => Err("modyn: a rollout is no function of a state".into()),
        }
    }

    /// Computes the results of all states of a broadcast of arrays, which `pool` shares.
    ///
    /// # Errors
    ///
    /// If there are other arrays than those of the function, or one is too short.
    pub fn compute(
        &self,
        broadcast: &Broadcast,
        inputs: &[Numbers<'_, S>],
        outputs: &[Results<'_, S>],
        pool: &dyn Pool,
    ) -> Result<(), String> {
        let states = broadcast.states();
        if inputs.len() != self.inputs.len() || outputs.len() != self.outputs.len() {
            return Err(format!(
                "modyn: a function of {} arrays with {} results got {} and {}",
                self.inputs.len(),
                self.outputs.len(),
                inputs.len(),
                outputs.len()
            ));
        }
        broadcast.check(inputs)?;
        let sizes = outputs.iter().zip(&self.outputs);
        if sizes.into_iter().any(|(output, length)| output.len() != length * states) {
            return Err("modyn: an array of results has another size".into());
        }
        let rollout = match &self.kind {
            Kind::Rollout(rollout) => Some(rollout.ready()?),
            Kind::Machine(..) | Kind::Evaluated(_) => None,
        };
        let kernel = if rollout.is_some() { Kernel::NONE } else { self.kernel()? };
        let (cost, lanes) = match &rollout {
            Some(ready) => (ready.cost(), ready.lanes()),
            None => (kernel.cost(), kernel.lanes()),
        };
        let lanes = if states == 1 { 1 } else { lanes };
        let arrays = Arrays { code: self, broadcast, inputs, outputs };
        let run = |states: Range<usize>| match &rollout {
            Some(ready) => ready.run(&arrays, states, lanes),
            None if lanes > 1 => kernel.in_lanes(&arrays, states, lanes),
            None => kernel.one_by_one(&arrays, states),
        };
        let groups = states.div_ceil(lanes);
        let useful = states.saturating_mul(cost).div_ceil(INSTRUCTIONS_PER_THREAD);
        let chunks = pool.threads().min(useful).min(groups).max(1);
        if chunks == 1 {
            run(0..states);
            return Ok(());
        }
        let share = groups.div_ceil(chunks) * lanes;
        pool.share(chunks, &|chunk| {
            let first = (chunk * share).min(states);
            run(first..(first + share).min(states));
        });
        Ok(())
    }
}

/// The arrays of a call.
pub struct Arrays<'a, S: Number> {
    code: &'a ArrayCode<S>,
    broadcast: &'a Broadcast,
    inputs: &'a [Numbers<'a, S>],
    outputs: &'a [Results<'a, S>],
}

impl<S: Number> Arrays<'_, S> {
    /// Returns `count` numbers of an argument in one state, from number `at` on.
    pub fn given(&self, array: usize, state: usize, at: usize, count: usize) -> &[S] {
        self.inputs[array].at(self.broadcast.place(array, state) + at, count)
    }

    /// Returns the places of `count` numbers of a result in one state, from number `at` on.
    pub fn found(&self, array: usize, state: usize, at: usize, count: usize) -> &[Cell<S>] {
        self.outputs[array].at(state * self.code.outputs[array] + at, count)
    }

    /// Calls `each` with the rows of numbers in lanes that an argument is copied to: in each lane the numbers of a state, from
    /// number `at` on. The last state fills the lanes that are left.
    pub fn gather(
        &self,
        array: usize,
        (states, at): (&Range<usize>, usize),
        rows: &mut [S],
        each: impl Fn(&mut S, S),
    ) {
        let lanes = states.len();
        let count = rows.len() / lanes;
        for lane in 0..lanes {
            let state = (states.start + lane).min(self.broadcast.states() - 1);
            let own = self.given(array, state, at, count).iter();
            for (&number, place) in own.zip(rows.iter_mut().skip(lane).step_by(lanes)) {
                each(place, number);
            }
        }
    }

    /// Copies rows of numbers in lanes to a result, from number `at` on.
    pub fn scatter(
        &self,
        array: usize,
        (states, at): (&Range<usize>, usize),
        rows: &[S],
        end: usize,
    ) {
        let lanes = states.len();
        let count = rows.len() / lanes;
        for lane in 0..lanes.min(end - states.start) {
            let places = self.found(array, states.start + lane, at, count).iter();
            for (place, &number) in places.zip(rows.iter().skip(lane).step_by(lanes)) {
                place.set(number);
            }
        }
    }
}

/// A function of arrays, ready to be called.
pub struct Kernel<'a, S: Number> {
    call: Option<Call<'a, S>>,
    program: Option<&'a Program>,
}

impl<S: Number> Kernel<'_, S> {
    const NONE: Self = Self { call: None, program: None };

    /// Returns the instructions of one state, as they count in threads.
    pub fn cost(&self) -> usize {
        self.call.map_or(INSTRUCTIONS_PER_THREAD, |call| call.size().instructions / 4 + 1)
    }

    /// Returns the states that are computed together.
    pub fn lanes(&self) -> usize {
        self.call.map_or(1, |call| call.lanes())
    }

    /// Computes the result for one state, or for as many as there are lanes.
    pub fn run(&self, numbers: &[S], result: &mut [S], lanes: usize) {
        match (self.call, self.program) {
            (Some(call), _) => {
                // The lengths are those of the program.
                let done = match lanes {
                    1 => call.one(&[numbers], result),
                    _ => call.in_lanes(&[numbers], result),
                };
                debug_assert!(done.is_ok(), "{done:?}");
            }
            (None, Some(program)) => result.copy_from_slice(&program.evaluate(numbers)),
            (None, None) => result.fill(S::from_f64(f64::NAN)),
        }
    }

    fn one_by_one(&self, arrays: &Arrays<'_, S>, states: Range<usize>) {
        let ArrayCode { inputs, outputs, .. } = arrays.code;
        with_numbers(inputs.iter().sum(), |numbers: &mut [S]| {
            with_numbers(outputs.iter().sum(), |result: &mut [S]| {
                for state in states {
                    let mut rest = &mut *numbers;
                    for (k, &length) in inputs.iter().enumerate() {
                        let own;
                        (own, rest) = rest.split_at_mut(length);
                        own.copy_from_slice(arrays.given(k, state, 0, length));
                    }
                    self.run(numbers, result, 1);
                    let mut rest = &*result;
                    for (k, &length) in outputs.iter().enumerate() {
                        let own;
                        (own, rest) = rest.split_at(length);
                        let places = arrays.found(k, state, 0, length).iter();
                        places.zip(own).for_each(|(place, &number)| place.set(number));
                    }
                }
            });
        });
    }

    fn in_lanes(&self, arrays: &Arrays<'_, S>, states: Range<usize>, lanes: usize) {
        let ArrayCode { inputs, outputs, .. } = arrays.code;
        let mut numbers = vec![S::zero(); inputs.iter().sum::<usize>() * lanes];
        let mut result = vec![S::zero(); outputs.iter().sum::<usize>() * lanes];
        for first in states.clone().step_by(lanes) {
            let group = first..first + lanes;
            let mut rest = &mut *numbers;
            for (k, &length) in inputs.iter().enumerate() {
                let rows;
                (rows, rest) = rest.split_at_mut(length * lanes);
                arrays.gather(k, (&group, 0), rows, |place, number| *place = number);
            }
            self.run(&numbers, &mut result, lanes);
            let mut rest = &*result;
            for (k, &length) in outputs.iter().enumerate() {
                let rows;
                (rows, rest) = rest.split_at(length * lanes);
                arrays.scatter(k, (&group, 0), rows, states.end);
            }
        }
    }
}

/// Calls `work` with this many zeros.
fn with_numbers<S: Number, T>(count: usize, work: impl FnOnce(&mut [S]) -> T) -> T {
    let mut small = [S::zero(); SMALL];
    match small.get_mut(..count) {
        Some(numbers) => work(numbers),
        None => work(&mut vec![S::zero(); count]),
    }
}
