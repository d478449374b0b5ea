//! Any kernel on any buffers, for the suites that compare a driver's operations with the CPU's.

use oneiro_shaders::{BindingKind, Kernel};
use wgpu::BufferUsages as Usage;

use super::Gpu;
use super::buffers::Pooled;
use super::device::{Device, Fault};
use crate::evaluator::{Control, Error};

impl Gpu {
    /// Runs a kernel once, on buffers in the order of its bindings; those it may write have its results
    /// afterwards.
    ///
    /// # Errors
    /// As [`Evaluator::evaluate_part`](crate::evaluator::Evaluator::evaluate_part).
    ///
    /// # Panics
    /// If there are not as many buffers as bindings, or a buffer is empty or no multiple of its element.
    pub fn run_kernel(&mut self, kernel: &Kernel, buffers: &mut [Vec<u32>], workgroups: u32) -> Result<(), Error> {
        assert_eq!(buffers.len(), kernel.bindings.len(), "the buffers of `{}`", kernel.name);
        for (buffer, binding) in buffers.iter().zip(kernel.bindings) {
            let whole = !buffer.is_empty() && buffer.len() * 4 % binding.stride as usize == 0;
            assert!(
                whole,
                "`{}` of `{}` has {} words",
                binding.name,
                kernel.name,
                buffer.len()
            );
        }
        run(&mut self.device, kernel, buffers, workgroups).map_err(|fault| self.error(fault))
    }
}

fn run(device: &mut Device, kernel: &Kernel, buffers: &mut [Vec<u32>], workgroups: u32) -> Result<(), Fault> {
    let pipeline = device.pipeline(kernel)?;
    let label = Some(kernel.name);
    let mut bound = Vec::with_capacity(buffers.len());
    let mut written = Vec::new();
    for (index, (buffer, binding)) in buffers.iter().zip(kernel.bindings).enumerate() {
        let usage = match binding.kind {
            BindingKind::Uniform => Usage::UNIFORM,
            BindingKind::Read => Usage::STORAGE,
            BindingKind::ReadWrite => Usage::STORAGE | Usage::COPY_SRC,
        };
        let mut pooled = Pooled::new(binding.name, usage | Usage::COPY_DST);
        pooled.write(device, bytemuck::cast_slice(buffer));
        if binding.kind == BindingKind::ReadWrite {
            let mut out = Pooled::new(binding.name, Usage::MAP_READ | Usage::COPY_DST);
            out.reserve(device, pooled.used());
            written.push((index, out));
        }
        bound.push(pooled);
    }
    let entries: Vec<_> = bound
        .iter()
        .zip(kernel.bindings)
        .map(|(buffer, binding)| wgpu::BindGroupEntry {
            binding: binding.binding,
            resource: buffer.binding(),
        })
        .collect();
    let bind_group = device.raw.create_bind_group(&wgpu::BindGroupDescriptor {
        label,
        layout: &pipeline.bindings,
        entries: &entries,
    });

    let mut encoder = device
        .raw
        .create_command_encoder(&wgpu::CommandEncoderDescriptor { label });
    {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label,
            timestamp_writes: None,
        });
        pass.set_pipeline(&pipeline.compute);
        pass.set_bind_group(0, &bind_group, &[]);
        pass.dispatch_workgroups(workgroups, 1, 1);
    }
    for (index, out) in &written {
        bound[*index].bring(&mut encoder, out);
    }
    let submission = device.submit(encoder);
    device.wait(&submission, &Control::new())?;
    for (index, out) in &written {
        out.read(&mut buffers[*index])?;
    }
    Ok(())
}
