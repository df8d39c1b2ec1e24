//! Motions over many time steps, computed by one kernel.

use modyn_codegen::emit::{GpuRollout, RolloutBuffer, RolloutSource};
use modyn_codegen::{Builder, Function, GpuLanguage, RolloutOptions};
use modyn_runtime::{ConstraintSettings, ContactSurface, ContactTarget, StepSettings};

use crate::kernel::Pipelines;
use crate::{Gpu, GpuArray, GpuError};

/// The rollouts of a robot on a processor: a kernel for each function of a time step, which
/// computes a motion over many steps in each thread. A kernel is compiled when it first runs.
///
/// ```
/// use modyn_codegen::{Builder, Function, RolloutOptions};
/// use modyn_gpu::{Gpu, Rollout, RolloutArguments};
///
/// let text = r#"<robot name="wheel"><link name="world"/>
///     <joint name="axle" type="continuous"><parent link="world"/><child link="disk"/><axis xyz="0 0 1"/></joint>
///     <link name="disk"><inertial><mass value="2"/>
///     <inertia ixx="0.1" iyy="0.1" izz="0.2" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>"#;
/// let gpu = Gpu::new()?;
/// let builder = Builder::new().urdf_text(text, "wheel.urdf").functions([Function::StepSemiImplicit]);
/// let cost = "fn cost(q: array<f32, 1>, qd: array<f32, 1>, u: array<f32, 1>, step: u32) -> f32 {
///     return u[0] * u[0];
/// }";
/// let options = RolloutOptions { cost: Some(cost.into()), ..RolloutOptions::default() };
/// let rollout = Rollout::new(&gpu, &builder, &options)?;
/// // Two rollouts of three steps of 0.1 s, from rest: torques of 1, 1, 1 and of 2, 0, -2 N m.
/// let rest = gpu.upload(&[0.0], 1)?;
/// let torques = gpu.upload(&[1.0, 2.0, 1.0, 0.0, 1.0, -2.0], 2)?;
/// let results = rollout.run(&RolloutArguments::new(&rest, &rest, &torques, 0.1))?;
/// // The angles of both, then the velocities: qdd = tau / 0.2.
/// let state = results.state.read()?;
/// for (found, expected) in state.iter().zip([0.3, 0.2, 1.5, 0.0]) {
///     assert!((found - expected).abs() < 1e-5, "{state:?}");
/// }
/// assert_eq!(results.cost.expect("there is a cost").read()?, [3.0, 8.0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Rollout {
    gpu: Gpu,
    source: RolloutSource,
    module: wgpu::ShaderModule,
    pipelines: Pipelines,
    /// A number in place of arguments that were left out, and one in place of results.
    absent: [GpuArray; 2],
    /// The default settings of each kernel that has settings.
    settings: Vec<Option<GpuArray>>,
}

/// The arguments of rollouts. `n` rollouts of `steps` steps run at a time.
#[derive(Clone, Copy, Debug)]
pub struct RolloutArguments<'a> {
    /// The function of a time step; [`Function::ConstrainedForwardDynamics`] for steps that close
    /// the loops and hold contacts.
    pub step: Function,
    /// The coordinates of the initial states. Rollout `i` starts from state `i` modulo the number
    /// of initial states.
    pub q: &'a GpuArray,
    /// The velocities of the initial states.
    pub qd: &'a GpuArray,
    /// The states of the actuators in the initial states, for [`Function::StepActuated`]: the
    /// activations, and the controls that are delayed. `None` for zeros.
    pub act: Option<&'a GpuArray>,
    /// The controls of all steps, one set after another: an array of `n` states, each with the
    /// scalars of one step times the number of steps. Without the user's function `forces` these
    /// are the joint forces; for [`Function::StepActuated`] the controls of the actuators.
    pub controls: &'a GpuArray,
    /// The duration of a step, s.
    pub dt: f32,
    /// The settings of the function `step`, one state: the `numbers` of `ConstraintSettings` and of
    /// each contact's target, or for [`Function::Step`] and [`Function::StepActuated`] the `numbers`
    /// of `StepSettings` and of each touching shape's surface. `None` for the default.
    pub settings: Option<&'a GpuArray>,
    /// Numbers for the user's functions: one state.
    pub data: Option<&'a GpuArray>,
    /// The run-time parameters: one state.
    pub parameters: Option<&'a GpuArray>,
    /// Whether the state after each step is stored.
    pub trajectory: bool,
}

