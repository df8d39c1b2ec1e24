//! Motions by steps whose lengths follow from a tolerance, and past singular postures of closed
//! loops.
//!
//! Where a linkage is flat, the rank of its constraints falls, and two assemblies meet. At a
//! distance d from there, a constraint that is violated by e changes the accelerations by e / d,
//! and in the posture itself they belong to neither assembly. The motion is smooth there all the
//! same. So a step passes the posture: none of its evaluations is in it. Steps follow a tolerance
//! near it, other lengths are tried where an evaluation comes too close, and each state is
//! projected onto the closed loops. A projection that would jump is refused, so the linkage stays
//! in its assembly.

use modyn_runtime::ShapeError;

use super::adaptive::{self, Interval, Step};
use super::dynamics::{Dynamics, Ranks};
use super::state::State;
use crate::command::outcome::Failure;

/// The shortest step by a tolerance, as a part of the longest.
const SHORTEST: f64 = 1e-7;

/// The tolerance of the steps past a singular posture in a motion of fixed steps. Smaller ones
/// cannot be kept everywhere, since rounding errors grow by the inverse distance from the posture.
const PASSING: f64 = 1e-8;

/// The lengths that are tried past a singular posture, in steps. Their evaluations are at other
/// instants.
const LENGTHS: [f64; 7] = [1.0, 1.4, 0.7, 2.0, 0.5, 2.8, 0.35];

/// The largest change of a state by a projection onto closed loops, in tolerances.
const JUMP: f64 = 100.0;

/// A posture near which the rank of constraints falls.
#[derive(Clone, Copy)]
pub struct Singular {
    /// The instant, s.
    pub time: f64,
    /// The rank in the posture.
    pub rank: f64,
    /// The rank elsewhere.
    pub usual: f64,
}

impl std::fmt::Display for Singular {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { time, rank, usual } = self;
        write!(
            f,
            "near {time:.4} s the loops pass a singular posture, in which the rank of their constraints falls from \
             {usual:.0} to {rank:.0}"
        )
    }
}

/// The lengths of steps.
#[derive(Clone, Copy)]
pub struct Lengths {
    /// The error of a step, relative to 1 + |x|; `None` for fixed steps.
    pub tolerance: Option<f64>,
    /// The length of the first step, s.
    pub first: f64,
    /// The length of the longest step that follows a tolerance, s.
    pub longest: f64,
}

/// A motion up to the end of its last step.
pub struct Walk {
    lengths: Lengths,
    /// The length of the next step by a tolerance, s.
    step: f64,
    /// The number of steps.
    pub steps: usize,
    time: f64,
    state: State,
    /// The last step, if its length followed a tolerance.
    last: Option<Step>,
    /// The first and the last singular posture up to now.
    pub singular: Option<[Singular; 2]>,
}

fn shape(error: ShapeError) -> Failure {
    Failure::usage(format!("error: {error}"))
}

impl Walk {
    /// Returns a motion that starts at time 0.
    pub fn new(state: State, lengths: Lengths) -> Self {
        let step = lengths.first;
        Self { lengths, step, steps: 0, time: 0.0, state, last: None, singular: None }
    }

    /// Returns the state at an instant that is not before the instants of earlier calls.
    pub fn state_at(&mut self, time: f64, dynamics: &mut Dynamics<'_>) -> Result<State, Failure> {
        while self.time < time {
            let is_done = match self.lengths.tolerance {
                None => self.fixed_step(time, dynamics).map_err(shape)?,
                Some(_) => false,
            };
            if !is_done {
                self.free_step(dynamics)?;
            }
        }
        let mut state = match &self.last {
            Some(last) if self.time > time => last.at(time),
            _ => self.state.clone(),
        };
        dynamics.interpreter.normalize_configuration(&mut state.q).map_err(shape)?;
        Ok(state)
    }

    /// Takes a step of the classical Runge-Kutta method to this instant; `false` near a singular
    /// posture.
    fn fixed_step(&mut self, time: f64, dynamics: &mut Dynamics<'_>) -> Result<bool, ShapeError> {
        dynamics.ranks.clear();
        let next = dynamics.step(self.time, time - self.time, &self.state)?;
        if self.is_near(dynamics) {
            return Ok(false);
        }
        self.steps += 1;
        self.last = None;
        self.time = time;
        self.state = next;
        self.step = self.lengths.first;
        Ok(true)
    }

    /// Takes a step by the tolerance.
    fn free_step(&mut self, dynamics: &mut Dynamics<'_>) -> Result<(), Failure> {
        let tolerance = self.lengths.tolerance.unwrap_or(PASSING);
        let mut shorter = 0.5;
        for factor in LENGTHS {
            let interval = Interval { time: self.time, dt: factor * self.step };
            dynamics.ranks.clear();
            let rates = |time: f64, state: &State| dynamics.rates(time, state);
            let step = Step::new(interval, &self.state, tolerance, rates).map_err(shape)?;
            let ratio = adaptive::ratio(step.error);
            let is_near = self.is_near(dynamics);
            if step.error <= 1.0 && !has_fallen(&dynamics.ranks) {
                let mut end = step.end.clone();
                dynamics.interpreter.normalize_configuration(&mut end.q).map_err(shape)?;
                let change = if is_near { dynamics.close(&mut end).map_err(shape)? } else { 0.0 };
                if change <= JUMP * tolerance {
                    self.steps += 1;
                    self.time += interval.dt;
                    self.state = end;
                    self.last = Some(step);
                    self.step = (ratio * interval.dt).min(self.lengths.longest);
                    return Ok(());
                }
            }
            shorter = ratio.min(shorter);
            if !is_near {
                break;
            }
        }
        self.step *= shorter;
        if self.step < SHORTEST * self.lengths.longest {
            Err(self.failure(tolerance))
        } else {
            Ok(())
        }
    }

    /// Returns whether the last evaluations came near a singular posture, and notes the posture.
    fn is_near(&mut self, dynamics: &Dynamics<'_>) -> bool {
        let usual = dynamics.usual;
        let rank = dynamics.ranks.iter().map(|ranks| ranks.firm).fold(usual, f64::min);
        let is_near = rank < usual;
        if is_near {
            let last = Singular { time: self.time, rank, usual };
            self.singular = Some([self.singular.map_or(last, |[first, _]| first), last]);
        }
        is_near
    }

    fn failure(&self, tolerance: f64) -> Failure {
        let time = self.time;
        let shortest = SHORTEST * self.lengths.longest;
        let cannot = format!(
            "error: the tolerance {tolerance:e} cannot be kept at {time:.4} s, not even by steps of {shortest:.1e} s: "
        );
        Failure::Negative(match self.singular {
            Some([_, last]) if last.time >= time => format!(
                "{cannot}{last}, and rounding errors grow there: take `--tolerance {:e}`",
                if tolerance < PASSING { PASSING } else { 10.0 * tolerance }
            ),
            _ => format!(
                "{cannot}the motion is stiff, leaves all bounds, or the tolerance is below rounding: take a larger \
                 `--tolerance`, or fixed steps by `--step`"
            ),
        })
    }
}

/// Returns whether the rank falls from the first of the states to a later one.
fn has_fallen(ranks: &[Ranks]) -> bool {
    ranks.iter().any(|later| later.exact < ranks[0].exact)
}
