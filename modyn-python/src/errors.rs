//! Diagnostics as exceptions and warnings of Python.

use std::collections::BTreeSet;
use std::sync::{Mutex, PoisonError};

use modyn_codegen::diagnostics::{Diagnostic, Diagnostics, Severity};
use pyo3::prelude::*;
use pyo3::types::PyList;

/// Returns the exception `DescriptionError` with all errors of a description.
pub fn description_error(py: Python<'_>, errors: &Diagnostics) -> PyErr {
    let raised = || {
        let all = errors.iter().map(|error| diagnostic(py, error)).collect::<PyResult<Vec<_>>>()?;
        let class = py.import("modyn._errors")?.getattr("DescriptionError")?;
        class.call1((errors.to_string(), PyList::new(py, all)?))
    };
    raised().map_or_else(|error| error, PyErr::from_value)
}

/// Issues `DescriptionWarning` for each warning of a description.
///
/// # Errors
///
/// If warnings are errors.
pub fn warn_of_description(py: Python<'_>, warnings: &[Diagnostic]) -> PyResult<()> {
    for warning in warnings {
        let class = py.import("modyn._errors")?.getattr("DescriptionWarning")?;
        let warning = class.call1((warning.to_string(), diagnostic(py, warning)?))?;
        py.import("warnings")?.call_method1("warn", (warning,))?;
    }
    Ok(())
}

/// Issues `MachineCodeWarning`, once for each reason.
///
/// # Errors
///
/// If warnings are errors.
pub fn warn_of_machine_code(py: Python<'_>, reason: &str) -> PyResult<()> {
    static ISSUED: Mutex<BTreeSet<String>> = Mutex::new(BTreeSet::new());
    if !ISSUED.lock().unwrap_or_else(PoisonError::into_inner).insert(reason.to_owned()) {
        return Ok(());
    }
    let class = py.import("modyn._errors")?.getattr("MachineCodeWarning")?;
    py.import("warnings")?.call_method1("warn", (reason, class))?;
    Ok(())
}

fn diagnostic<'py>(py: Python<'py>, diagnostic: &Diagnostic) -> PyResult<Bound<'py, PyAny>> {
    let class = py.import("modyn._errors")?.getattr("Diagnostic")?;
    let severity = match diagnostic.severity {
        Severity::Error => "error",
        Severity::Warning => "warning",
    };
    class.call1((
        severity,
        diagnostic.code.to_string(),
        diagnostic.file.as_deref(),
        diagnostic.position.map(|position| position.line),
        diagnostic.position.map(|position| position.column),
        diagnostic.subject.as_ref().map(ToString::to_string),
        diagnostic.message.as_str(),
        diagnostic.help.as_deref(),
    ))
}
