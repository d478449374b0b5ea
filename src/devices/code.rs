//! Lane code: kernels as the CPU runs them, many lanes at a time.

#[cfg_attr(not(feature = "compose"), path = "code/absent.rs")]
mod interpreted;
#[allow(clippy::duplicate_mod, reason = "what is absent is absent alike")]
#[cfg_attr(
    not(all(
        feature = "native",
        any(target_arch = "x86_64", target_arch = "aarch64", target_family = "wasm")
    )),
    path = "code/absent.rs"
)]
mod native;

#[cfg_attr(
    not(all(feature = "native", any(target_arch = "x86_64", target_arch = "aarch64"))),
    path = "code/unspecialised.rs"
)]
mod specialised;

use oneiro_shaders::{Kernel, Variant, Words};

pub(crate) use specialised::Specialised;

use crate::evaluator::Error;

/// Code of one kernel that this processor can run.
#[derive(Clone, Debug)]
pub(crate) enum LaneCode {
    /// Compiled with this program.
    Ahead(&'static Variant),
    /// Compiled at run time.
    Native(native::Code),
    /// Not compiled.
    Interpreted(interpreted::Code),
}

/// The name of the interpreter, among those of lane codes.
pub(crate) fn interpreter() -> Option<&'static str> {
    interpreted::is_available().then_some(interpreted::NAME)
}

impl LaneCode {
    /// A kernel's lane codes that this processor can run, by name and number of lanes: first those with several lanes that were
    /// compiled ahead, then the one compiled at run time, then those with one lane. The interpreter isn't among them.
    pub(crate) fn all(kernel: &'static Kernel) -> impl Iterator<Item = (&'static str, u32)> {
        let ahead = |is_wide: bool| {
            let variants = ahead(kernel).filter(move |variant| (variant.lanes > 1) == is_wide);
            variants.map(|variant| (variant.name, variant.lanes))
        };
        ahead(true).chain(native::all()).chain(ahead(false))
    }

    /// The narrower code that is the fastest for so few episodes, if it is faster than this one. `cost` estimates the time of one call from
    /// a code's name and its number of lanes.
    pub(crate) fn for_few(&self, kernel: &'static Kernel, rollouts: usize, cost: fn(&str, u32) -> f32) -> Option<Self> {
        let time = |(name, lanes): (&str, u32)| rollouts.div_ceil(lanes as usize) as f32 * cost(name, lanes);
        let narrower = Self::all(kernel).filter(|(_, lanes)| *lanes < self.lanes());
        let best = narrower.min_by(|a, b| time(*a).total_cmp(&time(*b)))?;
        let own = (self.name(), self.lanes());
        (time(best) < time(own)).then(|| Self::named(kernel, best.0).ok()?)?
    }

    fn name(&self) -> &'static str {
        match self {
            Self::Ahead(variant) => variant.name,
            Self::Native(code) => code.name(),
            Self::Interpreted(code) => code.name(),
        }
    }

    /// Returns a kernel's lane code by name; `None` if this processor can't run one with that name.
    ///
    /// # Errors
    /// [`Error::NoDevice`] if it can't be compiled.
    pub(crate) fn named(kernel: &'static Kernel, name: &str) -> Result<Option<Self>, Error> {
        if let Some(code) = native::named(kernel, name) {
            return code.map(Self::Native).map(Some);
        }
        if interpreter() == Some(name) {
            return interpreted::compiled(kernel).map(Self::Interpreted).map(Some);
        }
        Ok(ahead(kernel).find(|variant| variant.name == name).map(Self::Ahead))
    }

    /// Compiles a kernel at run time, or prepares to interpret it where it can't be compiled.
    ///
    /// # Errors
    /// [`Error::NoDevice`] if neither is possible.
    pub(crate) fn composed(kernel: &'static Kernel) -> Result<Self, Error> {
        match native::best(kernel) {
            Ok(code) => Ok(Self::Native(code)),
            Err(_) if interpreted::is_available() => interpreted::compiled(kernel).map(Self::Interpreted),
            Err(error) => Err(error),
        }
    }

    /// Prepares to interpret a kernel and to check each of its operations.
    ///
    /// # Errors
    /// [`Error::NoDevice`] if this program has no interpreter.
    pub(crate) fn checked(kernel: &'static Kernel) -> Result<Self, Error> {
        interpreted::checked(kernel).map(Self::Interpreted)
    }

    /// Number of lanes that a call runs.
    pub(crate) fn lanes(&self) -> u32 {
        match self {
            Self::Ahead(variant) => variant.lanes,
            Self::Native(code) => code.lanes(),
            Self::Interpreted(code) => code.lanes(),
        }
    }

    /// Runs its lanes of one workgroup, from `first_lane` on. Its loops may take `turns` turns in all, unless it was compiled
    /// ahead of time.
    ///
    /// # Errors
    /// [`Error::Unbounded`] if they take more.
    ///
    /// # Safety
    /// The buffers must be those of the kernel's bindings, in order, and not empty. All must be valid for reads for their
    /// whole length, and those that the kernel writes also for writes. While a call runs, no other may access the words that
    /// it writes.
    pub(crate) unsafe fn run(
        &self,
        buffers: &[Words],
        workgroup: u32,
        first_lane: u32,
        turns: u64,
    ) -> Result<(), Error> {
        match self {
            // SAFETY: the variant is available; the caller guarantees the rest.
            Self::Ahead(variant) => unsafe { (variant.run)(buffers, workgroup, first_lane) },
            // SAFETY: the caller guarantees it.
            Self::Native(code) => return unsafe { code.run(buffers, workgroup, first_lane, turns) },
            // SAFETY: the caller guarantees it.
            Self::Interpreted(code) => return unsafe { code.run(buffers, workgroup, first_lane, turns) },
        }
        Ok(())
    }
}

/// Why a kernel is interpreted, though this processor could run code compiled at run time.
pub(crate) fn interpreted_because(kernel: &'static Kernel) -> Option<String> {
    native::problem(kernel).filter(|_| interpreted::is_available())
}

/// Whether kernels composed at run time are interpreted, since they can't be compiled.
pub(crate) fn interprets() -> bool {
    interpreted::is_available() && native::all().next().is_none()
}

/// The lane codes compiled with this program that this processor can run.
fn ahead(kernel: &'static Kernel) -> impl Iterator<Item = &'static Variant> {
    kernel.variants.iter().filter(|variant| (variant.available)())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// It is available in every build for a processor that code can be generated for.
    #[test]
    fn machine_code_is_available() {
        let expected = cfg!(all(
            feature = "native",
            any(target_arch = "x86_64", target_arch = "aarch64")
        ));
        assert_eq!(native::all().next().is_some(), expected);
        let named = LaneCode::named(&oneiro_shaders::PROBE_NUMERICS, "native128x16").unwrap();
        assert_eq!(named.map(|code| code.lanes()), expected.then_some(16));
    }
}
