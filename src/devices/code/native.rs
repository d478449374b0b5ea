//! Kernels compiled to machine code at run time. Code is compiled once, and kept in the user's cache for the next time.

use std::collections::BTreeMap;
use std::sync::{Arc, LazyLock, Mutex, MutexGuard, PoisonError};
use std::thread;

#[cfg(not(target_family = "wasm"))]
use oneiro_shader_compiler::{Generic, tree::Program};
use oneiro_shader_compiler::{Part, Trees, trees};
use oneiro_shader_native as native;
use oneiro_shaders::{Kernel, Words};

use crate::devices::background;
#[cfg(not(target_family = "wasm"))]
use crate::devices::variants::Setting;
use crate::evaluator::Error;

/// A code generator, and the number of lanes that it is asked for.
#[derive(Debug)]
struct Kind {
    name: &'static str,
    lanes: u32,
    /// Lanes of the code that a long program has at first. It takes half as long to compile.
    first: u32,
    target: fn() -> Option<native::Target>,
}

/// Vectors of 512, 256 and 128 bits.
static KINDS: [Kind; 4] = [
    Kind {
        name: "native512x64",
        lanes: 64,
        first: 16,
        target: native::Target::avx512,
    },
    Kind {
        name: "native512x16",
        lanes: 16,
        first: 16,
        target: native::Target::avx512,
    },
    Kind {
        name: "native256x16",
        lanes: 16,
        first: 8,
        target: native::Target::avx2,
    },
    Kind {
        name: "native128x16",
        lanes: 16,
        first: 8,
        target: host,
    },
];

fn host() -> Option<native::Target> {
    native::Target::host().ok()
}

/// Values of the longest program whose code with all lanes is compiled in less than 150 ms.
const LONG: usize = 3_500;

/// Compiled code.
#[derive(Clone, Debug)]
pub(crate) struct Code {
    native: Arc<native::Native>,
    kernel: &'static str,
    kind: &'static Kind,
}

/// Those that this processor runs, the fastest first.
fn kinds() -> impl Iterator<Item = &'static Kind> {
    // To ask takes longer than a batch of a few episodes may.
    static AVAILABLE: LazyLock<Vec<&Kind>> =
        LazyLock::new(|| KINDS.iter().filter(|kind| (kind.target)().is_some()).collect());
    AVAILABLE.iter().copied()
}

/// Names and numbers of lanes of the codes that can be compiled for this processor, the fastest first.
pub(crate) fn all() -> impl Iterator<Item = (&'static str, u32)> {
    kinds().map(|kind| (kind.name, kind.lanes))
}

/// The codes of a kernel's name and their own.
type Known = BTreeMap<(&'static str, &'static str), Result<Code, String>>;

/// The code of each kernel so far, or why there is none.
fn known() -> MutexGuard<'static, Known> {
    static COMPILED: Mutex<Known> = Mutex::new(BTreeMap::new());
    // A poisoned lock is fine: entries are added complete or not at all.
    COMPILED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Why a kernel had to be compiled and couldn't be by any generator.
pub(crate) fn problem(kernel: &'static Kernel) -> Option<String> {
    let known = known();
    let of_kind = |kind: &Kind| known.get(&(kernel.name, kind.name))?.clone().err();
    kinds().map(of_kind).collect::<Option<Vec<_>>>()?.pop()
}

/// Held by the one of the threads in the background that compiles.
static TURN: Mutex<()> = Mutex::new(());

/// A kernel's code by name; `None` if there is no such code for this processor.
pub(crate) fn named(kernel: &'static Kernel, name: &str) -> Option<Result<Code, Error>> {
    kinds()
        .find(|kind| kind.name == name)
        .map(|kind| compiled(kernel, kind))
}

/// The fastest code that a kernel can be compiled to.
///
/// # Errors
/// [`Error::NoDevice`] if there is none.
pub(crate) fn best(kernel: &'static Kernel) -> Result<Code, Error> {
    let mut problem = Error::NoDevice("this processor has no code compiled at run time".into());
    for kind in kinds() {
        match compiled(kernel, kind) {
            Ok(code) => return Ok(code),
            Err(error) => problem = error,
        }
    }
    Err(problem)
}

