//! Lane code: how the CPU runs kernels, many lanes at a time.

#[cfg_attr(
    not(all(feature = "native", any(target_arch = "x86_64", target_arch = "aarch64"))),
    path = "code/no_native.rs"
)]
mod native;

use oneiro_shaders::{Kernel, Variant, Words};

use crate::evaluator::Error;

/// Code of one kernel that this processor can run.
#[derive(Clone, Debug)]
pub(crate) enum LaneCode {
    /// Compiled with this program.
    Ahead(&'static Variant),
    /// Compiled at run time.
    Native(native::Code),
}

impl LaneCode {
    /// Names of a kernel's codes that this processor can run: those compiled with this program, widest first, and that
    /// compiled at run time.
    pub(crate) fn names(kernel: &'static Kernel) -> impl Iterator<Item = &'static str> {
        let native = native::is_available().then_some(native::NAME);
        ahead(kernel).map(|variant| variant.name).chain(native)
    }

    /// The code of a kernel with a name; `None` if this processor can't run one with that name.
    ///
    /// # Errors
    /// [`Error::NoDevice`] if it can't be compiled.
    pub(crate) fn named(kernel: &'static Kernel, name: &str) -> Result<Option<Self>, Error> {
        if name == native::NAME && native::is_available() {
            return Self::native(kernel).map(Some);
        }
        Ok(ahead(kernel).find(|variant| variant.name == name).map(Self::Ahead))
    }

    /// The code of a kernel that was compiled at run time.
    ///
    /// # Errors
    /// [`Error::NoDevice`] if it can't be compiled.
    pub(crate) fn native(kernel: &'static Kernel) -> Result<Self, Error> {
        native::compiled(kernel).map(Self::Native)
    }

    /// Number of lanes that a call runs.
    pub(crate) fn lanes(&self) -> u32 {
        match self {
            Self::Ahead(variant) => variant.lanes,
            Self::Native(code) => code.lanes(),
        }
    }

    /// Runs its lanes of one workgroup, from `first_lane` on.
    ///
    /// # Safety
    /// The buffers must be those of the kernel's bindings, in order, and not empty. All must be valid for reads, and
    /// those that the kernel writes for writes, for their whole length. What one call writes, no other may access at the
    /// same time.
    pub(crate) unsafe fn run(&self, buffers: &[Words], workgroup: u32, first_lane: u32) {
        match self {
            // SAFETY: the variant is available, and the caller vouches for the rest.
            Self::Ahead(variant) => unsafe { (variant.run)(buffers, workgroup, first_lane) },
            // SAFETY: the caller vouches for it.
            Self::Native(code) => unsafe { code.run(buffers, workgroup, first_lane) },
        }
    }
}

/// The lane codes compiled with this program that this processor can run.
pub(crate) fn ahead(kernel: &'static Kernel) -> impl Iterator<Item = &'static Variant> {
    kernel.variants.iter().filter(|variant| (variant.available)())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whoever builds for a processor that has machine code has it.
    #[test]
    fn machine_code_is_available() {
        let expected = cfg!(all(
            feature = "native",
            any(target_arch = "x86_64", target_arch = "aarch64")
        ));
        assert_eq!(native::is_available(), expected);
        let named = LaneCode::named(&oneiro_shaders::PROBE_NUMERICS, "native128x16").unwrap();
        assert_eq!(named.is_some(), expected);
        assert_eq!(named.map(|code| code.lanes()), expected.then_some(16));
    }
}
