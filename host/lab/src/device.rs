//! Opens the evaluators that the command line names.

use std::sync::atomic::Ordering;
use std::thread;

use oneiro::backend::{self, Options, Specialise};
use oneiro::background;
use oneiro::cpu::Cpu;
use oneiro::evaluator::{Device, Evaluator};
use oneiro::probe::Case;
use oneiro_base::console::Console;
use oneiro_base::exit::{Failure, Result};
use oneiro_shaders::Kernel;

use crate::engine::handle::{Closed, Engine};
use crate::engine::signals::stop_signal;
use crate::threads;

/// The device that evaluates.
#[derive(Clone, Debug)]
pub struct Backend {
    /// As given by `--backend`.
    pub name: String,
    pub options: Options,
}

/// The name of the device that answers at once, with which `oneiro device bench` measures the host.
pub const NULL: &str = "null";

/// Refuses it: it simulates nothing, so its answers must not be recorded or reported as fitness.
///
/// # Errors
/// Exit 3.
pub fn refuse_null(name: &str) -> Result {
    if name == NULL {
        return Err(Failure::input(format_args!(
            "--backend {NULL}: answers without simulating anything; allowed: with `oneiro device bench`, which throws its answers away"
        )));
    }
    Ok(())
}

/// Opens the evaluator of a device.
///
/// # Errors
/// Exit 3 for the device that answers at once; exit 4 if there is no such device, and the message lists those that exist.
pub fn open(backend: &Backend) -> Result<Box<dyn Evaluator>> {
    refuse_null(&backend.name)?;
    threads::prepare();
    Ok(backend::open(&backend.name, backend.options)?)
}

/// Like [`open`], and shared by all jobs of a command until the user stops it.
///
/// # Errors
/// As [`open`], and exit 75 if the user stops it before it is open.
pub fn engine(backend: &Backend) -> Result<Engine> {
    let (stop, backend) = (stop_signal()?, backend.clone());
    // A driver may take some time to compile.
    let opened = background::wait(|| stop.load(Ordering::Relaxed), move || open(&backend));
    let stopped = || Failure::stopped("stopped while the device was being opened; run the same command again");
    let evaluator = opened.unwrap_or_else(|| Err(stopped()))?;
    Ok(Engine::new(evaluator, stop))
}

/// Ends an engine, and prints its evaluator's warnings. Returns the fraction of the robot-steps that kernels specialised to their
/// worlds have simulated.
pub fn close(engine: Engine, console: Console) -> f64 {
    let Closed { warnings, specialised } = engine.close();
    console.warn(warnings);
    specialised
}

/// Disables Mesa's device-select layer: without a desktop it prints to standard error, and its order of adapters isn't
/// needed here. Call before starting any thread.
pub fn quiet_drivers() {
    if cfg!(feature = "gpu") {
        // SAFETY: this thread is the only one.
        unsafe { std::env::set_var("NODEVICE_SELECT", "1") };
    }
}

/// Name and details of a device, for messages.
pub fn name(evaluator: &dyn Evaluator) -> String {
    named(&evaluator.device())
}

/// The same of a device that runs a kernel.
pub fn name_for(evaluator: &dyn Evaluator, kernel: &'static Kernel) -> String {
    named(&evaluator.device_for(kernel))
}

fn named(device: &Device) -> String {
    let exact = if device.exact { "" } else { ", not exact" };
    format!("{} ({}{exact})", device.name, device.detail)
}

/// Prints a device's warnings, such as that it was lost and reopened. Its results are right nevertheless.
pub fn tell_warnings(evaluator: &dyn Evaluator, console: Console) {
    console.warn(evaluator.warnings());
}

/// Lane code with a single lane.
const SCALAR: &str = "scalarx1";

/// Whether a lane code is the checked scalar one, which traps NaN, infinities and other forbidden values. It is slow.
pub fn is_checked(lane_code: &str) -> bool {
    lane_code.starts_with("checked")
}

/// One device or instruction set of this machine, to compare with the others.
pub struct Candidate {
    /// Name, such as `cpu native256x16` or `llvmpipe (LLVM 15.0.6, 256 bits)`.
    pub name: String,
    /// Number of CPU threads; `None` for an adapter.
    pub threads: Option<usize>,
    /// Whether it is exact.
    pub exact: bool,
    way: Way,
}

