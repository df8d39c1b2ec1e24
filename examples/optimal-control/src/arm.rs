//! Model predictive control of an arm: the hand follows a pose, with torque limits, and the robot differs from its model.

use std::time::Instant;

use modyn::Inertial;
use modyn::simulate::State;
use mpc::following::Following;
use mpc::pose_error;
use mpc::solver::Problem;

use crate::StepDuration;
use crate::robots::{Arm, ArmLink, LoadedArm, LoadedArmParams};

/// The number of steps of the horizon, of 20 ms.
pub(crate) const STEPS: usize = 30;
/// The solver of the arm's problem.
pub(crate) type Solver = mpc::Solver<Following<Arm>, 7, 7, STEPS>;

/// The postures whose hand poses the arm visits.
pub(crate) const POSTURES: [[f64; 7]; 4] = [
    [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785],
    [0.5, -0.2, -0.2, -1.9, 0.3, 2.0, 0.5],
    [-0.6, 0.3, 0.2, -1.7, -0.3, 2.2, 1.0],
    [0.4, -0.6, 0.3, -2.1, 0.5, 1.7, 0.3],
];

/// Returns the problem of a hand at the pose of a posture.
pub(crate) fn problem(goal: &[f64; 7], torque_share: f64) -> Following<Arm> {
    Following {
        link: ArmLink::GraspPoint,
        target: Arm::link_pose(goal, ArmLink::GraspPoint),
        posture: POSTURES[0],
        hold: Arm::gravity_torques(&POSTURES[0]),
        torque_share,
        dt: 0.02,
    }
}

/// Returns the solver of a problem, with a motion that stays at the first posture.
pub(crate) fn solver(problem: &Following<Arm>) -> Box<Solver> {
    let start = State::at_rest(POSTURES[0]);
    Box::new(Solver::new(problem, &start, &Arm::gravity_torques(&start.q)))
}

/// The robot that the controller moves: a load in its hand and friction in its joints, which the model does not have.
pub(crate) struct Plant {
    params: LoadedArmParams,
    pub(crate) state: State<Arm>,
}

/// The load in the hand, kg, and the friction of a joint, N m s/rad.
const LOAD: f64 = 0.5;
const FRICTION: f64 = 0.3;

impl Plant {
    /// Returns the robot at rest at the first posture.
    ///
    /// # Panics
    ///
    /// Panics if the load is no rigid body.
    pub(crate) fn new() -> Self {
        let mut params = LoadedArmParams::DEFAULT;
        let load = Inertial { mass: LOAD, center_of_mass: [0.0, 0.0, 0.1], inertia: [0.0; 6] };
        params.set_payload_of_hand(load).expect("a point mass is a rigid body");
        Self { params, state: State::at_rest(POSTURES[0]) }
    }

    /// Moves the robot for a millisecond.
    pub(crate) fn step(&mut self, torques: &[f64; 7]) {
        let State { q, qd } = &self.state;
        let tau = core::array::from_fn(|i| torques[i] - FRICTION * qd[i]);
        let step = LoadedArm::step_semi_implicit_with(&self.params, q, qd, &tau, 0.001);
        self.state = State { q: step.q, qd: step.qd };
    }
}

/// The results of the control of an arm.
#[derive(Default)]
pub(crate) struct Followed {
    /// The error of the hand's pose at the end of each rest.
    pub(crate) at_rest: Vec<[f64; 6]>,
    /// The inputs that were at a limit, of all.
    pub(crate) limited: f64,
    /// The largest torque, as a part of its limit.
    pub(crate) largest: f64,
    /// The durations of the steps of the controller.
    pub(crate) durations: Vec<StepDuration>,
}

/// Controls the robot: its hand visits the poses of the postures, each within a second, and rests there for a second. The
/// controller improves its motion once in each step of 20 ms; its feedback runs every millisecond.
pub(crate) fn follow(torque_share: f64) -> Followed {
    let mut problem = problem(&POSTURES[0], torque_share);
    let limits = problem.limits();
    let mut solver = solver(&problem);
    let mut plant = Plant::new();
    let mut followed = Followed::default();
    let mut limited = 0;
    let mut inputs = 0;
    for pair in POSTURES.windows(2) {
        for k in 0..100 {
            let share = 0.5 - 0.5 * (core::f64::consts::PI * f64::from(k.min(50)) / 50.0).cos();
            let goal = core::array::from_fn(|i| pair[0][i] + share * (pair[1][i] - pair[0][i]));
            problem.target = Arm::link_pose(&goal, ArmLink::GraspPoint);
            let start = Instant::now();
            solver.advance();
            solver.restart(&problem, &plant.state);
            let restarted = Instant::now();
            solver.iterate(&problem);
            let iteration = restarted.elapsed();
            followed.durations.push(StepDuration { whole: start.elapsed(), iteration });
            for ms in 0..20 {
                let torques = solver.feedback(&problem, f64::from(ms) / 20.0, &plant.state);
                for (torque, limit) in torques.iter().zip(limits.upper) {
                    followed.largest = followed.largest.max(torque.abs() / limit);
                    limited += usize::from(torque.abs() >= limit);
                    inputs += 1;
                }
                plant.step(&torques);
            }
        }
        let pose = Arm::link_pose(&plant.state.q, ArmLink::GraspPoint);
        followed.at_rest.push(pose_error::pose_error(&pose, &problem.target));
    }
    followed.limited = limited as f64 / inputs as f64;
    followed
}

#[cfg(test)]
mod tests {
    use super::*;
    use mpc::solver::Iteration;

