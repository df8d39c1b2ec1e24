//! Arrays of NumPy as arguments and results, without copies where their memory allows it.
//!
//! Every argument goes through [`in_order`], and every array that a caller gives for results
//! through [`Output::new`]: the type of its numbers, its shape, its alignment and order, whether it
//! can be written, and whether it shares memory with an argument.

use std::ops::Range;

use numpy::prelude::*;
use numpy::{BorrowError, IxDyn, PyArrayDyn, PyReadonlyArrayDyn, PyReadwriteArrayDyn};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyDict, PyFloat, PyTuple};

use crate::layout::{Layout, Leaf};
use crate::memory::zeros;
use crate::number::Number;

/// An argument: its numbers, and the number of states if it has several.
pub struct Given<'py, S: Number> {
    name: &'static str,
    numbers: Numbers<'py, S>,
    /// The number of states; `None` for one state without an axis of states.
    pub states: Option<usize>,
}

enum Numbers<'py, S: Number> {
    Borrowed(PyReadonlyArrayDyn<'py, S>),
    Owned(Vec<S>),
}

impl<'py, S: Number> Given<'py, S> {
    /// Returns an argument of one state from numbers.
    pub fn owned(name: &'static str, numbers: Vec<S>) -> Self {
        Self { name, numbers: Numbers::Owned(numbers), states: None }
    }

    /// Returns the argument `name` of `function`, whose axes have these lengths for one state. An
    /// array of the scalar in C order is borrowed; all else is converted.
    ///
    /// # Errors
    ///
    /// `TypeError` if these are not real numbers, `ValueError` for another shape.
    pub fn read(
        function: &str,
        name: &'static str,
        shape: &[usize],
        object: &Bound<'py, PyAny>,
    ) -> PyResult<Self> {
        if shape.is_empty()
            && let Ok(number) = object.cast::<PyFloat>()
        {
            return Ok(Self::owned(name, vec![S::from_f64(number.value())]));
        }
        let array = in_order(function, name, object)?;
        let states = match array.shape() {
            same if same == shape => None,
            [states, rest @ ..] if rest == shape => Some(*states),
            other => {
                let one = tuple(shape);
                let many = batch(shape);
                let given_shape = tuple(other);
                return Err(PyValueError::new_err(format!(
                    "`{name}` of `{function}` has the shape {given_shape}; expected {one}, or {many} for n states"
                )));
            }
        };
        if states.is_none() {
            // The numbers of a state are few: copying them takes less time than borrowing them.
            return Ok(Self { name, numbers: Numbers::Owned(array.to_vec()?), states });
        }
        let array = array.try_into_readonly().map_err(|_| overlap(function, name))?;
        Ok(Self { name, numbers: Numbers::Borrowed(array), states })
    }

    /// Returns the argument `name` of `function` as [`read`](Self::read) does. An object that is no
    /// array can have other numbers for each scalar.
    ///
    /// # Errors
    ///
    /// Those of [`read`](Self::read).
    pub fn read_for_scalar(
        function: &str,
        name: &'static str,
        shape: &[usize],
        object: &Bound<'py, PyAny>,
    ) -> PyResult<Self> {
        let numpy = object.py().import("numpy")?;
        let array = match object.is_instance(&numpy.getattr("ndarray")?)? {
            true => object.clone(),
            false => numpy
                .call_method1("asarray", (object, S::DTYPE))
                .map_err(|reason| not_numbers(function, name, reason, object.py()))?,
        };
        Self::read(function, name, shape, &array)
    }

    /// Returns the numbers of one state after another.
    ///
    /// # Errors
    ///
    /// If another thread has changed the order of the array meanwhile.
    pub fn as_slice(&self) -> PyResult<&[S]> {
        match &self.numbers {
            Numbers::Borrowed(array) => Ok(array.as_slice()?),
            Numbers::Owned(numbers) => Ok(numbers),
        }
    }

    /// Returns the addresses of the caller's memory, if it is read in its place.
    fn addresses(&self) -> Option<Range<usize>> {
        match &self.numbers {
            Numbers::Borrowed(array) => Some(addresses(array)),
            Numbers::Owned(_) => None,
        }
    }
}

