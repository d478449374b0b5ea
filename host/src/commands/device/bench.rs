//! `oneiro device bench`: robot-steps per second of each instruction set and adapter of this machine, of the 1995 paper's Khepera or of an
//! experiment, or individuals per second of its host.

mod host;
mod null;

use std::fmt::Write;
use std::path::Path;
use std::time::{Duration, Instant};

use oneiro::backend::Specialise;
use oneiro::batch::{Batch, Worlds};
use oneiro::cpu::Cpu;
use oneiro::evaluator::{Control, Evaluator};
use oneiro::world::{World, WorldSpec};
use oneiro_base::answer::Answer;
use oneiro_base::console::counted;
use oneiro_base::console::{Console, columns};
use oneiro_base::exit::{Failure, Result};
use oneiro_base::files;
use oneiro_base::plain;
use oneiro_lab::device::{self, Candidate};
use oneiro_lab::runs;
use oneiro_lab::workload;
use serde_json::{Value, json};

use super::list;
use crate::cli::DeviceBench;

/// How long a GPU is kept busy before it is timed. An idle H100 is slow for 5 ms.
const WAKING: Duration = Duration::from_millis(20);

/// Batch sizes, and the time to measure each.
pub(crate) struct Plan {
    /// Rollouts per batch.
    pub(crate) sizes: Vec<u32>,
    /// Batches that are expected to take longer are left out.
    pub(crate) longest: Duration,
    /// The same limit for the reference, about which longer batches say nothing new.
    pub(crate) longest_of_reference: Duration,
    /// Approximate time for all repetitions of one batch size on all devices.
    pub(crate) whole: Duration,
    /// Fewest and most repetitions.
    pub(crate) repetitions: (usize, usize),
    /// When kernels of GPUs are specialised.
    pub(crate) specialise: Specialise,
}

impl Plan {
    /// Takes some minutes.
    fn thorough() -> Self {
        Self {
            sizes: vec![1000, 10_000, 100_000, 1_000_000],
            longest: Duration::from_secs(12),
            longest_of_reference: Duration::from_secs(2),
            whole: Duration::from_secs(25),
            repetitions: (3, 100),
            specialise: Specialise::Auto,
        }
    }

    /// Takes some seconds.
    pub(crate) fn quick() -> Self {
        Self {
            sizes: vec![1000, 10_000],
            longest: Duration::from_secs(4),
            longest_of_reference: Duration::from_secs(1),
            whole: Duration::from_secs(3),
            repetitions: (3, 100),
            specialise: Specialise::Auto,
        }
    }
}

