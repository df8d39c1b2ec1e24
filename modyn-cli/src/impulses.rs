//! Steps of robots that are known at run time, with impulses: of the ground under the contacts, and
//! of joints that stop at their limits.
//!
//! `modyn::simulate::State::step_on_ground` is the same step for generated robots.

use modyn_runtime::equations::State;
use modyn_runtime::equations::constraints::{ProjectionOutputs, ResidualOutputs};
use modyn_runtime::joint::JointType;
use modyn_runtime::model::Model;
use modyn_runtime::quantities::Function;
use modyn_runtime::simulate::by_numbers::GroundRobot;
use modyn_runtime::simulate::{Ground, Residual};
use modyn_runtime::spatial::Twist;
use modyn_runtime::{ConstraintSettings, ContactTarget, FrameError, Interpreter, ShapeError};

use crate::random::Random;

/// The unilateral constraints of a motion.
#[derive(Clone, Copy, Default)]
pub struct Options {
    /// The coefficient of friction of the ground, on which all contacts act; `None` without ground.
    pub friction: Option<f64>,
    /// Whether joints stop at their limits and joint forces stay within the effort limits.
    pub limits: bool,
}

impl Options {
    /// Returns whether there are no unilateral constraints.
    #[must_use]
    pub fn is_none(self) -> bool {
        self.friction.is_none() && !self.limits
    }
}

/// Returns the names of the mimic joints whose limits contradict the limits of their leaders.
/// Limits that contradict are not enforced.
#[must_use]
pub fn contradictory_limits(model: &Model) -> Vec<String> {
    let contradicts = |&link: &usize| {
        let joint = &model.links()[link].joint;
        let Some(limits) = &joint.limits else { return false };
        let Some(mimic) = model.mimic(link) else { return false };
        model.coordinate_range(link).iter().any(|q| {
            let q = mimic.multiplier * q + mimic.offset;
            limits.lower.is_some_and(|lower| q < lower - 1e-9)
                || limits.upper.is_some_and(|upper| q > upper + 1e-9)
        })
    };
    let links = (0..model.links().len()).filter(contradicts);
    links.map(|link| model.links()[link].joint.name.clone()).collect()
}

/// The unilateral constraints of a robot.
pub struct Impulses {
    options: Options,
    robot: GroundRobot,
    /// The velocity of each joint with an effort limit, and the limit, N m or N.
    efforts: Vec<(usize, f64)>,
    /// The impulses of the last step, of contacts and of stops.
    last: [Vec<f64>; 2],
}

/// The results of a step besides the coordinates.
pub struct Step {
    /// The velocities.
    pub qd: Vec<f64>,
    /// The energy that the impulses take, J.
    pub dissipated: f64,
    /// The height of the lowest contact above the ground before the step, m; infinite for a robot
    /// without contacts.
    pub lowest: f64,
    /// The velocities that are wrong.
    pub residual: Residual,
    /// The mean force of the ground on each contact, N, in world axes.
    pub forces: Vec<[f64; 3]>,
}

impl Impulses {
    /// Returns the constraints of a model, before a first step.
    #[must_use]
    pub fn new(model: &Model, options: Options) -> Self {
        let effort = |link: usize| {
            let joint = &model.links()[link].joint;
            let v = model.v_range(link);
            let is_own = joint.mimic.is_none() && v.len() == 1;
            Some((v.start, joint.limits.as_ref()?.effort?)).filter(|_| is_own)
        };
        let joints = 0..if options.limits { model.links().len() } else { 0 };
        let whole = GroundRobot::new(model, options.limits);
        // Without ground no contact takes part.
        let robot = if options.friction.is_some() { whole } else { whole.without_contacts() };
        let last = [3 * robot.contacts(), model.nv()].map(|count| vec![0.0; count]);
        Self { options, robot, efforts: joints.filter_map(effort).collect(), last }
    }

    /// Returns whether there are no unilateral constraints.
    #[must_use]
    pub fn is_none(&self) -> bool {
        self.options.is_none()
    }

    /// Reduces joint forces to the effort limits.
    pub fn limit(&self, tau: &mut [f64]) {
        for &(velocity, effort) in &self.efforts {
            tau[velocity] = tau[velocity].clamp(-effort, effort);
        }
    }

