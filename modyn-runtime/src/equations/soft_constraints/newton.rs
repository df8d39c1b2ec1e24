//! Newton's method for the rows of a step. An iteration and an evaluation of its line search decide
//! by selections, so that they run on numbers, in lanes, and on expressions.

use super::law::larger;
use super::problem::{Iterate, SoftMotion, StepProblem};
use super::responses::Laws;
use crate::Scalar;
use crate::mechanism::{BodyTree, Mechanism};
use crate::scalar::at_most;

/// A full step is taken if the slope at its end is at most this share of that at its start.
const FULL_STEP: f64 = 0.05;

/// The largest number of evaluations of a line search.
pub const MAX_SEARCH: usize = 30;

/// The largest number of iterations.
pub const MAX_ITERATIONS: usize = 100;

/// The iteration after which the solver starts again with soft laws.
const RESTART: f64 = 12.0;

/// Scaled laws are made stiffer by this factor.
const STIFFER: f64 = 8.0;

/// The mismatch at which scaled laws are made stiffer, in tolerances.
const CLOSE: f64 = 1e3;

/// The state of the solver between iterations.
#[derive(Clone, Debug)]
pub struct Progress<S> {
    /// The factor of all weights.
    pub scale: S,
    /// The number of iterations.
    pub iterations: S,
    /// The largest mismatch between forces and laws, divided by the robot's weight and the largest force.
    pub residual: S,
    /// The solver has ended if this is not negative.
    pub end: S,
}

/// The state of a line search between two iterates.
#[derive(Clone, Debug)]
pub struct Search<S> {
    /// The end with a negative slope: its place from 0 to 1, and the slope.
    pub low: [S; 2],
    /// The end with a positive slope.
    pub high: [S; 2],
    /// The slope at which the search ends.
    pub least: S,
    /// The search has ended if this is not negative.
    pub end: S,
}

impl<S: Scalar> Progress<S> {
    /// Returns the state before the first iteration.
    #[must_use]
    pub fn first() -> Self {
        Self { scale: S::one(), iterations: S::zero(), residual: S::zero(), end: -S::one() }
    }
}

/// The end of an iteration's full step, and the search between its start and this end.
pub struct Advance<S> {
    /// The end of the full step.
    pub end: Iterate<S>,
    /// The state of the solver after the iteration.
    pub progress: Progress<S>,
    /// The search, which has ended already if the full step is taken.
    pub search: Search<S>,
}

