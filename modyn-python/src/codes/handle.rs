//! Compiled code as an object of Python, and all code by its keys.

use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::{Arc, OnceLock, PoisonError, RwLock, Weak};

use numpy::PyArrayDyn;
use numpy::prelude::*;
use pyo3::exceptions::{PyMemoryError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyList, PyTuple};

use super::code::ArrayCode;
use super::kernel::ArrayShapes;
use super::rollout::{Reverse, Rollout};
use super::states::{Broadcast, Fault, Numbers, common};
use super::{AnyCode, CodeNumber};
use crate::arrays::in_order;
use crate::memory::zeros;
use crate::number::Number;
use crate::pool::StartedThreads;

/// The identity of code: a hash of all numbers and texts that the code follows from, the same in each
/// process.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Identity([u64; 2]);

impl Identity {
    /// Returns the identity of code that follows from this content.
    pub fn of(content: impl Hash) -> Self {
        Self([0_u8, 1].map(|half| {
            let mut hasher = DefaultHasher::new();
            (half, &content).hash(&mut hasher);
            hasher.finish()
        }))
    }

    /// Returns the first key for code of this identity.
    fn key(self) -> i64 {
        (self.0[0] >> 1).cast_signed()
    }
}

/// Code in the registry, which does not keep it.
struct Registered {
    identity: Identity,
    code: Weak<AnyCode>,
}

/// Returns all code by its keys.
fn registry() -> &'static RwLock<HashMap<i64, Registered>> {
    static REGISTRY: OnceLock<RwLock<HashMap<i64, Registered>>> = OnceLock::new();
    REGISTRY.get_or_init(RwLock::default)
}

/// Returns the code with this key, if it lives.
pub fn find(key: i64) -> Option<Arc<AnyCode>> {
    let registry = registry().read().unwrap_or_else(PoisonError::into_inner);
    registry.get(&key)?.code.upgrade()
}

/// Returns the key of an identity, and its code if it lives. Code of another identity that has the
/// key moves it to the next one.
fn place(registry: &HashMap<i64, Registered>, identity: Identity) -> (i64, Option<Arc<AnyCode>>) {
    let mut key = identity.key();
    loop {
        let Some(registered) = registry.get(&key) else { return (key, None) };
        match registered.code.upgrade() {
            None => return (key, None),
            Some(code) if registered.identity == identity => return (key, Some(code)),
            Some(_) => key = (key + 1) & i64::MAX,
        }
    }
}

/// Compiled code, which lives as long as a handle of it.
#[pyclass(frozen, module = "modyn", weakref)]
#[derive(Clone)]
pub struct CodeHandle {
    code: Arc<AnyCode>,
    identity: Identity,
    key: i64,
}

impl CodeHandle {
    /// Returns the code of this identity, which `make` compiles unless it lives.
    ///
    /// # Errors
    ///
    /// The errors of `make`.
    pub fn new(identity: Identity, make: impl FnOnce() -> PyResult<AnyCode>) -> PyResult<Self> {
        let (key, known) =
            place(&registry().read().unwrap_or_else(PoisonError::into_inner), identity);
        if let Some(code) = known {
            return Ok(Self { code, identity, key });
        }
        let made = Arc::new(make()?);
        let mut registry = registry().write().unwrap_or_else(PoisonError::into_inner);
        registry.retain(|_, registered| registered.code.strong_count() > 0);
        // Another thread may have compiled it meanwhile.
        let (key, known) = place(&registry, identity);
        let code = known.unwrap_or(made);
        registry.insert(key, Registered { identity, code: Arc::downgrade(&code) });
        Ok(Self { code, identity, key })
    }

    /// Returns the code.
    pub fn code(&self) -> &AnyCode {
        &self.code
    }

    /// Returns the identity.
    pub fn identity(&self) -> Identity {
        self.identity
    }

    /// Returns the shapes of the arrays.
    fn shapes(&self) -> &ArrayShapes {
        match &*self.code {
            AnyCode::F64(code) => code.shapes(),
            AnyCode::F32(code) => code.shapes(),
        }
    }
}

#[pymethods]
impl CodeHandle {
    /// The key by which XLA finds the code.
    #[getter]
    fn key(&self) -> i64 {
        self.key
    }

