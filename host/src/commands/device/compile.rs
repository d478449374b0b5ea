//! `oneiro device compile`: compiles an experiment's kernel at the full width of this machine, by a Rust toolchain.

use std::time::{Duration, Instant};

use oneiro::ahead::{self, Compiled, Error, Toolchain, ToolchainError};
use oneiro::backend::Specialise;
use oneiro::batch::{Outcome, TraceRequest, Worlds};
use oneiro::cpu::Cpu;
use oneiro::evaluator::{Control, Evaluator};
use oneiro_base::answer::Answer;
use oneiro_base::console::{Console, columns};
use oneiro_base::exit::{Code, Failure, Result};
use oneiro_lab::runs;
use oneiro_lab::workload;
use serde_json::json;

use crate::cli::DeviceCompile;

/// The lane code that new code is compared with: that compiled at run time.
const REFERENCE: &str = "native128x16";

/// Lives that are compared. They fill the widest vectors several times.
const LIVES: u32 = 256;
/// Most cycles of them, and most robot-steps: a fraction of a second.
const CYCLES: u32 = 1_000;
const STEPS: u64 = 2_000_000;
/// Of these, cycles of which every number is compared.
const TRACED: u32 = 32;
/// Times that each code is timed, of which the fastest counts.
const TURNS: usize = 3;

/// Compiles the kernel, unless the cache has it.
pub(crate) fn run(arguments: &DeviceCompile, console: Console) -> Result {
    let experiment = runs::read(&arguments.experiment, &arguments.set)?;
    console.warn(experiment.warnings());
    let worlds = experiment.sample()?;
    let kernel = worlds.kernel().name;
    if ahead::ships(&worlds) {
        let message = format!(
            "{kernel}, the kernel of {}, ships with this program: there is nothing to compile",
            experiment.name()
        );
        return console.print_answer(&Answer {
            messages: vec![message],
            ..Answer::new("", json!({ "kernel": kernel, "ships": true }))
        });
    }
    let toolchain = Toolchain::find().map_err(|error| Failure::of(code(&error), error))?;
    let known = ahead::compiled(&worlds).filter(|known| known.rust == toolchain.version() && !arguments.again);
    let mut report = Report {
        kernel,
        seconds: None,
        rates: Vec::new(),
    };
    let compiled = if let Some(known) = known {
        report.check(&worlds, &known, console)?;
        known
    } else {
        console.say(format!(
            "compiling {kernel} with Rust {}: about ten seconds",
            toolchain.version()
        ));
        let begin = Instant::now();
        let check = |new: &Compiled| {
            report.seconds = Some(begin.elapsed());
            report.check(&worlds, new, console)
        };
        ahead::compile(&worlds, &toolchain, check).map_err(|error| match error {
            Error::Check(failure) => failure,
            Error::Toolchain(error) => Failure::of(code(&error), error),
            Error::Machine(problem) => Failure::device(problem),
            other @ (Error::Ships(_) | Error::NoCache) => Failure::input(other),
        })?
    };
    console.print_answer(&report.answer(&compiled))
}

/// The exit code of what a toolchain failed at.
fn code(error: &ToolchainError) -> Code {
    match error {
        ToolchainError::Missing(..) | ToolchainError::Unknown(_) | ToolchainError::TooOld(..) => Code::Input,
        ToolchainError::Narrow | ToolchainError::Arrays(_) => Code::Device,
        ToolchainError::Failed(..) | ToolchainError::Library(_) => Code::Failed,
        ToolchainError::Storage(_) => Code::Storage,
    }
}

