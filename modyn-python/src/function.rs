//! A function of a robot: its code, and calls of it for one state or many.

use std::sync::{Mutex, PoisonError, RwLock};

use modyn_codegen::plan::{Argument, ArgumentKind, Planned};
use modyn_codegen::{FloatType, Function, Planning};
use modyn_jit::{Call, Compiled, Options, ParameterError};
use modyn_runtime::model::Model;
use modyn_runtime::{Inertial, Interpreter};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyFloat, PyList, PyTuple};

use crate::arrays::{self, Given, Output, ResultForm};
use crate::change::Change;
use crate::checks::Check;
use crate::evaluated::Evaluated;
use crate::layout::{self, Layout};
use crate::memory::{filled, repeated};
use crate::number::Number;
use crate::pool::{BETWEEN_QUESTIONS, INSTRUCTIONS_PER_THREAD, Pool, StartedThreads};

/// The largest number of arguments of a function.
const MAX_ARGUMENTS: usize = 16;

/// The size of the longest vectors, whose lanes are states.
const MAX_VECTOR_BYTES: usize = 64;

/// A function or a fused function of a robot, compiled for either scalar.
pub trait RobotFunction: Send + Sync {
    /// Returns the arguments, with the lengths of their axes.
    fn arguments(&self) -> &[(Argument, Vec<usize>)];

    /// Applies a change of the robot's run-time parameters.
    ///
    /// # Errors
    ///
    /// If the robot does not have the parameter, or no rigid body has the inertia.
    fn apply(&self, change: &Change, model: &Model) -> Result<(), String>;

    /// Calls the function for one state, or for many if an argument has many. The interpreter's
    /// lock is released for many.
    ///
    /// # Errors
    ///
    /// If an argument does not fit, arguments have different numbers of states, or `out` does not
    /// fit.
    fn call<'py>(
        &self,
        py: Python<'py>,
        link: Option<usize>,
        arguments: &[Option<&Bound<'py, PyAny>>],
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>>;
}

/// Returns the function of a planning that has this one alone, as machine code; the reason why
/// there is none is added, and the function is then evaluated.
pub fn compiled(
    planning: Planning,
    scalar: FloatType,
    machine_code: bool,
) -> Option<(Box<dyn RobotFunction>, Option<String>)> {
    match scalar {
        FloatType::F64 => Typed::<f64>::compiled(planning, machine_code),
        FloatType::F32 => Typed::<f32>::compiled(planning, machine_code),
    }
}

/// Returns a function that the interpreter computes.
pub fn interpreted(
    function: Function,
    robot: Interpreter<f64>,
    scalar: FloatType,
) -> Box<dyn RobotFunction> {
    match scalar {
        FloatType::F64 => Box::new(Typed::<f64>::interpreted(function, robot)),
        FloatType::F32 => Box::new(Typed::<f32>::interpreted(function, robot)),
    }
}

/// A function or a fused function of a robot, compiled for a scalar.
struct Typed<S: Number> {
    name: &'static str,
    arguments: Vec<(Argument, Vec<usize>)>,
    /// The names of the robot's contacts.
    contacts: Vec<String>,
    /// The settings of constraints by default.
    settings: Vec<S>,
    /// The settings of steps by the description.
    step_settings: Vec<S>,
    /// The function; `None` for a fused function.
    function: Option<Function>,
    result: Layout,
    /// The numbers of a result of one state.
    length: usize,
    /// The shape of a result of one state that is one array, and whether it is in Fortran's order.
    single: Option<(Vec<usize>, bool)>,
    /// A change of run-time parameters waits until running batches end.
    code: RwLock<Code<S>>,
}

enum Code<S: Number> {
    Machine(Box<Compiled<S>>),
    Evaluated(Evaluated<S>),
}

impl<S: Number> Typed<S> {
    fn compiled(
        planning: Planning,
        machine_code: bool,
    ) -> Option<(Box<dyn RobotFunction>, Option<String>)> {
        let planned = planning.plan.functions.first()?;
        let name = planned.name;
        let function = planned.function;
        let declared = planned.arguments.iter();
        let arguments =
            declared.map(|(argument, shape)| (*argument, layout::of_argument(shape))).collect();
        let length = planned.result.len();
        let result = layout::of_result(&planned.result);
        let contacts = contact_names(&planning.model);
        let settings = default_settings(ArgumentKind::Settings, &planning.model);
        let step_settings = default_settings(ArgumentKind::StepSettings, &planning.model);
        let mut options = Options::default();
        options.batches = true;
        let compiled = machine_code.then(|| Compiled::from_plan(&planning, options));
        let (code, reason) = match compiled {
            Some(Ok(compiled)) => (Code::Machine(Box::new(compiled)), None),
            other => {
                let reason = other.and_then(Result::err).map(|error| error.to_string());
                (Code::Evaluated(evaluated(planning)?), reason)
            }
        };
        let code = RwLock::new(code);
        let single = arrays::single(&result, length);
        let compiled = Self {
            name,
            arguments,
            contacts,
            settings,
            step_settings,
            function,
            result,
            length,
            single,
            code,
        };
        Some((Box::new(compiled), reason))
    }

