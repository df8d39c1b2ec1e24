//! The kernels of a robot.

use std::collections::BTreeMap;
use std::sync::Mutex;

use modyn_codegen::Builder;
use modyn_codegen::emit::{GpuKernel, GpuLanguage, GpuSource};
use wgpu::util::DeviceExt;

use crate::{Gpu, GpuArray, GpuError};

/// The threads of a workgroup in the kernels.
const WORKGROUP: usize = 64;

/// The kernels of a robot on a processor. A kernel is compiled when it first runs.
#[derive(Debug)]
pub struct GpuRobot {
    gpu: Gpu,
    source: GpuSource,
    module: wgpu::ShaderModule,
    pipelines: Mutex<BTreeMap<usize, wgpu::ComputePipeline>>,
}

impl GpuRobot {
    /// Compiles the robot of `builder`: its functions become kernels. A function of one link has a kernel for each
    /// link.
    ///
    /// # Errors
    ///
    /// If the description or the options are wrong, or the processor refuses the kernels.
    pub fn new(gpu: &Gpu, builder: &Builder) -> Result<Self, GpuError> {
        let (source, _) = builder.generate_gpu(GpuLanguage::Wgsl)?;
        let device = &gpu.inner.device;
        let scope = device.push_error_scope(wgpu::ErrorFilter::Validation);
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(&source.prefix),
            source: wgpu::ShaderSource::Wgsl(source.text.as_str().into()),
        });
        if let Some(error) = pollster::block_on(scope.pop()) {
            return Err(GpuError::Device(error.to_string()));
        }
        Ok(Self { gpu: gpu.clone(), source, module, pipelines: Mutex::default() })
    }

    /// Returns the text of the kernels, and their arguments and results.
    #[must_use]
    pub fn source(&self) -> &GpuSource {
        &self.source
    }

    /// Runs a kernel on all states of the arguments. Its name is that of the function (`forward_dynamics`); for
    /// functions of one link the link's name follows (`link_pose_hand`). The result stays on the processor; the call
    /// does not wait for it.
    ///
    /// Run-time parameters are an array of one state.
    ///
    /// # Errors
    ///
    /// If there is no such kernel, or the arguments do not fit.
    pub fn run(&self, kernel: &str, arguments: &[&GpuArray]) -> Result<GpuArray, GpuError> {
        let (index, kernel) = self.find(kernel)?;
        let states = fitting(kernel, arguments)?;
        let result = self.gpu.empty(kernel.result, states)?;
        let device = &self.gpu.inner.device;
        let count = u32::try_from(states).map_err(|_| GpuError::TooLarge {
            bytes: 4 * states as u64,
            limit: 4 * u64::from(u32::MAX),
        })?;
        let count = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: None,
            contents: &[count.to_le_bytes(), [0; 4], [0; 4], [0; 4]].concat(),
            usage: wgpu::BufferUsages::UNIFORM,
        });
        let pipeline = self.pipeline(index)?;
        let buffers = arguments.iter().map(|array| &array.buffer).chain([&result.buffer, &count]);
        let entries: Vec<wgpu::BindGroupEntry<'_>> = (0..)
            .zip(buffers)
            .map(|(binding, buffer)| wgpu::BindGroupEntry {
                binding,
                resource: buffer.as_entire_binding(),
            })
            .collect();
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &entries,
        });
        let groups = states.div_ceil(WORKGROUP);
        let most = device.limits().max_compute_workgroups_per_dimension as usize;
        let rows = groups.div_ceil(most);
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(&pipeline);
            pass.set_bind_group(0, &group, &[]);
            let columns = groups.div_ceil(rows);
            pass.dispatch_workgroups(size(columns), size(rows), 1);
        }
        self.gpu.inner.queue.submit([encoder.finish()]);
        Ok(result)
    }

    /// Returns the kernel of that name, and its index.
    fn find(&self, name: &str) -> Result<(usize, &GpuKernel), GpuError> {
        let prefix = format!("{}_", self.source.prefix);
        let own = |kernel: &GpuKernel| kernel.name.trim_start_matches(&prefix).to_string();
        let mut kernels = self.source.kernels.iter().enumerate();
        kernels.find(|(_, kernel)| own(kernel) == name).ok_or_else(|| GpuError::NoKernel {
            name: name.into(),
            kernels: self.source.kernels.iter().map(own).collect(),
        })
    }

    fn pipeline(&self, index: usize) -> Result<wgpu::ComputePipeline, GpuError> {
        let mut pipelines =
            self.pipelines.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        if let Some(pipeline) = pipelines.get(&index) {
            return Ok(pipeline.clone());
        }
        let device = &self.gpu.inner.device;
        let scope = device.push_error_scope(wgpu::ErrorFilter::Validation);
        // A layout derived from the text would lack the buffers of arguments that the kernel does not read.
        let layout = layout(device, &self.source.kernels[index]);
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: None,
            layout: Some(&layout),
            module: &self.module,
            entry_point: Some(&self.source.kernels[index].name),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
        if let Some(error) = pollster::block_on(scope.pop()) {
            return Err(GpuError::Device(error.to_string()));
        }
        pipelines.insert(index, pipeline.clone());
        Ok(pipeline)
    }
}

/// Returns the buffers of a kernel: its arguments, the result, and the number of states.
fn layout(device: &wgpu::Device, kernel: &GpuKernel) -> wgpu::PipelineLayout {
    let read = wgpu::BufferBindingType::Storage { read_only: true };
    let written = wgpu::BufferBindingType::Storage { read_only: false };
    let arguments = kernel.arguments.iter().map(|_| read);
    let buffers = arguments.chain([written, wgpu::BufferBindingType::Uniform]);
    let entries: Vec<wgpu::BindGroupLayoutEntry> = (0..)
        .zip(buffers)
        .map(|(binding, ty)| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
            count: None,
        })
        .collect();
    let group = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: None,
        entries: &entries,
    });
    device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: None,
        bind_group_layouts: &[Some(&group)],
        immediate_size: 0,
    })
}

/// Returns a number of workgroups within the processor's limits.
fn size(groups: usize) -> u32 {
    u32::try_from(groups).unwrap_or(u32::MAX)
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
