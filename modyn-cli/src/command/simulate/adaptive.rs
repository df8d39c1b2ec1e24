//! Runge-Kutta steps whose length follows from a tolerance: the pair of orders 5 and 4 of Dormand
//! and Prince 1980, "A family of embedded Runge-Kutta formulae", with the step control of Hairer,
//! Norsett and Wanner 1993, "Solving Ordinary Differential Equations I", section II.4, and their
//! continuous extension of order 4, section II.6.

use super::state::State;

/// The instants of the evaluations, in steps.
const NODES: [f64; 7] = [0.0, 1.0 / 5.0, 3.0 / 10.0, 4.0 / 5.0, 8.0 / 9.0, 1.0, 1.0];

/// The weights of earlier rates in the state of each evaluation but the first. The last is the
/// state after the step.
const STAGES: [&[f64]; 6] = [
    &[1.0 / 5.0],
    &[3.0 / 40.0, 9.0 / 40.0],
    &[44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0],
    &[19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0],
    &[9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0],
    &[35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0],
];

/// The weights of the rates in the difference of the two methods.
const DIFFERENCE: [f64; 7] = [
    71.0 / 57600.0,
    0.0,
    -71.0 / 16695.0,
    71.0 / 1920.0,
    -17253.0 / 339_200.0,
    22.0 / 525.0,
    -1.0 / 40.0,
];

/// The weights of the rates in the term of the continuous extension that vanishes at both ends,
/// with its derivative.
const INSIDE: [f64; 7] = [
    -12_715_105_075.0 / 11_282_082_432.0,
    0.0,
    87_487_479_700.0 / 32_700_410_799.0,
    -10_690_763_975.0 / 1_880_347_072.0,
    701_980_252_875.0 / 199_316_789_632.0,
    -1_453_857_185.0 / 822_651_844.0,
    69_997_945.0 / 29_380_423.0,
];

/// The limits of the ratio of consecutive steps, and the safety factor.
const RATIO: [f64; 2] = [0.2, 5.0];
const SAFETY: f64 = 0.9;

/// A step from `time` on, of length `dt`, s.
#[derive(Clone, Copy)]
pub struct Interval {
    pub time: f64,
    pub dt: f64,
}

/// A step. Quaternions of its states do not have length 1.
pub struct Step {
    interval: Interval,
    start: State,
    /// The coefficients of the continuous extension.
    parts: [State; 4],
    /// The state after the step.
    pub end: State,
    /// The error relative to the tolerance; NaN if the state has left all bounds.
    pub error: f64,
}

impl Step {
    /// Returns the step from a state. The error of each coordinate and velocity x is measured by
    /// `tolerance` (1 + |x|); the largest one counts.
    pub fn new<E>(
        interval: Interval,
        start: &State,
        tolerance: f64,
        mut rates: impl FnMut(f64, &State) -> Result<State, E>,
    ) -> Result<Self, E> {
        let Interval { time, dt } = interval;
        let mut stages: Vec<State> = Vec::with_capacity(NODES.len());
        let moved_from = |start: &State, stages: &[State], weights: &[f64]| {
            stages.iter().zip(weights).fold(start.clone(), |sum, (rate, w)| sum.plus(dt * w, rate))
        };
        let mut end = start.clone();
        for (k, node) in NODES.iter().enumerate() {
            if let Some(weights) = k.checked_sub(1).map(|k| STAGES[k]) {
                end = moved_from(start, &stages, weights);
            }
            stages.push(rates(time + node * dt, &end)?);
        }
        let other = moved_from(&end, &stages, &DIFFERENCE);
        let error = largest_difference(&other, &end, start);
        let is_finite = end.q.iter().chain(&end.qd).all(|x| x.is_finite());
        let error = if is_finite { error / tolerance } else { f64::NAN };
        let moved = end.plus(-1.0, start);
        let zero = start.plus(-1.0, start);
        let ahead = zero.plus(dt, &stages[0]).plus(-1.0, &moved);
        let back = moved.plus(-dt, &stages[6]).plus(-1.0, &ahead);
        let parts = [moved, ahead, back, moved_from(&zero, &stages, &INSIDE)];
        Ok(Self { interval, start: start.clone(), parts, end, error })
    }

    /// Returns the state at an instant within the step.
    pub fn at(&self, time: f64) -> State {
        let part = (time - self.interval.time) / self.interval.dt;
        let [moved, ahead, back, inside] = &self.parts;
        let rest = 1.0 - part;
        self.start
            .plus(part, moved)
            .plus(part * rest, ahead)
            .plus(part * part * rest, back)
            .plus(part * part * rest * rest, inside)
    }
}

/// Returns the largest difference of a coordinate or velocity x from another state, divided by
/// 1 + |x|, where |x| is the larger one of the state and of `before`. It is NaN if one of the
/// differences is.
pub fn largest_difference(other: &State, state: &State, before: &State) -> f64 {
    let numbers = |state: &'_ State| state.q.iter().chain(&state.qd).copied().collect::<Vec<f64>>();
    let differences = numbers(state).into_iter().zip(numbers(before)).zip(numbers(other)).map(
        |((state, before), other)| (state - other).abs() / (1.0 + state.abs().max(before.abs())),
    );
    differences.fold(0.0, |most, x| if x <= most { most } else { x })
}

/// Returns the ratio of the next step to a step with this error.
pub fn ratio(error: f64) -> f64 {
    match error.is_nan() {
        true => RATIO[0],
        false => (SAFETY * error.powf(-0.2)).clamp(RATIO[0], RATIO[1]),
    }
}
