//! The kernels of a robot's functions.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use modyn_codegen::{FloatType, Function, Planning, RolloutForces, RolloutOptions};
use modyn_gpu::Gpu;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyTuple;

use super::array::{Argument, any, layout, upload};
use super::{GpuArray, GpuRollout, exception, function_named};
use crate::checks::Check;
use crate::errors::description_error;
use crate::layout::{self, Layout};
use crate::parameters::ParameterNumbers;
use crate::robot::Robot;

/// The kernels of a robot on a graphics processor, a thread for each state, in single precision.
/// Each is compiled at its first use. `Robot.gpu` makes them.
#[pyclass(frozen, module = "modyn")]
pub struct GpuRobot {
    gpu: Gpu,
    robot: Py<Robot>,
    kernels: Mutex<HashMap<Function, Arc<Kernels>>>,
}

/// The kernels of a function: one, or one for each link.
struct Kernels {
    kernels: modyn_gpu::GpuRobot,
    arguments: Vec<(modyn_codegen::plan::Argument, Vec<usize>)>,
    result: Layout,
    parameters: ParameterNumbers<f32>,
}

impl GpuRobot {
    /// Returns kernels that are compiled when they are used.
    pub(super) fn new(gpu: Gpu, robot: Py<Robot>) -> Self {
        Self { gpu, robot, kernels: Mutex::default() }
    }

    /// Returns the kernels of a function, which are compiled if this is their first use.
    fn kernels(&self, py: Python<'_>, function: Function) -> PyResult<Arc<Kernels>> {
        let mut kernels = self.kernels.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = kernels.get(&function) {
            return Ok(known.clone());
        }
        self.robot.get().check_has(function)?;
        let base = self.robot.get().builder().clone().scalar(FloatType::F32);
        let builder = base.functions([function]);
        let Planning { plan, model, .. } =
            builder.plan().map_err(|errors| description_error(py, &errors))?;
        let Some(planned) = plan.functions.first() else {
            let message = format!("the robot does not have the function `{}`", function.name());
            return Err(PyValueError::new_err(message));
        };
        let arguments = planned.arguments.iter();
        let new = Kernels {
            kernels: modyn_gpu::GpuRobot::new(&self.gpu, &builder)
                .map_err(|error| exception(py, error))?,
            arguments: arguments
                .map(|(argument, shape)| (*argument, layout::of_argument(shape)))
                .collect(),
            result: layout::of_result(&planned.result),
            parameters: ParameterNumbers::new(&plan, model.gravity(), planned.parameters > 0),
        };
        Ok(kernels.entry(function).or_insert(Arc::new(new)).clone())
    }
}

#[pymethods]
impl GpuRobot {
    /// The name of the processor, as its driver gives it.
    #[getter]
    fn processor(&self) -> &str {
        self.gpu.name()
    }

    /// Copies an array of n states to the processor, which rounds the numbers to single precision.
    /// The first axis counts states.
    fn upload(&self, py: Python<'_>, array: &Bound<'_, PyAny>) -> PyResult<GpuArray> {
        let (array, shape) = any(py, &self.gpu, array)?;
        Ok(GpuArray::new(array, layout(&shape)))
    }

    /// Runs the kernel of a function, such as `"forward_dynamics"`, on all states of its arguments:
    /// arrays on the processor or of NumPy. A function of a link takes its name or index, too. The
    /// result stays on the processor; the call does not wait for it.
    #[pyo3(signature = (function, *arguments, link=None))]
    fn run<'py>(
        &self,
        py: Python<'py>,
        function: &str,
        arguments: &Bound<'py, PyTuple>,
        link: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<GpuArray> {
        let name = function;
        let function = function_named(name)?;
        let kernels = self.kernels(py, function)?;
        let link = link.map(|link| self.robot.get().link(link)).transpose()?;
        if function.row().by_link != link.is_some() {
            let takes = if link.is_some() { "takes no link" } else { "needs `link`" };
            return Err(PyTypeError::new_err(format!("`{name}` {takes}")));
        }
        if arguments.len() != kernels.arguments.len() {
            let parameters = kernels.arguments.iter().map(|(parameter, _)| parameter.name);
            let names = parameters.collect::<Vec<&str>>().join(", ");
            let given = arguments.len();
            let message = format!("`{name}` takes {names}, and {given} arguments were given");
            return Err(PyTypeError::new_err(message));
        }
        let given = kernels.arguments.iter().zip(arguments.iter());
        let read = given.map(|((parameter, shape), object)| {
            let check = Check::of(Some(function), parameter);
            Argument::read(function.name(), parameter.name, check, shape, &object)
        });
        let given = read.collect::<PyResult<Vec<_>>>()?;
        let states = given.iter().find_map(Argument::states).unwrap_or(1);
        let each = given.into_iter().map(|argument| argument.uploaded(py, &self.gpu, states));
        let mut uploaded = each.collect::<PyResult<Vec<_>>>()?;
        let source = kernels.kernels.source();
        let kernel = source.kernels.iter().find(|kernel| kernel.link == link);
        let Some(kernel) = kernel else {
            return Err(PyValueError::new_err(format!("`{name}` has no such kernel")));
        };
        if kernel.arguments.iter().any(|argument| argument.common) {
            let parameters = self.robot.get().changed(&kernels.parameters)?;
            uploaded.push(upload(py, &self.gpu, parameters.as_slice(), 1)?);
        }
        let kernel = kernel.own_name(&source.prefix).to_owned();
        let arguments: Vec<&modyn_gpu::GpuArray> = uploaded.iter().collect();
        let computed = py.detach(|| kernels.kernels.run(&kernel, &arguments));
        let result = computed.map_err(|error| exception(py, error))?;
        Ok(GpuArray::new(result, kernels.result.clone()))
    }

    /// Returns kernels that integrate motions over many time steps.
    ///
    /// The time steps among `functions` become kernels. `cost` and `forces` are functions of yours
    /// in WGSL, which may call the functions of the robot (`robot_link_pose_hand`) and read the
    /// array `data`; docs/gpu.md has their signatures. `controls` is the number of controls of a
    /// step that `forces` takes. `active_contacts` proposes the contacts of a step that are active; then
    /// `functions` has `constrained_forward_dynamics` and `integrate`.
    #[pyo3(signature = (functions=None, *, cost=None, forces=None, controls=None, active_contacts=None))]
    fn rollout(
        &self,
        py: Python<'_>,
        functions: Option<Vec<String>>,
        cost: Option<String>,
        forces: Option<String>,
        controls: Option<usize>,
        active_contacts: Option<String>,
    ) -> PyResult<GpuRollout> {
        let functions = match functions {
            None => vec![Function::StepSemiImplicit],
            Some(names) => {
                names.iter().map(|name| function_named(name)).collect::<PyResult<_>>()?
            }
        };
        let robot = self.robot.clone_ref(py);
        let forces = match (forces, controls) {
            (Some(text), Some(controls)) => Some(RolloutForces { text, controls }),
            (None, None) => None,
            (Some(_), None) => {
                let message = "`forces` needs `controls`, the number of controls of a step";
                return Err(PyValueError::new_err(message));
            }
            (None, Some(_)) => {
                let message = "without `forces` the controls are the joint forces, and `controls` is not given";
                return Err(PyValueError::new_err(message));
            }
        };
        let options = RolloutOptions { cost, forces, active_contacts };
        GpuRollout::new(py, &self.gpu, robot, &functions, &options)
    }

    fn __repr__(&self) -> String {
        let robot = self.robot.get().model().name();
        format!("<modyn.GpuRobot '{robot}' on {}>", self.gpu.name())
    }
}
