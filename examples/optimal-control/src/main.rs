//! Optimal control of robots that modyn compiled: model predictive control of an arm and of a trotting quadruped, a
//! linear-quadratic regulator, a whole-body controller by quadratic programs, and inverse kinematics. Prints a table of
//! the results and of the times: of model predictive control the medians of all steps, of the others the shortest.
//!
//! `cargo run --release`

mod arm;
#[cfg(test)]
mod check;
mod inverse_kinematics;
mod lqr;
mod problems;
mod robots;
mod tangent;
mod trot;
mod whole_body;

use std::hint::black_box;
use std::time::{Duration, Instant};

use modyn::Pose;
use modyn::simulate::State;
use mpc::{Knot, Problem as _};

use problems::{GAINS, Sway};
use robots::{Arm, ArmLink, Quadruped};

/// The time of a part that a method does not have.
const ZERO: Duration = Duration::ZERO;

fn main() {
    println!(
        "| problem | size | result | iterations | solution, µs | an iteration, µs | derivatives and costs of a knot, µs |"
    );
    println!("|---|---|---|---|---|---|---|");
    follow_with_the_arm();
    trot_with_the_quadruped();
    regulate();
    sway();
    solve_inverse_kinematics();
}

/// The duration of a step of a controller.
pub(crate) struct StepDuration {
    /// Of the whole step: the motion from the measured state, and an iteration.
    pub(crate) whole: Duration,
    /// Of the iteration: the derivatives and costs of all knots, the Riccati recursion, and the line search.
    pub(crate) iteration: Duration,
}

/// Returns the medians of the durations of whole steps and of iterations.
fn medians(durations: &[StepDuration]) -> [Duration; 2] {
    let median = |of: fn(&StepDuration) -> Duration| {
        let mut all: Vec<Duration> = durations.iter().map(of).collect();
        all.sort();
        all[all.len() / 2]
    };
    [median(|duration| duration.whole), median(|duration| duration.iteration)]
}

fn follow_with_the_arm() {
    let followed = arm::follow(0.7);
    let errors: Vec<String> = followed.at_rest.iter().map(|error| words(error)).collect();
    let result = format!(
        "with a load that the model lacks, the hand rests {} from its poses; {:.0} % of the torques are at their limits",
        errors.join(", "),
        100.0 * followed.limited
    );
    let problem = arm::problem(&arm::POSTURES[1], 1.0);
    let start = State::at_rest(arm::POSTURES[0]);
    let mut knot = Knot::ZERO;
    let derivatives = best(1000, || problem.linearize(0, &start, &problem.hold, &mut knot));
    let [step, iteration] = medians(&followed.durations);
    let size = format!("{} steps, 14 states, 7 torques", arm::STEPS);
    let times = [step, iteration, derivatives];
    row("MPC, `arm7` follows poses", &size, &result, 1, times);
}

fn trot_with_the_quadruped() {
    let trotted = trot::trot(300, &trot::PUSHES);
    let [x, y, z] = trotted.error.map(|error| 1e3 * error);
    let result = format!(
        "with pushes of 0.3 m/s on unilateral ground, the base is at most {x:.0}, {y:.0} and {z:.0} mm from its motion"
    );
    let problem = trot::Trot::at(trot::STEPS);
    let start = State::at_rest(robots::standing());
    let mut knot = Knot::ZERO;
    let derivatives = best(1000, || problem.linearize(5, &start, &[0.1; 12], &mut knot));
    let [step, iteration] = medians(&trotted.durations);
    let size = format!("{} steps, 36 states, 12 torques", trot::STEPS);
    let times = [step, iteration, derivatives];
    row("MPC, floating `quadruped` trots", &size, &result, 1, times);
}

fn regulate() {
    let regulator = problems::regulator();
    let values = regulator.closed_loop.complex_eigenvalues();
    let radius = values.iter().map(|value| value.norm()).fold(0.0, f64::max);
    let start = problems::displaced(&regulator);
    let [before, after] = [start, regulator.run(start, 400)]
        .map(|x| tangent::difference(&regulator.rest, &x).rows(0, 7).norm());
    let result = format!(
        "the largest eigenvalue has the magnitude {radius:.3}; {before:.2} rad become {after:.0e} rad in 4 s"
    );
    let (size, time) = ("14 states, 7 torques", best(20, problems::regulator));
    row("LQR, `arm7` keeps a posture", size, &result, regulator.iterations, [time, ZERO, ZERO]);
}

