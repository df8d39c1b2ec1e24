//! Times of the function `step` in Rust: a quadruped on four feet and a humanoid on eight points, one state after the
//! other, in the motions of `lab/benches/python/on_ground.py`, which has MuJoCo's times.
//!
//! `RUSTFLAGS="-C target-cpu=native" cargo bench --manifest-path lab/Cargo.toml --bench steps`
//!
//! With `-- iterations` at the end the iterations of a million steps are counted instead.

mod numbers;

use std::time::Instant;

use modyn::simulate::State;
use modyn::{
    Array, ConstraintSettings, ContactSet, ContactSurface, ContactTarget, Robot, StepSettings,
    functions,
};

use numbers::numbers;

modyn::modyn!(
    "../../robots/quadruped.urdf",
    base = floating,
    joint_friction = none,
    functions = [step, link_poses, constrained_inverse_dynamics],
    contacts = [
        "fl": point("front_left_foot"),
        "fr": point("front_right_foot"),
        "hl": point("hind_left_foot"),
        "hr": point("hind_right_foot"),
    ]
);
modyn::modyn!(
    "../../robots/humanoid.urdf",
    base = floating,
    joint_friction = none,
    functions = [step, link_poses, constrained_inverse_dynamics],
    contacts = [
        "left_toe_out": point("left_ankle_roll_link", [0.12, 0.03, -0.035]),
        "left_toe_in": point("left_ankle_roll_link", [0.12, -0.03, -0.035]),
        "left_heel_out": point("left_ankle_roll_link", [-0.05, 0.025, -0.035]),
        "left_heel_in": point("left_ankle_roll_link", [-0.05, -0.025, -0.035]),
        "right_toe_out": point("right_ankle_roll_link", [0.12, -0.03, -0.035]),
        "right_toe_in": point("right_ankle_roll_link", [0.12, 0.03, -0.035]),
        "right_heel_out": point("right_ankle_roll_link", [-0.05, -0.025, -0.035]),
        "right_heel_in": point("right_ankle_roll_link", [-0.05, 0.025, -0.035]),
    ]
);

const STEPS: usize = 50;
const DT: f64 = 0.002;
const MOTIONS: usize = 64;
const RUNS: usize = 20;
const KINDS: [&str; 3] = ["stands", "pushed", "falls"];
/// The motions of each of the six kinds whose iterations are counted: a million steps.
const COUNTED: usize = 1_000_000 / 6 / STEPS + 1;
/// The largest numbers of iterations of the columns of their distribution.
const COLUMNS: [f64; 7] = [1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0];

/// A motion: its first state, and the joint forces of all steps.
struct Start<R: Robot> {
    state: State<R>,
    tau: R::V<f64>,
}

/// Returns numbers with about the normal distribution.
fn normals() -> impl FnMut() -> f64 {
    let mut uniform = numbers();
    // The variance of a number in -1..1 is a third.
    move || uniform() + uniform() + uniform()
}

/// Returns the height of the lowest place that can touch the ground.
fn lowest<R: Robot + functions::LinkPoses>(q: &R::Q<f64>) -> f64 {
    let poses = R::link_poses(q);
    let heights = R::TOUCHING_SHAPE_CENTERS.iter().map(|shape| {
        let pose = poses.as_ref()[shape.link];
        let parts = pose.rotation[2].iter().zip(shape.place);
        pose.translation[2] + parts.map(|(axis, place)| axis * place).sum::<f64>()
    });
    heights.fold(f64::INFINITY, f64::min)
}

/// Returns the motions of a kind from a posture, which gives each joint's angle by its name.
fn starts<R>(kind: &str, motions: usize, posture: &dyn Fn(&str) -> f64) -> Vec<Start<R>>
where
    R: Robot + functions::LinkPoses + functions::ConstrainedInverseDynamics,
{
    let mut normal = normals();
    let still = R::V::<f64>::from_fn(|_| 0.0);
    let mut standing = R::neutral::<f64>();
    for (joint, name) in R::JOINT_NAMES.iter().skip(1).enumerate() {
        standing.as_mut()[7 + joint] = posture(name);
    }
    standing.as_mut()[2] -= lowest::<R>(&standing);
    let targets = R::PerContact::from_fn(|_| ContactTarget::default());
    let settings =
        ConstraintSettings::from_numbers(ConstraintSettings::<f64>::DEFAULT.numbers(), targets);
    let held =
        R::constrained_inverse_dynamics(&standing, &still, &still, R::Contacts::ALL, &settings);
    let start = |_| {
        let mut state: State<R> = State { q: standing, qd: still };
        let mut tau = held.tau;
        state.q.as_mut()[7..].iter_mut().for_each(|angle| *angle += 0.02 * normal());
        match kind {
            "pushed" => state.qd.as_mut()[..2].iter_mut().for_each(|v| *v = normal()),
            "falls" => {
                state.q.as_mut()[2] += 0.05;
                state.qd.as_mut().iter_mut().for_each(|v| *v = 0.3 * normal());
                tau = still;
            }
            _ => {}
        }
        Start { state, tau }
    };
    (0..motions).map(start).collect()
}

