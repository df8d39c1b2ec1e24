//! Batches: many states at a time in the lanes of vector instructions, on the best that the
//! processor has.
//!
//! Generated robots have batch functions (`forward_dynamics_batch`, ...), which call this module.
//! States are a structure of arrays: for each coordinate a slice with its values, one for each
//! state. The members of a set, which are active or not in each state, are slices of `bool`
//! (flags).
//!
//! Unsafe code: [`Inputs`] and [`Outputs`] read and write without bounds checks. Only `Blocks`
//! creates them, from slices that hold all states of its range. Their `at` is in that range, and
//! `at + LANES` does not exceed its end. The index of the slice is checked at compile time; an
//! index that is a variable is checked when it is used. Threads share `Columns`, but each has a
//! range of its own, so that no two threads write to one place.
#![allow(unsafe_code)]

use core::fmt;
use core::marker::PhantomData;
use core::ops::Range;

#[doc(hidden)]
pub use crate::lanes::force_level;
use crate::lanes::{BatchTask, MAX_LANES};
pub use crate::lanes::{Chunk, Float, Lanes, SimdLevel, level};
use crate::scalar::Scalar;
#[doc(hidden)]
pub use crate::scalar::{Pack, SimdBackend, SimdTask};

/// The computation for one state: `O` outputs from `I` inputs and `B` flags, on any vectors.
///
/// `run` and everything that it calls must be `#[inline(always)]`.
pub trait Kernel<F: Float, const I: usize, const O: usize, const B: usize = 0>: Sync {
    /// Computes as many states as there are lanes.
    fn run<L: Lanes<Lane = F>>(&self, inputs: Inputs<'_, L, I, B>, outputs: Outputs<'_, L, O>);
}

/// The inputs of as many states as there are lanes.
#[derive(Clone, Copy)]
pub struct Inputs<'a, L: Lanes, const I: usize, const B: usize = 0> {
    columns: &'a [*const L::Lane; I],
    flags: &'a [*const bool; B],
    at: usize,
}

impl<L: Lanes, const I: usize, const B: usize> Inputs<'_, L, I, B> {
    /// Returns input `J` of each state.
    #[inline(always)]
    #[must_use]
    pub fn get<const J: usize>(&self) -> L {
        const { assert!(J < I, "there are not so many inputs") }
        // SAFETY: see the header.
        unsafe { L::load(self.columns[J].add(self.at)) }
    }

    /// Returns flag `J` of each state as a number: 1 if it is set, else 0.
    #[inline(always)]
    #[must_use]
    pub fn flag<const J: usize>(&self) -> L {
        const {
            assert!(J < B, "there are not so many flags");
            assert!(L::LANES <= MAX_LANES, "a vector has too many lanes");
        }
        let mut numbers = [L::Lane::zero(); MAX_LANES];
        let mut lane = 0;
        while lane < L::LANES {
            // SAFETY: see the header.
            if unsafe { *self.flags[J].add(self.at + lane) } {
                numbers[lane] = L::Lane::one();
            }
            lane += 1;
        }
        // SAFETY: the array has at least as many numbers as there are lanes.
        unsafe { L::load(numbers.as_ptr()) }
    }
}

/// The outputs of as many states as there are lanes.
pub struct Outputs<'a, L: Lanes, const O: usize> {
    columns: &'a [*mut L::Lane; O],
    at: usize,
}

impl<L: Lanes, const O: usize> Outputs<'_, L, O> {
    /// Stores output `J` of each state.
    #[inline(always)]
    pub fn set<const J: usize>(&self, value: L) {
        const { assert!(J < O, "there are not so many outputs") }
        // SAFETY: see the header.
        unsafe { value.store(self.columns[J].add(self.at)) }
    }

    /// Stores output `j` of each state.
    #[inline(always)]
    pub fn set_at(&self, j: usize, value: L) {
        // SAFETY: see the header.
        unsafe { value.store(self.columns[j].add(self.at)) }
    }

    /// Adds to output `j` of each state, which this call has stored.
    #[inline(always)]
    pub fn add_at(&self, j: usize, value: L) {
        // SAFETY: see the header. This call has stored the output.
        let stored = unsafe { L::load(self.columns[j].add(self.at).cast_const()) };
        self.set_at(j, stored + value);
    }
}

/// The starts of the slices of all inputs and outputs.
struct Columns<'a, F, const I: usize, const O: usize, const B: usize> {
    inputs: [*const F; I],
    flags: [*const bool; B],
    outputs: [*mut F; O],
    borrowed: PhantomData<(&'a [F], &'a [bool], &'a mut [F])>,
}

