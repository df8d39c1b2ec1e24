//! Many states at a time, side by side in vector instructions, on the best that the processor has.
//!
//! Generated robots have functions for it (`forward_dynamics_batch`, ...), which call this. The
//! states are a structure of arrays: for each coordinate a slice with its values, one for each state.
//!
//! Unsafe code: [`Inputs`] and [`Outputs`] read and write without a check of bounds each time. They are
//! made here only, in `Blocks`, from slices that all hold `states` numbers, for an `at` with
//! `at + LANES <= states`; which of the slices is checked at compile time.
#![allow(unsafe_code)]

use core::fmt;
use core::marker::PhantomData;

#[doc(hidden)]
pub use crate::lanes::force_level;
pub use crate::lanes::{Float, Lanes, Level, Part, level};
use crate::lanes::{MOST_LANES, Work};
#[doc(hidden)]
pub use crate::scalar::abreast::{Abreast, Beside, Vectors};

/// What is computed of each state: `O` numbers of `I`, on any lanes.
///
/// `run` must be `#[inline(always)]`, and all that it calls.
pub trait Kernel<F: Float, const I: usize, const O: usize>: Sync {
    /// Computes some states, one in each lane.
    fn run<L: Lanes<Lane = F>>(&self, inputs: Inputs<'_, L, I>, outputs: Outputs<'_, L, O>);
}

/// The numbers that some states are given by.
#[derive(Clone, Copy)]
pub struct Inputs<'a, L: Lanes, const I: usize> {
    columns: &'a [*const L::Lane; I],
    at: usize,
}

impl<L: Lanes, const I: usize> Inputs<'_, L, I> {
    /// Number `J` of each state.
    #[inline(always)]
    #[must_use]
    pub fn get<const J: usize>(&self) -> L {
        const { assert!(J < I, "there are not so many inputs") }
        // SAFETY: see the header.
        unsafe { L::load(self.columns[J].add(self.at)) }
    }
}

/// Where the results of some states go.
pub struct Outputs<'a, L: Lanes, const O: usize> {
    columns: &'a [*mut L::Lane; O],
    at: usize,
}

impl<L: Lanes, const O: usize> Outputs<'_, L, O> {
    /// Puts number `J` of each state.
    #[inline(always)]
    pub fn set<const J: usize>(&self, value: L) {
        const { assert!(J < O, "there are not so many outputs") }
        // SAFETY: see the header.
        unsafe { value.store(self.columns[J].add(self.at)) }
    }
}

/// The states, to be done block by block.
struct Blocks<'a, F: Float, K, const I: usize, const O: usize> {
    kernel: &'a K,
    inputs: [*const F; I],
    outputs: [*mut F; O],
    /// At least as many as any vector has lanes.
    states: usize,
    borrowed: PhantomData<(&'a [F], &'a mut [F])>,
}

impl<F: Float, K: Kernel<F, I, O>, const I: usize, const O: usize> Work<F>
    for Blocks<'_, F, K, I, O>
{
    #[inline(always)]
    fn run<L: Lanes<Lane = F>>(self) {
        let mut at = 0;
        loop {
            let inputs = Inputs { columns: &self.inputs, at };
            self.kernel.run::<L>(inputs, Outputs { columns: &self.outputs, at });
            // The last block may do some states again: the same numbers come out.
            let last = self.states - L::LANES;
            if at == last {
                break;
            }
            at = if last - at < L::LANES { last } else { at + L::LANES };
        }
    }
}

/// Computes `outputs` of `inputs`, which all hold `states` numbers: [`states`] has checked it.
fn compute<F: Float, K: Kernel<F, I, O>, const I: usize, const O: usize>(
    kernel: &K,
    inputs: [&[F]; I],
    mut outputs: [&mut [F]; O],
    states: usize,
) {
    if states < MOST_LANES {
        return padded(kernel, inputs, outputs, states);
    }
    F::dispatch(Blocks {
        kernel,
        inputs: inputs.each_ref().map(|column| column.as_ptr()),
        outputs: outputs.each_mut().map(|column| column.as_mut_ptr()),
        states,
        borrowed: PhantomData,
    });
}

/// The same for fewer states than lanes: the last one fills them up.
#[cold]
fn padded<F: Float, K: Kernel<F, I, O>, const I: usize, const O: usize>(
    kernel: &K,
    inputs: [&[F]; I],
    outputs: [&mut [F]; O],
    states: usize,
) {
    let Some(last) = states.checked_sub(1) else { return };
    let mut tile = Tile::<F, I, O>::new();
    for (padded, column) in tile.inputs.iter_mut().zip(inputs) {
        for (state, x) in padded.iter_mut().enumerate() {
            *x = column[state.min(last)];
        }
    }
    tile.compute(kernel);
    for (column, padded) in outputs.into_iter().zip(&tile.outputs) {
        column.copy_from_slice(&padded[..states]);
    }
}

