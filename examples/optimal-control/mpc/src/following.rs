//! An arm whose hand follows a pose: a problem for [`Solver`](crate::Solver), for any robot whose joints have motors.

use modyn::simulate::State;
use modyn::{Pose, Robot, functions};

use crate::knot::{Knot, StateCost};
use crate::pose_error::{pose_error, pose_error_derivative};
use crate::solver::{Limits, Problem, Step};

/// The problem: the pose of a link, at rest, with torques within the limits of the description. Coordinates beyond
/// their limits cost their square.
#[derive(Clone)]
pub struct Following<R: Robot> {
    /// The link.
    pub link: R::Link,
    /// The pose of the link in the world.
    pub target: Pose<f64>,
    /// The coordinates that the arm should stay near.
    pub posture: R::Q<f64>,
    /// The torques that cost nothing, such as the torques that balance gravity at the posture, N m.
    pub hold: R::V<f64>,
    /// The torque limits, as a part of the limits of the description.
    pub torque_share: f64,
    /// The time step, s.
    pub dt: f64,
}

/// The weights of half of the squared residuals.
struct Weights {
    /// Of the link's displacement from the target, 1/m^2.
    position: f64,
    /// Of the link's rotation from the target, 1/rad^2.
    rotation: f64,
    /// Of the coordinates' displacements from the posture.
    posture: f64,
    /// Of the velocities.
    velocity: f64,
    /// Of coordinates beyond their limits.
    beyond: f64,
}

/// Weights per second.
const RUNNING: Weights =
    Weights { position: 10.0, rotation: 1.0, posture: 0.01, velocity: 0.01, beyond: 100.0 };
/// Weights of the last state.
const LAST: Weights =
    Weights { position: 100.0, rotation: 10.0, posture: 0.01, velocity: 1.0, beyond: 100.0 };
/// The weight of torques per second, 1/(N m)^2.
const EFFORT: f64 = 1e-4;

impl<R, const NV: usize> Following<R>
where
    R: Robot<V<f64> = [f64; NV]>
        + functions::Difference
        + functions::LinkPose
        + functions::Jacobian,
{
    /// Returns the displacements from the posture, and the displacements beyond the joint limits.
    #[inline(always)]
    fn displacements(&self, q: &R::Q<f64>) -> [[f64; NV]; 2] {
        let from_posture = R::difference(&self.posture, q);
        let beyond = core::array::from_fn(|i| {
            let coordinate = q.as_ref()[i];
            coordinate - coordinate.max(R::LIMITS.lower[i]).min(R::LIMITS.upper[i])
        });
        [from_posture, beyond]
    }

    #[inline(always)]
    fn state_cost(&self, x: &State<R>, weights: &Weights) -> f64 {
        let [x0, y0, z0, a, b, c] = pose_error(&R::link_pose(&x.q, self.link), &self.target);
        let [from_posture, beyond] = self.displacements(&x.q);
        let sum = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>();
        0.5 * (weights.position * sum(&[x0, y0, z0])
            + weights.rotation * sum(&[a, b, c])
            + weights.posture * sum(&from_posture)
            + weights.velocity * sum(&x.qd)
            + weights.beyond * sum(&beyond))
    }

    /// Adds the cost of a state times `scale`.
    #[inline(always)]
    fn add_state_cost(
        &self,
        x: &State<R>,
        weights: &Weights,
        scale: f64,
        cost: &mut StateCost<NV>,
    ) {
        let pose = R::link_pose(&x.q, self.link);
        let error = pose_error(&pose, &self.target);
        let rows = pose_error_derivative::<R>(&x.q, self.link, &pose, &error);
        for (i, (error, row)) in error.iter().zip(&rows).enumerate() {
            let weight = if i < 3 { weights.position } else { weights.rotation };
            cost.add_of_coordinates(scale * weight, *error, row);
        }
        let [from_posture, beyond] = self.displacements(&x.q);
        for i in 0..NV {
            cost.add_of_coordinate(i, scale * weights.posture, from_posture[i]);
            if beyond[i] != 0.0 {
                cost.add_of_coordinate(i, scale * weights.beyond, beyond[i]);
            }
            cost.add_of_velocity(i, scale * weights.velocity, x.qd[i]);
        }
    }
}

impl<R, const NV: usize> Problem<NV, NV> for Following<R>
where
    R: Robot<V<f64> = [f64; NV]>
        + functions::Difference
        + functions::Integrate
        + functions::Jacobian
        + functions::Knot
        + functions::LinkPose
        + functions::StepSemiImplicit,
{
    type Robot = R;

    fn dt(&self) -> f64 {
        self.dt
    }

    fn limits(&self) -> Limits<NV> {
        let upper = core::array::from_fn(|i| self.torque_share * R::LIMITS.effort[i]);
        Limits { lower: upper.map(|x| -x), upper }
    }

    #[inline(always)]
    fn step(&self, _: usize, x: &State<R>, u: &[f64; NV]) -> Step<R> {
        let next = R::step_semi_implicit(&x.q, &x.qd, u, self.dt);
        let effort = u.iter().zip(&self.hold).map(|(u, hold)| (u - hold) * (u - hold)).sum::<f64>();
        let cost = self.dt * (self.state_cost(x, &RUNNING) + 0.5 * EFFORT * effort);
        Step { next: State { q: next.q, qd: next.qd }, cost }
    }

    #[inline(always)]
    fn linearize(&self, _: usize, x: &State<R>, u: &[f64; NV], knot: &mut Knot<NV, NV>) {
        knot.step.set::<R>(&R::knot(&x.q, &x.qd, u, self.dt));
        self.add_state_cost(x, &RUNNING, self.dt, &mut knot.state);
        for (i, (u, hold)) in u.iter().zip(&self.hold).enumerate() {
            knot.input.add_of_input(i, self.dt * EFFORT, u - hold);
        }
    }

    fn end(&self, x: &State<R>) -> f64 {
        self.state_cost(x, &LAST)
    }

    fn linearize_end(&self, x: &State<R>, cost: &mut StateCost<NV>) {
        self.add_state_cost(x, &LAST, 1.0, cost);
    }
}