/// Returns the addresses from the first byte of an array to its last.
fn addresses<S: Number>(array: &Bound<'_, PyArrayDyn<S>>) -> Range<usize> {
    let first = array.data() as usize;
    if array.len() == 0 {
        return first..first;
    }
    let mut below = 0;
    let mut above = size_of::<S>();
    for (&length, &stride) in array.shape().iter().zip(array.strides()) {
        let extent = stride.unsigned_abs() * (length - 1);
        if stride < 0 { below += extent } else { above += extent }
    }
    first - below..first + above
}

fn overlap(function: &str, name: &str) -> PyErr {
    PyValueError::new_err(format!(
        "`{name}` of `{function}` is being written by another call; give it memory of its own"
    ))
}

/// Returns an array of the scalar that is aligned and in C order, with the numbers of an object:
/// the object itself where it is one, else a copy.
///
/// # Errors
///
/// `TypeError` if these are not real numbers.
pub fn in_order<'py, S: Number>(
    function: &str,
    name: &str,
    object: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyArrayDyn<S>>> {
    if let Ok(array) = object.cast::<PyArrayDyn<S>>()
        && array.is_c_contiguous()
        && array.is_aligned()
    {
        return Ok(array.clone());
    }
    let py = object.py();
    let convert = || {
        let array = py.import("numpy")?.call_method1("asarray", (object,))?;
        let options = PyDict::new(py);
        options.set_item("order", "C")?;
        options.set_item("casting", "same_kind")?;
        let array = array.call_method("astype", (S::DTYPE,), Some(&options))?;
        Ok::<_, PyErr>(array.cast_into::<PyArrayDyn<S>>()?)
    };
    convert().map_err(|reason| not_numbers(function, name, reason, py))
}

/// Returns the error of an object that has no real numbers. Other errors, such as an interrupt or
/// too little memory, stay as they are.
fn not_numbers(function: &str, name: &str, reason: PyErr, py: Python<'_>) -> PyErr {
    let is_about_numbers =
        reason.is_instance_of::<PyTypeError>(py) || reason.is_instance_of::<PyValueError>(py);
    if !is_about_numbers {
        return reason;
    }
    PyTypeError::new_err(format!(
        "`{name}` of `{function}` must be an array of real numbers: {reason}"
    ))
}

/// Returns a shape as Python shows it.
pub fn tuple(shape: &[usize]) -> String {
    match shape {
        [one] => format!("({one},)"),
        _ => {
            let lengths: Vec<String> = shape.iter().map(usize::to_string).collect();
            format!("({})", lengths.join(", "))
        }
    }
}

/// Returns the shape of n states as Python shows it.
fn batch(shape: &[usize]) -> String {
    match shape {
        [] => "(n,)".into(),
        _ => format!("(n, {}", tuple(shape).trim_start_matches('(').replace(",)", ")")),
    }
}

/// The form of a result.
#[derive(Clone, Copy)]
pub struct ResultForm<'a> {
    /// The name of the function, for messages.
    pub function: &'a str,
    pub layout: &'a Layout,
    /// The numbers of one state.
    pub length: usize,
    /// The states of a batch.
    pub states: Option<usize>,
}

impl ResultForm<'_> {
    /// Returns the shape of memory that has the numbers of one state after another.
    fn flat_shape(&self) -> Vec<usize> {
        self.states.into_iter().chain([self.length]).collect()
    }
}

/// The memory that a call writes, and the object that it returns.
pub struct Output<'py, S: Number> {
    memory: PyReadwriteArrayDyn<'py, S>,
    returned: Bound<'py, PyAny>,
    /// The caller's array, if its memory has another order.
    copied_to: Option<Bound<'py, PyAny>>,
}

impl<'py, S: Number> Output<'py, S> {
    /// Returns the output of this form: new arrays, or `out`. `given` are the arguments.
    ///
    /// # Errors
    ///
    /// `TypeError` if `out` is not an array of the scalar or a named tuple of them, `ValueError` if
    /// it has another shape, cannot be written or overlaps an argument.
    pub fn new(
        py: Python<'py>,
        form: ResultForm<'_>,
        out: Option<&Bound<'py, PyAny>>,
        given: &[Given<'py, S>],
    ) -> PyResult<Self> {
        let Some(out) = out else { return Self::allocated(py, form) };
        let output = match form.layout {
            Layout::Array(leaf) => Self::array(py, form, leaf, out)?,
            Layout::Tuple(class, fields) => Self::tuple(form, class.name(), fields, out)?,
        };
        // Arrays without a common base can have the same memory, by NumPy's `frombuffer`.
        let written = addresses(&output.memory);
        let is_overlapped = |given: &&Given<'py, S>| {
            let overlaps =
                |read: Range<usize>| read.start < written.end && written.start < read.end;
            given.addresses().is_some_and(overlaps)
        };
        match given.iter().find(is_overlapped) {
            None => Ok(output),
            Some(given) => Err(PyValueError::new_err(format!(
                "`out` of `{}` overlaps an argument: it has memory of `{}`",
                form.function, given.name
            ))),
        }
    }

