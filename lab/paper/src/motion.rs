//! Motions of a model over time: an adaptive integrator for coordinates on a manifold.

use modyn_runtime::Interpreter;

/// Coordinates and velocities.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// Coordinates.
    pub q: Vec<f64>,
    /// Velocities.
    pub qd: Vec<f64>,
}

/// The stages of Dormand and Prince's fifth-order method (1980): times, and weights of the preceding stages.
const TIMES: [f64; 7] = [0.0, 0.2, 0.3, 0.8, 8.0 / 9.0, 1.0, 1.0];
const WEIGHTS: [[f64; 6]; 7] = [
    [0.0; 6],
    [0.2, 0.0, 0.0, 0.0, 0.0, 0.0],
    [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0],
    [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0],
    [19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0, 0.0, 0.0],
    [9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0, 0.0],
    [35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0],
];
/// The last stage's weights minus those of the embedded fourth-order method.
const ERRORS: [f64; 7] = [
    71.0 / 57600.0,
    0.0,
    -71.0 / 16695.0,
    71.0 / 1920.0,
    -17253.0 / 339_200.0,
    22.0 / 525.0,
    -1.0 / 40.0,
];

/// Returns the motion from `start` under `accelerations` at each of `times`, which ascend from 0.
///
/// Dormand and Prince's method; the steps keep the estimated error of each below `tolerance` times the larger of 1 and
/// the integrated values. The integrator is written here because quaternions are integrated as four numbers and
/// normalized after each step, and the available crates run no code of the caller between steps.
///
/// # Panics
///
/// If lengths are not those of `geometry`'s model.
pub fn integrate(
    geometry: &Interpreter<f64>,
    start: State,
    times: &[f64],
    tolerance: f64,
    mut accelerations: impl FnMut(f64, &State) -> Vec<f64>,
) -> Vec<State> {
    let nq = start.q.len();
    let mut slope = |t: f64, y: &[f64]| {
        let state = split(y, nq);
        let mut rates = vec![0.0; nq];
        geometry.velocity_to_qdot(&state.q, &state.qd, &mut rates).expect("lengths");
        rates.extend(accelerations(t, &state));
        rates
    };
    let mut y = [start.q, start.qd].concat();
    let (mut t, mut step) = (0.0, 1e-3);
    let mut states = Vec::with_capacity(times.len());
    for &until in times {
        while until - t > 1e-12 {
            let h = f64::min(step, until - t);
            let mut slopes: Vec<Vec<f64>> = Vec::with_capacity(7);
            let mut last = y.clone();
            for (time, weights) in TIMES.into_iter().zip(WEIGHTS) {
                last.clone_from(&y);
                for (weight, slope) in weights.iter().zip(&slopes) {
                    last.iter_mut().zip(slope).for_each(|(y, k)| *y += h * weight * k);
                }
                slopes.push(slope(t + time * h, &last));
            }
            assert!(last.iter().all(|y| y.is_finite()), "the motion is lost at {t} s");
            let error = (0..y.len()).fold(0.0, |worst: f64, i| {
                let error: f64 = ERRORS.iter().zip(&slopes).map(|(e, k)| h * e * k[i]).sum();
                worst.max(error.abs() / (tolerance * (1.0 + y[i].abs())))
            });
            if error <= 1.0 {
                t += h;
                y = last;
                geometry.normalize_configuration(&mut y[..nq]).expect("lengths");
            }
            step = h * (0.9 * error.max(1e-10).powf(-0.2)).clamp(0.2, 5.0);
            assert!(step > 1e-12, "the step vanishes at {t} s");
        }
        states.push(split(&y, nq));
    }
    states
}

fn split(y: &[f64], nq: usize) -> State {
    State { q: y[..nq].to_vec(), qd: y[nq..].to_vec() }
}

/// Returns this number of times, evenly spaced from 0 to `end`.
#[must_use]
pub fn instants(end: f64, count: usize) -> Vec<f64> {
    (0..count).map(|k| end * k as f64 / (count - 1) as f64).collect()
}

#[cfg(test)]
mod tests {
    use modyn_runtime::Interpreter;

    use super::{State, instants, integrate};
    use crate::robots;

    #[test]
    fn an_oscillation_is_followed_to_its_tolerance() {
        let geometry = Interpreter::<f64>::new(robots::chain(1));
        let start = State { q: vec![1.0], qd: vec![0.0] };
        let times = instants(10.0, 11);
        for tolerance in [1e-6, 1e-10] {
            let oscillate = |_: f64, state: &State| vec![-4.0 * state.q[0]];
            let states = integrate(&geometry, start.clone(), &times, tolerance, oscillate);
            for (t, state) in times.iter().zip(states) {
                let error = (state.q[0] - (2.0 * t).cos()).abs();
                assert!(error < 100.0 * tolerance, "{error:e} at {t}");
            }
        }
    }

    #[test]
    fn energy_is_kept() {
        let mut interpreter = Interpreter::<f64>::new(robots::biped());
        let start = crate::gait::desired(0.3);
        let start = State { q: start.q.to_vec(), qd: start.qd.to_vec() };
        let mut energy = |state: &State| {
            interpreter.kinetic_energy(&state.q, &state.qd).expect("lengths")
                + interpreter.potential_energy(&state.q).expect("lengths")
        };
        let before = energy(&start);
        let geometry = Interpreter::<f64>::new(robots::biped());
        let mut falling = geometry.clone();
        let fall = |_: f64, state: &State| {
            let mut qdd = vec![0.0; 12];
            falling.forward_dynamics(&state.q, &state.qd, &[0.0; 12], &mut qdd).expect("lengths");
            qdd
        };
        let end = integrate(&geometry, start, &[0.5], 1e-9, fall);
        assert!((energy(&end[0]) - before).abs() < 1e-5);
        let length: f64 = end[0].q[3..7].iter().map(|x| x * x).sum();
        assert!((length - 1.0).abs() < 1e-14);
    }
}
