//! New arrays, filled without the bookkeeping of borrows, which would take as long as the dynamics of an arm.
//!
//! Unsafe code: a slice of an array's memory. It is sound because the array is made here. It is contiguous and initialized,
//! nobody else refers to it before [`filled`] returns, and Python code cannot find it: NumPy's arrays are not tracked by
//! Python's garbage collector.
#![allow(unsafe_code)]

use numpy::prelude::*;
use numpy::{IxDyn, PyArrayDyn};
use pyo3::prelude::*;

use crate::number::Number;

/// Returns a new array of this shape, in Fortran's or C order, which `fill` has filled.
///
/// # Errors
///
/// Those of `fill`.
pub fn filled<'py, S: Number>(
    py: Python<'py>,
    (shape, is_fortran): (&[usize], bool),
    fill: impl FnOnce(&mut [S]) -> PyResult<()>,
) -> PyResult<Bound<'py, PyArrayDyn<S>>> {
    let array = PyArrayDyn::<S>::zeros(py, IxDyn(shape), is_fortran);
    // SAFETY: see the header.
    fill(unsafe { array.as_slice_mut()? })?;
    Ok(array)
}
