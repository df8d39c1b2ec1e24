//! New arrays. [`filled`] fills one without the bookkeeping of borrows, which would take as long as
//! the dynamics of an arm.
//!
//! Unsafe code: a call of NumPy's C interface, and a slice of an array's memory. The call has as
//! many lengths as it says, gives away a reference to the type of numbers, as `PyArray_Zeros`
//! expects, and its result is checked. The slice is sound because the array is made here. It is
//! contiguous and initialized, nobody else refers to it before [`filled`] returns, and Python code
//! cannot find it: NumPy's arrays are not tracked by Python's garbage collector.
#![allow(unsafe_code)]

use std::ffi::c_int;

use numpy::prelude::*;
use numpy::{PY_ARRAY_API, PyArrayDyn};
use pyo3::exceptions::PyMemoryError;
use pyo3::prelude::*;

use crate::number::Number;

/// Returns a new array of zeros of this shape, in Fortran's or C order.
///
/// # Errors
///
/// `MemoryError` if the array does not fit in memory.
pub fn zeros<'py, S: Number>(
    py: Python<'py>,
    shape: &[usize],
    is_fortran: bool,
) -> PyResult<Bound<'py, PyArrayDyn<S>>> {
    let too_large = |shape: &[usize]| {
        PyMemoryError::new_err(format!(
            "an array of the shape {shape:?} of {} does not fit in memory",
            S::DTYPE
        ))
    };
    let signed: Result<Vec<isize>, _> = shape.iter().map(|&n| isize::try_from(n)).collect();
    let mut lengths = signed.map_err(|_| too_large(shape))?;
    let bytes = shape.iter().try_fold(size_of::<S>(), |bytes, &n| bytes.checked_mul(n));
    if bytes.is_none_or(|bytes| isize::try_from(bytes).is_err()) {
        return Err(too_large(shape));
    }
    let count = c_int::try_from(lengths.len()).map_err(|_| too_large(shape))?;
    let order = c_int::from(is_fortran);
    // SAFETY: see the header.
    let array = unsafe {
        let dtype = S::get_dtype(py).into_dtype_ptr();
        let array = PY_ARRAY_API.PyArray_Zeros(py, count, lengths.as_mut_ptr(), dtype, order);
        Bound::from_owned_ptr_or_err(py, array)?
    };
    Ok(array.cast_into::<PyArrayDyn<S>>()?)
}

/// Returns a new array of this shape, in Fortran's or C order, which `fill` has filled.
///
/// # Errors
///
/// Those of `fill`; `MemoryError` if the array does not fit in memory.
pub fn filled<'py, S: Number>(
    py: Python<'py>,
    shape: &[usize],
    is_fortran: bool,
    fill: impl FnOnce(&mut [S]) -> PyResult<()>,
) -> PyResult<Bound<'py, PyArrayDyn<S>>> {
    let array = zeros::<S>(py, shape, is_fortran)?;
    // SAFETY: see the header.
    fill(unsafe { array.as_slice_mut()? })?;
    Ok(array)
}

/// Returns numbers, this often one after the other.
///
/// # Errors
///
/// `MemoryError` if they do not fit in memory.
pub fn repeated<S: Number>(numbers: &[S], times: usize) -> PyResult<Vec<S>> {
    let too_many = || PyMemoryError::new_err("the arguments of all states do not fit in memory");
    let count = numbers.len().checked_mul(times).ok_or_else(too_many)?;
    let mut repeated = Vec::new();
    repeated.try_reserve_exact(count).map_err(|_| too_many())?;
    (0..times).for_each(|_| repeated.extend_from_slice(numbers));
    Ok(repeated)
}