    fn allocated(py: Python<'py>, form: ResultForm<'_>) -> PyResult<Self> {
        let ResultForm { layout, length, states, .. } = form;
        if let Layout::Array(leaf) = layout
            && let Some(is_fortran) = order(leaf, states, length)
        {
            let array = zeros::<S>(py, &leaf.shape(states), is_fortran)?;
            let returned = array.clone().into_any();
            return Ok(Self { memory: array.readwrite(), returned, copied_to: None });
        }
        let base = zeros::<S>(py, &form.flat_shape(), false)?;
        let returned = views(&base, layout, states, length)?;
        Ok(Self { memory: base.readwrite(), returned, copied_to: None })
    }

    fn array(
        py: Python<'py>,
        form: ResultForm<'_>,
        leaf: &Leaf,
        out: &Bound<'py, PyAny>,
    ) -> PyResult<Self> {
        let ResultForm { function, length, states, .. } = form;
        let array = out.cast::<PyArrayDyn<S>>().map_err(|_| {
            PyTypeError::new_err(format!("`out` of `{function}` must be an array of {}", S::DTYPE))
        })?;
        let shape = leaf.shape(states);
        if array.shape() != shape {
            let given_shape = tuple(array.shape());
            let expected = tuple(&shape);
            return Err(PyValueError::new_err(format!(
                "`out` of `{function}` has the shape {given_shape}; expected {expected}"
            )));
        }
        let strides = leaf.strides::<S>(states, length);
        let axes_with_strides = array.shape().iter().zip(array.strides()).zip(&strides);
        let fits = array.is_aligned()
            && axes_with_strides.into_iter().all(|((&n, &given_stride), &stride)| {
                n <= 1 || usize::try_from(given_stride) == Ok(stride)
            });
        let returned = out.clone();
        if fits {
            // The axes in the order of the memory, which is then in C order.
            let mut axes: Vec<usize> = (0..shape.len()).collect();
            axes.sort_by_key(|&axis| (std::cmp::Reverse(strides[axis]), axis));
            let ordered = match axes.is_sorted() {
                true => array.clone(),
                false => array.permute(Some(IxDyn(&axes)))?,
            };
            let memory = writable(function, &ordered)?;
            return Ok(Self { memory, returned, copied_to: None });
        }
        // The caller's memory has another order: the call must not write what it cannot.
        drop(writable(function, array)?);
        let memory = Self::allocated(py, form)?;
        Ok(Self { copied_to: Some(returned), ..memory })
    }

    /// Returns the output in the memory of an earlier result of the same function.
    fn tuple(
        form: ResultForm<'_>,
        class: &str,
        fields: &[(&'static str, Layout)],
        out: &Bound<'py, PyAny>,
    ) -> PyResult<Self> {
        let ResultForm { function, length, states, .. } = form;
        let wrong = || {
            PyValueError::new_err(format!(
                "`out` of `{function}` must be the `{class}` that an earlier call of it returned for as many states"
            ))
        };
        let shape = form.flat_shape();
        let mut base = None;
        let mut leaves = Vec::new();
        gather::<S>(fields, out, &mut leaves).map_err(|_| wrong())?;
        for (leaf, array) in leaves {
            let array_of_struct =
                array.getattr("base")?.cast_into::<PyArrayDyn<S>>().map_err(|_| wrong())?;
            let base = base.get_or_insert_with(|| array_of_struct.clone());
            let strides = leaf.strides::<S>(states, length);
            let is_view = array_of_struct.is(&*base)
                && base.is_c_contiguous()
                && base.is_aligned()
                && base.shape() == shape
                && array.shape() == leaf.shape(states)
                && array.strides().iter().zip(&strides).all(|(&a, &b)| usize::try_from(a) == Ok(b))
                && array.data() == base.data().wrapping_add(offset(leaf, base));
            if !is_view {
                return Err(wrong());
            }
        }
        let memory = writable(function, &base.ok_or_else(wrong)?)?;
        Ok(Self { memory, returned: out.clone(), copied_to: None })
    }

    /// Returns the memory, which has the numbers of one state after another.
    ///
    /// # Errors
    ///
    /// If another thread has changed the order of the array meanwhile.
    pub fn as_mut_slice(&mut self) -> PyResult<&mut [S]> {
        Ok(self.memory.as_slice_mut()?)
    }

    /// Returns the object that the call returns.
    pub fn finish(self) -> PyResult<Bound<'py, PyAny>> {
        let Self { memory, returned, copied_to } = self;
        drop(memory);
        match copied_to {
            None => Ok(returned),
            Some(out) => {
                out.set_item(pyo3::types::PyEllipsis::get(out.py()), returned)?;
                Ok(out)
            }
        }
    }
}

/// Returns the arrays of a named tuple with their layouts.
fn gather<'py, 'l, S: Number>(
    fields: &'l [(&'static str, Layout)],
    out: &Bound<'py, PyAny>,
    leaves: &mut Vec<(&'l Leaf, Bound<'py, PyArrayDyn<S>>)>,
) -> PyResult<()> {
    for (name, layout) in fields {
        let field = out.getattr(*name)?;
        match layout {
            Layout::Array(leaf) => leaves.push((leaf, field.cast_into()?)),
            Layout::Tuple(_, fields) => gather(fields, &field, leaves)?,
        }
    }
    Ok(())
}

