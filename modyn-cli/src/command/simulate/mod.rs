//! `modyn simulate`: how a robot moves, in figures, in plots and on a page to watch.

mod motion;
#[cfg(feature = "plot")]
mod plot;
#[cfg(not(feature = "plot"))]
#[path = "no_plot.rs"]
mod plot;
mod skeleton;
mod table;
mod torques;
mod units;

use std::path::PathBuf;

use clap::Args;
use modyn_codegen::diagnostics::Diagnostics;
use modyn_codegen::diagnostics::sanitize_for_display;
use modyn_runtime::model::Model;

use crate::command::figure::numbers;
use crate::command::outcome::{Failure, to_file, to_stderr, to_stdout};
use crate::command::progress::Progress;
use crate::command::robot::Robot;
use crate::viewer;
use motion::{Motion, Settings};
use torques::Torques;

/// So many joints are named in a line.
const MOST_NAMES: usize = 8;
/// The most steps that are taken, and samples that are kept.
const MOST_STEPS: f64 = 1e8;
const MOST_SAMPLES: f64 = 1e6;

/// Simulate a robot: free fall, or under torques from a file
///
/// Loops stay closed, and are closed before the start if they nearly are. Joint limits are not enforced. Without `--csv`, `--plot` and `--html` the table goes to standard
/// output. Exit code 1 where the description is refused or the motion leaves all bounds.
#[derive(Args)]
pub struct Arguments {
    /// For how long, s
    #[arg(long, value_name = "S", default_value_t = 2.0, value_parser = positive)]
    time: f64,
    /// The step of the Runge-Kutta method of fourth order, s
    #[arg(long, value_name = "S", default_value_t = 0.001, value_parser = positive)]
    step: f64,
    /// From one row or picture to the next, s; in whole steps
    #[arg(long, value_name = "S", default_value_t = 0.02, value_parser = positive)]
    every: f64,
    /// The coordinates at the start, with commas; zero (and no rotation) without it
    #[arg(long, value_name = "Q", value_parser = list, allow_hyphen_values = true)]
    q: Option<Numbers>,
    /// The velocities at the start, with commas; at rest without it
    #[arg(long, value_name = "QD", value_parser = list, allow_hyphen_values = true)]
    qd: Option<Numbers>,
    /// Start at random coordinates within the limits
    #[arg(long, value_name = "SEED", conflicts_with = "q")]
    random: Option<u64>,
    /// Torques (N m, N) over time: rows of time and torques, linear in between, held outside; the first row may name
    /// the columns
    #[arg(long, value_name = "FILE.csv")]
    torques: Option<PathBuf>,
    /// Write the table: time, coordinates, velocities, torques, energies
    #[arg(long, value_name = "FILE.csv")]
    csv: Option<PathBuf>,
    /// Write plots of all of it
    #[arg(long, value_name = "FILE.svg")]
    plot: Option<PathBuf>,
    /// Write a page that moves the robot's skeleton in a browser
    #[arg(long, value_name = "FILE.html")]
    html: Option<PathBuf>,
    #[command(flatten)]
    robot: Robot,
}

/// Clap takes a `Vec` for an option that is given several times.
#[derive(Clone)]
struct Numbers(Vec<f64>);

/// Simulates, and writes what is asked for.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let description = arguments.robot.open()?;
    let reading = description.read(&arguments.robot.options.read_options());
    let reading = reading.map_err(|found| description.failure(found))?;
    description.warn(Diagnostics::new(reading.warnings));
    let model = reading.model;
    let torques = match &arguments.torques {
        Some(path) => Torques::read(path, &model)?,
        None => Torques::none(),
    };
    let settings = arguments.settings()?;
    let (q, qd) = motion::closed(&model, arguments.start(&model)?)?;
    let mut progress = Progress::start("simulating");
    let motion = Motion::simulate(&model, (q, qd), &torques, &settings)?;
    progress.stop();
    if let Some(path) = &arguments.csv {
        to_file(path, &table::of(&model, &motion)?)?;
    }
    if let Some(path) = &arguments.plot {
        to_file(path, &plot::of(&model, &motion)?)?;
    }
    if let Some(path) = &arguments.html {
        let skeleton = skeleton::of(&model, &motion)?;
        to_file(path, &viewer::page(model.name(), &skeleton.edges, &skeleton.frames))?;
    }
    if arguments.csv.is_none() && arguments.plot.is_none() && arguments.html.is_none() {
        to_stdout(&table::of(&model, &motion)?)?;
    }
    to_stderr(&summary(&model, &motion));
    Ok(())
}

impl Arguments {
    fn settings(&self) -> Result<Settings, Failure> {
        let steps = (self.time / self.step).round().max(1.0);
        let every = (self.every / self.step).round().max(1.0);
        if steps > MOST_STEPS || steps / every > MOST_SAMPLES {
            return Err(Failure::usage(format!(
                "error: {steps:.0} steps and {:.0} rows are too many ({MOST_STEPS:.0} and {MOST_SAMPLES:.0} are \
                 the most): take a larger `--step` or `--every`",
                steps / every
            )));
        }
        let step = self.time / steps;
        Ok(Settings { step, steps: steps as usize, every: every as usize })
    }

    fn start(&self, model: &Model) -> Result<(Vec<f64>, Vec<f64>), Failure> {
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
        let qd = given("qd", &self.qd, model.velocity_names())?;
        let qd = qd.unwrap_or_else(|| vec![0.0; model.nv()]);
        Ok((motion::place(model, q, self.random)?, qd))
    }
}

/// What a user wants to know first.
fn summary(model: &Model, motion: &Motion) -> String {
    let mut out = format!(
        "{}: {} s in {} steps; energy drifts by {:.1e} J, with {:.1e} J kinetic at most\n",
        sanitize_for_display(model.name()),
        motion.samples.last().map_or(0.0, |sample| sample.time),
        motion.steps,
        motion.drift(),
        motion.samples.iter().map(|sample| sample.kinetic).fold(0.0, f64::max),
    );
    let beyond = motion.beyond_limits(model);
    if !beyond.is_empty() {
        let shown = &beyond[..beyond.len().min(MOST_NAMES)];
        let more = match beyond.len() - shown.len() {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        let shown = sanitize_for_display(&shown.join(", "));
        out += &format!("beyond their limits, which are not enforced: {shown}{more}\n");
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