    fn interpreted(function: Function, robot: Interpreter<f64>) -> Self {
        let row = function.row();
        let sizes = robot.sizes();
        let shape = (row.result)(&sizes);
        let length = shape.len();
        let result = layout::of_result(&shape);
        let argument =
            |argument: &Argument| (*argument, layout::of_argument(&argument.shape(&sizes)));
        Self {
            name: function.name(),
            arguments: row.arguments.iter().map(argument).collect(),
            contacts: contact_names(robot.model()),
            settings: default_settings(ArgumentKind::Settings, robot.model()),
            step_settings: default_settings(ArgumentKind::StepSettings, robot.model()),
            function: Some(function),
            single: arrays::single(&result, length),
            result,
            length,
            code: RwLock::new(Code::Evaluated(Evaluated::Interpreted(
                function,
                Box::new(Mutex::new(robot)),
            ))),
        }
    }

    /// Returns the form of the result of one state, or of a batch with these states.
    fn result_form(&self, states: Option<usize>) -> ResultForm<'_> {
        ResultForm { function: self.name, layout: &self.result, length: self.length, states }
    }

    /// Returns whether the function is one of a link.
    fn is_by_link(&self) -> bool {
        self.function.is_some_and(|function| function.row().by_link)
    }

    /// Returns the argument of this kind; where it is not given, its default.
    fn given<'py>(
        &self,
        py: Python<'py>,
        declared: &(Argument, Vec<usize>),
        given: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Given<'py, S>> {
        let (argument, shape) = declared;
        let Argument { name, kind } = argument;
        match (kind, given.filter(|given| !given.is_none())) {
            (kind, Some(given)) => {
                let numbers = match kind {
                    ArgumentKind::Settings => {
                        let wanted = SettingsForm {
                            class: "ConstraintSettings",
                            field: "targets",
                            count: "one for each name of `contact_names`, in their order",
                        };
                        self.settings(&wanted, name, shape, given)?
                    }
                    ArgumentKind::StepSettings => {
                        let wanted = SettingsForm {
                            class: "StepSettings",
                            field: "surfaces",
                            count: "those that `step_settings()` has, in their order",
                        };
                        self.settings(&wanted, name, shape, given)?
                    }
                    ArgumentKind::ActiveContacts => {
                        match Given::read(self.name, name, shape, given) {
                            Ok(numbers) => numbers,
                            Err(error) => match names_in(given) {
                                Some(names) => self.contacts_of(name, &names)?,
                                None => return Err(of_contacts(py, &error)),
                            },
                        }
                    }
                    _ => Given::read(self.name, name, shape, given)?,
                };
                if let Some(check) = Check::of(self.function, argument) {
                    let checked = check.run(name, numbers.as_slice()?, shape.iter().product());
                    checked.map_err(PyValueError::new_err)?;
                }
                Ok(numbers)
            }
            (ArgumentKind::ActiveContacts, None) => {
                Ok(Given::owned(name, vec![S::one(); shape.iter().product()]))
            }
            (ArgumentKind::Settings, None) => Ok(Given::owned(name, self.settings.clone())),
            (ArgumentKind::StepSettings, None) => {
                Ok(Given::owned(name, self.step_settings.clone()))
            }
            (_, None) if has_zeros(name) => {
                Ok(Given::owned(name, vec![S::zero(); shape.iter().product()]))
            }
            (ArgumentKind::Activations, None) if shape.iter().product::<usize>() == 0 => {
                Ok(Given::owned(name, Vec::new()))
            }
            (_, None) => {
                Err(PyTypeError::new_err(format!("`{}` needs the argument `{name}`", self.name)))
            }
        }
    }

    /// Returns the numbers of settings: an object of their class, or an array.
    fn settings<'py>(
        &self,
        wanted: &SettingsForm,
        name: &'static str,
        shape: &[usize],
        given: &Bound<'py, PyAny>,
    ) -> PyResult<Given<'py, S>> {
        let class = given.get_type().name()?.to_string();
        let function = self.name;
        if class.ends_with("Settings") && class != wanted.class {
            let message =
                format!("`settings` of `{function}` is a `{class}`; expected `{}`", wanted.class);
            return Err(PyTypeError::new_err(message));
        }
        Given::read_for_scalar(function, name, shape, given).map_err(|error| {
            match given.getattr(wanted.field).and_then(|all| all.len()) {
                Ok(count) if error.is_instance_of::<PyValueError>(given.py()) => {
                    PyValueError::new_err(format!(
                        "`settings` of `{function}` has {count} {}; expected {}",
                        wanted.field, wanted.count
                    ))
                }
                _ => error,
            }
        })
    }

    /// Returns the set of active contacts with these names.
    fn contacts_of<'py>(&self, name: &'static str, active: &[String]) -> PyResult<Given<'py, S>> {
        if let Some(unknown) = active.iter().find(|one| !self.contacts.contains(one)) {
            let names = self.contacts.join("`, `");
            return Err(PyValueError::new_err(format!(
                "`{name}` of `{}` names `{unknown}`, which is no contact of this robot; `contact_names` has `{names}`",
                self.name
            )));
        }
        let numbers = self.contacts.iter().map(|contact| match active.contains(contact) {
            true => S::one(),
            false => S::zero(),
        });
        Ok(Given::owned(name, numbers.collect()))
    }

    fn call_once<'py>(
        &self,
        py: Python<'py>,
        link: Option<usize>,
        given: &[Given<'py, S>],
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let mut arguments: [&[S]; MAX_ARGUMENTS] = [&[]; MAX_ARGUMENTS];
        for (argument, given) in arguments.iter_mut().zip(given) {
            *argument = given.as_slice()?;
        }
        let arguments = &arguments[..given.len()];
        let code = self.code.read().unwrap_or_else(PoisonError::into_inner);
        match (&self.single, out) {
            (Some((shape, _)), None) if shape.is_empty() => {
                let mut number = [S::zero()];
                self.one(&code, link, arguments, &mut number)?;
                Ok(PyFloat::new(py, number[0].into()).into_any())
            }
            (Some((shape, is_fortran)), None) => {
                let fill = |result: &mut [S]| self.one(&code, link, arguments, result);
                Ok(filled(py, shape, *is_fortran, fill)?.into_any())
            }
            _ => {
                let mut output = Output::new(py, self.result_form(None), out, given)?;
                self.one(&code, link, arguments, output.as_mut_slice()?)?;
                output.finish()
            }
        }
    }

    fn call_many<'py>(
        &self,
        py: Python<'py>,
        link: Option<usize>,
        given: &[Given<'py, S>],
        states: usize,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let mut output = Output::new(py, self.result_form(Some(states)), out, given)?;
        let result = output.as_mut_slice()?;
        let repeated_copies = given.iter().map(|given| match given.states {
            None => repeated(given.as_slice()?, states).map(Some),
            Some(_) => Ok(None),
        });
        let copies: Vec<Option<Vec<S>>> = repeated_copies.collect::<PyResult<_>>()?;
        let slices = given.iter().zip(&copies).map(|(given, copy)| match copy {
            Some(copy) => Ok(copy.as_slice()),
            None => given.as_slice(),
        });
        let arguments = slices.collect::<PyResult<Vec<&[S]>>>()?;
        let threads = StartedThreads::new();
        py.detach(|| self.many(link, &arguments, states, result, &threads))?;
        threads.finish()?;
        output.finish()
    }

    fn one(
        &self,
        code: &Code<S>,
        link: Option<usize>,
        arguments: &[&[S]],
        result: &mut [S],
    ) -> PyResult<()> {
        match code {
            Code::Evaluated(evaluated) => {
                let done = evaluated.one(link.unwrap_or_default(), arguments, result);
                done.map_err(PyValueError::new_err)?;
            }
            Code::Machine(compiled) => {
                let call = self.machine(compiled)?;
                let done = match link {
                    None => call.one(arguments, result),
                    Some(link) => call.link(link, arguments, result),
                };
                done.map_err(|error| PyValueError::new_err(error.to_string()))?;
            }
        }
        Ok(())
    }

    /// Returns the machine code.
    fn machine<'c>(&self, compiled: &'c Compiled<S>) -> PyResult<Call<'c, S>> {
        let call = match self.function {
            Some(function) => compiled.function(function),
            None => compiled.fused(self.name),
        };
        call.map_err(|error| PyValueError::new_err(error.to_string()))
    }

    /// Computes many states, which the threads share; not all of them if the pool must end.
    fn many(
        &self,
        link: Option<usize>,
        arguments: &[&[S]],
        states: usize,
        result: &mut [S],
        pool: &dyn Pool,
    ) -> PyResult<()> {
        let code = self.code.read().unwrap_or_else(PoisonError::into_inner);
        let lengths: Vec<usize> =
            self.arguments.iter().map(|(_, shape)| shape.iter().product()).collect();
        let call = match &*code {
            Code::Machine(compiled) => Some(self.machine(compiled)?),
            Code::Evaluated(_) => None,
        };
        // Without numbers in the first argument, machine code cannot tell the number of states.
        let is_countable = lengths.first().is_some_and(|&n| n > 0);
        let run = |arguments: &[&[S]], results: &mut [S]| match &call {
            Some(call) if is_countable => {
                let done = match link {
                    None => call.many(arguments, results),
                    Some(link) => call.many_link(link, arguments, results),
                };
                done.map_err(|error| PyValueError::new_err(error.to_string()))
            }
            _ => self.one(&code, link, arguments, results),
        };
        let cost =
            call.as_ref().map_or(INSTRUCTIONS_PER_THREAD, |call| call.size().instructions / 4 + 1);
        let lanes = MAX_VECTOR_BYTES / size_of::<S>();
        // The states between two questions whether the work must end. The time of a program that is
        // evaluated is not known.
        let piece = match call.is_some() && is_countable {
            true => (BETWEEN_QUESTIONS / cost).next_multiple_of(lanes).max(lanes),
            false => 1,
        };
        let useful = (states.saturating_mul(cost)).div_ceil(INSTRUCTIONS_PER_THREAD);
        let useful_threads = pool.threads().min(useful).min(states.div_ceil(lanes)).max(1);
        let threads = if self.length == 0 { 1 } else { useful_threads };
        let share = states.div_ceil(threads).next_multiple_of(lanes).max(1);
        // The results of each chunk; nothing is written for a result without numbers.
        let mut rest = result;
        let mut chunks = Vec::with_capacity(threads);
        for first in (0..states).step_by(share) {
            let count = share.min(states - first);
            let result;
            (result, rest) = rest.split_at_mut(count * self.length);
            chunks.push(Mutex::new((first, count, result)));
        }
        let failed = Mutex::new(None);
        pool.share(chunks.len(), &|chunk| {
            let mut chunk = chunks[chunk].lock().unwrap_or_else(PoisonError::into_inner);
            let (first, count, results) = &mut *chunk;
            let mut done = 0;
            while done < *count {
                // The last piece is not shorter than a vector.
                let left = *count - done;
                let whole = if left < 2 * piece { left } else { piece };
                let states = if piece == 1 { 1 } else { whole };
                let at = *first + done;
                let arguments = arguments.iter().zip(&lengths);
                let own_arguments: Vec<&[S]> =
                    arguments.map(|(all, n)| &all[at * n..][..states * n]).collect();
                let results = &mut results[done * self.length..][..states * self.length];
                if let Err(error) = run(&own_arguments, results) {
                    *failed.lock().unwrap_or_else(PoisonError::into_inner) = Some(error);
                    return;
                }
                done += states;
                if pool.must_end() {
                    return;
                }
            }
        });
        failed.into_inner().unwrap_or_else(PoisonError::into_inner).map_or(Ok(()), Err)
    }
}

