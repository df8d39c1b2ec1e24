//! A function of arrays, on the arrays of a call: one state after the other, or a state in each
//! lane.

use std::cell::Cell;
use std::ops::Range;

use modyn_codegen::Planning;
use modyn_codegen::plan::Planned;
use modyn_codegen::program::Program;
use modyn_jit::{Call, Compiled, Options};

use super::states::{Broadcast, Numbers, Results};
use crate::checks::Check;
use crate::number::Number;
use crate::pool::{BETWEEN_QUESTIONS, INSTRUCTIONS_PER_THREAD, Pool, Questions};

/// The numbers of a state that are computed without memory from the heap.
const SMALL: usize = 64;

/// The shapes of the arrays of a function, for one state.
#[derive(Clone, Default, PartialEq, Eq, Hash)]
pub struct ArrayShapes {
    inputs: Vec<Vec<usize>>,
    outputs: Vec<Vec<usize>>,
    lengths: [Vec<usize>; 2],
    /// The numbers of each argument that are copied to rows: none of an argument that stays in place.
    gathered: Vec<usize>,
    /// The arguments whose numbers are checked, by their indices and names.
    checks: Vec<(usize, &'static str, Check)>,
}

impl ArrayShapes {
    /// Returns the shapes of arguments and results.
    pub fn new(inputs: Vec<Vec<usize>>, outputs: Vec<Vec<usize>>) -> Self {
        let lengths: [Vec<usize>; 2] = [&inputs, &outputs]
            .map(|shapes| shapes.iter().map(|shape| shape.iter().product()).collect());
        let gathered = lengths[0].clone();
        Self { inputs, outputs, lengths, gathered, checks: Vec::new() }
    }

    /// Returns the shapes of a function that reads these arguments in place, by their indices.
    pub fn with_in_place(mut self, arguments: Range<usize>) -> Self {
        self.gathered[arguments].fill(0);
        self
    }

