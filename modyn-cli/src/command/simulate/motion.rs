//! The motion of a robot: Runge-Kutta steps of the interpreter's forward dynamics.
//!
//! `modyn::simulate` has such steps for generated robots, whose states are arrays. Here sizes are
//! known at run time only, and the work of joint forces and friction is integrated, too.

use modyn_codegen::diagnostics::sanitize_for_display;
use modyn_runtime::model::Model;
use modyn_runtime::{Interpreter, ShapeError};

use super::dynamics::{Dynamics, Sample};
use super::settings::Settings;
use super::state::State;
use super::torques::Torques;
use super::walk::{Lengths, Singular, Walk};
use crate::command::outcome::Failure;
use crate::contact_steps::GroundPoint;
use crate::loops::{OpenLoop, close_loops};
use crate::random::Random;
use crate::viewer;

/// The samples of a motion.
pub struct Motion {
    pub samples: Vec<Sample>,
    pub steps: usize,
    /// The height of the lowest point above the ground, m; infinite without ground.
    pub lowest: f64,
    /// The largest residual of the solver of steps.
    pub residual: f64,
    /// The first singular posture that the loops pass.
    pub singular: Option<Singular>,
}

impl Motion {
    /// Returns the motion from these coordinates and velocities on.
    pub fn simulate(
        model: &Model,
        q: Vec<f64>,
        qd: Vec<f64>,
        torques: &Torques,
        settings: &Settings<'_>,
    ) -> Result<Self, Failure> {
        let shape = |error: ShapeError| Failure::usage(format!("error: {error}"));
        let mut dynamics = Dynamics::new(model, torques, settings, &q)?;
        let mut state = State { q, qd, energy: [0.0; 2] };
        let mut samples = vec![dynamics.sample(0.0, &state).map_err(shape)?];
        let lengths = Lengths {
            tolerance: settings.tolerance,
            first: if settings.tolerance.is_some() { 0.1 * settings.step } else { settings.step },
            longest: settings.step * settings.every as f64,
        };
        let mut walk = Walk::new(state.clone(), lengths);
        for i in 1..=settings.steps {
            let time = settings.step * i as f64;
            state = if dynamics.contact_steps.is_none() {
                walk.state_at(time, &mut dynamics)?
            } else {
                let before = settings.step * (i - 1) as f64;
                dynamics.contact_step(before, settings.step, &state).map_err(shape)?
            };
            if !state.q.iter().chain(&state.qd).all(|x| x.is_finite()) {
                let singular = walk.singular.map_or(String::new(), |[_, last]| format!("; {last}"));
                return Err(Failure::Negative(format!(
                    "error: the motion leaves all bounds at {time:.4} s: take a smaller `--step`, or \
                     smaller torques{singular}"
                )));
            }
            if i % settings.every == 0 || i == settings.steps {
                samples.push(dynamics.sample(time, &state).map_err(shape)?);
            }
        }
        let steps = if dynamics.contact_steps.is_none() { walk.steps } else { settings.steps };
        let Dynamics { lowest, residual, .. } = dynamics;
        Ok(Self {
            samples,
            steps,
            lowest,
            residual,
            singular: walk.singular.map(|[first, _]| first),
        })
    }

    /// Returns the motion of the robot of this index for the viewer.
    pub fn shown(&self, model: &Model, robot: usize) -> viewer::Motion {
        let numbers = |sample: &Sample| {
            let points: Vec<[f64; 6]> = sample.points.iter().map(GroundPoint::numbers).collect();
            points
        };
        // At the start there was no step: its points have no forces.
        let start = self.samples.get(1).map(|sample| {
            let points = sample.points.iter();
            points.map(|point| GroundPoint { force: [0.0; 3], ..*point }.numbers()).collect()
        });
        let has_ground = self.lowest.is_finite();
        let forces = || start.into_iter().chain(self.samples.iter().skip(1).map(numbers)).collect();
        viewer::Motion {
            name: model.name().to_owned(),
            robot,
            times: self.samples.iter().map(|sample| sample.time).collect(),
            coordinates: self.samples.iter().map(|sample| sample.q.clone()).collect(),
            forces: has_ground.then(forces),
        }
    }

    /// Returns the largest change of the conserved quantity, J.
    pub fn drift(&self) -> f64 {
        let start = self.samples.first().map_or(0.0, Sample::balance);
        self.samples.iter().map(|s| (s.balance() - start).abs()).fold(0.0, f64::max)
    }

    /// Returns the names of the joints, mimic joints included, that exceeded their limits.
    pub fn beyond_limits(&self, model: &Model) -> Vec<String> {
        let beyond = |&link: &usize| {
            let Some(limits) = &model.moving_links()[link].joint.limits else { return false };
            let ratio = model.mimic(link).map_or((1.0, 0.0), |m| (m.multiplier, m.offset));
            let range = model.q_range(link);
            self.samples.iter().flat_map(|sample| &sample.q[range.clone()]).any(|&q| {
                let q = ratio.0 * q + ratio.1;
                limits.lower.is_some_and(|lower| q < lower - 1e-9)
                    || limits.upper.is_some_and(|upper| q > upper + 1e-9)
            })
        };
        (0..model.moving_links().len())
            .filter(beyond)
            .map(|link| model.moving_links()[link].joint.name.clone())
            .collect()
    }
}

/// Returns the initial coordinates: given, random, or neutral.
pub fn place(
    model: &Model,
    given: Option<Vec<f64>>,
    seed: Option<u64>,
) -> Result<Vec<f64>, Failure> {
    let interpreter = Interpreter::<f64>::new(model.clone());
    let mut q = vec![0.0; model.nq()];
    let done = match (given, seed) {
        (Some(given), _) => {
            q = given;
            interpreter.normalize_configuration(&mut q)
        }
        (None, Some(seed)) => {
            let mut random = Random::new(seed);
            interpreter.random_configuration(|| random.uniform(), &mut q)
        }
        (None, None) => interpreter.neutral(&mut q),
    };
    done.map(|()| q).map_err(|error| Failure::usage(format!("error: {error}")))
}

/// Returns the coordinates and velocities with the loops closed, or the reason why they cannot be
/// closed.
pub fn closed(model: &Model, state: (Vec<f64>, Vec<f64>)) -> Result<(Vec<f64>, Vec<f64>), Failure> {
    let (q, qd) = state;
    match close_loops(model, q, qd) {
        Ok(state) => Ok(state),
        Err(OpenLoop::Shape(error)) => Err(Failure::usage(format!("error: {error}"))),
        Err(OpenLoop::Constraint(constraint)) => Err(Failure::Negative(format!(
            "error: the loop of joint `{}` cannot be closed from where the robot starts: give coordinates near \
             closed ones by `--q`, or others by `--random`",
            sanitize_for_display(&model.loop_constraints()[constraint].name)
        ))),
    }
}
