//! Vulkan drivers as compilers: their machine code of a kernel, where they show it. Nothing runs, so no card is needed.

use std::ffi::CStr;
use std::fmt;

use ash::vk;
use oneiro_shaders::{BindingKind, Kernel};

use super::adapter::Adapter;

/// What a driver made of a kernel.
#[derive(Clone, Debug)]
pub struct Compiled {
    /// Numbers such as registers, by the driver's own names.
    pub statistics: Vec<(String, u64)>,
    /// Number of its programs. The other fields are the first one's.
    pub programs: u32,
    /// Lanes that run in step.
    pub lanes: u32,
    /// Machine code; empty if the driver doesn't show it.
    pub text: String,
}

impl Compiled {
    /// A number that the driver gives by this name.
    pub fn statistic(&self, name: &str) -> Option<u64> {
        self.statistics
            .iter()
            .find(|(known, _)| known == name)
            .map(|(_, value)| *value)
    }
}

/// A driver's compiler for one device.
pub struct Compiler {
    _entry: ash::Entry,
    instance: ash::Instance,
    device: ash::Device,
    executables: ash::khr::pipeline_executable_properties::Device,
    driver: String,
}

impl fmt::Debug for Compiler {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Compiler")
            .field("driver", &self.driver)
            .finish_non_exhaustive()
    }
}

impl Compiler {
    /// The compiler of the first device that the drivers list.
    ///
    /// # Errors
    /// There is none, or its driver doesn't tell what it makes.
    pub fn first() -> Result<Self, String> {
        Self::open(|_| true)
    }

    /// The compiler of an adapter.
    ///
    /// # Errors
    /// It is none of Vulkan's, or its driver doesn't tell what it makes.
    pub fn of(adapter: &Adapter) -> Result<Self, String> {
        Self::open(|properties| {
            let name = properties.device_name_as_c_str().unwrap_or_default().to_string_lossy();
            adapter.backend() == "vulkan" && name == adapter.name()
        })
    }

    /// Version of the driver, as it says.
    pub fn driver(&self) -> &str {
        &self.driver
    }

    fn open(is_meant: impl Fn(&vk::PhysicalDeviceProperties) -> bool) -> Result<Self, String> {
        let said = |error: vk::Result| error.to_string();
        // SAFETY: the loader is the system's.
        let entry = unsafe { ash::Entry::load() }.map_err(|error| error.to_string())?;
        let version = vk::ApplicationInfo::default().api_version(vk::API_VERSION_1_2);
        let create = vk::InstanceCreateInfo::default().application_info(&version);
        // SAFETY: everything created from it is dropped before it.
        let instance = unsafe { entry.create_instance(&create, None) }.map_err(said)?;
        let opened = Self::device(&instance, is_meant);
        let (device, driver) = opened.inspect_err(|_| {
            // SAFETY: nothing was made from it.
            unsafe { instance.destroy_instance(None) };
        })?;
        Ok(Self {
            executables: ash::khr::pipeline_executable_properties::Device::new(&instance, &device),
            driver,
            _entry: entry,
            instance,
            device,
        })
    }

    /// The chosen device, and its driver's version.
    fn device(
        instance: &ash::Instance,
        is_meant: impl Fn(&vk::PhysicalDeviceProperties) -> bool,
    ) -> Result<(ash::Device, String), String> {
        let said = |error: vk::Result| error.to_string();
        let name = vk::KHR_PIPELINE_EXECUTABLE_PROPERTIES_NAME;
        let extensions = [name.as_ptr()];
        // SAFETY: the instance is alive, and all pointers in its structs are valid.
        unsafe {
            let found = instance.enumerate_physical_devices().map_err(said)?;
            let physical = found
                .into_iter()
                .find(|device| is_meant(&instance.get_physical_device_properties(*device)))
                .ok_or("Vulkan's drivers list no such device")?;
            let offered = instance.enumerate_device_extension_properties(physical).map_err(said)?;
            if !offered
                .iter()
                .any(|extension| extension.extension_name_as_c_str() == Ok(name))
            {
                return Err(format!("its driver does not report it ({})", name.to_string_lossy()));
            }
            let mut driver = vk::PhysicalDeviceDriverProperties::default();
            let mut properties = vk::PhysicalDeviceProperties2::default().push_next(&mut driver);
            instance.get_physical_device_properties2(physical, &mut properties);
            let queue = [vk::DeviceQueueCreateInfo::default().queue_priorities(&[1.0])];
            let mut features =
                vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR::default().pipeline_executable_info(true);
            let create = vk::DeviceCreateInfo::default()
                .queue_create_infos(&queue)
                .enabled_extension_names(&extensions)
                .push_next(&mut features);
            let device = instance.create_device(physical, &create, None).map_err(said)?;
            Ok((device, text(&driver.driver_info)))
        }
    }