    /// The shapes of the arrays of arguments, for one state.
    #[getter]
    fn inputs<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        tuples(py, self.shapes().inputs())
    }

    /// The shapes of the arrays of results, for one state.
    #[getter]
    fn outputs<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        tuples(py, self.shapes().outputs())
    }

    /// Calls the code on arrays in C order. Leading axes are axes of states, and are broadcast.
    /// Returns an array for each result, with the same leading axes.
    fn call<'py>(
        &self,
        py: Python<'py>,
        arrays: Vec<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyList>> {
        match &*self.code {
            AnyCode::F64(code) => called(py, code, &arrays),
            AnyCode::F32(code) => called(py, code, &arrays),
        }
    }

    /// Returns the rollout of a time step, whose code this is: the results of all steps, or of the
    /// last one. Given the code of the step's products, the rollout returns the gradients with
    /// respect to the arguments `variables`. `roles` are the roles of the step's arguments: `state`,
    /// `start` and `sequences`.
    #[pyo3(signature = (steps, trajectory, roles, reverse=None))]
    fn rollout(
        &self,
        steps: usize,
        trajectory: bool,
        roles: Roles,
        reverse: Option<(PyRef<'_, CodeHandle>, Vec<usize>)>,
    ) -> PyResult<Self> {
        let of_reverse = reverse.as_ref().map(|(step, variables)| (step.identity, variables));
        let identity = Identity::of((self.identity, steps, trajectory, &roles, of_reverse));
        let reverse = reverse.as_ref().map(|(step, variables)| (step.code(), variables.clone()));
        Self::new(identity, || match &*self.code {
            AnyCode::F64(step) => rolled_out(step, steps, trajectory, &roles, reverse),
            AnyCode::F32(step) => rolled_out(step, steps, trajectory, &roles, reverse),
        })
    }
}

/// Returns shapes as tuples.
fn tuples<'py>(py: Python<'py>, shapes: &[Vec<usize>]) -> PyResult<Bound<'py, PyList>> {
    let tuples = shapes.iter().map(|shape| PyTuple::new(py, shape));
    PyList::new(py, tuples.collect::<PyResult<Vec<_>>>()?)
}

/// The roles of the arguments of a step in a rollout, by their indices.
#[derive(FromPyObject, Hash)]
#[pyo3(from_item_all)]
pub struct Roles {
    /// The arguments that are the first results of the step before.
    state: Vec<usize>,
    /// The argument of the state from which a solver starts.
    start: Option<usize>,
    /// The arguments that have numbers for each step.
    sequences: Vec<usize>,
}

impl Roles {
    /// Returns whether gradients flow through an argument from step to step.
    fn is_carried(&self, argument: usize) -> bool {
        self.state.contains(&argument) && self.start != Some(argument)
    }
}

/// Returns the error of code that is no time step.
pub fn no_step() -> PyErr {
    PyValueError::new_err("this is no time step with products of it")
}

/// Returns the code of the rollout of a step.
fn rolled_out<S: CodeNumber>(
    step: &ArrayCode<S>,
    steps: usize,
    trajectory: bool,
    roles: &Roles,
    reverse: Option<(&AnyCode, Vec<usize>)>,
) -> PyResult<AnyCode> {
    let function = |code: &ArrayCode<S>| match code {
        ArrayCode::Function(function) => Ok(Arc::clone(function)),
        ArrayCode::Rollout(..) => Err(no_step()),
    };
    let step = function(step)?;
    let reverse = match reverse {
        None => None,
        Some((code, variables)) => {
            let step = function(S::code(code).ok_or_else(no_step)?)?;
            Some(Reverse { step, variables })
        }
    };
    let shapes = step.shapes().clone();
    let given = shapes.inputs();
    let results = shapes.outputs();
    let Roles { state, start, sequences } = roles;
    let fits = state.len() <= results.len()
        && state.iter().zip(results).all(|(&k, result)| given.get(k) == Some(result))
        && start.is_none_or(|start| state.contains(&start))
        && sequences.iter().all(|k| *k < given.len() && !state.contains(k))
        && reverse.as_ref().is_none_or(|reverse| {
            let varies = |k: &usize| roles.is_carried(*k) || reverse.variables.contains(k);
            let varying = (0..given.len()).filter(varies);
            reverse.step.shapes().outputs().iter().eq(varying.map(|k| &given[k]))
                && *reverse.step.shapes().inputs() == *[given, results].concat()
                && reverse.variables.is_sorted_by(|a, b| a < b)
        });
    if !fits {
        return Err(no_step());
    }
    let is_sequence: Vec<bool> = (0..given.len()).map(|k| sequences.contains(&k)).collect();
    let of_steps = |shape: &Vec<usize>| [&[steps], &**shape].concat();
    let input = |(shape, &is_sequence): (&Vec<usize>, &bool)| {
        if is_sequence { of_steps(shape) } else { shape.clone() }
    };
    let mut inputs: Vec<Vec<usize>> = given.iter().zip(&is_sequence).map(input).collect();
    let end = |shape: &Vec<usize>| if trajectory { of_steps(shape) } else { shape.clone() };
    let mut outputs: Vec<Vec<usize>> = results.iter().map(end).collect();
    if let Some(reverse) = &reverse {
        let gradients = reverse.variables.iter().map(|&k| inputs[k].clone()).collect();
        inputs.extend(std::mem::replace(&mut outputs, gradients));
    }
    let checks = shapes.checks().to_vec();
    let rollout = Rollout {
        step,
        state: state.clone(),
        start: *start,
        is_sequence,
        steps,
        trajectory,
        reverse,
        shapes: ArrayShapes::new(inputs, outputs).with_checks(checks),
    };
    Ok(S::any(ArrayCode::Rollout(Box::new(rollout))))
}

