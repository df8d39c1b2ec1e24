//! An arm reaches a pose of one of its links: a problem for [`ilqr`](crate::ilqr), for any robot whose joints have motors.

use modyn::na::{DMatrix, DVector};
use modyn::simulate::State;
use modyn::{Array as _, Pose, Robot, functions};

use crate::ilqr::{LinearStep, Problem, Step};
use crate::pose_error::{pose_error, pose_error_derivative};
use crate::tangent::{matrix, within_limits};

/// The problem. Torques beyond a part of their limits, and coordinates beyond theirs, cost their square.
pub(crate) struct Reaching<R: Robot> {
    /// The state at the beginning.
    pub(crate) start: State<R>,
    /// The link that reaches the target.
    pub(crate) link: R::Link,
    /// The pose of the link at the end, in the world.
    pub(crate) target: Pose<f64>,
    /// The time step, s.
    pub(crate) dt: f64,
}

// The factors of the residuals.
/// Of a torque, divided by its limit.
const EFFORT: f64 = 0.1;
/// Of the part of a torque beyond [`FREE`], divided by its limit.
const EXCESS: f64 = 30.0;
/// Of a velocity, s.
const SPEED: f64 = 0.02;
/// Of a displacement beyond a limit, in each step.
const BEYOND: f64 = 30.0;
/// Of the last pose's error, 1/rad and 1/m.
const ERROR: f64 = 300.0;
/// Of the last velocities, s.
const REST: f64 = 10.0;
/// The part of its limit that a torque may have without further cost.
const FREE: f64 = 0.8;

impl<R> Reaching<R>
where
    R: Robot + functions::Difference,
{
    /// Returns the residuals of a step, four groups with an entry for each joint, and the derivative of each residual
    /// with respect to the one number that it depends on: a torque (the first two groups), a velocity or a coordinate.
    fn residuals(x: &State<R>, u: &DVector<f64>) -> [DVector<f64>; 2] {
        let beyond = R::difference(&within_limits::<R>(&x.q), &x.q);
        let only_if = |value: f64, slope: f64| if value == 0.0 { 0.0 } else { slope };
        let pair = |row: usize| {
            let (group, i) = (row / R::NV, row % R::NV);
            let limit = R::LIMITS.effort[i];
            let load = u[i] / limit;
            let (excess, beyond) = (load - load.clamp(-FREE, FREE), beyond.as_ref()[i]);
            match group {
                0 => (EFFORT * load, EFFORT / limit),
                1 => (EXCESS * excess, only_if(excess, EXCESS / limit)),
                2 => (SPEED * x.qd.as_ref()[i], SPEED),
                _ => (BEYOND * beyond, only_if(beyond, BEYOND)),
            }
        };
        let (values, slopes): (Vec<f64>, Vec<f64>) = (0..4 * R::NV).map(pair).unzip();
        [values.into(), slopes.into()]
    }
}

impl<R> Problem for Reaching<R>
where
    R: Robot
        + functions::Difference
        + functions::Jacobian
        + functions::LinkPose
        + functions::StepSemiImplicit
        + functions::StepSemiImplicitDerivatives,
{
    type Robot = R;

    fn start(&self) -> State<R> {
        self.start
    }

    fn step(&self, _: usize, x: &State<R>, u: &DVector<f64>) -> Step<R> {
        let next = R::step_semi_implicit(&x.q, &x.qd, &R::V::<f64>::from_fn(|i| u[i]), self.dt);
        let [residuals, _] = Self::residuals(x, u);
        Step { next: State { q: next.q, qd: next.qd }, residuals }
    }

    fn linearize(&self, _: usize, x: &State<R>, u: &DVector<f64>) -> LinearStep {
        let (tau, nv) = (R::V::<f64>::from_fn(|i| u[i]), R::NV);
        let found = R::step_semi_implicit_derivatives(&x.q, &x.qd, &tau, self.dt);
        let [residuals, slopes] = Self::residuals(x, u);
        let mut linear = LinearStep {
            a: matrix(found.a.as_ref()),
            b: matrix(found.b.as_ref()),
            residuals,
            by_state: DMatrix::zeros(4 * nv, 2 * nv),
            by_input: DMatrix::zeros(4 * nv, nv),
        };
        for i in 0..nv {
            linear.by_input[(i, i)] = slopes[i];
            linear.by_input[(nv + i, i)] = slopes[nv + i];
            linear.by_state[(2 * nv + i, nv + i)] = slopes[2 * nv + i];
            linear.by_state[(3 * nv + i, i)] = slopes[3 * nv + i];
        }
        linear
    }

    fn end(&self, x: &State<R>) -> DVector<f64> {
        let error = pose_error(&R::link_pose(&x.q, self.link), &self.target) * ERROR;
        let speeds = x.qd.as_ref().iter().map(|qd| REST * qd);
        DVector::from_iterator(6 + R::NV, error.iter().copied().chain(speeds))
    }

    fn linearize_end(&self, x: &State<R>) -> DMatrix<f64> {
        let nv = R::NV;
        let mut derivative = DMatrix::zeros(6 + nv, 2 * nv);
        let of_pose = pose_error_derivative::<R>(&x.q, self.link, &self.target) * ERROR;
        derivative.view_mut((0, 0), (6, nv)).copy_from(&of_pose);
        for i in 0..nv {
            derivative[(6 + i, nv + i)] = REST;
        }
        derivative
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ilqr::{Options, check_derivatives, solve};
    use crate::problems::{hold, reaching};
    use crate::robots::Arm;
    use crate::tangent::moved;

    /// Along random displacements from the start, with torques and coordinates within and beyond their limits.
    #[test]
    fn derivatives_are_those_of_differences() {
        let problem = reaching();
        let wave = |size: usize, scale: f64| {
            DVector::from_fn(size, |i, _| scale * (3.0 * i as f64 + 1.0).sin())
        };
        for scale in [0.3, 1.5] {
            let x = moved(&problem.start, &wave(14, scale));
            let u =
                DVector::from_fn(7, |i, _| scale * Arm::LIMITS.effort[i] * (5.0 * i as f64).cos());
            check_derivatives(&problem, 0, &x, &u);
        }
    }

    #[test]
    fn the_hand_reaches_the_pose() {
        let problem = reaching();
        let inputs = hold(&problem);
        let solution = solve(&problem, inputs, &Options::default());
        assert!(solution.converged, "{:?}", solution.costs);
        assert!(solution.costs.windows(2).all(|pair| pair[1] < pair[0]), "{:?}", solution.costs);

        // The torques alone, without the solver.
        let mut x = problem.start;
        for u in &solution.inputs {
            let step =
                Arm::step_semi_implicit(&x.q, &x.qd, &core::array::from_fn(|i| u[i]), problem.dt);
            x = State { q: step.q, qd: step.qd };
            for i in 0..7 {
                assert!(u[i].abs() < Arm::LIMITS.effort[i], "{u}");
                assert!(
                    (Arm::LIMITS.lower[i]..=Arm::LIMITS.upper[i]).contains(&x.q[i]),
                    "{:?}",
                    x.q
                );
            }
        }
        let before = pose_error(&Arm::link_pose(&problem.start.q, problem.link), &problem.target);
        let after = pose_error(&Arm::link_pose(&x.q, problem.link), &problem.target);
        assert!(before.norm() > 1.0 && after.amax() < 1e-3, "{before} {after}");
        assert!(x.qd.iter().all(|qd| qd.abs() < 0.05), "{:?}", x.qd);
    }
}
