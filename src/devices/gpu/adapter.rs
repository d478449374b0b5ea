//! This machine's adapters and their capabilities.

use crate::evaluator::Error;

/// Modes of 32-bit floats that a driver offers to kernels (`VK_KHR_shader_float_controls`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FloatControls {
    /// `shaderRoundingModeRTEFloat32`: results are rounded to nearest, ties to even.
    pub round_to_nearest: bool,
    /// `shaderSignedZeroInfNanPreserveFloat32`.
    pub keep_special: bool,
    /// `shaderDenormPreserveFloat32`: subnormal numbers are not flushed to zero.
    pub keep_subnormal: bool,
}

/// Limits of an adapter on one dispatch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Storage buffers per kernel.
    pub storage_buffers: u32,
    /// Bytes per binding.
    pub binding_bytes: u64,
    /// Bytes per buffer.
    pub buffer_bytes: u64,
    /// Workgroups per dispatch.
    pub workgroups: u32,
}

/// A device that a driver offers.
#[derive(Clone, Debug)]
pub struct Adapter {
    index: usize,
    info: wgpu::AdapterInfo,
    limits: Limits,
    takes_spirv: bool,
    float_controls: FloatControls,
    pub(super) handle: wgpu::Adapter,
}

impl Adapter {
    /// Index in [`adapters`], by which it can be named.
    pub fn index(&self) -> usize {
        self.index
    }
    /// Name, such as `NVIDIA H100` or `llvmpipe (LLVM 15.0.6, 256 bits)`.
    pub fn name(&self) -> &str {
        &self.info.name
    }
    /// Name and version of the driver, such as `llvmpipe, Mesa 22.3.6 (LLVM 15.0.6)`; empty if unknown.
    pub fn driver(&self) -> String {
        [self.info.driver.as_str(), self.info.driver_info.as_str()]
            .into_iter()
            .filter(|part| !part.is_empty())
            .collect::<Vec<_>>()
            .join(", ")
    }
    /// Interface of the adapter: `vulkan`, `metal`, `dx12` or `gl`.
    pub fn backend(&self) -> &'static str {
        self.info.backend.to_str()
    }
    /// Whether it is software that emulates a GPU on the CPU.
    pub fn is_software(&self) -> bool {
        const NAMES: [&str; 5] = ["llvmpipe", "lavapipe", "swiftshader", "softpipe", "basic render"];
        let name = self.info.name.to_lowercase();
        self.info.device_type == wgpu::DeviceType::Cpu || NAMES.iter().any(|known| name.contains(known))
    }
    /// Whether it accepts SPIR-V. If not, it gets its kernels in WGSL and is never exact.
    pub fn takes_spirv(&self) -> bool {
        self.takes_spirv
    }
    /// Float modes of its driver.
    pub fn float_controls(&self) -> FloatControls {
        self.float_controls
    }
    /// Limits on its dispatches.
    pub fn limits(&self) -> Limits {
        self.limits
    }

    fn new(index: usize, handle: wgpu::Adapter) -> Self {
        let limits = handle.limits();
        let info = handle.get_info();
        // All backends report the feature, but only Vulkan's is about SPIR-V.
        let takes_spirv =
            info.backend == wgpu::Backend::Vulkan && handle.features().contains(wgpu::Features::PASSTHROUGH_SHADERS);
        Self {
            index,
            limits: Limits {
                storage_buffers: limits.max_storage_buffers_per_shader_stage,
                binding_bytes: limits.max_storage_buffer_binding_size,
                buffer_bytes: limits.max_buffer_size,
                workgroups: limits.max_compute_workgroups_per_dimension,
            },
            takes_spirv,
            float_controls: if takes_spirv {
                ask_vulkan(&handle)
            } else {
                FloatControls::default()
            },
            info,
            handle,
        }
    }

    /// Lower is better: hardware before software, exact before inexact, the faster kind of device first.
    fn rank(&self) -> (bool, bool, u8, usize) {
        let kind = match self.info.device_type {
            wgpu::DeviceType::DiscreteGpu => 0,
            wgpu::DeviceType::IntegratedGpu => 1,
            wgpu::DeviceType::VirtualGpu => 2,
            wgpu::DeviceType::Other | wgpu::DeviceType::Cpu => 3,
        };
        (self.is_software(), !self.takes_spirv, kind, self.index)
    }
}

/// Selects an adapter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Choice {
    /// The best real GPU; never a software driver.
    Hardware,
    /// The best adapter; a software driver if there is nothing else.
    Best,
    /// By its index in [`adapters`], or by a part of its name (ignoring case).
    Named(String),
}

/// All adapters, in the order in which the drivers list them. `WGPU_BACKEND` selects the interfaces to try (such as
/// `vulkan`). By default OpenGL is tried only if there is nothing else, since its libraries start slowly and print to
/// standard error if there is no display.
pub fn adapters() -> Vec<Adapter> {
    let found = adapters_of(wgpu::Backends::PRIMARY);
    if found.is_empty() {
        adapters_of(wgpu::Backends::all())
    } else {
        found
    }
}

