//! The equations of motion of a simulated robot, and one step of them.

use modyn_runtime::equations::constraints::{ConstrainedOutputs, ProjectionOutputs};
use modyn_runtime::equations::{self, ForwardInput, TimeStepInput};
use modyn_runtime::model::{JointFriction, Model};
use modyn_runtime::spatial::{Twist, Wrench};
use modyn_runtime::{ConstraintSettings, ContactTarget, Interpreter, ShapeError};

use super::adaptive;
use super::settings::Settings;
use super::state::State;
use super::torques::Torques;
use crate::command::outcome::Failure;
use crate::contact_steps::{ContactSteps, GroundPoint, Step};
use crate::loops::settings_of;

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
    /// The energy that friction, damping, contacts and joint limits have taken since the start, J.
    pub dissipated: f64,
    /// The points that can touch the ground in the last step; empty without ground or step.
    pub points: Vec<GroundPoint>,
}

impl Sample {
    /// Returns the conserved quantity: the energy, minus the work of the joint forces, plus the
    /// dissipated energy, J.
    pub fn balance(&self) -> f64 {
        self.kinetic + self.potential - self.work + self.dissipated
    }
}

/// The ranks of the constraints of closed loops in one state.
#[derive(Clone, Copy, Default)]
pub struct Ranks {
    /// The rank.
    pub exact: f64,
    /// The number of rows that keep a part of their mobility that is not small.
    pub firm: f64,
}

/// The number of projections of a state. Each doubles the number of correct digits.
const PROJECTIONS: usize = 3;

/// The part of a constraint's mobility below which a row is not firm: near a singular posture.
const FIRM: f64 = 1e-4;

/// The equations of motion.
pub struct Dynamics<'a> {
    pub interpreter: Interpreter<f64>,
    /// The interpreter without friction; `None` if there is no friction.
    smooth: Option<Interpreter<f64>>,
    torques: &'a Torques,
    tau: Vec<f64>,
    /// Steps with the ground or joint limits; `None` if neither acts.
    pub contact_steps: Option<ContactSteps>,
    /// The height of the lowest point above the ground up to now, m; infinite without ground.
    pub lowest: f64,
    /// The largest residual of the solver of steps.
    pub residual: f64,
    /// The points that can touch the ground in the last step.
    points: Vec<GroundPoint>,
    /// The stabilization of the loops.
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

impl<'a> Dynamics<'a> {
    /// Returns the equations of motion under these joint forces, with the ground, the joint limits
    /// and the controls of the settings, for a start at the coordinates `q`.
    pub fn new(
        model: &Model,
        torques: &'a Torques,
        settings: &Settings<'_>,
        q: &[f64],
    ) -> Result<Self, Failure> {
        let without_friction = (model.joint_friction() != JointFriction::None)
            .then(|| model.clone().with_joint_friction(JointFriction::None).map(Interpreter::new));
        let smooth = without_friction.transpose().map_err(|errors| Failure::usage(&errors[0]))?;
        let interpreter = Interpreter::new(model.clone());
        let tau = vec![0.0; model.nv()];
        let count = model.constraints();
        let constraints = (vec![Wrench::zero(); count], vec![Twist::zero(); count]);
        let inactive = vec![false; model.contacts().len()];
        let constraint_settings = settings_of(model);
        let steps = || {
            let steps = ContactSteps::new(model, settings.contacts, q);
            settings.keyframe.into_iter().fold(steps, ContactSteps::from_keyframe)
        };
        Ok(Self {
            interpreter,
            smooth,
            torques,
            tau,
            contact_steps: (!settings.contacts.is_none()).then(steps),
            lowest: f64::INFINITY,
            residual: 0.0,
            points: Vec::new(),
            constraint_settings,
            inactive,
            ranks: Vec::new(),
            usual: 0.0,
            constraints,
        })
    }

    /// Sets the joint forces of this time.
    fn set_torques(&mut self, time: f64) {
        self.torques.at(time, &mut self.tau);
        if let Some(steps) = &self.contact_steps {
            steps.limit(&mut self.tau);
        }
    }

