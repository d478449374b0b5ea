//! Variants of kernels for one world each: what the world says is constant in them. A variant is compiled in the background, once
//! its world has kept the generic kernel busy for as long as compiling takes, and results never depend on which of them runs.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::mpsc::{self, Receiver};
use std::sync::{Arc, OnceLock};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use oneiro_shader_compiler::specialise::Known;
use oneiro_shader_compiler::tree::{Program, Statement, visit};
use oneiro_shader_compiler::{Generic, Indices};
use oneiro_shaders::Kernel;

use super::device::{Device, Maker, Path, Pipeline};
use crate::backend::Specialise;
use crate::batch::{Part, Worlds};
use crate::compose;

/// Time with the generic kernel after which a world gets a variant, until it is known how long compiling takes. To wait as long as
/// that takes is never more than twice as slow as to know beforehand.
const FIRST: Duration = Duration::from_millis(500);
/// Most variants of a kernel that are kept.
const MOST: usize = 64;

/// A world of a batch, and whether its lives are traced.
#[derive(Clone)]
pub(super) struct Setting {
    pub(super) kernel: &'static Kernel,
    worlds: Worlds,
    world: u32,
    is_traced: bool,
}

impl Setting {
    pub(super) fn of(part: &Part<'_>, world: u32) -> Self {
        Self {
            kernel: part.kernel(),
            worlds: part.batch().worlds().clone(),
            world,
            is_traced: part.trace_every() > 0,
        }
    }

    /// What is known of a word of a buffer.
    fn word(&self, buffer: u32, element: Option<u32>, offset: u32) -> Option<u32> {
        let binding = self.kernel.bindings.get(buffer as usize)?;
        let in_array = |words: &[u32]| {
            let stride = binding.stride as usize / size_of::<u32>();
            let last = (words.len() / stride).checked_sub(1)?;
            words
                .get((element? as usize).min(last) * stride + offset as usize)
                .copied()
        };
        let packed = self.worlds.packed();
        match binding.name {
            // `trace_every` and `trace_records`
            "dispatch" => (matches!(offset, 2 | 3) && !self.is_traced).then_some(0),
            "groups" => (offset == 0).then_some(self.world),
            "worlds" => in_array(bytemuck::cast_slice(&packed.worlds)),
            "shapes" => in_array(bytemuck::cast_slice(&packed.shapes)),
            "tables" => in_array(bytemuck::cast_slice(&packed.tables)),
            _ => None,
        }
    }

    /// Whether a word on which a variant relies is the same here.
    fn has(&self, word: &Word) -> bool {
        let element = if word.of_own_world {
            Some(self.world)
        } else {
            word.element
        };
        self.word(word.buffer, element, word.offset) == Some(word.bits)
    }
}

/// A word that a variant takes for constant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Word {
    buffer: u32,
    element: Option<u32>,
    offset: u32,
    bits: u32,
    /// Whether the element is the world itself, wherever that is in its batch.
    of_own_world: bool,
}

/// A variant.
struct Variant {
    /// It is right for every world with these words.
    words: Vec<Word>,
    pipeline: Arc<Pipeline>,
}

/// A variant in the making.
struct Underway {
    setting: Setting,
    began: Instant,
    made: Receiver<Result<Variant, String>>,
    thread: JoinHandle<()>,
}

/// The variants of one kernel.
#[derive(Default)]
struct OfKernel {
    generic: Arc<OnceLock<Result<Generic, String>>>,
    ready: Vec<Variant>,
    underway: Vec<Underway>,
    /// Worlds that the generic kernel has simulated, and for how long.
    spent: Vec<(Setting, Duration)>,
}

/// All variants on a device.
#[derive(Default)]
pub(super) struct Variants {
    pub(super) when: Specialise,
    kernels: BTreeMap<(&'static str, usize), OfKernel>,
    /// How long the last one took to make.
    cost: Option<Duration>,
    /// Why one could not be made.
    pub(super) problems: Vec<String>,
    /// Steps by variants.
    pub(super) steps: u64,
}

impl std::fmt::Debug for Variants {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Variants")
            .field("when", &self.when)
            .finish_non_exhaustive()
    }
}

impl Drop for Variants {
    /// A driver may not be unloaded while it compiles.
    fn drop(&mut self) {
        for underway in self.kernels.values_mut().flat_map(|own| own.underway.drain(..)) {
            let _ = underway.thread.join();
        }
    }
}

impl Variants {
    fn of(&mut self, kernel: &'static Kernel) -> &mut OfKernel {
        self.kernels
            .entry((kernel.name, kernel.spirv.as_ptr().addr()))
            .or_default()
    }

    /// The variant for a world of a part, if it is ready.
    pub(super) fn ready(&mut self, device: &Device, part: &Part<'_>, world: u32) -> Option<Arc<Pipeline>> {
        if self.when == Specialise::Never || device.path() != Path::Spirv {
            return None;
        }
        let setting = Setting::of(part, world);
        self.collect(setting.kernel);
        let must = self.when == Specialise::Always;
        let found = |own: &OfKernel| {
            let fits = |variant: &&Variant| variant.words.iter().all(|word| setting.has(word));
            own.ready.iter().find(fits).map(|variant| Arc::clone(&variant.pipeline))
        };
        let pipeline = found(self.of(setting.kernel));
        if pipeline.is_some() || !must {
            return pipeline;
        }
        self.begin(device, setting.clone());
        while !self.of(setting.kernel).underway.is_empty() {
            thread::sleep(Duration::from_millis(1));
            self.collect(setting.kernel);
        }
        found(self.of(setting.kernel))
    }

