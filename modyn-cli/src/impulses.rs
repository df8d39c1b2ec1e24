//! Steps with impulses: the ground under the contacts, and joints that stop at their limits.
//!
//! `modyn::simulate::State::step_on_ground` is the same step for generated robots.

use modyn_runtime::model::Model;
use modyn_runtime::quantities::Function;
use modyn_runtime::simulate::by_numbers::GroundRobot;
use modyn_runtime::simulate::{Ground, Residual};
use modyn_runtime::{ConstraintSettings, ContactTarget, FrameError, Interpreter};

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
    pub fn is_none(self) -> bool {
        self.friction.is_none() && !self.limits
    }
}

/// Returns the names of the mimic joints whose limits contradict those of their leaders. Such limits are not enforced.
pub fn contradictory_limits(model: &Model) -> Vec<String> {
    let contradicts = |&link: &usize| {
        let joint = &model.links()[link].joint;
        let (Some(limits), Some(mimic)) = (&joint.limits, model.mimic(link)) else { return false };
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
    /// The height of the lowest contact above the ground before the step, m; infinite without ground.
    pub lowest: f64,
    /// The velocities that are wrong.
    pub residual: Residual,
    /// The mean force of the ground on each contact, N, in world axes.
    pub forces: Vec<[f64; 3]>,
}

impl Impulses {
    pub fn new(model: &Model, options: Options) -> Self {
        let effort = |link: usize| {
            let (joint, v) = (&model.links()[link].joint, model.v_range(link));
            let is_own = joint.mimic.is_none() && v.len() == 1;
            Some((v.start, joint.limits.as_ref()?.effort?)).filter(|_| is_own)
        };
        let joints = 0..if options.limits { model.links().len() } else { 0 };
        let robot = GroundRobot::new(model, options.limits);
        // Without ground no contact takes part.
        let robot = if options.friction.is_some() { robot } else { robot.without_contacts() };
        let last = [3 * robot.contacts(), model.nv()].map(|count| vec![0.0; count]);
        Self { options, robot, efforts: joints.filter_map(effort).collect(), last }
    }

    pub fn is_none(&self) -> bool {
        self.options.is_none()
    }

    /// Reduces joint forces to the effort limits.
    pub fn limit(&self, tau: &mut [f64]) {
        for &(velocity, effort) in &self.efforts {
            tau[velocity] = tau[velocity].clamp(-effort, effort);
        }
    }

    /// Returns the velocities after a step of `dt` seconds from this state on under these joint forces.
    pub fn step(
        &mut self,
        interpreter: &mut Interpreter<f64>,
        (q, qd, tau): (&[f64], &[f64], &[f64]),
        settings: &ConstraintSettings<f64, Vec<ContactTarget<f64>>>,
        dt: f64,
    ) -> Result<Step, FrameError> {
        let model = interpreter.model();
        let mut problem = vec![0.0; GroundRobot::new(model, false).problem_length()];
        let numbers = settings.contacts.iter().flat_map(ContactTarget::numbers);
        let numbers: Vec<f64> = settings.numbers().into_iter().chain(numbers).collect();
        let arguments = [q, qd, tau, &[dt], &numbers];
        interpreter.evaluate(Function::ContactProblem, &arguments, 0, &mut problem)?;
        let factors = interpreter.brge(q)?;
        let friction = self.options.friction.unwrap_or_default();
        let contacts = settings.contacts[..self.robot.contacts()].iter();
        let contacts: Vec<ContactTarget<f64>> =
            contacts.map(|target| ContactTarget { friction, ..*target }).collect();
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
        let forces = forces.map(|(target, p)| target.pose.rotate(p.map(|x| x / dt)));
        let forces = forces.collect();
        Ok(Step { qd: next, dissipated: energies[0] - energies[1], lowest, residual, forces })
    }
}
