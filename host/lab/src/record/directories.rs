//! Runs with a directory each, for the engine.

use std::borrow::Cow;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use oneiro_base::console::Console;
use oneiro_base::console::counted;
use oneiro_base::exit::Result;

use super::{Done, Recorder, SavedRun, Session, is_locked, named};
use crate::engine::job::{Job, Step};
use crate::engine::scheduler::{Record, RunNumber, Runs, UnderWay, Waiting};
use crate::experiment::kinds::is_run;
use crate::runs::Experiment;

/// A run to be done, and its place.
#[derive(Debug)]
pub enum RunPlace {
    /// A new run.
    New {
        experiment: Arc<dyn Experiment>,
        seed: u64,
        /// Its future directory.
        directory: PathBuf,
        /// The name from which the program chose that. If another process takes the directory first, the run gets the next one.
        name: Option<PathBuf>,
    },
    /// A run that was stopped or killed.
    Saved(SavedRun),
}

impl RunPlace {
    /// The run's directory; a new one may get the next name.
    pub fn directory(&self) -> &Path {
        match self {
            Self::New { directory, .. } => directory,
            Self::Saved(run) => run.directory(),
        }
    }

    fn experiment(&self) -> &Arc<dyn Experiment> {
        match self {
            Self::New { experiment, .. } => experiment,
            Self::Saved(run) => run.experiment(),
        }
    }
}

/// Runs with a directory each.
#[derive(Debug)]
pub struct Directories {
    places: Vec<RunPlace>,
    session: Session,
    console: Console,
    done: Vec<(PathBuf, Done)>,
    /// How each stopped run continues.
    stopped: Vec<String>,
}

impl Directories {
    /// Maximum number of runs in progress: each holds a lock file open, and systems allow a few thousand open files.
    pub const MOST: usize = 256;

    /// Prepares runs and their places.
    pub fn new(places: Vec<RunPlace>, session: Session, console: Console) -> Self {
        Self {
            places,
            session,
            console,
            done: Vec::new(),
            stopped: Vec::new(),
        }
    }

    /// All runs in the engine's form.
    pub fn waiting(&self) -> Vec<Waiting> {
        let waiting = |(run, place): (RunNumber, &RunPlace)| Waiting {
            run,
            kernel: place.experiment().kernel(),
        };
        self.places.iter().enumerate().map(waiting).collect()
    }

    /// Total robot-steps of all runs, from their beginnings.
    pub fn steps(&self) -> u64 {
        self.places.iter().map(|place| place.experiment().steps()).sum()
    }

    /// The runs that are finished.
    pub fn done(self) -> Vec<(PathBuf, Done)> {
        self.done
    }
}

impl Record<Box<dyn Job>> for Recorder {
    fn add(&mut self, job: &Box<dyn Job>, step: Step) -> Result {
        self.record(&**job, step)
    }
}

/// Waits until the process that has just locked a directory has written which run it is.
fn wait_for_config(directory: &Path) {
    const LONGEST: Duration = Duration::from_secs(2);
    const MOMENT: Duration = Duration::from_millis(20);
    let began = Instant::now();
    while !is_run(directory) && is_locked(directory) && began.elapsed() < LONGEST {
        thread::sleep(MOMENT);
    }
}

impl Runs for Directories {
    type Job = Box<dyn Job>;
    type Record = Recorder;

    fn begin(&mut self, run: RunNumber) -> Result<(Box<dyn Job>, Recorder)> {
        let session = Session {
            started: oneiro_base::utc::now(),
            ..self.session.clone()
        };
        let (recorder, job) = match &self.places[run] {
            RunPlace::New {
                experiment,
                seed,
                directory,
                name,
            } => {
                let mut directory = Cow::from(directory);
                loop {
                    match (
                        Recorder::create(&directory, experiment, *seed, session.clone(), self.console),
                        name,
                    ) {
                        (Ok(begun), _) => break begun,
                        (Err(failure), None) => return Err(failure),
                        (Err(failure), Some(name)) => {
                            wait_for_config(&directory);
                            let identity = experiment.identities().of(*seed);
                            let named = named(name, &**experiment, *seed, identity)?;
                            if named.own.is_some() || named.directory == directory {
                                return Err(failure);
                            }
                            self.console.say(named.why.unwrap_or_default());
                            directory = named.directory.into();
                        }
                    }
                }
            }
            RunPlace::Saved(saved) => {
                let (recorder, job, warnings) = Recorder::resume(saved, session, self.console)?;
                self.console.warn(warnings);
                (recorder, job)
            }
        };
        Ok((job, recorder))
    }

    fn finish(&mut self, finished: Vec<UnderWay<Self>>) -> Result {
        for UnderWay {
            mut job, mut record, ..
        } in finished
        {
            let done = record.finish(&mut *job)?;
            self.done.push((record.directory().to_owned(), done));
        }
        Ok(())
    }

    fn end(&mut self, mut under_way: Vec<&mut UnderWay<Self>>) -> Result {
        under_way.sort_by_key(|own| own.run);
        for UnderWay { job, record, .. } in under_way {
            record.stop(&**job)?;
            let directory = record.directory().display();
            self.stopped
                .push(format!("  oneiro resume {directory}  ({})", record.reached()));
        }
        Ok(())
    }

    fn stopped(&self) -> String {
        let mut lines = self.stopped.clone();
        let unborn = self.places.len() - self.stopped.len() - self.done.len();
        if unborn > 0 {
            lines.push(format!(
                "  or all by the same command, with {}",
                counted(unborn, "run that has not begun", "runs that have not begun")
            ));
        }
        format!("stopped; to continue:\n{}", lines.join("\n"))
    }
}
