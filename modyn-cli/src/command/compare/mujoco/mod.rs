//! `modyn compare --mujoco`: compares steps and motions of an MJCF with MuJoCo's.

mod joints;
mod python;

use modyn_codegen::Format;
use modyn_codegen::diagnostics::{Diagnostics, sanitize_for_display};
use modyn_runtime::Interpreter;
use modyn_runtime::equations::TimeStepInput;
use modyn_runtime::model::{Keyframe, Model};
use serde_json::{Value, json};

use super::{Arguments, shape};
use crate::command::outcome::{Failure, to_stdout};
use crate::command::progress::Progress;
use crate::command::robot::needs_dynamics;
use crate::command::table::Table;
use crate::contact_steps::{ContactSteps, Ground, Limits, Options};
use crate::escape;
use crate::random::Random;
use joints::{Joints, TheirJoint};
use python::Process;

/// The number of steps of a motion.
const STEPS: usize = 50;

/// The allowed difference after a step, relative to the largest velocity.
const TOLERANCE: f64 = 1e-8;

/// The factor of the allowed difference after a motion.
const MOTION: f64 = 100.0;

/// The tolerance of the solver of modyn's steps.
const SOLVER_TOLERANCE: f64 = 1e-12;

/// The largest displacements of the states from the start, rad and m, in turn.
const DISPLACEMENTS: [f64; 2] = [0.05, 0.25];

/// The largest number of pairs of shapes that are named.
const MAX_PAIRS: usize = 4;

/// The velocities `qvel` after the first step and after the last one, by modyn.
struct Ends {
    qvel: [Vec<f64>; 2],
    iterations: f64,
}

/// The settings of MuJoCo in a row of the table.
#[derive(Clone, Copy, PartialEq)]
enum Solver {
    /// Newton's method without a tolerance.
    Solved,
    /// The settings of the MJCF.
    AsDescribed,
}

/// The comparison after a number of steps.
struct Row {
    solver: Solver,
    steps: usize,
    /// The differences of the states that count, in ascending order.
    differences: Vec<f64>,
    /// The number of states with contacts that modyn does not have.
    left_out: usize,
    /// The number of states whose motion leaves all bounds in MuJoCo.
    diverged: usize,
    /// The allowed difference; `None` where none is required.
    allowed: Option<f64>,
}

impl Row {
    fn largest(&self) -> Option<f64> {
        self.differences.last().copied()
    }

    fn median(&self) -> Option<f64> {
        self.differences.get(self.differences.len() / 2).copied()
    }

    /// Returns whether all states that count agree. Infinity agrees with nothing.
    fn agrees(&self) -> bool {
        let Some(allowed) = self.allowed else { return true };
        self.largest().is_none_or(|largest| largest <= allowed)
    }
}

/// The comparison of a scene.
struct Report {
    robot: String,
    version: String,
    timestep: f64,
    velocities: usize,
    shapes: usize,
    /// The number of MuJoCo's contacts in the states.
    contacts: u64,
    /// The largest number of iterations of a step.
    iterations: f64,
    rows: Vec<Row>,
    /// The reasons for differences.
    remarks: Vec<String>,
}

/// Compares, and prints the result.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let description = arguments.robot.open()?;
    let is_mjcf = Format::of(&description.text, &description.name) == Format::Mjcf;
    let Some(path) = description.path.as_ref().filter(|_| is_mjcf) else {
        return Err(Failure::usage(
            "error: `--mujoco` needs the file of an MJCF\n\
             help: `modyn convert ROBOT.urdf -o robot.xml` writes an MJCF",
        ));
    };
    let read = description.read(&arguments.robot.options.read_options());
    let reading = read.map_err(|diagnostics| description.failure(diagnostics))?;
    description.warn(Diagnostics::new(reading.warnings));
    needs_dynamics(&reading.model, "compare")?;
    let mut progress = Progress::start("comparing");
    let report = compare(arguments, &reading.model, path)?;
    progress.stop();
    to_stdout(&if arguments.json { report.as_json() } else { report.as_text(arguments) })?;
    if report.rows.iter().all(Row::agrees) { Ok(()) } else { Err(Failure::Reported) }
}

