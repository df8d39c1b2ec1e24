//! Rollouts: motions over many time steps, a thread for each.
#![allow(clippy::too_many_arguments)]

use modyn_codegen::{FloatType, Function, RolloutOptions};
use modyn_gpu::{Gpu, Rollout, RolloutArguments};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use super::array::{Argument, any, layout, upload};
use super::{GpuArray, exception, function_named};
use crate::arrays::tuple;
use crate::checks::Check;
use crate::errors::description_error;
use crate::parameters::ParameterNumbers;
use crate::robot::Robot;

/// Kernels that integrate motions over many time steps. `GpuRobot.rollout` makes them.
#[pyclass(frozen, module = "modyn")]
pub struct GpuRollout {
    gpu: Gpu,
    robot: Py<Robot>,
    rollout: Rollout,
    parameters: ParameterNumbers<f32>,
}

impl GpuRollout {
    /// Compiles the rollouts of these functions, with functions of the user.
    ///
    /// # Errors
    ///
    /// `DescriptionError` if there is no time step or no control, `RuntimeError` with the place if
    /// the processor refuses a function of the user.
    pub(super) fn new(
        py: Python<'_>,
        gpu: &Gpu,
        robot: Py<Robot>,
        functions: &[Function],
        options: &RolloutOptions,
    ) -> PyResult<Self> {
        let cpu_robot = robot.get();
        let base = cpu_robot.builder().clone().scalar(FloatType::F32);
        let builder =
            base.functions(functions.iter().copied()).fused(cpu_robot.fused_functions().cloned());
        let planning = builder.plan().map_err(|errors| description_error(py, &errors))?;
        let created = py.detach(|| Rollout::new(gpu, &builder, options));
        let rollout = created.map_err(|error| exception(py, error))?;
        let has_parameters = rollout.source().parameters > 0;
        let plan = &planning.plan;
        let gravity = planning.model.gravity();
        let parameters = ParameterNumbers::new(plan, gravity, has_parameters);
        Ok(Self { gpu: gpu.clone(), robot, rollout, parameters })
    }

    /// Returns the controls: (n, steps, `count`), or an array on the processor.
    fn controls(
        &self,
        py: Python<'_>,
        controls: &Bound<'_, PyAny>,
        count: usize,
    ) -> PyResult<modyn_gpu::GpuArray> {
        if let Ok(array) = controls.cast::<GpuArray>() {
            return Ok(array.get().array.clone());
        }
        let (array, shape) = any(py, &self.gpu, controls)?;
        match *shape {
            [_, given_count] if given_count == count => Ok(array),
            _ => {
                let given_shape = tuple(&[&[array.states()], &*shape].concat());
                let message = format!(
                    "`controls` of `run` has the shape {given_shape}; expected (n, steps, {count}) for n rollouts"
                );
                Err(PyValueError::new_err(message))
            }
        }
    }
}

#[pymethods]
impl GpuRollout {
    /// Runs n rollouts from the states `q`, (nq,) or (k, nq), and `qd`, (nv,) or (k, nv), under the
    /// `controls`, (n, steps, controls), with steps of `dt` s. Rollout i starts from state i modulo
    /// k. The arrays may be on the processor.
    ///
    /// `step` is a time step among the functions; `"constrained_forward_dynamics"` for steps that
    /// close loops and hold contacts, whose `settings` are the function's settings. `data` are
    /// numbers for your functions. `act`, (activations,) or (k, activations), are the activations and
    /// the delayed controls with which `"step_actuated"` begins, by default zeros. Returns
    /// `RolloutResults`, whose arrays stay on the processor:
    /// `state` (n, nq + nv) after the last step, `cost` (n,) or `None`, and with `trajectory=True`
    /// `trajectory` (n, steps, nq + nv). The call does not wait for them.
    #[pyo3(signature = (
        q, qd, controls, dt, *, step="step_semi_implicit", settings=None, data=None, trajectory=false, act=None
    ))]
    fn run<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        controls: &Bound<'py, PyAny>,
        dt: f32,
        step: &str,
        settings: Option<&Bound<'py, PyAny>>,
        data: Option<&Bound<'py, PyAny>>,
        trajectory: bool,
        act: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let source = self.rollout.source();
        let step = function_named(step)?;
        let start = |name: &'static str, count: usize, object| {
            Argument::read("run", name, None, &[count], object)?.uploaded(py, &self.gpu, 1)
        };
        let q = start("q", source.nq, q)?;
        let qd = start("qd", source.nv, qd)?;
        let act = act.map(|act| start("act", source.activations, act)).transpose()?;
        let rollout = source.rollouts.iter().find(|rollout| rollout.step == step.name());
        // A step without a kernel is refused below.
        let count = rollout.map_or(source.nv, |rollout| rollout.controls);
        let controls = self.controls(py, controls, count)?;
        let uploaded = |settings| {
            let check = if step.row().has_solver { Check::StepSettings } else { Check::Settings };
            let shape = &[rollout.map_or(0, |rollout| rollout.settings)];
            let read = Argument::read("run", "settings", Some(check), shape, settings)?;
            read.uploaded(py, &self.gpu, 1)
        };
        let settings = settings.map(uploaded).transpose()?;
        let data = data.map(|data| any_numbers(py, &self.gpu, data)).transpose()?;
        let parameters = match source.parameters {
            0 => None,
            _ => {
                let numbers = self.robot.get().changed(&self.parameters)?;
                Some(upload(py, &self.gpu, numbers.as_slice(), 1)?)
            }
        };
        let arguments = RolloutArguments {
            step,
            act: act.as_ref(),
            settings: settings.as_ref(),
            data: data.as_ref(),
            parameters: parameters.as_ref(),
            trajectory,
            ..RolloutArguments::new(&q, &qd, &controls, dt)
        };
        let computed = py.detach(|| self.rollout.run(&arguments));
        let results = computed.map_err(|error| exception(py, error))?;
        let size = source.nq + source.nv;
        let state = GpuArray::new(results.state, layout(&[size]));
        let cost = results.cost.map(|cost| GpuArray::new(cost, layout(&[])));
        let steps = controls.scalars() / count;
        let trajectory = results.trajectory.map(|all| GpuArray::new(all, layout(&[steps, size])));
        let class = py.import("modyn._types")?.getattr("RolloutResults")?;
        class.call1((state, cost, trajectory))
    }

    fn __repr__(&self) -> String {
        let steps: Vec<&str> =
            self.rollout.source().rollouts.iter().map(|rollout| rollout.step).collect();
        format!("<modyn.GpuRollout of {}>", steps.join(", "))
    }
}

/// Returns numbers that all rollouts share, (count,).
fn any_numbers(
    py: Python<'_>,
    gpu: &Gpu,
    numbers: &Bound<'_, PyAny>,
) -> PyResult<modyn_gpu::GpuArray> {
    if let Ok(array) = numbers.cast::<GpuArray>() {
        return Ok(array.get().array.clone());
    }
    let one = py.import("numpy")?.call_method1("reshape", (numbers, (1, -1)))?;
    Ok(any(py, gpu, &one)?.0)
}
