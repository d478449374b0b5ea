//! Kernels that test the shader compiler, compiled as the real ones are: random ones from seeds, and
//! hand-written ones for what was hard. With each come its buffers before and after a dispatch, the latter found
//! by the compiler's interpreter, which knows neither masks nor lanes nor SPIR-V.

use oneiro_shaders::{Kernel, Variant, Words};

/// A kernel and what it must do.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// The kernel.
    pub kernel: &'static Kernel,
    /// Its buffers, by binding number.
    pub before: &'static [&'static [u32]],
    /// The same after a dispatch of [`WORKGROUPS`].
    pub after: &'static [&'static [u32]],
}

/// A kernel that differs from another by one mistake.
#[derive(Clone, Copy, Debug)]
pub struct Control {
    /// Which.
    pub mistake: &'static str,
    /// With the mistake.
    pub kernel: &'static Kernel,
    /// Without it.
    pub exact: &'static Kernel,
}

#[allow(clippy::unreadable_literal, clippy::large_const_arrays, reason = "generated")]
mod generated {
    use super::{Case, Control};
    include!(concat!(env!("OUT_DIR"), "/corpus.rs"));
}
pub use generated::*;

impl Case {
    /// The case of a kernel.
    pub fn of(kernel: &Kernel) -> Option<&'static Self> {
        CASES.iter().find(|case| case.kernel.name == kernel.name)
    }

    /// The buffers before, to be changed.
    pub fn buffers(&self) -> Vec<Vec<u32>> {
        self.before.iter().map(|words| words.to_vec()).collect()
    }

    /// Where buffers differ from what they must be: binding, word, found, expected.
    pub fn differences(&self, found: &[Vec<u32>]) -> Vec<(usize, usize, u32, u32)> {
        let mut all = Vec::new();
        for (binding, (found, expected)) in found.iter().zip(self.after).enumerate() {
            for (word, (found, expected)) in found.iter().zip(*expected).enumerate() {
                if found != expected {
                    all.push((binding, word, *found, *expected));
                }
            }
        }
        all
    }

    /// The buffers after a dispatch of a kernel with the same bindings, run by one of its variants.
    ///
    /// # Panics
    /// If this processor can't run the variant.
    pub fn run(&self, kernel: &Kernel, variant: &Variant) -> Vec<Vec<u32>> {
        assert!((variant.available)(), "{} does not run here", variant.name);
        let mut buffers = self.buffers();
        let words: Vec<_> = buffers
            .iter_mut()
            .map(|buffer| Words {
                start: buffer.as_mut_ptr(),
                len: buffer.len(),
            })
            .collect();
        for workgroup in 0..WORKGROUPS {
            for first_lane in (0..kernel.workgroup_size).step_by(variant.lanes as usize) {
                // SAFETY: the variant is available, and the buffers are whole, not empty, and used by this call only.
                unsafe { (variant.run)(&words, workgroup, first_lane) };
            }
        }
        buffers
    }
}