impl<'a> RolloutArguments<'a> {
    /// Returns arguments of semi-implicit Euler steps, without other numbers, whose trajectories
    /// are not stored.
    #[must_use]
    pub fn new(q: &'a GpuArray, qd: &'a GpuArray, controls: &'a GpuArray, dt: f32) -> Self {
        let step = Function::StepSemiImplicit;
        Self {
            step,
            q,
            qd,
            act: None,
            controls,
            dt,
            settings: None,
            data: None,
            parameters: None,
            trajectory: false,
        }
    }
}

/// The results of rollouts. They stay on the processor.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct RolloutResults {
    /// The final states: the coordinates, then the velocities.
    pub state: GpuArray,
    /// The sum of the user's function `cost` over the steps; `None` without that function.
    pub cost: Option<GpuArray>,
    /// The state after each step, one set after another: as many scalars as states have, times the
    /// number of steps. `None` if it was not asked for.
    pub trajectory: Option<GpuArray>,
}

impl Rollout {
    /// Compiles the rollouts of the robot of `builder`. Its functions of time steps become kernels;
    /// its other functions can be called by the functions of `options`.
    ///
    /// # Errors
    ///
    /// If the description or the options are wrong, or the processor refuses the user's functions.
    pub fn new(gpu: &Gpu, builder: &Builder, options: &RolloutOptions) -> Result<Self, GpuError> {
        let (source, _) = builder.emit_rollouts(GpuLanguage::Wgsl, options)?;
        let module = gpu.module(&source.prefix, &source.text)?;
        let absent = [gpu.empty(1, 1)?, gpu.empty(1, 1)?];
        let defaults = |rollout: &GpuRollout| {
            (rollout.settings > 0).then(|| gpu.upload(&settings(rollout), 1)).transpose()
        };
        Ok(Self {
            gpu: gpu.clone(),
            settings: source.rollouts.iter().map(defaults).collect::<Result<_, GpuError>>()?,
            source,
            module,
            pipelines: Pipelines::default(),
            absent,
        })
    }

    /// Returns the text of the kernels with their sizes.
    #[must_use]
    pub fn source(&self) -> &RolloutSource {
        &self.source
    }

    /// Runs rollouts. The results stay on the processor; the call does not wait for them.
    ///
    /// # Errors
    ///
    /// If the arguments do not fit the robot.
    pub fn run(&self, arguments: &RolloutArguments<'_>) -> Result<RolloutResults, GpuError> {
        let (index, steps) = self.fitting(arguments)?;
        let source = &self.source;
        let gpu = &self.gpu;
        let size = source.nq + source.nv;
        let count = arguments.controls.states;
        let state = gpu.empty(size, count)?;
        let has_cost = source.buffers.contains(&RolloutBuffer::Costs);
        let cost = has_cost.then(|| gpu.empty(1, count)).transpose()?;
        let trajectory =
            arguments.trajectory.then(|| gpu.empty(size * steps, count)).transpose()?;
        let [unread, unwritten] = &self.absent;
        let starts = arguments.q.states;
        let is_actuated = arguments.step == Function::StepActuated && source.activations > 0;
        let zeros = (is_actuated && arguments.act.is_none())
            .then(|| gpu.upload(&vec![0.0; source.activations * starts], starts))
            .transpose()?;
        let buffers = source.buffers.iter().map(|buffer| match buffer {
            RolloutBuffer::StartQ => Some(arguments.q),
            RolloutBuffer::StartQd => Some(arguments.qd),
            RolloutBuffer::StartAct => arguments.act.or(zeros.as_ref()).or(Some(unread)),
            RolloutBuffer::Controls => Some(arguments.controls),
            RolloutBuffer::Settings => {
                arguments.settings.or(self.settings[index].as_ref()).or(Some(unread))
            }
            RolloutBuffer::Data => arguments.data.or(Some(unread)),
            RolloutBuffer::Parameters => arguments.parameters,
            RolloutBuffer::Out => Some(&state),
            RolloutBuffer::Costs => cost.as_ref(),
            RolloutBuffer::Trajectory => trajectory.as_ref().or(Some(unwritten)),
            _ => None,
        });
        let numbers = [
            gpu.count(count)?,
            gpu.count(steps)?,
            gpu.count(starts)?,
            u32::from(arguments.trajectory),
            arguments.dt.to_bits(),
            0,
            0,
            0,
        ];
        let sizes = gpu.uniform(&numbers);
        let buffers: Vec<&wgpu::Buffer> =
            buffers.flatten().map(|array| &array.buffer).chain([&sizes]).collect();
        gpu.launch(&self.pipeline(index)?, &buffers, count);
        Ok(RolloutResults { state, cost, trajectory })
    }

