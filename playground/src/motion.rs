//! The motion of a robot under gravity: steps of the interpreter.

use modyn_cli::contact_steps::{
    ContactSteps, Ground, GroundPoint, Limits, Options, Step, lift_out_of_ground,
};
use modyn_cli::loops::{OpenLoop, close_loops};
use modyn_codegen::diagnostics::sanitize_for_display;
use modyn_runtime::Interpreter;
use modyn_runtime::equations::TimeStepInput;
use modyn_runtime::model::Model;

/// The choices of a motion.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MotionOptions {
    /// The coefficient of friction of the ground under the contacts; `None` without ground.
    pub friction: Option<f64>,
    /// Whether joints stop at their limits.
    pub limits: bool,
    /// Whether joints with one coordinate are held where they start, by firm limits without play.
    pub hold: bool,
}

/// A robot that moves.
pub struct Motion {
    steps: ContactSteps,
    /// The coordinates.
    pub q: Vec<f64>,
    /// The velocities.
    pub qd: Vec<f64>,
    /// The time since the start, s.
    pub time: f64,
    /// The points that can touch the ground in the last step; empty without ground.
    pub points: Vec<GroundPoint>,
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
        interpreter.normalize_configuration(&mut q).map_err(|error| wrong(&error))?;
        if options.friction.is_some() {
            lift_out_of_ground(model, &mut q).map_err(|error| wrong(&error))?;
        }
        let qd = vec![0.0; model.nv()];
        let (q, qd) = close_loops(model, q, qd).map_err(|why| open(model, &why))?;
        let ground = match options.friction {
            _ if Options::of_scene(model).is_some() => Ground::Described,
            Some(friction) => Ground::Plane(friction),
            None => Ground::None,
        };
        let limits = match options {
            MotionOptions { hold: true, .. } => Limits::Hold,
            MotionOptions { limits: true, .. } => Limits::Act,
            _ => Limits::None,
        };
        let actuators = ground == Ground::Described;
        Ok(Self {
            steps: ContactSteps::new(model, Options { ground, limits, actuators }, &q),
            q,
            qd,
            time: 0.0,
            points: Vec::new(),
        })
    }

    /// Makes a step of `dt` seconds.
    ///
    /// # Errors
    ///
    /// If the motion leaves all bounds, which the message says.
    pub fn step(&mut self, dt: f64) -> Result<(), String> {
        let tau = vec![0.0; self.qd.len()];
        let start = TimeStepInput { q: &self.q, qd: &self.qd, tau: &tau, dt };
        let Step { q, qd, points, .. } =
            self.steps.step(start).map_err(|error| error.to_string())?;
        if !q.iter().chain(&qd).all(|x| x.is_finite()) {
            return Err(format!("the motion leaves all bounds at {:.3} s", self.time));
        }
        (self.q, self.qd, self.points, self.time) = (q, qd, points, self.time + dt);
        Ok(())
    }
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