impl<S: Scalar, T: BodyTree<S>> StepProblem<'_, S, T> {
    /// Makes one full step of Newton's method.
    pub fn advance(&mut self, start: &Iterate<S>, progress: &Progress<S>) -> Advance<S> {
        let [zero, one] = [S::zero(), S::one()];
        let scale = progress.scale;
        let start_laws = self.laws(start, scale);
        let end = self.full_step(start, &start_laws);
        let end_laws = self.laws(&end, scale);
        let residual = self.mismatch(&end, &end_laws);
        let tolerance = self.tolerance;
        let is_solved = |tolerance: S, then: S, otherwise: S| {
            // A residual that is NaN ends the iterations.
            (residual - tolerance).select_nonnegative(otherwise, then)
        };
        let iterations = progress.iterations + one;
        let stiffer = at_most(scale * S::from_f64(STIFFER), one);
        let scaled = is_solved(tolerance * S::from_f64(CLOSE), stiffer, scale);
        let restarts = S::from_f64(0.25) - (iterations - S::from_f64(RESTART)).abs();
        let next_scale = restarts.select_nonnegative(self.softening, scaled);
        // Scaled laws never end the iterations.
        let solved = (scale - one).select_nonnegative(is_solved(tolerance, one, -one), -one);
        let slopes = [
            self.slope(start, &start_laws, [start, &end]),
            self.slope(&end, &end_laws, [start, &end]),
        ];
        let least = S::from_f64(FULL_STEP) * slopes[0].abs();
        // The first iterate has no forces in equilibrium, so its full step is taken.
        let is_flat = (least - slopes[1]).select_nonnegative(one, -one);
        // A search needs a start from which the function falls, which rounding hides near the solution.
        let is_final = slopes[0].select_nonnegative(one, is_flat);
        let is_taken = (-progress.iterations).select_nonnegative(one, is_final);
        Advance {
            end,
            progress: Progress { scale: next_scale, iterations, residual, end: solved },
            search: Search {
                low: [zero, slopes[0]],
                high: [one, slopes[1]],
                least,
                end: solved.select_nonnegative(one, is_taken),
            },
        }
    }

    /// Makes one evaluation of a line search from `start` to `end`, the end of a full step with
    /// laws of this `scale`. Returns the iterate there.
    #[must_use]
    pub fn search(
        &self,
        [start, end]: [&Iterate<S>; 2],
        search: &Search<S>,
        scale: S,
    ) -> (Iterate<S>, Search<S>) {
        let [low, high] = [search.low, search.high];
        // The Illinois form of regula falsi: the slope at an end that stays is halved.
        let at = low[0] - low[1] * (high[0] - low[0]) / (high[1] - low[1]);
        let between = |a: &[S], b: &[S]| a.iter().zip(b).map(|(&a, &b)| a + at * (b - a)).collect();
        let iterate = Iterate {
            accelerations: between(&start.accelerations, &end.accelerations),
            balances: between(&start.balances, &end.balances),
        };
        let here = self.slope(&iterate, &self.laws(&iterate, scale), [start, end]);
        let half = S::from_f64(0.5);
        let choose = |rises: S, falls: S| here.select_nonnegative(rises, falls);
        let next = Search {
            low: [choose(low[0], at), choose(low[1] * half, here)],
            high: [choose(at, high[0]), choose(here, high[1] * half)],
            least: search.least,
            end: (search.least - here.abs()).select_nonnegative(S::one(), -S::one()),
        };
        (iterate, next)
    }

    /// Returns the largest difference between a force that keeps an iterate in equilibrium and the force of its
    /// law, divided by the sum of the robot's weight and the largest force; NaN if one is.
    fn mismatch(&self, iterate: &Iterate<S>, laws: &Laws<S>) -> S {
        let differences = iterate.balances.iter().zip(laws.forces());
        let differences = differences.map(|(&balance, force)| (balance - force).abs());
        let most = self.reduce(differences, larger);
        let force = self.reduce(laws.forces().map(S::abs), S::max);
        most / (self.weight + force)
    }

    /// Returns the slope of the function at an iterate along the way between two.
    fn slope(&self, iterate: &Iterate<S>, laws: &Laws<S>, [start, end]: [&Iterate<S>; 2]) -> S {
        let differences = iterate.balances.iter().zip(laws.forces());
        let way = end.accelerations.iter().zip(&start.accelerations);
        let products = differences
            .zip(way)
            .map(|((&balance, force), (&end, &start))| (balance - force) * (end - start));
        self.reduce(products, |a, b| a + b)
    }
}

/// The accelerations in a step, and how the solver ended.
#[derive(Clone, Debug, PartialEq)]
pub struct SoftStep<S> {
    /// The accelerations and the forces.
    pub motion: SoftMotion<S>,
    /// The largest mismatch between forces and laws, divided by the sum of the robot's weight and the largest
    /// force.
    pub residual: S,
    /// The number of iterations.
    pub iterations: S,
}

/// Returns the accelerations of a step by semi-implicit Euler: joint damping acts with the velocities after
/// the step.
pub fn soft_step<S: Scalar>(mut problem: StepProblem<'_, S, Mechanism<S>>) -> SoftStep<S> {
    let mut start = problem.first();
    let mut progress = Progress::<S>::first();
    for _ in 0..MAX_ITERATIONS {
        if progress.end.is_known_nonnegative() {
            break;
        }
        let Advance { end, progress: next_progress, mut search } =
            problem.advance(&start, &progress);
        let mut next = end.clone();
        for _ in 0..MAX_SEARCH {
            if search.end.is_known_nonnegative() {
                break;
            }
            (next, search) = problem.search([&start, &end], &search, progress.scale);
        }
        (start, progress) = (next, next_progress);
    }
    let Progress { residual, iterations, .. } = progress;
    SoftStep { motion: problem.motion(&start), residual, iterations }
}
