//! Runs batches on a GPU through wgpu. Nothing outside this module names wgpu.

mod adapter;
mod buffers;
#[cfg(any(windows, target_os = "linux", target_os = "android", target_os = "freebsd"))]
mod compiler;
#[cfg(feature = "compose")]
mod cost;
mod device;
mod dispatch;
mod pace;
mod recovery;
mod run;
#[cfg(feature = "compose")]
mod specialised;
#[cfg(not(feature = "compose"))]
#[path = "unspecialised.rs"]
mod specialised;
mod spirv;
mod trust;

pub use adapter::{Adapter, Choice, FloatControls, Limits, adapters, find};
#[cfg(any(windows, target_os = "linux", target_os = "android", target_os = "freebsd"))]
pub use compiler::{Compiled, Compiler};
#[cfg(feature = "compose")]
pub use cost::{Cost, Line, buffers, cost};
pub use device::Path;
pub use dispatch::Bounds;
#[cfg(feature = "compose")]
pub use oneiro_shader_compiler::count::{Class, Counted};
pub use recovery::Recovering;
pub use run::Run;
#[cfg(feature = "compose")]
pub use specialised::specialised;

use oneiro_shaders::episode::Group;

use device::{Device, Fault};
use dispatch::Dispatcher;

use crate::batch::{Part, PartResult};
use crate::devices::variants::Specialise;
use crate::evaluator::{self, Control, Error, Evaluator};

/// Groups of a world that keep a device busy by themselves.
const GROUPS_OF_A_WORLD: usize = 16;

/// Whether a batch's worlds are simulated one after the other, each by its variant of the kernel. Their groups lie together.
fn divides(when: Specialise, groups: &[Group]) -> bool {
    let worlds = groups.chunk_by(|a, b| a.world == b.world).count();
    match when {
        Specialise::Always => true,
        Specialise::Auto => groups.len() >= GROUPS_OF_A_WORLD * worlds,
        Specialise::Never => false,
    }
}

/// One GPU, real or not.
#[derive(Debug)]
pub struct Gpu {
    device: Device,
    dispatcher: Dispatcher,
    inexact: Option<String>,
}

impl Gpu {
    /// Opens an adapter, with the exact kernels if it accepts them.
    ///
    /// # Errors
    /// [`Error::NoDevice`] if there is no such adapter, or it can't run the kernels.
    pub fn open(choice: &Choice) -> Result<Self, Error> {
        let adapter = find(choice)?;
        let path = if adapter.takes_spirv() { Path::Spirv } else { Path::Wgsl };
        Self::open_with(&adapter, path)
    }

    /// Opens an adapter with kernels in the given form.
    ///
    /// # Errors
    /// [`Error::NoDevice`] if the adapter can't run the kernels, or not in this form.
    pub fn open_with(adapter: &Adapter, path: Path) -> Result<Self, Error> {
        let mut gpu = Self {
            device: Device::open(adapter, path)?,
            dispatcher: Dispatcher::default(),
            inexact: None,
        };
        if !adapter.is_software() {
            specialised::expect_gpu_compiler(&mut gpu.dispatcher.variants);
        }
        gpu.inexact = trust::verdict(&mut gpu)?;
        Ok(gpu)
    }

    /// Reopens a lost device.
    ///
    /// # Errors
    /// [`Error::NoDevice`] if it is gone for good.
    pub(crate) fn reopen(&self) -> Result<Self, Error> {
        // After a reset, a driver may refuse everything made before, so all of it is made again.
        let old = self.device.adapter();
        let is_same = |a: &Adapter| a.name() == old.name() && a.backend() == old.backend();
        let mut found: Vec<_> = adapters().into_iter().filter(is_same).collect();
        found.sort_by_key(|a| a.index().abs_diff(old.index()));
        let adapter = found
            .first()
            .ok_or_else(|| Error::NoDevice(format!("{} is no longer there", old.name())))?;
        let mut gpu = Self::open_with(adapter, self.device.path())?;
        gpu.dispatcher.bounds = self.dispatcher.bounds;
        gpu.dispatcher.variants.when = self.dispatcher.variants.when;
        gpu.device.doom = self.device.doom.next();
        Ok(gpu)
    }

