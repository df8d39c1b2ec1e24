//! Functions of arrays for libraries that differentiate by every entry of their arrays: JAX and
//! PyTorch.
//!
//! ```text
//! Robot ─ plan_entries ─▶ ArrayCode, by a key of its content ─┬─ xla.rs: XLA calls it with its buffers and threads
//!                                                             └─ call_arrays: arrays of NumPy
//! ```
//!
//! The code of a function is never dropped: XLA may call it as long as the process lives.

mod code;
mod field;
mod interface;
mod kernel;
mod rollout;
mod signature;
mod states;
mod xla;

use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::{OnceLock, PoisonError, RwLock};

use modyn_codegen::plan::{Derivative, DerivativeMode, EntryFunction, Planned};
use modyn_codegen::{FloatType, Function, Planning};
use numpy::PyArrayDyn;
use numpy::prelude::*;
use pyo3::exceptions::{PyMemoryError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

use crate::arrays::in_order;
use crate::errors::{description_error, warn_of_machine_code};
use crate::memory::zeros;
use crate::number::Number;
use crate::pool::StartedThreads;
use crate::robot::Robot;
use code::ArrayCode;
use field::{FieldNumbers, FieldStep};
use kernel::{ArrayShapes, StateFunction};
use rollout::{Reverse, Rollout};
use states::{Broadcast, Fault, Numbers, common};
pub use xla::xla_handler;

/// The key of code, and the shapes of its arrays of arguments and of results.
type KeyAndShapes = (i64, Vec<Vec<usize>>, Vec<Vec<usize>>);

/// The code of a function of arrays, for either scalar.
enum AnyCode {
    F64(ArrayCode<f64>),
    F32(ArrayCode<f32>),
}

impl AnyCode {
    /// Returns the only function of a planning, and the reason why there is no machine code, if it
    /// was wanted.
    fn new(
        planning: Planning,
        arrays: ArrayShapes,
        scalar: FloatType,
        machine: bool,
    ) -> Option<(Self, Option<String>)> {
        Some(match scalar {
            FloatType::F64 => {
                let (function, reason) = StateFunction::new(planning, arrays, machine)?;
                (Self::F64(ArrayCode::Function(function)), reason)
            }
            FloatType::F32 => {
                let (function, reason) = StateFunction::new(planning, arrays, machine)?;
                (Self::F32(ArrayCode::Function(function)), reason)
            }
        })
    }
}

/// Returns the code of all functions, by their keys.
fn registry() -> &'static RwLock<HashMap<i64, &'static AnyCode>> {
    static REGISTRY: OnceLock<RwLock<HashMap<i64, &'static AnyCode>>> = OnceLock::new();
    REGISTRY.get_or_init(RwLock::default)
}

/// Returns the code with this key.
fn find(key: i64) -> Option<&'static AnyCode> {
    registry().read().unwrap_or_else(PoisonError::into_inner).get(&key).copied()
}

/// Keeps code as long as the process lives.
fn register(key: i64, code: AnyCode) {
    let mut registry = registry().write().unwrap_or_else(PoisonError::into_inner);
    registry.entry(key).or_insert_with(|| Box::leak(Box::new(code)));
}

/// Returns a derivative, given its mode and the indices of the arrays that vary.
fn parsed((mode, variables): (String, Vec<usize>)) -> PyResult<Derivative> {
    let mode = match &*mode {
        "forward" => DerivativeMode::Forward,
        "reverse" => DerivativeMode::Reverse,
        "matrix" => DerivativeMode::Matrix,
        other => return Err(PyValueError::new_err(format!("no mode `{other}`"))),
    };
    Ok(Derivative { mode, variables })
}

/// Returns the key of a function: a hash of its program, its arrays and its scalar, the same in
/// each process.
fn key_of(planned: &Planned, arrays: &ArrayShapes, scalar: FloatType, machine: bool) -> i64 {
    let mut hasher = DefaultHasher::new();
    env!("CARGO_PKG_VERSION").hash(&mut hasher);
    (arrays, scalar == FloatType::F32, machine).hash(&mut hasher);
    for program in planned.kernels.straight().into_iter().flat_map(<[_; 2]>::from) {
        program.to_string().hash(&mut hasher);
    }
    (hasher.finish() >> 1).cast_signed()
}

