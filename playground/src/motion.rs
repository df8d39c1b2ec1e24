//! The motion of a robot under gravity: steps of the interpreter.

use modyn_cli::impulses::{
    Impulses, OpenLoop, Options, close_loops, lift_out_of_ground, settings_of,
};
use modyn_codegen::diagnostics::sanitize_for_display;
use modyn_runtime::equations::ForwardInput;
use modyn_runtime::equations::constraints::ConstrainedOutputs;
use modyn_runtime::model::{Limits, Model};
use modyn_runtime::spatial::{Twist, Wrench};
use modyn_runtime::{ConstraintSettings, ContactTarget, Interpreter};

/// The choices of a motion.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MotionOptions {
    /// The coefficient of friction of the ground under the contacts; `None` without ground.
    pub friction: Option<f64>,
    /// Whether joints stop at their limits.
    pub limits: bool,
    /// Whether joints with one coordinate are held where they start, by stops without play.
    pub hold: bool,
}

/// A robot that moves.
pub struct Motion {
    interpreter: Interpreter<f64>,
    impulses: Impulses,
    settings: ConstraintSettings<f64, Vec<ContactTarget<f64>>>,
    /// The coordinates.
    pub q: Vec<f64>,
    /// The velocities.
    pub qd: Vec<f64>,
    /// The time since the start, s.
    pub time: f64,
    /// The force of the ground on each contact in the last step, N, in world axes; empty without
    /// ground.
    pub forces: Vec<[f64; 3]>,
}

impl Motion {
    /// Returns the robot at rest at these coordinates, with its loops closed. A robot that would
    /// start in the ground starts on it.
    ///
    /// # Errors
    ///
    /// If the coordinates do not have the model's length, or a loop cannot be closed from there.
    pub fn new(model: &Model, q: &[f64], options: MotionOptions) -> Result<Self, String> {
        let wrong = |error: &dyn std::fmt::Display| error.to_string();
        let interpreter = Interpreter::<f64>::new(model.clone());
        let mut q = q.to_vec();
        interpreter.normalize(&mut q).map_err(|error| wrong(&error))?;
        if options.friction.is_some() {
            lift_out_of_ground(model, &mut q).map_err(|error| wrong(&error))?;
        }
        let qd = vec![0.0; model.nv()];
        let (q, qd) = close_loops(model, q, qd).map_err(|why| open(model, &why))?;
        // Loops have their own equations, which know neither the ground nor stops.
        let has_loops = !model.loop_constraints().is_empty();
        let unilateral = if has_loops {
            Options::default()
        } else {
            Options { friction: options.friction, limits: options.limits || options.hold }
        };
        let stopped = if options.hold { held(model, &q)? } else { model.clone() };
        Ok(Self {
            impulses: Impulses::new(&stopped, unilateral),
            settings: settings_of(model),
            interpreter,
            q,
            qd,
            time: 0.0,
            forces: Vec::new(),
        })
    }

    /// Makes a step of `dt` seconds by the semi-implicit Euler method.
    ///
    /// # Errors
    ///
    /// If the motion leaves all bounds, which the message says.
    pub fn step(&mut self, dt: f64) -> Result<(), String> {
        let next = self.velocities(dt).map_err(|error| error.to_string())?;
        if !next.iter().all(|x| x.is_finite()) {
            return Err(format!("the motion leaves all bounds at {:.3} s", self.time));
        }
        let moved: Vec<f64> = next.iter().map(|rate| dt * rate).collect();
        let before = std::mem::take(&mut self.q);
        self.q = vec![0.0; before.len()];
        let done = self.interpreter.integrate(&before, &moved, &mut self.q);
        done.map_err(|error| error.to_string())?;
        (self.qd, self.time) = (next, self.time + dt);
        Ok(())
    }

    /// Returns the velocities after a step.
    fn velocities(&mut self, dt: f64) -> Result<Vec<f64>, modyn_runtime::FrameError> {
        let tau = vec![0.0; self.qd.len()];
        let model = self.interpreter.model();
        if model.loop_constraints().is_empty() {
            let Self { q, qd, settings, interpreter, .. } = self;
            let step = self.impulses.step(interpreter, q, qd, &tau, settings, dt)?;
            self.forces = step.forces;
            return Ok(step.qd);
        }
        let constraints = model.constraints();
        let contacts = model.contacts().len();
        let mut qdd = vec![0.0; self.qd.len()];
        let mut wrenches = vec![Wrench::zero(); constraints];
        let mut residuals = vec![Twist::zero(); constraints];
        self.interpreter.constrained_forward_dynamics(
            ForwardInput { q: &self.q, qd: &self.qd, tau: &tau },
            &vec![false; contacts],
            &self.settings,
            ConstrainedOutputs {
                qdd: &mut qdd,
                wrenches: &mut wrenches,
                residuals: &mut residuals,
            },
        )?;
        Ok(self.qd.iter().zip(&qdd).map(|(rate, change)| rate + dt * change).collect())
    }
}

/// Returns the model whose joints with one coordinate have no range but that of their coordinates
/// `q`.
fn held(model: &Model, q: &[f64]) -> Result<Model, String> {
    let mut links = model.links().to_vec();
    for (i, link) in links.iter_mut().enumerate() {
        link.joint.limits = None;
        if link.joint.mimic.is_none() && link.joint.joint_type.nq() == 1 {
            let at = Some(q[model.q_range(i).start]);
            let limits = Limits { lower: at, upper: at, velocity: None, effort: None };
            link.joint.limits = Some(limits);
        }
    }
    let name = model.name();
    let frames = model.frames().to_vec();
    Model::new(name, model.gravity(), links, frames)
        .and_then(|held| held.with_contacts(model.contacts().to_vec()))
        .map_err(|errors| errors.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))
}

/// Returns the message of a loop that is open.
fn open(model: &Model, why: &OpenLoop) -> String {
    match why {
        OpenLoop::Shape(error) => error.to_string(),
        OpenLoop::Constraint(constraint) => format!(
            "the loop of joint `{}` cannot be closed from here: move the joints nearer to a closed loop",
            sanitize_for_display(&model.loop_constraints()[*constraint].name)
        ),
    }
}