/// Returns the angle of a joint whose name ends with one of these; zero for other joints.
fn angle(joint: &str, bends: &[(&str, f64)]) -> f64 {
    bends.iter().find(|(name, _)| joint.ends_with(name)).map_or(0.0, |(_, angle)| *angle)
}

/// Prints the times of a robot's motions.
fn measure<R>(name: &str, posture: &dyn Fn(&str) -> f64)
where
    R: Robot + functions::LinkPoses + functions::ConstrainedInverseDynamics + functions::Step,
{
    let surfaces = R::PerTouchingShape::from_fn(|_| ContactSurface::default());
    let settings = StepSettings::from_numbers(StepSettings::<f64>::DEFAULT.numbers(), surfaces);
    for kind in KINDS {
        let motions = starts::<R>(kind, MOTIONS, posture);
        let mut least = f64::INFINITY;
        let mut iterations = 0.0;
        let mut unsolved = 0;
        for _ in 0..RUNS {
            let begin = Instant::now();
            iterations = 0.0;
            unsolved = 0;
            for Start { state, tau } in &motions {
                let mut step = state.step(DT, tau, &settings);
                for k in 0..STEPS {
                    if k > 0 {
                        step = step.step(DT, tau, &settings);
                    }
                    iterations += step.iterations;
                    unsolved += usize::from(step.residual > settings.tolerance);
                }
            }
            least = least.min(begin.elapsed().as_secs_f64());
        }
        let steps = (MOTIONS * STEPS) as f64;
        let time = 1e6 * least / steps;
        println!("| {name} | {kind} | {time:.2} | {:.2} | {unsolved} |", iterations / steps);
    }
}

/// Prints the distribution of the iterations of a robot's steps, in percent.
fn count<R>(name: &str, posture: &dyn Fn(&str) -> f64)
where
    R: Robot + functions::LinkPoses + functions::ConstrainedInverseDynamics + functions::Step,
{
    let surfaces = R::PerTouchingShape::from_fn(|_| ContactSurface::default());
    let settings = StepSettings::from_numbers(StepSettings::<f64>::DEFAULT.numbers(), surfaces);
    for kind in KINDS {
        let mut counts = [0_usize; COLUMNS.len() + 1];
        let mut most = 0.0_f64;
        let mut unsolved = 0_usize;
        for Start { state, tau } in starts::<R>(kind, COUNTED, posture) {
            let mut step = state.step(DT, &tau, &settings);
            for k in 0..STEPS {
                if k > 0 {
                    step = step.step(DT, &tau, &settings);
                }
                counts[COLUMNS.iter().take_while(|&&largest| step.iterations > largest).count()] +=
                    1;
                most = most.max(step.iterations);
                // A residual that is NaN is none that was reached.
                unsolved += usize::from(!(step.residual <= settings.tolerance));
            }
        }
        let steps = COUNTED * STEPS;
        let shares = counts.map(|count| format!("{:.3}", 100.0 * count as f64 / steps as f64));
        println!("| {name} | {kind} | {steps} | {} | {most} | {unsolved} |", shares.join(" | "));
    }
}

fn main() {
    let quadruped = |joint: &str| {
        let front = if joint.starts_with("front") { 1.0 } else { -1.0 };
        let bends = [("hip_pitch", 0.6 * front), ("knee", -1.2 * front)];
        angle(joint, &bends)
    };
    let bends = [("hip_pitch", -0.2), ("knee", 0.42), ("ankle_pitch", -0.22)];
    let humanoid = |joint: &str| angle(joint, &bends);
    let names = ["quadruped, four feet", "humanoid, eight points"];
    if std::env::args().any(|argument| argument == "iterations") {
        println!(
            "| robot | motion | steps | to 1 | 2 | 3 | 4 | 6 | 8 | 12 | more | most | unsolved |"
        );
        println!("{}|", "|---".repeat(13));
        count::<Quadruped>(names[0], &quadruped);
        count::<Humanoid>(names[1], &humanoid);
        return;
    }
    println!("| robot | motion | us a step | iterations | unsolved |\n|---|---|---|---|---|");
    measure::<Quadruped>(names[0], &quadruped);
    measure::<Humanoid>(names[1], &humanoid);
}
