//! Variants of kernels that are compiled for one world each: the world's values are constant in them. A variant is compiled in the background, once
//! its world has kept the generic kernel busy for long enough, and results never depend on whether it runs.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::mpsc::{self, Receiver};
use std::sync::{Arc, OnceLock};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use oneiro_shader_compiler::Generic;
use oneiro_shader_compiler::specialise::Known;
use oneiro_shader_compiler::tree::{Program, Statement, visit};
use oneiro_shaders::Kernel;

use crate::batch::{Part, Worlds};
use crate::devices::background;
use crate::devices::variants::Specialise;
use crate::evaluator::Control;
use crate::parts::compose;

/// How long compiling takes on a processor, until it is known.
const EXPECTED_COMPILE_TIME: Duration = Duration::from_millis(500);
/// Most variants of a kernel that are kept.
const MOST: usize = 64;

/// A world of a batch, and whether its episodes are traced.
#[derive(Clone)]
pub(crate) struct Setting {
    pub(crate) kernel: &'static Kernel,
    worlds: Worlds,
    world: u32,
    is_traced: bool,
}

impl Setting {
    pub(crate) fn of(part: &Part<'_>, world: u32) -> Self {
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
pub(crate) struct Word {
    buffer: u32,
    element: Option<u32>,
    offset: u32,
    bits: u32,
    /// Whether the element is the world itself, wherever that is in its batch.
    of_own_world: bool,
}

/// A variant in the form that a device runs.
struct Variant<T> {
    /// It is right for every world with these words.
    words: Vec<Word>,
    made: T,
}

impl<T> Variant<T> {
    fn fits(&self, setting: &Setting) -> bool {
        self.words.iter().all(|word| setting.has(word))
    }
}

/// A variant whose loops are unrolled, for drivers that leave long ones, and their most turns in the beginning of an episode and in a cycle.
#[cfg(feature = "gpu")]
#[derive(Clone)]
pub(crate) struct Unrolled<T> {
    pub(crate) made: T,
    pub(crate) begin_turns: u32,
    pub(crate) turns: u32,
}

/// Makes the form that a device runs of a kernel's program for a world.
pub(crate) trait Make<T>: FnOnce(&Generic, &Setting, Program) -> Result<T, String> + Send + 'static {}

impl<T, F: FnOnce(&Generic, &Setting, Program) -> Result<T, String> + Send + 'static> Make<T> for F {}

/// A variant in the making.
struct Underway<T> {
    setting: Setting,
    began: Instant,
    made: Receiver<Result<Variant<T>, String>>,
    thread: JoinHandle<()>,
}

/// The variants of one kernel.
struct OfKernel<T> {
    generic: Arc<OnceLock<Result<Generic, String>>>,
    ready: Vec<Variant<T>>,
    #[cfg(feature = "gpu")]
    unrolled: Vec<Variant<Unrolled<T>>>,
    underway: Vec<Underway<T>>,
    /// Worlds that the generic kernel has simulated, and for how long.
    spent: Vec<(Setting, Duration)>,
}

impl<T> Default for OfKernel<T> {
    fn default() -> Self {
        Self {
            generic: Arc::default(),
            ready: Vec::new(),
            #[cfg(feature = "gpu")]
            unrolled: Vec::new(),
            underway: Vec::new(),
            spent: Vec::new(),
        }
    }
}

/// All variants on a device.
pub(crate) struct Variants<T> {
    pub(crate) when: Specialise,
    /// How many times as long as compiling takes the generic kernel works before a world gets a variant. With 1 the work never takes
    /// twice as long as if that had been known beforehand.
    pub(crate) patience: u32,
    kernels: BTreeMap<(&'static str, usize), OfKernel<T>>,
    /// How long the latest one took to compile, or the first is expected to take.
    pub(crate) compile_time: Duration,
    /// Why one could not be made.
    pub(crate) problems: Vec<String>,
    /// Steps by variants.
    pub(crate) steps: u64,
}

impl<T> std::fmt::Debug for Variants<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Variants")
            .field("when", &self.when)
            .finish_non_exhaustive()
    }
}

impl<T> Drop for Variants<T> {
    fn drop(&mut self) {
        for underway in self.kernels.values_mut().flat_map(|kernel| kernel.underway.drain(..)) {
            background::abandon(underway.thread, true);
        }
    }
}

impl<T> Default for Variants<T> {
    fn default() -> Self {
        Self {
            when: Specialise::default(),
            patience: 1,
            kernels: BTreeMap::new(),
            compile_time: EXPECTED_COMPILE_TIME,
            problems: Vec::new(),
            steps: 0,
        }
    }
}

impl<T: Clone + Send + 'static> Variants<T> {
    fn of(&mut self, kernel: &'static Kernel) -> &mut OfKernel<T> {
        self.kernels
            .entry((kernel.name, kernel.spirv.as_ptr().addr()))
            .or_default()
    }