    /// Adapter that it runs on.
    pub fn adapter(&self) -> &Adapter {
        self.device.adapter()
    }

    /// Reason why its results aren't exact, or `None` if they are: if it runs the exact kernels, and all of their
    /// operations and functions had the CPU's bits when it was opened.
    pub fn why_inexact(&self) -> Option<&str> {
        self.inexact.as_deref()
    }

    /// Sets limits on each dispatch, besides those of time and memory.
    pub fn set_bounds(&mut self, bounds: Bounds) {
        self.dispatcher.bounds = bounds;
    }

    /// Sets when kernels are specialised.
    pub fn set_specialise(&mut self, when: Specialise) {
        self.dispatcher.variants.when = when;
    }

    /// Loses the device after a number of dispatches, and `devices` devices in all, each replacement after as many
    /// dispatches. For tests of recovery.
    #[doc(hidden)]
    pub fn lose_after(&mut self, dispatches: u32, devices: u32) {
        self.device.doom = device::Doom::after(dispatches, devices);
    }

    /// Requests other modes than all that the driver has, to show their effect in tests.
    #[doc(hidden)]
    pub fn ask_for(&mut self, float_controls: FloatControls) {
        self.device.ask_for(float_controls);
    }

    fn error(&self, fault: Fault) -> Error {
        let device = self.adapter().name().to_owned();
        match fault {
            Fault::Cancelled => Error::Cancelled,
            Fault::Lost(reason) => Error::Lost { device, reason },
            Fault::OutOfMemory => Error::TooLarge(format!("{device}: not even 64 episodes fit into its memory")),
            Fault::TooLarge(problem) => Error::TooLarge(format!("{device}: {problem}")),
            Fault::Refused(problem) => Error::NoDevice(format!("{device} refuses the kernel: {problem}")),
        }
    }
}

impl Evaluator for Gpu {
    fn device(&self) -> evaluator::Device {
        let adapter = self.adapter();
        evaluator::Device {
            name: adapter.name().to_owned(),
            detail: adapter.driver(),
            exact: self.inexact.is_none(),
        }
    }

    fn evaluate_part(&mut self, part: &Part<'_>, control: &Control) -> Result<PartResult, Error> {
        self.dispatcher
            .run(&mut self.device, part, control)
            .map_err(|fault| self.error(fault))
    }

    fn warnings(&self) -> &[String] {
        &self.dispatcher.variants.problems
    }

    fn specialised_steps(&self) -> u64 {
        self.dispatcher.variants.steps
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::batch::{Batch, Rollout};
    use crate::devices::cpu::Cpu;
    use crate::random::Key;
    use crate::world::{World, WorldSpec};

    #[test]
    fn smaller_cuts_when_memory_runs_out() {
        let world = World::new(WorldSpec {
            cycles: 20,
            ..WorldSpec::miglino1995()
        })
        .expect("a good world");
        let genes = [1.0; 18];
        let rollout = |index| Rollout {
            world: 0,
            genes: &genes,
            key: Key::rollout(0, 0, index, 0),
        };
        let batch = |rollouts| {
            let rollouts: Vec<_> = (0..rollouts).map(rollout).collect();
            Batch::new(std::slice::from_ref(&world), &rollouts, None).expect("a good batch")
        };
        let mut gpu = Gpu::open(&Choice::Best).expect("these tests need an adapter");

        let control = Control::new();
        gpu.device.pretend_out_of_memory();
        let there = gpu.evaluate(&batch(200), &control).expect("it fits after all");
        let here = Cpu::new(Some(1))
            .expect("a CPU")
            .evaluate(&batch(200), &Control::new())
            .expect("a result");
        assert_eq!(there.fitness, here.fitness);
        assert_eq!(control.steps(), 200 * 20);

        gpu.device.pretend_out_of_memory();
        assert!(
            matches!(gpu.evaluate(&batch(64), &control), Err(Error::TooLarge(_))),
            "64 can't be cut"
        );
        assert_eq!(control.steps(), 200 * 20);
        assert!(gpu.evaluate(&batch(64), &control).is_ok());
    }
}
