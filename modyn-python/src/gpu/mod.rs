//! Graphics processors: kernels of a robot's functions and of rollouts, on arrays that stay on the
//! processor.

mod array;
mod robot;
mod rollout;

use std::sync::{Mutex, PoisonError};

use modyn_codegen::Function;
use modyn_codegen::diagnostics::suggest;
use modyn_gpu::{Gpu, GpuError};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;

use crate::errors::description_error;
use crate::robot::Robot;
pub use array::GpuArray;
pub use robot::GpuRobot;
pub use rollout::GpuRollout;

#[pymethods]
impl Robot {
    /// Returns the robot's kernels on the machine's graphics processor, in single precision; on a
    /// software processor where there is no other. `RuntimeError` if there is none, or the package
    /// was built without the feature `gpu`.
    fn gpu(slf: &Bound<'_, Self>) -> PyResult<GpuRobot> {
        let py = slf.py();
        let gpu = py.detach(processor).map_err(|error| exception(py, error))?;
        Ok(GpuRobot::new(gpu, slf.clone().unbind()))
    }
}

/// Returns the machine's graphics processor. All robots share it, so that arrays of one are
/// arguments of another.
fn processor() -> Result<Gpu, GpuError> {
    static OPENED: Mutex<Option<Gpu>> = Mutex::new(None);
    let mut opened = OPENED.lock().unwrap_or_else(PoisonError::into_inner);
    match &*opened {
        Some(gpu) => Ok(gpu.clone()),
        None => Ok(opened.insert(Gpu::new()?).clone()),
    }
}

/// Returns an error of a processor as an exception.
fn exception(py: Python<'_>, error: GpuError) -> PyErr {
    match error {
        GpuError::Description(diagnostics) => description_error(py, &diagnostics),
        GpuError::NoAdapter(_) | GpuError::NoDevice(_) | GpuError::Device(_) => {
            PyRuntimeError::new_err(error.to_string())
        }
        error => PyValueError::new_err(error.to_string()),
    }
}

/// Returns the function of one state with this name.
///
/// # Errors
///
/// `ValueError` if there is none.
fn function_named(name: &str) -> PyResult<Function> {
    let one = || Function::ALL.iter().filter(|function| function.batched().is_none());
    one().find(|function| function.name() == name).copied().ok_or_else(|| {
        let help = match suggest(name, one().map(|function| function.name())) {
            Some(meant) => format!("did you mean `{meant}`?"),
            None => "`modyn.functions()` has all".into(),
        };
        PyValueError::new_err(format!("there is no function `{name}`; {help}"))
    })
}