impl<S: Number> RobotFunction for Typed<S> {
    fn arguments(&self) -> &[(Argument, Vec<usize>)] {
        &self.arguments
    }

    fn apply(&self, change: &Change, model: &Model) -> Result<(), String> {
        let mut code = self.code.write().unwrap_or_else(PoisonError::into_inner);
        match &mut *code {
            Code::Evaluated(evaluated) => evaluated.apply(change, model),
            Code::Machine(compiled) => match change {
                Change::Gravity(gravity) => compiled.set_gravity(gravity.map(S::from_f64)),
                Change::Inertia(link, inertial) => compiled.set_inertia(link, &rounded(inertial)),
                Change::Payload(link, inertial) => compiled.set_payload(link, &rounded(inertial)),
            }
            .map_err(|error| match error {
                ParameterError::NotAParameter { .. } => change.missing(),
                error => error.to_string(),
            }),
        }
    }

    fn call<'py>(
        &self,
        py: Python<'py>,
        link: Option<usize>,
        arguments: &[Option<&Bound<'py, PyAny>>],
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let link = link.filter(|_| self.is_by_link());
        let given = self.arguments.iter().zip(arguments);
        let read = given.map(|(declared, argument)| self.given(py, declared, *argument));
        let given = read.collect::<PyResult<Vec<_>>>()?;
        let mut states: Option<(usize, usize)> = None;
        for (i, count) in given.iter().enumerate().filter_map(|(i, one)| Some((i, one.states?))) {
            let (first, expected) = *states.get_or_insert((i, count));
            if count != expected {
                return Err(PyValueError::new_err(format!(
                    "`{}` of `{}` has {count} states, and `{}` has {expected}",
                    self.arguments[i].0.name, self.name, self.arguments[first].0.name
                )));
            }
        }
        match states {
            None => self.call_once(py, link, &given, out),
            Some((_, states)) => self.call_many(py, link, &given, states, out),
        }
    }
}