/// As many states as the widest vectors have lanes.
struct Tile<F, const I: usize, const O: usize> {
    inputs: [[F; MOST_LANES]; I],
    outputs: [[F; MOST_LANES]; O],
}

impl<F: Float, const I: usize, const O: usize> Tile<F, I, O> {
    fn new() -> Self {
        Self { inputs: [[F::zero(); MOST_LANES]; I], outputs: [[F::zero(); MOST_LANES]; O] }
    }

    fn compute<K: Kernel<F, I, O>>(&mut self, kernel: &K) {
        F::dispatch(Blocks {
            kernel,
            inputs: self.inputs.each_ref().map(|column| column.as_ptr()),
            outputs: self.outputs.each_mut().map(|column| column.as_mut_ptr()),
            states: MOST_LANES,
            borrowed: PhantomData,
        });
    }
}

/// An argument of a function for batches: what it is called, how many numbers of a state it holds, and
/// what they belong to.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
pub struct Argument {
    pub name: &'static str,
    pub numbers: usize,
    pub coordinates: &'static [&'static str],
}

/// The number of states; an error if some slice holds another number than the first one.
fn states<F>(
    arguments: &'static [Argument],
    inputs: &[&[F]],
    outputs: &[&mut [F]],
) -> Result<usize, BatchError> {
    let lengths = || inputs.iter().map(|c| c.len()).chain(outputs.iter().map(|c| c.len()));
    let expected = lengths().next().unwrap_or(0);
    match lengths().enumerate().find(|&(_, length)| length != expected) {
        None => Ok(expected),
        Some((place, length)) => Err(BatchError::new(arguments, place, length, expected)),
    }
}

/// Computes all states: `inputs` and `outputs` are the slices of all arguments one after the other.
#[doc(hidden)]
pub fn run<F: Float, const I: usize, const O: usize>(
    kernel: &impl Kernel<F, I, O>,
    arguments: &'static [Argument],
    inputs: [&[F]; I],
    outputs: [&mut [F]; O],
) -> Result<(), BatchError> {
    let states = states(arguments, &inputs, &outputs)?;
    compute(kernel, inputs, outputs, states);
    Ok(())
}

/// The same on all cores.
#[cfg(feature = "rayon")]
#[doc(hidden)]
pub fn run_parallel<F: Float, const I: usize, const O: usize>(
    kernel: &impl Kernel<F, I, O>,
    arguments: &'static [Argument],
    inputs: [&[F]; I],
    outputs: [&mut [F]; O],
) -> Result<(), BatchError> {
    let states = states(arguments, &inputs, &outputs)?;
    halve(kernel, inputs, outputs, states);
    Ok(())
}

/// Halves the states, each a multiple of the lanes, until there are few: some microseconds of work, in
/// which handing it over is lost.
#[cfg(feature = "rayon")]
fn halve<F: Float, K: Kernel<F, I, O>, const I: usize, const O: usize>(
    kernel: &K,
    inputs: [&[F]; I],
    outputs: [&mut [F]; O],
    states: usize,
) {
    const FEW: usize = 256;
    if states < 2 * FEW {
        return compute(kernel, inputs, outputs, states);
    }
    let middle = states / 2 / MOST_LANES * MOST_LANES;
    let (mut before, mut behind) = (inputs, inputs);
    for (column, (before, behind)) in inputs.iter().zip(before.iter_mut().zip(&mut behind)) {
        (*before, *behind) = column.split_at(middle);
    }
    let mut ends = [const { None }; O];
    let mut ends_left = ends.iter_mut();
    let starts = outputs.map(|column| {
        let (start, end) = column.split_at_mut(middle);
        if let Some(place) = ends_left.next() {
            *place = Some(end);
        }
        start
    });
    let ends = ends.map(Option::unwrap_or_default);
    rayon::join(
        || halve(kernel, before, starts, middle),
        || halve(kernel, behind, ends, states - middle),
    );
}