/// Returns a kernel's code. That of a long program has fewer lanes at first, until that of all lanes has been compiled in the
/// background.
///
/// # Errors
/// [`Error::NoDevice`] if it can't be compiled.
fn compiled(kernel: &'static Kernel, kind: &'static Kind) -> Result<Code, Error> {
    let mut known = known();
    let name = (kernel.name, kind.name);
    if let Some(code) = known.get(&name) {
        return code.clone().map_err(Error::NoDevice);
    }
    let compiler = Compiler::new(kernel, kind, native::Cache::of_user());
    let (code, is_whole) = match compiler.first() {
        Ok(first) => first,
        Err(error) => {
            known.insert(name, Err(error.to_string()));
            return Err(error);
        }
    };
    known.insert(name, Ok(code.clone()));
    let lanes = code.lanes();
    if !is_whole {
        let whole = move || {
            // Waiting jobs have no memory yet: compiling the longest shipped kernels takes 350 MB.
            let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
            if let Ok(Some(code)) = compiler.whole(lanes) {
                self::known().insert(name, Ok(code));
            }
        };
        // Without another thread, the code with fewer lanes remains. At its end the process waits for it, so that the code is in the
        // cache the next time.
        if let Ok(thread) = thread::Builder::new().spawn(whole) {
            background::abandon(thread, true);
        }
    }
    Ok(code)
}

/// Compiles a kernel, unless its code is in a cache.
struct Compiler {
    kernel: &'static Kernel,
    kind: &'static Kind,
    target: native::Target,
    cache: Option<native::Cache>,
}

impl Compiler {
    fn new(kernel: &'static Kernel, kind: &'static Kind, cache: Option<native::Cache>) -> Self {
        Self {
            kernel,
            kind,
            target: (kind.target)().expect("it is there once it is a kind of this processor"),
            cache,
        }
    }

    /// Numbers of lanes up to this one, in descending order.
    fn lanes_to(&self, most: u32) -> impl Iterator<Item = u32> + use<> {
        let lanes = self.target.lanes().iter().copied().rev();
        lanes.filter(move |lanes| *lanes <= most)
    }

    /// The code that can be had soon, and whether none with more lanes is worth waiting for.
    fn first(&self) -> Result<(Code, bool), Error> {
        for lanes in self.lanes_to(self.kind.lanes) {
            let key = native::Key::new(self.kernel.wgsl, lanes, &self.target);
            if let Some(code) = self.cache.as_ref().and_then(|cache| cache.load(&key)) {
                return Ok((self.ready(&code)?, lanes == self.kind.lanes));
            }
        }
        let trees = trees_of(self.kernel)?;
        let most = self.most_lanes(&trees)?;
        let is_long = trees.tidied.values.len() > LONG;
        let lanes = if is_long { self.kind.first.min(most) } else { most };
        Ok((self.compile(&trees, lanes)?, lanes == most))
    }

    /// The code with all lanes that there is room for; `None` if that has no more than these.
    fn whole(&self, lanes: u32) -> Result<Option<Code>, Error> {
        let trees = trees_of(self.kernel)?;
        let most = self.most_lanes(&trees)?;
        let code = (most > lanes).then(|| self.compile(&trees, most)).transpose()?;
        Ok(code.filter(|code| code.lanes() > lanes))
    }

    fn most_lanes(&self, trees: &Trees) -> Result<u32, Error> {
        let most = self.target.most_lanes(trees);
        let most = most.map_err(|error| refused(self.kernel, &error.to_string()))?;
        Ok(most.min(self.kind.lanes))
    }

    /// The code with these lanes, or with fewer where a thread's stack has no room for more.
    fn compile(&self, trees: &Trees, lanes: u32) -> Result<Code, Error> {
        let mut failed = None;
        for lanes in self.lanes_to(lanes) {
            let compile = || self.target.compile(trees, lanes);
            let code = match &self.cache {
                Some(cache) => cache.load_or(&native::Key::new(self.kernel.wgsl, lanes, &self.target), compile),
                None => compile(),
            };
            match code {
                Ok(code) => return self.ready(&code),
                Err(error @ (native::Error::TooLarge | native::Error::Arrays(_))) => failed = Some(error),
                Err(error) => return Err(refused(self.kernel, &error.to_string())),
            }
        }
        Err(refused(
            self.kernel,
            &failed.map_or_else(String::new, |error| error.to_string()),
        ))
    }

