//! The extension module of the Python package `modyn`.
//!
//! ```text
//! load ─▶ Robot ─ first use ─▶ RobotFunction ─ arrays ─▶ machine code (or programs, evaluated) ─ layout ─▶ arrays
//! ```
//!
//! `methods.rs` has a method for each function of modyn's table; `cargo xtask pages` writes it.

mod arrays;
mod change;
mod checks;
mod codes;
mod conventions;
mod entries;
mod errors;
mod evaluated;
mod factorization;
mod function;
#[cfg_attr(not(feature = "gpu"), path = "without_gpu.rs")]
mod gpu;
mod layout;
mod memory;
mod methods;
mod number;
mod options;
mod parameters;
mod pictures;
mod pool;
mod robot;

use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

use modyn_codegen::Function;
use modyn_codegen::read::file::read_text;
use pyo3::exceptions::{PyOSError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

use crate::errors::description_error;
use crate::robot::{Robot, Source};

/// Reads the robot of a file: URDF, xacro, SDF or MJCF.
///
/// The keyword arguments are modyn's options about a robot: `gravity`, `base`, `mimic`, `armature`,
/// `rotors`, `loops`, `contacts`, `ground`, `actuators`, `joint_friction`, `unphysical_inertia`,
/// `unsupported_forces`, `packages`, `xacro_args`, `fused`, `modules`, `scalar`, `runtime_gravity`,
/// `runtime_inertia` and `payload`; with `machine_code=False`, functions are evaluated instead of
/// compiled.
///
/// `OSError` if the file cannot be read, `DescriptionError` with file, line and column if the
/// description is wrong.
#[pyfunction]
#[pyo3(signature = (path, /, **options))]
fn load(
    py: Python<'_>,
    path: &Bound<'_, PyAny>,
    options: Option<&Bound<'_, PyDict>>,
) -> PyResult<Robot> {
    let path: PathBuf = py.import("os")?.call_method1("fsdecode", (path,))?.extract()?;
    if is_description(&path.to_string_lossy()) && !path.exists() {
        let message = "`load` takes the path of a file, and this is the text of a description: use `modyn.loads`";
        return Err(PyValueError::new_err(message));
    }
    let file = std::fs::File::open(&path).map_err(|error| unreadable(py, &path, error))?;
    let name = path.display().to_string();
    let text = read_text(&name, file).map_err(|errors| description_error(py, &errors))?;
    // The folder in which files that the description names are.
    let folder = std::path::absolute(&path).unwrap_or(path).parent().map(Path::to_owned);
    read(py, Source { text, file: name, folder }, options)
}

/// Returns the exception of a file that cannot be opened: an `OSError` with the number, the reason
/// and the file's name.
fn unreadable(py: Python<'_>, path: &Path, error: std::io::Error) -> PyErr {
    let Some(number) = error.raw_os_error() else {
        return error.into();
    };
    let reason = py.import("os").and_then(|os| os.call_method1("strerror", (number,)));
    match reason {
        Ok(reason) => PyOSError::new_err((number, reason.unbind(), path.as_os_str().to_owned())),
        Err(error) => error,
    }
}

/// Reads the robot of a text: URDF, xacro, SDF or MJCF; `file` is the name in diagnostics, and `folder`
/// the folder of files which the text names: without it, no other file is read. The other keyword
/// arguments are the same as for `load`.
#[pyfunction]
#[pyo3(signature = (text, /, file="robot", *, folder=None, **options))]
fn loads(
    py: Python<'_>,
    text: &Bound<'_, PyAny>,
    file: &str,
    folder: Option<PathBuf>,
    options: Option<&Bound<'_, PyDict>>,
) -> PyResult<Robot> {
    let Ok(text) = text.extract::<String>() else {
        let class = text.get_type().name()?;
        let message = format!(
            "`loads` takes the text of a description as str, not {class}; `modyn.load` takes the path of a file"
        );
        return Err(PyTypeError::new_err(message));
    };
    let is_path = !text.trim().is_empty() && !text.contains(['<', '\n', '\0', '#']);
    if is_path {
        let message = "`loads` takes the text of a description, and this is none: use `modyn.load` \
                       for the path of a file";
        return Err(PyValueError::new_err(format!("{message}, {text:?}")));
    }
    read(py, Source { text, file: file.into(), folder }, options)
}

/// Returns whether this is the text of a description in place of a path.
fn is_description(path: &str) -> bool {
    let path = path.trim_start_matches(['\u{feff}', ' ', '\t', '\r', '\n']);
    path.starts_with('<') || path.contains('\n')
}

fn read(py: Python<'_>, source: Source, options: Option<&Bound<'_, PyDict>>) -> PyResult<Robot> {
    match options {
        Some(options) => Robot::read(py, source, options),
        None => Robot::read(py, source, &PyDict::new(py)),
    }
}

/// Sets the number of threads that share a batch; `None` for all processors, the default.
#[pyfunction]
#[pyo3(signature = (threads))]
fn set_threads(threads: Option<usize>) -> PyResult<()> {
    if threads == Some(0) {
        return Err(PyValueError::new_err("`threads` must be at least 1"));
    }
    pool::THREADS.store(threads.unwrap_or(0), Ordering::Relaxed);
    Ok(())
}

/// Returns the names of the functions of one state in modyn's table, which are methods of `Robot`.
#[pyfunction]
fn functions(py: Python<'_>) -> PyResult<Bound<'_, PyList>> {
    let one = Function::ALL.iter().filter(|function| function.batched().is_none());
    PyList::new(py, one.map(|function| function.name()))
}

/// Returns the names of the options of `load`, each with an example, its default and its
/// documentation.
#[pyfunction]
fn options_table() -> Vec<(&'static str, String, &'static str, &'static str)> {
    options::rows().map(|row| (row.name, options::example(row), row.default, row.docs)).collect()
}

/// The extension module.
#[pymodule]
mod _modyn {
    #[pymodule_export]
    use super::codes::CodeHandle;
    #[pymodule_export]
    use super::conventions::{
        mujoco_from_qacc, mujoco_from_qpos, mujoco_from_qvel, mujoco_to_qacc, mujoco_to_qpos,
        mujoco_to_qvel, pinocchio_angle, pinocchio_cos_sin,
    };
    #[pymodule_export]
    use super::entries::{CudaKernel, xla_cuda_handler, xla_handler};
    #[pymodule_export]
    use super::factorization::Factorization;
    #[cfg(feature = "gpu")]
    #[pymodule_export]
    use super::gpu::{GpuArray, GpuRobot, GpuRollout};
    #[pymodule_export]
    use super::robot::Robot;
    #[pymodule_export]
    use super::{functions, load, loads, options_table, set_threads};
}
