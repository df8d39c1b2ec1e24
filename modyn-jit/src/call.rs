//! Calls of compiled functions: they check the arguments, find links, and put the states of a batch
//! into lanes.

use std::borrow::Cow;

use modyn_codegen::plan::{LinkProgram, Shape};

use crate::code_size::CodeSize;
use crate::error::CallError;
use crate::function::{CompiledFunction, CompiledKernels};
use crate::machine::Pages;
use crate::real::Real;

/// The largest number of arrays of a call: of the arguments and the run-time parameters.
pub(crate) const MAX_GIVEN: usize = 16;

/// A function of a robot, ready to be called.
#[derive(Clone, Copy)]
pub struct Call<'a, S> {
    pub(crate) compiled: &'a CompiledFunction,
    pub(crate) pages: &'a Pages,
    pub(crate) parameters: &'a [S],
    pub(crate) placements: &'a [Vec<S>],
    /// The states that a batch computes together.
    pub(crate) lanes: usize,
}

impl<S: Real> Call<'_, S> {
    /// Returns the arguments by name, each with the layout of its numbers.
    #[must_use]
    pub fn arguments(&self) -> &[(&'static str, Shape)] {
        &self.compiled.arguments
    }

    /// Returns the layout of the result's numbers.
    #[must_use]
    pub fn result(&self) -> &Shape {
        &self.compiled.result
    }

    /// Returns counts of its code for one state; for a function of one link, of all links together.
    #[must_use]
    pub fn size(&self) -> CodeSize {
        self.compiled.size
    }

    /// Returns the number of states that the code for batches computes together, one in each lane;
    /// 1 without such code.
    #[must_use]
    pub fn lanes(&self) -> usize {
        if self.has_batch() { self.lanes } else { 1 }
    }

    /// Computes the results for as many states as there are [`lanes`](Self::lanes): each number of
    /// an argument has the numbers of all lanes, and so has each number of the result.
    ///
    /// # Errors
    ///
    /// If the number of arguments or a length is wrong, the function is one of a link, or
    /// [`Options::batches`](crate::Options::batches) was not set.
    pub fn in_lanes(&self, arguments: &[&[S]], results: &mut [S]) -> Result<(), CallError> {
        let function = self.name();
        self.check_link(None)?;
        self.check_count(arguments.len())?;
        if !self.has_batch() {
            return Err(CallError::NoBatch { function });
        }
        let pairs = self.arguments().iter().zip(arguments);
        let given = pairs.map(|((name, shape), argument)| (*name, shape, argument.len()));
        for (name, shape, length) in given.chain([("result", self.result(), results.len())]) {
            let expected = shape.len() * self.lanes;
            if length != expected {
                return Err(CallError::Length { function, name, expected, found: length });
            }
        }
        self.run(None, arguments, results, self.lanes);
        Ok(())
    }

    /// Computes the result for one state.
    ///
    /// # Errors
    ///
    /// If the number of arguments or a length is wrong, or the function is one of a link.
    pub fn one(&self, arguments: &[&[S]], result: &mut [S]) -> Result<(), CallError> {
        self.check(None, arguments, result)?;
        self.run(None, arguments, result, 1);
        Ok(())
    }

    /// Computes the result for one link, by its index among the links of the description, and one
    /// state.
    ///
    /// # Errors
    ///
    /// If there is no such link, the number of arguments or a length is wrong, or the function is
    /// not one of a link.
    pub fn link(&self, link: usize, arguments: &[&[S]], result: &mut [S]) -> Result<(), CallError> {
        self.check(Some(link), arguments, result)?;
        self.run(Some(link), arguments, result, 1);
        Ok(())
    }

    /// Computes the results for many states: each argument has the numbers of the states one after
    /// the other, and so has the result.
    ///
    /// # Errors
    ///
    /// If the number of arguments or a length is wrong, the function is one of a link, or
    /// [`Options::batches`](crate::Options::batches) was not set.
    pub fn many(&self, arguments: &[&[S]], results: &mut [S]) -> Result<(), CallError> {
        self.states(None, arguments, results)
    }

    /// Computes the results of a link for many states, as [`many`](Self::many) does.
    ///
    /// # Errors
    ///
    /// The errors of [`many`](Self::many), or there is no such link.
    pub fn many_link(
        &self,
        link: usize,
        arguments: &[&[S]],
        results: &mut [S],
    ) -> Result<(), CallError> {
        self.states(Some(link), arguments, results)
    }

    fn name(&self) -> &'static str {
        self.compiled.name
    }

    /// Returns whether there is code for batches.
    fn has_batch(&self) -> bool {
        match &self.compiled.kernels {
            CompiledKernels::One(kernel) | CompiledKernels::Poses { bodies: kernel, .. } => {
                kernel.batch.is_some()
            }
            CompiledKernels::Looped { batch, .. } => batch.is_some(),
            CompiledKernels::ByLink(_, kernels) => kernels.iter().all(|k| k.batch.is_some()),
        }
    }

    fn check_link(&self, link: Option<usize>) -> Result<(), CallError> {
        let links = match &self.compiled.kernels {
            CompiledKernels::ByLink(links, _) => Some(links.len()),
            CompiledKernels::One(_)
            | CompiledKernels::Looped { .. }
            | CompiledKernels::Poses { .. } => None,
        };
        let fits = match (link, links) {
            (None, None) => true,
            (Some(link), Some(links)) => link < links,
            _ => false,
        };
        let function = self.name();
        if fits { Ok(()) } else { Err(CallError::Link { function, link, links }) }
    }

    fn check_count(&self, count: usize) -> Result<(), CallError> {
        let expected = self.arguments().iter().map(|(name, _)| *name);
        if count == expected.len() {
            return Ok(());
        }
        let function = self.name();
        Err(CallError::Arguments { function, expected: expected.collect(), found: count })
    }

    fn check(
        &self,
        link: Option<usize>,
        arguments: &[&[S]],
        result: &[S],
    ) -> Result<(), CallError> {
        self.check_link(link)?;
        self.check_count(arguments.len())?;
        let pairs = self.arguments().iter().zip(arguments);
        let given = pairs.map(|((name, shape), argument)| (*name, shape, argument.len()));
        for (name, shape, length) in given.chain([("result", self.result(), result.len())]) {
            let expected = shape.len();
            if length != expected {
                return Err(CallError::Length {
                    function: self.name(),
                    name,
                    expected,
                    found: length,
                });
            }
        }
        Ok(())
    }

    /// Runs the code on checked arguments, with this number of states at a time.
    fn run(&self, link: Option<usize>, arguments: &[&[S]], result: &mut [S], lanes: usize) {
        let parameters = self.compiled.has_parameters.then(|| spread(self.parameters, lanes));
        let mut all: [&[S]; MAX_GIVEN] = [&[]; MAX_GIVEN];
        let given = arguments.iter().copied().chain(parameters.as_deref());
        let count = all.iter_mut().zip(given).map(|(array, given)| *array = given).count();
        match &self.compiled.kernels {
            CompiledKernels::One(kernel) => {
                kernel.code(lanes).call(self.pages, &all[..count], result);
            }
            CompiledKernels::Looped { single, batch } => {
                let code = batch.as_ref().filter(|_| lanes > 1).unwrap_or(single);
                code.call(self.pages, &all[..count], result, lanes);
            }
            CompiledKernels::ByLink(links, kernels) => {
                let LinkProgram { program, placement: row } = links[link.unwrap_or_default()];
                let placement = row.map(|row| spread(&self.placements[row], lanes));
                all[count] = placement.as_deref().unwrap_or_default();
                let count = count + usize::from(row.is_some());
                kernels[program].code(lanes).call(self.pages, &all[..count], result);
            }
            CompiledKernels::Poses { bodies, placed, links } => {
                let bodies = bodies.code(lanes);
                let mut poses = vec![S::default(); bodies.results];
                bodies.call(self.pages, &all[..count], &mut poses);
                let length = Shape::pose().len() * lanes;
                for (link, pose) in links.iter().zip(result.chunks_exact_mut(length)) {
                    let body = &poses[link.program * length..][..length];
                    match link.placement {
                        None => pose.copy_from_slice(body),
                        Some(row) => {
                            let placement = spread(&self.placements[row], lanes);
                            placed.code(lanes).call(self.pages, &[body, &placement], pose);
                        }
                    }
                }
            }
        }
    }

    fn states(
        &self,
        link: Option<usize>,
        arguments: &[&[S]],
        results: &mut [S],
    ) -> Result<(), CallError> {
        self.check_link(link)?;
        self.check_count(arguments.len())?;
        let function = self.name();
        if !self.has_batch() {
            return Err(CallError::NoBatch { function });
        }
        let lengths: Vec<usize> = self.arguments().iter().map(|(_, shape)| shape.len()).collect();
        let mut count = None;
        for ((name, _), (argument, &one)) in
            self.arguments().iter().zip(arguments.iter().zip(&lengths))
        {
            let name = *name;
            let length = argument.len();
            let states = length.checked_div(one).unwrap_or_default();
            if states * one != length {
                return Err(CallError::States { function, name, one, found: length });
            }
            let expected = *count.get_or_insert(states) * one;
            if expected != length {
                return Err(CallError::Length { function, name, expected, found: length });
            }
        }
        let count = count.unwrap_or_default();
        let one = self.result().len();
        if results.len() != count * one {
            let expected = count * one;
            let length = results.len();
            return Err(CallError::Length { function, name: "result", expected, found: length });
        }
        let lanes = self.lanes;
        let mut columns: Vec<Vec<S>> =
            lengths.iter().map(|length| vec![S::default(); length * lanes]).collect();
        let mut computed = vec![S::default(); one * lanes];
        for first in (0..count).step_by(lanes) {
            // The last state fills the remaining lanes.
            let state = |lane: usize| (first + lane).min(count - 1);
            for ((column, argument), &length) in columns.iter_mut().zip(arguments).zip(&lengths) {
                for (i, numbers) in column.chunks_exact_mut(lanes).enumerate() {
                    for (lane, number) in numbers.iter_mut().enumerate() {
                        *number = argument[state(lane) * length + i];
                    }
                }
            }
            let given: Vec<&[S]> = columns.iter().map(Vec::as_slice).collect();
            self.run(link, &given, &mut computed, lanes);
            let states = results[first * one..].chunks_exact_mut(one.max(1)).take(lanes);
            for (lane, state) in states.enumerate() {
                for (number, lanes) in state.iter_mut().zip(computed.chunks_exact(lanes)) {
                    *number = lanes[lane];
                }
            }
        }
        Ok(())
    }
}

/// Repeats each number in this number of lanes.
fn spread<S: Real>(numbers: &[S], lanes: usize) -> Cow<'_, [S]> {
    if lanes == 1 {
        return numbers.into();
    }
    numbers.iter().flat_map(|&number| std::iter::repeat_n(number, lanes)).collect()
}