enum Way {
    Cpu(&'static str),
    #[cfg(feature = "gpu")]
    Gpu(Box<oneiro::gpu::Adapter>),
}

impl Candidate {
    /// The scalar code, which all others are compared with.
    pub fn scalar(threads: usize) -> Self {
        Self::cpu(SCALAR, threads)
    }

    /// A lane code.
    pub fn cpu(lanes: &'static str, threads: usize) -> Self {
        Self {
            name: format!("cpu {lanes}"),
            threads: Some(threads),
            exact: true,
            way: Way::Cpu(lanes),
        }
    }

    /// The adapter, if it is one.
    #[cfg(feature = "gpu")]
    pub fn adapter(&self) -> Option<&oneiro::gpu::Adapter> {
        match &self.way {
            Way::Cpu(_) => None,
            Way::Gpu(adapter) => Some(adapter),
        }
    }

    /// Name of the lane code and number of threads, if it is the CPU.
    pub fn lanes(&self) -> Option<(&'static str, usize)> {
        match self.way {
            Way::Cpu(lanes) => Some((lanes, self.threads?)),
            #[cfg(feature = "gpu")]
            Way::Gpu(_) => None,
        }
    }

    /// Whether it is the scalar code.
    pub fn is_scalar(&self) -> bool {
        matches!(self.way, Way::Cpu(SCALAR))
    }

    /// Opens it to compute single operations or functions.
    ///
    /// # Errors
    /// Exit 4: it can't run the kernels.
    pub fn probe(&self) -> Result<Probe> {
        match &self.way {
            Way::Cpu(lanes) => Ok(Probe::Cpu(lanes)),
            #[cfg(feature = "gpu")]
            Way::Gpu(adapter) => Ok(Probe::Gpu(Box::new(oneiro::gpu::Gpu::open_with(
                adapter,
                path(adapter),
            )?))),
        }
    }

