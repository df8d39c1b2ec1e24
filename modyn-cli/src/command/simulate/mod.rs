//! `modyn simulate`: computes a robot's motion as a table, as plots, and as a page with an
//! animation.

mod adaptive;
mod dynamics;
mod motion;
mod plot;
mod settings;
mod state;
mod table;
mod torques;
mod units;
mod walk;

use std::path::PathBuf;

use clap::Args;
use modyn_codegen::ReadOptions;
use modyn_codegen::diagnostics::Diagnostics;
use modyn_codegen::diagnostics::sanitize_for_display;
use modyn_codegen::output::Replaces;
use modyn_runtime::model::{Keyframe, Model};

use crate::command::numbers::numbers;
use crate::command::outcome::{Failure, may_write, to_file, to_stderr, to_stdout};
use crate::command::progress::Progress;
use crate::command::robot::{Robot, needs_dynamics};
use crate::command::view::note_shapes;
use crate::contact_steps::{Ground, Limits, Options, contradictory_limits, put_on_ground};
use crate::viewer::Scene;
use motion::Motion;
use settings::Settings;
use torques::Torques;

/// The time step of a description without one, s.
const TIME_STEP: f64 = 0.001;
/// The largest number of joints that are named in a line.
const MAX_NAMES: usize = 8;
/// The largest numbers of steps and of samples.
const MAX_STEPS: f64 = 1e8;
const MAX_SAMPLES: f64 = 1e6;

/// Simulate a robot in free fall, or under joint forces from a file
///
/// Loops are closed before the start if they are nearly closed, and stay closed. Shapes touch the
/// floor of an MJCF or an SDF, or the plane of `--ground`, by steps of MuJoCo's law, in which joint
/// limits act, too. With `--ground`, points of `--contacts` touch it in place of the shapes. Without
/// `--q`, the lowest shape or point of a floating robot starts on the floor. Other robots fall
/// freely, and their joint limits act with `--limits`. Actuators of such an MJCF and of `--actuators`
/// act, with controls that are zero. With `--key` the robot starts in a keyframe of the MJCF, and its
/// actuators hold the controls of the keyframe. Without `--csv`, `--plot` and `--html` the table is
/// written to standard output.
///
/// The exit code is 1 if the description is rejected or the motion diverges.
#[derive(Args)]
pub struct Arguments {
    /// The duration, s
    #[arg(long, value_name = "S", default_value_t = 2.0, value_parser = positive)]
    time: f64,
    /// The step of the fourth-order Runge-Kutta method, or of steps with contacts and joint limits, s
    /// [default: the `timestep` of an MJCF, else 0.001]
    #[arg(long, value_name = "S", value_parser = positive)]
    step: Option<f64>,
    /// Choose the steps such that each step's error of a coordinate or velocity x is at most this
    /// tolerance times 1 + |x|, by the Runge-Kutta method of Dormand and Prince
    #[arg(
        long,
        value_name = "TOLERANCE",
        value_parser = positive,
        conflicts_with_all = ["step", "ground", "limits", "actuators", "key"],
    )]
    tolerance: Option<f64>,
    /// The time from one row or picture to the next, s; rounded to whole steps
    #[arg(long, value_name = "S", default_value_t = 0.02, value_parser = positive)]
    every: f64,
    /// The initial coordinates, separated by commas [default: zero, and identity quaternions]
    #[arg(long, value_name = "Q", value_parser = list, allow_hyphen_values = true)]
    q: Option<Numbers>,
    /// The initial velocities, separated by commas [default: zero]
    #[arg(long, value_name = "QD", value_parser = list, allow_hyphen_values = true)]
    qd: Option<Numbers>,
    /// Start at random coordinates within the limits
    #[arg(long, value_name = "SEED", conflicts_with = "q")]
    random: Option<u64>,
    /// Start in this keyframe, by steps in which joint limits and actuators act
    #[arg(long, value_name = "NAME", conflicts_with_all = ["q", "qd", "random"])]
    key: Option<String>,
    /// Stop joints softly at their limits, and keep joint forces within the effort limits
    #[arg(long)]
    limits: bool,
    /// A table of joint forces (N m, N): rows of time and forces, interpolated linearly and
    /// constant outside of the table; the first row may name the columns
    #[arg(long, value_name = "FILE.csv")]
    torques: Option<PathBuf>,
    /// Write a table: time, coordinates, velocities, joint forces, energies
    #[arg(long, value_name = "FILE.csv")]
    csv: Option<PathBuf>,
    /// Write plots of these quantities
    #[arg(long, value_name = "FILE.svg")]
    plot: Option<PathBuf>,
    /// Write a page that shows the motion in a browser, with the shapes of the description
    #[arg(long, value_name = "FILE.html")]
    html: Option<PathBuf>,
    #[command(flatten)]
    robot: Robot,
}