    /// Returns the velocities after a step of `dt` seconds from this state on under these joint
    /// forces (N m, N).
    ///
    /// # Errors
    ///
    /// If a length is not that of the interpreter's model.
    pub fn step(
        &mut self,
        interpreter: &mut Interpreter<f64>,
        q: &[f64],
        qd: &[f64],
        tau: &[f64],
        settings: &ConstraintSettings<f64, Vec<ContactTarget<f64>>>,
        dt: f64,
    ) -> Result<Step, FrameError> {
        let model = interpreter.model();
        let mut problem = vec![0.0; GroundRobot::new(model, false).problem_length()];
        let target_numbers = settings.contacts.iter().flat_map(ContactTarget::numbers);
        let numbers: Vec<f64> = settings.numbers().into_iter().chain(target_numbers).collect();
        let arguments = [q, qd, tau, &[dt], &numbers];
        interpreter.evaluate(Function::ContactProblem, &arguments, 0, &mut problem)?;
        let factors = interpreter.brge(q)?;
        let friction = self.options.friction.unwrap_or_default();
        let targets = settings.contacts[..self.robot.contacts()].iter();
        let contacts: Vec<ContactTarget<f64>> =
            targets.map(|target| ContactTarget { friction, ..*target }).collect();
        let settings = ConstraintSettings::from_numbers(settings.numbers(), contacts);
        let mut next = vec![0.0; qd.len()];
        let [of_contacts, of_stops] = &mut self.last;
        let (residual, _) = self.robot.solve(
            &Ground::default(),
            (q, dt, &settings),
            (|i| problem[i], |inverse| inverse.copy_from_slice(&factors.inverse())),
            (of_contacts, of_stops),
            &mut next,
        );
        let (free, heights) = problem.split_at(qd.len());
        let energies =
            [interpreter.kinetic_energy(q, free)?, interpreter.kinetic_energy(q, &next)?];
        let heights = heights[..settings.contacts.len()].iter();
        let lowest = heights.copied().fold(f64::INFINITY, f64::min);
        let impulses = of_contacts.as_chunks::<3>().0;
        // Impulses are along the axes of the targets.
        let forces = settings.contacts.iter().zip(impulses);
        let in_world = forces.map(|(target, p)| target.pose.rotate(p.map(|x| x / dt)));
        let forces = in_world.collect();
        Ok(Step { qd: next, dissipated: energies[0] - energies[1], lowest, residual, forces })
    }
}

/// Moves each floating base such that the lowest contact that it carries is on the ground, the
/// plane z = 0.
///
/// # Errors
///
/// If `q` does not have the model's length.
pub fn put_on_ground(model: &Model, q: &mut [f64]) -> Result<(), ShapeError> {
    move_to_ground(model, q, |_| true)
}

/// Lifts each floating base whose contacts are in the ground, the plane z = 0, such that the lowest
/// one is on it.
///
/// # Errors
///
/// If `q` does not have the model's length.
pub fn lift_out_of_ground(model: &Model, q: &mut [f64]) -> Result<(), ShapeError> {
    move_to_ground(model, q, |lowest| lowest < 0.0)
}

/// Moves each floating base whose lowest contact is at a height that fulfils the condition onto the
/// ground.
fn move_to_ground(
    model: &Model,
    q: &mut [f64],
    is_moved: impl Fn(f64) -> bool,
) -> Result<(), ShapeError> {
    let mut interpreter = Interpreter::<f64>::new(model.clone());
    let twists = || vec![Twist::zero(); model.constraints()];
    let mut displacements = twists();
    let mut velocities = twists();
    let outputs =
        ResidualOutputs { displacements: &mut displacements, velocities: &mut velocities };
    interpreter.constraint_residual(
        State { q, qd: &vec![0.0; model.nv()] },
        &settings_of(model),
        outputs,
    )?;
    let base = |frame: usize| {
        let links = std::iter::successors(model.frames()[frame].link, |&i| model.links()[i].parent);
        links.last()
    };
    for (i, link) in model.links().iter().enumerate() {
        if link.parent.is_some() || link.joint.joint_type != JointType::Floating {
            continue;
        }
        // The constraints of loops come before those of contacts.
        let heights = displacements.iter().skip(model.loop_constraints().len());
        let all_heights = model.contacts().iter().zip(heights);
        let touching = all_heights.filter(|(contact, _)| base(contact.end.frame) == Some(i));
        let lowest = touching.map(|(_, height)| height.linear.0[2]).fold(f64::INFINITY, f64::min);
        if lowest.is_finite() && is_moved(lowest) {
            // The coordinates are in the axes of the joint's frame.
            let [.., up] = link.joint.origin.rotation;
            let place = &mut q[model.q_range(i).start..];
            place.iter_mut().zip(up).for_each(|(x, up)| *x -= up * lowest);
        }
    }
    Ok(())
}

