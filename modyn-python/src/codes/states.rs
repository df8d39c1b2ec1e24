//! The states of arrays that other libraries own, as a call reads and writes them: axes of states
//! that are broadcast, and memory that several threads write at different places.
//!
//! Unsafe code: results are cells that threads share. It is sound because a call gives each thread
//! other states, and the states of a result are apart (`ArrayCode::compute` checks the lengths);
//! the memory belongs to the call until it ends, since `Results` borrow it.
#![allow(unsafe_code)]

use std::cell::Cell;
use std::fmt;

/// The reason why a call cannot be computed.
#[derive(Debug)]
pub enum Fault {
    /// The arrays do not fit.
    Arrays(String),
    /// The states do not fit in memory.
    Memory,
}

impl From<String> for Fault {
    fn from(message: String) -> Self {
        Self::Arrays(message)
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Arrays(message) => f.write_str(message),
            Self::Memory => f.write_str("modyn: the states of a call do not fit in memory"),
        }
    }
}

/// Axes of states that several arrays have in common, as NumPy broadcasts them.
pub struct Broadcast<'a> {
    states: usize,
    lengths: &'a [usize],
    offsets: Vec<Offsets>,
}

/// The place of each state of an array, in states.
enum Offsets {
    /// State n is at n times this number.
    Stride(usize),
    Table(Vec<usize>),
}

impl<'a> Broadcast<'a> {
    /// Returns the broadcast of arrays with these axes of states and this many numbers of each
    /// state.
    ///
    /// # Errors
    ///
    /// If the axes do not fit, or the places of the states do not fit in memory.
    pub fn new(axes: &[&[usize]], lengths: &'a [usize]) -> Result<Self, Fault> {
        let all = common(axes)?;
        let product = all.iter().try_fold(1_usize, |states, &n| states.checked_mul(n));
        let states = product.ok_or(Fault::Memory)?;
        let offsets =
            axes.iter().map(|array| offsets(array, &all, states)).collect::<Result<_, _>>()?;
        Ok(Self { states, lengths, offsets })
    }

    /// Returns the number of states.
    pub fn states(&self) -> usize {
        self.states
    }

    /// Returns the first number of a state in the array with this index.
    pub fn place(&self, array: usize, state: usize) -> usize {
        let place = match &self.offsets[array] {
            Offsets::Stride(stride) => state * stride,
            Offsets::Table(table) => table[state],
        };
        place * self.lengths[array]
    }

    /// Checks that the arrays have the numbers of all states.
    ///
    /// # Errors
    ///
    /// If one is too short.
    pub fn check<S>(&self, arrays: &[Numbers<'_, S>]) -> Result<(), String> {
        let last = self.states.checked_sub(1);
        for (k, (array, length)) in arrays.iter().zip(self.lengths).enumerate() {
            let end = match (&self.offsets[k], last) {
                (_, None) => 0,
                (Offsets::Stride(stride), Some(last)) => (last * stride + 1) * length,
                (Offsets::Table(table), Some(_)) => {
                    table.iter().max().map_or(0, |most| (most + 1) * length)
                }
            };
            if array.0.len() < end {
                return Err(format!(
                    "modyn: array {k} has {} numbers, and {end} are needed",
                    array.0.len()
                ));
            }
        }
        Ok(())
    }
}

/// Returns the axes of states that arrays with these axes have in common.
///
/// # Errors
///
/// If the axes do not fit.
pub fn common(axes: &[&[usize]]) -> Result<Vec<usize>, String> {
    let count = axes.iter().map(|array| array.len()).max().unwrap_or_default();
    let mut all = vec![1; count];
    for array in axes {
        for (length, &given_length) in all[count - array.len()..].iter_mut().zip(*array) {
            match (*length, given_length) {
                (_, 1) => {}
                (1, _) => *length = given_length,
                (expected, _) if expected == given_length => {}
                (expected, _) => {
                    return Err(format!(
                        "modyn: axes of {expected} and of {given_length} states do not fit"
                    ));
                }
            }
        }
    }
    Ok(all)
}

/// Returns the places of all states in an array with its own axes.
///
/// # Errors
///
/// If they do not fit in memory.
fn offsets(axes: &[usize], all: &[usize], states: usize) -> Result<Offsets, Fault> {
    let total: usize = axes.iter().product();
    if total == states {
        return Ok(Offsets::Stride(1));
    }
    if total == 1 {
        return Ok(Offsets::Stride(0));
    }
    let skipped = all.len() - axes.len();
    let place = |state: usize| {
        let mut rest = state;
        let mut place = 0;
        let mut stride = 1;
        for (axis, &length) in all.iter().enumerate().rev() {
            let at = rest % length;
            rest /= length;
            if let Some(own_axis) = axis.checked_sub(skipped).map(|axis| axes[axis]) {
                place += if own_axis == 1 { 0 } else { at * stride };
                stride *= own_axis;
            }
        }
        place
    };
    let mut table = Vec::new();
    table.try_reserve_exact(states).map_err(|_| Fault::Memory)?;
    table.extend((0..states).map(place));
    Ok(Offsets::Table(table))
}

/// The numbers of an array that a call reads.
pub struct Numbers<'a, S>(&'a [S]);

impl<'a, S> From<&'a [S]> for Numbers<'a, S> {
    fn from(numbers: &'a [S]) -> Self {
        Self(numbers)
    }
}

impl<S> Numbers<'_, S> {
    /// Returns the numbers of all states.
    pub fn all(&self) -> &[S] {
        self.0
    }

    /// Returns numbers from a place on.
    pub fn at(&self, place: usize, count: usize) -> &[S] {
        &self.0[place..place + count]
    }
}

/// The numbers of an array that the threads of a call write.
pub struct Results<'a, S>(&'a [Cell<S>]);

// SAFETY: see the header.
unsafe impl<S: Send> Sync for Results<'_, S> {}
// SAFETY: see the header.
unsafe impl<S: Send> Send for Results<'_, S> {}

impl<'a, S> From<&'a mut [S]> for Results<'a, S> {
    fn from(numbers: &'a mut [S]) -> Self {
        Self(Cell::from_mut(numbers).as_slice_of_cells())
    }
}

impl<S> Results<'_, S> {
    /// Returns the number of all numbers.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Returns the places of numbers. A thread must write only the places of its own states.
    pub fn at(&self, place: usize, count: usize) -> &[Cell<S>] {
        &self.0[place..place + count]
    }
}
