//! An open device: compiles kernels, waits for work, and reports faults.

use std::cell::Cell;
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use oneiro_shaders::{Binding, BindingKind, Kernel};

use super::adapter::{Adapter, FloatControls};
use super::spirv;
use crate::devices::background;
use crate::evaluator::{Control, Error};

/// Number of storage buffers that an episode binds.
const STORAGE_BUFFERS: u32 = 8;

/// Form of a device's kernels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Path {
    /// Exact SPIR-V.
    Spirv,
    /// WGSL, which drivers may round as they like.
    Wgsl,
}

/// Reason why a device gave no result.
#[derive(Debug)]
pub(super) enum Fault {
    /// The evaluation was cancelled.
    Cancelled,
    /// The device is lost, with the driver's message.
    Lost(String),
    /// Memory ran out; a smaller batch might fit.
    OutOfMemory,
    /// The device can't do this at any size.
    TooLarge(String),
    /// The driver refuses the kernel or its use.
    Refused(String),
}

/// Errors reported by wgpu's callbacks.
#[derive(Debug, Default)]
struct Reported {
    lost: Option<String>,
    error: Option<wgpu::Error>,
}

/// A kernel that is ready to run.
#[derive(Debug)]
pub(super) struct Pipeline {
    pub(super) kernel: &'static str,
    pub(super) bindings: wgpu::BindGroupLayout,
    pub(super) compute: wgpu::ComputePipeline,
}

/// Makes pipelines.
pub(super) struct Maker {
    raw: wgpu::Device,
    path: Path,
    float_controls: FloatControls,
}

impl Maker {
    /// Compiles a kernel, or a variant of it from SPIR-V.
    pub(super) fn pipeline(&self, kernel: &Kernel, variant: Option<&[u32]>) -> Pipeline {
        let label = Some(kernel.name);
        let entries: Vec<_> = kernel.bindings.iter().map(layout_entry).collect();
        let bindings = self.raw.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label,
            entries: &entries,
        });
        let layout = self.raw.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label,
            bind_group_layouts: &[Some(&bindings)],
            immediate_size: 0,
        });
        let module = match self.path {
            Path::Spirv => {
                let words = spirv::with_modes(variant.unwrap_or(kernel.spirv), self.float_controls);
                let descriptor = wgpu::ShaderModuleDescriptorPassthrough {
                    label,
                    entry_points: vec![wgpu::PassthroughShaderEntryPoint {
                        name: kernel.entry_point.into(),
                        workgroup_size: (kernel.workgroup_size, 1, 1),
                    }]
                    .into(),
                    spirv: Some(words.into()),
                    ..Default::default()
                };
                // SAFETY: naga wrote the module from a validated one, with every loop ended by its own bound. Indices are clamped to
                // their buffers, or those of a kernel that was seen to stay within; wgpu asks the driver for robust access besides,
                // which keeps any index within the buffer's memory. The added modes are supported by the driver.
                unsafe { self.raw.create_shader_module_passthrough(descriptor) }
            }
            Path::Wgsl => self.raw.create_shader_module(wgpu::ShaderModuleDescriptor {
                label,
                source: wgpu::ShaderSource::Wgsl(kernel.wgsl.into()),
            }),
        };
        let compute = self.raw.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label,
            layout: Some(&layout),
            module: &module,
            entry_point: Some(kernel.entry_point),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
        Pipeline {
            kernel: kernel.name,
            bindings,
            compute,
        }
    }
}