fn sway() {
    let sway = Sway::default();
    let dt = 0.002;
    let mut state = State::<Quadruped>::at_rest(robots::standing());
    let mut worst = [0.0_f64; 6];
    let mut iterations = 0;
    let mut friction = 0.0_f64;
    for k in 0..1000 {
        let time = dt * f64::from(k);
        let command = match whole_body::command(&state, &sway.at(time), GAINS) {
            Ok(command) => command,
            Err(status) => return eprintln!("no torques at {time} s: {status}"),
        };
        state = problems::move_on_ground(&state, dt, &command.tau).state;
        let [x, y, z, a, b, c, ..] = Quadruped::difference(&sway.at(time + dt).q, &state.q);
        let error = [x, y, z, a, b, c];
        if norm(&error) > norm(&worst) {
            worst = error;
        }
        iterations = iterations.max(command.iterations as usize);
        friction = command.forces.iter().map(|[x, y, z]| x.hypot(*y) / z).fold(friction, f64::max);
    }
    let result = format!(
        "the base is at most {} from its motion; forces use {:.0} % of the friction",
        words(&worst),
        100.0 * friction / whole_body::FRICTION
    );
    let time = best(200, || whole_body::command(&state, &sway.at(2.0), GAINS));
    let size = "30 unknowns, 18 equations, 44 inequalities";
    row("whole-body QP, floating `quadruped` sways", size, &result, iterations, [time, ZERO, ZERO]);
}

fn solve_inverse_kinematics() {
    const TARGETS: u32 = 200;
    let mut uniform = problems::uniform(1);
    let targets: Vec<Pose<f64>> = (0..TARGETS)
        .map(|_| Arm::link_pose(&Arm::random_configuration(&mut uniform), ArmLink::GraspPoint))
        .collect();
    let options = inverse_kinematics::Options::default();
    let solve = || -> Vec<_> {
        let mut uniform = problems::uniform(2);
        let mut solutions = Vec::new();
        for target in &targets {
            let link = ArmLink::GraspPoint;
            solutions.extend(inverse_kinematics::reach::<Arm>(
                link,
                target,
                &options,
                &mut uniform,
            ));
        }
        solutions
    };
    let solutions = solve();
    let reached = solutions.len();
    let first = solutions.iter().filter(|solution| solution.starts == 1).count();
    let iterations: usize = solutions.iter().map(|solution| solution.iterations).sum();
    let limits = solutions
        .iter()
        .flat_map(|solution| solution.q.iter().zip(Arm::LIMITS.lower).zip(Arm::LIMITS.upper));
    let stopped = limits.filter(|((q, lower), upper)| q == lower || q == upper).count();
    let result = format!(
        "{reached} of {TARGETS} poses reached, {first} from the first start; {stopped} joints at their limits"
    );
    let time = best(10, solve) / TARGETS;
    let size = "7 joints, 6 equations; means of 200";
    let mean = iterations / reached.max(1);
    row("inverse kinematics, `arm7`", size, &result, mean, [time, ZERO, ZERO]);
}

/// Prints a row of the table; a time of zero is left out.
fn row(problem: &str, size: &str, result: &str, iterations: usize, times: [Duration; 3]) {
    let [solution, iteration, derivatives] = times.map(|time| match time.as_secs_f64() * 1e6 {
        0.0 => String::new(),
        us if us < 100.0 => format!("{us:.1}"),
        us => format!("{us:.0}"),
    });
    println!(
        "| {problem} | {size} | {result} | {iterations} | {solution} | {iteration} | {derivatives} |"
    );
}

/// Returns the shortest time of several calls.
fn best<T>(calls: usize, mut call: impl FnMut() -> T) -> Duration {
    let once = |_| {
        let start = Instant::now();
        black_box(call());
        start.elapsed()
    };
    (0..calls).map(once).min().unwrap_or_default()
}

/// Returns a displacement in words; further entries do not count.
fn words(displacement: &[f64]) -> String {
    let length = norm(&displacement[..3]);
    let angle = norm(&displacement[3..6]);
    format!("{:.2} mm and {:.2} mrad", 1e3 * length, 1e3 * angle)
}

fn norm(x: &[f64]) -> f64 {
    x.iter().map(|x| x.powi(2)).sum::<f64>().sqrt()
}
