//! The one writer of a run's directory.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use oneiro_base::console::Console;
use oneiro_base::contents::describe;
use oneiro_base::disk;
use oneiro_base::exit::{Code, Failure, Result};
use oneiro_base::files::directory::{self, Found, Holds, Named};
use oneiro_base::sealed::Problem;
use serde::{Deserialize, Serialize};

use super::extend::is_unsettled;
use super::{CONFIG, Done, FORM, Meta, SavedRun, Session, Status};
use crate::engine::checkpoint;
use crate::engine::job::{Job, Progress, Step};
use crate::engine::log::{Extent, Log, Prefix};
use crate::experiment::{Difference, INPUTS};
use crate::runs::{Experiment, Recording, Table};

/// Checkpoints that are kept: if the newest is damaged, there is one before.
pub(super) const KEPT: usize = 2;

/// Current contents of a run's directory.
#[derive(Debug)]
pub enum Standing {
    /// Nothing.
    New,
    /// The same run, unfinished.
    Unfinished(SavedRun),
    /// The same run, finished.
    Done(Done),
}

/// Examines the directory of a future run.
///
/// # Errors
/// Exit 3 if it holds something else, which is never overwritten; exit 5 if it holds the run, finished and changed since.
pub fn standing(directory: &Path, identity: blake3::Hash) -> Result<Standing> {
    if FORM.refuse_others(directory)? == Holds::Nothing {
        return Ok(Standing::New);
    }
    let run = SavedRun::open(directory)?;
    let done = run.done()?;
    if run.identity() != identity {
        return Err(Failure::input(format_args!(
            "{}: holds the run of another experiment or seed, and nothing is overwritten; name another directory with --out",
            directory.display()
        )));
    }
    Ok(done.map_or(Standing::Unfinished(run), Standing::Done))
}

/// A run that was begun before.
#[derive(Debug)]
pub enum Begun {
    Unfinished(SavedRun),
    Done(Done),
}

/// Chooses the directory of a run by its name: `name`, or `name-b`, `name-c` and so on if other runs have that.
///
/// # Errors
/// Exit 5 if the run is there, finished and changed since; exit 6 if a directory can't be read.
pub fn named(name: &Path, experiment: &dyn Experiment, seed: u64, identity: blake3::Hash) -> Result<Named<Begun>> {
    directory::named(name, |directory| {
        let is_refused = |failure: &Failure| failure.code() == Code::Input as u8;
        match FORM.look(directory) {
            Ok(Holds::Nothing) => return Ok(Found::Free),
            Ok(Holds::Other(file)) => return Ok(Found::Other(format!("holds other files, such as {file}"))),
            Ok(Holds::Mark) => {}
            Err(failure) if is_refused(&failure) => return Ok(Found::Other("is something else".into())),
            Err(failure) => return Err(failure),
        }
        let run = match SavedRun::open(directory) {
            Ok(run) => run,
            Err(failure) if is_refused(&failure) => {
                return Ok(Found::Other("holds a run that this version can't read".into()));
            }
            Err(failure) => return Err(failure),
        };
        let is_own = run.identity() == identity;
        match run.done() {
            Ok(Some(done)) if is_own => Ok(Found::Own(Begun::Done(done))),
            Ok(None) if is_own => Ok(Found::Own(Begun::Unfinished(run))),
            Err(failure) if is_own || was_of(directory, identity) => Err(failure),
            _ => Ok(Found::Other(described(&run, experiment, seed))),
        }
    })
}

/// Whether a finished run was this one before its configuration was changed.
fn was_of(directory: &Path, identity: blake3::Hash) -> bool {
    let done = Done::read(directory).ok().flatten();
    done.is_some_and(|done| done.experiment == identity.to_hex().as_str())
}

