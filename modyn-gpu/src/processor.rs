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
        Self::of(&wgpu::Instance::default())
    }

    /// Returns the fastest processor that an instance of wgpu finds.
    fn of(instance: &wgpu::Instance) -> Result<Self, GpuError> {
        let options = wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::HighPerformance,
            ..Default::default()
        };
        let requested = pollster::block_on(instance.request_adapter(&options));
        let adapter = requested.map_err(|error| GpuError::NoAdapter(error.to_string()))?;
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
        let bytes = (numbers as u64).saturating_mul(4);
        let limit = self.inner.limit;
        if bytes > limit { Err(GpuError::TooLarge { bytes, limit }) } else { Ok(bytes) }
    }

    /// Returns the result of `make`, which takes memory of the processor for this many bytes.
    pub(crate) fn with_memory<T>(
        &self,
        bytes: u64,
        make: impl FnOnce() -> T,
    ) -> Result<T, GpuError> {
        let scope = self.inner.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let made = make();
        match pollster::block_on(scope.pop()) {
            Some(_) => Err(GpuError::OutOfMemory { bytes }),
            None => Ok(made),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_machine_without_processors_is_an_error() {
        let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
        descriptor.backends = wgpu::Backends::empty();
        let error = Gpu::of(&wgpu::Instance::new(descriptor)).expect_err("no processor");
        assert!(matches!(error, GpuError::NoAdapter(_)), "{error}");
        assert!(error.to_string().contains("mesa-vulkan-drivers"), "{error}");
    }

    #[test]
    fn arrays_beyond_the_limit_are_refused() {
        let gpu = Gpu::new().expect("a processor");
        let numbers = (gpu.inner.limit / 4) as usize;
        assert_eq!(gpu.check(numbers).expect("allowed"), 4 * numbers as u64);
        let error = gpu.check(numbers + 1).expect_err("too large");
        assert!(matches!(error, GpuError::TooLarge { .. }), "{error}");
        let error = gpu.empty(numbers, 2).expect_err("too large");
        assert!(error.to_string().contains(&gpu.inner.limit.to_string()), "{error}");
    }
}