    /// Returns the shapes with checks of the numbers of arguments.
    pub fn with_checks(self, checks: Vec<(usize, &'static str, Check)>) -> Self {
        Self { checks, ..self }
    }

    /// Returns the checks of arguments.
    pub fn checks(&self) -> &[(usize, &'static str, Check)] {
        &self.checks
    }

    /// Checks the numbers of the arguments of a call.
    ///
    /// # Errors
    ///
    /// If a number is outside of its range.
    fn check<S: Number>(&self, inputs: &[Numbers<'_, S>]) -> Result<(), String> {
        self.checks.iter().try_for_each(|&(array, name, check)| {
            check.run(name, inputs[array].all(), self.lengths[0][array])
        })
    }

    /// Returns the shapes of the arguments.
    pub fn inputs(&self) -> &[Vec<usize>] {
        &self.inputs
    }

    /// Returns the shapes of the results.
    pub fn outputs(&self) -> &[Vec<usize>] {
        &self.outputs
    }

    /// Returns the numbers of each argument, and of each result.
    pub fn lengths(&self) -> [&[usize]; 2] {
        self.lengths.each_ref().map(Vec::as_slice)
    }

    /// Returns the numbers of each argument in the rows that a kernel gets, and of each result.
    pub fn rows(&self) -> [&[usize]; 2] {
        [&self.gathered, &self.lengths[1]]
    }
}

/// Code of a function that is more than one program.
pub trait OwnCode<S: Number>: Send + Sync {
    /// Returns the code, ready to be called.
    ///
    /// # Errors
    ///
    /// If a program was not compiled, which no caller can bring about.
    fn ready(&self) -> Result<Box<dyn OwnKernel<S> + '_>, String>;
}

/// Code of a function that is more than one program, ready to be called.
pub trait OwnKernel<S: Number>: Send + Sync {
    /// Returns the instructions of one state, as they count in threads.
    fn cost(&self) -> usize;

    /// Returns the states that are computed together.
    fn lanes(&self) -> usize;

    /// Computes the result for one state, or for as many as there are lanes.
    fn run(&self, numbers: &[S], result: &mut [S], lanes: &Lanes<'_, S>);

    /// Returns what was wrong with the arguments that it read in place, if anything was.
    fn fault(&self) -> Option<String>;
}

/// A function of arrays: all arguments are one row of numbers, and so are all results.
pub struct StateFunction<S: Number + 'static> {
    code: Code<S>,
    shapes: ArrayShapes,
}

enum Code<S: Number + 'static> {
    Machine(Box<Compiled<S>>, &'static str),
    Evaluated(Box<Planned>),
    Own(Box<dyn OwnCode<S>>),
}

impl<S: Number> StateFunction<S> {
    /// Returns the only function of a planning, with the shapes of its arrays, and the reason why
    /// there is no machine code, if it was wanted; `None` if nothing was planned.
    pub fn new(
        planning: Planning,
        shapes: ArrayShapes,
        machine: bool,
    ) -> Option<(Self, Option<String>)> {
        let mut options = Options::default();
        options.batches = true;
        let name = planning.plan.functions.first()?.name;
        let compiled = machine.then(|| Compiled::from_plan(&planning, options));
        let (code, reason) = match compiled {
            Some(Ok(compiled)) => (Code::Machine(Box::new(compiled), name), None),
            other => {
                let reason = other.and_then(Result::err).map(|error| error.to_string());
                let planned = planning.plan.functions.into_iter().next()?;
                (Code::Evaluated(Box::new(planned)), reason)
            }
        };
        Some((Self { code, shapes }, reason))
    }

    /// Returns a function that is more than one program, with the shapes of its arrays.
    pub fn of_own_code(code: impl OwnCode<S> + 'static, shapes: ArrayShapes) -> Self {
        Self { code: Code::Own(Box::new(code)), shapes }
    }

    /// Returns the shapes of the arrays.
    pub fn shapes(&self) -> &ArrayShapes {
        &self.shapes
    }

    /// Returns the function, ready to be called.
    ///
    /// # Errors
    ///
    /// If the function was not compiled or has no program of one state, which no caller can bring
    /// about.
    pub fn kernel(&self) -> Result<Kernel<'_, S>, String> {
        let runner = match &self.code {
            Code::Machine(compiled, name) => {
                Runner::Machine(compiled.fused(name).map_err(|error| error.to_string())?)
            }
            Code::Evaluated(planned) => {
                let straight = planned.kernels.straight();
                let (program, _) = straight.ok_or("modyn: a function without a program")?;
                Runner::Evaluated(program)
            }
            Code::Own(code) => Runner::Own(code.ready()?),
        };
        Ok(Kernel { shapes: &self.shapes, runner })
    }
}

/// The arrays of a call.
pub struct Arrays<'a, S: Number> {
    broadcast: &'a Broadcast<'a>,
    inputs: &'a [Numbers<'a, S>],
    outputs: &'a [Results<'a, S>],
    /// The numbers of one state in each argument, and in each result.
    lengths: [&'a [usize]; 2],
}

/// The states that a kernel computes together, one in each lane. The last state of a call fills the
/// lanes that are left.
pub struct Lanes<'a, S: Number> {
    arrays: &'a Arrays<'a, S>,
    states: Range<usize>,
}

impl<'a, S: Number> Lanes<'a, S> {
    /// Returns a lane for each of these states of a call.
    pub fn new(arrays: &'a Arrays<'a, S>, states: Range<usize>) -> Self {
        Self { arrays, states }
    }

    /// Returns the number of lanes.
    pub fn count(&self) -> usize {
        self.states.len()
    }

    /// Returns the state of a lane, among all states of the call.
    pub fn state(&self, lane: usize) -> usize {
        (self.states.start + lane).min(self.arrays.states() - 1)
    }

    /// Returns the number of states of the call.
    pub fn states(&self) -> usize {
        self.arrays.states()
    }

    /// Returns the argument with this index, which stays in place, in the state of a lane.
    pub fn in_place(&self, array: usize, lane: usize) -> &'a [S] {
        self.arrays.given(array, self.state(lane), 0, self.arrays.lengths[0][array])
    }
}

