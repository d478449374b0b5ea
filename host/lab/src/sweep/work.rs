//! A shard's runs as the engine's work: they start from the sweep's cells, and their results go to the shard's journal.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::sync::{Arc, Weak};
use std::time::{Duration, Instant};

use oneiro_base::exit::{Failure, Result};
use rayon::prelude::*;

use super::journal::{Journal, Outcome, Saved};
use super::{Plan, RunIndex, Sweep};
use crate::engine::job::{Job, Step};
use crate::engine::scheduler::{Record, RunNumber, Runs, UnderWay, Waiting};
use crate::record::result_of;
use crate::runs::{Experiment, Recording};

/// Maximum memory of all runs in progress, in bytes.
const MEMORY: u64 = 512 << 20;

/// A shard's runs in their order of completion.
pub struct Work<'a> {
    sweep: &'a Sweep,
    plan: &'a Plan,
    journal: &'a Journal,
    /// Experiments of cells with runs in progress.
    cells: BTreeMap<usize, Weak<dyn Experiment>>,
    /// Runs from a checkpoint that have not been resumed yet.
    saved: BTreeMap<RunIndex, Saved>,
    checkpoint_every: Duration,
    checkpointed: Instant,
}

/// The record of a run in progress, in memory until it is finished.
pub struct Recorded {
    experiment: Arc<dyn Experiment>,
    done: u32,
    /// Its tables so far, by their files, that of steps first. Individuals are not recorded in sweeps.
    tables: Vec<(&'static str, Vec<u8>)>,
}

impl<'a> Work<'a> {
    /// Prepares a shard's runs; `saved` are those that were in progress when the last process stopped.
    pub fn new(
        (sweep, plan): (&'a Sweep, &'a Plan),
        saved: Vec<Saved>,
        checkpoint_every: Duration,
        journal: &'a Journal,
    ) -> Self {
        Self {
            sweep,
            plan,
            journal,
            cells: BTreeMap::new(),
            saved: saved.into_iter().map(|saved| (saved.run, saved)).collect(),
            checkpoint_every,
            checkpointed: Instant::now(),
        }
    }

    /// Some runs of the sweep for the engine, those with a checkpoint first.
    pub fn waiting(&self, mut runs: Vec<RunIndex>) -> Vec<Waiting> {
        runs.sort_by_key(|run| !self.saved.contains_key(run));
        let waiting = |run: RunIndex| Waiting {
            run: run as RunNumber,
            kernel: self.plan.kernels[self.sweep.cell_of(run)],
        };
        runs.into_iter().map(waiting).collect()
    }

    /// Maximum number of runs in progress at a time, as memory allows.
    pub fn most(&self) -> usize {
        (MEMORY / self.plan.bytes.max(1)).max(2) as usize
    }

    fn experiment(&mut self, cell: usize) -> Result<Arc<dyn Experiment>> {
        if let Some(experiment) = self.cells.get(&cell).and_then(Weak::upgrade) {
            return Ok(experiment);
        }
        let experiment = self.sweep.cell(cell)?;
        self.cells.retain(|_, experiment| experiment.strong_count() > 0);
        self.cells.insert(cell, Arc::downgrade(&experiment));
        Ok(experiment)
    }

    fn checkpoint<'r>(&mut self, under_way: impl Iterator<Item = &'r UnderWay<Self>>) -> Result
    where
        Self: 'r,
    {
        self.checkpointed = Instant::now();
        let under_way: Vec<_> = under_way.collect();
        let saved = under_way.into_par_iter().map(|UnderWay { run, job, record }| Saved {
            run: *run as RunIndex,
            done: record.done,
            tables: record.tables.iter().map(|(_, rows)| rows.clone()).collect(),
            job: job.save(),
        });
        // Runs that are still to be resumed from an earlier checkpoint stay in the next one.
        let mut all: Vec<Saved> = self.saved.values().cloned().collect();
        all.par_extend(saved);
        self.journal.checkpoint(all)
    }
}

