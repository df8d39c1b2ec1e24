//! A package that was built without the feature `gpu`.

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

use crate::robot::Robot;

#[pymethods]
impl Robot {
    /// Returns the robot's kernels on the machine's graphics processor, in single precision; on a
    /// software processor where there is no other. `RuntimeError` if there is none, or the package
    /// was built without the feature `gpu`.
    fn gpu(&self) -> PyResult<()> {
        Err(PyRuntimeError::new_err(
            "this build of modyn has no kernels for graphics processors; build it with the feature `gpu`: \
             `maturin build --release --features gpu` in `modyn-python`",
        ))
    }
}
