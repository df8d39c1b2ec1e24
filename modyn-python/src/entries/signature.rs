//! The arguments and the result of a function as arrays.

use modyn_codegen::diagnostics::suggest;
use modyn_codegen::plan::{
    Argument, ArgumentKind, Derivative, DerivativeMode, EntryFunction, EntrySource, Record, Shape,
    Sizes,
};
use modyn_codegen::{FloatType, Function};
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyList;

use crate::checks::Check;
use crate::codes::ArrayShapes;
use crate::function::{default_settings, has_zeros};
use crate::layout::{self, Layout, Leaf};
use crate::number::Number;
use crate::robot::Robot;

/// What a function takes and returns.
#[derive(Clone)]
pub struct Signature {
    pub name: &'static str,
    /// The function of the table; `None` for a fused function.
    function: Option<Function>,
    pub arguments: Vec<(Argument, Shape)>,
    depends_on_parameters: bool,
    result: Shape,
}

impl Signature {
    /// Returns the signature of a function of the table. No function of arrays has factors.
    fn of_table(robot: &Robot, function: Function) -> Self {
        let row = function.row();
        let sizes = Sizes::new(robot.model(), 0);
        let arguments = row.arguments.iter();
        Self {
            name: function.name(),
            function: Some(function),
            arguments: arguments.map(|argument| (*argument, argument.shape(&sizes))).collect(),
            depends_on_parameters: row.depends_on_parameters,
            result: (row.result)(&sizes),
        }
    }

    /// Returns the signature of a function of a robot.
    ///
    /// # Errors
    ///
    /// If there is no fused function of this name, or it has factors.
    pub fn of(robot: &Robot, source: &EntrySource) -> Result<Self, String> {
        match source {
            EntrySource::Table { function, .. } => Ok(Self::of_table(robot, *function)),
            EntrySource::Fused(name) => {
                let fused = robot.fused_named(name).ok_or_else(|| unknown(name, robot))?;
                if has_factors(&fused.result) {
                    return Err(format!(
                        "fused function `{name}`: `brge` returns factors, which are no arrays: use \
                         `mass_matrix` in its place"
                    ));
                }
                Ok(Self {
                    name: fused.name,
                    function: None,
                    arguments: fused.arguments.clone(),
                    depends_on_parameters: fused.depends_on_parameters,
                    result: fused.result.clone(),
                })
            }
        }
    }

    fn layout(&self) -> Layout {
        layout::of_result(&self.result)
    }

    /// Returns the arrays of the result: for each the places of its numbers in C order.
    pub fn places(&self) -> Vec<Vec<usize>> {
        let mut all = Vec::new();
        walk(&self.layout(), &mut |leaf| all.push(in_order(leaf)));
        all
    }

    /// Returns the arguments, the parameters and the result, as `Robot._array_signature` documents
    /// them.
    pub fn in_python<'py>(&self, py: Python<'py>, robot: &Robot) -> PyResult<Bound<'py, PyAny>> {
        let arguments = PyList::empty(py);
        for (argument, shape) in &self.arguments {
            let shape = layout::of_argument(shape);
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
                name => name,
            };
            arguments.append((name, shape, default))?;
        }
        let parameters = match self.depends_on_parameters {
            true => robot.run_time_parameters()?,
            false => Vec::new(),
        };
        let result = template(py, &self.layout(), &mut (0..))?;
        Ok((arguments, parameters, result).into_pyobject(py)?.into_any())
    }
}

fn array<S: Number>(py: Python<'_>, numbers: Vec<S>) -> Bound<'_, PyAny> {
    PyArray1::from_vec(py, numbers).into_any()
}

/// Returns the result with the index of each array in place of the array.
fn template<'py>(
    py: Python<'py>,
    layout: &Layout,
    next: &mut std::ops::RangeFrom<usize>,
) -> PyResult<Bound<'py, PyAny>> {
    match layout {
        Layout::Array(_) => Ok(next.next().into_pyobject(py)?.into_any()),
        Layout::Tuple(class, fields) => {
            let mut field =
                |(name, layout): &(&'static str, Layout)| Ok((*name, template(py, layout, next)?));
            class.of_fields(py, fields.iter().map(&mut field).collect::<PyResult<_>>()?)
        }
    }
}

/// Returns whether a field of a fused function's result has the factors of the mass matrix.
fn has_factors(result: &Shape) -> bool {
    let is_factors = |shape: &Shape| matches!(shape, Shape::Record(Record::Factorization, _));
    match result {
        Shape::Record(_, fields) => fields.iter().any(|(_, shape)| is_factors(shape)),
        Shape::Scalar | Shape::Array(..) => false,
    }
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
    let signature = Signature::of(robot, &function.source)?;
    let arguments = signature.arguments.iter();
    let mut inputs: Vec<Vec<usize>> =
        arguments.map(|(_, shape)| layout::of_argument(shape)).collect();
    let nq = robot.model().nq();
    let nv = robot.model().nv();
    if function.feedback.is_some() || function.cost {
        let name = signature.name;
        let names: Vec<&str> =
            signature.arguments.iter().map(|(argument, _)| argument.name).collect();
        let of_table = signature.function.filter(|_| names.starts_with(&["q", "qd", "tau", "dt"]));
        let step = of_table.ok_or_else(|| {
            format!(
                "`{name}` is no time step under joint forces, so it has no feedback and no cost"
            )
        })?;
        if function.cost && step.row().has_solver {
            return Err(format!("`{name}` has no cost: compute it from the states"));
        }
    }
    let of_arguments = signature.arguments.iter().enumerate().filter_map(|(k, (argument, _))| {
        Some((k, argument.name, Check::of(signature.function, argument)?))
    });
    let checks = of_arguments.collect();
    if function.cost {
        // Time steps with a cost have no argument that is checked.
        inputs.insert(2, Vec::new());
    }
    if let Some(gains) = function.feedback {
        inputs.extend([gains.shape(nv).to_vec(), vec![nq], vec![nv]]);
    }
    if function.cost {
        inputs.extend([vec![nq], vec![nv], vec![2 * nv], vec![nv]]);
    }
    let parameters = robot.parameter_count();
    let has_parameters = signature.depends_on_parameters && parameters > 0;
    inputs.extend(has_parameters.then_some(vec![parameters]));
    let mut outputs = Vec::new();
    walk(&signature.layout(), &mut |leaf| outputs.push(leaf.shape(None)));
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

/// Returns the message that a robot has no function of this name.
pub fn unknown(name: &str, robot: &Robot) -> String {
    if name == Function::Brge.name() {
        return "`brge` returns factors, which are no arrays: use `mass_matrix`".into();
    }
    let one = Function::ALL.iter().filter(|function| function.batched().is_none());
    let names = one.map(|function| function.name()).chain(robot.fused_names());
    match suggest(name, names) {
        Some(meant) => format!("there is no function `{name}`; did you mean `{meant}`?"),
        None => format!(
            "there is no function `{name}`; `modyn.functions()` has all names, and `fused_names` of \
             the robot those of its fused functions"
        ),
    }
}
