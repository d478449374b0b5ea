//! A run in memory: the files of its directory, without a directory.

use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use oneiro::cpu::Cpu;
use oneiro_base::console::Console;
use oneiro_base::exit::{Failure, Result};

use super::{CONFIG, result_of};
use crate::engine::alone::{self, Alone};
use crate::engine::handle::Engine;
use crate::engine::job::{Job, Progress, Results, Step};
use crate::experiment::check_seed;
use crate::runs::{Experiment, Recording, Table};

/// A run that advances when it is asked to, on the caller's thread.
pub struct InMemory {
    experiment: Arc<dyn Experiment>,
    seed: u64,
    job: Box<dyn Job>,
    tables: Vec<(&'static str, Vec<u8>)>,
    progress: Progress,
    engine: Engine,
    alone: Alone,
}

/// A finished run: the hash of its results, as in a directory's `DONE`, its files, and the champion's genes.
pub struct Finished {
    pub result: String,
    pub files: Vec<(String, Vec<u8>)>,
    pub champion: Vec<f32>,
}

impl InMemory {
    /// Begins a run.
    ///
    /// # Errors
    /// Exit 3 for a seed above 2^63 - 1; exit 4 if this processor can't evaluate.
    pub fn new(experiment: Arc<dyn Experiment>, seed: u64) -> Result<Self> {
        check_seed(seed)?;
        let recording = Recording::Directory {
            path: Path::new(""),
            console: Console::default(),
        };
        let table = |Table { file, head }| (file, head);
        Ok(Self {
            tables: experiment.tables(recording).into_iter().map(table).collect(),
            job: Arc::clone(&experiment).job(seed, recording)?,
            experiment,
            seed,
            progress: Progress {
                done: 0,
                best: f32::NAN,
            },
            engine: Engine::new(Box::new(Cpu::new(None)?), Arc::default()),
            alone: Alone::default(),
        })
    }

    /// Steps so far, generations or minutes, and the best fitness.
    pub fn progress(&self) -> Progress {
        self.progress
    }

    /// Robot-steps so far.
    pub fn steps(&self) -> u64 {
        self.engine.control.steps()
    }

    /// The table of steps so far.
    pub fn table(&self) -> &[u8] {
        &self.tables[0].1
    }

    /// The number of episodes of the next step that several processes may share, since their results are their fitness alone. `None`
    /// once the run is finished.
    pub fn shared(&self) -> Option<usize> {
        alone::shared(&*self.job)
    }

    /// Evaluates some of the episodes that may be shared: their fitness.
    ///
    /// # Errors
    /// Errors of the evaluator.
    pub fn evaluate(&mut self, episodes: Range<usize>) -> Result<Vec<f32>> {
        if episodes.is_empty() {
            return Ok(Vec::new());
        }
        let (outcome, _) = self.alone.evaluate(&*self.job, episodes, &self.engine)?;
        Ok(outcome.fitness)
    }

    /// Takes the next step, given the fitness of all episodes that could be shared.
    ///
    /// # Errors
    /// Those of the run.
    pub fn tell(&mut self, fitness: &[f32]) -> Result {
        if self.shared() != Some(fitness.len()) {
            return Err(Failure::failed("a step has other episodes"));
        }
        let step = self.job.tell(&Results {
            fitness,
            traces: &[],
            logs: &[],
            log_words: 0,
            states: &[],
        })?;
        self.record(step);
        Ok(())
    }

    /// Takes the next step by itself.
    ///
    /// # Errors
    /// Errors of the evaluator, and those of the run.
    pub fn step(&mut self) -> Result {
        let step = self.alone.step(&mut *self.job, &self.engine)?;
        self.record(step);
        Ok(())
    }

    fn record(&mut self, step: Step) {
        for added in step.added {
            if let Some((_, table)) = self.tables.iter_mut().find(|(file, _)| *file == added.file) {
                table.extend(added.bytes);
            }
        }
        self.progress = step.progress.unwrap_or(self.progress);
    }

    /// Ends a run that has taken all steps.
    ///
    /// # Errors
    /// Those of the run.
    pub fn finish(mut self) -> Result<Finished> {
        let table = String::from_utf8_lossy(&self.tables[0].1).into_owned();
        let finished = self.job.finish(&table)?;
        let config = self.experiment.resolved_toml(self.seed).into_bytes();
        let mut files = vec![(CONFIG.to_owned(), config)];
        files.extend(self.tables.into_iter().map(|(name, bytes)| (name.to_owned(), bytes)));
        let inputs = self.experiment.inputs().iter();
        files.extend(inputs.map(|input| (input.name.clone(), input.content.bytes.clone())));
        let results = finished.files.into_iter();
        files.extend(results.map(|(name, bytes)| (name.to_owned(), bytes)));
        let all: Vec<_> = files.iter().map(|(name, bytes)| (name.as_str(), &bytes[..])).collect();
        let identity = self.experiment.identities().of(self.seed);
        Ok(Finished {
            result: result_of(identity, &self.experiment.results(), &all),
            champion: finished.champion,
            files,
        })
    }
}
