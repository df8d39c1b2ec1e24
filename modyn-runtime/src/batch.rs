//! Many states at a time, side by side in vector instructions, on the best that the processor has.
//!
//! Generated robots have functions for it (`forward_dynamics_batch`, ...), which call this. The
//! states are a structure of arrays: for each coordinate a slice with its values, one for each state.
//!
//! Unsafe code: [`Inputs`] and [`Outputs`] read and write without a check of bounds each time. They are
//! made here only, in `Blocks`, from slices that all hold the states of its range, for an `at` in it with
//! `at + LANES` not beyond; which of the slices is checked at compile time. Threads share `Columns`, but
//! each has a range of its own, so that no two write in one place.
#![allow(unsafe_code)]

use core::fmt;
use core::marker::PhantomData;
use core::ops::Range;

#[doc(hidden)]
pub use crate::lanes::force_level;
use crate::lanes::{BatchTask, MAX_LANES};
pub use crate::lanes::{Chunk, Float, Lanes, SimdLevel, level};
#[doc(hidden)]
pub use crate::scalar::simd::{Pack, SimdBackend, SimdTask};

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

/// Where the slices for each number of a state begin.
struct Columns<'a, F, const I: usize, const O: usize> {
    inputs: [*const F; I],
    outputs: [*mut F; O],
    borrowed: PhantomData<(&'a [F], &'a mut [F])>,
}

impl<'a, F, const I: usize, const O: usize> Columns<'a, F, I, O> {
    fn new(inputs: &[&'a [F]; I], outputs: &'a mut [&mut [F]; O]) -> Self {
        Self {
            inputs: inputs.each_ref().map(|column| column.as_ptr()),
            outputs: outputs.each_mut().map(|column| column.as_mut_ptr()),
            borrowed: PhantomData,
        }
    }
}

// SAFETY: see the header.
unsafe impl<F: Float, const I: usize, const O: usize> Sync for Columns<'_, F, I, O> {}

/// Some states, to be done block by block.
struct Blocks<'a, F: Float, K, const I: usize, const O: usize> {
    kernel: &'a K,
    columns: &'a Columns<'a, F, I, O>,
    /// At least as many as any vector has lanes.
    states: Range<usize>,
}