/// Moves the robot from random states in both programs.
fn compare(
    arguments: &Arguments,
    model: &Model,
    path: &std::path::Path,
) -> Result<Report, Failure> {
    let (process, scene) = Process::start(arguments.python.as_deref(), path)?;
    let joints = Joints::find(model, their_joints(&scene), sizes(&scene))?;
    let actuators = [array(&scene, "actuators").len(), index(&scene["activations"])];
    let is_actuated = actuators == [model.control_names().len(), model.activation_names().len()];
    let inputs = if is_actuated { actuators } else { [0; 2] };
    let starts = starts(arguments, model, &joints.coordinates(&numbers(&scene["start"])), inputs)?;
    let theirs = |Keyframe { q, qd, ctrl, act, .. }: &Keyframe| {
        let zeros = |numbers: &[f64], count| [numbers, &vec![0.0; count - numbers.len()]].concat();
        json!({
            "qpos": joints.qpos(q),
            "qvel": joints.qvel(q, qd),
            "ctrl": zeros(ctrl, actuators[0]),
            "act": zeros(act, actuators[1]),
        })
    };
    let states: Vec<Value> = starts.iter().map(theirs).collect();
    let answer =
        process.ask(&json!({"steps": STEPS, "actuated": is_actuated, "states": states}))?;
    let timestep = scene["timestep"].as_f64().unwrap_or_default();
    let options =
        Options { ground: Ground::Described, limits: Limits::Act, actuators: is_actuated };
    let moved = starts
        .iter()
        .map(|start| motion(model, options, timestep, start, &joints))
        .collect::<Result<Vec<Ends>, Failure>>()?;
    let tolerance = arguments.tolerance.unwrap_or(TOLERANCE);
    let mut rows = Vec::new();
    for (end, steps, factor) in [(0, 1, 1.0), (1, STEPS, MOTION)] {
        for (solver, name) in [(Solver::Solved, "solved"), (Solver::AsDescribed, "as_described")] {
            let allowed = (solver == Solver::Solved).then_some(tolerance * factor);
            let mut row =
                Row { solver, steps, differences: Vec::new(), left_out: 0, diverged: 0, allowed };
            for (ends, their) in moved.iter().zip(array(&answer, name)) {
                row.add(&ends.qvel[end], &their["ends"][end]);
            }
            row.differences.sort_by(f64::total_cmp);
            rows.push(row);
        }
    }
    let solved = array(&answer, "solved");
    let contacts = solved.iter().filter_map(|motion| motion["contacts"].as_u64()).sum();
    let remarks = remarks(model, &scene, &rows, solved, is_actuated);
    Ok(Report {
        robot: model.name().to_owned(),
        version: scene["version"].as_str().unwrap_or_default().to_owned(),
        timestep,
        velocities: model.nv(),
        shapes: model.touching_shapes().len(),
        contacts,
        iterations: moved.iter().map(|ends| ends.iterations).fold(0.0, f64::max),
        rows,
        remarks,
    })
}

/// Returns random states near these coordinates, with random controls.
fn starts(
    arguments: &Arguments,
    model: &Model,
    near: &[f64],
    [controls, activations]: [usize; 2],
) -> Result<Vec<Keyframe>, Failure> {
    let interpreter = Interpreter::<f64>::new(model.clone());
    let mut random = Random::new(arguments.seed);
    let mut start = |i: usize| {
        let mut some = |count, most| (0..count).map(|_| random.symmetric(most)).collect::<Vec<_>>();
        let moved = some(model.nv(), DISPLACEMENTS[i % 2]);
        let mut q = near.to_vec();
        interpreter.integrate(near, &moved, &mut q).map_err(shape)?;
        interpreter.normalize_configuration(&mut q).map_err(shape)?;
        Ok(Keyframe {
            name: String::new(),
            q,
            qd: some(model.nv(), 1.0),
            ctrl: some(controls, 1.0),
            act: some(activations, 1.0),
        })
    };
    (0..arguments.states as usize).map(&mut start).collect()
}