#[pymethods]
impl Robot {
    /// Returns the names of the arguments of a function, each with its shape and its default; the
    /// run-time parameters that it depends on, each by option and link with its present numbers;
    /// and its result, whose arrays are their indices. For `modyn.jax` and `modyn.torch`.
    #[pyo3(signature = (name, link=None))]
    fn _array_signature<'py>(
        &self,
        py: Python<'py>,
        name: &str,
        link: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (function, _) = self.array_function(name, link)?;
        signature::of(self, py, function)
    }

    /// Returns the key of the code of a function or of a derivative, and the shapes of its arrays
    /// of arguments and of results. Each derivative is its mode (`forward`, `reverse` or `matrix`)
    /// and the indices of the arrays that vary. With `feedback`, a time step has the arguments
    /// `gains`, `q_ref` and `qd_ref`; with `cost`, the array `cost` of the state, and `q_goal`,
    /// `qd_goal`, `state_weights` and `control_weights`. For `modyn.jax` and `modyn.torch`.
    #[pyo3(signature = (name, link, derivatives, feedback=false, cost=false))]
    fn _array_code(
        &self,
        py: Python<'_>,
        name: &str,
        link: Option<&Bound<'_, PyAny>>,
        derivatives: Vec<(String, Vec<usize>)>,
        feedback: bool,
        cost: bool,
    ) -> PyResult<KeyAndShapes> {
        let (function, link) = self.array_function(name, link)?;
        let derivatives = derivatives.into_iter().map(parsed).collect::<PyResult<Vec<_>>>()?;
        let mut results = signature::places(self, function);
        let count = results.iter().map(Vec::len).sum();
        results.extend(cost.then(|| vec![count]));
        let function = EntryFunction { function, link, results, feedback, cost, derivatives };
        let arrays = signature::shapes(self, &function).map_err(PyValueError::new_err)?;
        let key = self.array_key(&function, || self.array_code(py, &function, &arrays))?;
        Ok((key, arrays.inputs().to_vec(), arrays.outputs().to_vec()))
    }
}

#[pymethods]
impl Robot {
    /// Returns the key of the code of `step` on a height field, which sets the planes of the
    /// surfaces: given the key of the step, or of its derivative, which is a mode (`forward`,
    /// `reverse` or `matrix`) and the indices of the arrays that vary. `field` has the origin, the
    /// spacing, the columns and the heights.
    #[pyo3(signature = (step, derivative, field))]
    fn _field_code(
        &self,
        py: Python<'_>,
        step: i64,
        derivative: Option<(String, Vec<usize>)>,
        field: FieldNumbers,
    ) -> PyResult<i64> {
        let derivative = derivative.map(parsed).transpose()?;
        let poses = field::poses(self);
        let arrays = signature::shapes(self, &poses).map_err(PyValueError::new_err)?;
        let poses = self.array_key(&poses, || self.array_code(py, &poses, &arrays))?;
        let mut hasher = DefaultHasher::new();
        let FieldNumbers { origin, spacing, columns, heights } = &field;
        let numbers = origin.iter().chain(spacing).chain(heights);
        numbers.for_each(|number| number.to_bits().hash(&mut hasher));
        (step, poses, columns, format!("{derivative:?}")).hash(&mut hasher);
        let key = (hasher.finish() >> 1).cast_signed();
        if find(key).is_some() {
            return Ok(key);
        }
        let codes = [step, poses].map(find);
        let code = match codes {
            [Some(AnyCode::F64(step)), Some(AnyCode::F64(poses))] => {
                AnyCode::F64(self.on_field([step, poses], &field, derivative)?)
            }
            [Some(AnyCode::F32(step)), Some(AnyCode::F32(poses))] => {
                AnyCode::F32(self.on_field([step, poses], &field, derivative)?)
            }
            _ => return Err(no_step()),
        };
        register(key, code);
        Ok(key)
    }

