//! Functions of arrays for libraries that differentiate by every entry of their arrays: JAX and
//! PyTorch.
//!
//! ```text
//! Robot ─ plan_entries ─▶ ArrayCode, by a key of its content ─┬─ xla.rs: XLA calls it with its buffers and threads
//!                                                             └─ codes/handle.rs: arrays of NumPy
//! ```
//!
//! Code lives as long as a [`CodeHandle`] does. The robot has one, functions of Python have one, and
//! `modyn.jax` keeps the handles of the code that programs of XLA call.

mod field;
mod interface;
mod signature;
mod xla;

use std::sync::{Arc, PoisonError};

use modyn_codegen::plan::{Derivative, DerivativeMode, EntryFunction, Planned};
use modyn_codegen::{FloatType, Function};
use numpy::PyReadonlyArray2;
use numpy::prelude::*;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::codes::{
    AnyCode, ArrayCode, ArrayShapes, CodeHandle, CodeNumber, Identity, StateFunction, no_step,
};
use crate::errors::{description_error, warn_of_machine_code};
use crate::robot::Robot;
use field::{FieldNumbers, FieldStep};
pub use xla::xla_handler;

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

/// Returns the identity of a function: of its program, its arrays and its scalar.
fn identity_of(
    planned: &Planned,
    arrays: &ArrayShapes,
    scalar: FloatType,
    machine: bool,
) -> Identity {
    let programs = planned.kernels.straight().into_iter().flat_map(<[_; 2]>::from);
    let texts: Vec<String> = programs.map(ToString::to_string).collect();
    let version = env!("CARGO_PKG_VERSION");
    Identity::of((version, arrays, scalar == FloatType::F32, machine, texts))
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

    /// Returns the code of a function or of a derivative. Each derivative is its mode (`forward`,
    /// `reverse` or `matrix`) and the indices of the arrays that vary. With `feedback`, a time step has the arguments
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
    ) -> PyResult<CodeHandle> {
        let (function, link) = self.array_function(name, link)?;
        let derivatives = derivatives.into_iter().map(parsed).collect::<PyResult<Vec<_>>>()?;
        let mut results = signature::places(self, function);
        let count = results.iter().map(Vec::len).sum();
        results.extend(cost.then(|| vec![count]));
        let function = EntryFunction { function, link, results, feedback, cost, derivatives };
        self.code_of(py, &function)
    }
}