/// Whether this process may have as much memory as drivers need. A Vulkan loader that gets too little never comes back: it fails
/// with its lock taken, which it waits for when it is unloaded. Mesa's software driver has memory in files, and crashes where these may not
/// be as large.
fn drivers_have_room() -> bool {
    #[cfg(unix)]
    {
        use rustix::process::{Resource, getrlimit};
        let is_enough = |of| getrlimit(of).current.is_none_or(|bytes| bytes >= LEAST_ROOM);
        is_enough(Resource::As) && is_enough(Resource::Fsize)
    }
    #[cfg(not(unix))]
    true
}

/// Drivers are loaded if a process may have at least this much memory (`ulimit -v`) and files as large (`ulimit -f`), bytes.
const LEAST_ROOM: u64 = 2 << 30;

/// Adapters of these interfaces, or of those that `WGPU_BACKEND` names.
fn adapters_of(backends: wgpu::Backends) -> Vec<Adapter> {
    if !drivers_have_room() {
        return Vec::new();
    }
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle_from_env();
    // Kernels are never dispatched indirectly, and compiling the check's own kernels would slow the start.
    descriptor.flags.remove(wgpu::InstanceFlags::VALIDATION_INDIRECT_CALL);
    descriptor.backends = wgpu::Backends::from_env().unwrap_or(backends);
    let instance = wgpu::Instance::new(descriptor);
    let handles = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all()));
    handles
        .into_iter()
        .enumerate()
        .map(|(index, handle)| Adapter::new(index, handle))
        .collect()
}

/// Finds an adapter.
///
/// # Errors
/// [`Error::NoDevice`], with the adapters that there are, or with what to install.
pub fn find(choice: &Choice) -> Result<Adapter, Error> {
    let mut all = adapters();
    all.sort_by_key(Adapter::rank);
    if all.is_empty() {
        let limited = std::env::var("WGPU_BACKEND").map(|backend| format!(" for WGPU_BACKEND={backend}"));
        return Err(Error::NoDevice(format!(
            "no GPU driver was found{}, or this program may have less than 2 GiB of memory or in a file (ulimit -v, -f); install your card's Vulkan driver, or a software one (Debian and \
             Ubuntu: mesa-vulkan-drivers)",
            limited.unwrap_or_default()
        )));
    }
    let is_meant = |adapter: &Adapter| match choice {
        Choice::Hardware => !adapter.is_software(),
        Choice::Best => true,
        Choice::Named(name) => match name.parse::<usize>() {
            Ok(index) => adapter.index == index,
            Err(_) => adapter.name().to_lowercase().contains(&name.to_lowercase()),
        },
    };
    if let Some(found) = all.iter().position(is_meant) {
        return Ok(all.swap_remove(found));
    }
    all.sort_by_key(Adapter::index);
    let list: Vec<_> = all
        .iter()
        .map(|a| format!("{}: {} ({})", a.index, a.name(), a.backend()))
        .collect();
    let problem = match choice {
        Choice::Named(name) => format!("no adapter has the index or a name with `{name}`"),
        Choice::Hardware | Choice::Best => "there is no real GPU here".into(),
    };
    Err(Error::NoDevice(format!("{problem}; there are: {}", list.join("; "))))
}

/// Modes of 32-bit floats that a Vulkan driver offers, which wgpu doesn't expose.
#[cfg(any(windows, target_os = "linux", target_os = "android", target_os = "freebsd"))]
fn ask_vulkan(handle: &wgpu::Adapter) -> FloatControls {
    use ash::vk;
    // SAFETY: nothing is destroyed through the guard.
    let Some(adapter) = (unsafe { handle.as_hal::<wgpu::hal::api::Vulkan>() }) else {
        return FloatControls::default();
    };
    // Before Vulkan 1.2 the modes require an extension, which wgpu doesn't enable.
    if adapter.physical_device_capabilities().properties().api_version < vk::API_VERSION_1_2 {
        return FloatControls::default();
    }
    let mut controls = vk::PhysicalDeviceFloatControlsProperties::default();
    let mut properties = vk::PhysicalDeviceProperties2::default().push_next(&mut controls);
    // SAFETY: the physical device is the instance's, and both structs are valid for writes.
    unsafe {
        adapter
            .shared_instance()
            .raw_instance()
            .get_physical_device_properties2(adapter.raw_physical_device(), &mut properties);
    }
    FloatControls {
        round_to_nearest: controls.shader_rounding_mode_rte_float32 == vk::TRUE,
        keep_special: controls.shader_signed_zero_inf_nan_preserve_float32 == vk::TRUE,
        keep_subnormal: controls.shader_denorm_preserve_float32 == vk::TRUE,
    }
}

/// Without Vulkan there are none.
#[cfg(not(any(windows, target_os = "linux", target_os = "android", target_os = "freebsd")))]
fn ask_vulkan(_: &wgpu::Adapter) -> FloatControls {
    FloatControls::default()
}