    /// Returns the states of motions of many time steps in one call: after each step, (..., steps,
    /// n), or after the last one with `trajectory=False`. Many motions use the vector units and all
    /// cores.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,); `controls`: (steps, nv), the joint forces of each step;
    /// `dt`: the time step, s; `step`: the method, such as `semi_implicit` for the function
    /// `step_semi_implicit`, or `step` for the function `step`, with contacts and joint limits. This
    /// one has the arguments `settings`: `StepSettings`, by default the result of `step_settings()`;
    /// `warm_start`: the accelerations from which the first solver starts, by default zeros; and
    /// `ground`: a `HeightField` that sets the planes of the surfaces, by the place of each shape
    /// before each step. With a feedback, the forces are `controls` + `gains` (x_ref - x), where
    /// the difference of states has that of coordinates in tangent space, then that of velocities:
    /// `gains`: (nv, 2 nv) or (steps, nv, 2 nv); `q_ref`: (nq,) or (steps, nq); `qd_ref`: (nv,) or
    /// (steps, nv); one step stands for all of them. With `cost`, a `QuadraticCost`, each step adds
    /// the cost of its forces and of the state after it. Leading axes are those of motions, and are
    /// broadcast. Result: `RolloutStates`: `q` and `qd`; with a cost `RolloutCosts`; of `step`
    /// `StepSolution`, with the largest `residual` and `iterations` of all steps with
    /// `trajectory=False`.
    #[pyo3(signature = (
        q, qd, controls, dt, *, step="semi_implicit", gains=None, q_ref=None, qd_ref=None,
        cost=None, settings=None, warm_start=None, ground=None, trajectory=true,
    ))]
    #[allow(clippy::too_many_arguments)]
    fn rollout<'py>(
        slf: &Bound<'py, Self>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        controls: &Bound<'py, PyAny>,
        dt: &Bound<'py, PyAny>,
        step: &str,
        gains: Option<&Bound<'py, PyAny>>,
        q_ref: Option<&Bound<'py, PyAny>>,
        qd_ref: Option<&Bound<'py, PyAny>>,
        cost: Option<&Bound<'py, PyAny>>,
        settings: Option<&Bound<'py, PyAny>>,
        warm_start: Option<&Bound<'py, PyAny>>,
        ground: Option<&Bound<'py, PyAny>>,
        trajectory: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let others = [settings, warm_start, gains, q_ref, qd_ref];
        let arguments = rollout_arguments([q, qd, controls, dt], others)?;
        let rollout = slf.py().import("modyn._rollout")?.getattr("rollout")?;
        rollout.call1((slf, arguments, (step, ground), trajectory, cost))
    }

    /// Returns the gradients of the weighted states of motions, which `rollout` returns, with
    /// respect to its arguments, for each motion: one call, which stores few states. Coordinates
    /// have an entry for each of their numbers; lengths of quaternions have no effect.
    ///
    /// Arguments: those of `rollout`; `q_weights`: (steps, nq) and `qd_weights`: (steps, nv), or
    /// (nq,) and (nv,) with `trajectory=False`; `None` for zeros; `cost_weights`: (steps,), or ()
    /// with `trajectory=False`, the weights of the cost. Result: `RolloutGradients`, with the names
    /// and the shapes of the arguments.
    #[pyo3(signature = (
        q, qd, controls, dt, q_weights, qd_weights, *, step="semi_implicit", gains=None,
        q_ref=None, qd_ref=None, cost=None, cost_weights=None, settings=None, warm_start=None,
        ground=None, trajectory=true,
    ))]
    #[allow(clippy::too_many_arguments)]
    fn rollout_vjp<'py>(
        slf: &Bound<'py, Self>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        controls: &Bound<'py, PyAny>,
        dt: &Bound<'py, PyAny>,
        q_weights: &Bound<'py, PyAny>,
        qd_weights: &Bound<'py, PyAny>,
        step: &str,
        gains: Option<&Bound<'py, PyAny>>,
        q_ref: Option<&Bound<'py, PyAny>>,
        qd_ref: Option<&Bound<'py, PyAny>>,
        cost: Option<&Bound<'py, PyAny>>,
        cost_weights: Option<&Bound<'py, PyAny>>,
        settings: Option<&Bound<'py, PyAny>>,
        warm_start: Option<&Bound<'py, PyAny>>,
        ground: Option<&Bound<'py, PyAny>>,
        trajectory: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let others = [settings, warm_start, gains, q_ref, qd_ref];
        let arguments = rollout_arguments([q, qd, controls, dt], others)?;
        let vjp = slf.py().import("modyn._rollout")?.getattr("rollout_vjp")?;
        let weights = (q_weights, qd_weights, cost_weights);
        vjp.call1((slf, arguments, weights, (step, ground), trajectory, cost))
    }

    /// Returns the state after a `step`, and its derivatives A with respect to the state and B with
    /// respect to the joint forces, as `step_semi_implicit_derivatives` does for a step without
    /// contacts: in tangent space, displacements in the axes before and after the step. They
    /// follow from the implicit function theorem at the solution; where a contact opens or closes, or
    /// a point begins to slide, they are one-sided.
    ///
    /// Arguments: as of `step`. Result: `StepDerivatives`.
    #[pyo3(signature = (q, qd, tau, dt, warm_start=None, settings=None))]
    #[allow(clippy::too_many_arguments)]
    fn step_derivatives<'py>(
        slf: &Bound<'py, Self>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        tau: &Bound<'py, PyAny>,
        dt: &Bound<'py, PyAny>,
        warm_start: Option<&Bound<'py, PyAny>>,
        settings: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let given = [Some(q), Some(qd), Some(tau), Some(dt), warm_start, settings];
        let names = ["q", "qd", "tau", "dt", "warm_start", "settings"];
        let arguments = named(slf.py(), &names, &given)?;
        let function = slf.py().import("modyn._rollout")?.getattr("step_derivatives")?;
        function.call1((slf, arguments))
    }

    /// Returns the results of each of `steps` calls of `step` under the joint forces
    /// `policy(time, q, qd)`, which gets the time (s) and the state before each step. `modyn.show`
    /// shows the motion. A rollout without a call of Python in each step is `rollout`.
    ///
    /// Arguments: `policy`: a function that returns tau: (nv,); `q`: (nq,); `qd`: (nv,); `dt`: ();
    /// `steps`: the number of steps; `settings` and `ground` as in `rollout`. Leading axes of `q` and
    /// `qd` are axes of motions, which `policy` gets, too. Result: `StepSolution`, with an axis of
    /// steps after the axes of motions.
    #[pyo3(signature = (policy, q, qd, dt, steps, settings=None, *, ground=None))]
    #[allow(clippy::too_many_arguments)]
    fn simulate<'py>(
        slf: &Bound<'py, Self>,
        policy: &Bound<'py, PyAny>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        dt: &Bound<'py, PyAny>,
        steps: &Bound<'py, PyAny>,
        settings: Option<&Bound<'py, PyAny>>,
        ground: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let given = [Some(q), Some(qd), Some(dt), settings];
        let arguments = named(slf.py(), &["q", "qd", "dt", "settings"], &given)?;
        let simulate = slf.py().import("modyn._rollout")?.getattr("simulate")?;
        simulate.call1((slf, policy, arguments, steps, ground))
    }
}