/// Computes all states, each of which stands together: `inputs` are the arguments, each with all its
/// numbers, state by state, and `output` the result alike.
#[doc(hidden)]
pub fn run_each<F: Float, const A: usize, const I: usize, const O: usize>(
    kernel: &impl Kernel<F, I, O>,
    arguments: &'static [Argument],
    inputs: [&[F]; A],
    output: &mut [F],
) -> Result<(), BatchError> {
    let lengths = inputs.iter().map(|flat| flat.len()).chain([output.len()]);
    let mut states = None;
    for (place, (flat, argument)) in lengths.zip(arguments).enumerate() {
        let Some(length) = flat.checked_div(argument.numbers) else { continue };
        let expected = *states.get_or_insert(length);
        if length != expected {
            return Err(BatchError::whole(arguments, place, length, expected));
        }
    }
    let (states, mut at) = (states.unwrap_or(0), 0);
    let mut tile = Tile::<F, I, O>::new();
    while at < states {
        let some = (states - at).min(MOST_LANES);
        let mut first = 0;
        for (flat, argument) in inputs.iter().zip(arguments) {
            let numbers = argument.numbers;
            let columns = &mut tile.inputs[first..first + numbers];
            gather(&flat[at * numbers..(at + some) * numbers], columns);
            first += numbers;
        }
        tile.compute(kernel);
        scatter(&tile.outputs, &mut output[at * O..(at + some) * O]);
        at += some;
    }
    Ok(())
}

/// Transposes states into columns, the last one into what is left of them.
fn gather<F: Float>(states: &[F], columns: &mut [[F; MOST_LANES]]) {
    let numbers = columns.len();
    if states.len() == MOST_LANES * numbers {
        for (j, column) in columns.iter_mut().enumerate() {
            for (x, state) in column.iter_mut().zip(states.chunks_exact(numbers)) {
                *x = state[j];
            }
        }
        return;
    }
    let last = (states.len() / numbers.max(1)).saturating_sub(1);
    for (j, column) in columns.iter_mut().enumerate() {
        for (state, x) in column.iter_mut().enumerate() {
            *x = states[state.min(last) * numbers + j];
        }
    }
}

/// Transposes columns into states.
fn scatter<F: Float>(columns: &[[F; MOST_LANES]], states: &mut [F]) {
    for (i, state) in states.chunks_exact_mut(columns.len().max(1)).enumerate() {
        for (x, column) in state.iter_mut().zip(columns) {
            *x = column[i];
        }
    }
}

/// An argument holds another number of states than the first one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BatchError {
    /// The argument.
    pub argument: &'static str,
    /// The place of the slice in it, and the name of its coordinate; `None` if a state stands together.
    pub coordinate: Option<(usize, &'static str)>,
    /// How many states it holds.
    pub states: usize,
    /// How many the first argument holds.
    pub expected: usize,
    /// The first argument, and where in it, if it has places.
    first: (&'static str, &'static str),
    /// Rows of the matrix that the argument is.
    rows: usize,
}

impl BatchError {
    /// For slice `place` of all.
    #[cold]
    fn new(arguments: &'static [Argument], place: usize, states: usize, expected: usize) -> Self {
        let mut place = place;
        let mut whole = 0;
        while place >= arguments[whole].numbers {
            place -= arguments[whole].numbers;
            whole += 1;
        }
        let Argument { coordinates, .. } = arguments[whole];
        let name = place.checked_rem(coordinates.len()).map(|place| coordinates[place]);
        let error = Self::whole(arguments, whole, states, expected);
        Self { coordinate: name.map(|name| (place, name)), first: (error.first.0, "[0]"), ..error }
    }

    /// For an argument.
    #[cold]
    fn whole(arguments: &'static [Argument], place: usize, states: usize, expected: usize) -> Self {
        let Argument { name, coordinates, .. } = arguments[place];
        let first = arguments.iter().find(|argument| argument.numbers > 0).unwrap_or(&arguments[0]);
        Self {
            argument: name,
            coordinate: None,
            states,
            expected,
            first: (first.name, ""),
            rows: coordinates.len(),
        }
    }
}

impl fmt::Display for BatchError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { argument, coordinate, states, expected, first, rows } = self;
        match coordinate {
            Some((place, name)) if place < rows => write!(f, "`{argument}[{place}]` ({name})"),
            Some((place, name)) => {
                write!(f, "`{argument}[{}][{}]` ({name})", place / rows, place % rows)
            }
            None => write!(f, "`{argument}`"),
        }?;
        let (name, place) = first;
        write!(f, " holds {states} states, `{name}{place}` holds {expected}")
    }
}

impl core::error::Error for BatchError {}

/// Keeps what needs feature `rayon`.
#[cfg(feature = "rayon")]
#[doc(hidden)]
#[macro_export]
macro_rules! __with_rayon {
    ($($item:tt)*) => { $($item)* };
}

/// Leaves out what needs feature `rayon`.
#[cfg(not(feature = "rayon"))]
#[doc(hidden)]
#[macro_export]
macro_rules! __with_rayon {
    ($($item:tt)*) => {};
}