impl<'a, S: Number> Arrays<'a, S> {
    /// Returns the arrays of a function with these shapes.
    ///
    /// # Errors
    ///
    /// If the arrays are not the function's arrays, if one is too short, or if a number is outside
    /// of its range.
    pub fn new(
        shapes: &'a ArrayShapes,
        broadcast: &'a Broadcast<'a>,
        inputs: &'a [Numbers<'a, S>],
        outputs: &'a [Results<'a, S>],
    ) -> Result<Self, String> {
        let lengths = shapes.lengths();
        let states = broadcast.states();
        if inputs.len() != lengths[0].len() || outputs.len() != lengths[1].len() {
            return Err(format!(
                "modyn: a function of {} arrays with {} results got {} and {}",
                lengths[0].len(),
                lengths[1].len(),
                inputs.len(),
                outputs.len()
            ));
        }
        broadcast.check(inputs)?;
        let mut sizes = outputs.iter().zip(lengths[1]);
        if sizes.any(|(output, length)| output.len() != length * states) {
            return Err("modyn: an array of results has another size".into());
        }
        shapes.check(inputs)?;
        Ok(Self { broadcast, inputs, outputs, lengths })
    }

    /// Returns the number of states.
    pub fn states(&self) -> usize {
        self.broadcast.states()
    }

    /// Returns `count` numbers of an argument in one state, from number `at` on.
    pub fn given(&self, array: usize, state: usize, at: usize, count: usize) -> &'a [S] {
        self.inputs[array].at(self.broadcast.place(array, state) + at, count)
    }

    /// Returns the places of `count` numbers of a result in one state, from number `at` on.
    pub fn found(&self, array: usize, state: usize, at: usize, count: usize) -> &[Cell<S>] {
        self.outputs[array].at(state * self.lengths[1][array] + at, count)
    }

    /// Calls `each` with the rows of numbers in lanes that an argument is copied to: in each lane
    /// the numbers of a state, from number `at` on. The last state fills the lanes that are left.
    pub fn gather(
        &self,
        array: usize,
        states: &Range<usize>,
        at: usize,
        rows: &mut [S],
        each: impl Fn(&mut S, S),
    ) {
        let lanes = states.len();
        let count = rows.len() / lanes;
        for lane in 0..lanes {
            let state = (states.start + lane).min(self.broadcast.states() - 1);
            let numbers = self.given(array, state, at, count).iter();
            for (&number, place) in numbers.zip(rows.iter_mut().skip(lane).step_by(lanes)) {
                each(place, number);
            }
        }
    }

    /// Copies rows of numbers in lanes to a result, from number `at` on.
    pub fn scatter(&self, array: usize, states: &Range<usize>, at: usize, rows: &[S], end: usize) {
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
pub struct Kernel<'a, S: Number + 'static> {
    shapes: &'a ArrayShapes,
    runner: Runner<'a, S>,
}

enum Runner<'a, S: Number + 'static> {
    Machine(Call<'a, S>),
    Evaluated(&'a Program),
    Own(Box<dyn OwnKernel<S> + 'a>),
}

impl<S: Number> Kernel<'_, S> {
    /// Returns the instructions of one state, as they count in threads.
    pub fn cost(&self) -> usize {
        match &self.runner {
            Runner::Machine(call) => call.size().instructions / 4 + 1,
            Runner::Evaluated(_) => INSTRUCTIONS_PER_THREAD,
            Runner::Own(kernel) => kernel.cost(),
        }
    }

    /// Returns the instructions of one state until the next question whether the work must end. The
    /// time of a program that is evaluated, and of a solver that iterates, is not known: the
    /// question comes after each state.
    pub fn work(&self) -> usize {
        match &self.runner {
            Runner::Machine(_) => self.cost(),
            Runner::Evaluated(_) | Runner::Own(_) => BETWEEN_QUESTIONS,
        }
    }

    /// Returns the states that are computed together.
    pub fn lanes(&self) -> usize {
        match &self.runner {
            Runner::Machine(call) => call.lanes(),
            Runner::Evaluated(_) => 1,
            Runner::Own(kernel) => kernel.lanes(),
        }
    }

    /// Returns what was wrong with the arguments that it read in place, if anything was.
    pub fn fault(&self) -> Option<String> {
        match &self.runner {
            Runner::Machine(_) | Runner::Evaluated(_) => None,
            Runner::Own(kernel) => kernel.fault(),
        }
    }

    /// Computes the result for one state, or for as many as there are lanes.
    pub fn run(&self, numbers: &[S], result: &mut [S], lanes: &Lanes<'_, S>) {
        match &self.runner {
            Runner::Machine(call) => {
                // The arrays have the program's lengths, so the calls cannot fail.
                let done = match lanes.count() {
                    1 => call.one(&[numbers], result),
                    _ => call.in_lanes(&[numbers], result),
                };
                debug_assert!(done.is_ok(), "{done:?}");
            }
            Runner::Evaluated(program) => result.copy_from_slice(&program.evaluate(numbers)),
            Runner::Own(kernel) => kernel.run(numbers, result, lanes),
        }
    }

    /// Computes states, one in each lane if there are several.
    pub fn compute(
        &self,
        arrays: &Arrays<'_, S>,
        states: Range<usize>,
        lanes: usize,
        pool: &dyn Pool,
    ) {
        match lanes {
            1 => self.one_by_one(arrays, states, pool),
            _ => self.in_lanes(arrays, states, lanes, pool),
        }
    }

    fn one_by_one(&self, arrays: &Arrays<'_, S>, states: Range<usize>, pool: &dyn Pool) {
        let mut questions = Questions::new(pool);
        let work = self.work();
        let [inputs, outputs] = self.shapes.rows();
        with_numbers(inputs.iter().sum(), |numbers: &mut [S]| {
            with_numbers(outputs.iter().sum(), |result: &mut [S]| {
                for state in states {
                    let mut rest = &mut *numbers;
                    for (k, &length) in inputs.iter().enumerate() {
                        let lane;
                        (lane, rest) = rest.split_at_mut(length);
                        lane.copy_from_slice(arrays.given(k, state, 0, length));
                    }
                    self.run(numbers, result, &Lanes::new(arrays, state..state + 1));
                    let mut rest = &*result;
                    for (k, &length) in outputs.iter().enumerate() {
                        let lane;
                        (lane, rest) = rest.split_at(length);
                        let places = arrays.found(k, state, 0, length).iter();
                        places.zip(lane).for_each(|(place, &number)| place.set(number));
                    }
                    if questions.must_end(work) {
                        return;
                    }
                }
            });
        });
    }

    fn in_lanes(
        &self,
        arrays: &Arrays<'_, S>,
        states: Range<usize>,
        lanes: usize,
        pool: &dyn Pool,
    ) {
        let mut questions = Questions::new(pool);
        let work = self.work().saturating_mul(lanes);
        let [inputs, outputs] = self.shapes.rows();
        let mut numbers = vec![S::zero(); inputs.iter().sum::<usize>() * lanes];
        let mut result = vec![S::zero(); outputs.iter().sum::<usize>() * lanes];
        for first in states.clone().step_by(lanes) {
            let group = first..first + lanes;
            let mut rest = &mut *numbers;
            for (k, &length) in inputs.iter().enumerate() {
                let rows;
                (rows, rest) = rest.split_at_mut(length * lanes);
                arrays.gather(k, &group, 0, rows, |place, number| *place = number);
            }
            self.run(&numbers, &mut result, &Lanes::new(arrays, group.clone()));
            let mut rest = &*result;
            for (k, &length) in outputs.iter().enumerate() {
                let rows;
                (rows, rest) = rest.split_at(length * lanes);
                arrays.scatter(k, &group, 0, rows, states.end);
            }
            if questions.must_end(work) {
                return;
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
