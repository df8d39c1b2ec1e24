//! The arguments and the result of a function as arrays.

use modyn_codegen::diagnostics::suggest;
use modyn_codegen::plan::{ArgumentKind, Derivative, DerivativeMode, EntryFunction, Sizes};
use modyn_codegen::{FloatType, Function};
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::{PyList, PyTuple};

use crate::checks::Check;
use crate::codes::ArrayShapes;
use crate::function::{default_settings, has_zeros};
use crate::layout::{self, Class, Layout, Leaf};
use crate::number::Number;
use crate::robot::Robot;

/// Returns the sizes of a robot. No function of arrays has factors.
fn sizes(robot: &Robot) -> Sizes {
    Sizes::new(robot.model(), 0)
}

/// Returns the arguments, the parameters and the result of a function, as `Robot._array_signature`
/// documents them.
pub fn of<'py>(robot: &Robot, py: Python<'py>, function: Function) -> PyResult<Bound<'py, PyAny>> {
    let row = function.row();
    let sizes = sizes(robot);
    let arguments = PyList::empty(py);
    for argument in row.arguments {
        let shape = layout::of_argument(&argument.shape(&sizes));
        let length = shape.iter().product();
        let default = match (argument.kind, robot.scalar()) {
            (ArgumentKind::ActiveContacts, FloatType::F64) => array(py, vec![1.0_f64; length]),
            (ArgumentKind::ActiveContacts, FloatType::F32) => array(py, vec![1.0_f32; length]),
            (kind @ (ArgumentKind::Settings | ArgumentKind::StepSettings), scalar) => {
                match scalar {
                    FloatType::F64 => array(py, default_settings::<f64>(kind, robot.model())),
                    FloatType::F32 => array(py, default_settings::<f32>(kind, robot.model())),
                }
            }
            (ArgumentKind::Activations, _) if length > 0 => py.None().into_bound(py),
            (kind, scalar) if kind == ArgumentKind::Activations || has_zeros(argument.name) => {
                match scalar {
                    FloatType::F64 => array(py, vec![0.0_f64; length]),
                    FloatType::F32 => array(py, vec![0.0_f32; length]),
                }
            }
            _ => py.None().into_bound(py),
        };
        let name = match argument.name {
            // A keyword of Python.
            "from" => "from_",
            "step_settings" => "settings",
            name => name,
        };
        arguments.append((name, shape, default))?;
    }
    let parameters = match row.depends_on_parameters {
        true => robot.run_time_parameters()?,
        false => Vec::new(),
    };
    let result = template(py, &result(robot, function), &mut (0..))?;
    Ok((arguments, parameters, result).into_pyobject(py)?.into_any())
}

fn array<S: Number>(py: Python<'_>, numbers: Vec<S>) -> Bound<'_, PyAny> {
    PyArray1::from_vec(py, numbers).into_any()
}

fn result(robot: &Robot, function: Function) -> Layout {
    layout::of_result(&(function.row().result)(&sizes(robot)))
}

/// Returns the result with the index of each array in place of the array.
fn template<'py>(
    py: Python<'py>,
    layout: &Layout,
    next: &mut std::ops::RangeFrom<usize>,
) -> PyResult<Bound<'py, PyAny>> {
    match layout {
        Layout::Array(_) => Ok(next.next().into_pyobject(py)?.into_any()),
        Layout::Tuple(Class::Package(name), fields) => {
            let of_fields = fields.iter().map(|(_, layout)| template(py, layout, next));
            let fields = of_fields.collect::<PyResult<Vec<_>>>()?;
            let class = py.import("modyn._results")?.getattr(*name)?;
            class.call1(PyTuple::new(py, fields)?)
        }
        // Only fused functions have types of a robot's own.
        Layout::Tuple(Class::Fused(_), _) => Ok(py.None().into_bound(py)),
    }
}

/// Returns the arrays of a function's result: for each the places of its numbers in C order.
pub fn places(robot: &Robot, function: Function) -> Vec<Vec<usize>> {
    let mut all = Vec::new();
    walk(&result(robot, function), &mut |leaf| all.push(in_order(leaf)));
    all
}

