//! Device buffers that are kept between batches and grow as needed.

use wgpu::BufferUsages as Usage;

use super::device::{Device, Fault};

/// A buffer whose first `used` bytes are bound.
#[derive(Debug)]
pub(super) struct Pooled {
    label: &'static str,
    usage: Usage,
    buffer: Option<wgpu::Buffer>,
    used: u64,
    /// Bytes written last, for contents that seldom change.
    written: Vec<u8>,
}

impl Pooled {
    pub(super) fn new(label: &'static str, usage: Usage) -> Self {
        Self {
            label,
            usage,
            buffer: None,
            used: 0,
            written: Vec::new(),
        }
    }

    /// Makes room for a number of bytes; growing discards the contents.
    pub(super) fn reserve(&mut self, device: &Device, bytes: u64) -> &wgpu::Buffer {
        const STEP: u64 = 1 << 20;
        self.used = bytes;
        if self.buffer.as_ref().is_none_or(|buffer| buffer.size() < bytes) {
            self.written.clear();
            // Freed before its replacement is made, so that both needn't fit.
            self.buffer = None;
            let size = if bytes < STEP {
                bytes.next_power_of_two()
            } else {
                bytes.next_multiple_of(STEP)
            };
            let most = device.adapter().limits().buffer_bytes;
            self.buffer = Some(device.raw.create_buffer(&wgpu::BufferDescriptor {
                label: Some(self.label),
                size: size.min(most).max(bytes).max(16),
                usage: self.usage,
                mapped_at_creation: self.usage.contains(Usage::MAP_WRITE),
            }));
        }
        self.buffer()
    }

    /// Replaces the contents.
    pub(super) fn write(&mut self, device: &Device, bytes: &[u8]) {
        device
            .queue
            .write_buffer(self.reserve(device, bytes.len() as u64), 0, bytes);
    }

    /// Replaces the contents, unless they are the same.
    pub(super) fn keep(&mut self, device: &Device, bytes: &[u8]) {
        self.reserve(device, bytes.len() as u64);
        if self.written != bytes {
            device.queue.write_buffer(self.buffer(), 0, bytes);
            self.written.clear();
            self.written.extend_from_slice(bytes);
        }
    }

    /// The whole buffer, which begins with the used bytes.
    pub(super) fn buffer(&self) -> &wgpu::Buffer {
        self.buffer
            .as_ref()
            .expect("a pooled buffer is reserved before it is used")
    }

    /// Number of bytes in use.
    pub(super) fn used(&self) -> u64 {
        self.used
    }

    /// The used bytes as a binding; kernels clamp their indices to its size.
    pub(super) fn binding(&self) -> wgpu::BindingResource<'_> {
        self.range(0, self.used)
    }

    /// A range of bytes as a binding.
    pub(super) fn range(&self, offset: u64, bytes: u64) -> wgpu::BindingResource<'_> {
        wgpu::BindingResource::Buffer(wgpu::BufferBinding {
            buffer: self.buffer(),
            offset,
            size: wgpu::BufferSize::new(bytes),
        })
    }

    /// Copies data to a device buffer through this one, which the host writes. Unlike the queue's own writes, that
    /// allocates no host memory, which is slow in large pieces.
    ///
    /// # Errors
    /// [`Fault::Lost`] if the host can't write this buffer.
    pub(super) fn send(
        &mut self,
        device: &Device,
        bytes: &[u8],
        encoder: &mut wgpu::CommandEncoder,
        to: &mut Self,
    ) -> Result<(), Fault> {
        let size = bytes.len() as u64;
        let to = to.reserve(device, size);
        let staging = self.reserve(device, size);
        staging
            .get_mapped_range_mut(0..size)
            .map_err(|error| Fault::Lost(format!("its memory can't be written: {error}")))?
            .copy_from_slice(bytes);
        staging.unmap();
        encoder.copy_buffer_to_buffer(staging, 0, to, 0, Some(size));
        // Mapped again once this copy is done, ready for the next.
        encoder.map_buffer_on_submit(staging, wgpu::MapMode::Write, 0..staging.size(), |_| {});
        Ok(())
    }

    /// Sets the used bytes to 0.
    pub(super) fn clear(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.clear_buffer(self.buffer(), 0, Some(self.used));
    }

    /// Copies the used bytes to a buffer that the host reads, and maps that once the copy is done.
    pub(super) fn bring(&self, encoder: &mut wgpu::CommandEncoder, to: &Self) {
        encoder.copy_buffer_to_buffer(self.buffer(), 0, to.buffer(), 0, Some(self.used));
        // A failure shows when the mapped range is requested.
        encoder.map_buffer_on_submit(to.buffer(), wgpu::MapMode::Read, 0..self.used, |_| {});
    }

    /// Reads the bytes copied to this buffer.
    ///
    /// # Errors
    /// [`Fault::Lost`] if they never arrived.
    pub(super) fn read<T: bytemuck::Pod>(&self, into: &mut [T]) -> Result<(), Fault> {
        let view = self
            .buffer()
            .get_mapped_range(0..self.used)
            .map_err(|error| Fault::Lost(format!("its results can't be read: {error}")))?;
        bytemuck::cast_slice_mut(into).copy_from_slice(&view);
        drop(view);
        self.buffer().unmap();
        Ok(())
    }
}

/// Buffers that all episodes of a batch share.
#[derive(Debug)]
pub(super) struct Scene {
    pub(super) worlds: Pooled,
    pub(super) shapes: Pooled,
    pub(super) tables: Pooled,
}

impl Default for Scene {
    fn default() -> Self {
        let usage = Usage::STORAGE | Usage::COPY_DST;
        Self {
            worlds: Pooled::new("worlds", usage),
            shapes: Pooled::new("shapes", usage),
            tables: Pooled::new("tables", usage),
        }
    }
}

/// Buffers of one cut of a batch. There are two, so that one is filled and read while the device works on the other.
#[derive(Debug)]
pub(super) struct Bench {
    pub(super) dispatch: Pooled,
    pub(super) groups: Pooled,
    pub(super) inputs: Pooled,
    pub(super) inputs_in: Pooled,
    pub(super) state: Pooled,
    pub(super) fitness: Pooled,
    pub(super) trace: Pooled,
    pub(super) fitness_out: Pooled,
    pub(super) trace_out: Pooled,
    pub(super) state_out: Pooled,
}

impl Default for Bench {
    fn default() -> Self {
        let result = Usage::STORAGE | Usage::COPY_SRC | Usage::COPY_DST;
        Self {
            dispatch: Pooled::new("dispatch", Usage::UNIFORM | Usage::COPY_DST),
            groups: Pooled::new("groups", Usage::STORAGE | Usage::COPY_DST),
            inputs: Pooled::new("inputs", Usage::STORAGE | Usage::COPY_DST),
            inputs_in: Pooled::new("inputs in", Usage::MAP_WRITE | Usage::COPY_SRC),
            state: Pooled::new("state", result),
            fitness: Pooled::new("fitness", result),
            trace: Pooled::new("trace", result),
            fitness_out: Pooled::new("fitness out", Usage::MAP_READ | Usage::COPY_DST),
            trace_out: Pooled::new("trace out", Usage::MAP_READ | Usage::COPY_DST),
            state_out: Pooled::new("state out", Usage::MAP_READ | Usage::COPY_DST),
        }
    }
}
