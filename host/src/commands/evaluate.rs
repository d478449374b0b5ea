//! `oneiro evaluate`: fitness for genomes that come from elsewhere.

use std::fmt::Write;
use std::path::Path;

use oneiro::batch::{Batch, Rollout};
use oneiro::evaluator::Control;
use oneiro::random::Key;
use oneiro::world::World;
use serde_json::json;

use crate::cli::Evaluate;
use crate::console::{Console, decimal};
use crate::evolve::Population;
use crate::exit::{Failure, Result};
use crate::experiment::Experiment;
use crate::npy::npy;
use crate::{device, files, genomes, progress};

/// Rollouts that are evaluated at once: enough for any device, and a few hundred megabytes at most.
const AT_ONCE: usize = 1 << 18;

/// Evaluates, and prints or writes one row a genome and trial.
pub(crate) fn run(arguments: &Evaluate, console: Console) -> Result {
    let sink = Sink::of(&arguments.out)?;
    let experiment = Experiment::read(&arguments.experiment, &arguments.set)?;
    let world = experiment.world();
    let genomes = genomes::read(&arguments.genomes, world.genes())?;
    let seed = arguments.seed.or(experiment.settings().seed).unwrap_or(1);
    let trials = arguments.trials.unwrap_or(experiment.settings().trials) as usize;
    let mut evaluator = device::open(&arguments.backend)?;
    let rollouts = genomes.len() * trials;
    console.say(format!(
        "{} genomes, {trials} trials, seed {seed}, on {}",
        genomes.len(),
        device::name(evaluator.as_ref())
    ));

    let steps = rollouts as u64 * u64::from(world.cycles());
    let control = Control::new();
    let fitness = progress::watched(steps, "evaluating", console, &control, || -> Result<Vec<f32>> {
        let mut fitness = Vec::with_capacity(rollouts);
        for first in (0..rollouts).step_by(AT_ONCE) {
            let batch = batch(world, &genomes, seed, trials, first..(first + AT_ONCE).min(rollouts))?;
            fitness.extend(evaluator.evaluate(&batch, &control)?.fitness);
        }
        Ok(fitness)
    })?;
    device::tell_warnings(evaluator.as_ref(), console);
    sink.take(&fitness, trials, console)
}

/// Some of the rollouts, which are numbered genome by genome and within each by trial.
fn batch(
    world: &World,
    genomes: &Population,
    seed: u64,
    trials: usize,
    range: std::ops::Range<usize>,
) -> Result<Batch> {
    let rollouts: Vec<Rollout<'_>> = range
        .map(|index| {
            let (genome, trial) = (index / trials, index % trials);
            let key = Key::rollout(seed, 0, genome as u64, trial as u64);
            Rollout {
                world: 0,
                genes: genomes.genome(genome),
                key,
            }
        })
        .collect();
    Ok(Batch::new(std::slice::from_ref(world), &rollouts, None)?)
}

/// Where the rows go.
enum Sink<'a> {
    Stdout,
    Csv(&'a Path),
    Npy(&'a Path),
}

impl<'a> Sink<'a> {
    /// As the path says; refused before anything is computed.
    fn of(out: &'a Path) -> Result<Self> {
        if out.as_os_str() == "-" {
            return Ok(Self::Stdout);
        }
        files::must_be_new(out)?;
        match out.extension().and_then(|extension| extension.to_str()) {
            Some("csv") => Ok(Self::Csv(out)),
            Some("npy") => Ok(Self::Npy(out)),
            _ => Err(Failure::input(format_args!(
                "--out {}: the extension names no format; allowed: .csv, .npy, or - for standard output",
                out.display()
            ))),
        }
    }

    /// Prints or writes fitness, genome by genome and within each by trial.
    fn take(&self, fitness: &[f32], trials: usize, console: Console) -> Result {
        match self {
            Self::Stdout if console.json() => console.json_data(&rows(fitness, trials)),
            Self::Stdout => console.data(csv(fitness, trials)),
            Self::Csv(path) => files::write_new(path, csv(fitness, trials).as_bytes()),
            Self::Npy(path) => files::write_new(path, &npy(&[fitness.len() / trials, trials], fitness)),
        }?;
        if let Self::Csv(path) | Self::Npy(path) = self {
            console.say(format!("wrote {}", path.display()));
        }
        Ok(())
    }
}

fn rows(fitness: &[f32], trials: usize) -> Vec<serde_json::Value> {
    let row = |(index, &fitness): (usize, &f32)| {
        json!({
            "genome": index / trials,
            "trial": index % trials,
            "fitness": decimal(fitness),
            "bits": format!("{:08x}", fitness.to_bits()),
        })
    };
    fitness.iter().enumerate().map(row).collect()
}

/// Fitness in the shortest decimal that reads back as the same number, and its bits.
fn csv(fitness: &[f32], trials: usize) -> String {
    let mut text = String::from("genome,trial,fitness,bits\n");
    for (index, fitness) in fitness.iter().enumerate() {
        // Writing to a string can't fail.
        let _ = writeln!(
            text,
            "{},{},{fitness},{:08x}",
            index / trials,
            index % trials,
            fitness.to_bits()
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use oneiro::world::WorldSpec;

    #[test]
    fn rows_are_genomes_by_trials() {
        let text = csv(&[1.5, -0.1, 0.0, 3.0], 2);
        assert_eq!(
            text,
            "genome,trial,fitness,bits\n0,0,1.5,3fc00000\n0,1,-0.1,bdcccccd\n1,0,0,00000000\n1,1,3,40400000\n"
        );
    }

    #[test]
    fn batches_take_each_rollout_once_wherever_they_are_cut() {
        let world = World::new(WorldSpec::miglino1995()).unwrap();
        let genomes = Population::new(18, (0_u8..72).map(f32::from).collect());
        let inputs = |range| batch(&world, &genomes, 7, 3, range).unwrap().all().inputs().to_vec();
        let whole = inputs(0..12);
        let lane = |inputs: &[u32], lane: usize| inputs.iter().skip(lane).step_by(64).copied().collect::<Vec<_>>();
        for cut in 1..12 {
            let (first, second) = (inputs(0..cut), inputs(cut..12));
            for rollout in 0..12 {
                let there = if rollout < cut {
                    lane(&first, rollout)
                } else {
                    lane(&second, rollout - cut)
                };
                assert_eq!(there, lane(&whole, rollout), "cut {cut}, rollout {rollout}");
            }
        }
    }
}