    fn ready(&self, code: &native::Code) -> Result<Code, Error> {
        let native = native::Native::new(code).map_err(|error| refused(self.kernel, &error.to_string()))?;
        Ok(Code {
            native: Arc::new(native),
            kernel: self.kernel.name,
            kind: self.kind,
        })
    }
}

fn refused(kernel: &Kernel, problem: &str) -> Error {
    Error::NoDevice(format!("the kernel {} can't be compiled: {problem}", kernel.name))
}

/// A kernel's program.
///
/// # Errors
/// [`Error::NoDevice`] if its text is refused.
fn trees_of(kernel: &Kernel) -> Result<Trees, Error> {
    let part = Part {
        path: format!("{}.wgsl", kernel.name),
        text: kernel.wgsl.into(),
    };
    trees(&[part]).map_err(|refusals| refused(kernel, &refusals[0].to_string()))
}

/// The buffers in the layout that the code expects.
fn words(buffers: &[Words]) -> Vec<native::Words> {
    let words = |buffer: &Words| native::Words {
        start: buffer.start,
        len: buffer.len,
    };
    buffers.iter().map(words).collect()
}

impl Code {
    /// Compiles a program of a kernel for a world, by the same generator as this code.
    #[cfg(not(target_family = "wasm"))]
    pub(crate) fn specialise(&self) -> impl Fn(&Generic, &Setting, Program) -> Result<Self, String> + use<> {
        let kind = self.kind;
        move |generic, setting, program| {
            let kernel = setting.kernel.name;
            let trees = generic
                .trees(program)
                .map_err(|refusals| format!("{kernel}: {}", refusals[0]))?;
            let said = |error: native::Error| format!("{kernel}: {error}");
            let target = (kind.target)().expect("it is there for the other code");
            let most = target.most_lanes(&trees).map_err(said)?;
            let code = target.compile(&trees, most.min(kind.lanes)).map_err(said)?;
            let native = Arc::new(native::Native::new(&code).map_err(said)?);
            Ok(Self { native, kernel, kind })
        }
    }

    pub(crate) fn name(&self) -> &'static str {
        self.kind.name
    }

    pub(crate) fn lanes(&self) -> u32 {
        self.native.lanes()
    }

    /// Runs its lanes of one workgroup, from `first_lane` on.
    ///
    /// # Errors
    /// [`Error::Unbounded`] if its loops turn more than `turns` times in all.
    ///
    /// # Safety
    /// As [`super::LaneCode::run`].
    pub(crate) unsafe fn run(
        &self,
        buffers: &[Words],
        workgroup: u32,
        first_lane: u32,
        turns: u64,
    ) -> Result<(), Error> {
        // SAFETY: the caller guarantees it.
        match unsafe { self.native.run(&words(buffers), workgroup, first_lane, turns) } {
            Err(native::Stopped::TurnsUsedUp(turns)) => Err(Error::Unbounded {
                kernel: self.kernel.to_owned(),
                turns,
            }),
            Err(stopped @ native::Stopped::Size { .. }) => Err(Error::TooLarge(format!(
                "{}: {stopped}; evaluate fewer episodes at once",
                self.kernel
            ))),
            done => {
                done.expect("the buffers are those of its bindings");
                Ok(())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A long program's first code has fewer lanes, and a short one's all.
    #[test]
    fn long_programs_begin_with_fewer_lanes() {
        for kind in kinds() {
            for (kernel, lanes) in [
                (&oneiro_shaders::PROBE_NUMERICS, kind.lanes),
                (&oneiro_shaders::SURROGATE_PERCEPTRON, kind.first),
            ] {
                let compiler = Compiler::new(kernel, kind, None);
                let (code, is_whole) = compiler.first().unwrap();
                let all = kind.lanes;
                assert_eq!(
                    (code.lanes(), is_whole),
                    (lanes, lanes == all),
                    "{}, {kind:?}",
                    kernel.name
                );
                let whole = compiler.whole(code.lanes()).unwrap();
                assert_eq!(whole.is_none(), is_whole);
                assert!(whole.is_none_or(|whole| whole.lanes() == all));
            }
        }
    }
}
