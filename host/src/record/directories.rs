//! Runs with a directory each, for the engine.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use super::{Done, Recorder, SavedRun, Session};
use crate::console::Console;
use crate::engine::job::{Job, Step};
use crate::engine::scheduler::{RunNumber, Runs, UnderWay, Waiting};
use crate::exit::{Failure, Result};
use crate::runs::Experiment;

/// A run to be done, and its place.
#[derive(Debug)]
pub(crate) enum RunPlace {
    /// A new run.
    New {
        experiment: Arc<dyn Experiment>,
        seed: u64,
        /// Its future directory.
        directory: PathBuf,
    },
    /// A run that was stopped or killed.
    Saved(SavedRun),
}

impl RunPlace {
    fn experiment(&self) -> &Arc<dyn Experiment> {
        match self {
            Self::New { experiment, .. } => experiment,
            Self::Saved(run) => run.experiment(),
        }
    }
}

/// Runs with a directory each.
#[derive(Debug)]
pub(crate) struct Directories {
    places: Vec<RunPlace>,
    session: Session,
    console: Console,
    under_way: BTreeMap<RunNumber, Recorder>,
    done: Vec<(PathBuf, Done)>,
}

impl Directories {
    /// Most runs in progress: each holds a lock file open, and systems allow some thousand open files.
    pub(crate) const MOST: usize = 256;

    /// Prepares runs and their places.
    pub(crate) fn new(places: Vec<RunPlace>, session: Session, console: Console) -> Self {
        Self {
            places,
            session,
            console,
            under_way: BTreeMap::new(),
            done: Vec::new(),
        }
    }

    /// All runs in the engine's form.
    pub(crate) fn waiting(&self) -> Vec<Waiting> {
        let waiting = |(run, place): (RunNumber, &RunPlace)| Waiting {
            run,
            kernel: place.experiment().kernel(),
        };
        self.places.iter().enumerate().map(waiting).collect()
    }

    /// Total robot-steps of all runs, from their beginnings.
    pub(crate) fn steps(&self) -> u64 {
        self.places.iter().map(|place| place.experiment().steps()).sum()
    }

    /// The runs that are finished.
    pub(crate) fn done(self) -> Vec<(PathBuf, Done)> {
        self.done
    }

    fn recorder(&mut self, run: RunNumber) -> Result<&mut Recorder> {
        let recorder = self.under_way.get_mut(&run);
        recorder.ok_or_else(|| Failure::failed("a run has no directory"))
    }
}

impl Runs for Directories {
    type Job = Box<dyn Job>;

    fn begin(&mut self, run: RunNumber) -> Result<Box<dyn Job>> {
        let session = Session {
            started: crate::utc::now(),
            ..self.session.clone()
        };
        let (recorder, job) = match &self.places[run] {
            RunPlace::New {
                experiment,
                seed,
                directory,
            } => Recorder::create(directory, experiment, *seed, session, self.console)?,
            RunPlace::Saved(saved) => {
                let (recorder, job, warnings) = Recorder::resume(saved, session, self.console)?;
                for warning in warnings {
                    self.console.say(format!("warning: {warning}"));
                }
                (recorder, job)
            }
        };
        self.under_way.insert(run, recorder);
        Ok(job)
    }

    fn record(&mut self, run: RunNumber, job: &Self::Job, step: Step) -> Result {
        self.recorder(run)?.record(&**job, step)
    }

    fn finish(&mut self, finished: Vec<(RunNumber, Self::Job)>) -> Result {
        for (run, mut job) in finished {
            let recorder = self.recorder(run)?;
            let done = recorder.finish(&mut *job)?;
            let directory = recorder.directory().to_owned();
            self.done.push((directory, done));
            self.under_way.remove(&run);
        }
        Ok(())
    }

    fn end(&mut self, under_way: &UnderWay<'_, Box<dyn Job>>) -> Result {
        for (run, job) in under_way {
            self.recorder(*run)?.stop(&***job)?;
        }
        Ok(())
    }

    fn stopped(&self) -> String {
        let mut lines: Vec<String> = self
            .under_way
            .values()
            .map(|run| format!("  oneiro resume {}  ({})", run.directory().display(), run.reached()))
            .collect();
        let unborn = self.places.len() - self.under_way.len() - self.done.len();
        if unborn > 0 {
            lines.push(format!(
                "  the same command, once these are finished, for {unborn} runs that have not begun"
            ));
        }
        format!("stopped; to continue:\n{}", lines.join("\n"))
    }
}
