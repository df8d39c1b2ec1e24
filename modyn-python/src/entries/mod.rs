//! Functions of arrays for libraries that differentiate by every entry of their arrays: JAX and
//! PyTorch.
//!
//! ```text
//! Robot ─ plan_entries ─▶ ArrayCode, by a key of its content ─┬─ xla.rs: XLA calls it with its buffers and threads
//!                                                             └─ codes/handle.rs: arrays of NumPy
//!       ─ emit_rows ─▶ text ─ _cuda.py: NVRTC ─▶ CudaKernel, by the same key: cuda.rs
//! ```
//!
//! Code lives as long as a [`CodeHandle`] does. The robot has one, functions of Python have one, and
//! `modyn.jax` keeps the handles of the code that programs of XLA call.

mod cuda;
mod field;
mod interface;
mod signature;
mod xla;

use std::sync::{Arc, PoisonError};

use modyn_codegen::plan::{Derivative, DerivativeMode, EntryFunction, EntrySource, Gains, Planned};
use modyn_codegen::{Builder, FloatType, Function};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

use crate::codes::{
    AnyCode, ArrayCode, ArrayShapes, CodeHandle, CodeNumber, Identity, StateFunction, no_step,
};
use crate::errors::{description_error, warn_of_machine_code};
use crate::robot::Robot;
pub use cuda::CudaKernel;
use field::{FieldForm, FieldStep};
use signature::Signature;
pub use xla::{xla_cuda_handler, xla_handler};

/// Returns a derivative, given its mode and the indices of the arrays that vary.
fn parsed(derivative: (String, Vec<usize>)) -> PyResult<Derivative> {
    let (mode, variables) = derivative;
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

/// What a time step of a rollout has beside the function of the table.
#[derive(FromPyObject)]
struct Extras {
    /// The shape of `gains`, which the arguments `q_ref` and `qd_ref` follow.
    gains: Option<[usize; 2]>,
    /// The array `cost` of the state, and `q_goal`, `qd_goal`, `state_weights` and `control_weights`.
    cost: bool,
    /// The rows and columns of a height field: the last arguments are its `heights` and `grid`, and the
    /// field sets the planes of the surfaces below the shapes.
    field: Option<[usize; 2]>,
}

#[pymethods]
impl Robot {
    /// Returns the names of the arguments of a function or a fused function, each with its shape and
    /// its default; the run-time parameters that it depends on, each by option and link with its
    /// present numbers; and its result, whose arrays are their indices. For `modyn.jax` and
    /// `modyn.torch`.
    #[pyo3(signature = (name, link=None))]
    fn _array_signature<'py>(
        &self,
        py: Python<'py>,
        name: &str,
        link: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let source = self.entry_source(name, link)?;
        Signature::of(self, &source).map_err(PyValueError::new_err)?.in_python(py, self)
    }

    /// Returns the code of a function or of a derivative. Each derivative is its mode (`forward`,
    /// `reverse` or `matrix`) and the indices of the arrays that vary. For `modyn.jax` and
    /// `modyn.torch`.
    fn _array_code(
        &self,
        py: Python<'_>,
        name: &str,
        link: Option<&Bound<'_, PyAny>>,
        derivatives: Vec<(String, Vec<usize>)>,
        extras: Extras,
    ) -> PyResult<CodeHandle> {
        let plain = self.entry_function(name, link, derivatives)?;
        let function = self.with_extras(plain, &extras)?;
        let code = self.code_of(py, &function)?;
        match extras.field {
            None => Ok(code),
            Some(shape) => self.on_field(py, &function, &code, shape),
        }
    }

    /// Returns the text of a kernel on CUDA for the function or the derivative that `_array_code`
    /// has for these arguments, without a height field.
    fn _array_text(
        &self,
        py: Python<'_>,
        name: &str,
        link: Option<&Bound<'_, PyAny>>,
        derivatives: Vec<(String, Vec<usize>)>,
        extras: Extras,
    ) -> PyResult<String> {
        let plain = self.entry_function(name, link, derivatives)?;
        let function = self.with_extras(plain, &extras)?;
        let shapes = signature::shapes(self, &function).map_err(PyValueError::new_err)?;
        self.text_of(py, &function, shapes.lengths())
    }

    /// Returns the texts of two kernels on CUDA: of the poses of the links that carry the touching
    /// shapes, (12 shapes,), from `q`; and of the settings with the planes of a height field of these
    /// rows and columns below the shapes, from the poses, `settings`, `heights` and `grid`. With them
    /// the places of the planes among the settings, each the first of twelve numbers.
    fn _field_texts(
        &self,
        py: Python<'_>,
        field: [usize; 2],
    ) -> PyResult<(String, String, Vec<usize>)> {
        let poses = field::poses(self);
        let results: Vec<usize> = poses.results.iter().map(Vec::len).collect();
        let of_poses = self.text_of(py, &poses, [&[self.model().nq()], &results])?;
        let count = self.model().touching_shapes().len();
        let places = field::planes(count).map(|plane| plane.start).collect();
        Ok((of_poses, field::planes_text(self, field), places))
    }
}

