//! Numbers for many states on the graphics processor.

use std::sync::mpsc;

use crate::{Gpu, GpuError};

/// Numbers for many states on a graphics processor: scalar `j` of state `i` of `n` states is number `j n + i`.
#[derive(Clone, Debug)]
pub struct GpuArray {
    pub(crate) gpu: Gpu,
    pub(crate) buffer: wgpu::Buffer,
    pub(crate) scalars: usize,
    pub(crate) states: usize,
}

impl GpuArray {
    /// Returns the number of scalars of a state.
    #[must_use]
    pub fn scalars(&self) -> usize {
        self.scalars
    }

    /// Returns the number of states.
    #[must_use]
    pub fn states(&self) -> usize {
        self.states
    }

    /// Waits until the numbers are computed, and returns a copy of them.
    ///
    /// # Errors
    ///
    /// If the processor failed.
    pub fn read(&self) -> Result<Vec<f32>, GpuError> {
        let failed = |error: &dyn std::fmt::Display| GpuError::Device(error.to_string());
        let (device, queue) = (&self.gpu.inner.device, &self.gpu.inner.queue);
        let size = self.buffer.size();
        let copy = device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size,
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_buffer_to_buffer(&self.buffer, 0, &copy, 0, size);
        queue.submit([encoder.finish()]);
        let (sender, receiver) = mpsc::channel();
        copy.slice(..).map_async(wgpu::MapMode::Read, move |result| {
            // The receiver is gone, so nothing is lost.
            let _ = sender.send(result);
        });
        device.poll(wgpu::PollType::wait_indefinitely()).map_err(|error| failed(&error))?;
        let mapped = receiver.recv().map_err(|error| failed(&error))?;
        mapped.map_err(|error| failed(&error))?;
        let bytes = copy.slice(..).get_mapped_range().map_err(|error| failed(&error))?;
        let (numbers, _) = bytes.as_chunks::<4>();
        Ok(numbers.iter().map(|number| f32::from_le_bytes(*number)).collect())
    }
}
