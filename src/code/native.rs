//! Kernels compiled to machine code at run time, once in a program's life; the next program finds the code in the user's
//! cache.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use oneiro_shader_compiler::{Part, trees};
use oneiro_shader_native as native;
use oneiro_shaders::{Kernel, Words};

use crate::evaluator::Error;

/// Vectors of 128 bits, 16 lanes.
pub(crate) const NAME: &str = "native128x16";
const LANES: u32 = 16;

/// Compiled code.
#[derive(Clone, Debug)]
pub(crate) struct Code(Arc<native::Native>);

/// Whether code can be compiled for this processor.
pub(crate) fn is_available() -> bool {
    native::Target::host().is_ok()
}

/// The code of a kernel.
///
/// # Errors
/// [`Error::NoDevice`] if it can't be compiled.
pub(crate) fn compiled(kernel: &'static Kernel) -> Result<Code, Error> {
    static COMPILED: Mutex<BTreeMap<&str, Code>> = Mutex::new(BTreeMap::new());
    // A kernel is added whole or not at all.
    let mut compiled = COMPILED.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(code) = compiled.get(kernel.name) {
        return Ok(code.clone());
    }
    let refused = |problem: String| Error::NoDevice(format!("the kernel {} can't be compiled: {problem}", kernel.name));
    let part = Part {
        path: format!("{}.wgsl", kernel.name),
        text: kernel.wgsl.into(),
    };
    let failed = |error: native::Error| refused(error.to_string());
    let target = native::Target::host().map_err(failed)?;
    let cache = native::Cache::of_user();
    let key = native::Key::new(kernel.wgsl, LANES, &target);
    let kept = cache.as_ref().and_then(|cache| cache.load(&key));
    let code = if let Some(code) = kept {
        code
    } else {
        let trees = trees(&[part]).map_err(|refusals| refused(refusals[0].to_string()))?;
        let code = target.compile(&trees, LANES).map_err(failed)?;
        if let Some(cache) = cache {
            // Without it the next program compiles again.
            let _ = cache.save(&key, &code);
        }
        code
    };
    let code = Code(Arc::new(native::Native::new(&code).map_err(failed)?));
    compiled.insert(kernel.name, code.clone());
    Ok(code)
}

impl Code {
    pub(crate) fn lanes(&self) -> u32 {
        self.0.lanes()
    }

    /// Runs its lanes of one workgroup, from `first_lane` on.
    ///
    /// # Safety
    /// As [`super::LaneCode::run`].
    pub(crate) unsafe fn run(&self, buffers: &[Words], workgroup: u32, first_lane: u32) {
        let words = |buffer: &Words| native::Words {
            start: buffer.start,
            len: buffer.len,
        };
        let buffers: Vec<_> = buffers.iter().map(words).collect();
        // SAFETY: the caller vouches for it.
        let done = unsafe { self.0.run(&buffers, workgroup, first_lane, u64::MAX) };
        done.expect("kernels that ship end, and their buffers are those of their bindings");
    }
}
