//! Options of the device that evaluates.

use std::str::FromStr;

use clap::Args;
use oneiro::backend::{Options, Specialise};
use oneiro::evaluator::Evaluator;
use oneiro_base::exit::Result;
use oneiro_lab::device;
use oneiro_lab::engine::handle::Engine;

use super::numbers::{number, whole};

/// Fraction of a GPU's episodes to repeat on the CPU, 0 to 1
const RECHECK: f64 = 0.01;

/// Options of the device that evaluates.
#[derive(Args, Debug)]
pub(crate) struct Backend {
    /// auto (CPU; a bit-exact GPU for batches it would finish earlier), cpu, gpu, gpu:NAME, gpu:INDEX or pool (all)
    #[arg(id = "backend", long = "backend", value_name = "BACKEND", default_value = "auto")]
    pub(crate) name: String,
    /// CPU threads, 1 to 1024 [default: one per processor]
    #[arg(long, value_name = "N", value_parser = whole::<u16>(1..=1024))]
    pub(crate) threads: Option<u16>,
    /// Fraction of a GPU's episodes to repeat on the CPU, 0 to 1
    #[arg(long, value_name = "FRACTION", default_value_t = RECHECK, value_parser = number::<f64>(0.0..=1.0))]
    pub(crate) recheck: f64,
    /// Compile GPU kernels for this world: auto, always or never
    #[arg(long, value_name = "WHEN", default_value = "auto", value_parser = Specialise::from_str)]
    pub(crate) specialise: Specialise,
}

impl Backend {
    /// The device of a name, with the defaults of all options.
    pub(crate) fn named(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            threads: None,
            recheck: RECHECK,
            specialise: Specialise::default(),
        }
    }

    /// The device with these options.
    pub(crate) fn resolve(&self) -> device::Backend {
        device::Backend {
            name: self.name.clone(),
            options: Options {
                threads: self.threads.map(usize::from),
                audit_share: self.recheck,
                specialise: self.specialise,
                ..Options::default()
            },
        }
    }

    /// As [`device::open`].
    pub(crate) fn open(&self) -> Result<Box<dyn Evaluator>> {
        device::open(&self.resolve())
    }

    /// As [`device::engine`].
    pub(crate) fn engine(&self) -> Result<Engine> {
        device::engine(&self.resolve())
    }
}