/// Returns the default settings of a robot's constraints.
#[must_use]
pub fn settings_of(model: &Model) -> ConstraintSettings<f64, Vec<ContactTarget<f64>>> {
    let ConstraintSettings { alpha, beta, tolerance, rounding, .. } =
        ConstraintSettings::<f64>::DEFAULT;
    let contacts = vec![ContactTarget::<f64>::GROUND; model.contacts().len()];
    ConstraintSettings { alpha, beta, tolerance, rounding, contacts }
}

/// The number of random coordinates from which loops are tried to be closed.
const MAX_STARTS: usize = 100;

/// Returns coordinates at which the loops are closed: near neutral ones, or else near random ones;
/// `None` if they were not found. A robot without loops has its neutral coordinates.
#[must_use]
pub fn closed_start(model: &Model) -> Option<Vec<f64>> {
    let interpreter = Interpreter::<f64>::new(model.clone());
    let mut q = vec![0.0; model.nq()];
    interpreter.neutral(&mut q).ok()?;
    let close = |q: Vec<f64>| close_loops(model, q, vec![0.0; model.nv()]).ok().map(|(q, _)| q);
    let mut random = Random::new(1);
    close(q.clone()).or_else(|| {
        (0..MAX_STARTS).find_map(|_| {
            interpreter.random(|| random.uniform(), &mut q).ok()?;
            close(q.clone())
        })
    })
}

/// The largest number of projections onto closed loops. Each doubles the number of correct digits,
/// so more never help.
const PROJECTIONS: usize = 50;

/// The largest residual of closed loops: m, and sines of angles.
const CLOSED: f64 = 1e-9;

/// The reason why loops cannot be closed.
#[derive(Clone, Debug, PartialEq)]
pub enum OpenLoop {
    /// The state does not have the model's lengths.
    Shape(ShapeError),
    /// The loop of this constraint stays open from where the robot starts.
    Constraint(usize),
}

/// Returns the coordinates and velocities with the loops closed.
///
/// # Errors
///
/// If a length is not the model's, or a loop cannot be closed from there.
pub fn close_loops(
    model: &Model,
    mut q: Vec<f64>,
    mut qd: Vec<f64>,
) -> Result<(Vec<f64>, Vec<f64>), OpenLoop> {
    if model.loop_constraints().is_empty() {
        return Ok((q, qd));
    }
    let shape = OpenLoop::Shape;
    let mut interpreter = Interpreter::<f64>::new(model.clone());
    let settings = settings_of(model);
    let inactive = vec![false; model.contacts().len()];
    let mut dq = vec![0.0; qd.len()];
    let mut dqd = vec![0.0; qd.len()];
    for _ in 0..PROJECTIONS {
        let outputs = ProjectionOutputs { dq: &mut dq, dqd: &mut dqd };
        interpreter
            .project_constraints(State { q: &q, qd: &qd }, &inactive, &settings, outputs)
            .map_err(shape)?;
        let before = q.clone();
        interpreter.integrate(&before, &dq, &mut q).map_err(shape)?;
    }
    // Velocities come last: a redundant loop that is open can be locked.
    let outputs = ProjectionOutputs { dq: &mut dq, dqd: &mut dqd };
    interpreter
        .project_constraints(State { q: &q, qd: &qd }, &inactive, &settings, outputs)
        .map_err(shape)?;
    qd.iter_mut().zip(&dqd).for_each(|(v, d)| *v += d);
    let twists = || vec![Twist::zero(); model.constraints()];
    let mut displacements = twists();
    let mut velocities = twists();
    let outputs =
        ResidualOutputs { displacements: &mut displacements, velocities: &mut velocities };
    interpreter.constraint_residual(State { q: &q, qd: &qd }, &settings, outputs).map_err(shape)?;
    // NaN is not closed.
    let is_open =
        |displacement: &Twist<f64>| !displacement.components().iter().all(|x| x.abs() < CLOSED);
    match displacements[..model.loop_constraints().len()].iter().position(is_open) {
        None => Ok((q, qd)),
        Some(constraint) => Err(OpenLoop::Constraint(constraint)),
    }
}