    /// The variant for a world, if it is ready. Where it must be, this waits for it until `control` is cancelled.
    pub(crate) fn ready<M: Make<T>>(
        &mut self,
        setting: &Setting,
        control: &Control,
        make: impl FnOnce() -> M,
    ) -> Option<T> {
        if self.when == Specialise::Never {
            return None;
        }
        self.collect(setting.kernel);
        let must = self.when == Specialise::Always;
        let found = |kernel: &OfKernel<T>| {
            let mut ready = kernel.ready.iter();
            ready
                .find(|variant| variant.fits(setting))
                .map(|variant| variant.made.clone())
        };
        let made = found(self.of(setting.kernel));
        if made.is_some() || !must {
            return made;
        }
        self.begin(setting.clone(), make());
        while !self.of(setting.kernel).underway.is_empty() && !control.is_cancelled() {
            thread::sleep(Duration::from_millis(1));
            self.collect(setting.kernel);
        }
        found(self.of(setting.kernel))
    }

    /// The variant for a world in which loops would turn more often than a device lets them: in it they are unrolled. `None` if it would get
    /// too long, or if `control` is cancelled.
    ///
    /// # Errors
    /// A mistake of the compiler.
    #[cfg(feature = "gpu")]
    pub(crate) fn unrolled<M: Make<T>>(
        &mut self,
        setting: &Setting,
        most: u32,
        control: &Control,
        make: impl FnOnce() -> M,
    ) -> Result<Option<Unrolled<T>>, String> {
        let kernel = self.of(setting.kernel);
        if let Some(ready) = kernel.unrolled.iter().find(|variant| variant.fits(setting)) {
            return Ok(Some(ready.made.clone()));
        }
        let (generic, of_thread, make) = (Arc::clone(&kernel.generic), setting.clone(), make());
        let work = move || unrolled_of(&generic, &of_thread, most, make);
        let Some(variant) = background::wait(|| control.is_cancelled(), work).transpose()?.flatten() else {
            return Ok(None);
        };
        let made = variant.made.clone();
        kernel.unrolled.truncate(MOST - 1);
        kernel.unrolled.insert(0, variant);
        Ok(Some(made))
    }

    /// Notes that the generic kernel has simulated a world for some time, and begins to make a variant if that is worth it.
    pub(crate) fn spend<M: Make<T>>(&mut self, setting: Setting, time: Duration, make: impl FnOnce() -> M) {
        if self.when != Specialise::Auto {
            return;
        }
        let worth = self.compile_time * self.patience;
        let kernel = self.of(setting.kernel);
        let is_same = |other: &Setting| {
            setting.is_traced == other.is_traced
                && setting.world == other.world
                && setting.worlds.is_same(&other.worlds)
        };
        if kernel.underway.iter().any(|underway| is_same(&underway.setting)) {
            return;
        }
        let at = kernel
            .spent
            .iter()
            .position(|(other, _)| is_same(other))
            .unwrap_or_else(|| {
                if kernel.spent.len() == MOST {
                    kernel.spent.remove(0);
                }
                kernel.spent.push((setting.clone(), Duration::ZERO));
                kernel.spent.len() - 1
            });
        kernel.spent[at].1 += time;
        if kernel.spent[at].1 >= worth && kernel.underway.is_empty() {
            kernel.spent.remove(at);
            self.begin(setting, make());
        }
    }

    /// Begins to make a variant.
    fn begin(&mut self, setting: Setting, make: impl Make<T>) {
        let (tell, made) = mpsc::channel();
        let kernel = self.of(setting.kernel);
        let generic = Arc::clone(&kernel.generic);
        let of_thread = setting.clone();
        let work = move || {
            // Nobody may want it any more.
            let _ = tell.send(made_of(&generic, &of_thread, make));
        };
        // Without another thread, the generic kernel goes on.
        if let Ok(thread) = thread::Builder::new().spawn(work) {
            kernel.underway.push(Underway {
                setting,
                began: Instant::now(),
                made,
                thread,
            });
        }
    }