/// What the code does, compared with that compiled at run time.
struct Report {
    kernel: &'static str,
    /// How long compiling took; `None` if the cache had the code.
    seconds: Option<Duration>,
    /// Robot-steps per second on one thread of each lane code.
    rates: Vec<(&'static str, f64)>,
}

impl Report {
    /// Compares lives of all new lane code with those of [`REFERENCE`], and times both.
    ///
    /// # Errors
    /// Exit 1: a bit differs. Exit 4: code can't be run.
    fn check(&mut self, worlds: &Worlds, compiled: &Compiled, console: Console) -> Result {
        console.say(format!("comparing {LIVES} episodes of random genomes with {REFERENCE}"));
        let genomes: Vec<_> = (0..LIVES)
            .map(|index| workload::genome(worlds.genes()[0], 1.0, 1, index))
            .collect();
        let rollouts = workload::rollouts(&genomes);
        let of = |cycles: u32, trace: Option<TraceRequest>| worlds.stretch(&rollouts, 0..cycles, &[], trace);
        let traced = of(TRACED, Some(TraceRequest { every: 1 }))?;
        let affordable = STEPS * u64::from(TRACED) / traced.steps().max(1);
        let timed = of(affordable.clamp(1, CYCLES.into()) as u32, None)?;
        let cpu = |name: &str| -> Result<Cpu> {
            Ok(Cpu::new(Some(1))?
                .with_variant(name)?
                .with_specialise(Specialise::Never))
        };
        let lived = |name: &str| -> Result<[Outcome; 2]> {
            let mut cpu = cpu(name)?;
            let first = cpu.evaluate(&traced, &Control::new())?;
            Ok([first, cpu.evaluate(&timed, &Control::new())?])
        };
        let [first, whole] = lived(REFERENCE)?;
        for &name in &compiled.lane_codes {
            let [own_first, own] = lived(name)?;
            if !is_same(&own_first, &first) || !is_same(&own, &whole) {
                return Err(Failure::failed(format_args!(
                    "{name}, compiled with Rust {}, has other bits than {REFERENCE} for {}, and is not kept. This is a mistake in \
                     Oneiro or in the toolchain: please report it with the experiment",
                    compiled.rust, self.kernel
                )));
            }
        }
        for &name in [REFERENCE].iter().chain(&compiled.lane_codes) {
            let mut cpu = cpu(name)?;
            let mut fastest = f64::INFINITY;
            for _ in 0..TURNS {
                let begin = Instant::now();
                cpu.evaluate(&timed, &Control::new())?;
                fastest = fastest.min(begin.elapsed().as_secs_f64());
            }
            self.rates.push((name, timed.steps() as f64 / fastest));
        }
        Ok(())
    }

    fn answer(&self, compiled: &Compiled) -> Answer {
        let rates: Vec<_> = self
            .rates
            .iter()
            .map(|(name, rate)| json!({ "lane_code": name, "steps_per_second": rate }))
            .collect();
        let value = json!({
            "kernel": self.kernel,
            "ships": false,
            "lane_codes": compiled.lane_codes,
            "rust": compiled.rust,
            "bytes": compiled.bytes,
            "seconds": self.seconds.map(|seconds| seconds.as_secs_f64()),
            "lives_compared": LIVES,
            "one_thread": rates,
        });
        let made = self.seconds.map_or_else(
            || "was compiled before".to_owned(),
            |seconds| format!("is compiled, in {:.0} s", seconds.as_secs_f64()),
        );
        let reference = self.rates.first().map_or(1.0, |(_, rate)| *rate);
        let rows: Vec<_> = self
            .rates
            .iter()
            .map(|(name, rate)| {
                vec![
                    (*name).to_owned(),
                    format!("{:.1}", rate / 1e6),
                    format!("{:.2}", rate / reference),
                ]
            })
            .collect();
        let text = format!(
            "{} {made}, with Rust {}: {} kB. Commands on this machine use it automatically.\n\
             {LIVES} episodes of random genomes have the same bits as by {REFERENCE}.\n\n{}",
            self.kernel,
            compiled.rust,
            compiled.bytes.div_ceil(1_000),
            columns(&["lane code", "M steps/s on one thread", "times"], &rows)
        );
        Answer::new(text, value)
    }
}

/// Whether two outcomes of a batch are the same, bit for bit.
fn is_same(a: &Outcome, b: &Outcome) -> bool {
    let bits = |outcome: &Outcome| outcome.fitness.iter().map(|own| own.to_bits()).collect::<Vec<_>>();
    bits(a) == bits(b) && a.traces == b.traces && a.logs == b.logs && a.states == b.states
}