/// How a run differs from one that is wanted.
fn described(run: &SavedRun, experiment: &dyn Experiment, seed: u64) -> String {
    const LONGEST: usize = 40;
    let known = run.experiment().resolved_toml(run.seed());
    match Difference::of_runs(&known, &experiment.resolved_toml(seed))
        .into_iter()
        .next()
    {
        Some(Difference { key, values }) => {
            let [known, wanted] = values.map(|value| match value.char_indices().nth(LONGEST) {
                Some((end, _)) => format!("{} ..", &value[..end]),
                None => value,
            });
            format!("holds a run with other settings ({key}: {known} there, {wanted} here)")
        }
        None => "holds a run of another experiment".into(),
    }
}

/// Writer of a run's directory. While it exists, no other process can write there.
#[derive(Debug)]
pub struct Recorder {
    directory: PathBuf,
    _lock: File,
    experiment: Arc<dyn Experiment>,
    identity: blake3::Hash,
    tables: Vec<(&'static str, Log)>,
    progress: Progress,
    meta: Meta,
}

/// A run between two steps.
#[derive(Serialize, Deserialize)]
pub(super) struct Saved {
    pub(super) progress: Progress,
    /// Length of each table.
    pub(super) tables: Vec<Extent>,
    pub(super) job: Vec<u8>,
}

/// The saved job of a run's newest good checkpoint. A process may be writing there.
pub(super) fn newest_job(directory: &Path, identity: &blake3::Hash) -> Option<Vec<u8>> {
    let all = checkpoint::list(directory).ok()?;
    let saved = all
        .into_iter()
        .find_map(|(_, path)| checkpoint::read::<Saved>(&path, identity).ok());
    saved.map(|saved| saved.job)
}

impl Recorder {
    /// Starts a run's directory.
    ///
    /// # Errors
    /// Exit 3 if the directory isn't empty, or another process writes there; exit 6 if writing fails.
    pub fn create(
        directory: &Path,
        experiment: &Arc<dyn Experiment>,
        seed: u64,
        session: Session,
        console: Console,
    ) -> Result<(Self, Box<dyn Job>)> {
        let (lock, holds) = FORM.take(directory, || is_busy(directory))?;
        if holds == Holds::Mark {
            return Err(Failure::input(format_args!(
                "{}: another process has begun this run",
                directory.display()
            )));
        }
        if !experiment.inputs().is_empty() {
            let inputs = disk::make_folder(directory, INPUTS)?;
            for input in experiment.inputs() {
                disk::write(&directory.join(&input.name), &input.content.bytes)?;
            }
            disk::sync_directory(&inputs)?;
        }
        // From here on it is a run, and can be resumed.
        disk::write(&directory.join(CONFIG), experiment.resolved_toml(seed).as_bytes())?;
        disk::sync_directory(directory)?;
        Self::begin(directory, lock, experiment, seed, session, console)
    }

    /// Resumes a run from its newest good checkpoint, or from the start if there was none yet. Cuts off what the tables
    /// have beyond the checkpoint. Also returns warnings about bad checkpoints.
    ///
    /// # Errors
    /// Exit 3 if another process writes there, or if another version of the program wrote its checkpoints; exit 5 if
    /// there are checkpoints and none of them is good; exit 6 if writing fails.
    pub fn resume(run: &SavedRun, session: Session, console: Console) -> Result<(Self, Box<dyn Job>, Vec<String>)> {
        let (directory, experiment, seed) = (run.directory(), run.experiment(), run.seed());
        let lock = disk::try_lock(directory)?.ok_or_else(|| is_busy(directory))?;
        if is_unsettled(directory) {
            return Err(Failure::input(format_args!(
                "{0}: its larger budget was interrupted; `oneiro resume {0}` completes it",
                directory.display()
            )));
        }
        let mut problems = Vec::new();
        let mut is_other_version = true;
        for (_, path) in checkpoint::list(directory)? {
            let own = match checkpoint::read::<Saved>(&path, &run.identity()) {
                Ok(saved) => {
                    is_other_version = false;
                    Good::of(run, &saved, console)
                }
                Err(problem) => {
                    is_other_version &= matches!(problem, Problem::Other(_));
                    Err(checkpoint::words(&problem, &format!("experiment than {CONFIG}")))
                }
            };
            match own {
                Ok(good) => {
                    let mut session = session;
                    session.from_generation = good.progress.done;
                    let tables = good.tables.into_iter().map(|(file, prefix)| {
                        let log = Log::cut_back(directory.join(file), prefix)?;
                        Ok((file, log))
                    });
                    let tables = tables.collect::<Result<_>>()?;
                    let recorder = Self::new(directory, lock, experiment, seed, session, tables, good.progress)?;
                    return Ok((recorder, good.job, problems));
                }
                Err(problem) => problems.push(format!("{}: {problem}; it is not used", path.display())),
            }
        }
        if problems.is_empty() {
            let (recorder, job) = Self::begin(directory, lock, experiment, seed, session, console)?;
            return Ok((recorder, job, problems));
        }
        if is_other_version {
            return Err(is_of_other_version(directory));
        }
        Err(Failure::corrupt(format_args!(
            "this run has no intact checkpoint: {}",
            problems.join("; ")
        )))
    }

