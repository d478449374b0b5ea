//! Evaluators by the names that users give on the command line.

use crate::devices::cpu::Cpu;
use crate::devices::pool::Pool;
pub use crate::devices::variants::Specialise;
use crate::evaluator::{Error, Evaluator};

/// Names that [`open`] accepts, for messages.
pub const BACKENDS: &str =
    "auto, cpu, cpu:LANES such as cpu:native512x16, gpu, gpu:NAME or index, pool, pool:A+B.. of these";

/// Options of a backend. They don't affect results.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Options {
    /// CPU threads; by default one per processor.
    pub threads: Option<usize>,
    /// Most cycles in one call of a kernel; by default chosen for speed and quick cancellation.
    pub chunk: Option<u32>,
    /// Fraction of a GPU's episodes, 0 to 1, that run again on the CPU for comparison. Ignored on GPUs that aren't exact.
    pub audit_share: f64,
    /// When kernels are specialised.
    pub specialise: Specialise,
}

/// Opens a backend:
///
/// - `cpu` is the processor, `cpu:LANES` one of its [lane codes](Cpu::variants);
/// - `gpu` is the best real GPU, `gpu:NAME` the adapter of that index or with that text in its name, which may be a
///   software one. A GPU that is lost is opened again once; after that the CPU takes over;
/// - `auto` is the CPU, or the best exact GPU for batches that it would finish earlier: [`Auto`](crate::auto::Auto);
/// - `pool` is the CPU and all exact real GPUs, `pool:A+B` any backends of these names.
///
/// ```
/// use oneiro::backend::{Options, open};
///
/// let evaluator = open("cpu", Options { threads: Some(2), ..Options::default() })?;
/// assert_eq!(evaluator.device().name, "cpu");
/// # Ok::<(), oneiro::evaluator::Error>(())
/// ```
///
/// # Errors
/// [`Error::NoDevice`]: an unknown backend, a missing device, or options that aren't allowed.
pub fn open(name: &str, options: Options) -> Result<Box<dyn Evaluator>, Error> {
    if !(0.0..=1.0).contains(&options.audit_share) {
        return Err(Error::NoDevice(format!(
            "an audited fraction of {}; allowed: 0 to 1",
            options.audit_share
        )));
    }
    let (kind, which) = match name.split_once(':') {
        Some((kind, which)) => (kind, Some(which.trim())),
        None => (name, None),
    };
    match (kind.trim(), which) {
        ("auto", None) => Ok(gpus::auto(cpu(options)?, options)),
        ("cpu", None) => Ok(Box::new(cpu(options)?)),
        ("cpu", Some(variant)) => Ok(Box::new(cpu(options)?.with_variant(variant)?)),
        ("gpu", which) => gpus::named(which, options),
        ("pool", None) => {
            let mut members: Vec<Box<dyn Evaluator>> = vec![Box::new(cpu(options)?)];
            members.extend(gpus::all(options));
            Ok(Box::new(Pool::new(members)?))
        }
        ("pool", Some(names)) => {
            let members = names.split('+').map(|name| match name.trim() {
                whole if whole == "auto" || whole.starts_with("pool") => Err(unknown(name)),
                name => open(name, options),
            });
            Ok(Box::new(Pool::new(members.collect::<Result<_, _>>()?)?))
        }
        _ => Err(unknown(name)),
    }
}

fn unknown(name: &str) -> Error {
    Error::NoDevice(format!("no backend `{name}`; allowed: {BACKENDS}"))
}

fn cpu(options: Options) -> Result<Cpu, Error> {
    let cpu = Cpu::new(options.threads)?.with_specialise(options.specialise);
    Ok(match options.chunk {
        Some(cycles) => cpu.with_chunk(cycles),
        None => cpu,
    })
}

#[cfg(feature = "gpu")]
mod gpus {
    use super::{Cpu, Error, Evaluator, Options, cpu};
    use crate::devices::audit::Audited;
    use crate::devices::auto::Auto;
    use crate::devices::gpu::{self, Bounds, Choice, Gpu, Recovering};

    /// Opens the adapter with an index or name, or the best real GPU.
    pub(super) fn named(which: Option<&str>, options: Options) -> Result<Box<dyn Evaluator>, Error> {
        let choice = which.map_or(Choice::Hardware, |name| Choice::Named(name.into()));
        guarded(Gpu::open(&choice)?, options)
    }

    /// Joins the CPU and the best real GPU, if there is one that may be exact.
    pub(super) fn auto(cpu: Cpu, options: Options) -> Box<dyn Evaluator> {
        let Some(adapter) = gpu::find(&Choice::Hardware).ok().filter(gpu::Adapter::takes_spirv) else {
            return Box::new(cpu);
        };
        let (threads, name) = (cpu.threads(), adapter.name().to_owned());
        let open = move || {
            let gpu = Gpu::open_with(&adapter, gpu::Path::Spirv).map_err(|error| error.to_string())?;
            match gpu.why_inexact() {
                None => guarded(gpu, options).map_err(|error| error.to_string()),
                Some(why) => Err(format!("it is not exact ({why})")),
            }
        };
        Box::new(Auto::new(Box::new(cpu), threads, name, Box::new(open)))
    }

    /// Opens all real GPUs that are exact.
    pub(super) fn all(options: Options) -> Vec<Box<dyn Evaluator>> {
        let adapters = gpu::adapters()
            .into_iter()
            .filter(|adapter| !adapter.is_software() && adapter.takes_spirv());
        let gpus = adapters.filter_map(|adapter| Gpu::open_with(&adapter, gpu::Path::Spirv).ok());
        gpus.filter(|gpu| gpu.device().exact)
            .filter_map(|gpu| guarded(gpu, options).ok())
            .collect()
    }

    /// Wraps a GPU: the CPU replaces it if it is lost, and its results are audited.
    fn guarded(mut gpu: Gpu, options: Options) -> Result<Box<dyn Evaluator>, Error> {
        if let Some(cycles) = options.chunk {
            gpu.set_bounds(Bounds {
                cycles: cycles.max(1),
                ..Bounds::default()
            });
        }
        gpu.set_specialise(options.specialise);
        let exact = gpu.device().exact;
        let recovering = Box::new(Recovering::new(gpu, Box::new(cpu(options)?)));
        if options.audit_share > 0.0 && exact {
            return Ok(Box::new(Audited::new(recovering, cpu(options)?, options.audit_share)));
        }
        Ok(recovering)
    }
}

/// Without the feature `gpu` there are none.
#[cfg(not(feature = "gpu"))]
mod gpus {
    use super::{Cpu, Error, Evaluator, Options};

    pub(super) fn named(_: Option<&str>, _: Options) -> Result<Box<dyn Evaluator>, Error> {
        let problem = "this program was built without GPUs (the feature `gpu`); allowed: auto, cpu, pool";
        Err(Error::NoDevice(problem.into()))
    }

    pub(super) fn auto(cpu: Cpu, _: Options) -> Box<dyn Evaluator> {
        Box::new(cpu)
    }

    pub(super) fn all(_: Options) -> Vec<Box<dyn Evaluator>> {
        Vec::new()
    }
}
