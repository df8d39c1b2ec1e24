//! Kernels of functions of arrays on CUDA, which PyTorch and XLA start on their streams.
//!
//! `_cuda.py` opens the driver's library, and compiles and loads the kernels; here is what each call
//! needs: the rows that arguments have for each state, and the launch.
//!
//! Unsafe code: the driver's functions are called by their addresses, on addresses of arrays. It is
//! sound because `_cuda.py`, the only caller of `CudaKernel`, takes the addresses from the library
//! that it keeps open, whose functions have had these types since CUDA 4.0, and passes the shapes of
//! arrays that PyTorch keeps until the stream has passed the kernel; XLA keeps the arrays of a call in
//! the same way (see `xla.rs`). The driver copies the kernel's parameters before it returns, so the
//! pointers to them end with the call. The kernel reads and writes only the rows of its arrays, as
//! `emit_rows` documents: `rows_of` makes `rows` the number of an array's rows, and `stride` is the
//! stride of the tensor.
#![allow(unsafe_code)]

use std::collections::HashMap;
use std::ffi::{CStr, c_char, c_int, c_uint, c_void};
use std::mem::transmute;
use std::ptr::{null, null_mut};
use std::sync::{Arc, OnceLock, PoisonError, RwLock};

use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;

use crate::codes::{common, leading};

/// The number of threads of a block, no more than `emit_rows` allows.
const BLOCK: usize = 128;

type Pointer = *mut c_void;
type Launch = unsafe extern "C" fn(
    Pointer,
    c_uint,
    c_uint,
    c_uint,
    c_uint,
    c_uint,
    c_uint,
    c_uint,
    Pointer,
    *mut Pointer,
    *mut Pointer,
) -> c_int;
type PushContext = unsafe extern "C" fn(Pointer) -> c_int;
type PopContext = unsafe extern "C" fn(*mut Pointer) -> c_int;
type ErrorText = unsafe extern "C" fn(c_int, *mut *const c_char) -> c_int;

/// The functions of the driver's library.
struct Driver {
    launch: Launch,
    push: PushContext,
    pop: PopContext,
    error: ErrorText,
}

impl Driver {
    /// Returns an error of the driver as a message.
    fn checked(&self, code: c_int) -> Result<(), String> {
        if code == 0 {
            return Ok(());
        }
        let mut text = null();
        // SAFETY: see the header. The driver's texts are constants.
        let known = unsafe { (self.error)(code, &raw mut text) == 0 && !text.is_null() };
        // SAFETY: as above.
        let words = known.then(|| unsafe { CStr::from_ptr(text) }.to_string_lossy());
        Err(format!("modyn: CUDA's error {code}: {}", words.unwrap_or("unknown".into())))
    }
}

/// A kernel of a function of arrays.
pub struct Kernel {
    driver: Driver,
    function: usize,
    inputs: Vec<Vec<usize>>,
    outputs: Vec<Vec<usize>>,
    is_double: bool,
}

impl Kernel {
    /// Returns the shapes of the arguments for one state.
    pub fn inputs(&self) -> &[Vec<usize>] {
        &self.inputs
    }

    /// Returns the number of results.
    pub fn outputs(&self) -> usize {
        self.outputs.len()
    }

    /// Returns whether the numbers are of `f64`, else of `f32`.
    pub fn is_double(&self) -> bool {
        self.is_double
    }

    /// Starts the kernel on a stream. `axes` are the axes of states of each argument, `strides` the
    /// numbers from one of its rows to the next, `arrays` the addresses of the arguments and of the
    /// results.
    ///
    /// # Errors
    ///
    /// If the axes do not fit, or the driver refuses.
    ///
    /// # Safety
    ///
    /// See the header.
    pub unsafe fn launch(
        &self,
        stream: usize,
        axes: &[&[usize]],
        strides: &[usize],
        mut arrays: Vec<usize>,
    ) -> Result<(), String> {
        let all = common(axes)?;
        let count: usize = all.iter().product();
        if count == 0 {
            return Ok(());
        }
        if arrays.len() != self.inputs.len() + self.outputs.len() {
            return Err("modyn: a kernel got another number of arrays".into());
        }
        let mut numbers = Vec::with_capacity(3 * axes.len() + 1);
        for (axes, &stride) in axes.iter().zip(strides) {
            numbers.extend(rows_of(axes, &all).ok_or("modyn: an array must be repeated first")?);
            numbers.push(stride);
        }
        numbers.push(count);
        let unsigned = numbers.into_iter().map(u32::try_from).collect::<Result<Vec<u32>, _>>();
        let mut numbers = unsigned.map_err(|_| "modyn: a call has 2^32 states or more")?;
        let mut parameters: Vec<Pointer> = Vec::with_capacity(arrays.len() + numbers.len());
        parameters.extend(arrays.iter_mut().map(|array| (&raw mut *array).cast()));
        parameters.extend(numbers.iter_mut().map(|number| (&raw mut *number).cast()));
        let blocks = u32::try_from(count.div_ceil(BLOCK)).unwrap_or(u32::MAX);
        let [function, stream] = [self.function, stream].map(|address| address as Pointer);
        let parameters = parameters.as_mut_ptr();
        let threads = BLOCK as u32;
        // SAFETY: see the header.
        self.driver.checked(unsafe {
            let launch = self.driver.launch;
            launch(function, blocks, 1, 1, threads, 1, 1, 0, stream, parameters, null_mut())
        })
    }
}

