//! Lists this machine's adapters and their abilities.

use crate::evaluator::Error;

/// The modes of 32-bit floats that a driver offers to kernels (`VK_KHR_shader_float_controls`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FloatControls {
    /// `shaderRoundingModeRTEFloat32`: results are rounded to the nearest, ties to even.
    pub round_to_nearest: bool,
    /// `shaderSignedZeroInfNanPreserveFloat32`.
    pub keep_special: bool,
    /// `shaderDenormPreserveFloat32`: subnormal numbers are not flushed to zero.
    pub keep_subnormal: bool,
}

/// Limits on what an adapter takes in one dispatch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Storage buffers that one kernel may bind.
    pub storage_buffers: u32,
    /// Bytes that one binding may span.
    pub binding_bytes: u64,
    /// Bytes of one buffer.
    pub buffer_bytes: u64,
    /// Workgroups in one dispatch.
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
    /// Its place in [`adapters`], by which it can be named.
    pub fn index(&self) -> usize {
        self.index
    }
    /// Its name, such as `NVIDIA H100` or `llvmpipe (LLVM 15.0.6, 256 bits)`.
    pub fn name(&self) -> &str {
        &self.info.name
    }
    /// Its driver's name and version, such as `llvmpipe, Mesa 22.3.6 (LLVM 15.0.6)`; empty if unknown.
    pub fn driver(&self) -> String {
        [self.info.driver.as_str(), self.info.driver_info.as_str()]
            .into_iter()
            .filter(|part| !part.is_empty())
            .collect::<Vec<_>>()
            .join(", ")
    }
    /// The interface it is reached through: `vulkan`, `metal`, `dx12` or `gl`.
    pub fn backend(&self) -> &'static str {
        self.info.backend.to_str()
    }
    /// Whether it is a program on the CPU that stands in for a GPU.
    pub fn is_software(&self) -> bool {
        const NAMES: [&str; 5] = ["llvmpipe", "lavapipe", "swiftshader", "softpipe", "basic render"];
        let name = self.info.name.to_lowercase();
        self.info.device_type == wgpu::DeviceType::Cpu || NAMES.iter().any(|known| name.contains(known))
    }
    /// Whether it takes SPIR-V. If not, it gets its kernels in WGSL and is never exact.
    pub fn takes_spirv(&self) -> bool {
        self.takes_spirv
    }
    /// The float modes of its driver.
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
        // Every backend lists the feature, but only Vulkan's is about SPIR-V.
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

/// Names an adapter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Choice {
    /// The best real GPU; never a software driver.
    Hardware,
    /// The best adapter, a software driver if there is nothing else.
    Best,
    /// By its index in [`adapters`], or by a part of its name (in any case).
    Named(String),
}

/// All adapters, in the order in which the drivers list them. `WGPU_BACKEND` chooses the interfaces asked
/// (such as `vulkan`); without it, OpenGL is asked only if there is nothing else, since its libraries are slow to
/// start and talk on standard error where there is no display.
pub fn adapters() -> Vec<Adapter> {
    let found = adapters_of(wgpu::Backends::PRIMARY);
    if found.is_empty() {
        adapters_of(wgpu::Backends::all())
    } else {
        found
    }
}

/// The adapters of these interfaces, or of those that `WGPU_BACKEND` names.
fn adapters_of(backends: wgpu::Backends) -> Vec<Adapter> {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle_from_env();
    // Kernels are never dispatched indirectly, and the check's own kernels would cost start-up time.
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

/// Finds the adapter that is named.
///
/// # Errors
/// [`Error::NoDevice`], with what there is instead, or what to install.
pub fn find(choice: &Choice) -> Result<Adapter, Error> {
    let mut all = adapters();
    all.sort_by_key(Adapter::rank);
    if all.is_empty() {
        let limited = std::env::var("WGPU_BACKEND").map(|backend| format!(" for WGPU_BACKEND={backend}"));
        return Err(Error::NoDevice(format!(
            "no GPU driver was found{}; install your card's Vulkan driver, or a software one (Debian and Ubuntu: \
             mesa-vulkan-drivers)",
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

/// The modes of 32-bit floats that a Vulkan driver offers. wgpu doesn't expose them.
#[cfg(any(windows, target_os = "linux", target_os = "android", target_os = "freebsd"))]
fn ask_vulkan(handle: &wgpu::Adapter) -> FloatControls {
    use ash::vk;
    // SAFETY: nothing is destroyed through the guard.
    let Some(adapter) = (unsafe { handle.as_hal::<wgpu::hal::api::Vulkan>() }) else {
        return FloatControls::default();
    };
    // Before Vulkan 1.2 the modes are an extension, which wgpu doesn't enable.
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

/// There is no Vulkan here.
#[cfg(not(any(windows, target_os = "linux", target_os = "android", target_os = "freebsd")))]
fn ask_vulkan(_: &wgpu::Adapter) -> FloatControls {
    FloatControls::default()
}