impl<'a, F, const I: usize, const O: usize, const B: usize> Columns<'a, F, I, O, B> {
    fn new(inputs: &[&'a [F]; I], flags: &[&'a [bool]; B], outputs: &'a mut [&mut [F]; O]) -> Self {
        Self {
            inputs: inputs.each_ref().map(|column| column.as_ptr()),
            flags: flags.each_ref().map(|column| column.as_ptr()),
            outputs: outputs.each_mut().map(|column| column.as_mut_ptr()),
            borrowed: PhantomData,
        }
    }
}

// SAFETY: see the header.
unsafe impl<F: Float, const I: usize, const O: usize, const B: usize> Sync
    for Columns<'_, F, I, O, B>
{
}

/// A range of states, computed block by block.
struct Blocks<'a, F: Float, K, const I: usize, const O: usize, const B: usize> {
    kernel: &'a K,
    columns: &'a Columns<'a, F, I, O, B>,
    /// At least as many states as any vector has lanes.
    states: Range<usize>,
}

impl<F: Float, K: Kernel<F, I, O, B>, const I: usize, const O: usize, const B: usize> BatchTask<F>
    for Blocks<'_, F, K, I, O, B>
{
    #[inline(always)]
    fn run<L: Lanes<Lane = F>>(self) {
        let Self { kernel, columns, states: Range { start: mut at, end } } = self;
        loop {
            let inputs = Inputs { columns: &columns.inputs, flags: &columns.flags, at };
            kernel.run::<L>(inputs, Outputs { columns: &columns.outputs, at });
            // The last block may overlap the previous one; the states in both get the same results.
            let last = end - L::LANES;
            if at == last {
                break;
            }
            at = if last - at < L::LANES { last } else { at + L::LANES };
        }
    }
}

/// Computes `outputs` from `inputs` and `flags`. All slices must hold `states` entries, which
/// [`states`] checks.
fn compute<F: Float, K: Kernel<F, I, O, B>, const I: usize, const O: usize, const B: usize>(
    kernel: &K,
    inputs: [&[F]; I],
    flags: [&[bool]; B],
    mut outputs: [&mut [F]; O],
    states: usize,
) {
    if states < MAX_LANES {
        return padded(kernel, inputs, flags, outputs, states);
    }
    let columns = &Columns::new(&inputs, &flags, &mut outputs);
    F::dispatch(Blocks { kernel, columns, states: 0..states });
}