/// What is timed: the beginnings of lives of random genomes in one world.
pub(crate) struct Timed {
    worlds: Worlds,
    /// Cycles of each life, at most [`workload::CYCLES`], so that long lives don't take minutes.
    cycles: u32,
    /// What the table says of it.
    text: String,
    /// What `--json` says of it.
    names: [(&'static str, String); 2],
    /// The lane codes of its kernel, the fastest first. The last is the measure of all others.
    lane_codes: Vec<&'static str>,
}

impl Timed {
    /// The 1995 paper's Khepera.
    pub(crate) fn khepera() -> Result<Self> {
        let world = World::new(WorldSpec {
            cycles: workload::CYCLES,
            ..WorldSpec::miglino1995()
        })?;
        let worlds = Worlds::new(std::slice::from_ref(&world))?;
        let text = "Khepera, 8-2 perceptron with random genes, arena miglino1995, no noise".to_owned();
        let names = [
            ("world", "miglino1995".to_owned()),
            ("controller", "perceptron".to_owned()),
        ];
        Self::of(worlds, text, names)
    }

    /// An experiment's file.
    ///
    /// # Errors
    /// Exit 3: it isn't valid, or no experiment of lives in one world.
    fn experiment(path: &Path, set: &[String], console: Console) -> Result<Self> {
        let experiment = runs::read(path, set)?;
        console.warn(experiment.warnings());
        let worlds = experiment.sample()?;
        let text = format!("{}, random genes", path.display());
        let names = [
            ("experiment", experiment.name().to_owned()),
            ("kernel", worlds.kernel().name.to_owned()),
        ];
        Self::of(worlds, text, names)
    }

    fn of(worlds: Worlds, text: String, names: [(&'static str, String); 2]) -> Result<Self> {
        let mut lane_codes = Cpu::variants_for(&worlds);
        lane_codes.retain(|name| !device::is_checked(name));
        let mut timed = Self {
            worlds,
            cycles: workload::CYCLES,
            text,
            names,
            lane_codes,
        };
        timed.cycles = timed.batch(1)?.cycles().end;
        Ok(timed)
    }

    /// Its narrowest lane code, on one thread: the scalar code, or that compiled at run time.
    fn reference(&self) -> Option<(&'static str, usize)> {
        Some((self.lane_codes.last()?, 1))
    }

    /// The candidates to time: those of `--backend`, and the reference.
    ///
    /// # Errors
    /// Exit 4: there is no such device.
    pub(crate) fn candidates(&self, which: &str) -> Result<Vec<Candidate>> {
        let mut candidates = device::candidates_with(which, &self.lane_codes)?;
        if let Some((lanes, threads)) = self.reference()
            && !candidates.iter().any(|own| own.lanes() == Some((lanes, threads)))
        {
            candidates.insert(0, Candidate::cpu(lanes, threads));
        }
        Ok(candidates)
    }

    /// Lives of random genes from -1 to 1.
    fn batch(&self, rollouts: u32) -> Result<Batch> {
        let genes = self.worlds.genes()[0];
        let genomes: Vec<Vec<f32>> = (0..rollouts)
            .map(|index| workload::genome(genes, 1.0, 1, index))
            .collect();
        let rollouts = workload::rollouts(&genomes);
        Ok(self.worlds.beginnings(&rollouts, self.cycles)?)
    }
}

/// The speed of one device with one batch size.
#[derive(Clone, Debug, serde::Serialize)]
pub(crate) struct Cell {
    pub(crate) device: String,
    pub(crate) threads: Option<usize>,
    pub(crate) exact: bool,
    pub(crate) rollouts: u32,
    pub(crate) robot_steps: u64,
    /// Median of the repetitions.
    pub(crate) seconds: f64,
    pub(crate) repetitions: usize,
    pub(crate) steps_per_second: f64,
    /// Share of the steps that a kernel specialised to the world has simulated.
    pub(crate) specialised: f64,
    /// Speed relative to the narrowest lane code on one thread, at the same batch size, or at the largest that it ran.
    pub(crate) ratio: Option<f64>,
    /// Rollouts of the batch that `ratio` compares with.
    pub(crate) ratio_rollouts: Option<u32>,
}

/// Time from before a device is opened to its first result.
#[derive(Clone, Debug, serde::Serialize)]
pub(crate) struct First {
    pub(crate) device: String,
    pub(crate) threads: Option<usize>,
    pub(crate) rollouts: u32,
    pub(crate) seconds: f64,
}

/// Measures and prints a table.
pub(crate) fn run(arguments: &DeviceBench, console: Console) -> Result {
    if arguments.host || arguments.backend == device::NULL {
        return host::run(arguments, console);
    }
    if arguments.seconds.is_some() || !arguments.processors.is_empty() {
        return Err(Failure::usage("--seconds and --processors are for --host"));
    }
    let mut plan = if arguments.quick {
        Plan::quick()
    } else {
        Plan::thorough()
    };
    plan.specialise = arguments.specialise;
    if let Some(path) = &arguments.share {
        files::must_end_in("--share", path, "json", "the figures are JSON")?;
        files::must_be_new(path)?;
    }
    if !arguments.rollouts.is_empty() {
        plan.sizes.clone_from(&arguments.rollouts);
        plan.sizes.sort_unstable();
        plan.sizes.dedup();
    }
    let subject = match &arguments.experiment {
        Some(path) => Timed::experiment(path, &arguments.set, console)?,
        None => Timed::khepera()?,
    };
    let candidates = subject.candidates(&arguments.backend)?;
    let (cells, firsts) = measure(&subject, &candidates, &plan, console)?;
    let mut figures = json!({
        "cycles": subject.cycles,
        "cells": cells,
        "first_results": firsts,
    });
    for (key, name) in &subject.names {
        figures[key] = json!(name);
    }
    if let Some(path) = &arguments.share {
        share(path, &figures)?;
        console.say(format!(
            "{} has these figures, the processor's name, the devices and their drivers; nothing else about this machine",
            path.display()
        ));
    }
    let mut text = format!(
        "Million robot-steps per second, and the ratio to {} on one thread.\n\
         {}, {} an episode.\n\n{}\n",
        subject.reference().map_or("the slowest lane code", |(lanes, _)| lanes),
        subject.text,
        counted(subject.cycles, "cycle", "cycles"),
        table(&cells),
    );
    for First {
        device,
        rollouts,
        seconds,
        ..
    } in firsts.iter().filter(|first| first.threads.is_none())
    {
        // Writing to a string can't fail.
        let _ = writeln!(
            text,
            "{device}: first result, of {}, {seconds:.2} s after opening it",
            counted(*rollouts, "episode", "episodes")
        );
    }
    console.print_answer(&Answer::new(text, figures))
}

/// Writes the figures for others, with what they depend on.
///
/// # Errors
/// Exit 3: the file exists. Exit 6: it can't be written.
fn share(path: &Path, figures: &Value) -> Result {
    let all = json!({
        "oneiro": env!("CARGO_PKG_VERSION"),
        "system": std::env::consts::OS,
        "architecture": std::env::consts::ARCH,
        "processor": processor(),
        "devices": list::answer(true).value,
        "bench": figures,
    });
    files::write_new(path, format!("{all:#}\n").as_bytes())
}

/// The processor's name, where the system tells it in a file.
fn processor() -> Option<String> {
    let text = String::from_utf8(plain::read(Path::new("/proc/cpuinfo"), plain::MAXIMUM).ok()?).ok()?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}

/// Times every candidate at every batch size, in turns, so that a slowdown of the machine affects all alike.
///
/// # Errors
/// Exit 4: a device can't be opened, or is lost.
pub(crate) fn measure(
    subject: &Timed,
    candidates: &[Candidate],
    plan: &Plan,
    console: Console,
) -> Result<(Vec<Cell>, Vec<First>)> {
    let is_reference = |candidate: &Candidate| candidate.lanes().is_some() && candidate.lanes() == subject.reference();
    let smallest = subject.batch(plan.sizes.first().copied().unwrap_or(1000))?;
    let mut firsts = Vec::new();
    let mut evaluators = Vec::new();
    // Seconds per robot-step, as last measured.
    let mut paces = Vec::new();
    for candidate in candidates {
        let start = Instant::now();
        let mut evaluator = candidate.open(None, plan.specialise)?;
        evaluator.evaluate(&smallest, &Control::new())?;
        let seconds = start.elapsed().as_secs_f64();
        firsts.push(First {
            device: candidate.name.clone(),
            threads: candidate.threads,
            rollouts: smallest.rollouts() as u32,
            seconds,
        });
        let again = time(evaluator.as_mut(), &smallest)?;
        paces.push(again / smallest.steps() as f64);
        evaluators.push(evaluator);
    }

    let mut cells: Vec<Cell> = Vec::new();
    // Rollouts and steps per second.
    let mut references: Vec<(u32, f64)> = Vec::new();
    for &size in &plan.sizes {
        console.say(format!("timing batches of {}", counted(size, "episode", "episodes")));
        let batch = subject.batch(size)?;
        let steps = batch.steps() as f64;
        let affordable = |&i: &usize| {
            let longest = if is_reference(&candidates[i]) {
                plan.longest_of_reference
            } else {
                plan.longest
            };
            paces[i] * steps <= longest.as_secs_f64()
        };
        let taking_part: Vec<usize> = (0..candidates.len()).filter(affordable).collect();
        let is_woken = |i: usize| candidates[i].threads.is_none() && taking_part.len() > 1;
        let waking = |i: usize| if is_woken(i) { WAKING.as_secs_f64() } else { 0.0 };
        let round: f64 = taking_part.iter().map(|&i| paces[i] * steps + waking(i)).sum();
        let (fewest, most) = plan.repetitions;
        let repetitions = ((plan.whole.as_secs_f64() / round.max(1e-6)) as usize).clamp(fewest, most);
        let mut times = vec![Vec::with_capacity(repetitions); candidates.len()];
        for &i in &taking_part {
            // The first batch of a size allocates its buffers.
            time(evaluators[i].as_mut(), &batch)?;
        }
        let mut specialised = vec![0; candidates.len()];
        for _ in 0..repetitions {
            for &i in &taking_part {
                let evaluator = evaluators[i].as_mut();
                if is_woken(i) {
                    wake(evaluator, &smallest)?;
                }
                let before = evaluator.specialised_steps();
                times[i].push(time(evaluator, &batch)?);
                specialised[i] += evaluator.specialised_steps() - before;
            }
        }
        for &i in &taking_part {
            let seconds = median(&mut times[i]);
            paces[i] = seconds / steps;
            if is_reference(&candidates[i]) {
                references.push((size, steps / seconds));
            }
            cells.push(Cell {
                device: candidates[i].name.clone(),
                threads: candidates[i].threads,
                exact: evaluators[i].device().exact,
                rollouts: size,
                robot_steps: batch.steps(),
                seconds,
                repetitions,
                steps_per_second: steps / seconds,
                specialised: specialised[i] as f64 / (steps * repetitions as f64),
                ratio: None,
                ratio_rollouts: None,
            });
        }
    }
    for cell in &mut cells {
        let reference = references.iter().rfind(|(rollouts, _)| *rollouts <= cell.rollouts);
        cell.ratio = reference.map(|(_, rate)| cell.steps_per_second / rate);
        cell.ratio_rollouts = reference.map(|(rollouts, _)| *rollouts);
    }
    Ok((cells, firsts))
}

/// Keeps a GPU busy for long enough to leave its idle clock.
fn wake(evaluator: &mut dyn Evaluator, batch: &Batch) -> Result {
    let start = Instant::now();
    while start.elapsed() < WAKING {
        time(evaluator, batch)?;
    }
    Ok(())
}

/// Seconds of one evaluation.
fn time(evaluator: &mut dyn Evaluator, batch: &Batch) -> Result<f64> {
    let start = Instant::now();
    evaluator.evaluate(batch, &Control::new())?;
    Ok(start.elapsed().as_secs_f64())
}

/// Median; 0 if there are no values.
fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    match (values.len(), values.len() / 2) {
        (0, _) => 0.0,
        (length, middle) if length % 2 == 1 => values[middle],
        (_, middle) => 0.5 * (values[middle - 1] + values[middle]),
    }
}

/// A table with a row per device and a column per batch size.
pub(crate) fn table(cells: &[Cell]) -> String {
    let mut sizes: Vec<u32> = cells.iter().map(|cell| cell.rollouts).collect();
    sizes.sort_unstable();
    sizes.dedup();
    let mut devices: Vec<(&str, Option<usize>)> = Vec::new();
    for cell in cells {
        let device = (cell.device.as_str(), cell.threads);
        if !devices.contains(&device) {
            devices.push(device);
        }
    }
    let heads: Vec<String> = sizes.iter().map(|size| counted(*size, "episode", "episodes")).collect();
    let mut head = vec!["device", "threads"];
    head.extend(heads.iter().map(String::as_str));
    let rows: Vec<Vec<String>> = devices
        .iter()
        .map(|&(device, threads)| {
            let mut row = vec![
                device.to_owned(),
                threads.map_or("-".to_owned(), |threads| threads.to_string()),
            ];
            row.extend(sizes.iter().map(|&size| {
                cells
                    .iter()
                    .find(|cell| (cell.device.as_str(), cell.threads, cell.rollouts) == (device, threads, size))
                    .map_or("-".to_owned(), |cell| {
                        let ratio = cell.ratio.map_or(String::new(), |ratio| format!(" {ratio:>5.2}x"));
                        format!("{:.1}{ratio}", cell.steps_per_second / 1e6)
                    })
            }));
            row
        })
        .collect();
    columns(&head, &rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians() {
        assert_eq!(median(&mut [3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(&mut [4.0, 1.0, 2.0, 3.0]), 2.5);
        assert_eq!(median(&mut []), 0.0);
    }

    #[test]
    fn the_scalar_code_is_the_measure() {
        let plan = Plan {
            sizes: vec![64],
            repetitions: (2, 2),
            ..Plan::quick()
        };
        let console = Console::new(oneiro_base::console::Output {
            json: false,
            quiet: true,
            verbose: false,
        });
        let (cells, firsts) = measure(&Timed::khepera().unwrap(), &[Candidate::scalar(1)], &plan, console).unwrap();
        assert_eq!((cells.len(), firsts.len()), (1, 1));
        assert_eq!(cells[0].ratio, Some(1.0));
        assert_eq!(cells[0].robot_steps, 64 * 500);
        assert_eq!(cells[0].repetitions, 2);
        assert!(table(&cells).contains("1.00x"));
    }
}