/// Returns the names of a robot's contacts.
fn contact_names(model: &Model) -> Vec<String> {
    model.contacts().iter().map(|contact| contact.name.clone()).collect()
}

/// Returns the names in a list, a tuple or an array of texts, or one text; `None` for another
/// object.
fn names_in(object: &Bound<'_, PyAny>) -> Option<Vec<String>> {
    if let Ok(name) = object.extract::<String>() {
        return Some(vec![name]);
    }
    let listed = || object.call_method0("tolist").and_then(|list| list.extract()).ok();
    let names: Vec<String> = object.extract().ok().or_else(listed)?;
    // An empty array may be meant as booleans of another length.
    let is_list = object.is_instance_of::<PyList>() || object.is_instance_of::<PyTuple>();
    (is_list || !names.is_empty()).then_some(names)
}

/// The form that the settings of a function have in Python.
struct SettingsForm {
    class: &'static str,
    /// The attribute that has an object for each contact or shape.
    field: &'static str,
    /// How many objects are expected, in words.
    count: &'static str,
}

/// Returns the error of a set of active contacts with the form of one.
fn of_contacts(py: Python<'_>, error: &PyErr) -> PyErr {
    let message = error.value(py).to_string();
    let help = "active contacts are names, as in `[\"left\", \"right\"]`, or booleans in the order of `contact_names`";
    PyErr::from_type(error.get_type(py), format!("{message}; {help}"))
}

/// Returns an inertia in the scalar.
fn rounded<S: Number>(inertial: &Inertial) -> Inertial<S> {
    inertial.map(S::from_f64)
}

/// Returns the settings of constraints or of steps that a robot has by default.
pub fn default_settings<S: Number>(kind: ArgumentKind, model: &Model) -> Vec<S> {
    let settings = S::FLOAT.default_settings(kind, model).unwrap_or_default();
    settings.into_iter().map(S::from_f64).collect()
}

/// Returns whether an argument is zeros where it is not given.
pub fn has_zeros(argument: &str) -> bool {
    ["applied", "warm_start", "act_cotangent", "tangent_act"].contains(&argument)
}

fn evaluated<S: Number>(planning: Planning) -> Option<Evaluated<S>> {
    let Planning { mut plan, model, .. } = planning;
    let planned: Planned = plan.functions.drain(..).next()?;
    Some(Evaluated::new(planned, plan, model.gravity()))
}
