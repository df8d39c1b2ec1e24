//! A linear-quadratic regulator about a posture at rest, for any robot whose joints have motors.
//!
//! The torques that balance gravity make a posture an equilibrium. A and B of the time step there are the derivatives of
//! `step_semi_implicit`. The Riccati recursion
//!
//! ```text
//! K = (R + B^T P B)^-1 B^T P A            P <- Q + A^T P (A - B K)
//! ```
//!
//! converges to the cost x^T P x of the best feedback -K x (Anderson and Moore 1990, "Optimal Control: Linear Quadratic
//! Methods").

use modyn::na::{Cholesky, DMatrix, DVector};
use modyn::simulate::State;
use modyn::{Array as _, Robot, functions};

use crate::robots::Arm;
use crate::tangent::{difference, matrix};

/// The weights of the cost, the same for all joints.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Weights {
    /// Of the squared displacements.
    pub(crate) displacement: f64,
    /// Of the squared velocities.
    pub(crate) velocity: f64,
    /// Of the squared torques, each divided by its limit.
    pub(crate) effort: f64,
}

/// A regulator: torques that balance gravity at a posture, and feedback of the displacement of the state.
pub(crate) struct Regulator<R: Robot> {
    /// The state at rest.
    pub(crate) rest: State<R>,
    /// The torques at rest.
    pub(crate) tau: R::V<f64>,
    /// K: torques are `tau` - K times the displacement of the state.
    pub(crate) gain: DMatrix<f64>,
    /// A - B K, the time step of the closed loop.
    pub(crate) closed_loop: DMatrix<f64>,
    /// The number of steps of the recursion.
    pub(crate) iterations: usize,
}

impl<R> Regulator<R>
where
    R: Robot
        + functions::Difference
        + functions::GravityTorques
        + functions::StepSemiImplicitDerivatives,
{
    /// Returns the regulator about the coordinates `q` for the time step `dt` (s); `None` if the recursion does not
    /// converge.
    pub(crate) fn about(q: R::Q<f64>, weights: &Weights, dt: f64) -> Option<Self> {
        let [a, b, of_state, of_effort] = linear_quadratic::<R>(&q, weights, dt);
        let (_, gain, iterations) = riccati([&a, &b, &of_state, &of_effort])?;
        let closed_loop = a - b * &gain;
        Some(Self {
            rest: State::at_rest(q),
            tau: R::gravity_torques(&q),
            gain,
            closed_loop,
            iterations,
        })
    }

    /// Returns the torques at a state.
    pub(crate) fn torques(&self, state: &State<R>) -> R::V<f64> {
        let feedback = &self.gain * difference(&self.rest, state);
        R::V::<f64>::from_fn(|i| self.tau.as_ref()[i] - feedback[i])
    }
}

impl Regulator<Arm> {
    /// Returns the state after some time steps of 10 ms, by an integrator of higher order with a shorter step.
    pub(crate) fn run(&self, mut state: State<Arm>, steps: usize) -> State<Arm> {
        for _ in 0..steps {
            let tau = self.torques(&state);
            for _ in 0..5 {
                state = state.runge_kutta_4(0.002, |x| Arm::forward_dynamics(&x.q, &x.qd, &tau));
            }
        }
        state
    }
}

/// Returns A and B of a time step at rest, and the weights Q and R of states and torques.
fn linear_quadratic<R>(q: &R::Q<f64>, weights: &Weights, dt: f64) -> [DMatrix<f64>; 4]
where
    R: Robot + functions::GravityTorques + functions::StepSemiImplicitDerivatives,
{
    let (rest, tau) = (State::<R>::at_rest(*q), R::gravity_torques(q));
    let step = R::step_semi_implicit_derivatives(q, &rest.qd, &tau, dt);
    let of_state = |i: usize, _| if i < R::NV { weights.displacement } else { weights.velocity };
    let of_effort = |i: usize, _| weights.effort / R::LIMITS.effort[i].powi(2);
    [
        matrix(step.a.as_ref()),
        matrix(step.b.as_ref()),
        DMatrix::from_diagonal(&DVector::from_fn(2 * R::NV, of_state)),
        DMatrix::from_diagonal(&DVector::from_fn(R::NV, of_effort)),
    ]
}

/// The greatest number of steps of the recursion, and the relative change of P below which it has converged.
const MAX_STEPS: usize = 10_000;
const CONVERGED: f64 = 1e-12;

/// Returns P, K and the number of steps, for A, B and the weights of states and inputs; `None` if the recursion does not
/// converge.
fn riccati([a, b, q, r]: [&DMatrix<f64>; 4]) -> Option<(DMatrix<f64>, DMatrix<f64>, usize)> {
    let mut p = q.clone();
    for step in 1..=MAX_STEPS {
        let pb = &p * b;
        let gain = Cholesky::new(r + b.tr_mul(&pb))?.solve(&(pb.tr_mul(a)));
        let next = q + a.tr_mul(&(&p * (a - b * &gain)));
        let next = (&next + next.transpose()) * 0.5;
        let change = (&next - &p).amax();
        p = next;
        if change < CONVERGED * p.amax() {
            return Some((p, gain, step));
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problems::{WEIGHTS, displaced, regulator};

    fn spectral_radius(m: &DMatrix<f64>) -> f64 {
        m.complex_eigenvalues().iter().map(|value| value.norm()).fold(0.0, f64::max)
    }

    #[test]
    fn the_closed_loop_is_stable_and_the_open_loop_is_not() {
        let found = regulator();
        let [a, ..] = linear_quadratic::<Arm>(&found.rest.q, &WEIGHTS, 0.01);
        assert!(spectral_radius(&a) > 1.01);
        assert!(spectral_radius(&found.closed_loop) < 0.99);
    }

    /// The motion of the robot itself, by another integrator with a shorter step.
    #[test]
    fn a_displaced_arm_returns() {
        let found = regulator();
        let away = displaced(&found);
        let at_start = difference(&found.rest, &away).norm();
        let state = found.run(away, 400);
        let at_end = difference(&found.rest, &state).norm();
        assert!(at_start > 0.5 && at_end < 1e-3, "{at_start} {at_end}");
    }

    /// The cost of the linear closed loop is x^T P x / 2, and gains nearby cost more.
    #[test]
    fn gains_nearby_cost_more() {
        let [a, b, q, r] = linear_quadratic::<Arm>(&regulator().rest.q, &WEIGHTS, 0.01);
        let (p, best, _) = riccati([&a, &b, &q, &r]).expect("converges");
        let start = DVector::from_fn(14, |i, _| (2.0 * i as f64 + 1.0).sin());
        let cost = |gain: &DMatrix<f64>| {
            let (mut x, mut sum) = (start.clone(), 0.0);
            for _ in 0..3000 {
                let u = -(gain * &x);
                sum += 0.5 * (x.dot(&(&q * &x)) + u.dot(&(&r * &u)));
                x = &a * x + &b * u;
            }
            sum
        };
        let least = cost(&best);
        assert!((least / (0.5 * start.dot(&(&p * &start))) - 1.0).abs() < 1e-6);
        for i in 0..7 {
            for factor in [0.98, 1.02] {
                let mut gain = best.clone();
                gain.row_mut(i).scale_mut(factor);
                assert!(cost(&gain) > least * (1.0 + 1e-9), "joint {i}, {factor}");
            }
        }
    }
}
