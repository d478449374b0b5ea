//! What a real GPU's compiler makes of the kernels, without a card: Mesa's driver compiles them for cards of AMD that are not there. Its
//! machine code is read: nothing that rounds in another way is in it. That of one family is run as well: it gives the processor's bits,
//! and what a cycle issues is pinned.
//!
//! Kernels whose `NoContraction` was taken away show that both would notice fused operations.
#![cfg(all(feature = "gpu", feature = "compose", target_os = "linux"))]

use std::collections::BTreeMap;
use std::env;
use std::ffi::CStr;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;

use ash::vk;
use oneiro::batch::{Batch, Rollout, Worlds};
use oneiro::cpu::Cpu;
use oneiro::evaluator::{Control, Evaluator};
use oneiro::foraging::{Foraging, Light};
use oneiro::random::{Key, pcg4d};
use oneiro::surrogate::{Differences, Surrogate};
use oneiro::swarm::{Lamp, Order, Swarm};
use oneiro::world::{Noise, World, WorldSpec};
use oneiro_shader_compiler::spirv;
use oneiro_shaders::{BindingKind, KERNELS, Kernel};

mod pinned;
#[path = "machine_code/rdna.rs"]
mod rdna;
mod skips;

use pinned::Rows;
use rdna::{Code, Issued};

/// Families of cards: GCN, RDNA 1, 2 and 3.
const FAMILIES: [&str; 4] = ["polaris10", "navi10", "navi21", "gfx1100"];
/// Names the family for a process of its own: the driver asks once.
const FAMILY: &str = "ONEIRO_FAMILY";

/// A kernel's machine code for one family.
struct Compiled {
    statistics: BTreeMap<String, u64>,
    text: String,
}

/// Adapters of cards that are not there.
struct NullDevice {
    _entry: ash::Entry,
    instance: ash::Instance,
    device: ash::Device,
    executables: ash::khr::pipeline_executable_properties::Device,
    driver: String,
}

