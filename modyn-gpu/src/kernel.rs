//! Kernels on the processor: texts, pipelines and launches.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

use wgpu::util::DeviceExt;

use crate::{Gpu, GpuError};

/// The threads of a workgroup in the kernels.
const WORKGROUP: usize = 64;

/// The kernels of a text that were compiled already, by their indices.
#[derive(Debug, Default)]
pub(crate) struct Pipelines {
    compiled: Mutex<BTreeMap<usize, wgpu::ComputePipeline>>,
}

impl Pipelines {
    /// Returns the kernel with this index and entry point, and compiles it if it is the first time.
    /// `written` says of each buffer whether the kernel writes it.
    pub(crate) fn get(
        &self,
        gpu: &Gpu,
        module: &wgpu::ShaderModule,
        index: usize,
        entry: &str,
        written: impl Iterator<Item = bool>,
    ) -> Result<wgpu::ComputePipeline, GpuError> {
        let mut compiled = self.compiled.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(pipeline) = compiled.get(&index) {
            return Ok(pipeline.clone());
        }
        let pipeline = gpu.pipeline(module, entry, written)?;
        compiled.insert(index, pipeline.clone());
        Ok(pipeline)
    }
}

impl Gpu {
    /// Compiles a text.
    pub(crate) fn module(&self, label: &str, text: &str) -> Result<wgpu::ShaderModule, GpuError> {
        let device = &self.inner.device;
        let scope = device.push_error_scope(wgpu::ErrorFilter::Validation);
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(label),
            source: wgpu::ShaderSource::Wgsl(text.into()),
        });
        match pollster::block_on(scope.pop()) {
            Some(error) => Err(GpuError::Device(error.to_string())),
            None => Ok(module),
        }
    }

    /// Returns the kernel of a text with this entry point. `written` says of each buffer whether
    /// the kernel writes it; the last buffer is a uniform besides these.
    fn pipeline(
        &self,
        module: &wgpu::ShaderModule,
        entry: &str,
        written: impl Iterator<Item = bool>,
    ) -> Result<wgpu::ComputePipeline, GpuError> {
        let device = &self.inner.device;
        let scope = device.push_error_scope(wgpu::ErrorFilter::Validation);
        // A layout derived from the text would lack the buffers of arguments that the kernel does
        // not read.
        let layout = layout(device, written);
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: None,
            layout: Some(&layout),
            module,
            entry_point: Some(entry),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
        match pollster::block_on(scope.pop()) {
            Some(error) => Err(GpuError::Device(error.to_string())),
            None => Ok(pipeline),
        }
    }

    /// Returns the number of states as the kernels have it.
    pub(crate) fn count(&self, states: usize) -> Result<u32, GpuError> {
        u32::try_from(states).map_err(|_| GpuError::TooLarge {
            bytes: 4 * states as u64,
            limit: 4 * u64::from(u32::MAX),
        })
    }

    /// Returns a uniform of these numbers.
    pub(crate) fn uniform(&self, numbers: &[u32]) -> wgpu::Buffer {
        let bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
        self.inner.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: None,
            contents: &bytes,
            usage: wgpu::BufferUsages::UNIFORM,
        })
    }

    /// Starts a kernel with a thread for each state, and does not wait.
    pub(crate) fn launch(
        &self,
        pipeline: &wgpu::ComputePipeline,
        buffers: &[&wgpu::Buffer],
        states: usize,
    ) {
        let device = &self.inner.device;
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
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &group, &[]);
            let columns = groups.div_ceil(rows);
            pass.dispatch_workgroups(size(columns), size(rows), 1);
        }
        self.inner.queue.submit([encoder.finish()]);
    }
}

/// Returns the layout of buffers and of the uniform after them.
fn layout(device: &wgpu::Device, written: impl Iterator<Item = bool>) -> wgpu::PipelineLayout {
    let storage = |written: bool| wgpu::BufferBindingType::Storage { read_only: !written };
    let buffers = written.map(storage).chain([wgpu::BufferBindingType::Uniform]);
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
