//! Checks of the derivatives of a problem by differences.

use modyn::simulate::State;
use modyn::{Array as _, Robot, functions};
use mpc::{Knot, Problem};

/// Compares the derivatives of step `k` of a problem with differences of second order.
pub(crate) fn check_derivatives<P, const NV: usize, const NU: usize>(
    problem: &P,
    k: usize,
    x: &State<P::Robot>,
    u: &[f64; NU],
) where
    P: Problem<NV, NU>,
    P::Robot: Robot<V<f64> = [f64; NV]> + functions::Integrate,
{
    const SMALL: f64 = 1e-6;
    let mut knot = Knot::ZERO;
    problem.linearize(k, x, u, &mut knot);
    let mut gradient = [0.0; 3].map(|_| vec![]);
    gradient[0].extend(knot.state.q);
    gradient[1].extend(knot.state.qd);
    gradient[2].extend(knot.input.u);
    for (part, name) in ["q", "qd", "u"].into_iter().enumerate() {
        for j in 0..gradient[part].len() {
            let unit = |size: f64| move |i: usize| if i == j { size } else { 0.0 };
            let [above, below] = [SMALL, -SMALL].map(|by| {
                let mut x = *x;
                let mut u = *u;
                match part {
                    0 => x.q = P::Robot::integrate(&x.q, &<[f64; NV]>::from_fn(unit(by))),
                    1 => x.qd[j] += by,
                    _ => u[j] += by,
                }
                problem.step(k, &x, &u)
            });
            let expected = (above.cost - below.cost) / (2.0 * SMALL);
            let error = (gradient[part][j] - expected).abs();
            assert!(
                error < 1e-6 * expected.abs().max(1.0),
                "{k}, {name} {j}: {error:e} {expected}"
            );
            for i in 0..NV {
                let expected = (above.next.qd[i] - below.next.qd[i]) / (2.0 * SMALL);
                let derivative = match part {
                    0 => knot.step.dqd_dq[i][j],
                    1 => knot.step.dqd_dqd[i][j],
                    _ => knot.step.dqd_du[i][j],
                };
                let error = (derivative - expected).abs();
                assert!(
                    error < 1e-6 * expected.abs().max(1.0),
                    "{k}, qd {i} by {name} {j}: {error:e}"
                );
            }
        }
    }
}