fn writable<'py, S: Number>(
    function: &str,
    array: &Bound<'py, PyArrayDyn<S>>,
) -> PyResult<PyReadwriteArrayDyn<'py, S>> {
    array.try_readwrite().map_err(|reason| {
        let reason = match reason {
            BorrowError::NotWriteable => "cannot be written: it is read-only",
            _ => "overlaps an argument, or is used by another call",
        };
        PyValueError::new_err(format!("`out` of `{function}` {reason}"))
    })
}

/// Returns the shape of a result of one state, and whether it is in Fortran's order, if it is one
/// array in either order.
pub fn single(layout: &Layout, length: usize) -> Option<(Vec<usize>, bool)> {
    match layout {
        Layout::Array(leaf) => Some((leaf.shape(None), order(leaf, None, length)?)),
        Layout::Tuple(..) => None,
    }
}

/// Returns whether an array that is all numbers of a result is in Fortran's order; `None` if it is
/// in neither order.
fn order(leaf: &Leaf, states: Option<usize>, length: usize) -> Option<bool> {
    let all_axes =
        states.map(|states| (states, length)).into_iter().chain(leaf.axes.iter().copied());
    let axes: Vec<(usize, usize)> = all_axes.collect();
    // The numbers so far, from the axis of the smallest stride; `None` after an axis with another
    // stride.
    let next = |sum: Option<usize>, &(n, stride): &(usize, usize)| {
        sum.filter(|&numbers| stride == numbers).map(|numbers| numbers * n)
    };
    let all = Some(length * states.unwrap_or(1));
    if axes.iter().rev().fold(Some(1), next) == all {
        Some(false)
    } else {
        (axes.iter().fold(Some(1), next) == all).then_some(true)
    }
}

/// Returns the index of an array's first number in `base`. NumPy accepts no offset into an empty one.
fn offset<S: Number>(leaf: &Leaf, base: &Bound<'_, PyArrayDyn<S>>) -> usize {
    if base.is_empty() { 0 } else { leaf.offset }
}

/// Returns the arrays of a layout as views into `base`, in named tuples.
fn views<'py, S: Number>(
    base: &Bound<'py, PyArrayDyn<S>>,
    layout: &Layout,
    states: Option<usize>,
    length: usize,
) -> PyResult<Bound<'py, PyAny>> {
    static NDARRAY: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
    let py = base.py();
    match layout {
        Layout::Array(leaf) => {
            let ndarray = NDARRAY.import(py, "numpy", "ndarray")?;
            let shape = leaf.shape(states);
            let strides = leaf.strides::<S>(states, length);
            let shape = PyTuple::new(py, shape)?;
            let strides = PyTuple::new(py, strides)?;
            let offset = offset(leaf, base) * size_of::<S>();
            ndarray.call1((shape, S::get_dtype(py), base, offset, strides))
        }
        Layout::Tuple(class, fields) => {
            let field = |(name, layout): &(&'static str, Layout)| {
                Ok((*name, views(base, layout, states, length)?))
            };
            class.of_fields(py, fields.iter().map(field).collect::<PyResult<_>>()?)
        }
    }
}