/// Computes fewer states than lanes; copies of the last state fill the lanes.
#[cold]
fn padded<F: Float, K: Kernel<F, I, O, B>, const I: usize, const O: usize, const B: usize>(
    kernel: &K,
    inputs: [&[F]; I],
    flags: [&[bool]; B],
    outputs: [&mut [F]; O],
    states: usize,
) {
    let Some(last) = states.checked_sub(1) else { return };
    let mut tile = Tile::<F, I, O, B>::new();
    for (padded, column) in tile.inputs.iter_mut().zip(inputs) {
        for (state, x) in padded.iter_mut().enumerate() {
            *x = column[state.min(last)];
        }
    }
    for (padded, column) in tile.flags.iter_mut().zip(flags) {
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
struct Tile<F, const I: usize, const O: usize, const B: usize> {
    inputs: [[F; MAX_LANES]; I],
    flags: [[bool; MAX_LANES]; B],
    outputs: [[F; MAX_LANES]; O],
}

impl<F: Float, const I: usize, const O: usize, const B: usize> Tile<F, I, O, B> {
    fn new() -> Self {
        Self {
            inputs: [[F::zero(); MAX_LANES]; I],
            flags: [[false; MAX_LANES]; B],
            outputs: [[F::zero(); MAX_LANES]; O],
        }
    }

    fn compute<K: Kernel<F, I, O, B>>(&mut self, kernel: &K) {
        let inputs = self.inputs.each_ref().map(|column| &column[..]);
        let flags = self.flags.each_ref().map(|column| &column[..]);
        let mut outputs = self.outputs.each_mut().map(|column| &mut column[..]);
        let columns = &Columns::new(&inputs, &flags, &mut outputs);
        F::dispatch(Blocks { kernel, columns, states: 0..MAX_LANES });
    }
}

/// An argument of a batch function: its name, its number of entries for each state, and their
/// names.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
pub struct Argument {
    pub name: &'static str,
    pub numbers: usize,
    pub coordinates: &'static [&'static str],
}

/// Returns the number of states. Errors if a slice holds another number of states than the first
/// slice.
fn states<F>(
    arguments: &'static [Argument],
    inputs: &[&[F]],
    flags: &[&[bool]],
    outputs: &[&mut [F]],
) -> Result<usize, BatchError> {
    let inputs = || inputs.iter().map(|c| c.len()).chain(flags.iter().map(|c| c.len()));
    let lengths = || inputs().chain(outputs.iter().map(|c| c.len()));
    let expected = lengths().next().unwrap_or(0);
    match lengths().enumerate().find(|&(_, length)| length != expected) {
        None => Ok(expected),
        Some((place, length)) => Err(BatchError::new(arguments, place, length, expected)),
    }
}

/// Computes all states. `inputs` and `outputs` are the slices of all arguments, concatenated.
#[doc(hidden)]
pub fn run<F: Float, const I: usize, const O: usize>(
    kernel: &impl Kernel<F, I, O>,
    arguments: &'static [Argument],
    inputs: [&[F]; I],
    outputs: [&mut [F]; O],
) -> Result<(), BatchError> {
    run_flagged(kernel, arguments, (inputs, []), outputs)
}

/// Computes all states of a function with flags, which are the last of the inputs.
#[doc(hidden)]
pub fn run_flagged<F: Float, const I: usize, const O: usize, const B: usize>(
    kernel: &impl Kernel<F, I, O, B>,
    arguments: &'static [Argument],
    inputs: ([&[F]; I], [&[bool]; B]),
    outputs: [&mut [F]; O],
) -> Result<(), BatchError> {
    let (inputs, flags) = inputs;
    let states = states(arguments, &inputs, &flags, &outputs)?;
    compute(kernel, inputs, flags, outputs, states);
    Ok(())
}

/// Computes all states on all cores. A task has some microseconds of work, so that the cost of
/// scheduling is negligible.
#[cfg(feature = "rayon")]
#[doc(hidden)]
pub fn run_parallel<F: Float, const I: usize, const O: usize>(
    kernel: &impl Kernel<F, I, O>,
    arguments: &'static [Argument],
    inputs: [&[F]; I],
    outputs: [&mut [F]; O],
) -> Result<(), BatchError> {
    run_parallel_flagged(kernel, arguments, (inputs, []), outputs)
}

/// Computes all states of a function with flags on all cores.
#[cfg(feature = "rayon")]
#[doc(hidden)]
pub fn run_parallel_flagged<F: Float, const I: usize, const O: usize, const B: usize>(
    kernel: &impl Kernel<F, I, O, B>,
    arguments: &'static [Argument],
    inputs: ([&[F]; I], [&[bool]; B]),
    mut outputs: [&mut [F]; O],
) -> Result<(), BatchError> {
    use rayon::iter::{IntoParallelIterator, ParallelIterator};

    /// A multiple of the number of lanes, so that only the last range overlaps.
    const STATES_PER_TASK: usize = 16 * MAX_LANES;
    let (inputs, flags) = inputs;
    let states = states(arguments, &inputs, &flags, &outputs)?;
    if states < 2 * STATES_PER_TASK {
        compute(kernel, inputs, flags, outputs, states);
        return Ok(());
    }
    let columns = &Columns::new(&inputs, &flags, &mut outputs);
    let ranges = states / STATES_PER_TASK;
    (0..ranges).into_par_iter().for_each(|i| {
        let end = if i + 1 == ranges { states } else { (i + 1) * STATES_PER_TASK };
        F::dispatch(Blocks { kernel, columns, states: i * STATES_PER_TASK..end });
    });
    Ok(())
}

/// Computes all states, each stored contiguously. `inputs` are the arguments with all their
/// entries, state by state. A result has its entries in `parts`. The last of `arguments` describes
/// the results.
#[doc(hidden)]
pub fn run_each<F: Float, R, const A: usize, const I: usize, const O: usize, const P: usize>(
    kernel: &impl Kernel<F, I, O>,
    arguments: &'static [Argument],
    inputs: [&[F]; A],
    results: &mut [R],
    parts: impl Fn(&mut R) -> [&mut [F]; P],
) -> Result<(), BatchError> {
    let given = FlaggedStates { inputs, sets: None::<&[()]>, flags: |(): &()| [] };
    run_each_flagged(kernel, arguments, given, results, parts)
}

/// The states of a function with flags, each stored contiguously.
#[doc(hidden)]
pub struct FlaggedStates<'a, F, C, G, const A: usize> {
    /// The arguments with all their entries, state by state.
    pub inputs: [&'a [F]; A],
    /// The set of each state, the last argument; `None` for a function without flags.
    pub sets: Option<&'a [C]>,
    /// Returns the flags of a set.
    pub flags: G,
}

/// Computes all states of a function with flags, as [`run_each`] does.
#[doc(hidden)]
pub fn run_each_flagged<
    F: Float,
    C,
    R,
    const A: usize,
    const I: usize,
    const O: usize,
    const B: usize,
    const P: usize,
>(
    kernel: &impl Kernel<F, I, O, B>,
    arguments: &'static [Argument],
    given: FlaggedStates<'_, F, C, impl Fn(&C) -> [bool; B], A>,
    results: &mut [R],
    parts: impl Fn(&mut R) -> [&mut [F]; P],
) -> Result<(), BatchError> {
    let FlaggedStates { inputs, sets, flags } = given;
    let states = states_each(arguments, inputs, sets.map(<[C]>::len), results.len())?;
    let mut at = 0;
    let mut tile = Tile::<F, I, O, B>::new();
    while at < states {
        let count = (states - at).min(MAX_LANES);
        let mut first = 0;
        for (flat, argument) in inputs.iter().zip(arguments) {
            let numbers = argument.numbers;
            let columns = &mut tile.inputs[first..first + numbers];
            transpose(&flat[at * numbers..(at + count) * numbers], columns);
            first += numbers;
        }
        for lane in 0..MAX_LANES {
            let set = sets.and_then(|sets| sets.get(at + lane.min(count - 1)));
            let of_state = set.map_or([false; B], &flags);
            for (column, flag) in tile.flags.iter_mut().zip(of_state) {
                column[lane] = flag;
            }
        }
        tile.compute(kernel);
        for (state, result) in results[at..at + count].iter_mut().enumerate() {
            let mut columns = tile.outputs.iter();
            for part in parts(result) {
                // The columns are the second operand of `zip`, which takes a column for each entry
                // only.
                for (x, column) in part.iter_mut().zip(&mut columns) {
                    *x = column[state];
                }
            }
        }
        at += count;
    }
    Ok(())
}

/// Returns the number of states. Errors if an argument holds another number of states than the
/// first argument. An argument without entries fits any number. `sets` is the number of sets of
/// flags, the argument after `inputs`.
fn states_each<F, const A: usize>(
    arguments: &'static [Argument],
    inputs: [&[F]; A],
    sets: Option<usize>,
    results: usize,
) -> Result<usize, BatchError> {
    let inputs = inputs.iter().zip(arguments).map(|(flat, a)| flat.len().checked_div(a.numbers));
    let whole = |place: usize, states| (place, (arguments[place].numbers > 0).then_some(states));
    let sets = sets.map(|sets| whole(A, sets));
    let mut expected = None;
    let last = whole(arguments.len() - 1, results);
    for (place, states) in inputs.enumerate().chain(sets).chain([last]) {
        let Some(states) = states else { continue };
        let expected = *expected.get_or_insert(states);
        if states != expected {
            return Err(BatchError::whole(arguments, place, states, expected));
        }
    }
    Ok(expected.unwrap_or(0))
}

/// Transposes states into columns; copies of the last state fill the remaining lanes.
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

/// An argument holds another number of states than the first argument.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct BatchError {
    /// The name of the argument.
    pub argument: &'static str,
    /// The index of the slice in the argument, and the name of its coordinate (empty if it has
    /// none); `None` if states are stored contiguously.
    pub coordinate: Option<(usize, &'static str)>,
    /// The number of states in the argument.
    pub states: usize,
    /// The number of states in the first argument.
    pub expected: usize,
    /// The name of the first argument, and the index of its first slice, if it has slices.
    first: (&'static str, &'static str),
    /// The number of rows, if the argument is a matrix.
    rows: usize,
}

impl BatchError {
    /// Returns the error of slice `place` of all slices.
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

    /// Returns the error of argument `place`, whose states are stored contiguously.
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

/// Keeps items that need feature `rayon`.
#[cfg(feature = "rayon")]
#[doc(hidden)]
#[macro_export]
macro_rules! __with_rayon {
    ($($item:tt)*) => { $($item)* };
}

/// Omits items that need feature `rayon`.
#[cfg(not(feature = "rayon"))]
#[doc(hidden)]
#[macro_export]
macro_rules! __with_rayon {
    ($($item:tt)*) => {};
}
