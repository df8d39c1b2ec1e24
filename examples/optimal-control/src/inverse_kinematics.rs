//! Inverse kinematics by damped least squares within joint limits, for any robot.
//!
//! A step is the displacement dq that minimizes |e + J dq|^2 + d |dq|^2, with the error e of the pose, its derivative J and
//! the damping d: dq = -J^T (J J^T + d)^-1 e. A joint that would pass its limit stops there, and the step is computed again
//! for the other joints.
//!
//! - Nakamura and Hanafusa 1986, "Inverse kinematic solutions with singularity robustness for robot manipulator control",
//!   and Wampler 1986, "Manipulator inverse kinematic solutions based on vector formulations and damped least-squares
//!   methods".
//! - Sugihara 2011, "Solvability-unconcerned inverse kinematics by the Levenberg-Marquardt method": the damping in proportion
//!   to |e|^2, plus a small number.
//! - Baerlocher and Boulic 2004, "An inverse kinematics architecture enforcing an arbitrary number of strict priority
//!   levels": limits by removing joints.

use modyn::na::{Cholesky, DMatrix, DVector};
use modyn::{Array as _, Pose, Robot, functions};
use mpc::pose_error::{pose_error, pose_error_derivative};

use crate::tangent::within_limits;

/// The options of the method.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Options {
    /// The error at which the pose is reached, the length of its six numbers in rad and m.
    pub(crate) tolerance: f64,
    /// The greatest number of steps from one start.
    pub(crate) iterations: usize,
    /// The greatest number of further starts, at random.
    pub(crate) restarts: usize,
}

impl Default for Options {
    fn default() -> Self {
        Self { tolerance: 1e-8, iterations: 20, restarts: 100 }
    }
}

/// Coordinates within the limits at which the link has the pose.
pub(crate) struct Reached<R: Robot> {
    /// The coordinates.
    pub(crate) q: R::Q<f64>,
    /// The number of steps, from all starts.
    pub(crate) iterations: usize,
    /// The number of starts.
    pub(crate) starts: usize,
}

/// The damping for each unit of the squared error, and the damping that remains where the error is zero. Of the factors
/// 0.5 to 0.005, 0.1 takes the fewest steps.
const DAMPING: [f64; 2] = [0.1, 1e-9];

/// Returns coordinates at which `link` has the pose `target`; `None` if no start leads there.
///
/// The first start is in the middle of the limits. The others come from `uniform`, a source of random
/// numbers in [0, 1).
pub(crate) fn reach<R>(
    link: R::Link,
    target: &Pose<f64>,
    options: &Options,
    mut uniform: impl FnMut() -> f64,
) -> Option<Reached<R>>
where
    R: Robot
        + functions::Difference
        + functions::Integrate
        + functions::Jacobian
        + functions::LinkPose
        + functions::RandomConfiguration,
{
    let mut iterations = 0;
    for starts in 1..=1 + options.restarts {
        let mut q = if starts == 1 { middle::<R>() } else { R::random_configuration(&mut uniform) };
        for _ in 0..options.iterations {
            let error = pose_error(&R::link_pose(&q, link), target);
            if DVector::from_column_slice(&error).norm() < options.tolerance {
                return Some(Reached { q, iterations, starts });
            }
            q = step::<R>(&q, link, target);
            iterations += 1;
        }
    }
    None
}

/// Returns the coordinates in the middle of their limits; those without limits are neutral.
fn middle<R: Robot>() -> R::Q<f64> {
    let (neutral, limits) = (R::neutral::<f64>(), R::LIMITS);
    R::Q::<f64>::from_fn(|i| {
        let middle = 0.5 * (limits.lower[i] + limits.upper[i]);
        if middle.is_finite() { middle } else { neutral.as_ref()[i] }
    })
}

/// Returns the coordinates after a step.
fn step<R>(q: &R::Q<f64>, link: R::Link, target: &Pose<f64>) -> R::Q<f64>
where
    R: Robot
        + functions::Difference
        + functions::Integrate
        + functions::Jacobian
        + functions::LinkPose,
{
    let pose = R::link_pose(q, link);
    let error = pose_error(&pose, target);
    let rows = pose_error_derivative::<R>(q, link, &pose, &error);
    let error = DVector::from_column_slice(&error);
    let derivative = DMatrix::from_fn(6, R::NV, |i, j| rows[i].as_ref()[j]);
    let damping = DAMPING[0] * error.norm_squared() + DAMPING[1];
    // The displacements of the joints that stop at a limit.
    let (mut free, mut stops) = (vec![true; R::NV], DVector::zeros(R::NV));
    // Each iteration stops a joint or returns.
    loop {
        let of_free =
            DMatrix::from_fn(6, R::NV, |i, j| if free[j] { derivative[(i, j)] } else { 0.0 });
        let square = &of_free * of_free.transpose() + DMatrix::identity(6, 6) * damping;
        // The matrix is positive definite, since the damping is.
        let Some(factors) = Cholesky::new(square) else { return *q };
        let displacement =
            &stops - of_free.tr_mul(&factors.solve(&(&error + &derivative * &stops)));
        let found = R::integrate(q, &R::V::<f64>::from_fn(|i| displacement[i]));
        let within = within_limits::<R>(&found);
        let back = R::difference(&found, &within);
        let passed = |i: &usize| free[*i] && back.as_ref()[*i] != 0.0;
        let passed: Vec<usize> = (0..R::NV).filter(passed).collect();
        if passed.is_empty() {
            return within;
        }
        for i in passed {
            free[i] = false;
            stops[i] = displacement[i] + back.as_ref()[i];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problems::uniform;
    use crate::robots::{Arm, ArmLink};

    /// Poses of random coordinates within the limits, so each can be reached.
    #[test]
    fn reachable_poses_are_reached_within_limits() {
        let mut uniform = uniform(1);
        let mut at_limits = 0;
        for case in 0..200 {
            let goal = Arm::random_configuration(&mut uniform);
            let target = Arm::link_pose(&goal, ArmLink::GraspPoint);
            let found =
                reach::<Arm>(ArmLink::GraspPoint, &target, &Options::default(), &mut uniform);
            let found = found.unwrap_or_else(|| panic!("case {case}: {goal:?}"));
            let pose = Arm::link_pose(&found.q, ArmLink::GraspPoint);
            for i in 0..3 {
                assert!((pose.translation[i] - target.translation[i]).abs() < 1e-7);
                for j in 0..3 {
                    assert!((pose.rotation[i][j] - target.rotation[i][j]).abs() < 1e-7);
                }
            }
            for (i, q) in found.q.iter().enumerate() {
                let (lower, upper) = (Arm::LIMITS.lower[i], Arm::LIMITS.upper[i]);
                assert!((lower..=upper).contains(q), "case {case}, joint {i}: {q}");
                at_limits += usize::from(*q == lower || *q == upper);
            }
        }
        // The limits matter.
        assert!(at_limits > 3, "{at_limits}");
    }

    /// A pose that no coordinates have.
    #[test]
    fn a_pose_out_of_reach_is_not_reached() {
        let mut target = Arm::link_pose(&middle::<Arm>(), ArmLink::GraspPoint);
        target.translation[0] += 2.0;
        let options = Options { restarts: 3, ..Options::default() };
        assert!(reach::<Arm>(ArmLink::GraspPoint, &target, &options, uniform(2)).is_none());
    }
}