/// An open device.
#[derive(Debug)]
pub(super) struct Device {
    pub(super) raw: wgpu::Device,
    pub(super) queue: wgpu::Queue,
    adapter: Adapter,
    path: Path,
    /// Modes that its kernels request.
    float_controls: FloatControls,
    reported: Arc<Mutex<Reported>>,
    pub(super) doom: Doom,
    /// By name and SPIR-V, so that a changed kernel is a different one.
    pipelines: BTreeMap<(&'static str, usize), Arc<Pipeline>>,
    /// Whether work was left unfinished by a cancellation.
    is_busy: Cell<bool>,
}

impl Device {
    /// Opens a device.
    ///
    /// # Errors
    /// [`Error::NoDevice`] if the adapter can't run the kernels, or doesn't accept SPIR-V where the path requires it.
    pub(super) fn open(adapter: &Adapter, path: Path) -> Result<Self, Error> {
        let refused = |problem: String| Error::NoDevice(format!("{}: {problem}", adapter.name()));
        let (needed, has) = (STORAGE_BUFFERS, adapter.limits().storage_buffers);
        if has < needed {
            return Err(refused(format!(
                "binds {has} storage buffers per kernel; needed: {needed}"
            )));
        }
        let features = match path {
            Path::Spirv if adapter.takes_spirv() => wgpu::Features::PASSTHROUGH_SHADERS,
            Path::Spirv => return Err(refused(format!("{} does not accept SPIR-V", adapter.backend()))),
            Path::Wgsl => wgpu::Features::empty(),
        };
        let most = adapter.handle.limits();
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("oneiro"),
            required_features: features,
            required_limits: wgpu::Limits {
                max_storage_buffers_per_shader_stage: needed,
                max_storage_buffer_binding_size: most.max_storage_buffer_binding_size,
                max_buffer_size: most.max_buffer_size,
                max_compute_workgroups_per_dimension: most.max_compute_workgroups_per_dimension,
                ..wgpu::Limits::downlevel_defaults().or_worse_values_from(&most)
            },
            memory_hints: wgpu::MemoryHints::MemoryUsage,
            ..Default::default()
        };
        let (device, queue) = pollster::block_on(adapter.handle.request_device(&descriptor))
            .map_err(|error| refused(error.to_string()))?;

        let reported = Arc::new(Mutex::new(Reported::default()));
        let sink = Arc::clone(&reported);
        device.on_uncaptured_error(Arc::new(move |error| {
            // The first error is the cause; those that follow are consequences.
            lock(&sink).error.get_or_insert(error);
        }));
        let sink = Arc::clone(&reported);
        device.set_device_lost_callback(move |reason, message| {
            let said = if message.is_empty() {
                format!("{reason:?}").to_lowercase()
            } else {
                message
            };
            lock(&sink).lost.get_or_insert(said);
        });
        Ok(Self {
            raw: device,
            queue,
            adapter: adapter.clone(),
            path,
            float_controls: adapter.float_controls(),
            reported,
            doom: Doom::default(),
            pipelines: BTreeMap::new(),
            is_busy: Cell::new(false),
        })
    }

    /// Adapter that it was opened on.
    pub(super) fn adapter(&self) -> &Adapter {
        &self.adapter
    }

    /// Form of its kernels.
    pub(super) fn path(&self) -> Path {
        self.path
    }

    /// Sets the modes to request from now on.
    pub(super) fn ask_for(&mut self, float_controls: FloatControls) {
        self.float_controls = float_controls;
        self.pipelines.clear();
    }

    /// What makes pipelines of this device, on any thread.
    pub(super) fn maker(&self) -> Maker {
        Maker {
            raw: self.raw.clone(),
            path: self.path,
            float_controls: self.float_controls,
        }
    }

    /// Returns a kernel, which is compiled on first use. Returns soon after a cancellation; the driver then goes on compiling.
    ///
    /// # Errors
    /// [`Fault::Cancelled`], [`Fault::Refused`] if the driver doesn't accept it, [`Fault::Lost`].
    pub(super) fn pipeline(&mut self, kernel: &Kernel, control: &Control) -> Result<Arc<Pipeline>, Fault> {
        let key = (kernel.name, kernel.spirv.as_ptr().addr());
        if let Some(pipeline) = self.pipelines.get(&key) {
            return Ok(Arc::clone(pipeline));
        }
        let (maker, kernel) = (self.maker(), *kernel);
        let made = background::wait(|| control.is_cancelled(), move || maker.pipeline(&kernel, None));
        let pipeline = Arc::new(made.ok_or(Fault::Cancelled)?);
        self.check()?;
        self.pipelines.insert(key, Arc::clone(&pipeline));
        Ok(pipeline)
    }

    /// Submits commands.
    pub(super) fn submit(&mut self, encoder: wgpu::CommandEncoder) -> wgpu::SubmissionIndex {
        let submission = self.queue.submit([encoder.finish()]);
        if self.doom.strikes() {
            self.raw.destroy();
        }
        submission
    }

    /// Waits for a submission. Returns soon after a cancellation; the device then finishes on its own.
    ///
    /// # Errors
    /// [`Fault::Cancelled`], and any fault of the device.
    pub(super) fn wait(&self, submission: &wgpu::SubmissionIndex, control: &Control) -> Result<(), Fault> {
        const LOOK_UP: Duration = Duration::from_millis(20);
        loop {
            let wait = wgpu::PollType::Wait {
                submission_index: Some(submission.clone()),
                timeout: Some(LOOK_UP),
            };
            match self.poll(wait) {
                Err(wgpu::PollError::Timeout) => {}
                // The submission was refused by the queue, which has reported the reason.
                Err(wgpu::PollError::WrongSubmissionIndex(..)) => {
                    self.check()?;
                    return Err(Fault::Lost("it accepts no more work".into()));
                }
                Ok(()) => {
                    // Submissions end in their order.
                    self.is_busy.set(false);
                    return self.check();
                }
            }
            self.check()?;
            if control.is_cancelled() {
                self.is_busy.set(true);
                return Err(Fault::Cancelled);
            }
        }
    }

