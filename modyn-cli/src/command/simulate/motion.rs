//! The motion of a robot: Runge-Kutta steps of the interpreter's forward dynamics.
//!
//! `modyn::simulate` has such steps for generated robots, whose states are arrays. Here sizes are known at run time only,
//! and the work of joint forces and friction is integrated, too.

use modyn_codegen::diagnostics::sanitize_for_display;
use modyn_runtime::model::{Friction, Model};
use modyn_runtime::simulate::Residual;
use modyn_runtime::spatial::{Twist, Wrench};
use modyn_runtime::{ConstraintSettings, ContactTarget, FrameError, Interpreter, ShapeError};

use super::state::State;
use super::torques::Torques;
use super::walk::{Lengths, Ranks, Singular, Walk};
use crate::command::outcome::Failure;
use crate::impulses::{Impulses, OpenLoop, Options, close_loops, settings_of};
use crate::random::Random;
use crate::viewer;

/// The settings of the integration.
pub struct Settings {
    /// The time step, s.
    pub step: f64,
    /// The number of steps.
    pub steps: usize,
    /// The number of steps from one sample to the next.
    pub every: usize,
    /// The largest error of a step, relative to 1 + |x|; steps are then divided until they keep it.
    pub tolerance: Option<f64>,
    /// The ground and the joint limits; with them steps are of first order.
    pub unilateral: Options,
}

/// The state of a robot at an instant, and its energies.
#[derive(Clone)]
pub struct Sample {
    pub time: f64,
    pub q: Vec<f64>,
    pub qd: Vec<f64>,
    pub tau: Vec<f64>,
    pub kinetic: f64,
    pub potential: f64,
    /// The work of the joint forces since the start, J.
    pub work: f64,
    /// The energy dissipated by friction, damping, impacts and joint stops since the start, J.
    pub dissipated: f64,
    /// The force of the ground on each contact in the last step, N, in world axes; empty without ground or step.
    pub forces: Vec<[f64; 3]>,
}

impl Sample {
    /// Returns the conserved quantity: the energy, minus the work of the joint forces, plus the dissipated energy, J.
    pub fn balance(&self) -> f64 {
        self.kinetic + self.potential - self.work + self.dissipated
    }
}

/// The samples of a motion.
pub struct Motion {
    pub samples: Vec<Sample>,
    pub steps: usize,
    /// The height of the lowest contact above the ground, m; infinite without ground.
    pub lowest: f64,
    /// The largest velocities that the impulses of a step left wrong.
    pub residual: Residual,
    /// The first singular posture that the loops pass.
    pub singular: Option<Singular>,
}

/// The part of a constraint's mobility below which a row is not firm: near a singular posture.
const FIRM: f64 = 1e-4;

/// The equations of motion.
pub struct Dynamics<'a> {
    pub interpreter: Interpreter<f64>,
    /// The interpreter without friction; `None` if there is no friction.
    smooth: Option<Interpreter<f64>>,
    torques: &'a Torques,
    tau: Vec<f64>,
    impulses: Impulses,
    lowest: f64,
    residual: Residual,
    /// The forces of the ground in the last step.
    forces: Vec<[f64; 3]>,
    /// The stabilization of the loops, and the ground under the contacts.
    pub constraint_settings: ConstraintSettings<f64, Vec<ContactTarget<f64>>>,
    /// For each contact whether it is active: none is.
    pub inactive: Vec<bool>,
    /// The ranks of the loops in the states of the last evaluations.
    pub ranks: Vec<Ranks>,
    /// The largest number of firm rows of the loops up to now.
    pub usual: f64,
    /// The wrench and the residual of each constraint.
    constraints: (Vec<Wrench<f64>>, Vec<Twist<f64>>),
}

