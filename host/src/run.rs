//! The loop of a run: ask, evaluate, tell, record.

use std::collections::VecDeque;
use std::path::Path;

use oneiro::batch::{Batch, Rollout, TraceRequest, Worlds};
use oneiro::evaluator::Error;
use oneiro::random::Key;
use oneiro::world::Invalid;

use crate::evolve::genetic::Genetic;
use crate::evolve::{Evolution, Generation};
use crate::exit::{Failure, Result};
use crate::experiment::Experiment;
use crate::experiment::settings::TrialScore;
use crate::record::{Done, Ended, Recorder, SavedRun, Session};
use crate::worker::{Watch, Worker};

/// Runs that go in lockstep at most: each has a lock open, and systems allow some thousand open files.
pub(crate) const LOCKSTEP: usize = 256;

/// One evolution from one seed, and where it is recorded.
#[derive(Debug)]
pub(crate) struct Run {
    seed: u64,
    evolution: Evolution,
    recorder: Recorder,
    /// The generation that lived last.
    last: Option<Generation>,
}

impl Run {
    /// Begins one in a directory of its own.
    ///
    /// # Errors
    /// As [`Recorder::create`].
    pub(crate) fn start(experiment: &Experiment, seed: u64, directory: &Path, session: Session) -> Result<Self> {
        Ok(Self {
            seed,
            evolution: experiment.evolution(seed),
            recorder: Recorder::create(directory, experiment, seed, session)?,
            last: None,
        })
    }

    /// Goes on with one. What is to be told of its checkpoints comes along.
    ///
    /// # Errors
    /// As [`Recorder::resume`].
    pub(crate) fn resume(saved: &SavedRun, session: Session) -> Result<(Self, Vec<String>)> {
        let experiment = saved.experiment();
        let settings = &experiment.settings().evolution;
        let seed = saved.seed();
        let (recorder, checkpoint, warnings) = Recorder::resume(saved, session)?;
        let evolution = match checkpoint {
            Some(from) => Evolution::new(
                Genetic::at(settings, seed, from.generation, from.population),
                settings.generations,
                from.champion,
            ),
            None => experiment.evolution(seed),
        };
        Ok((
            Self {
                seed,
                evolution,
                recorder,
                last: None,
            },
            warnings,
        ))
    }

    /// Its seed.
    pub(crate) fn seed(&self) -> u64 {
        self.seed
    }

    /// Its evolution.
    pub(crate) fn evolution(&self) -> &Evolution {
        &self.evolution
    }

    /// Where it is recorded.
    pub(crate) fn directory(&self) -> &Path {
        self.recorder.directory()
    }
}

/// What watches runs as they go.
pub(crate) trait Follow: Watch {
    /// Called when a generation of a run has lived.
    fn lived(&mut self, run: &Run);
}

/// Evolves runs of one experiment in lockstep, their generations in one batch, until all are finished.
///
/// # Errors
/// Exit 75 when it was stopped, and as the evaluator's errors, both with a checkpoint of each run; exit 6 when
/// recording fails, with the last checkpoints as they were.
pub(crate) fn evolve(
    experiment: &Experiment,
    mut runs: Vec<Run>,
    worker: &Worker,
    watch: &mut dyn Follow,
) -> Result<Vec<(Run, Done)>> {
    let worlds = Worlds::new(std::slice::from_ref(experiment.world()))?;
    let ended = live(experiment, &worlds, &mut runs, worker, watch)
        .and_then(|()| finish(experiment, &worlds, &mut runs, worker, watch));
    match ended {
        Ok(done) => Ok(runs.into_iter().zip(done).collect()),
        Err(Interruption::Other(failure)) => Err(failure),
        Err(Interruption::Evaluation(error)) => {
            for run in &mut runs {
                run.recorder.stop(&run.evolution)?;
            }
            Err(match error {
                Error::Cancelled => Failure::stopped(stopped(&runs)),
                error => error.into(),
            })
        }
    }
}

/// All generations, in two halves of the runs: while the device evaluates one, this thread evolves and records the
/// other.
fn live(experiment: &Experiment, worlds: &Worlds, runs: &mut [Run], worker: &Worker, watch: &mut dyn Follow) -> Step {
    let (one, other) = runs.split_at_mut(runs.len().div_ceil(2));
    let mut under_way = VecDeque::new();
    for half in [one, other] {
        if let Some(batch) = ask(experiment, worlds, half)? {
            worker.submit(batch);
            under_way.push_back(half);
        }
    }
    while let Some(half) = under_way.pop_front() {
        let outcome = worker.receive(watch)?;
        let lived = tell(experiment, half, &outcome.fitness)?;
        let next = ask(experiment, worlds, half)?;
        let goes_on = next.is_some();
        if let Some(batch) = next {
            worker.submit(batch);
        }
        record(experiment, half, lived, watch)?;
        if goes_on {
            under_way.push_back(half);
        }
    }
    Ok(())
}

/// The next generation of each run that is not finished, or nothing when all are.
fn ask(experiment: &Experiment, worlds: &Worlds, runs: &[Run]) -> Step<Option<Batch>> {
    let trials = experiment.settings().trials;
    let mut rollouts = Vec::new();
    for run in runs.iter().filter(|run| !run.evolution.is_finished()) {
        for (genes, individual) in run.evolution.ask().genomes().zip(0..) {
            let keys = keys(run.seed, run.evolution.generation(), individual, trials);
            rollouts.extend(keys.map(|key| Rollout { world: 0, genes, key }));
        }
    }
    if rollouts.is_empty() {
        return Ok(None);
    }
    Ok(Some(worlds.batch(&rollouts, None)?))
}