    /// Takes what has been made.
    fn collect(&mut self, kernel: &'static Kernel) {
        let kernel = self.of(kernel);
        let (mut problems, mut compile_time) = (Vec::new(), None);
        kernel.underway.retain(|underway| match underway.made.try_recv() {
            Err(mpsc::TryRecvError::Empty) => true,
            Ok(Ok(variant)) => {
                compile_time = Some(underway.began.elapsed());
                if kernel.ready.len() == MOST {
                    kernel.ready.remove(0);
                }
                kernel.ready.push(variant);
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
        self.compile_time = compile_time.unwrap_or(self.compile_time);
        if !problems.is_empty() {
            // The generic kernel does it.
            self.when = Specialise::Never;
        }
        self.problems.extend(problems);
    }
}

/// Makes a variant.
fn made_of<T>(
    generic: &OnceLock<Result<Generic, String>>,
    setting: &Setting,
    make: impl Make<T>,
) -> Result<Variant<T>, String> {
    let generic = generic
        .get_or_init(|| parsed(setting.kernel))
        .as_ref()
        .map_err(Clone::clone)?;
    let (words, program) = program(generic, setting);
    let made = make(generic, setting, program)?;
    Ok(Variant { words, made })
}

/// Makes a variant whose loops are unrolled, so that they turn at most `most` times in a cycle. `None` if it would get too long.
#[cfg(feature = "gpu")]
fn unrolled_of<T>(
    generic: &OnceLock<Result<Generic, String>>,
    setting: &Setting,
    most: u32,
    make: impl Make<T>,
) -> Result<Option<Variant<Unrolled<T>>>, String> {
    let generic = generic
        .get_or_init(|| parsed(setting.kernel))
        .as_ref()
        .map_err(Clone::clone)?;
    let packed = setting.worlds.packed();
    let [begin, cycle] = [0, 1].map(|cycles| packed.words_of(setting.world as usize, cycles));
    let Some((unrolled, [begin, both])) = generic.unrolled([&begin, &cycle], u64::from(most)) else {
        return Ok(None);
    };
    let (words, program) = program(&unrolled, setting);
    let made = Unrolled {
        made: make(&unrolled, setting, program)?,
        begin_turns: begin as u32,
        turns: (both - begin) as u32,
    };
    Ok(Some(Variant { words, made }))
}

/// A kernel from which variants are made.
///
/// # Errors
/// A mistake of the compiler.
pub(crate) fn parsed(kernel: &Kernel) -> Result<Generic, String> {
    Generic::new(&compose::parts_of(kernel)).map_err(|refusals| format!("{}: {refusals:?}", kernel.name))
}

/// Whether a kernel has no parts of a user's, of which it isn't known what they do with an index or with a zero's sign.
pub(crate) fn ships(kernel: &Kernel) -> bool {
    !kernel.variants.is_empty()
}

/// The words that a variant takes for constant, and its program.
pub(crate) fn program(generic: &Generic, setting: &Setting) -> (Vec<Word>, Program) {
    let name_of = |buffer: u32| {
        setting
            .kernel
            .bindings
            .get(buffer as usize)
            .map_or("", |binding| binding.name)
    };
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::batch::Rollout;
    use crate::random::Key;
    use crate::world::{World, WorldSpec};

    /// A world, packed anew.
    fn setting(cycles: u32) -> Setting {
        let spec = WorldSpec {
            cycles,
            ..WorldSpec::miglino1995()
        };
        let worlds = Worlds::new(&[World::new(spec).unwrap()]).unwrap();
        let rollout = Rollout {
            world: 0,
            genes: &[0.0; 18],
            key: Key::rollout(0, 0, 0, 0),
        };
        Setting::of(&worlds.batch(&[rollout], None).unwrap().all(), 0)
    }

    #[test]
    fn time_in_a_world_counts_together_however_often_it_was_packed() {
        let mut variants = Variants::<()>::default();
        let kernel = setting(500).kernel;
        let mut begins = |setting| {
            variants.spend(setting, EXPECTED_COMPILE_TIME / 2, || {
                |_: &Generic, _: &Setting, _: Program| Ok(())
            });
            !variants.of(kernel).underway.is_empty()
        };
        assert!(!begins(setting(500)));
        assert!(!begins(setting(400)), "another world has its own time");
        assert!(begins(setting(500)));
    }
}
