//! A graphics processor.

use std::sync::Arc;

use crate::GpuError;

/// A graphics processor. Clones are cheap and refer to the same processor.
#[derive(Clone, Debug)]
pub struct Gpu {
    pub(crate) inner: Arc<Inner>,
}

#[derive(Debug)]
pub(crate) struct Inner {
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    name: String,
    is_software: bool,
    limit: u64,
}

impl Gpu {
    /// Returns the fastest processor of the machine; a software processor where there is no other.
    ///
    /// # Errors
    ///
    /// If there is none, or it cannot be opened.
    pub fn new() -> Result<Self, GpuError> {
        let instance = wgpu::Instance::default();
        let options = wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::HighPerformance,
            ..Default::default()
        };
        let adapter = pollster::block_on(instance.request_adapter(&options));
        let adapter = adapter.map_err(|error| GpuError::NoAdapter(error.to_string()))?;
        let limits = adapter.limits();
        let descriptor =
            wgpu::DeviceDescriptor { required_limits: limits.clone(), ..Default::default() };
        let opened = pollster::block_on(adapter.request_device(&descriptor));
        let (device, queue) = opened.map_err(|error| GpuError::NoDevice(error.to_string()))?;
        // WGSL counts the numbers of a buffer in 32 bits.
        let limit = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size).min(1 << 34);
        let wgpu::AdapterInfo { name, device_type, .. } = adapter.get_info();
        let is_software = device_type == wgpu::DeviceType::Cpu;
        Ok(Self { inner: Arc::new(Inner { device, queue, name, is_software, limit }) })
    }

    /// Returns the name of the processor, as its driver gives it.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.inner.name
    }

    /// Returns whether the processor is software that runs on the CPU.
    #[must_use]
    pub fn is_software(&self) -> bool {
        self.inner.is_software
    }

    /// Waits until all kernels that were started have ended.
    ///
    /// # Errors
    ///
    /// If the processor failed.
    pub fn wait(&self) -> Result<(), GpuError> {
        let waited = self.inner.device.poll(wgpu::PollType::wait_indefinitely());
        waited.map(drop).map_err(|error| GpuError::Device(error.to_string()))
    }

    /// Returns the size of this many numbers in bytes, if the processor has memory for them.
    pub(crate) fn check(&self, numbers: usize) -> Result<u64, GpuError> {
        let (bytes, limit) = (4 * numbers as u64, self.inner.limit);
        if bytes > limit { Err(GpuError::TooLarge { bytes, limit }) } else { Ok(bytes) }
    }
}
