//! Runs any kernel on any buffers, for tests that compare a driver's operations with the CPU's.

use oneiro_shaders::{BindingKind, Kernel};
use wgpu::BufferUsages as Usage;

use super::Gpu;
use super::buffers::Pooled;
use super::device::{Device, Fault};
use crate::evaluator::{Control, Error};

/// One dispatch of a kernel.
#[derive(Clone, Debug)]
pub struct Run<'a> {
    /// Kernel to run.
    pub kernel: &'a Kernel,
    /// Non-empty buffers in the order of its bindings; writable ones hold the results afterwards.
    pub buffers: Vec<Vec<u32>>,
    /// Number of workgroups.
    pub workgroups: u32,
}

/// Alignment of bound ranges on every device, in bytes.
const ALIGNMENT: usize = 256;

impl Gpu {
    /// Runs a kernel once, on buffers as in [`Run`].
    ///
    /// # Errors
    /// As [`Evaluator::evaluate_part`](crate::evaluator::Evaluator::evaluate_part).
    ///
    /// # Panics
    /// As [`Gpu::run`].
    pub fn run_kernel(&mut self, kernel: &Kernel, buffers: &mut [Vec<u32>], workgroups: u32) -> Result<(), Error> {
        let taken = buffers.iter_mut().map(std::mem::take).collect();
        let mut runs = [Run {
            kernel,
            buffers: taken,
            workgroups,
        }];
        let done = self.run(&mut runs);
        let [run] = runs;
        for (place, buffer) in buffers.iter_mut().zip(run.buffers) {
            *place = buffer;
        }
        done
    }

    /// Runs kernels, all in one submission.
    ///
    /// # Errors
    /// As [`Evaluator::evaluate_part`](crate::evaluator::Evaluator::evaluate_part).
    ///
    /// # Panics
    /// If the number of buffers isn't that of the bindings, or a buffer is empty or isn't a multiple of its element.
    pub fn run(&mut self, runs: &mut [Run<'_>]) -> Result<(), Error> {
        for Run { kernel, buffers, .. } in runs.iter() {
            assert_eq!(buffers.len(), kernel.bindings.len(), "the buffers of `{}`", kernel.name);
            for (buffer, binding) in buffers.iter().zip(kernel.bindings) {
                let whole = !buffer.is_empty() && (buffer.len() * 4).is_multiple_of(binding.stride as usize);
                assert!(
                    whole,
                    "`{}` of `{}` has {} words",
                    binding.name,
                    kernel.name,
                    buffer.len()
                );
            }
        }
        run(&mut self.device, runs).map_err(|fault| self.error(fault))
    }
}

/// All buffers with one kind of binding, concatenated in one buffer of the device. wgpu tracks the use of whole
/// buffers, so read-only and writable data must be separate.
struct Arena {
    buffer: Pooled,
    words: Vec<u32>,
}

impl Arena {
    fn new(label: &'static str, usage: Usage) -> Self {
        Self {
            buffer: Pooled::new(label, usage | Usage::COPY_DST),
            words: Vec::new(),
        }
    }

    /// Appends a buffer and returns the index of its first word.
    fn push(&mut self, words: &[u32]) -> usize {
        let start = self.words.len();
        self.words.extend_from_slice(words);
        self.words.resize(self.words.len().next_multiple_of(ALIGNMENT / 4), 0);
        start
    }
}

/// Index of the arena for a kind of binding.
fn arena(kind: BindingKind) -> usize {
    match kind {
        BindingKind::Uniform => 0,
        BindingKind::Read => 1,
        BindingKind::ReadWrite => WRITTEN,
    }
}
const WRITTEN: usize = 2;

fn run(device: &mut Device, runs: &mut [Run<'_>]) -> Result<(), Fault> {
    let mut arenas = [
        Arena::new("uniform", Usage::UNIFORM),
        Arena::new("read", Usage::STORAGE),
        Arena::new("written", Usage::STORAGE | Usage::COPY_SRC),
    ];
    // Start of each run's buffers in their arenas.
    let mut starts: Vec<Vec<usize>> = Vec::with_capacity(runs.len());
    for run in runs.iter() {
        let buffers = run.buffers.iter().zip(run.kernel.bindings);
        starts.push(
            buffers
                .map(|(words, binding)| arenas[arena(binding.kind)].push(words))
                .collect(),
        );
    }
    for Arena { buffer, words } in arenas.iter_mut().filter(|arena| !arena.words.is_empty()) {
        buffer.write(device, bytemuck::cast_slice(words));
    }
    let mut out = Pooled::new("out", Usage::MAP_READ | Usage::COPY_DST);
    out.reserve(device, arenas[WRITTEN].buffer.used());

    let (label, control) = (Some("runs"), Control::new());
    let mut encoder = device
        .raw
        .create_command_encoder(&wgpu::CommandEncoderDescriptor { label });
    {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label,
            timestamp_writes: None,
        });
        for (run, starts) in runs.iter().zip(&starts) {
            let pipeline = device.pipeline(run.kernel, &control)?;
            let buffers = run.buffers.iter().zip(run.kernel.bindings).zip(starts);
            let entries: Vec<_> = buffers
                .map(|((words, binding), start)| wgpu::BindGroupEntry {
                    binding: binding.binding,
                    resource: arenas[arena(binding.kind)]
                        .buffer
                        .range(*start as u64 * 4, words.len() as u64 * 4),
                })
                .collect();
            let bind_group = device.raw.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some(run.kernel.name),
                layout: &pipeline.bindings,
                entries: &entries,
            });
            pass.set_pipeline(&pipeline.compute);
            pass.set_bind_group(0, &bind_group, &[]);
            pass.dispatch_workgroups(run.workgroups, 1, 1);
        }
    }
    let [.., written] = &mut arenas;
    written.buffer.bring(&mut encoder, &out);
    let submission = device.submit(encoder);
    device.wait(&submission, &control)?;
    out.read(&mut written.words)?;
    for (run, starts) in runs.iter_mut().zip(&starts) {
        let buffers = run.buffers.iter_mut().zip(run.kernel.bindings).zip(starts);
        for ((words, _), start) in buffers.filter(|((_, binding), _)| binding.kind == BindingKind::ReadWrite) {
            let results = *start..*start + words.len();
            words.copy_from_slice(&written.words[results]);
        }
    }
    Ok(())
}
