//! Kernels compiled to machine code at run time. Code is compiled once, and kept in the user's cache for the next time.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use oneiro_shader_compiler::tree::Program;
use oneiro_shader_compiler::{Generic, Part, Trees, trees};
use oneiro_shader_native as native;
use oneiro_shaders::{Kernel, Words};

use crate::evaluator::Error;
use crate::variants::Setting;

/// 16 lanes in vectors of 128 bits.
pub(crate) const NAME: &str = "native128x16";
pub(crate) const LANES: u32 = 16;

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

/// Returns a kernel's code.
///
/// # Errors
/// [`Error::NoDevice`] if it can't be compiled.
pub(crate) fn compiled(kernel: &'static Kernel) -> Result<Code, Error> {
    static COMPILED: Mutex<BTreeMap<&str, Code>> = Mutex::new(BTreeMap::new());
    // A poisoned lock is fine: entries are added complete or not at all.
    let mut compiled = COMPILED.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(code) = compiled.get(kernel.name) {
        return Ok(code.clone());
    }
    let failed = |error: native::Error| refused(kernel, &error.to_string());
    let target = native::Target::host().map_err(failed)?;
    let compile = || target.compile(&trees_of(kernel)?, LANES).map_err(failed);
    let code = match native::Cache::of_user() {
        Some(cache) => cache.load_or(&native::Key::new(kernel.wgsl, LANES, &target), compile),
        None => compile(),
    }?;
    let code = Code {
        native: Arc::new(native::Native::new(&code).map_err(failed)?),
        kernel: kernel.name,
    };
    compiled.insert(kernel.name, code.clone());
    Ok(code)
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
        .and_then(|target| target.compile(&trees, LANES))
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