/// Returns the velocities after the first step and after the last one from a state, by modyn.
fn motion(
    model: &Model,
    options: Options,
    timestep: f64,
    start: &Keyframe,
    joints: &Joints<'_>,
) -> Result<Ends, Failure> {
    let mut steps = ContactSteps::new(model, options, &start.q)
        .from_keyframe(start)
        .with_tolerance(SOLVER_TOLERANCE);
    let Keyframe { mut q, mut qd, .. } = start.clone();
    let tau = vec![0.0; qd.len()];
    let mut first = Vec::new();
    let mut iterations = 0.0_f64;
    for k in 0..STEPS {
        let input = TimeStepInput { q: &q, qd: &qd, tau: &tau, dt: timestep };
        let step = steps.step(input).map_err(shape)?;
        [q, qd] = [step.q, step.qd];
        iterations = iterations.max(step.iterations);
        if k == 0 {
            first = joints.qvel(&q, &qd);
        }
    }
    Ok(Ends { qvel: [first, joints.qvel(&q, &qd)], iterations })
}

impl Row {
    /// Adds the velocities of a state by both programs.
    fn add(&mut self, qvel: &[f64], their: &Value) {
        if !array(their, "left_out").is_empty() {
            self.left_out += 1;
        } else if their["qvel"].is_null() {
            self.diverged += 1;
        } else {
            let their = numbers(&their["qvel"]);
            let size = their.iter().fold(1.0_f64, |most, x| most.max(x.abs()));
            let differences = qvel.iter().zip(&their).map(|(x, y)| (x - y).abs() / size);
            // NaN counts as an infinite difference.
            let worst = |most: f64, x: f64| if x <= most { most } else { x };
            let largest = differences.fold(0.0, worst);
            self.differences.push(if largest.is_nan() { f64::INFINITY } else { largest });
        }
    }
}

/// Returns the reasons for differences between the programs.
fn remarks(
    model: &Model,
    scene: &Value,
    rows: &[Row],
    solved: &[Value],
    is_actuated: bool,
) -> Vec<String> {
    let mut remarks = Vec::new();
    let actuators = array(scene, "actuators");
    if !is_actuated {
        remarks.push(format!(
            "modyn reads {} of the {} actuators: both programs move without actuators",
            model.control_names().len(),
            actuators.len()
        ));
    }
    let mut pairs: Vec<String> = Vec::new();
    for pair in solved.iter().flat_map(|motion| array(&motion["ends"][1], "left_out")) {
        let [one, other] = [0, 1].map(|i| sanitize_for_display(pair[i].as_str().unwrap_or("?")));
        pairs.push(format!("`{one}` with `{other}`"));
    }
    pairs.sort();
    pairs.dedup();
    if !pairs.is_empty() {
        let more = match pairs.len().saturating_sub(MAX_PAIRS) {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        pairs.truncate(MAX_PAIRS);
        remarks.push(format!(
            "modyn has contacts of moving links with planes of the world only, and states with other contacts do \
             not count: {}{more}",
            pairs.join(", ")
        ));
    }
    if rows.iter().any(|row| row.diverged > 0) {
        remarks.push("states whose motion leaves all bounds in MuJoCo do not count".into());
    }
    let followers =
        (0..model.moving_links().len()).filter(|&link| model.mimic(link).is_some()).count();
    if followers > 0 {
        remarks.push(format!(
            "{followers} joints follow others exactly in modyn and softly in MuJoCo: with `--mimic independent` \
             they follow softly in both programs"
        ));
    }
    let text = |name: &str| scene[name].as_str().unwrap_or_default().to_owned();
    let integrator = text("integrator");
    if matches!(&*integrator, "RK4" | "IMPLICIT") {
        let replacement = if integrator == "RK4" { "Euler" } else { "implicitfast" };
        remarks.push(format!(
            "the integrator of the MJCF is {integrator}, in place of which modyn has {replacement}; the rows \
             `solved to the end` have {replacement} in both programs"
        ));
    }
    if index(&scene["noslip_iterations"]) > 0 {
        remarks.push(
            "modyn has no `noslip_iterations`; the rows `solved to the end` are without them"
                .into(),
        );
    }
    remarks.push(format!(
        "as described, MuJoCo's solver is {} with at most {} iterations to the tolerance {:e}",
        text("solver"),
        scene["iterations"],
        scene["tolerance"].as_f64().unwrap_or_default()
    ));
    remarks
}

impl Solver {
    fn name(self) -> &'static str {
        match self {
            Self::Solved => "solved to the end",
            Self::AsDescribed => "as described",
        }
    }
}

