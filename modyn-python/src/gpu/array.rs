//! Arrays on a graphics processor, to and from NumPy.

use modyn_gpu::Gpu;
use numpy::prelude::*;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use super::exception;
use crate::arrays::{Given, Output, ResultForm, in_order, tuple};
use crate::checks::Check;
use crate::layout::{Layout, Leaf};

/// Numbers for n states on a graphics processor, in single precision: arguments and results of
/// kernels.
#[pyclass(frozen, module = "modyn")]
pub struct GpuArray {
    pub(super) array: modyn_gpu::GpuArray,
    layout: Layout,
}

impl GpuArray {
    /// Returns an array whose states have this layout.
    pub(super) fn new(array: modyn_gpu::GpuArray, layout: Layout) -> Self {
        Self { array, layout }
    }
}

#[pymethods]
impl GpuArray {
    /// Waits until the numbers are computed, and returns a copy of them: an array of `float32`, or
    /// a named tuple of arrays as the robot's function returns. The first axis counts states.
    fn numpy<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let scalars = self.array.scalars();
        let states = self.array.states();
        let columns = py.detach(|| self.array.read()).map_err(|error| exception(py, error))?;
        let form = ResultForm {
            function: "numpy",
            layout: &self.layout,
            length: scalars,
            states: Some(states),
        };
        let mut output = Output::<f32>::new(py, form, None, &[])?;
        for (i, state) in output.as_mut_slice()?.chunks_exact_mut(scalars).enumerate() {
            for (j, number) in state.iter_mut().enumerate() {
                *number = columns[j * states + i];
            }
        }
        output.finish()
    }

    /// The number of states.
    fn __len__(&self) -> usize {
        self.array.states()
    }

    fn __repr__(&self) -> String {
        let scalars = self.array.scalars();
        let states = self.array.states();
        format!("<modyn.GpuArray of {states} states, {scalars} numbers each>")
    }
}

/// Returns the layout of states that are arrays of these lengths.
pub(super) fn layout(shape: &[usize]) -> Layout {
    let stride = |axis: usize| shape[axis + 1..].iter().product();
    let axes = shape.iter().enumerate().map(|(axis, n)| (*n, stride(axis))).collect();
    Layout::Array(Leaf { offset: 0, axes })
}

/// Copies numbers to the processor, the numbers of one state after another.
pub(super) fn upload(
    py: Python<'_>,
    gpu: &Gpu,
    numbers: &[f32],
    states: usize,
) -> PyResult<modyn_gpu::GpuArray> {
    let scalars = numbers.len() / states.max(1);
    let uploaded = py.detach(|| {
        let columns = (0..scalars).flat_map(|j| (0..states).map(move |i| i * scalars + j));
        gpu.upload(&columns.map(|place| numbers[place]).collect::<Vec<f32>>(), states)
    });
    uploaded.map_err(|error| exception(py, error))
}

/// Returns the array of n states of any shape, and the shape of a state.
pub(super) fn any(
    py: Python<'_>,
    gpu: &Gpu,
    object: &Bound<'_, PyAny>,
) -> PyResult<(modyn_gpu::GpuArray, Vec<usize>)> {
    let contiguous = py.import("numpy")?.call_method1("ascontiguousarray", (object, "float32"))?;
    let array = in_order::<f32>("upload", "array", &contiguous)?.try_readonly()?;
    let [states, shape @ ..] = array.shape() else {
        let shape = tuple(array.shape());
        return Err(PyValueError::new_err(format!(
            "an array of n states has an axis: not {shape}"
        )));
    };
    Ok((upload(py, gpu, array.as_slice()?, *states)?, shape.to_vec()))
}

/// An argument of a kernel: on the processor, or yet to be copied.
pub(super) enum Argument<'py> {
    OnProcessor(modyn_gpu::GpuArray),
    Given(Given<'py, f32>),
}

impl<'py> Argument<'py> {
    /// Returns an argument of the function of this name, whose states have this shape.
    ///
    /// # Errors
    ///
    /// `TypeError` if these are not real numbers, `ValueError` for another shape, or a number out
    /// of range.
    pub fn read(
        function: &str,
        name: &'static str,
        check: Option<Check>,
        shape: &[usize],
        object: &Bound<'py, PyAny>,
    ) -> PyResult<Self> {
        if let Ok(array) = object.cast::<GpuArray>() {
            return Ok(Self::OnProcessor(array.get().array.clone()));
        }
        let given = Given::read_for_scalar(function, name, shape, object)?;
        if let Some(check) = check {
            let checked = check.run(name, given.as_slice()?, shape.iter().product());
            checked.map_err(PyValueError::new_err)?;
        }
        Ok(Self::Given(given))
    }

    /// Returns the number of states; `None` for one state without an axis of states.
    pub fn states(&self) -> Option<usize> {
        match self {
            Self::OnProcessor(array) => Some(array.states()),
            Self::Given(given) => given.states,
        }
    }

    /// Returns the array on the processor; one state is repeated this often.
    pub fn uploaded(
        self,
        py: Python<'_>,
        gpu: &Gpu,
        repeated: usize,
    ) -> PyResult<modyn_gpu::GpuArray> {
        match self {
            Self::OnProcessor(array) => Ok(array),
            Self::Given(given) => match given.states {
                Some(states) => upload(py, gpu, given.as_slice()?, states),
                None => upload(
                    py,
                    gpu,
                    &crate::memory::repeated(given.as_slice()?, repeated)?,
                    repeated,
                ),
            },
        }
    }
}
