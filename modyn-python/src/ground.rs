//! Steps on the ground, with friction and joint stops: machine code for the problem of each state, then the loops of
//! [`modyn_runtime::solve`], on all processors.

use std::cell::RefCell;

use modyn_codegen::Function;
use modyn_runtime::simulate::impulses::{
    FreeMotion, Impulses, Vectors, contact_mode, solve_step, velocity_range,
};
use modyn_runtime::simulate::{ContactMode, Ground};
use modyn_runtime::solve::{Contact, Stop};
use modyn_runtime::spatial::Vector3;
use modyn_runtime::{ConstraintSettings, ContactTarget, Interpreter, Model};
use numpy::prelude::*;
use numpy::{PyArray1, PyArrayDyn, PyReadonlyArrayDyn};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyTuple;

use crate::arrays::Given;
use crate::function::threads;
use crate::number::Number;
use crate::robot::Robot;

/// The states that a thread should have at least.
const STATES_PER_THREAD: usize = 64;

/// The settings of a step that all states share.
struct Shared<'a> {
    model: &'a Model,
    dt: f64,
    beta: f64,
    targets: Vec<ContactTarget<f64>>,
    ground: Ground<f64>,
}

/// The numbers of all states before the step: for each of them a slice of each.
struct Before<'a> {
    q: &'a [f64],
    qd: &'a [f64],
    heights: &'a [f64],
    before: &'a [f64],
    free: &'a [f64],
    mobility: &'a [f64],
    responses: &'a [f64],
}

/// The numbers after the step. Impulses are those of the last step before it.
struct After<'a> {
    qd: &'a mut [f64],
    impulses: &'a mut [f64],
    stops: &'a mut [f64],
    modes: &'a mut [i8],
    residuals: &'a mut [f64],
}

impl<'a> After<'a> {
    /// Returns the numbers of the first `states` states, and those of the others.
    fn split(self, states: usize, (nv, contacts): (usize, usize)) -> (Self, Self) {
        let (qd, qds) = self.qd.split_at_mut(states * nv);
        let (impulses, more) = self.impulses.split_at_mut(states * 3 * contacts);
        let (stops, others) = self.stops.split_at_mut(states * nv);
        let (modes, rest) = self.modes.split_at_mut(states * contacts);
        let (residuals, last) = self.residuals.split_at_mut(states * 2);
        let own = Self { qd, impulses, stops, modes, residuals };
        (own, Self { qd: qds, impulses: more, stops: others, modes: rest, residuals: last })
    }
}

impl Shared<'_> {
    /// Returns for each velocity the range of its joint's stop.
    fn stops(&self, q: &[f64]) -> Vec<Stop<f64>> {
        let mut stops = Vec::new();
        if !self.ground.joint_limits {
            return stops;
        }
        stops.resize(self.model.nv(), Stop::new([f64::NEG_INFINITY, f64::INFINITY]));
        for link in 0..self.model.links().len() {
            let joint = &self.model.links()[link].joint;
            let (at, velocity) = (self.model.q_range(link), self.model.v_range(link));
            if joint.mimic.is_none() && velocity.len() == 1 {
                let limits = self.model.coordinate_range(link);
                stops[velocity.start].range =
                    velocity_range(q[at.start], limits, self.beta, self.dt);
            }
        }
        stops
    }

    /// Takes the steps of these states, from `first` on.
    fn step(&self, all: &Before<'_>, first: usize, after: After<'_>, robot: Interpreter<f64>) {
        let (n, contacts) = (self.model.nv(), self.targets.len());
        let (nq, rows) = (self.model.nq(), 3 * contacts);
        let robot = RefCell::new(robot);
        let matrix = |numbers: &[f64], length: usize| -> Vec<Vec<f64>> {
            numbers.chunks(length.max(1)).map(<[f64]>::to_vec).collect()
        };
        let vectors = |numbers: &[f64]| -> Vec<Vector3<f64>> {
            numbers.as_chunks().0.iter().map(|three| Vector3(*three)).collect()
        };
        for k in 0..after.qd.len() / n.max(1) {
            let state = first + k;
            fn part(numbers: &[f64], state: usize, length: usize) -> &[f64] {
                &numbers[state * length..][..length]
            }
            let q = part(all.q, state, nq);
            let inverse = || {
                let found = robot.borrow_mut().brge(q).map(|factors| factors.inverse());
                matrix(&found.unwrap_or_else(|_| vec![0.0; n * n]), n)
            };
            let (mobility, responses) = (
                matrix(part(all.mobility, state, rows * rows), rows),
                matrix(part(all.responses, state, rows * n), n),
            );
            let (before, free) =
                (vectors(part(all.before, state, rows)), vectors(part(all.free, state, rows)));
            let motion = FreeMotion {
                dt: self.dt,
                qd: part(all.qd, state, n),
                heights: part(all.heights, state, contacts),
                before: &before,
                free: &free,
                mobility: &mobility,
                responses: &responses,
            };
            let (impulses, stops) =
                (&mut after.impulses[k * rows..][..rows], &mut after.stops[k * n..][..n]);
            let mut found = Impulses { contacts: impulses.to_vec(), stops: stops.to_vec() };
            let (residual, _) = solve_step(
                &Vectors { contacts, velocities: n, inverse },
                &motion,
                &self.targets,
                &self.ground,
                (&mut vec![Contact::new(0.0); contacts], &mut self.stops(q), &mut vec![0; n]),
                &mut found,
                &mut after.qd[k * n..][..n],
            );
            impulses.copy_from_slice(&found.contacts);
            stops.copy_from_slice(&found.stops);
            after.residuals[2 * k..][..2].copy_from_slice(&[residual.contacts, residual.stops]);
            let three = found.contacts.as_chunks().0.iter().zip(&self.targets);
            for (mode, (impulse, target)) in after.modes[k * contacts..].iter_mut().zip(three) {
                *mode = match contact_mode(target.friction, *impulse) {
                    ContactMode::Open => 0,
                    ContactMode::Stick => 1,
                    ContactMode::Slip => 2,
                };
            }
        }
    }
}

