//! New arrays, filled without the bookkeeping of borrows, which would take as long as the dynamics of an arm.
//!
//! Unsafe code: a slice of an array's memory. It is sound because the array is made here. It is contiguous and initialized,
//! nobody else refers to it before [`filled`] returns, and Python code cannot find it: NumPy's arrays are not tracked by
//! Python's garbage collector.
#![allow(unsafe_code)]

use numpy::prelude::*;
use numpy::{IxDyn, PyArrayDyn};
use pyo3::prelude::*;

/// Returns a new array of this shape, in Fortran's or C order, which `fill` has filled.
///
/// # Errors
///
/// Those of `fill`.
pub fn filled<'py>(
    py: Python<'py>,
    (shape, is_fortran): (&[usize], bool),
    fill: impl FnOnce(&mut [f64]) -> PyResult<()>,
) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    let array = PyArrayDyn::<f64>::zeros(py, IxDyn(shape), is_fortran);
    // SAFETY: see the header.
    fill(unsafe { array.as_slice_mut()? })?;
    Ok(array)
}
