//! Steps with impulses: the ground under the contacts, and joints that stop at their limits.
//!
//! `modyn::simulate::State::step_on_ground` is the same step for generated robots.

use modyn_runtime::model::Model;
use modyn_runtime::simulate::impulses::{
    FreeMotion, Impulses as StepImpulses, Vectors, solve_step, velocity_range,
};
use modyn_runtime::simulate::{Ground, Residual};
use modyn_runtime::solve::{Contact, Stop};
use modyn_runtime::spatial::Vector3;
use modyn_runtime::{
    ConstraintSettings, ContactProblemOutputs, ContactTarget, Interpreter, ShapeError,
};

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

/// The limits of a joint with one coordinate.
struct Limited {
    coordinate: usize,
    velocity: usize,
    /// The lowest and the highest coordinate, rad or m; mimic joints included.
    range: [f64; 2],
    /// The largest joint force, N m or N.
    effort: f64,
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
    limited: Vec<Limited>,
    /// The impulses of the last step.
    last: StepImpulses<Vec<f64>, Vec<f64>>,
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
        let limited = (0..model.links().len()).filter_map(|link| {
            let joint = &model.links()[link].joint;
            let (q, v) = (model.q_range(link), model.v_range(link));
            (joint.mimic.is_none() && v.len() == 1).then(|| Limited {
                coordinate: q.start,
                velocity: v.start,
                range: model.coordinate_range(link),
                effort: joint
                    .limits
                    .as_ref()
                    .and_then(|limits| limits.effort)
                    .unwrap_or(f64::INFINITY),
            })
        });
        let limited = if options.limits { limited.collect() } else { Vec::new() };
        let contacts = options.friction.map_or(0, |_| model.contacts().len());
        let last = StepImpulses { contacts: vec![0.0; 3 * contacts], stops: vec![0.0; model.nv()] };
        Self { options, limited, last }
    }

    pub fn is_none(&self) -> bool {
        self.options.is_none()
    }

    /// Reduces joint forces to the effort limits.
    pub fn limit(&self, tau: &mut [f64]) {
        for joint in &self.limited {
            tau[joint.velocity] = tau[joint.velocity].clamp(-joint.effort, joint.effort);
        }
    }

    /// Returns the velocities after a step of `dt` seconds from this state on under these joint forces.
    pub fn step(
        &mut self,
        interpreter: &mut Interpreter<f64>,
        (q, qd, tau): (&[f64], &[f64], &[f64]),
        settings: &ConstraintSettings<f64, Vec<ContactTarget<f64>>>,
        dt: f64,
    ) -> Result<Step, ShapeError> {
        let (n, count) = (qd.len(), settings.contacts.len());
        let (mut free, mut heights) = (vec![0.0; n], vec![0.0; count]);
        let (mut before, mut after) = (vec![Vector3::zero(); count], vec![Vector3::zero(); count]);
        let rows = 3 * count;
        let (mut mobility, mut responses) = (vec![0.0; rows * rows], vec![0.0; rows * n]);
        let problem = ContactProblemOutputs {
            qd: &mut free,
            heights: &mut heights,
            before: &mut before,
            free: &mut after,
            mobility: &mut mobility,
            responses: &mut responses,
        };
        interpreter.contact_problem((q, qd, tau, dt), settings, problem)?;
        let matrix = |numbers: &[f64], rows: usize| -> Vec<Vec<f64>> {
            numbers.chunks(rows.max(1)).map(<[f64]>::to_vec).collect()
        };
        let (mobility, responses) = (matrix(&mobility, rows), matrix(&responses, n));
        // Without ground no contact takes part.
        let contacts = self.last.contacts.len() / 3;
        let targets: Vec<ContactTarget<f64>> = settings.contacts[..contacts]
            .iter()
            .map(|target| ContactTarget {
                friction: self.options.friction.unwrap_or_default(),
                ..*target
            })
            .collect();
        let motion = FreeMotion {
            dt,
            qd: &free,
            heights: &heights[..contacts],
            before: &before[..contacts],
            free: &after[..contacts],
            mobility: &mobility[..3 * contacts],
            responses: &responses[..3 * contacts],
        };
        let mut stops = vec![Stop::new([f64::NEG_INFINITY, f64::INFINITY]); n];
        for joint in &self.limited {
            let range = velocity_range(q[joint.coordinate], joint.range, settings.beta, dt);
            stops[joint.velocity].range = range;
        }
        if self.limited.is_empty() {
            stops.clear();
        }
        let factors = interpreter.brge(q)?;
        let memory = Vectors { contacts, velocities: n, inverse: || matrix(&factors.inverse(), n) };
        let mut next = free.clone();
        let (residual, _) = solve_step(
            &memory,
            &motion,
            &targets,
            &Ground::default(),
            (&mut vec![Contact::new(0.0); contacts], &mut stops, &mut vec![0; n]),
            &mut self.last,
            &mut next,
        );
        let energies =
            [interpreter.kinetic_energy(q, &free)?, interpreter.kinetic_energy(q, &next)?];
        let lowest = motion.heights.iter().copied().fold(f64::INFINITY, f64::min);
        let impulses = self.last.contacts.as_chunks::<3>().0;
        // Impulses are along the axes of the targets.
        let forces =
            targets.iter().zip(impulses).map(|(target, p)| target.pose.rotate(p.map(|x| x / dt)));
        let forces = forces.collect();
        Ok(Step { qd: next, dissipated: energies[0] - energies[1], lowest, residual, forces })
    }
}