/// A list of numbers. (For clap a plain `Vec` is an option that can be repeated.)
#[derive(Clone)]
struct Numbers(Vec<f64>);

/// Simulates, and writes the requested files.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let description = arguments.robot.open()?;
    let given = arguments.robot.options.read_options();
    let options = ReadOptions { shapes: arguments.html.is_some(), ..given.clone() };
    let read = description.read(&options);
    let reading = read.map_err(|diagnostics| description.failure(diagnostics))?;
    let mut inputs = description.inputs(Some(&reading));
    inputs.extend(arguments.torques.clone());
    for path in [&arguments.csv, &arguments.plot, &arguments.html].into_iter().flatten() {
        may_write(path, &inputs, Replaces::Written)?;
    }
    description.warn(Diagnostics::new(reading.warnings));
    let model = reading.model;
    needs_dynamics(&model, "simulate")?;
    let torques = match &arguments.torques {
        Some(path) => Torques::read(path, &model)?,
        None => Torques::none(),
    };
    let settings = arguments.settings(&model)?;
    let (q, qd) = motion::closed(&model, arguments.start(&model)?)?;
    let mut progress = Progress::start("simulating");
    let motion = Motion::simulate(&model, q, qd, &torques, &settings)?;
    progress.stop();
    if let Some(path) = &arguments.csv {
        to_file(path, &table::of(&model, &motion)?, &inputs)?;
    }
    if let Some(path) = &arguments.plot {
        to_file(path, &plot::of(&model, &motion), &inputs)?;
    }
    if let Some(path) = &arguments.html {
        note_shapes(&reading.shapes);
        let mut scene = Scene::new(model.name());
        let robot = scene.robot(model.clone(), reading.shapes);
        scene.motion(motion.shown(&model, robot));
        if let Some(height) = ground_height(&model, settings.contacts.ground) {
            scene.ground(height);
        }
        to_file(path, &scene.page(), &inputs)?;
    }
    if arguments.csv.is_none() && arguments.plot.is_none() && arguments.html.is_none() {
        to_stdout(&table::of(&model, &motion)?)?;
    }
    to_stderr(&summary(&model, &motion, settings.contacts));
    Ok(())
}

impl Arguments {
    fn settings<'a>(&self, model: &'a Model) -> Result<Settings<'a>, Failure> {
        let contacts = self.contacts(model)?;
        let keyframe = self.keyframe(model)?;
        // Steps by a tolerance are within those from one row to the next.
        let step = match self.tolerance {
            Some(_) => self.every,
            None => self.step.or(model.time_step()).unwrap_or(TIME_STEP),
        };
        let steps = (self.time / step).round().max(1.0);
        let every = (self.every / step).round().max(1.0);
        if steps > MAX_STEPS || steps / every > MAX_SAMPLES {
            return Err(Failure::usage(format!(
                "error: {steps:.0} steps and {:.0} rows are too many ({MAX_STEPS:.0} and {MAX_SAMPLES:.0} are \
                 the most): take a larger `--step` or `--every`",
                steps / every
            )));
        }
        let step = self.time / steps;
        let steps = steps as usize;
        let every = every as usize;
        let tolerance = self.tolerance;
        Ok(Settings { step, steps, every, tolerance, contacts, keyframe })
    }

    /// Returns the keyframe that the user names.
    fn keyframe<'a>(&self, model: &'a Model) -> Result<Option<&'a Keyframe>, Failure> {
        let Some(name) = &self.key else { return Ok(None) };
        if let Some(keyframe) = model.keyframe(name) {
            return Ok(Some(keyframe));
        }
        let names: Vec<&str> = model.keyframes().iter().map(|key| key.name.as_str()).collect();
        let help = match names.is_empty() {
            true => "give the start by `--q` and `--qd`".into(),
            false => format!("there are: {}", sanitize_for_display(&names.join(", "))),
        };
        let name = sanitize_for_display(name);
        Err(Failure::usage(format!(
            "error: `--key`: no keyframe has the name `{name}`\nhelp: {help}"
        )))
    }

    /// Returns what the ground, the joint limits and the actuators do.
    fn contacts(&self, model: &Model) -> Result<Options, Failure> {
        if let Some(scene) = Options::of_scene(model) {
            let name = sanitize_for_display(model.name());
            if self.tolerance.is_none() {
                return Ok(scene);
            }
            to_stderr(&format!(
                "note: `{name}` does not touch its floor: steps by a `--tolerance` have no contacts\n"
            ));
        }
        if self.has_ground() && model.contacts().is_empty() {
            return Err(Failure::usage(
                "error: `--ground` needs shapes or points that touch it: describe the `<collision>`s of \
                 links that move, or add `--contacts 'foot: point(LINK)'` for each point"
                    .to_string(),
            ));
        }
        let ground = if self.has_ground() { Ground::Described } else { Ground::None };
        let are_given = !self.robot.options.read_options().actuators.is_empty();
        let has_key = self.key.is_some();
        let actuators = are_given || self.has_ground() || has_key;
        let limits = if self.limits || has_key { Limits::Act } else { Limits::None };
        Ok(Options { ground, limits, actuators })
    }

    /// Returns whether the option `ground` is given.
    fn has_ground(&self) -> bool {
        self.robot.options.read_options().ground.is_some()
    }

    fn start(&self, model: &Model) -> Result<(Vec<f64>, Vec<f64>), Failure> {
        if let Some(Keyframe { q, qd, .. }) = self.keyframe(model)? {
            let zeros = vec![0.0; model.nv()];
            return Ok((q.clone(), if qd.is_empty() { zeros } else { qd.clone() }));
        }
        let given = |name: &str, given: &Option<Numbers>, names: Vec<String>| match given {
            Some(Numbers(numbers)) if numbers.len() != names.len() => Err(Failure::usage(format!(
                "error: `--{name}` must be {} numbers but is {}: {}",
                names.len(),
                numbers.len(),
                sanitize_for_display(&names.join(", "))
            ))),
            Some(Numbers(numbers)) => Ok(Some(numbers.clone())),
            None => Ok(None),
        };
        let q = given("q", &self.q, model.coordinate_names())?;
        let given = given("qd", &self.qd, model.velocity_names())?;
        let qd = given.unwrap_or_else(|| vec![0.0; model.nv()]);
        let touches = self.has_ground() || Options::of_scene(model).is_some();
        let is_placed = q.is_some() || !touches;
        let mut q = motion::place(model, q, self.random)?;
        if !is_placed {
            put_on_ground(model, &mut q)
                .map_err(|error| Failure::usage(format!("error: {error}")))?;
        }
        Ok((q, qd))
    }
}