impl NullDevice {
    fn open() -> Result<Self, String> {
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
    fn compile(&self, kernel: &Kernel, spirv: &[u32]) -> Result<Compiled, vk::Result> {
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
            let statistics = self.executables.get_pipeline_executable_statistics(&info)?;
            let statistics = statistics.iter().map(|one| (text(&one.name), one.value.u64)).collect();
            let code = self.assembly(&info)?;
            device.destroy_pipeline(pipeline, None);
            device.destroy_shader_module(module, None);
            device.destroy_pipeline_layout(layout, None);
            device.destroy_descriptor_set_layout(sets[0], None);
            Ok(Compiled { statistics, text: code })
        }
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

/// Rollouts of a group.
const GROUP: u64 = 64;
/// Cycles of which costs are counted, after those at the beginning of a life that are left out.
const COUNTED: u32 = 32;
const LEFT_OUT: u32 = 8;

/// Lives of a group in worlds to which kernels are specialised, by name.
fn batches() -> Vec<(&'static str, Batch)> {
    let world = |change: fn(&mut WorldSpec)| {
        let mut spec = WorldSpec::miglino1995();
        spec.cycles = LEFT_OUT + COUNTED;
        change(&mut spec);
        let world = World::new(spec).unwrap();
        let genes = world.genes();
        batch(Worlds::new(&[world]).unwrap(), |index| genome(genes, index))
    };
    let forager = Foraging {
        cycles: LEFT_OUT + COUNTED,
        ..Foraging::odowd2014(Light::OverNest)
    };
    let foragers = Worlds::new(&[forager]).unwrap();
    let swarm = Swarm {
        forager,
        ..Swarm::odowd2014(10)
    };
    let lamp = Lamp::fixed(Light::OverNest);
    let swarms = Worlds::new(&[swarm]).unwrap();
    vec![
        ("no noise", world(|_| ())),
        ("sensor noise", world(|spec| spec.noise = Noise::SENSOR)),
        (
            "all noise",
            world(|spec| {
                spec.noise = Noise {
                    motor: 0.1,
                    ..Noise::CONSERVATIVE
                };
            }),
        ),
        (
            "surrogate",
            world(|spec| spec.surrogate = Some(Arc::new(Surrogate::drawn(1, Differences::all(0.5))))),
        ),
        (
            "over nest",
            batch(foragers, |index| {
                genome(2, index).iter().map(|gene| gene.abs()).collect()
            }),
        ),
        (
            "ten robots",
            batch(swarms, |index| {
                let order = |robot| {
                    let genes = genome(2, 10 * index + robot);
                    Order::always([genes[0].abs(), genes[1].abs()])
                };
                swarm.inputs(&lamp, &(0..10).map(order).collect::<Vec<_>>())
            }),
        ),
    ]
}

/// Genes from -1 to 1.
fn genome(genes: usize, index: u64) -> Vec<f32> {
    let words = (0..genes as u32)
        .step_by(4)
        .flat_map(|block| pcg4d([index as u32, block, 0, 0]));
    words
        .map(|word| (word >> 8) as f32 / 8_388_608.0 - 1.0)
        .take(genes)
        .collect()
}

fn batch(worlds: Worlds, genes: impl Fn(u64) -> Vec<f32>) -> Batch {
    let genes: Vec<Vec<f32>> = (0..GROUP).map(genes).collect();
    let rollouts: Vec<_> = (0..)
        .zip(&genes)
        .map(|(index, genes)| Rollout {
            world: 0,
            genes,
            key: Key::rollout(0, 0, index, 0),
        })
        .collect();
    worlds.stretch(&rollouts, 0..LEFT_OUT + COUNTED, &[], None).unwrap()
}

/// Lets a group live by machine code up to some cycle. Returns its buffers and what was issued.
fn lived(batch: &Batch, code: &Code, end: u32) -> ([Vec<u32>; 9], Issued) {
    let mut buffers = oneiro::gpu::buffers(&batch.all(), end);
    let issued = code.run(&mut buffers, 0);
    (buffers, issued)
}

/// Whether machine code gives a group the processor's bits: its fitness, and all that it keeps.
fn is_exact(batch: &Batch, code: &Code) -> bool {
    let (buffers, _) = lived(batch, code, LEFT_OUT + COUNTED);
    let mut cpu = Cpu::new(Some(1)).unwrap();
    let expected = cpu.evaluate_part(&batch.all(), &Control::new()).unwrap();
    let bits: Vec<u32> = expected.fitness.iter().map(|fitness| fitness.to_bits()).collect();
    buffers[7] == bits && buffers[6] == expected.states
}

/// What a cycle of a group issues.
fn cost(batch: &Batch, code: &Code) -> String {
    let [all, first] = [LEFT_OUT + COUNTED, LEFT_OUT].map(|end| lived(batch, code, end).1);
    let a_cycle = |figure: fn(Issued) -> u64| (figure(all) - figure(first)) as f64 / f64::from(COUNTED);
    format!(
        "{:.0} issued a cycle, of them {:.0} vector, {:.0} memory, {:.0} products",
        a_cycle(Issued::all),
        a_cycle(|issued| issued.vector),
        a_cycle(|issued| issued.memory),
        a_cycle(|issued| issued.products),
    )
}

/// Every kernel, generic and specialised: its name, itself, and SPIR-V.
fn variants() -> Vec<(String, &'static Kernel, Vec<u32>)> {
    let generic = KERNELS
        .iter()
        .map(|kernel| (kernel.name.to_owned(), *kernel, kernel.spirv.to_vec()));
    let specialised = batches().into_iter().map(|(name, batch)| {
        let spirv = oneiro::gpu::specialised(&batch.all(), 0).unwrap();
        (format!("{}, {name}", batch.kernel().name), batch.kernel(), spirv)
    });
    generic.chain(specialised).collect()
}

/// Powers of two that instructions have as constants: a product with one of them is exact, however it is rounded.
const POWERS: [&str; 8] = ["-4.0", "-2.0", "-1.0", "-0.5", "0.5", "1.0", "2.0", "4.0"];

/// Whether a reciprocal is the estimate that an integer division begins with, which is corrected: of a whole number, and scaled to one.
fn divides_integers(lines: &[(&str, &str)], at: usize) -> bool {
    /// A little less than 2^32, as a float.
    const SCALE: &str = "0x4f7ffffe";
    let mut operands = lines[at].1.split(',').map(str::trim);
    let (Some(result), Some(operand)) = (operands.next(), operands.next()) else {
        return false;
    };
    let sets = |line: &&(&str, &str), register: &str| line.1.split(',').next().map(str::trim) == Some(register);
    let made = lines[..at].iter().rev().find(|line| sets(line, operand));
    let used = lines[at + 1..]
        .iter()
        .find(|line| line.1.split(',').skip(1).any(|own| own.trim() == result));
    made.is_some_and(|line| line.0.starts_with("v_cvt_f32_u32"))
        && used.is_some_and(|line| line.0.starts_with("v_mul_f32") && line.1.contains(SCALE))
}

/// Instructions that may give other bits than IEEE's operations one by one.
fn inexact(code: &str) -> Vec<String> {
    let is_fused = |name: &str| {
        ["v_fma", "v_fmac", "v_pk_fma", "v_dot", "v_mad_mix"]
            .iter()
            .any(|own| name.starts_with(own))
    };
    let native = ["v_rcp", "v_rsq", "v_sqrt", "v_exp", "v_log", "v_sin", "v_cos", "v_div"];
    let lines: Vec<(&str, &str)> = code
        .lines()
        .map(|line| line.split(';').next().unwrap_or_default().trim())
        .map(|line| line.split_once(' ').unwrap_or((line, "")))
        .collect();
    let is_inexact = |at: &usize| {
        let (name, operands) = lines[*at];
        if native.iter().any(|own| name.starts_with(own)) {
            return !divides_integers(&lines, *at);
        }
        let mut factors = operands.split(',').skip(1).take(2).map(str::trim);
        is_fused(name) && !factors.any(|factor| POWERS.contains(&factor))
    };
    let found = (0..lines.len()).filter(is_inexact);
    found.map(|at| format!("{} {}", lines[at].0, lines[at].1)).collect()
}

/// SPIR-V without its `NoContraction`.
fn contractible(words: &[u32]) -> Vec<u32> {
    let all: Vec<usize> = (0..spirv::float_arithmetic(words).len()).collect();
    spirv::without_contraction(words, &all)
}

/// Compiles everything for the family that the environment names, and prints a row for each: a process of the test below.
#[test]
#[ignore = "a process of the test below"]
fn of_family() {
    let Ok(family) = env::var(FAMILY) else { return };
    let device = NullDevice::open().unwrap();
    println!("\ndriver {}", device.driver);
    for (name, kernel, spirv) in variants() {
        let compiled = device.compile(kernel, &spirv).unwrap();
        let found = inexact(&compiled.text);
        assert!(found.is_empty(), "{family}: {name}: {found:#?}");
        assert!(compiled.text.lines().count() > 100, "{name}: {}", compiled.text);
        if let Some(folder) = env::var_os("ONEIRO_MACHINE_CODE") {
            let name = name.replace(", ", "-").replace(' ', "-");
            std::fs::write(Path::new(&folder).join(format!("{family}-{name}.s")), &compiled.text).unwrap();
        }
        let of = |name: &str| compiled.statistics.get(name).copied().unwrap_or_default();
        println!(
            "row {name} | {} instructions, {} bytes, {} VGPRs, {} SGPRs, {} spilled, {} waves, throughput {}",
            of("Instructions"),
            of("Code size"),
            of("VGPRs"),
            of("SGPRs"),
            of("Spilled VGPRs") + of("Spilled SGPRs"),
            of("Subgroups per SIMD"),
            of("Inverse Throughput"),
        );
    }
    if family == "navi21" {
        for (name, batch) in batches() {
            let kernel = batch.kernel();
            let own = oneiro::gpu::specialised(&batch.all(), 0).unwrap();
            for (kind, spirv) in [("any world", kernel.spirv), ("this world", &own)] {
                let code = Code::new(&device.compile(kernel, spirv).unwrap().text);
                assert!(is_exact(&batch, &code), "{}, {name}, {kind}: other bits", kernel.name);
                println!("row {}, {name}, {kind} | {}", kernel.name, cost(&batch, &code));
            }
            let fused = device.compile(kernel, &contractible(kernel.spirv)).unwrap();
            assert!(
                !is_exact(&batch, &Code::new(&fused.text)),
                "{name}: fused operations have no effect"
            );
        }
    }
    // On families without fused operations at full rate the compiler makes none.
    if ["navi21", "gfx1100"].contains(&family.as_str()) {
        for kernel in KERNELS.iter().filter(|kernel| kernel.name == "life_perceptron") {
            let compiled = device.compile(kernel, &contractible(kernel.spirv)).unwrap();
            let found = inexact(&compiled.text).len();
            assert!(found > 20, "{family}: {found} fused operations are seen");
        }
    }
}

/// The driver for cards of AMD.
fn driver() -> Option<PathBuf> {
    let folders = ["/usr/share/vulkan/icd.d", "/etc/vulkan/icd.d"];
    let names = ["radeon_icd.x86_64.json", "radeon_icd.json"];
    let all = folders
        .iter()
        .flat_map(|folder| names.map(|name| Path::new(folder).join(name)));
    all.into_iter().find(|path| path.exists())
}

#[test]
fn machine_code_is_exact_and_costs_what_is_pinned() {
    let Some(driver) = driver() else {
        skips::skipped(
            "amd-driver",
            "what AMD's cards run was not looked at (Debian: mesa-vulkan-drivers)",
        );
        return;
    };
    let mut rows = Rows::default();
    let mut version = String::new();
    for family in FAMILIES {
        let ran = Command::new(env::current_exe().unwrap())
            .args(["--exact", "of_family", "--ignored", "--nocapture"])
            .env(FAMILY, family)
            .env("RADV_FORCE_FAMILY", family)
            .env("VK_ICD_FILENAMES", &driver)
            .env("VK_DRIVER_FILES", &driver)
            .env("NODEVICE_SELECT", "1")
            .env("XDG_RUNTIME_DIR", env::temp_dir())
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&ran.stdout);
        assert!(
            ran.status.success(),
            "{family}: {said}{}",
            String::from_utf8_lossy(&ran.stderr)
        );
        for line in said.lines() {
            if let Some(own) = line.strip_prefix("driver ") {
                version = own.split_whitespace().take(2).collect::<Vec<_>>().join("-");
            }
            if let Some((name, figures)) = line.strip_prefix("row ").and_then(|row| row.split_once(" | ")) {
                rows.text(family, name, figures);
            }
        }
    }
    // Other versions of the driver make other code.
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/goldens/machine-code");
    let file = folder.join(format!("{}.rows", version.to_lowercase()));
    if file.exists() {
        pinned::check(&file, &rows.to_string());
    } else {
        println!("no figures are kept for {version}:\n{rows}");
    }
}