impl Motion {
    /// Returns the motion from these coordinates and velocities on.
    pub fn simulate(
        model: &Model,
        (q, qd): (Vec<f64>, Vec<f64>),
        torques: &Torques,
        settings: &Settings,
    ) -> Result<Self, Failure> {
        let shape = |error: ShapeError| Failure::usage(format!("error: {error}"));
        let smooth = (model.friction() != Friction::None)
            .then(|| model.clone().with_friction(Friction::None).map(Interpreter::new));
        let smooth = smooth.transpose().map_err(|errors| Failure::usage(&errors[0]))?;
        let interpreter = Interpreter::new(model.clone());
        let tau = vec![0.0; model.nv()];
        let count = model.constraints();
        let constraints = (vec![Wrench::zero(); count], vec![Twist::zero(); count]);
        let inactive = vec![false; model.contacts().len()];
        let constraint_settings = settings_of(model);
        let mut dynamics = Dynamics {
            interpreter,
            smooth,
            torques,
            tau,
            impulses: Impulses::new(model, settings.unilateral),
            lowest: f64::INFINITY,
            residual: Residual { contacts: 0.0, stops: 0.0 },
            forces: Vec::new(),
            constraint_settings,
            inactive,
            ranks: Vec::new(),
            usual: 0.0,
            constraints,
        };
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
            state = if dynamics.impulses.is_none() {
                walk.state_at(time, &mut dynamics)?
            } else {
                let before = settings.step * (i - 1) as f64;
                let next = dynamics.impulse_step(before, settings.step, &state);
                next.map_err(|error| Failure::usage(format!("error: {error}")))?
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
        let steps = if dynamics.impulses.is_none() { walk.steps } else { settings.steps };
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
        let count = model.contacts().len();
        // At the start there was no step.
        let forces = |sample: &Sample| match sample.forces.len() {
            0 => vec![[0.0; 3]; count],
            _ => sample.forces.clone(),
        };
        let has_ground = self.lowest.is_finite();
        viewer::Motion {
            name: model.name().to_owned(),
            robot,
            times: self.samples.iter().map(|sample| sample.time).collect(),
            coordinates: self.samples.iter().map(|sample| sample.q.clone()).collect(),
            forces: has_ground.then(|| self.samples.iter().map(forces).collect()),
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
            let Some(limits) = &model.links()[link].joint.limits else { return false };
            let ratio = model.mimic(link).map_or((1.0, 0.0), |m| (m.multiplier, m.offset));
            let range = model.q_range(link);
            self.samples.iter().flat_map(|sample| &sample.q[range.clone()]).any(|&q| {
                let q = ratio.0 * q + ratio.1;
                limits.lower.is_some_and(|lower| q < lower - 1e-9)
                    || limits.upper.is_some_and(|upper| q > upper + 1e-9)
            })
        };
        (0..model.links().len())
            .filter(beyond)
            .map(|link| model.links()[link].joint.name.clone())
            .collect()
    }
}

impl Dynamics<'_> {
    /// Sets the joint forces to those of this time.
    fn set_torques(&mut self, time: f64) {
        self.torques.at(time, &mut self.tau);
        self.impulses.limit(&mut self.tau);
    }

    fn sample(&mut self, time: f64, state: &State) -> Result<Sample, ShapeError> {
        self.set_torques(time);
        let State { q, qd, energy: [work, dissipated] } = state.clone();
        Ok(Sample {
            time,
            kinetic: self.interpreter.kinetic_energy(&q, &qd)?,
            potential: self.interpreter.potential_energy(&q)?,
            tau: self.tau.clone(),
            q,
            qd,
            work,
            dissipated,
            forces: self.forces.clone(),
        })
    }

    /// Returns the state after one step of the classical Runge-Kutta method; quaternions are scaled to length 1.
    pub fn step(&mut self, time: f64, dt: f64, state: &State) -> Result<State, ShapeError> {
        let first = self.rates(time, state)?;
        let second = self.rates(time + dt / 2.0, &state.plus(dt / 2.0, &first))?;
        let third = self.rates(time + dt / 2.0, &state.plus(dt / 2.0, &second))?;
        let last = self.rates(time + dt, &state.plus(dt, &third))?;
        let (ends, middles) = (first.plus(1.0, &last), second.plus(1.0, &third));
        let mut next = state.plus(dt / 6.0, &ends).plus(dt / 3.0, &middles);
        self.interpreter.normalize(&mut next.q)?;
        Ok(next)
    }

    /// Returns the state after one step of the semi-implicit Euler method with the impulses of the ground and of joint
    /// stops.
    fn impulse_step(&mut self, time: f64, dt: f64, state: &State) -> Result<State, FrameError> {
        self.set_torques(time);
        let State { q, qd, energy: [work, dissipated] } = state;
        let motion = (&**q, &**qd, &*self.tau);
        let settings = &self.constraint_settings;
        let step = self.impulses.step(&mut self.interpreter, motion, settings, dt)?;
        self.lowest = self.lowest.min(step.lowest);
        self.residual = self.residual.max(step.residual);
        self.forces = step.forces;
        let mut next = State { q: vec![0.0; q.len()], qd: step.qd, energy: [0.0; 2] };
        let moved: Vec<f64> = next.qd.iter().map(|rate| dt * rate).collect();
        self.interpreter.integrate(q, &moved, &mut next.q)?;
        let friction = self.friction_power(q, qd)?;
        let power = (power(&self.tau, qd) + power(&self.tau, &next.qd)) / 2.0;
        next.energy = [work + dt * power, dissipated + dt * friction + step.dissipated];
        Ok(next)
    }