/// The keys of an individual's lives.
pub(crate) fn keys(seed: u64, generation: u32, individual: u32, trials: u32) -> impl Iterator<Item = Key> {
    (0..trials).map(move |trial| Key::rollout(seed, generation.into(), individual.into(), trial.into()))
}

/// Gives the runs that are not finished their individuals' scores. The generations that have lived, with their runs'
/// indices.
fn tell(experiment: &Experiment, runs: &mut [Run], fitness: &[f32]) -> Step<Vec<(usize, Generation)>> {
    let settings = experiment.settings();
    let mut scores = fitness
        .chunks_exact(settings.trials as usize)
        .map(|lives| score(settings.trial_score, lives));
    let running = runs
        .iter_mut()
        .enumerate()
        .filter(|(_, run)| !run.evolution.is_finished());
    running
        .map(|(index, run)| {
            let own = scores.by_ref().take(run.evolution.ask().len()).collect();
            Ok((index, run.evolution.tell(own)?))
        })
        .collect()
}

/// What an individual's lives count as; NaN if one of them is.
pub(crate) fn score(kind: TrialScore, lives: &[f32]) -> f32 {
    let nan = lives.iter().copied().find(|life| life.is_nan());
    nan.unwrap_or_else(|| match kind {
        TrialScore::Mean => (lives.iter().map(|&life| f64::from(life)).sum::<f64>() / lives.len() as f64) as f32,
        TrialScore::Least => lives.iter().copied().fold(f32::INFINITY, f32::min),
    })
}

/// Records the generations that have lived.
fn record(experiment: &Experiment, runs: &mut [Run], lived: Vec<(usize, Generation)>, watch: &mut dyn Follow) -> Step {
    for (index, generation) in lived {
        let run = &mut runs[index];
        run.recorder.push(&generation)?;
        run.last = Some(generation);
        let is_due = run
            .evolution
            .generation()
            .is_multiple_of(experiment.settings().record.checkpoint_every);
        if is_due && !run.evolution.is_finished() {
            run.recorder.checkpoint(&run.evolution)?;
        }
        watch.lived(run);
    }
    Ok(())
}

/// Lets the champions live again for their traces, and writes what the runs gave.
fn finish(
    experiment: &Experiment,
    worlds: &Worlds,
    runs: &mut [Run],
    worker: &Worker,
    watch: &mut dyn Follow,
) -> Step<Vec<Done>> {
    /// Records; a longer life is traced less often.
    const LONGEST_TRACE: u32 = 10_000;
    let every = experiment.world().cycles().div_ceil(LONGEST_TRACE);
    let trials = experiment.settings().trials;
    let mut all = Vec::with_capacity(runs.len());
    for run in runs {
        let (Some(champion), Some(last)) = (run.evolution.champion(), &run.last) else {
            return Err(Failure::failed("a run has no generation").into());
        };
        let keys: Vec<Key> = keys(run.seed, champion.generation, champion.individual, trials).collect();
        let life = Rollout {
            world: 0,
            genes: &champion.genome,
            key: keys[0],
        };
        worker.submit(worlds.batch(&[life], Some(TraceRequest { every }))?);
        let outcome = worker.receive(watch)?;
        if trials == 1 && outcome.fitness[0].to_bits() != champion.fitness.to_bits() {
            return Err(Failure::failed(format_args!(
                "seed {}: the champion's fitness was {} (bits {:08x}) in its generation and is {} (bits {:08x}) in its \
                 trace; results of this device can't be trusted",
                run.seed,
                champion.fitness,
                champion.fitness.to_bits(),
                outcome.fitness[0],
                outcome.fitness[0].to_bits()
            ))
            .into());
        }
        let trace = outcome.traces.first().map_or(&[][..], Vec::as_slice);
        all.push(run.recorder.finish(&Ended {
            experiment,
            last,
            champion,
            keys: &keys,
            trace,
            every,
        })?);
    }
    Ok(all)
}

/// What is said of runs that were stopped.
fn stopped(runs: &[Run]) -> String {
    let directories: Vec<String> = runs
        .iter()
        .map(|run| {
            format!(
                "  oneiro resume {}  (generation {})",
                run.directory().display(),
                run.evolution.generation()
            )
        })
        .collect();
    format!("stopped; to go on:\n{}", directories.join("\n"))
}

/// A result of the loop.
type Step<T = ()> = std::result::Result<T, Interruption>;

/// What ends the loop early.
pub(crate) enum Interruption {
    /// The evaluator; all that has lived is recorded, and can be kept.
    Evaluation(Error),
    /// Anything else; only what checkpoints hold is sure.
    Other(Failure),
}

impl From<Error> for Interruption {
    fn from(error: Error) -> Self {
        Self::Evaluation(error)
    }
}

impl From<Failure> for Interruption {
    fn from(failure: Failure) -> Self {
        Self::Other(failure)
    }
}

impl From<Invalid> for Interruption {
    fn from(invalid: Invalid) -> Self {
        Self::Other(invalid.into())
    }
}

#[cfg(test)]
mod tests;
