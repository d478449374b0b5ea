//! Mesa's drivers as compilers: devices that are not there, and what the drivers make of a kernel for them.

use std::collections::BTreeMap;
use std::ffi::CStr;

use ash::vk;
use oneiro_shaders::{BindingKind, Kernel};

/// A kernel's machine code for one family.
pub(crate) struct Compiled {
    statistics: BTreeMap<String, u64>,
    /// Lanes that run in step.
    pub(crate) lanes: u32,
    pub(crate) text: String,
}

impl Compiled {
    /// A number that the driver gives by this name.
    pub(crate) fn statistic(&self, name: &str) -> u64 {
        let found = self.statistics.get(name).copied();
        found.unwrap_or_else(|| panic!("no {name} among {:?}", self.statistics))
    }
}

/// A card that is not there.
pub(crate) struct NullDevice {
    _entry: ash::Entry,
    instance: ash::Instance,
    device: ash::Device,
    executables: ash::khr::pipeline_executable_properties::Device,
    pub(crate) driver: String,
}

impl NullDevice {
    pub(crate) fn open() -> Result<Self, String> {
        let said = |error: vk::Result| error.to_string();
        // SAFETY: the loader is the system's.
        let entry = unsafe { ash::Entry::load() }.map_err(|error| error.to_string())?;
        let version = vk::ApplicationInfo::default().api_version(vk::API_VERSION_1_2);
        let create = vk::InstanceCreateInfo::default().application_info(&version);
        // SAFETY: what is created from it is gone before it.
        let instance = unsafe { entry.create_instance(&create, None) }.map_err(said)?;
        // SAFETY: the instance is alive.
        let found = unsafe { instance.enumerate_physical_devices() }.map_err(said)?;
        let physical = *found.first().ok_or("the driver lists no device")?;
        let mut driver = vk::PhysicalDeviceDriverProperties::default();
        let mut properties = vk::PhysicalDeviceProperties2::default().push_next(&mut driver);
        // SAFETY: the instance is alive.
        unsafe { instance.get_physical_device_properties2(physical, &mut properties) };
        let queue = [vk::DeviceQueueCreateInfo::default().queue_priorities(&[1.0])];
        let extensions = [vk::KHR_PIPELINE_EXECUTABLE_PROPERTIES_NAME.as_ptr()];
        let mut features =
            vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR::default().pipeline_executable_info(true);
        let create = vk::DeviceCreateInfo::default()
            .queue_create_infos(&queue)
            .enabled_extension_names(&extensions)
            .push_next(&mut features);
        // SAFETY: the instance is alive.
        let device = unsafe { instance.create_device(physical, &create, None) }.map_err(said)?;
        Ok(Self {
            executables: ash::khr::pipeline_executable_properties::Device::new(&instance, &device),
            driver: text(&driver.driver_info),
            _entry: entry,
            instance,
            device,
        })
    }

    /// Compiles SPIR-V of a kernel.
    pub(crate) fn compile(&self, kernel: &Kernel, spirv: &[u32]) -> Result<Compiled, vk::Result> {
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
            let lanes = self.lanes(pipeline)?;
            let statistics = self.executables.get_pipeline_executable_statistics(&info)?;
            let statistics = statistics.iter().map(|one| (text(&one.name), one.value.u64)).collect();
            let code = self.assembly(&info)?;
            device.destroy_pipeline(pipeline, None);
            device.destroy_shader_module(module, None);
            device.destroy_pipeline_layout(layout, None);
            device.destroy_descriptor_set_layout(sets[0], None);
            Ok(Compiled {
                statistics,
                lanes,
                text: code,
            })
        }
    }

    /// The lanes of the one program that a pipeline has: all of its machine code is looked at.
    unsafe fn lanes(&self, pipeline: vk::Pipeline) -> Result<u32, vk::Result> {
        let get = self.executables.fp().get_pipeline_executable_properties_khr;
        let info = vk::PipelineInfoKHR::default().pipeline(pipeline);
        let mut count = 0;
        let mut only = vk::PipelineExecutablePropertiesKHR::default();
        // SAFETY: asks for their number, then for one, into what has room for one.
        unsafe {
            get(
                self.device.handle(),
                &raw const info,
                &raw mut count,
                std::ptr::null_mut(),
            )
            .result()?;
            assert_eq!(count, 1, "programs of a pipeline");
            get(self.device.handle(), &raw const info, &raw mut count, &raw mut only).result()?;
        }
        Ok(only.subgroup_size)
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

impl Drop for NullDevice {
    fn drop(&mut self) {
        // SAFETY: nothing that was made from them is left.
        unsafe {
            self.device.destroy_device(None);
            self.instance.destroy_instance(None);
        }
    }
}

fn text(chars: &[std::ffi::c_char]) -> String {
    let bytes: Vec<u8> = chars.iter().map(|byte| *byte as u8).collect();
    CStr::from_bytes_until_nul(&bytes).map_or_else(|_| String::new(), |text| text.to_string_lossy().into_owned())
}