fn in_order(leaf: &Leaf) -> Vec<usize> {
    let along = |places: Vec<usize>, &(count, stride): &(usize, usize)| {
        let axis = |place: usize| (0..count).map(move |i| place + i * stride);
        places.into_iter().flat_map(axis).collect()
    };
    leaf.axes.iter().fold(vec![leaf.offset], along)
}

/// Returns the shapes of the arrays of a function or a derivative.
///
/// # Errors
///
/// If a derivative varies an array that there is not.
pub fn shapes(robot: &Robot, function: &EntryFunction) -> Result<ArrayShapes, String> {
    let row = function.function.row();
    let sizes = sizes(robot);
    let arguments = row.arguments.iter();
    let mut inputs: Vec<Vec<usize>> =
        arguments.map(|argument| layout::of_argument(&argument.shape(&sizes))).collect();
    let nq = sizes.nq;
    let nv = sizes.nv;
    if function.feedback || function.cost {
        let name = function.function.name();
        let names: Vec<&str> = row.arguments.iter().map(|argument| argument.name).collect();
        if !names.starts_with(&["q", "qd", "tau", "dt"]) {
            return Err(format!(
                "`{name}` is no time step under joint forces, so it has no feedback and no cost"
            ));
        }
        if function.cost && row.has_solver {
            return Err(format!("`{name}` has no cost: compute it from the states"));
        }
    }
    let of_arguments = row.arguments.iter().enumerate().filter_map(|(k, argument)| {
        Some((k, argument.name, Check::of(Some(function.function), argument)?))
    });
    let checks = of_arguments.collect();
    if function.cost {
        // Time steps with a cost have no argument that is checked.
        inputs.insert(2, Vec::new());
    }
    if function.feedback {
        inputs.extend([vec![nv, 2 * nv], vec![nq], vec![nv]]);
    }
    if function.cost {
        inputs.extend([vec![nq], vec![nv], vec![2 * nv], vec![nv]]);
    }
    let parameters = robot.parameter_count();
    inputs.extend((row.depends_on_parameters && parameters > 0).then_some(vec![parameters]));
    let mut outputs = Vec::new();
    walk(&result(robot, function.function), &mut |leaf| outputs.push(leaf.shape(None)));
    outputs.extend(function.cost.then(Vec::new));
    for Derivative { mode, variables } in &function.derivatives {
        let is_sorted = variables.is_sorted_by(|a, b| a < b);
        if !is_sorted || variables.last().is_none_or(|&last| last >= inputs.len()) {
            let count = inputs.len();
            return Err(format!("{variables:?} must be ascending indices of {count} arrays"));
        }
        let varying: Vec<Vec<usize>> = variables.iter().map(|&i| inputs[i].clone()).collect();
        match mode {
            DerivativeMode::Forward => inputs.extend(varying),
            DerivativeMode::Reverse => inputs.extend(std::mem::replace(&mut outputs, varying)),
            DerivativeMode::Matrix => outputs = matrices(&outputs, &varying),
        }
    }
    Ok(ArrayShapes::new(inputs, outputs).with_checks(checks))
}

/// Returns the shapes of the derivatives of each result by each variable.
pub fn matrices(outputs: &[Vec<usize>], varying: &[Vec<usize>]) -> Vec<Vec<usize>> {
    let pairs = |output| varying.iter().map(move |input| [output, &**input].concat());
    outputs.iter().flat_map(|output| pairs(&**output)).collect()
}

/// Calls `each` with the arrays of a layout, in order.
fn walk(layout: &Layout, each: &mut impl FnMut(&Leaf)) {
    match layout {
        Layout::Array(leaf) => each(leaf),
        Layout::Tuple(_, fields) => fields.iter().for_each(|(_, layout)| walk(layout, each)),
    }
}

/// Returns the message that there is no function of this name.
pub fn unknown(name: &str) -> String {
    if name == Function::Brge.name() {
        return "`brge` returns factors, which are no arrays: use `mass_matrix`".into();
    }
    let one = Function::ALL.iter().filter(|function| function.batched().is_none());
    match suggest(name, one.map(|function| function.name())) {
        Some(meant) => format!("there is no function `{name}`; did you mean `{meant}`?"),
        None => format!("there is no function `{name}`; `modyn.functions()` has all names"),
    }
}