#[pymethods]
impl Robot {
    /// Returns the code of `step` on a height field, which sets the planes of the surfaces: given
    /// the code of the step, or of its derivative, which is a mode (`forward`, `reverse` or
    /// `matrix`) and the indices of the arrays that vary. `heights`: (rows, columns).
    #[pyo3(signature = (step, derivative, heights, origin, spacing))]
    fn _field_code(
        &self,
        py: Python<'_>,
        step: &CodeHandle,
        derivative: Option<(String, Vec<usize>)>,
        heights: PyReadonlyArray2<'_, f64>,
        origin: [f64; 2],
        spacing: [f64; 2],
    ) -> PyResult<CodeHandle> {
        let derivative = derivative.map(parsed).transpose()?;
        let poses = self.code_of(py, &field::poses(self))?;
        let columns = heights.shape()[1];
        let heights = heights.as_slice()?;
        let numbers = FieldNumbers { origin, spacing, columns, heights };
        let identity = Identity::of((
            (step.identity(), poses.identity()),
            format!("{derivative:?}"),
            numbers.bits(),
        ));
        CodeHandle::new(identity, || match step.code() {
            AnyCode::F64(step) => self.on_field(step, poses.code(), &numbers, derivative),
            AnyCode::F32(step) => self.on_field(step, poses.code(), &numbers, derivative),
        })
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
    /// (steps, nv); one step stands for all of them. With `step="actuated"`, the function
    /// `step_actuated`, `controls` has a control for each actuator, (steps, controls), and further
    /// arguments are `act`: the activations before the first step, by default zeros; and `applied`:
    /// (nv,), joint forces of all steps, by default zeros; there is no feedback and no `ground`. With
    /// `cost`, a `QuadraticCost`, each step adds
    /// the cost of its forces and of the state after it. Leading axes are those of motions, and are
    /// broadcast. Result: `RolloutStates`: `q` and `qd`; with a cost `RolloutCosts`; of `step`
    /// `StepSolution` and of `actuated` `ActuatedStep`, with the largest `residual` and `iterations` of all steps with
    /// `trajectory=False`.
    #[pyo3(signature = (
        q, qd, controls, dt, *, step="semi_implicit", gains=None, q_ref=None, qd_ref=None,
        cost=None, settings=None, warm_start=None, act=None, applied=None, ground=None,
        trajectory=true,
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
        act: Option<&Bound<'py, PyAny>>,
        applied: Option<&Bound<'py, PyAny>>,
        ground: Option<&Bound<'py, PyAny>>,
        trajectory: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let others = [act, applied, settings, warm_start, gains, q_ref, qd_ref];
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
        act=None, applied=None, ground=None, trajectory=true,
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
        act: Option<&Bound<'py, PyAny>>,
        applied: Option<&Bound<'py, PyAny>>,
        ground: Option<&Bound<'py, PyAny>>,
        trajectory: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let others = [act, applied, settings, warm_start, gains, q_ref, qd_ref];
        let arguments = rollout_arguments([q, qd, controls, dt], others)?;
        let vjp = slf.py().import("modyn._rollout")?.getattr("rollout_vjp")?;
        let weights = (q_weights, qd_weights, cost_weights);
        vjp.call1((slf, arguments, weights, (step, ground), trajectory, cost))
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
const ROLLOUT_ARGUMENTS: [&str; 11] = [
    "q",
    "qd",
    "controls",
    "dt",
    "act",
    "applied",
    "settings",
    "warm_start",
    "gains",
    "q_ref",
    "qd_ref",
];

/// Returns the arguments of a rollout by their names: the state, the controls and the time, then the
/// activations, the applied forces, the settings, the warm start and the feedback.
fn rollout_arguments<'py>(
    required: [&Bound<'py, PyAny>; 4],
    others: [Option<&Bound<'py, PyAny>>; 7],
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
        if let Function::StepDerivatives | Function::StepActuatedDerivatives = function {
            let step = name.trim_end_matches("_derivatives");
            let message = format!("`{name}` is no function of arrays: differentiate `{step}`");
            return Err(PyValueError::new_err(message));
        }
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
    fn on_field<S: CodeNumber>(
        &self,
        step: &ArrayCode<S>,
        poses: &AnyCode,
        field: &FieldNumbers<'_>,
        derivative: Option<Derivative>,
    ) -> PyResult<AnyCode> {
        let (ArrayCode::Function(step), Some(ArrayCode::Function(poses))) = (step, S::code(poses))
        else {
            return Err(no_step());
        };
        let functions = [step, poses].map(Arc::clone);
        let on_field = FieldStep::new(self, functions, field, derivative)
            .map_err(|error| PyValueError::new_err(error.to_string()))?;
        let shapes = on_field.shapes().clone();
        let function = StateFunction::of_own_code(on_field, shapes);
        Ok(S::any(ArrayCode::Function(Arc::new(function))))
    }

    /// Returns the code of a function of arrays, which is compiled at its first use, and is the
    /// robot's as long as the robot lives.
    fn code_of(&self, py: Python<'_>, function: &EntryFunction) -> PyResult<CodeHandle> {
        let codes = || self.array_codes.lock().unwrap_or_else(PoisonError::into_inner);
        let known =
            codes().iter().find(|(other, _)| other == function).map(|(_, code)| code.clone());
        if let Some(code) = known {
            return Ok(code);
        }
        let arrays = signature::shapes(self, function).map_err(PyValueError::new_err)?;
        let code = self.compile_arrays(py, function, &arrays)?;
        codes().push((function.clone(), code.clone()));
        Ok(code)
    }

    /// Compiles a function of arrays, unless there is the same code already.
    fn compile_arrays(
        &self,
        py: Python<'_>,
        function: &EntryFunction,
        arrays: &ArrayShapes,
    ) -> PyResult<CodeHandle> {
        let result_of_planning = self.builder().plan_entries(function);
        let planning = result_of_planning.map_err(|errors| description_error(py, &errors))?;
        let planned = planning.plan.functions.first();
        let none = || PyValueError::new_err("there is no such function");
        let planned = planned.ok_or_else(none)?;
        let scalar = self.scalar();
        let machine = self.has_machine_code();
        CodeHandle::new(identity_of(planned, arrays, scalar, machine), || {
            let code = AnyCode::new(planning, arrays.clone(), scalar, machine);
            let (code, reason) = code.ok_or_else(none)?;
            if let Some(reason) = reason {
                let message = format!("functions are evaluated, which is slow: {reason}");
                warn_of_machine_code(py, &message)?;
            }
            Ok(code)
        })
    }
}