    /// Opens it without audits and without a fallback if it is lost. `chunk` is the maximum number of cycles in one dispatch.
    ///
    /// # Errors
    /// Exit 4: it can't run the kernels.
    pub fn open(&self, chunk: Option<u32>, specialise: Specialise) -> Result<Box<dyn Evaluator>> {
        Ok(match &self.way {
            Way::Cpu(lanes) => {
                let cpu = Cpu::new(self.threads)?.with_variant(lanes)?.with_specialise(specialise);
                Box::new(if let Some(cycles) = chunk {
                    cpu.with_chunk(cycles)
                } else {
                    cpu
                })
            }
            #[cfg(feature = "gpu")]
            Way::Gpu(adapter) => {
                let mut gpu = oneiro::gpu::Gpu::open_with(adapter, path(adapter))?;
                gpu.set_specialise(specialise);
                if let Some(cycles) = chunk {
                    gpu.set_bounds(oneiro::gpu::Bounds {
                        cycles,
                        ..oneiro::gpu::Bounds::default()
                    });
                }
                Box::new(gpu)
            }
        })
    }
}

/// A device that computes single operations or functions.
pub enum Probe {
    /// A lane code.
    Cpu(&'static str),
    /// An adapter.
    #[cfg(feature = "gpu")]
    Gpu(Box<oneiro::gpu::Gpu>),
}

impl Probe {
    /// Computes the cases: for each case one word per pair of operands.
    ///
    /// # Errors
    /// Exit 1 or 4: the device refuses a kernel, or is lost.
    pub fn compute(&mut self, cases: &[Case]) -> Result<Vec<Vec<u32>>> {
        match self {
            Self::Cpu(lanes) => cases.iter().map(|case| lanes_of(case, lanes)).collect(),
            #[cfg(feature = "gpu")]
            Self::Gpu(gpu) => {
                let run = |case: &Case| oneiro::gpu::Run {
                    kernel: case.kernel,
                    buffers: vec![
                        case.parameters.to_vec(),
                        case.left.clone(),
                        case.right.clone(),
                        vec![0; case.left.len()],
                    ],
                    workgroups: case.workgroups(),
                };
                let mut runs: Vec<_> = cases.iter().map(run).collect();
                gpu.run(&mut runs)?;
                Ok(runs.into_iter().filter_map(|mut run| run.buffers.pop()).collect())
            }
        }
    }
}

fn lanes_of(case: &Case, lanes: &str) -> Result<Vec<u32>> {
    let results = case.run(lanes);
    results.ok_or_else(|| Failure::device(format_args!("this CPU has no lane code {lanes} for {}", case.subject)))
}

/// The candidates that `which` names: `all`, `cpu`, `gpu` (every adapter, also software ones), `gpu:NAME` or
/// `gpu:INDEX`. Those of the CPU come first, each instruction set with one thread and with all.
///
/// # Errors
/// Exit 3 for the device that answers at once; exit 4: there is no such adapter, or no such name.
pub fn candidates(which: &str) -> Result<Vec<Candidate>> {
    candidates_with(which, &Cpu::variants())
}

/// The same, with these lane codes of the CPU, the fastest first.
///
/// # Errors
/// As [`candidates`].
pub fn candidates_with(which: &str, lane_codes: &[&'static str]) -> Result<Vec<Candidate>> {
    refuse_null(which)?;
    let mut candidates = Vec::new();
    if matches!(which, "all" | "cpu") {
        let all = thread::available_parallelism().map_or(1, usize::from);
        for &variant in lane_codes.iter().rev() {
            candidates.push(Candidate::cpu(variant, 1));
            if all > 1 {
                candidates.push(Candidate::cpu(variant, all));
            }
        }
    }
    match which.split_once(':') {
        _ if which == "cpu" => {}
        None if which == "all" => candidates.extend(adapters()),
        None if which == "gpu" => {
            candidates.extend(adapters());
            if candidates.is_empty() {
                return Err(Failure::device(
                    "there is no adapter here; install your card's Vulkan driver, or a software one (Debian and Ubuntu: \
                     mesa-vulkan-drivers)",
                ));
            }
        }
        Some(("gpu", name)) => candidates.push(adapter(name)?),
        _ => {
            return Err(Failure::device(format_args!(
                "no backend `{which}`; allowed: all, cpu, gpu, gpu:NAME, gpu:INDEX"
            )));
        }
    }
    Ok(candidates)
}

#[cfg(feature = "gpu")]
fn path(adapter: &oneiro::gpu::Adapter) -> oneiro::gpu::Path {
    if adapter.takes_spirv() {
        oneiro::gpu::Path::Spirv
    } else {
        oneiro::gpu::Path::Wgsl
    }
}

#[cfg(feature = "gpu")]
fn gpu(adapter: oneiro::gpu::Adapter) -> Candidate {
    let name = format!("{} ({})", adapter.name(), adapter.backend());
    Candidate {
        name,
        threads: None,
        exact: adapter.takes_spirv(),
        way: Way::Gpu(Box::new(adapter)),
    }
}

#[cfg(feature = "gpu")]
fn adapters() -> Vec<Candidate> {
    oneiro::gpu::adapters().into_iter().map(gpu).collect()
}

#[cfg(feature = "gpu")]
fn adapter(name: &str) -> Result<Candidate> {
    Ok(gpu(oneiro::gpu::find(&oneiro::gpu::Choice::Named(name.to_owned()))?))
}

/// The indices of the hardware adapters.
#[cfg(feature = "gpu")]
pub(crate) fn gpus_here() -> Vec<usize> {
    let here = oneiro::gpu::adapters().into_iter();
    let gpus = here.filter(|adapter| !adapter.is_software());
    gpus.map(|adapter| adapter.index()).collect()
}

/// There are none without the GPU feature.
#[cfg(not(feature = "gpu"))]
pub(crate) fn gpus_here() -> Vec<usize> {
    Vec::new()
}

#[cfg(not(feature = "gpu"))]
fn adapters() -> Vec<Candidate> {
    Vec::new()
}

#[cfg(not(feature = "gpu"))]
fn adapter(name: &str) -> Result<Candidate> {
    // The library's message says what is missing.
    Err(Failure::from(
        match backend::open(&format!("gpu:{name}"), Options::default()) {
            Err(error) => error,
            Ok(_) => oneiro::evaluator::Error::NoDevice(format!("gpu:{name} can't be compared in this build")),
        },
    ))
}