    /// Returns the rates of a state. Near a singular posture of closed loops they are those of the state with the loops closed: the
    /// errors of states within a step would grow there.
    pub fn rates(&mut self, time: f64, state: &State) -> Result<State, ShapeError> {
        self.set_torques(time);
        let has_loops = self.constraints.0.len() != self.inactive.len();
        let mut closed = state.clone();
        let firm = if has_loops { self.firm_rows(state)? } else { 0.0 };
        if firm < self.usual {
            self.close(&mut closed)?;
        }
        let State { q, qd, .. } = &closed;
        let mut rates = State { q: vec![0.0; q.len()], qd: vec![0.0; qd.len()], energy: [0.0; 2] };
        self.interpreter.velocity_to_qdot(q, qd, &mut rates.q)?;
        let into = (&mut *rates.qd, &mut *self.constraints.0, &mut *self.constraints.1);
        if has_loops {
            let state = (q.as_slice(), qd.as_slice(), self.tau.as_slice());
            let settings = &self.constraint_settings;
            let robot = &mut self.interpreter;
            let exact =
                robot.constrained_forward_dynamics(state, &self.inactive, settings, into)?;
            self.ranks.push(Ranks { exact, firm });
        } else {
            self.interpreter.forward_dynamics(q, qd, &self.tau, into.0)?;
        }
        rates.energy = [power(&self.tau, qd), self.friction_power(q, qd)?];
        Ok(rates)
    }

    /// Returns the number of rows of closed loops that keep a part of their mobility that is not small.
    fn firm_rows(&mut self, State { q, qd, .. }: &State) -> Result<f64, ShapeError> {
        let settings = ConstraintSettings { tolerance: FIRM, ..self.constraint_settings.clone() };
        let into = (&mut *vec![0.0; qd.len()], &mut *vec![0.0; qd.len()]);
        let firm =
            self.interpreter.project_constraints((q, qd), &self.inactive, &settings, into)?;
        self.usual = self.usual.max(firm);
        Ok(firm)
    }

    /// Returns the power that friction and damping dissipate: their part of inverse dynamics times the velocities, W.
    fn friction_power(&mut self, q: &[f64], qd: &[f64]) -> Result<f64, ShapeError> {
        let Some(smooth) = &mut self.smooth else { return Ok(0.0) };
        let (mut with, mut without) = (vec![0.0; qd.len()], vec![0.0; qd.len()]);
        self.interpreter.bias_forces(q, qd, &mut with)?;
        smooth.bias_forces(q, qd, &mut without)?;
        Ok(power(&with, qd) - power(&without, qd))
    }
}

fn power(tau: &[f64], qd: &[f64]) -> f64 {
    tau.iter().zip(qd).map(|(a, b)| a * b).sum()
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
            interpreter.normalize(&mut q)
        }
        (None, Some(seed)) => {
            let mut random = Random::new(seed);
            interpreter.random(|| random.uniform(), &mut q)
        }
        (None, None) => interpreter.neutral(&mut q),
    };
    done.map(|()| q).map_err(|error| Failure::usage(format!("error: {error}")))
}

/// Returns the coordinates and velocities with the loops closed, or the reason why they cannot be closed.
pub fn closed(model: &Model, state: (Vec<f64>, Vec<f64>)) -> Result<(Vec<f64>, Vec<f64>), Failure> {
    match close_loops(model, state) {
        Ok(state) => Ok(state),
        Err(OpenLoop::Shape(error)) => Err(Failure::usage(format!("error: {error}"))),
        Err(OpenLoop::Constraint(constraint)) => Err(Failure::Negative(format!(
            "error: the loop of joint `{}` cannot be closed from where the robot starts: give coordinates near \
             closed ones by `--q`, or others by `--random`",
            sanitize_for_display(&model.loop_constraints()[constraint].name)
        ))),
    }
}