impl<F: Float, K: Kernel<F, I, O>, const I: usize, const O: usize> BatchTask<F>
    for Blocks<'_, F, K, I, O>
{
    #[inline(always)]
    fn run<L: Lanes<Lane = F>>(self) {
        let Self { kernel, columns, states: Range { start: mut at, end } } = self;
        loop {
            let inputs = Inputs { columns: &columns.inputs, at };
            kernel.run::<L>(inputs, Outputs { columns: &columns.outputs, at });
            // The last block may do some states again: the same numbers come out.
            let last = end - L::LANES;
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
    if states < MAX_LANES {
        return padded(kernel, inputs, outputs, states);
    }
    let columns = &Columns::new(&inputs, &mut outputs);
    F::dispatch(Blocks { kernel, columns, states: 0..states });
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
    inputs: [[F; MAX_LANES]; I],
    outputs: [[F; MAX_LANES]; O],
}

impl<F: Float, const I: usize, const O: usize> Tile<F, I, O> {
    fn new() -> Self {
        Self { inputs: [[F::zero(); MAX_LANES]; I], outputs: [[F::zero(); MAX_LANES]; O] }
    }

    fn compute<K: Kernel<F, I, O>>(&mut self, kernel: &K) {
        let inputs = self.inputs.each_ref().map(|column| &column[..]);
        let mut outputs = self.outputs.each_mut().map(|column| &mut column[..]);
        let columns = &Columns::new(&inputs, &mut outputs);
        F::dispatch(Blocks { kernel, columns, states: 0..MAX_LANES });
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

/// The same on all cores, some states at a time: some microseconds of work, in which handing it over is
/// lost.
#[cfg(feature = "rayon")]
#[doc(hidden)]
pub fn run_parallel<F: Float, const I: usize, const O: usize>(
    kernel: &impl Kernel<F, I, O>,
    arguments: &'static [Argument],
    inputs: [&[F]; I],
    mut outputs: [&mut [F]; O],
) -> Result<(), BatchError> {
    use rayon::iter::{IntoParallelIterator, ParallelIterator};

    /// A multiple of the lanes, so that the last range alone does states again.
    const STATES_PER_TASK: usize = 16 * MAX_LANES;
    let states = states(arguments, &inputs, &outputs)?;
    if states < 2 * STATES_PER_TASK {
        compute(kernel, inputs, outputs, states);
        return Ok(());
    }
    let columns = &Columns::new(&inputs, &mut outputs);
    let ranges = states / STATES_PER_TASK;
    (0..ranges).into_par_iter().for_each(|i| {
        let end = if i + 1 == ranges { states } else { (i + 1) * STATES_PER_TASK };
        F::dispatch(Blocks { kernel, columns, states: i * STATES_PER_TASK..end });
    });
    Ok(())
}

/// Computes all states, each of which stands together: `inputs` are the arguments, each with all its
/// numbers, state by state; a result has its numbers in `parts`. The last one of `arguments` stands for
/// the results.
#[doc(hidden)]
pub fn run_each<F: Float, R, const A: usize, const I: usize, const O: usize, const P: usize>(
    kernel: &impl Kernel<F, I, O>,
    arguments: &'static [Argument],
    inputs: [&[F]; A],
    results: &mut [R],
    parts: impl Fn(&mut R) -> [&mut [F]; P],
) -> Result<(), BatchError> {
    let states = states_each(arguments, inputs, results.len())?;
    let mut at = 0;
    let mut tile = Tile::<F, I, O>::new();
    while at < states {
        let count = (states - at).min(MAX_LANES);
        let mut first = 0;
        for (flat, argument) in inputs.iter().zip(arguments) {
            let numbers = argument.numbers;
            let columns = &mut tile.inputs[first..first + numbers];
            transpose(&flat[at * numbers..(at + count) * numbers], columns);
            first += numbers;
        }
        tile.compute(kernel);
        for (state, result) in results[at..at + count].iter_mut().enumerate() {
            let mut columns = tile.outputs.iter();
            for part in parts(result) {
                // The columns second: one is taken for each number only.
                for (x, column) in part.iter_mut().zip(&mut columns) {
                    *x = column[state];
                }
            }
        }
        at += count;
    }
    Ok(())
}

/// The number of states; an error if some argument holds another number than the first one. What has no
/// numbers holds any.
fn states_each<F, const A: usize>(
    arguments: &'static [Argument],
    inputs: [&[F]; A],
    results: usize,
) -> Result<usize, BatchError> {
    let inputs = inputs.iter().zip(arguments).map(|(flat, a)| flat.len().checked_div(a.numbers));
    let result = arguments.len() - 1;
    let results = (arguments[result].numbers > 0).then_some(results);
    let mut expected = None;
    for (place, states) in inputs.enumerate().chain([(result, results)]) {
        let Some(states) = states else { continue };
        let expected = *expected.get_or_insert(states);
        if states != expected {
            return Err(BatchError::whole(arguments, place, states, expected));
        }
    }
    Ok(expected.unwrap_or(0))
}

/// Transposes states into columns, the last one into what is left of them.
fn transpose<F: Float>(states: &[F], columns: &mut [[F; MAX_LANES]]) {
    let numbers = columns.len();
    if states.len() == MAX_LANES * numbers {
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

/// An argument holds another number of states than the first one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct BatchError {
    /// The argument.
    pub argument: &'static str,
    /// The place of the slice in it, and the name of its coordinate (empty if it belongs to none); `None`
    /// if a state stands together.
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
            Some((place, "")) => write!(f, "`{argument}[{place}]`"),
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