    /// Checks for faults since the last call.
    ///
    /// # Errors
    /// The fault, if any.
    pub(super) fn check(&self) -> Result<(), Fault> {
        let mut reported = lock(&self.reported);
        if let Some(reason) = &reported.lost {
            return Err(Fault::Lost(reason.clone()));
        }
        let Some(error) = reported.error.take() else {
            return Ok(());
        };
        drop(reported);
        // An error may be the first sign of a lost device, which polling reports.
        let _ = self.poll(wgpu::PollType::Poll);
        if let Some(reason) = &lock(&self.reported).lost {
            return Err(Fault::Lost(reason.clone()));
        }
        Err(match error {
            wgpu::Error::OutOfMemory { .. } => Fault::OutOfMemory,
            wgpu::Error::Validation { description, .. } | wgpu::Error::Internal { description, .. } => {
                Fault::Refused(description)
            }
        })
    }

    /// Polls for finished work, without wgpu's panic when the driver reports that the device is lost.
    fn poll(&self, how: wgpu::PollType) -> Result<(), wgpu::PollError> {
        match catch_unwind(AssertUnwindSafe(|| self.raw.poll(how))) {
            Ok(result) => result.map(|_| ()),
            Err(panic) => {
                let said = panic
                    .downcast_ref::<String>()
                    .map_or("no reason given", |message| message.as_str());
                lock(&self.reported).lost.get_or_insert_with(|| said.to_owned());
                Ok(())
            }
        }
    }
}

impl Drop for Device {
    /// A queue that is dropped waits for its work, in which a software driver may compile for a minute; drivers may destroy no pipeline
    /// meanwhile.
    fn drop(&mut self) {
        if !self.is_busy.get() {
            return;
        }
        let (device, queue, pipelines) = (
            self.raw.clone(),
            self.queue.clone(),
            std::mem::take(&mut self.pipelines),
        );
        let finish = move || {
            // wgpu panics if the driver reports that the device is lost.
            let _ = catch_unwind(AssertUnwindSafe(|| device.poll(wgpu::PollType::wait_indefinitely())));
            drop((pipelines, queue));
        };
        // Without a thread, this one waits.
        if let Ok(thread) = thread::Builder::new().spawn(finish) {
            background::abandon(thread, true);
        }
    }
}

/// When a device is lost on purpose, in tests.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Doom {
    dispatches: u32,
    devices: u32,
    passed: u32,
}

impl Doom {
    /// Loses `devices` devices in succession, each after `dispatches` dispatches.
    pub(super) fn after(dispatches: u32, devices: u32) -> Self {
        Self {
            dispatches,
            devices,
            passed: 0,
        }
    }
    /// The planned loss of the device that replaces this one.
    pub(super) fn next(self) -> Self {
        Self::after(self.dispatches, self.devices.saturating_sub(1))
    }
    /// Whether the dispatch just submitted is the last.
    fn strikes(&mut self) -> bool {
        self.passed = self.passed.saturating_add(1);
        self.devices > 0 && self.passed == self.dispatches
    }
}

fn lock(reported: &Mutex<Reported>) -> std::sync::MutexGuard<'_, Reported> {
    reported.lock().unwrap_or_else(PoisonError::into_inner)
}

fn layout_entry(binding: &Binding) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding: binding.binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer {
            ty: match binding.kind {
                BindingKind::Uniform => wgpu::BufferBindingType::Uniform,
                BindingKind::Read => wgpu::BufferBindingType::Storage { read_only: true },
                BindingKind::ReadWrite => wgpu::BufferBindingType::Storage { read_only: false },
            },
            has_dynamic_offset: false,
            min_binding_size: wgpu::BufferSize::new(u64::from(binding.stride)),
        },
        count: None,
    }
}

#[cfg(test)]
impl Device {
    /// Fails as if the driver had run out of memory.
    pub(super) fn pretend_out_of_memory(&self) {
        let source = Box::new(std::io::Error::from(std::io::ErrorKind::OutOfMemory));
        lock(&self.reported).error = Some(wgpu::Error::OutOfMemory { source });
    }
}