    /// Notes that the generic kernel has simulated a world for some time, and begins to make a variant if that is worth it.
    pub(super) fn spend(&mut self, device: &Device, part: &Part<'_>, world: u32, time: Duration) {
        if self.when != Specialise::Auto || device.path() != Path::Spirv {
            return;
        }
        let cost = self.cost.unwrap_or(FIRST);
        let setting = Setting::of(part, world);
        let own = self.of(setting.kernel);
        let is_same = |other: &Setting| {
            setting.is_traced == other.is_traced
                && setting.world == other.world
                && setting.worlds.is_same(&other.worlds)
        };
        if own.underway.iter().any(|underway| is_same(&underway.setting)) {
            return;
        }
        let at = own
            .spent
            .iter()
            .position(|(other, _)| is_same(other))
            .unwrap_or_else(|| {
                if own.spent.len() == MOST {
                    own.spent.remove(0);
                }
                own.spent.push((setting.clone(), Duration::ZERO));
                own.spent.len() - 1
            });
        own.spent[at].1 += time;
        if own.spent[at].1 >= cost && own.underway.is_empty() {
            own.spent.remove(at);
            self.begin(device, setting);
        }
    }

    /// Begins to make a variant.
    fn begin(&mut self, device: &Device, setting: Setting) {
        let (tell, made) = mpsc::channel();
        let maker = device.maker();
        let own = self.of(setting.kernel);
        let generic = Arc::clone(&own.generic);
        let of_thread = setting.clone();
        let thread = thread::spawn(move || {
            // Nobody may want it any more.
            let _ = tell.send(make(&generic, &of_thread, &maker));
        });
        own.underway.push(Underway {
            setting,
            began: Instant::now(),
            made,
            thread,
        });
    }

    /// Takes what has been made.
    fn collect(&mut self, kernel: &'static Kernel) {
        let own = self.of(kernel);
        let (mut problems, mut cost) = (Vec::new(), None);
        own.underway.retain(|underway| match underway.made.try_recv() {
            Err(mpsc::TryRecvError::Empty) => true,
            Ok(Ok(variant)) => {
                cost = Some(underway.began.elapsed());
                if own.ready.len() == MOST {
                    own.ready.remove(0);
                }
                own.ready.push(variant);
                false
            }
            Ok(Err(problem)) => {
                problems.push(problem);
                false
            }
            Err(mpsc::TryRecvError::Disconnected) => {
                problems.push("the compiler failed".to_owned());
                false
            }
        });
        self.cost = cost.or(self.cost);
        if !problems.is_empty() {
            // The generic kernel does it.
            self.when = Specialise::Never;
        }
        self.problems.extend(problems);
    }
}

/// Makes a variant.
fn make(generic: &OnceLock<Result<Generic, String>>, setting: &Setting, maker: &Maker) -> Result<Variant, String> {
    let generic = generic
        .get_or_init(|| parsed(setting.kernel))
        .as_ref()
        .map_err(Clone::clone)?;
    let (words, spirv) = compiled(generic, setting)?;
    let pipeline = Arc::new(maker.pipeline(setting.kernel, Some(&spirv)));
    Ok(Variant { words, pipeline })
}

/// SPIR-V of the kernel of a batch, specialised to one of its worlds, for tools that look at what a driver makes of it.
///
/// # Errors
/// A mistake of the compiler.
pub fn specialised(part: &Part<'_>, world: u32) -> Result<Vec<u32>, String> {
    let setting = Setting::of(part, world);
    Ok(compiled(&parsed(setting.kernel)?, &setting)?.1)
}

/// A kernel from which variants are made.
///
/// # Errors
/// A mistake of the compiler.
pub(super) fn parsed(kernel: &Kernel) -> Result<Generic, String> {
    Generic::new(&compose::parts_of(kernel)).map_err(|refusals| format!("{}: {refusals:?}", kernel.name))
}

/// The words that a variant takes for constant, and its SPIR-V.
fn compiled(generic: &Generic, setting: &Setting) -> Result<(Vec<Word>, Vec<u32>), String> {
    let (words, program) = program(generic, setting);
    let indices = if ships(setting.kernel) {
        Indices::Within
    } else {
        Indices::Clamped
    };
    Ok((words, generic.spirv(&program, indices)?))
}

/// Whether a kernel has no parts of a user's, of which it isn't known what they do with an index or with a zero's sign.
fn ships(kernel: &Kernel) -> bool {
    !kernel.variants.is_empty()
}

/// The words that a variant takes for constant, and its program.
pub(super) fn program(generic: &Generic, setting: &Setting) -> (Vec<Word>, Program) {
    let name_of = |buffer: u32| setting.kernel.bindings.get(buffer as usize).map_or("", |own| own.name);
    let words = RefCell::new(BTreeSet::new());
    let word = |buffer: u32, element: Option<u32>, offset: u32| {
        let bits = setting.word(buffer, element, offset)?;
        words.borrow_mut().insert(Word {
            buffer,
            element,
            offset,
            bits,
            of_own_world: name_of(buffer) == "worlds" && element == Some(setting.world),
        });
        Some(bits)
    };
    let signed_zeros = !ships(setting.kernel);
    let program = generic.program(&Known {
        word: &word,
        signed_zeros,
    });
    // The world's own index is no constant of the variant if all that it leads to is.
    let mut reads_worlds = false;
    visit(&program.body, &mut |statement| {
        reads_worlds |= matches!(statement, Statement::Load { address, .. } if name_of(address.buffer) == "worlds");
    });
    let mut words: Vec<Word> = words.into_inner().into_iter().collect();
    words.retain(|word| reads_worlds || name_of(word.buffer) != "groups");
    (words, program)
}
