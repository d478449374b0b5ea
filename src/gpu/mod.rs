//! Batches on a GPU, through wgpu. Nothing outside this module names it.

mod adapter;
mod buffers;
mod device;
mod dispatch;
mod pace;
mod recovery;
mod run;
mod spirv;

pub use adapter::{Adapter, Choice, FloatControls, Limits, adapters, find};
pub use device::Path;
pub use dispatch::Bounds;
pub use recovery::Recovering;

use device::{Device, Fault};
use dispatch::Lives;

use crate::batch::Part;
use crate::evaluator::{self, Control, Error, Evaluator, PartResult};

/// One GPU, real or not.
#[derive(Debug)]
pub struct Gpu {
    device: Device,
    lives: Lives,
    exact: bool,
}

impl Gpu {
    /// Opens an adapter, with the exact kernels where it takes them.
    ///
    /// # Errors
    /// [`Error::NoDevice`] if there is no such adapter, or it can't run the kernels.
    pub fn open(choice: &Choice) -> Result<Self, Error> {
        let adapter = find(choice)?;
        let path = if adapter.takes_spirv() { Path::Spirv } else { Path::Wgsl };
        Self::open_with(&adapter, path)
    }

    /// Opens an adapter on a path of one's choice.
    ///
    /// # Errors
    /// [`Error::NoDevice`] if the adapter can't run the kernels, or not on this path.
    pub fn open_with(adapter: &Adapter, path: Path) -> Result<Self, Error> {
        let mut gpu = Self {
            device: Device::open(adapter, path)?,
            lives: Lives::default(),
            exact: false,
        };
        gpu.exact = path == Path::Spirv;
        Ok(gpu)
    }

    /// Opens a lost device again.
    ///
    /// # Errors
    /// [`Error::NoDevice`] if it is gone for good.
    pub(crate) fn reopen(&self) -> Result<Self, Error> {
        // A driver that was reset may refuse whatever was made before, so everything is made anew.
        let old = self.device.adapter();
        let is_same = |a: &Adapter| a.name() == old.name() && a.backend() == old.backend();
        let mut found: Vec<_> = adapters().into_iter().filter(is_same).collect();
        found.sort_by_key(|a| a.index().abs_diff(old.index()));
        let adapter = found
            .first()
            .ok_or_else(|| Error::NoDevice(format!("{} is no longer there", old.name())))?;
        let mut gpu = Self::open_with(adapter, self.device.path())?;
        gpu.lives.bounds = self.lives.bounds;
        gpu.device.doom = self.device.doom.next();
        Ok(gpu)
    }

    /// The adapter it runs on.
    pub fn adapter(&self) -> &Adapter {
        self.device.adapter()
    }

    /// Bounds each dispatch more than time and memory do.
    pub fn set_bounds(&mut self, bounds: Bounds) {
        self.lives.bounds = bounds;
    }

    /// Loses the device after so many more dispatches, and as many devices in all (each re-created one after
    /// as many dispatches). For tests of what happens then.
    #[doc(hidden)]
    pub fn lose_after(&mut self, dispatches: u32, devices: u32) {
        self.device.doom = device::Doom::after(dispatches, devices);
    }

    fn error(&self, fault: Fault) -> Error {
        let device = self.adapter().name().to_owned();
        match fault {
            Fault::Cancelled => Error::Cancelled,
            Fault::Lost(reason) => Error::Lost { device, reason },
            Fault::OutOfMemory => Error::TooLarge(format!("{device}: not even 64 rollouts fit into its memory")),
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
            exact: self.exact,
        }
    }

    fn evaluate_part(&mut self, part: &Part<'_>, control: &Control) -> Result<PartResult, Error> {
        loop {
            match self.lives.run(&mut self.device, part, control) {
                Ok(result) => return Ok(result),
                Err(Fault::OutOfMemory) if self.lives.shrink(part) => {}
                Err(fault) => return Err(self.error(fault)),
            }
        }
    }
}