/// The names of the arguments of a rollout.
const ROLLOUT_ARGUMENTS: [&str; 9] =
    ["q", "qd", "controls", "dt", "settings", "warm_start", "gains", "q_ref", "qd_ref"];

/// Returns the arguments of a rollout by their names: the state, the controls and the time, then the
/// settings, the warm start and the feedback.
fn rollout_arguments<'py>(
    required: [&Bound<'py, PyAny>; 4],
    others: [Option<&Bound<'py, PyAny>>; 5],
) -> PyResult<Bound<'py, PyDict>> {
    let given: Vec<_> = required.into_iter().map(Some).chain(others).collect();
    named(required[0].py(), &ROLLOUT_ARGUMENTS, &given)
}

/// Returns arguments by their names.
fn named<'py>(
    py: Python<'py>,
    names: &[&str],
    given: &[Option<&Bound<'py, PyAny>>],
) -> PyResult<Bound<'py, PyDict>> {
    let arguments = PyDict::new(py);
    for (name, given) in names.iter().zip(given) {
        arguments.set_item(name, given)?;
    }
    Ok(arguments)
}

impl Robot {
    /// Returns the function of the table with this name, and the index of its link.
    fn array_function(
        &self,
        name: &str,
        link: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<(Function, Option<usize>)> {
        let one = |function: &&Function| function.batched().is_none() && function.name() == name;
        let named = Function::ALL.iter().find(one).copied();
        let function = named
            .filter(|function| *function != Function::Brge)
            .ok_or_else(|| PyValueError::new_err(signature::unknown(name)))?;
        self.check_has(function)?;
        let link = match (function.row().by_link, link.filter(|link| !link.is_none())) {
            (false, None) => None,
            (true, Some(link)) => Some(self.link(link)?),
            (true, None) => {
                let message = format!("`{name}` is a function of a link: give its name as `link`");
                return Err(PyTypeError::new_err(message));
            }
            (false, Some(_)) => {
                let message = format!("`{name}` is no function of a link: leave `link` out");
                return Err(PyTypeError::new_err(message));
            }
        };
        Ok((function, link))
    }

    /// Returns the code of a step on a height field, given the code of the step and of the poses of
    /// the links that carry the shapes.
    fn on_field<S: Number>(
        &self,
        codes: [&'static ArrayCode<S>; 2],
        field: &FieldNumbers,
        derivative: Option<Derivative>,
    ) -> PyResult<ArrayCode<S>> {
        let [ArrayCode::Function(step), ArrayCode::Function(poses)] = codes else {
            return Err(no_step());
        };
        let step = FieldStep::new(self, [step, poses], field, derivative)
            .map_err(|error| PyValueError::new_err(error.to_string()))?;
        let shapes = step.shapes().clone();
        Ok(ArrayCode::Function(StateFunction::of_own_code(step, shapes)))
    }

    /// Compiles a function of arrays, unless there is the same code already, and returns its key.
    fn array_code(
        &self,
        py: Python<'_>,
        function: &EntryFunction,
        arrays: &ArrayShapes,
    ) -> PyResult<i64> {
        let result_of_planning = self.builder().plan_entries(function);
        let planning = result_of_planning.map_err(|errors| description_error(py, &errors))?;
        let planned = planning.plan.functions.first();
        let none = || PyValueError::new_err("there is no such function");
        let planned = planned.ok_or_else(none)?;
        let scalar = self.scalar();
        let machine = self.has_machine_code();
        let key = key_of(planned, arrays, scalar, machine);
        if find(key).is_none() {
            let code = AnyCode::new(planning, arrays.clone(), scalar, machine);
            let (code, reason) = code.ok_or_else(none)?;
            if let Some(reason) = reason {
                let message = format!("functions are evaluated, which is slow: {reason}");
                warn_of_machine_code(py, &message)?;
            }
            register(key, code);
        }
        Ok(key)
    }
}

/// The roles of the arguments of a step in a rollout, by their indices.
#[derive(FromPyObject, Hash)]
#[pyo3(from_item_all)]
pub struct Roles {
    /// The arguments that are the first results of the step before.
    state: Vec<usize>,
    /// The argument of the state from which a solver starts.
    start: Option<usize>,
    /// The arguments that have numbers for each step.
    sequences: Vec<usize>,
}

impl Roles {
    /// Returns whether gradients flow through an argument from step to step.
    fn is_carried(&self, argument: usize) -> bool {
        self.state.contains(&argument) && self.start != Some(argument)
    }
}

/// Returns the key of the rollout of a time step, of whose code this is the key: the results of all
/// steps, or of the last one. Given the code of the step's products, the rollout returns the
/// gradients with respect to the arguments `variables`. `roles` are the roles of the step's
/// arguments: `state`, `start` and `sequences`.
#[pyfunction]
pub fn rollout_code(
    step: i64,
    steps: usize,
    trajectory: bool,
    roles: Roles,
    reverse: Option<(i64, Vec<usize>)>,
) -> PyResult<KeyAndShapes> {
    let mut hasher = DefaultHasher::new();
    (step, steps, trajectory, &roles, &reverse).hash(&mut hasher);
    let key = (hasher.finish() >> 1).cast_signed();
    let code_of = |key: i64| find(key).ok_or_else(|| PyValueError::new_err(missing(key)));
    let (code, arrays) = match code_of(step)? {
        AnyCode::F64(step) => {
            let reverse = reverse.map(|(key, variables)| match code_of(key)? {
                AnyCode::F64(step) => Ok((step, variables)),
                AnyCode::F32(_) => Err(no_step()),
            });
            let (rollout, arrays) =
                rolled_out(step, steps, trajectory, &roles, reverse.transpose()?)?;
            (AnyCode::F64(ArrayCode::Rollout(rollout, arrays.clone())), arrays)
        }
        AnyCode::F32(step) => {
            let reverse = reverse.map(|(key, variables)| match code_of(key)? {
                AnyCode::F32(step) => Ok((step, variables)),
                AnyCode::F64(_) => Err(no_step()),
            });
            let (rollout, arrays) =
                rolled_out(step, steps, trajectory, &roles, reverse.transpose()?)?;
            (AnyCode::F32(ArrayCode::Rollout(rollout, arrays.clone())), arrays)
        }
    };
    if find(key).is_none() {
        register(key, code);
    }
    Ok((key, arrays.inputs().to_vec(), arrays.outputs().to_vec()))
}

fn no_step() -> PyErr {
    PyValueError::new_err("this is no time step with products of it")
}

/// Returns the rollout of a step with the shapes of its arrays.
fn rolled_out<S: Number>(
    step: &'static ArrayCode<S>,
    steps: usize,
    trajectory: bool,
    roles: &Roles,
    reverse: Option<(&'static ArrayCode<S>, Vec<usize>)>,
) -> PyResult<(Rollout<S>, ArrayShapes)> {
    let function = |code: &'static ArrayCode<S>| match code {
        ArrayCode::Function(function) => Ok(function),
        ArrayCode::Rollout(..) => Err(no_step()),
    };
    let step = function(step)?;
    let reverse = reverse
        .map(|(step, variables)| function(step).map(|step| Reverse { step, variables }))
        .transpose()?;
    let given = step.shapes().inputs();
    let results = step.shapes().outputs();
    let Roles { state, start, sequences } = roles;
    let fits = state.len() <= results.len()
        && state.iter().zip(results).all(|(&k, result)| given.get(k) == Some(result))
        && start.is_none_or(|start| state.contains(&start))
        && sequences.iter().all(|k| *k < given.len() && !state.contains(k))
        && reverse.as_ref().is_none_or(|reverse| {
            let varies = |k: &usize| roles.is_carried(*k) || reverse.variables.contains(k);
            let varying = (0..given.len()).filter(varies);
            reverse.step.shapes().outputs().iter().eq(varying.map(|k| &given[k]))
                && *reverse.step.shapes().inputs() == *[given, results].concat()
                && reverse.variables.is_sorted_by(|a, b| a < b)
        });
    if !fits {
        return Err(no_step());
    }
    let is_sequence: Vec<bool> = (0..given.len()).map(|k| sequences.contains(&k)).collect();
    let of_steps = |shape: &Vec<usize>| [&[steps], &**shape].concat();
    let input = |(shape, &is_sequence): (&Vec<usize>, &bool)| {
        if is_sequence { of_steps(shape) } else { shape.clone() }
    };
    let mut inputs: Vec<Vec<usize>> = given.iter().zip(&is_sequence).map(input).collect();
    let end = |shape: &Vec<usize>| if trajectory { of_steps(shape) } else { shape.clone() };
    let mut outputs: Vec<Vec<usize>> = results.iter().map(end).collect();
    if let Some(reverse) = &reverse {
        let gradients = reverse.variables.iter().map(|&k| inputs[k].clone()).collect();
        inputs.extend(std::mem::replace(&mut outputs, gradients));
    }
    let checks = step.shapes().checks().to_vec();
    let rollout = Rollout {
        step,
        state: state.clone(),
        start: *start,
        is_sequence,
        steps,
        trajectory,
        reverse,
    };
    Ok((rollout, ArrayShapes::new(inputs, outputs).with_checks(checks)))
}

/// Calls the code with this key on arrays in C order, whose leading axes are those of states and
/// are broadcast. Returns an array for each result, with the same leading axes.
#[pyfunction]
pub fn call_arrays<'py>(
    py: Python<'py>,
    key: i64,
    arrays: Vec<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyList>> {
    match find(key) {
        Some(AnyCode::F64(code)) => called(py, code, &arrays),
        Some(AnyCode::F32(code)) => called(py, code, &arrays),
        None => Err(PyValueError::new_err(missing(key))),
    }
}

/// Returns the message that no function has this key.
fn missing(key: i64) -> String {
    format!(
        "modyn: this process has not compiled the function {key:016x}; load the robot and call `modyn.jax.function` or \
         `modyn.torch.function` with it first"
    )
}

/// Returns the axes of states of an array whose axes for one state are `own`.
fn leading<'a>(axes: &'a [usize], own_axes: &[usize]) -> Result<&'a [usize], String> {
    axes.strip_suffix(own_axes).ok_or_else(|| {
        let given_shape = crate::arrays::tuple(axes);
        let expected = crate::arrays::tuple(own_axes);
        format!(
            "modyn: an array has the shape {given_shape}; expected {expected}, after axes of states"
        )
    })
}