impl Robot {
    /// Returns a function of arrays or its derivative, as `_array_code` has it without extras.
    fn entry_function(
        &self,
        name: &str,
        link: Option<&Bound<'_, PyAny>>,
        derivatives: Vec<(String, Vec<usize>)>,
    ) -> PyResult<EntryFunction> {
        let source = self.entry_source(name, link)?;
        let derivatives = derivatives.into_iter().map(parsed).collect::<PyResult<Vec<_>>>()?;
        let signature = Signature::of(self, &source).map_err(PyValueError::new_err)?;
        let results = signature.places();
        Ok(EntryFunction { source, results, feedback: None, cost: false, derivatives })
    }

    /// Returns a function of arrays with a feedback and with a cost, if there are any.
    fn with_extras(&self, function: EntryFunction, extras: &Extras) -> PyResult<EntryFunction> {
        let Extras { gains, cost, .. } = *extras;
        let nv = self.model().nv();
        let of_shape = |shape: [usize; 2]| {
            let mut forms = [Gains::Matrix, Gains::Diagonal].into_iter();
            forms.find(|form| form.shape(nv) == shape).ok_or_else(|| {
                PyValueError::new_err(format!("`gains` has {shape:?} rows and columns"))
            })
        };
        let feedback = gains.map(of_shape).transpose()?;
        let mut results = function.results;
        let count = results.iter().map(Vec::len).sum();
        results.extend(cost.then(|| vec![count]));
        Ok(EntryFunction { results, feedback, cost, ..function })
    }

    /// Returns the builder of functions of arrays, which can name the robot's fused functions.
    fn builder_of_entries(&self) -> Builder {
        self.builder().clone().fused(self.fused_functions().cloned())
    }

    /// Returns the text of a kernel on CUDA, given the numbers of each argument and of each result.
    fn text_of(
        &self,
        py: Python<'_>,
        function: &EntryFunction,
        lengths: [&[usize]; 2],
    ) -> PyResult<String> {
        let builder = self.builder_of_entries().scalar(self.scalar());
        let text = py.detach(|| builder.emit_rows(function, lengths));
        text.map_err(|errors| description_error(py, &errors))
    }

    /// Returns the function of the table with this name and link, or the fused function.
    fn entry_source(&self, name: &str, link: Option<&Bound<'_, PyAny>>) -> PyResult<EntrySource> {
        let one = |function: &&Function| function.batched().is_none() && function.name() == name;
        let named = Function::ALL.iter().find(one).copied();
        let function = named.filter(|function| *function != Function::Brge);
        if function.is_none() && self.fused_named(name).is_none() {
            return Err(PyValueError::new_err(signature::unknown(name, self)));
        }
        if let Some(step) = function.and_then(|function| function.row().derivatives_of) {
            let step = step.name();
            let message = format!("`{name}` is no function of arrays: differentiate `{step}`");
            return Err(PyValueError::new_err(message));
        }
        function.map_or(Ok(()), |function| self.check_has(function))?;
        let by_link = function.is_some_and(|function| function.row().by_link);
        let link = match (by_link, link.filter(|link| !link.is_none())) {
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
        Ok(match function {
            Some(function) => EntrySource::Table { function, link },
            None => EntrySource::Fused(name.into()),
        })
    }

    /// Returns the code of a step on a height field with this many rows and columns, given the code of
    /// the step or of its derivative.
    fn on_field(
        &self,
        py: Python<'_>,
        function: &EntryFunction,
        step: &CodeHandle,
        shape: [usize; 2],
    ) -> PyResult<CodeHandle> {
        let form = FieldForm::new(self, function, shape).map_err(PyValueError::new_err)?;
        let poses = self.code_of(py, &field::poses(self))?;
        let identity = Identity::of((step.identity(), poses.identity(), format!("{form:?}")));
        CodeHandle::new(identity, || match step.code() {
            AnyCode::F64(step) => self.step_on_field(step, poses.code(), form),
            AnyCode::F32(step) => self.step_on_field(step, poses.code(), form),
        })
    }

    fn step_on_field<S: CodeNumber>(
        &self,
        step: &ArrayCode<S>,
        poses: &AnyCode,
        form: FieldForm,
    ) -> PyResult<AnyCode> {
        let ArrayCode::Function(step) = step else { return Err(no_step()) };
        let Some(ArrayCode::Function(poses)) = S::code(poses) else { return Err(no_step()) };
        let on_field = FieldStep::new(self, [step, poses].map(Arc::clone), form);
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
        let result_of_planning = self.builder_of_entries().plan_entries(function);
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