/// Returns the numbers `every` and `rows` of an array with these axes of states: state `i` of all has
/// row `i / every % rows`. `None` if there are none, as for the axes (2, 1, 3) of (2, 5, 3).
fn rows_of(axes: &[usize], all: &[usize]) -> Option<[usize; 2]> {
    let mut every = 1;
    let mut rows = 1;
    let mut is_ended = false;
    let lengths = axes.iter().rev().chain(std::iter::repeat(&1));
    for (&length, &whole) in lengths.zip(all.iter().rev()).filter(|(_, whole)| **whole != 1) {
        match length {
            1 if rows == 1 => every *= whole,
            1 => is_ended = true,
            _ if is_ended => return None,
            _ => rows *= length,
        }
    }
    Some([every, rows])
}

/// Returns the kernels by the keys of their functions, for XLA.
fn kernels() -> &'static RwLock<HashMap<i64, Arc<Kernel>>> {
    static KERNELS: OnceLock<RwLock<HashMap<i64, Arc<Kernel>>>> = OnceLock::new();
    KERNELS.get_or_init(RwLock::default)
}

/// Returns the kernel of the function with this key.
pub fn kernel(key: i64) -> Option<Arc<Kernel>> {
    kernels().read().unwrap_or_else(PoisonError::into_inner).get(&key).cloned()
}

/// A kernel on CUDA, for `modyn.torch` and `modyn.jax`.
#[pyclass(frozen, module = "modyn")]
pub struct CudaKernel(Arc<Kernel>);

#[pymethods]
impl CudaKernel {
    /// Keeps a kernel under the key of its function. `driver` are the addresses of the functions
    /// `cuLaunchKernel`, `cuCtxPushCurrent`, `cuCtxPopCurrent` and `cuGetErrorString`, `shapes` the
    /// shapes of the arguments and of the results.
    #[new]
    fn new(
        key: i64,
        driver: [usize; 4],
        function: usize,
        shapes: [Vec<Vec<usize>>; 2],
        is_double: bool,
    ) -> PyResult<Self> {
        if driver.contains(&0) {
            return Err(PyValueError::new_err("the driver's library lacks a function"));
        }
        let [launch, push, pop, error] = driver;
        // SAFETY: see the header.
        let driver = unsafe {
            Driver {
                launch: transmute::<usize, Launch>(launch),
                push: transmute::<usize, PushContext>(push),
                pop: transmute::<usize, PopContext>(pop),
                error: transmute::<usize, ErrorText>(error),
            }
        };
        let [inputs, outputs] = shapes;
        let kernel = Arc::new(Kernel { driver, function, inputs, outputs, is_double });
        let mut kernels = kernels().write().unwrap_or_else(PoisonError::into_inner);
        kernels.insert(key, Arc::clone(&kernel));
        Ok(Self(kernel))
    }

    /// Returns the axes of states that arguments of these shapes have in common, and the indices of
    /// the arguments that must be repeated along them before `launch`.
    fn states(&self, shapes: Vec<Vec<usize>>) -> PyResult<(Vec<usize>, Vec<usize>)> {
        let axes = self.axes(&shapes)?;
        let all = common(&axes).map_err(PyValueError::new_err)?;
        let needs = |k: &usize| rows_of(axes[*k], &all).is_none();
        let repeated = (0..axes.len()).filter(needs).collect();
        Ok((all, repeated))
    }

    /// Starts the kernel on a stream of a context. `arrays` are the addresses of the arguments, whose
    /// shapes are `shapes` and whose rows are `strides` numbers apart, and of the results, in this
    /// order.
    fn launch(
        &self,
        context: usize,
        stream: usize,
        shapes: Vec<Vec<usize>>,
        strides: Vec<usize>,
        arrays: Vec<usize>,
    ) -> PyResult<()> {
        let axes = self.axes(&shapes)?;
        if strides.len() != axes.len() {
            return Err(PyValueError::new_err("a kernel got another number of strides"));
        }
        let Driver { push, pop, .. } = self.0.driver;
        let error = PyRuntimeError::new_err::<String>;
        // SAFETY: see the header.
        self.0.driver.checked(unsafe { push(context as Pointer) }).map_err(error)?;
        let mut current = null_mut();
        // SAFETY: see the header.
        let (launched, popped) = unsafe {
            let launched = self.0.launch(stream, &axes, &strides, arrays);
            (launched, pop(&raw mut current))
        };
        launched.and(self.0.driver.checked(popped)).map_err(error)
    }
}

impl CudaKernel {
    /// Returns the axes of states of arguments of these shapes.
    fn axes<'a>(&self, shapes: &'a [Vec<usize>]) -> PyResult<Vec<&'a [usize]>> {
        let inputs = self.0.inputs();
        if shapes.len() != inputs.len() {
            let message =
                format!("a kernel got {} arrays; expected {}", shapes.len(), inputs.len());
            return Err(PyValueError::new_err(message));
        }
        let axes = shapes.iter().zip(inputs).map(|(shape, own_axes)| leading(shape, own_axes));
        axes.collect::<Result<_, _>>().map_err(PyValueError::new_err)
    }
}