    /// Returns the index of the kernel and the number of steps, if the arguments fit.
    fn fitting(&self, arguments: &RolloutArguments<'_>) -> Result<(usize, usize), GpuError> {
        let source = &self.source;
        let step = arguments.step.name();
        let place = source.rollouts.iter().position(|rollout| rollout.step == step);
        let index = place.ok_or_else(|| GpuError::NoKernel {
            name: step.into(),
            kernels: source.rollouts.iter().map(|rollout| rollout.step.into()).collect(),
        })?;
        let kernel = || source.rollouts[index].name.clone();
        let all = [Some(arguments.q), Some(arguments.qd), Some(arguments.controls)];
        let others = [arguments.act, arguments.settings, arguments.data, arguments.parameters];
        self.gpu.check_owner(&kernel(), all.into_iter().chain(others).flatten())?;
        let shape = |argument: &str, scalars: usize, array: &GpuArray| GpuError::Shape {
            kernel: kernel(),
            argument: argument.into(),
            scalars,
            given: array.scalars,
        };
        let states = |expected: usize, array: &GpuArray| match array.states == expected {
            true => Ok(()),
            false => Err(GpuError::States { kernel: kernel(), expected, given: array.states }),
        };
        let is_actuated = arguments.step == Function::StepActuated;
        let activations = if is_actuated { source.activations } else { 0 };
        let q = ("q", source.nq, Some(arguments.q));
        let qd = ("qd", source.nv, Some(arguments.qd));
        for (name, scalars, array) in [q, qd, ("act", activations, arguments.act)] {
            let Some(array) = array else { continue };
            if array.scalars != scalars {
                return Err(shape(name, scalars, array));
            }
            states(arguments.q.states, array)?;
        }
        let controls = source.rollouts[index].controls;
        if !arguments.controls.scalars.is_multiple_of(controls) {
            return Err(GpuError::Controls {
                kernel: kernel(),
                controls,
                given: arguments.controls.scalars,
            });
        }
        let has = |buffer| source.buffers.contains(&buffer);
        let settings = arguments.settings.or(self.settings[index].as_ref());
        let settings_count = source.rollouts[index].settings;
        for (name, is_needed, scalars, array) in [
            ("settings", settings_count > 0, Some(settings_count), settings),
            ("data", has(RolloutBuffer::Data), None, arguments.data),
            (
                "parameters",
                has(RolloutBuffer::Parameters),
                Some(source.parameters),
                arguments.parameters,
            ),
        ] {
            match (array, scalars) {
                (Some(array), _) if !is_needed => return Err(shape(name, 0, array)),
                (Some(array), Some(scalars)) if array.scalars != scalars => {
                    return Err(shape(name, scalars, array));
                }
                (Some(array), _) => states(1, array)?,
                (None, Some(scalars)) if is_needed => {
                    return Err(GpuError::Shape {
                        kernel: kernel(),
                        argument: name.into(),
                        scalars,
                        given: 0,
                    });
                }
                (None, _) => {}
            }
        }
        Ok((index, arguments.controls.scalars / controls))
    }

    fn pipeline(&self, index: usize) -> Result<wgpu::ComputePipeline, GpuError> {
        let written = self.source.buffers.iter().map(|buffer| buffer.is_result());
        let name = &self.source.rollouts[index].name;
        self.pipelines.get(&self.gpu, &self.module, index, name, written)
    }
}

/// Returns the default settings of a kernel.
fn settings(rollout: &GpuRollout) -> Vec<f32> {
    let solves = Function::from_name(rollout.step).is_some_and(|step| step.row().has_solver);
    let [common, contact]: [Vec<f32>; 2] = match solves {
        true => [
            StepSettings::<f32, [ContactSurface<f32>; 0]>::DEFAULT.numbers().into(),
            ContactSurface::<f32>::GROUND.numbers().into(),
        ],
        false => [
            ConstraintSettings::<f32, [ContactTarget<f32>; 0]>::DEFAULT.numbers().into(),
            ContactTarget::<f32>::GROUND.numbers().into(),
        ],
    };
    common.into_iter().chain(contact.into_iter().cycle()).take(rollout.settings).collect()
}
