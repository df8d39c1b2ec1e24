//! Runge-Kutta steps whose length follows from a tolerance: the pair of orders 5 and 4 of Dormand and Prince 1980, "A family of
//! embedded Runge-Kutta formulae", with the step control of Hairer, Norsett and Wanner 1993, "Solving Ordinary Differential
//! Equations I", section II.4.

use super::motion::State;

/// The instants of the evaluations, in steps.
const NODES: [f64; 7] = [0.0, 1.0 / 5.0, 3.0 / 10.0, 4.0 / 5.0, 8.0 / 9.0, 1.0, 1.0];

/// The weights of earlier rates in the state of each evaluation but the first. The last is the state after the step.
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

/// The limits of the ratio of consecutive steps, and the safety factor.
const RATIO: [f64; 2] = [0.2, 5.0];
const SAFETY: f64 = 0.9;

/// Returns the state after a step, before quaternions are scaled to length 1, and its error relative to `tolerance`. The error
/// of each coordinate and velocity x is measured by `tolerance` (1 + |x|); the largest one counts. It is NaN if the state has
/// left all bounds.
pub fn step<E>(
    (time, dt): (f64, f64),
    start: &State,
    tolerance: f64,
    mut rates: impl FnMut(f64, &State) -> Result<State, E>,
) -> Result<(State, f64), E> {
    let mut found: Vec<State> = Vec::with_capacity(NODES.len());
    let sum = |found: &[State], weights: &[f64], start: &State| {
        found.iter().zip(weights).fold(start.clone(), |sum, (rate, w)| sum.plus(dt * w, rate))
    };
    let mut state = start.clone();
    for (k, node) in NODES.iter().enumerate() {
        if let Some(weights) = k.checked_sub(1).map(|k| STAGES[k]) {
            state = sum(&found, weights, start);
        }
        found.push(rates(time + node * dt, &state)?);
    }
    let other = sum(&found, &DIFFERENCE, &state);
    let numbers = |state: &State| state.q.iter().chain(&state.qd).copied().collect::<Vec<f64>>();
    let (after, before, other) = (numbers(&state), numbers(start), numbers(&other));
    let errors = after.iter().zip(&before).zip(&other).map(|((after, before), other)| {
        (after - other).abs() / (tolerance * (1.0 + after.abs().max(before.abs())))
    });
    // A NaN remains.
    let error = errors.fold(0.0, |most: f64, error| if error <= most { most } else { error });
    Ok((state, if after.iter().all(|x| x.is_finite()) { error } else { f64::NAN }))
}

/// Returns the ratio of the next step to a step with this error.
pub fn ratio(error: f64) -> f64 {
    match error.is_nan() {
        true => RATIO[0],
        false => (SAFETY * error.powf(-0.2)).clamp(RATIO[0], RATIO[1]),
    }
}
