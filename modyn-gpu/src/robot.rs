//! The kernels of a robot.

use modyn_codegen::emit::GpuKernel;
use modyn_codegen::{Builder, Emitted, Target};

use crate::kernel::Pipelines;
use crate::{Gpu, GpuArray, GpuError};

/// The text of a robot's kernels.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct GpuSource {
    /// The prefix of all names.
    pub prefix: String,
    /// The text.
    pub text: String,
    /// The kernels, in the order of the text.
    pub kernels: Vec<GpuKernel>,
}

/// The kernels of a robot on a processor. A kernel is compiled when it first runs.
#[derive(Debug)]
pub struct GpuRobot {
    gpu: Gpu,
    source: GpuSource,
    module: wgpu::ShaderModule,
    pipelines: Pipelines,
}

impl GpuRobot {
    /// Compiles the robot of `builder`: its functions become kernels. A function of one link has a
    /// kernel for each link.
    ///
    /// # Errors
    ///
    /// If the description or the options are wrong, or the processor refuses the kernels.
    pub fn new(gpu: &Gpu, builder: &Builder) -> Result<Self, GpuError> {
        let emitted = builder.emit(Target::Wgsl)?;
        let text = emitted.text().into();
        let Emitted { prefix, kernels, .. } = emitted;
        let source = GpuSource { prefix, text, kernels };
        let module = gpu.module(&source.prefix, &source.text)?;
        Ok(Self { gpu: gpu.clone(), source, module, pipelines: Pipelines::default() })
    }

    /// Returns the text of the kernels, and their arguments and results.
    #[must_use]
    pub fn source(&self) -> &GpuSource {
        &self.source
    }

    /// Runs a kernel on all states of the arguments. Its name is the function's
    /// (`forward_dynamics`); for functions of one link the link's name follows (`link_pose_hand`).
    /// The result stays on the processor; the call does not wait for it.
    ///
    /// Run-time parameters are an array of one state.
    ///
    /// # Errors
    ///
    /// If there is no such kernel, or the arguments do not fit.
    pub fn run(&self, kernel: &str, arguments: &[&GpuArray]) -> Result<GpuArray, GpuError> {
        let (index, kernel) = self.find(kernel)?;
        self.gpu.check_owner(&kernel.name, arguments.iter().copied())?;
        let states = fitting(kernel, arguments)?;
        let result = self.gpu.empty(kernel.result, states)?;
        let count = self.gpu.uniform(&[self.gpu.count(states)?, 0, 0, 0]);
        let pipeline = self.pipeline(index)?;
        let of_arguments = arguments.iter().map(|array| &array.buffer);
        let buffers: Vec<&wgpu::Buffer> = of_arguments.chain([&result.buffer, &count]).collect();
        self.gpu.launch(&pipeline, &buffers, states);
        Ok(result)
    }

    /// Returns the kernel of that name, and its index.
    fn find(&self, name: &str) -> Result<(usize, &GpuKernel), GpuError> {
        let source = &self.source;
        let own_names = || source.kernels.iter().map(|kernel| kernel.own_name(&source.prefix));
        let index = own_names().position(|kernel_name| kernel_name == name).ok_or_else(|| {
            GpuError::NoKernel {
                name: name.into(),
                kernels: own_names().map(String::from).collect(),
            }
        })?;
        Ok((index, &source.kernels[index]))
    }

    fn pipeline(&self, index: usize) -> Result<wgpu::ComputePipeline, GpuError> {
        let kernel = &self.source.kernels[index];
        let written = kernel.arguments.iter().map(|_| false).chain([true]);
        self.pipelines.get(&self.gpu, &self.module, index, &kernel.name, written)
    }
}

/// Returns the number of states of these arguments, if they fit the kernel.
fn fitting(kernel: &GpuKernel, arguments: &[&GpuArray]) -> Result<usize, GpuError> {
    let name = || kernel.name.clone();
    if arguments.len() != kernel.arguments.len() {
        let expected = kernel.arguments.iter().map(|argument| argument.name.clone()).collect();
        return Err(GpuError::Arguments { kernel: name(), expected, given: arguments.len() });
    }
    let mut states = None;
    for (argument, array) in kernel.arguments.iter().zip(arguments) {
        if argument.len != array.scalars {
            return Err(GpuError::Shape {
                kernel: name(),
                argument: argument.name.clone(),
                scalars: argument.len,
                given: array.scalars,
            });
        }
        let expected = if argument.common { 1 } else { *states.get_or_insert(array.states) };
        if array.states != expected {
            return Err(GpuError::States { kernel: name(), expected, given: array.states });
        }
    }
    Ok(states.unwrap_or(1))
}