    /// Compiles SPIR-V of a kernel.
    ///
    /// # Errors
    /// The driver's statistics.
    pub fn compile(&self, kernel: &Kernel, spirv: &[u32]) -> Result<Compiled, vk::Result> {
        let of = |binding: &oneiro_shaders::Binding| {
            vk::DescriptorSetLayoutBinding::default()
                .binding(binding.binding)
                .descriptor_count(1)
                .stage_flags(vk::ShaderStageFlags::COMPUTE)
                .descriptor_type(match binding.kind {
                    BindingKind::Uniform => vk::DescriptorType::UNIFORM_BUFFER,
                    _ => vk::DescriptorType::STORAGE_BUFFER,
                })
        };
        let bindings: Vec<_> = kernel.bindings.iter().map(of).collect();
        let device = &self.device;
        // SAFETY: every object is created from this device, used before it is destroyed, and destroyed once.
        unsafe {
            let set = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
            let sets = [device.create_descriptor_set_layout(&set, None)?];
            let layout = vk::PipelineLayoutCreateInfo::default().set_layouts(&sets);
            let layout = device.create_pipeline_layout(&layout, None)?;
            let module = device.create_shader_module(&vk::ShaderModuleCreateInfo::default().code(spirv), None)?;
            let stage = vk::PipelineShaderStageCreateInfo::default()
                .stage(vk::ShaderStageFlags::COMPUTE)
                .module(module)
                .name(c"main");
            let flags = vk::PipelineCreateFlags::CAPTURE_STATISTICS_KHR
                | vk::PipelineCreateFlags::CAPTURE_INTERNAL_REPRESENTATIONS_KHR;
            let create = vk::ComputePipelineCreateInfo::default()
                .flags(flags)
                .stage(stage)
                .layout(layout);
            let made = device.create_compute_pipelines(vk::PipelineCache::null(), &[create], None);
            let pipeline = made.map_err(|(_, error)| error)?[0];
            let info = vk::PipelineExecutableInfoKHR::default().pipeline(pipeline);
            let (programs, lanes) = self.programs(pipeline)?;
            let statistics = self.executables.get_pipeline_executable_statistics(&info)?;
            let statistics = statistics.iter().map(|one| (text(&one.name), number(one))).collect();
            let code = self.assembly(&info)?;
            device.destroy_pipeline(pipeline, None);
            device.destroy_shader_module(module, None);
            device.destroy_pipeline_layout(layout, None);
            device.destroy_descriptor_set_layout(sets[0], None);
            Ok(Compiled {
                statistics,
                programs,
                lanes,
                text: code,
            })
        }
    }

    /// The number of programs that a pipeline consists of, and the lanes of the first.
    unsafe fn programs(&self, pipeline: vk::Pipeline) -> Result<(u32, u32), vk::Result> {
        let info = vk::PipelineInfoKHR::default().pipeline(pipeline);
        // SAFETY: the pipeline was made with what this needs.
        let all = unsafe { self.executables.get_pipeline_executable_properties(&info) }?;
        Ok((all.len() as u32, all.first().map_or(0, |program| program.subgroup_size)))
    }

    /// The last of the compiler's representations, which is the machine code.
    unsafe fn assembly(&self, info: &vk::PipelineExecutableInfoKHR<'_>) -> Result<String, vk::Result> {
        let get = self
            .executables
            .fp()
            .get_pipeline_executable_internal_representations_khr;
        let mut count = 0;
        // SAFETY: asks for their number, then for their sizes, then for their texts, into what has room for that.
        unsafe {
            get(self.device.handle(), info, &raw mut count, std::ptr::null_mut()).result()?;
            let mut all = vec![vk::PipelineExecutableInternalRepresentationKHR::default(); count as usize];
            get(self.device.handle(), info, &raw mut count, all.as_mut_ptr()).result()?;
            let mut texts: Vec<Vec<u8>> = all.iter().map(|one| vec![0; one.data_size]).collect();
            for (one, text) in all.iter_mut().zip(&mut texts) {
                one.p_data = text.as_mut_ptr().cast();
            }
            get(self.device.handle(), info, &raw mut count, all.as_mut_ptr()).result()?;
            let last = texts.pop().unwrap_or_default();
            Ok(String::from_utf8_lossy(&last).trim_end_matches('\0').to_owned())
        }
    }
}

impl Drop for Compiler {
    fn drop(&mut self) {
        // SAFETY: everything made from them is dropped.
        unsafe {
            self.device.destroy_device(None);
            self.instance.destroy_instance(None);
        }
    }
}

fn number(one: &vk::PipelineExecutableStatisticKHR<'_>) -> u64 {
    // SAFETY: the format tells which field is set.
    unsafe {
        match one.format {
            vk::PipelineExecutableStatisticFormatKHR::FLOAT64 => one.value.f64 as u64,
            vk::PipelineExecutableStatisticFormatKHR::BOOL32 => one.value.b32.into(),
            _ => one.value.u64,
        }
    }
}

fn text(chars: &[std::ffi::c_char]) -> String {
    let bytes: Vec<u8> = chars.iter().map(|byte| *byte as u8).collect();
    CStr::from_bytes_until_nul(&bytes).map_or_else(|_| String::new(), |text| text.to_string_lossy().into_owned())
}