/// The outcome of a finished run.
fn outcome(plan: &Plan, run: RunNumber, mut job: Box<dyn Job>, recorded: &Recorded) -> Result<Outcome> {
    let table = std::str::from_utf8(&recorded.tables[0].1).map_err(Failure::failed)?;
    let finished = job.finish(table)?;
    let files = finished.files.iter().map(|(file, bytes)| (*file, &bytes[..]));
    let tables = recorded.tables.iter().map(|(file, rows)| (*file, &rows[..]));
    let files: Vec<_> = files.chain(tables).collect();
    let mut champion = String::with_capacity(16 * finished.champion.len());
    for gene in &finished.champion {
        let comma = if champion.is_empty() { "" } else { "," };
        // Writing to a string can't fail.
        let _ = write!(champion, "{comma}{gene}");
    }
    Ok(Outcome {
        run: run as RunIndex,
        outcomes: finished.outcomes,
        champion,
        generations: table[plan.table.head.len()..].to_owned(),
        result: result_of(plan.ids[run], &recorded.experiment.results(), &files),
    })
}

impl Record<Box<dyn Job>> for Recorded {
    fn add(&mut self, _: &Box<dyn Job>, step: Step) -> Result {
        self.done = step.progress.map_or(self.done, |progress| progress.done);
        for added in step.added {
            let table = self.tables.iter_mut().find(|(file, _)| *file == added.file);
            let (_, rows) =
                table.ok_or_else(|| Failure::failed(format_args!("{}: is no table of this run", added.file)))?;
            rows.extend(added.bytes);
        }
        Ok(())
    }
}

impl Runs for Work<'_> {
    type Job = Box<dyn Job>;
    type Record = Recorded;

    fn begin(&mut self, run: RunNumber) -> Result<(Box<dyn Job>, Recorded)> {
        let index = run as RunIndex;
        let experiment = self.experiment(self.sweep.cell_of(index))?;
        let seed = self.sweep.seed_of(index);
        let tables = experiment.tables(Recording::Tables).into_iter();
        let mut tables: Vec<(&'static str, Vec<u8>)> = tables.map(|table| (table.file, table.head)).collect();
        let saved = self.saved.remove(&index).and_then(|saved| {
            let job = Arc::clone(&experiment).restored(seed, Recording::Tables, &saved.job);
            // A saved run that doesn't fit starts over.
            let job = job.ok().filter(|_| saved.tables.len() == tables.len())?;
            for ((_, rows), saved) in tables.iter_mut().zip(saved.tables) {
                *rows = saved;
            }
            Some((job, saved.done))
        });
        let (job, done) = if let Some(saved) = saved {
            saved
        } else {
            (Arc::clone(&experiment).job(seed, Recording::Tables)?, 0)
        };
        let recorded = Recorded {
            experiment,
            done,
            tables,
        };
        Ok((job, recorded))
    }

    fn finish(&mut self, finished: Vec<UnderWay<Self>>) -> Result {
        let plan = self.plan;
        // With short runs, a fast device would wait for one thread's hashes.
        let outcomes = finished
            .into_par_iter()
            .with_max_len(1)
            .map(|UnderWay { run, job, record }| Ok((outcome(plan, run, job, &record)?, plan.ids[run])))
            .collect::<Result<_>>()?;
        self.journal.done(outcomes)
    }

    fn pause(&mut self, under_way: &[&UnderWay<Self>]) -> Result {
        if self.checkpointed.elapsed() < self.checkpoint_every {
            return Ok(());
        }
        self.checkpoint(under_way.iter().copied())
    }

    fn end(&mut self, under_way: Vec<&mut UnderWay<Self>>) -> Result {
        // Also if all runs are done: those of the last checkpoint are in the table of results now.
        self.checkpoint(under_way.into_iter().map(|own| &*own))
    }

    fn stopped(&self) -> String {
        "stopped; run the same command again to continue".into()
    }
}