    /// Returns the sample of a state.
    pub fn sample(&mut self, time: f64, state: &State) -> Result<Sample, ShapeError> {
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
            points: self.points.clone(),
        })
    }

    /// Returns the state after one step of the classical Runge-Kutta method; quaternions are scaled
    /// to length 1.
    pub fn step(&mut self, time: f64, dt: f64, state: &State) -> Result<State, ShapeError> {
        let first = self.rates(time, state)?;
        let second = self.rates(time + dt / 2.0, &state.plus(dt / 2.0, &first))?;
        let third = self.rates(time + dt / 2.0, &state.plus(dt / 2.0, &second))?;
        let last = self.rates(time + dt, &state.plus(dt, &third))?;
        let ends = first.plus(1.0, &last);
        let middles = second.plus(1.0, &third);
        let mut next = state.plus(dt / 6.0, &ends).plus(dt / 3.0, &middles);
        self.interpreter.normalize_configuration(&mut next.q)?;
        Ok(next)
    }

    /// Returns the state after one step with the ground and joint limits.
    pub fn contact_step(&mut self, time: f64, dt: f64, state: &State) -> Result<State, ShapeError> {
        self.set_torques(time);
        let State { q, qd, energy: [work, taken] } = state;
        let Some(steps) = &mut self.contact_steps else { return Ok(state.clone()) };
        let Step { q: next_q, qd: next_qd, qdd, tau, points, residual, .. } =
            steps.step(TimeStepInput { q, qd, tau: &self.tau, dt })?;
        self.lowest = points.iter().map(|point| point.gap).fold(self.lowest, f64::min);
        self.residual = self.residual.max(residual);
        self.points = points;
        // The forces on the motion without friction, contacts and limits, which would move the
        // robot in the same way.
        let smooth = self.smooth.as_mut().unwrap_or(&mut self.interpreter);
        let mut forces = vec![0.0; qd.len()];
        smooth.inverse_dynamics(q, qd, &qdd, &mut forces)?;
        let mean: Vec<f64> = qd.iter().zip(&qdd).map(|(v, a)| v + dt / 2.0 * a).collect();
        let done = dt * power(&tau, &mean);
        let energy = [work + done, taken + done - dt * power(&forces, &mean)];
        Ok(State { q: next_q, qd: next_qd, energy })
    }

    /// Returns the rates of a state. Near a singular posture of closed loops the state is projected
    /// onto the loops first: the errors of states within a step would grow there.
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
        if has_loops {
            let (wrenches, residuals) = &mut self.constraints;
            let outputs = ConstrainedOutputs { qdd: &mut rates.qd, wrenches, residuals };
            let input = ForwardInput { q, qd, tau: &self.tau };
            let settings = &self.constraint_settings;
            let robot = &mut self.interpreter;
            let exact =
                robot.constrained_forward_dynamics(input, &self.inactive, settings, outputs)?;
            self.ranks.push(Ranks { exact, firm });
        } else {
            self.interpreter.forward_dynamics(q, qd, &self.tau, &mut rates.qd)?;
        }
        rates.energy = [power(&self.tau, qd), self.friction_power(q, qd)?];
        Ok(rates)
    }

    /// Returns the number of rows of closed loops that keep a part of their mobility that is not
    /// small.
    fn firm_rows(&mut self, State { q, qd, .. }: &State) -> Result<f64, ShapeError> {
        let settings = ConstraintSettings { tolerance: FIRM, ..self.constraint_settings.clone() };
        let outputs = ProjectionOutputs {
            step_q: &mut vec![0.0; qd.len()],
            step_qd: &mut vec![0.0; qd.len()],
        };
        let firm = self.interpreter.project_constraints(
            equations::State { q, qd },
            &self.inactive,
            &settings,
            outputs,
        )?;
        self.usual = self.usual.max(firm);
        Ok(firm)
    }

    /// Returns the power that friction and damping dissipate: their part of inverse dynamics times
    /// the velocities, W.
    fn friction_power(&mut self, q: &[f64], qd: &[f64]) -> Result<f64, ShapeError> {
        let Some(smooth) = &mut self.smooth else { return Ok(0.0) };
        let mut forces = vec![0.0; qd.len()];
        self.interpreter.bias_forces(q, qd, &mut forces)?;
        let all = power(&forces, qd);
        smooth.bias_forces(q, qd, &mut forces)?;
        Ok(all - power(&forces, qd))
    }

    /// Projects a state onto the closed loops. Returns the largest change of a coordinate or
    /// velocity x, relative to 1 + |x|.
    pub fn close(&mut self, state: &mut State) -> Result<f64, ShapeError> {
        let before = state.clone();
        let mut change = [vec![0.0; state.qd.len()], vec![0.0; state.qd.len()]];
        for _ in 0..PROJECTIONS {
            let [step_q, step_qd] = &mut change;
            let settings = &self.constraint_settings;
            let open = equations::State { q: &state.q, qd: &state.qd };
            self.interpreter.project_constraints(
                open,
                &self.inactive,
                settings,
                ProjectionOutputs { step_q, step_qd },
            )?;
            let q = state.q.clone();
            self.interpreter.integrate(&q, step_q, &mut state.q)?;
            state.qd.iter_mut().zip(step_qd).for_each(|(v, d)| *v += *d);
        }
        Ok(adaptive::largest_difference(state, &before, &before))
    }
}

fn power(tau: &[f64], qd: &[f64]) -> f64 {
    tau.iter().zip(qd).map(|(a, b)| a * b).sum()
}
