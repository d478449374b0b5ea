//! Kernels compiled to machine code at run time. Code is compiled once, and kept in the user's cache for the next time.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;

use oneiro_shader_compiler::tree::Program;
use oneiro_shader_compiler::{Generic, Part, Trees, trees};
use oneiro_shader_native as native;
use oneiro_shaders::{Kernel, Words};

use crate::devices::background;
use crate::devices::variants::Setting;
use crate::evaluator::Error;

/// 16 lanes in vectors of 128 bits.
pub(crate) const NAME: &str = "native128x16";
pub(crate) const LANES: u32 = 16;
/// Lanes of the code that a long program has at first. It takes half as long to compile.
const FIRST: u32 = 8;
/// Values of the longest program whose code with all lanes is compiled in less than 150 ms.
const LONG: usize = 3_500;

/// Compiled code.
#[derive(Clone, Debug)]
pub(crate) struct Code {
    native: Arc<native::Native>,
    kernel: &'static str,
}

/// Whether code can be compiled for this processor.
pub(crate) fn is_available() -> bool {
    native::Target::host().is_ok()
}

/// The code of each kernel so far, or why there is none.
fn known() -> MutexGuard<'static, BTreeMap<&'static str, Result<Code, String>>> {
    static COMPILED: Mutex<BTreeMap<&str, Result<Code, String>>> = Mutex::new(BTreeMap::new());
    // A poisoned lock is fine: entries are added complete or not at all.
    COMPILED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Why a kernel had to be compiled and couldn't be.
pub(crate) fn problem(kernel: &'static Kernel) -> Option<String> {
    known().get(kernel.name)?.clone().err()
}

/// Held by the one of the threads in the background that compiles.
static TURN: Mutex<()> = Mutex::new(());

/// Returns a kernel's code. That of a long program has fewer lanes at first, until that of all lanes has been compiled in the
/// background.
///
/// # Errors
/// [`Error::NoDevice`] if it can't be compiled.
pub(crate) fn compiled(kernel: &'static Kernel) -> Result<Code, Error> {
    let mut known = known();
    if let Some(code) = known.get(kernel.name) {
        return code.clone().map_err(Error::NoDevice);
    }
    let compiler = Compiler::new(kernel, native::Cache::of_user())?;
    let (code, is_whole) = match compiler.first() {
        Ok(first) => first,
        Err(error) => {
            known.insert(kernel.name, Err(error.to_string()));
            return Err(error);
        }
    };
    known.insert(kernel.name, Ok(code.clone()));
    let lanes = code.lanes();
    if !is_whole {
        let whole = move || {
            // Waiting jobs have no memory yet: compiling the longest shipped kernels takes 350 MB.
            let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
            if let Ok(Some(code)) = compiler.whole(lanes) {
                self::known().insert(kernel.name, Ok(code));
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
    target: native::Target,
    cache: Option<native::Cache>,
}

impl Compiler {
    fn new(kernel: &'static Kernel, cache: Option<native::Cache>) -> Result<Self, Error> {
        let target = native::Target::host().map_err(|error| refused(kernel, &error.to_string()))?;
        Ok(Self { kernel, target, cache })
    }

    /// The code that can be had soon, and whether none with more lanes is worth waiting for.
    fn first(&self) -> Result<(Code, bool), Error> {
        for lanes in native::LANES.into_iter().rev() {
            let key = native::Key::new(self.kernel.wgsl, lanes, &self.target);
            if let Some(code) = self.cache.as_ref().and_then(|cache| cache.load(&key)) {
                return Ok((self.ready(&code)?, lanes == LANES));
            }
        }
        let trees = trees_of(self.kernel)?;
        let most = self.most_lanes(&trees)?;
        let is_long = trees.tidied.values.len() > LONG;
        let lanes = if is_long { FIRST.min(most) } else { most };
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
        native::most_lanes(trees).map_err(|error| refused(self.kernel, &error.to_string()))
    }

    /// The code with these lanes, or with fewer where a thread's stack has no room for more.
    fn compile(&self, trees: &Trees, lanes: u32) -> Result<Code, Error> {
        let fewer = native::LANES.into_iter().rev().filter(|fewer| *fewer <= lanes);
        let mut failed = None;
        for lanes in fewer {
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
pub(crate) fn trees_of(kernel: &Kernel) -> Result<Trees, Error> {
    let part = Part {
        path: format!("{}.wgsl", kernel.name),
        text: kernel.wgsl.into(),
    };
    trees(&[part]).map_err(|refusals| refused(kernel, &refusals[0].to_string()))
}

/// The buffers in the layout that code compiled outside of this program expects.
pub(super) fn words(buffers: &[Words]) -> Vec<native::Words> {
    let words = |buffer: &Words| native::Words {
        start: buffer.start,
        len: buffer.len,
    };
    buffers.iter().map(words).collect()
}

/// Compiles a program of a kernel for a world.
pub(crate) fn specialised(generic: &Generic, setting: &Setting, program: Program) -> Result<Code, String> {
    let kernel = setting.kernel.name;
    let trees = generic
        .trees(program)
        .map_err(|refusals| format!("{kernel}: {}", refusals[0]))?;
    let said = |error: native::Error| format!("{kernel}: {error}");
    let code = native::Target::host()
        .and_then(|target| target.compile(&trees, native::most_lanes(&trees)?))
        .map_err(said)?;
    let native = Arc::new(native::Native::new(&code).map_err(said)?);
    Ok(Code { native, kernel })
}

impl Code {
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

    /// A long program's first code has half the lanes, and a short one's all.
    #[test]
    fn long_programs_begin_with_fewer_lanes() {
        for (kernel, lanes) in [
            (&oneiro_shaders::PROBE_NUMERICS, LANES),
            (&oneiro_shaders::SURROGATE_PERCEPTRON, FIRST),
        ] {
            let compiler = Compiler::new(kernel, None).unwrap();
            let (code, is_whole) = compiler.first().unwrap();
            assert_eq!((code.lanes(), is_whole), (lanes, lanes == LANES), "{}", kernel.name);
            let whole = compiler.whole(code.lanes()).unwrap();
            assert_eq!(whole.is_none(), is_whole);
            assert!(whole.is_none_or(|whole| whole.lanes() == LANES));
        }
    }
}