impl Report {
    fn as_text(&self, arguments: &Arguments) -> String {
        let head = ["MuJoCo's steps", "states", "left out", "median", "largest", "allowed", ""];
        let mut table = Table::new(&head);
        let shown = |x: Option<f64>| x.map_or(String::new(), |x| format!("{x:.1e}"));
        for row in &self.rows {
            let steps =
                if row.steps == 1 { "1 step".into() } else { format!("{} steps", row.steps) };
            table.row([
                format!("{steps}, {}", row.solver.name()),
                row.differences.len().to_string(),
                (row.left_out + row.diverged).to_string(),
                shown(row.median()),
                shown(row.largest()),
                shown(row.allowed),
                if row.agrees() { "" } else { "DIFFERS" }.into(),
            ]);
        }
        let verdict = match self.verdict() {
            Some(true) => "all states that count agree",
            Some(false) => "states differ",
            None => "no state counts",
        };
        let remarks = self.remarks.iter().map(|remark| format!("- {remark}\n"));
        format!(
            "{}: {} states (seed {}) beside MuJoCo {}, time step {} s\n\
             differences of velocities, relative to the largest velocity or 1\n\n{}\n{verdict}\n\n{}",
            sanitize_for_display(&self.robot),
            arguments.states,
            arguments.seed,
            sanitize_for_display(&self.version),
            self.timestep,
            table.right_aligned_from(1).text(),
            remarks.collect::<String>(),
        )
    }

    /// Returns whether the states agree; `None` if none counts.
    fn verdict(&self) -> Option<bool> {
        let counts = self.rows.iter().any(|row| !row.differences.is_empty());
        counts.then(|| self.rows.iter().all(Row::agrees))
    }

    fn as_json(&self) -> String {
        // JSON has no infinity.
        let finite = |x: Option<f64>| x.filter(|x| x.is_finite());
        let row = |row: &Row| {
            json!({
                "steps": row.steps,
                "solver": row.solver.name(),
                "states": row.differences.len(),
                "left_out": row.left_out,
                "diverged": row.diverged,
                "median": finite(row.median()),
                "largest": finite(row.largest()),
                "allowed": row.allowed,
                "agrees": row.agrees(),
            })
        };
        escape::json(&json!({
            "robot": self.robot,
            "mujoco": self.version,
            "timestep": self.timestep,
            "velocities": self.velocities,
            "shapes": self.shapes,
            "contacts": self.contacts,
            "iterations": self.iterations,
            "agrees": self.verdict(),
            "rows": self.rows.iter().map(row).collect::<Value>(),
            "remarks": self.remarks,
        }))
    }
}

/// Returns the joints of the scene.
fn their_joints(scene: &Value) -> Vec<TheirJoint> {
    let joint = |joint: &Value| TheirJoint {
        name: joint[0].as_str().unwrap_or_default().to_owned(),
        kind: joint[1].as_u64().unwrap_or(u64::MAX),
        qpos: index(&joint[2]),
        qvel: index(&joint[3]),
    };
    array(scene, "joints").iter().map(joint).collect()
}

/// Returns the lengths of `qpos` and `qvel`.
fn sizes(scene: &Value) -> [usize; 2] {
    [0, 1].map(|i| index(&scene["sizes"][i]))
}

fn array<'a>(value: &'a Value, name: &str) -> &'a [Value] {
    value[name].as_array().map_or(&[], Vec::as_slice)
}

fn numbers(value: &Value) -> Vec<f64> {
    // A number that is missing agrees with nothing.
    let number = |x: &Value| x.as_f64().unwrap_or(f64::NAN);
    value.as_array().map(|all| all.iter().map(number).collect()).unwrap_or_default()
}

fn index(value: &Value) -> usize {
    value.as_u64().and_then(|x| usize::try_from(x).ok()).unwrap_or(0)
}
