//! Steps with impulses: the ground under the contacts, and joints that stop at their limits.
//!
//! `modyn::simulate::State::step_on_ground` is the same step for generated robots.

use modyn_runtime::model::Model;
use modyn_runtime::simulate::Ground;
use modyn_runtime::simulate::impulses::{
    FreeMotion, JointStop, Residual, StepContact, apply_impulses,
};
use modyn_runtime::spatial::{Twist, Vector3};
use modyn_runtime::{ConstraintSettings, ContactTarget, Interpreter, ShapeError};

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
}

/// The results of a step besides the coordinates.
pub struct Step {
    /// The velocities.
    pub qd: Vec<f64>,
    /// The energy that the impulses take, J.
    pub dissipated: f64,
    /// The height of the lowest contact above the ground before the step, m; infinite without ground.
    pub lowest: f64,
    /// The velocities that the sweeps left wrong.
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
        Self { options, limited }
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
        &self,
        interpreter: &mut Interpreter<f64>,
        (q, qd, tau): (&[f64], &[f64], &[f64]),
        settings: &ConstraintSettings<f64, Vec<ContactTarget<f64>>>,
        dt: f64,
    ) -> Result<Step, ShapeError> {
        let n = qd.len();
        let mut next = vec![0.0; n];
        interpreter.forward_dynamics(q, qd, tau, &mut next)?;
        next.iter_mut().zip(qd).for_each(|(next, qd)| *next = qd + dt * *next);
        let free = next.clone();
        let factors = interpreter.brge(q)?;

        let contacts = self.options.friction.map_or(0, |_| settings.contacts.len());
        let mut columns = vec![Twist::zero(); settings.contacts.len() * n];
        let twists = || vec![Twist::zero(); settings.contacts.len()];
        let (mut displacements, mut velocities) = (twists(), twists());
        if contacts > 0 {
            interpreter.constraint_jacobian(q, &mut columns)?;
            let before = (&mut *displacements, &mut *velocities);
            interpreter.constraint_residual((q, qd), settings, before)?;
        }
        let mut responses = Vec::with_capacity(3 * contacts);
        for columns in columns.chunks(n.max(1)).take(contacts) {
            for k in 0..3 {
                let force: Vec<f64> = columns.iter().map(|column| column.linear[k]).collect();
                responses.push(factors.solve(&force)?);
            }
        }
        let ground = Ground::with_friction(self.options.friction.unwrap_or(0.0));
        let touches: Vec<StepContact<'_, f64>> = (0..contacts)
            .map(|c| {
                StepContact::new(
                    &settings.contacts[c],
                    (&columns[c * n..][..n], [0, 1, 2].map(|k| &*responses[3 * c + k])),
                    (displacements[c], velocities[c]),
                    FreeMotion { dt, velocities: &free },
                    ground.friction,
                )
            })
            .collect();
        let lowest = touches.iter().map(|touch| touch.height).fold(f64::INFINITY, f64::min);
        let inverse = if self.limited.is_empty() { Vec::new() } else { factors.inverse() };
        let stops = self.limited.iter().map(|joint| {
            let response = &inverse[joint.velocity * n..][..n];
            let place = (q[joint.coordinate], joint.range);
            JointStop::new((joint.velocity, response), place, settings.beta, dt)
        });
        let stops: Vec<JointStop<'_, f64>> = stops.collect();
        let (mut impulses, mut torques) = (vec![Vector3::zero(); contacts], vec![0.0; stops.len()]);
        let (of_contacts, of_stops) = ((&*touches, &mut *impulses), (&*stops, &mut *torques));
        let residual = apply_impulses(of_contacts, of_stops, ground.sweeps, &mut next);

        // The change of the kinetic energy by impulses is their product with the mean velocity.
        let mean: Vec<f64> = free.iter().zip(&next).map(|(a, b)| (a + b) / 2.0).collect();
        let by_contacts = touches.iter().zip(&impulses);
        let by_contacts =
            by_contacts.map(|(touch, &p)| p.dot(touch.velocity(&mean) + touch.ground));
        let by_stops = stops.iter().zip(&torques).map(|(stop, p)| p * mean[stop.entry]);
        let dissipated = -by_contacts.chain(by_stops).sum::<f64>();
        let forces = impulses.iter().map(|impulse| impulse.0.map(|x| x / dt)).collect();
        Ok(Step { qd: next, dissipated, lowest, residual, forces })
    }
}