fn called<'py, S: Number>(
    py: Python<'py>,
    code: &ArrayCode<S>,
    arrays: &[Bound<'py, PyAny>],
) -> PyResult<Bound<'py, PyList>> {
    let wrong = |message: String| PyValueError::new_err(message);
    let read = |array: &Bound<'py, PyAny>| {
        let array = in_order::<S>("call_arrays", "arrays", array)?;
        array.try_into_readonly().map_err(|error| wrong(error.to_string()))
    };
    let given = arrays.iter().map(read).collect::<PyResult<Vec<_>>>()?;
    let mut axes = Vec::with_capacity(given.len());
    let mut numbers: Vec<Numbers<'_, S>> = Vec::with_capacity(given.len());
    for (array, shape) in given.iter().zip(code.shapes().inputs()) {
        axes.push(leading(array.shape(), shape).map_err(wrong)?);
        numbers.push(array.as_slice()?.into());
    }
    let all = common(&axes).map_err(wrong)?;
    let allocated = code.shapes().outputs().iter().map(|shape| {
        let shape = [&*all, shape].concat();
        zeros::<S>(py, &shape, false)
    });
    let results: Vec<Bound<'py, PyArrayDyn<S>>> = allocated.collect::<PyResult<_>>()?;
    let broadcast =
        Broadcast::new(&axes, code.shapes().lengths()[0]).map_err(|fault| match fault {
            Fault::Memory => PyMemoryError::new_err(fault.to_string()),
            Fault::Arrays(message) => wrong(message),
        })?;
    let mut written: Vec<_> = results.iter().map(PyArrayMethods::readwrite).collect();
    let mut outputs = Vec::with_capacity(written.len());
    for array in &mut written {
        outputs.push(array.as_slice_mut()?.into());
    }
    let threads = StartedThreads::new();
    let run = || code.compute(&broadcast, &numbers, &outputs, &threads);
    // Releasing Python's lock takes longer than one state.
    let is_long = broadcast.states() > 1 || matches!(code, ArrayCode::Rollout(..));
    if is_long { py.detach(run) } else { run() }.map_err(wrong)?;
    threads.finish()?;
    drop(outputs);
    drop(written);
    PyList::new(py, results)
}