    /// Begins with the first step.
    fn begin(
        directory: &Path,
        lock: File,
        experiment: &Arc<dyn Experiment>,
        seed: u64,
        session: Session,
        console: Console,
    ) -> Result<(Self, Box<dyn Job>)> {
        let recording = Recording::Directory {
            path: directory,
            console,
        };
        let create = |Table { file, head }| {
            let mut log = Log::create(directory.join(file))?;
            log.push(&head)?;
            Ok((file, log))
        };
        let tables = experiment
            .tables(recording)
            .into_iter()
            .map(create)
            .collect::<Result<_>>()?;
        let progress = Progress {
            done: 0,
            best: f32::NAN,
        };
        let recorder = Self::new(directory, lock, experiment, seed, session, tables, progress)?;
        Ok((recorder, Arc::clone(experiment).job(seed, recording)?))
    }

    fn new(
        directory: &Path,
        lock: File,
        experiment: &Arc<dyn Experiment>,
        seed: u64,
        session: Session,
        tables: Vec<(&'static str, Log)>,
        progress: Progress,
    ) -> Result<Self> {
        let contents = super::contents(experiment.contents(), !experiment.inputs().is_empty());
        describe(
            directory,
            &format!("{}, seed {seed}: a run of oneiro", experiment.name()),
            &contents,
        )?;
        Ok(Self {
            directory: directory.to_owned(),
            _lock: lock,
            experiment: Arc::clone(experiment),
            identity: experiment.identities().of(seed),
            tables,
            progress,
            meta: Meta::begin(directory, &**experiment, seed, session)?,
        })
    }

    /// Path of the directory.
    pub fn directory(&self) -> &Path {
        &self.directory
    }

    /// Description of the run's progress.
    pub fn reached(&self) -> String {
        let (_, unit) = self.experiment.shown().time;
        format!("{unit} {}", self.progress.done)
    }

    /// Records a step that the job has taken.
    pub(super) fn record(&mut self, job: &dyn Job, step: Step) -> Result {
        for added in step.added {
            if let Some((_, log)) = self.tables.iter_mut().find(|(file, _)| *file == added.file) {
                log.push(&added.bytes)?;
            }
        }
        self.progress = step.progress.unwrap_or(self.progress);
        if step.is_checkpoint {
            self.checkpoint(job)?;
        }
        Ok(())
    }

    /// Saves the run so that it can be resumed from here, whatever happens.
    fn checkpoint(&mut self, job: &dyn Job) -> Result {
        let saved = Saved {
            progress: self.progress,
            tables: self.sync()?,
            job: job.save(),
        };
        checkpoint::write(&self.directory, self.progress.done.into(), KEPT, &self.identity, &saved)
    }

    /// Waits until all tables are on disk. Returns their extents.
    fn sync(&mut self) -> Result<Vec<Extent>> {
        disk::at_once(self.tables.iter_mut().map(|(_, log)| || log.sync()))
    }

    /// Writes a checkpoint and notes that the run was stopped.
    pub(super) fn stop(&mut self, job: &dyn Job) -> Result {
        self.checkpoint(job)?;
        self.end(Status::Stopped)
    }

    fn end(&mut self, status: Status) -> Result {
        self.meta.generation = self.progress.done;
        self.meta.best = Some(self.progress.best).filter(|best| !best.is_nan());
        self.meta.end(&self.directory, status)
    }

    /// Writes the results, and `DONE` once all of them are on disk.
    pub(super) fn finish(&mut self, job: &mut dyn Job) -> Result<Done> {
        self.sync()?;
        // A killed process may have left one more.
        checkpoint::prune(&self.directory, KEPT)?;
        let mut files = vec![CONFIG];
        files.extend(self.tables.iter().map(|(file, _)| *file));
        let experiment = Arc::clone(&self.experiment);
        files.extend(experiment.inputs().iter().map(|input| input.name.as_str()));
        let table = disk::read_text(&self.directory.join(self.tables[0].0))?;
        let results = job.finish(&table)?.files;
        let write = |(name, bytes): &(&str, Vec<u8>)| disk::write(&self.directory.join(name), bytes);
        disk::at_once(results.iter().map(|file| || write(file)))?;
        files.extend(results.iter().map(|(name, _)| *name));
        disk::sync_directory(&self.directory)?;
        let done = Done::of(&self.directory, self.identity, &files, &experiment.results())?;
        self.end(Status::Done)?;
        done.write(&self.directory)?;
        Ok(done)
    }
}

pub(super) fn is_busy(directory: &Path) -> Failure {
    Failure::input(format_args!(
        "{}: another process is working on this run; allowed: one at a time",
        directory.display()
    ))
}

fn is_of_other_version(directory: &Path) -> Failure {
    Failure::input(format_args!(
        "{}: its checkpoints were written by another version of oneiro; allowed: finish it with that version, or \
         begin anew in another directory",
        directory.display()
    ))
}

/// Why a run can't be continued from any of its checkpoints.
pub(super) fn unusable(directory: &Path, problems: &[(PathBuf, Problem)]) -> Failure {
    if problems.iter().all(|(_, problem)| matches!(problem, Problem::Other(_))) {
        return is_of_other_version(directory);
    }
    let words = problems.iter().map(|(path, problem)| {
        let problem = checkpoint::words(problem, &format!("experiment than {CONFIG}"));
        format!("{}: {problem}", path.display())
    });
    let words: Vec<String> = words.collect();
    Failure::corrupt(format_args!("this run has no intact checkpoint: {}", words.join("; ")))
}

/// A checkpoint that can be resumed from, and the tables at that time.
struct Good {
    progress: Progress,
    tables: Vec<(&'static str, Prefix)>,
    job: Box<dyn Job>,
}

impl Good {
    /// Reads a checkpoint of a run, or returns the problem with it.
    fn of(run: &SavedRun, saved: &Saved, console: Console) -> std::result::Result<Self, String> {
        let recording = Recording::Directory {
            path: run.directory(),
            console,
        };
        let tables = run.experiment().tables(recording);
        if saved.tables.len() != tables.len() {
            return Err(format!("has other tables than {CONFIG} means"));
        }
        let prefix = |(table, extent): (Table, &Extent)| {
            let prefix = Prefix::of(&run.directory().join(table.file), extent);
            let prefix = prefix.ok_or_else(|| format!("{} is not what it was then", table.file))?;
            Ok::<_, String>((table.file, prefix))
        };
        let job = Arc::clone(run.experiment()).restored(run.seed(), recording, &saved.job);
        Ok(Self {
            progress: saved.progress,
            tables: tables
                .into_iter()
                .zip(&saved.tables)
                .map(prefix)
                .collect::<std::result::Result<_, _>>()?,
            job: job.map_err(|failure| failure.to_string())?,
        })
    }
}