/// Returns the message that no function has this key.
pub fn missing(key: i64) -> String {
    format!(
        "modyn: this process has no function {key:016x}; load the robot, call `modyn.jax.function` \
         or `modyn.jax.rollout` with it, and keep what it returns"
    )
}

/// Returns the axes of states of an array whose axes for one state are `own`.
pub fn leading<'a>(axes: &'a [usize], own_axes: &[usize]) -> Result<&'a [usize], String> {
    axes.strip_suffix(own_axes).ok_or_else(|| {
        let given_shape = crate::arrays::tuple(axes);
        let expected = crate::arrays::tuple(own_axes);
        format!(
            "modyn: an array has the shape {given_shape}; expected {expected}, after axes of states"
        )
    })
}

/// Calls code on arrays of NumPy.
fn called<'py, S: Number>(
    py: Python<'py>,
    code: &ArrayCode<S>,
    arrays: &[Bound<'py, PyAny>],
) -> PyResult<Bound<'py, PyList>> {
    let wrong = |message: String| PyValueError::new_err(message);
    let read = |array: &Bound<'py, PyAny>| {
        let array = in_order::<S>("call", "arrays", array)?;
        array.try_into_readonly().map_err(|error| wrong(error.to_string()))
    };
    let given = arrays.iter().map(read).collect::<PyResult<Vec<_>>>()?;
    let mut axes = Vec::with_capacity(given.len());
    let mut numbers: Vec<Numbers<'_, S>> = Vec::with_capacity(given.len());
    let inputs = code.shapes().inputs();
    if given.len() != inputs.len() {
        let counts = format!("{} arrays; expected {}", given.len(), inputs.len());
        return Err(wrong(format!("modyn: a function got {counts}")));
    }
    for (array, shape) in given.iter().zip(inputs) {
        axes.push(leading(array.shape(), shape).map_err(wrong)?);
        numbers.push(array.as_slice()?.into());
    }
    let all = common(&axes).map_err(wrong)?;
    let allocated = code.shapes().outputs().iter().map(|shape| {
        let shape = [&*all, shape].concat();
        zeros::<S>(py, &shape, false)
    });
    let results: Vec<Bound<'py, PyArrayDyn<S>>> = allocated.collect::<PyResult<_>>()?;
    let broadcast =
        Broadcast::new(&axes, code.shapes().lengths()[0]).map_err(|fault| match fault {
            Fault::Memory => PyMemoryError::new_err(fault.to_string()),
            Fault::Arrays(message) => wrong(message),
        })?;
    let mut written: Vec<_> = results.iter().map(PyArrayMethods::readwrite).collect();
    let mut outputs = Vec::with_capacity(written.len());
    for array in &mut written {
        outputs.push(array.as_slice_mut()?.into());
    }
    let threads = StartedThreads::new();
    let run = || code.compute(&broadcast, &numbers, &outputs, &threads);
    // Releasing Python's lock takes longer than one state.
    let is_long = broadcast.states() > 1 || matches!(code, ArrayCode::Rollout(..));
    if is_long { py.detach(run) } else { run() }.map_err(wrong)?;
    threads.finish()?;
    drop(outputs);
    drop(written);
    PyList::new(py, results)
}
