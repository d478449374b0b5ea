//! Pipelines of kernels that are specialised to a world.

use std::sync::Arc;
use std::time::Duration;

use oneiro_shader_compiler::tree::Program;
use oneiro_shader_compiler::{Generic, Indices};

use super::device::{Device, Path, Pipeline};
use crate::batch::Part;
use crate::devices::variants::{self, Make, Setting, parsed, program, ships};
use crate::evaluator::Control;

pub(super) type Variants = variants::Variants<Arc<Pipeline>>;
pub(super) type Unrolled = variants::Unrolled<Arc<Pipeline>>;

/// How long a real GPU's driver takes to compile a kernel, until it is known.
const EXPECTED_COMPILE_TIME: Duration = Duration::from_millis(100);

/// Sets the time that a real GPU's driver is expected to take.
pub(super) fn expect_gpu_compiler(variants: &mut Variants) {
    variants.compile_time = EXPECTED_COMPILE_TIME;
}

/// The variant for a world of a part, if it is ready.
pub(super) fn ready(
    variants: &mut Variants,
    device: &Device,
    part: &Part<'_>,
    world: u32,
    control: &Control,
) -> Option<Arc<Pipeline>> {
    (device.path() == Path::Spirv)
        .then(|| variants.ready(&Setting::of(part, world), control, || make(device)))
        .flatten()
}

/// Notes that the generic kernel has simulated a world for some time.
pub(super) fn spend(variants: &mut Variants, device: &Device, part: &Part<'_>, world: u32, time: Duration) {
    if device.path() == Path::Spirv {
        variants.spend(Setting::of(part, world), time, || make(device));
    }
}

/// The variant with unrolled loops for a world of a part, whose cycle turns them more than `most` times. `None` if it would get too long,
/// or if `control` is cancelled.
///
/// # Errors
/// A mistake of the compiler.
pub(super) fn unrolled(
    variants: &mut Variants,
    device: &Device,
    part: &Part<'_>,
    world: u32,
    most: u32,
    control: &Control,
) -> Result<Option<Unrolled>, String> {
    if device.path() != Path::Spirv {
        return Ok(None);
    }
    variants.unrolled(&Setting::of(part, world), most, control, || make(device))
}

/// Makes pipelines of a device.
fn make(device: &Device) -> impl Make<Arc<Pipeline>> + use<> {
    let maker = device.maker();
    move |generic: &Generic, setting: &Setting, program: Program| {
        let spirv = spirv(generic, setting, &program)?;
        Ok(Arc::new(maker.pipeline(setting.kernel, Some(&spirv))))
    }
}

fn spirv(generic: &Generic, setting: &Setting, program: &Program) -> Result<Vec<u32>, String> {
    let indices = if ships(setting.kernel) {
        Indices::Within
    } else {
        Indices::Clamped
    };
    generic.spirv(program, indices)
}

/// SPIR-V of the kernel of a batch, specialised to one of its worlds, for tools that look at what a driver makes of it.
///
/// # Errors
/// A mistake of the compiler.
pub fn specialised(part: &Part<'_>, world: u32) -> Result<Vec<u32>, String> {
    let setting = Setting::of(part, world);
    let generic = parsed(setting.kernel)?;
    let (_, program) = program(&generic, &setting);
    spirv(&generic, &setting, &program)
}