/// Returns the numbers of an array in C order, in `float64`.
fn numbers(object: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    let numpy = object.py().import("numpy")?;
    let array = numpy.call_method1("ascontiguousarray", (object, "float64"))?;
    let array: PyReadonlyArrayDyn<'_, f64> =
        array.cast_into::<PyArrayDyn<f64>>()?.try_into_readonly()?;
    Ok(array.as_slice()?.to_vec())
}

#[pymethods]
impl Robot {
    /// Returns the state after a step of the time `dt` (s) under the joint forces `tau`, with all contacts of the robot as
    /// points that the ground can push but not pull, with Coulomb friction and joint stops.
    ///
    /// `q` is (nq,), `qd` and `tau` are (nv,), or (n, nq) and (n, nv) for n states, which run on all processors. `settings` has
    /// the ground under each contact (`ConstraintSettings`; by default the plane z = 0 with friction 0.8). `last` is the
    /// result of the last step, whose impulses are the solver's first guess. Without `joint_limits` joints have no stops. The
    /// solver ends when no velocity contradicts the laws of contacts by more than `tolerance` (m/s, rad/s), or after
    /// `sweeps` visits of each contact and `newton_steps` steps of Newton's method.
    ///
    /// Result: `GroundStep`. Source: Stewart and Trinkle 1996.
    #[pyo3(signature = (q, qd, tau, dt, settings=None, *, last=None, joint_limits=true, tolerance=1e-9, sweeps=8, newton_steps=40))]
    #[allow(clippy::too_many_arguments)]
    fn step_on_ground<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        tau: &Bound<'py, PyAny>,
        dt: f64,
        settings: Option<&Bound<'py, PyAny>>,
        last: Option<&Bound<'py, PyAny>>,
        joint_limits: bool,
        tolerance: f64,
        sweeps: usize,
        newton_steps: usize,
    ) -> PyResult<Bound<'py, PyAny>> {
        const NAME: &str = "step_on_ground";
        self.check_has(Function::ContactProblem)?;
        if !(dt > 0.0 && dt.is_finite()) {
            return Err(PyValueError::new_err(format!(
                "`dt` of `{NAME}` must be a time above zero, not {dt}"
            )));
        }
        let model = self.model();
        let (nq, nv, contacts) = (model.nq(), model.nv(), model.contacts().len());
        let states = Given::<f64>::read(NAME, "q", &[nq], &numpy_f64(q)?)?.states;
        let count = states.unwrap_or(1);
        let shape = |own: &[usize]| -> Vec<usize> {
            states.into_iter().chain(own.iter().copied()).collect()
        };

        let length = ConstraintSettings::<f64>::COUNT + ContactTarget::<f64>::COUNT * contacts;
        let of_settings = match settings.filter(|settings| !settings.is_none()) {
            Some(settings) => {
                let given = Given::<f64>::read_for_scalar(NAME, "settings", &[length], settings)?;
                if given.states.is_some() {
                    return Err(PyValueError::new_err(format!(
                        "`settings` of `{NAME}` are those of all states: one object, not one for each state"
                    )));
                }
                given.as_slice().to_vec()
            }
            None => {
                let ground = <f64 as Number>::GROUND.numbers();
                let all = <f64 as Number>::SETTINGS.numbers().into_iter();
                all.chain(ground.into_iter().cycle()).take(length).collect()
            }
        };
        let (own, targets) = of_settings.split_at(ConstraintSettings::<f64>::COUNT);
        let shared = Shared {
            model,
            dt,
            beta: own[1],
            targets: targets
                .as_chunks()
                .0
                .iter()
                .map(|target| ContactTarget::from_numbers(*target))
                .collect(),
            ground: Ground { joint_limits, tolerance, sweeps, newton_steps },
        };

        let time = pyo3::types::PyFloat::new(py, dt);
        let arguments = [Some(q), Some(qd), Some(tau), Some(time.as_any()), settings];
        let problem = self.call(py, function(Function::ContactProblem), &arguments, None, None)?;
        let field = |name: &str| numbers(&problem.getattr(name)?);
        let all = (numbers(q)?, field("qd")?);
        let of_contacts = (field("heights")?, field("before")?, field("free")?, field("mobility")?);
        // By rows: each has the response of all velocities.
        let responses = problem.getattr("responses")?.call_method1("swapaxes", (-1, -2))?;
        let responses = numbers(&responses)?;
        let (mut impulses, mut stops) = (vec![0.0; count * 3 * contacts], vec![0.0; count * nv]);
        if let Some(last) = last.filter(|last| !last.is_none()) {
            for (name, first) in [("impulses", &mut impulses), ("stops", &mut stops)] {
                let found = numbers(&last.getattr(name)?)?;
                if found.len() != first.len() {
                    return Err(PyValueError::new_err(format!(
                        "`{name}` of `last` has {} numbers; a step of as many states has {}",
                        found.len(),
                        first.len()
                    )));
                }
                *first = found;
            }
        }
        let mut moved = vec![0.0; count * nv];
        let (mut modes, mut residuals) = (vec![0_i8; count * contacts], vec![0.0; 2 * count]);
        let threads = threads().min(count.div_ceil(STATES_PER_THREAD)).max(1);
        let robots = (0..threads).map(|_| self.interpreter()).collect::<PyResult<Vec<_>>>()?;
        py.detach(|| {
            let before = Before {
                q: &all.0,
                qd: &all.1,
                heights: &of_contacts.0,
                before: &of_contacts.1,
                free: &of_contacts.2,
                mobility: &of_contacts.3,
                responses: &responses,
            };
            let mut rest = After {
                qd: &mut moved,
                impulses: &mut impulses,
                stops: &mut stops,
                modes: &mut modes,
                residuals: &mut residuals,
            };
            let share = count.div_ceil(threads);
            std::thread::scope(|scope| {
                for (i, robot) in robots.into_iter().enumerate() {
                    let first = i * share;
                    let own = share.min(count.saturating_sub(first));
                    let (chunk, others) = rest.split(own, (nv, contacts));
                    rest = others;
                    let (shared, before) = (&shared, &before);
                    if threads == 1 {
                        shared.step(before, first, chunk, robot);
                    } else {
                        scope.spawn(move || shared.step(before, first, chunk, robot));
                    }
                }
            });
        });

        let displacement = moved.iter().map(|v| dt * v).collect();
        let displacement = self.array(py, displacement, &shape(&[nv]))?;
        let arguments = [Some(q), Some(&displacement)];
        let next = self.call(py, function(Function::Integrate), &arguments, None, None)?;
        let array = |numbers: Vec<f64>, own: &[usize]| self.array(py, numbers, &shape(own));
        let modes = PyArray1::from_vec(py, modes).reshape(shape(&[contacts]))?.into_any();
        let results = [
            next,
            array(moved, &[nv])?,
            array(impulses, &[contacts, 3])?,
            array(stops, &[nv])?,
            modes,
            array(residuals, &[2])?,
        ];
        py.import("modyn._types")?.getattr("GroundStep")?.call1(PyTuple::new(py, results)?)
    }
}

impl Robot {
    /// Returns an array of the robot's scalar with this shape.
    fn array<'py>(
        &self,
        py: Python<'py>,
        numbers: Vec<f64>,
        shape: &[usize],
    ) -> PyResult<Bound<'py, PyAny>> {
        let array = PyArray1::from_vec(py, numbers).reshape(shape.to_vec())?;
        array.call_method1("astype", (self.dtype(py),))
    }
}

/// Returns the index of a function in the table.
fn function(function: Function) -> usize {
    Function::ALL.iter().position(|&one| one == function).unwrap_or(0)
}

/// Returns an object as an array of `float64`.
fn numpy_f64<'py>(object: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    object.py().import("numpy")?.call_method1("asarray", (object, "float64"))
}
