//! Numbers for many states on the graphics processor.

use std::sync::{Arc, mpsc};

use crate::{Gpu, GpuError};
use modyn_runtime::Array;

/// Numbers for many states on a graphics processor: scalar `j` of state `i` of `n` states is number
/// `j n + i`.
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
    /// If the processor has no memory for the copy, or it failed.
    pub fn read(&self) -> Result<Vec<f32>, GpuError> {
        let failed = |error: &dyn std::fmt::Display| GpuError::Device(error.to_string());
        let device = &self.gpu.inner.device;
        let queue = &self.gpu.inner.queue;
        let size = self.buffer.size();
        let usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
        let copy = self.gpu.buffer(size, usage)?;
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

    /// Waits until the numbers are computed, and returns an array for each state, as the functions
    /// of generated robots have it: accelerations of an arm as `Vec<[f64; 7]>`. A result of several
    /// parts is one array of their numbers in order, a matrix its columns.
    ///
    /// # Errors
    ///
    /// If an array has another length than a state has scalars, the processor has no memory for the
    /// copy, or it failed.
    pub fn read_states<T: Copy + From<f32>, A: Array<T>>(&self) -> Result<Vec<A>, GpuError> {
        if A::LEN != self.scalars {
            return Err(GpuError::Width { scalars: self.scalars, asked: A::LEN });
        }
        let numbers = self.read()?;
        let states = self.states;
        let of_state = |state: usize| A::from_fn(|j| T::from(numbers[j * states + state]));
        Ok((0..states).map(of_state).collect())
    }
}

impl Gpu {
    /// Copies numbers for this number of states to the processor: scalar `j` of state `i` is number
    /// `j states + i`.
    ///
    /// # Errors
    ///
    /// If the length is not a whole number of scalars for each state, is too large for the
    /// processor, or there is no memory left for the array.
    pub fn upload(&self, numbers: &[f32], states: usize) -> Result<GpuArray, GpuError> {
        if states == 0 || numbers.is_empty() || !numbers.len().is_multiple_of(states) {
            return Err(GpuError::Length { numbers: numbers.len(), states });
        }
        let array = self.empty(numbers.len() / states, states)?;
        let bytes: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
        let write = || self.inner.queue.write_buffer(&array.buffer, 0, &bytes);
        self.with_memory(bytes.len() as u64, write)?;
        Ok(array)
    }

    /// Copies states to the processor, each an array as the functions of generated robots take it:
    /// coordinates of an arm as `&[[f64; 7]]`. The numbers are rounded to single precision.
    ///
    /// # Errors
    ///
    /// If there are no states, too many for the processor, or there is no memory left for the
    /// array.
    pub fn upload_states<T: Copy + Into<f64>, A: Array<T>>(
        &self,
        states: &[A],
    ) -> Result<GpuArray, GpuError> {
        let columns = (0..A::LEN).flat_map(|j| {
            states.iter().map(move |state| {
                let number: f64 = state.as_ref()[j].into();
                number as f32
            })
        });
        self.upload(&columns.collect::<Vec<f32>>(), states.len())
    }

    /// Checks that these arguments of a kernel are in the memory of this processor.
    pub(crate) fn check_owner<'a>(
        &self,
        kernel: &str,
        mut arguments: impl Iterator<Item = &'a GpuArray>,
    ) -> Result<(), GpuError> {
        match arguments.all(|array| Arc::ptr_eq(&array.gpu.inner, &self.inner)) {
            true => Ok(()),
            false => Err(GpuError::OtherProcessor { kernel: kernel.into() }),
        }
    }

    /// Returns memory for a result.
    pub(crate) fn empty(&self, scalars: usize, states: usize) -> Result<GpuArray, GpuError> {
        let size = self.check(scalars.saturating_mul(states))?;
        let usage = wgpu::BufferUsages::STORAGE
            | wgpu::BufferUsages::COPY_SRC
            | wgpu::BufferUsages::COPY_DST;
        let buffer = self.buffer(size, usage)?;
        Ok(GpuArray { gpu: self.clone(), buffer, scalars, states })
    }

    /// Returns memory of this many bytes.
    pub(crate) fn buffer(
        &self,
        size: u64,
        usage: wgpu::BufferUsages,
    ) -> Result<wgpu::Buffer, GpuError> {
        let descriptor =
            wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false };
        self.with_memory(size, || self.inner.device.create_buffer(&descriptor))
    }
}