    /// Returns the cost of inputs: the sum of the costs of the problem's steps.
    fn cost(problem: &Following<Arm>, inputs: &[[f64; 7]; STEPS]) -> f64 {
        let mut x = State::at_rest(POSTURES[0]);
        let mut sum = 0.0;
        for (k, u) in inputs.iter().enumerate() {
            let step = problem.step(k, &x, u);
            sum += step.cost;
            x = step.next;
        }
        sum + problem.end(&x)
    }

    /// Returns the derivative of the cost with respect to a torque, by a difference of whole motions.
    fn slope(problem: &Following<Arm>, inputs: &[[f64; 7]; STEPS], k: usize, i: usize) -> f64 {
        let [above, below] = [1e-5, -1e-5].map(|by| {
            let mut inputs = *inputs;
            inputs[k][i] += by;
            cost(problem, &inputs)
        });
        (above - below) / 2e-5
    }

    /// With coordinates within and beyond their limits.
    #[test]
    fn derivatives_are_those_of_differences() {
        let problem = problem(&POSTURES[1], 1.0);
        for scale in [0.3, 2.0] {
            let wave = |i: usize| scale * (3.0 * i as f64 + 1.0).sin();
            let x = State {
                q: core::array::from_fn(|i| POSTURES[0][i] + wave(i)),
                qd: core::array::from_fn(|i| wave(i + 7)),
            };
            let u = core::array::from_fn(|i| wave(i) * Arm::LIMITS.effort[i]);
            crate::check::check_derivatives(&problem, 0, &x, &u);
        }
    }

    /// The conditions of Karush, Kuhn and Tucker, with the gradient by differences of whole motions: zero for inputs
    /// within their limits, and towards the outside at a limit.
    #[test]
    fn the_optimum_has_the_gradient_of_an_optimum() {
        for (share, least_limited) in [(1.0, 0), (0.3, 10)] {
            let problem = problem(&POSTURES[1], share);
            let mut solver = solver(&problem);
            let first = solver.motion().cost;
            // The largest slopes are about 1.
            let start = slope(&problem, &solver.motion().inputs, 0, 1);
            assert!(start.abs() > 0.01, "{share}: {start}");
            let count = (0..60).take_while(|_| solver.iterate(&problem) != Iteration::Converged);
            let count = count.count();
            assert!(count < 60, "{share}: {count} iterations, cost {}", solver.motion().cost);
            let motion = solver.motion();
            assert!(motion.cost < 0.1 * first, "{share}: {first}, then {}", motion.cost);
            assert!((cost(&problem, &motion.inputs) - motion.cost).abs() < 1e-12 * motion.cost);
            let limits = problem.limits();
            let mut limited = 0;
            for (k, i) in (0..STEPS).flat_map(|k| (0..7).map(move |i| (k, i))) {
                let slope = slope(&problem, &motion.inputs, k, i);
                let u = motion.inputs[k][i];
                if u == limits.upper[i] {
                    assert!(slope < 1e-6, "{share}, step {k}, joint {i}: {slope}");
                    limited += 1;
                } else if u == limits.lower[i] {
                    assert!(slope > -1e-6, "{share}, step {k}, joint {i}: {slope}");
                    limited += 1;
                } else {
                    assert!(slope.abs() < 1e-6, "{share}, step {k}, joint {i}: {slope}");
                }
            }
            assert!(limited >= least_limited, "{share}: {limited}");
        }
    }

    /// At rotations up to nearly half a turn.
    #[test]
    fn the_derivative_of_the_pose_error_is_that_of_differences() {
        let q = [0.3, -0.5, 0.7, -1.9, 0.4, 1.3, -0.8];
        let link = ArmLink::GraspPoint;
        let mut largest = 0.0_f64;
        for goal in [
            [0.3, -0.5, 0.7, -1.9, 0.4, 1.3, -0.8 + 1e-3],
            [1.1, 0.2, -0.4, -1.1, -0.6, 2.1, 0.9],
            [-1.3, 0.6, 1.4, -2.4, 1.7, 0.6, 1.2],
            [1.7, -0.3, 0.9, -1.2, -1.4, 2.4, 2.1],
            [0.3, 1.2, 0.7, -0.4, 0.4, 3.0, -0.8],
        ] {
            let target = Arm::link_pose(&goal, link);
            let error = |q: &[f64; 7]| pose_error::pose_error(&Arm::link_pose(q, link), &target);
            let [.., a, b, c] = error(&q);
            largest = largest.max((a * a + b * b + c * c).sqrt());
            let pose = Arm::link_pose(&q, link);
            let rows = pose_error::pose_error_derivative::<Arm>(&q, link, &pose, &error(&q));
            for j in 0..7 {
                let [above, below] = [1e-6, -1e-6].map(|by| {
                    let mut q = q;
                    q[j] += by;
                    error(&q)
                });
                for i in 0..6 {
                    let expected = (above[i] - below[i]) / 2e-6;
                    assert!((rows[i][j] - expected).abs() < 1e-8, "{goal:?}, {i}, {j}");
                }
            }
        }
        assert!(largest > 1.5, "{largest}");
    }

    #[test]
    fn the_hand_follows_poses_with_a_load_that_the_model_does_not_have() {
        let followed = follow(0.7);
        for error in &followed.at_rest {
            let size = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
            assert!(size(&error[..3]) < 0.04 && size(&error[3..]) < 0.05, "{:?}", followed.at_rest);
        }
        assert!(
            followed.largest <= 1.0 && followed.largest > 0.7,
            "{} {}",
            followed.largest,
            followed.limited
        );
    }
}
