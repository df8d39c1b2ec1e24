//! Closed loops of robots that are known at run time: closed coordinates, from which motions start.

use modyn_runtime::equations::State;
use modyn_runtime::equations::constraints::{ProjectionOutputs, ResidualOutputs};
use modyn_runtime::model::Model;
use modyn_runtime::spatial::Twist;
use modyn_runtime::{ConstraintSettings, ContactTarget, Interpreter, ShapeError};

use crate::random::Random;

/// Returns the default settings of a robot's constraints.
#[must_use]
pub fn settings_of(model: &Model) -> ConstraintSettings<f64, Vec<ContactTarget<f64>>> {
    let ConstraintSettings { alpha, beta, tolerance, rounding, .. } =
        ConstraintSettings::<f64>::DEFAULT;
    let targets = vec![ContactTarget::<f64>::GROUND; model.contacts().len()];
    ConstraintSettings { alpha, beta, tolerance, rounding, targets }
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
            interpreter.random_configuration(|| random.uniform(), &mut q).ok()?;
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
    let mut step_q = vec![0.0; qd.len()];
    let mut step_qd = vec![0.0; qd.len()];
    for _ in 0..PROJECTIONS {
        let outputs = ProjectionOutputs { step_q: &mut step_q, step_qd: &mut step_qd };
        interpreter
            .project_constraints(State { q: &q, qd: &qd }, &inactive, &settings, outputs)
            .map_err(shape)?;
        let before = q.clone();
        interpreter.integrate(&before, &step_q, &mut q).map_err(shape)?;
    }
    // Velocities come last: a redundant loop that is open can be locked.
    let outputs = ProjectionOutputs { step_q: &mut step_q, step_qd: &mut step_qd };
    interpreter
        .project_constraints(State { q: &q, qd: &qd }, &inactive, &settings, outputs)
        .map_err(shape)?;
    qd.iter_mut().zip(&step_qd).for_each(|(v, d)| *v += d);
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