/// Returns the height of the ground, m, if it is level.
fn ground_height(model: &Model, ground: Ground) -> Option<f64> {
    match ground {
        Ground::None => None,
        Ground::Plane(_) => Some(0.0),
        Ground::Described => {
            let plane = model.step_settings().surfaces.first()?.plane;
            let is_level = plane.rotation[2][2] > 1.0 - 1e-9;
            Some(plane.translation[2]).filter(|height| is_level && height.is_finite())
        }
    }
}

/// Returns the summary of a motion with these contacts and joint limits.
fn summary(model: &Model, motion: &Motion, contacts: Options) -> String {
    let mut out = format!(
        "{}: {} s in {} steps; energy drifts by {:.1e} J, with {:.1e} J kinetic at most\n",
        sanitize_for_display(model.name()),
        motion.samples.last().map_or(0.0, |sample| sample.time),
        motion.steps,
        motion.drift(),
        motion.samples.iter().map(|sample| sample.kinetic).fold(0.0, f64::max),
    );
    if !contacts.is_none() {
        out += &format!(
            "contacts, joint limits and friction take {:.3} J; the forces of a step miss their laws by at most \
             {:.1e} of the weight\n",
            motion.samples.last().map_or(0.0, |sample| sample.dissipated),
            motion.residual
        );
    }
    if motion.lowest.is_finite() {
        out +=
            &format!("the deepest contact is {:.1e} m in the ground\n", (-motion.lowest).max(0.0));
    }
    if let Some(singular) = &motion.singular {
        out += &format!("{singular}; the linkage stays in its assembly\n");
    }
    let (joints, remark) = match contacts.limits != Limits::None {
        true => (
            contradictory_limits(model),
            "mimic joints whose limits contradict their leaders', and are not enforced",
        ),
        false => (motion.beyond_limits(model), "beyond their limits, which are not enforced"),
    };
    if !joints.is_empty() {
        let shown = &joints[..joints.len().min(MAX_NAMES)];
        let more = match joints.len() - shown.len() {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        let shown = sanitize_for_display(&shown.join(", "));
        out += &format!("{remark}: {shown}{more}\n");
    }
    out
}

fn positive(text: &str) -> Result<f64, String> {
    match numbers(text)?.as_slice() {
        &[x] if x > 0.0 => Ok(x),
        _ => Err("expected a number above 0".into()),
    }
}

fn list(text: &str) -> Result<Numbers, String> {
    numbers(text).map(Numbers)
}
