//! Runs and sweeps in directories.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use oneiro_base::console::Bars;
use oneiro_base::exit::Failure;
use oneiro_lab::engine::handle::Engine;
use oneiro_lab::experiment::check_seed;
use oneiro_lab::record::{self, Directories, RunPlace, SavedRun, Session, SingleRun};
use oneiro_lab::runs::Replay;
use oneiro_lab::sweep::store::Shard;
use oneiro_lab::sweep::tables::Written;

use super::experiment::Experiment;
use super::{Counted, Error, Result, Task, device};
use crate::COMMIT;
use crate::cli::{Backend, Beside, SweepRun};
use crate::commands::places::{Place, Places, sorted_out};
use crate::commands::sweep::{self, Means};

/// A finished or stopped run.
#[derive(Debug)]
pub struct Run(SavedRun);

/// Runs an experiment with a seed, as `oneiro run --out` does. A run that was begun there continues, and a finished one stays.
///
/// # Errors
/// Exit 3 for a seed above 2^63 - 1, and if the directory holds something else; exit 4 without such a device; exit 6 if the disk is full;
/// exit 75 if the task was stopped: the same call or [`resume`] continues it.
pub fn run(experiment: &Experiment, seed: u64, out: &Path, backend: &str, task: &Task) -> Result<Run> {
    check_seed(seed)?;
    let places = vec![(seed, Place::Directory(out.to_owned()))];
    let Places { todo, .. } = sorted_out(places, experiment.any(), device::quiet())?;
    all(todo, backend, task)?;
    Run::open(out)
}

/// Goes on with a run that was stopped or killed, as `oneiro resume` does. A finished one is left as it is.
///
/// # Errors
/// As [`run`], and exit 5 if its checkpoints are damaged.
pub fn resume(directory: &Path, backend: &str, task: &Task) -> Result<Run> {
    let saved = SavedRun::open(directory)?;
    if saved.done()?.is_none() {
        all(vec![RunPlace::Saved(saved)], backend, task)?;
    }
    Run::open(directory)
}

/// Does runs.
fn all(places: Vec<RunPlace>, backend: &str, task: &Task) -> Result {
    if places.is_empty() {
        return Ok(());
    }
    device::threaded(|| {
        let engine = engine(backend, task)?;
        let session = Session::new(COMMIT, backend, engine.description());
        let mut runs = Directories::new(places, session, device::quiet());
        task.expect(runs.steps());
        engine.run(runs.waiting(), Directories::MOST, &mut runs, &mut Counted(task))?;
        Ok(())
    })
}

fn engine(backend: &str, task: &Task) -> oneiro_base::exit::Result<Engine> {
    let evaluator = Backend::named(backend).open()?;
    Ok(Engine::new(evaluator, Arc::clone(&task.stop)))
}

impl Run {
    /// Opens a run's directory.
    ///
    /// # Errors
    /// Exit 3 if it isn't one, or its configuration is invalid.
    pub fn open(directory: &Path) -> Result<Self> {
        Ok(Self(SavedRun::open(directory)?))
    }

    /// Its directory.
    pub fn directory(&self) -> &Path {
        self.0.directory()
    }

    /// Its experiment.
    pub fn experiment(&self) -> Experiment {
        Experiment::of(Arc::clone(self.0.experiment()))
    }

    /// Its seed.
    pub fn seed(&self) -> u64 {
        self.0.seed()
    }

    /// Hash of its results, once it is finished.
    ///
    /// # Errors
    /// Exit 5 if the record of it is damaged.
    pub fn result(&self) -> Result<Option<String>> {
        Ok(self.0.done()?.map(|done| done.result))
    }

    /// Its table of steps: `generations.csv`, or a swarm's `intervals.csv`.
    pub fn table(&self) -> PathBuf {
        let directory = self.directory();
        let recording = oneiro_lab::runs::Recording::Directory {
            path: directory,
            console: device::quiet(),
        };
        let tables = self.0.experiment().tables(recording);
        directory.join(tables.first().map_or("", |table| table.file))
    }

    /// Genes of its champion.
    ///
    /// # Errors
    /// Exit 1 if it isn't finished, exit 3 for swarms, exit 5 if its files aren't what was written.
    pub fn champion(&self) -> Result<Vec<f32>> {
        Ok(SingleRun::open(self.directory())?.champion()?.genome)
    }

    /// Checks that its files are as they were written, as `oneiro verify` does. Returns the hash of its results.
    ///
    /// # Errors
    /// Exit 1 if it isn't finished, exit 5 with everything that differs.
    pub fn verify(&self) -> Result<String> {
        Ok(record::verify(self.directory())?.result)
    }

    /// Evaluates a share of its individuals again and compares the bits, as `oneiro verify --recompute` does. Returns the report as JSON.
    ///
    /// # Errors
    /// Exit 1 if a bit differs; exit 5 if its files aren't what was written; exit 4 without such a device; exit 75 if the task was
    /// stopped.
    pub fn audit(&self, share: f64, backend: &str, task: &Task) -> Result<String> {
        if !(0.0..=1.0).contains(&share) || share == 0.0 {
            return Err(Error::input(format_args!(
                "share: is {share}; allowed: a number above 0 and up to 1, such as 0.01"
            )));
        }
        device::threaded(|| {
            let engine = engine(backend, task)?;
            let recorded = self.0.recorded()?;
            let audit = self.0.experiment().audit(&recorded, share, &engine, Bars::Hidden)?;
            match audit.problem {
                None => Ok(audit.answer.value.to_string()),
                Some(problem) => Err(Failure::failed(format_args!(
                    "{}: {problem}",
                    self.directory().display()
                )))?,
            }
        })
    }
}

/// A champion's episode to draw again: its number, the seed of other random numbers, and where its files are written.
#[derive(Clone, Copy, Debug)]
pub struct Replayed<'a> {
    /// From 0.
    pub trial: u32,
    /// `None`: the run's.
    pub seed: Option<u64>,
    /// A folder.
    pub out: &'a Path,
}

impl Run {
    /// Draws an episode of its champion again, as `oneiro replay` does, on a page whose name says which episode it is.
    ///
    /// # Errors
    /// Exit 1 if it isn't finished; exit 3 for an episode or a seed that isn't allowed; exit 5 if its files aren't what was written; exit 4
    /// without such a device; exit 6 if the disk is full.
    pub fn replay(&self, replayed: Replayed<'_>, backend: &str, task: &Task) -> Result {
        let Replayed { trial, seed, out } = replayed;
        check_seed(seed.unwrap_or(0))?;
        device::threaded(|| {
            let recorded = self.0.finished()?;
            let engine = engine(backend, task)?;
            let replay = Replay {
                test: false,
                out,
                trial,
                every: 1,
                start: None,
                seed,
                elite: None,
                elites: false,
                generation: None,
                individual: None,
                generations: &[],
                genome: None,
                picture: None,
                at: None,
                film: None,
                speed: None,
                surrogate: None,
            };
            self.0.experiment().replay(&recorded, &replay, &engine, Bars::Hidden)?;
            Ok(())
        })
    }
}

/// A sweep's tables.
#[derive(Clone, Debug)]
pub struct Tables {
    /// Runs.
    pub runs: usize,
    /// Hash of the tables of results and of generations.
    pub hash: String,
    /// The files.
    pub files: Vec<PathBuf>,
}

impl From<Written> for Tables {
    fn from(Written { runs, hash, files }: Written) -> Self {
        Self { runs, hash, files }
    }
}

/// Which runs of a sweep are done: all, or a shard's.
#[derive(Clone, Copy, Debug)]
pub struct SweepShard(Shard);

impl SweepShard {
    /// A shard as the program names it, such as `3/8`.
    ///
    /// # Errors
    /// Exit 3 for anything else.
    pub fn parse(text: &str) -> Result<Self> {
        let shard = text
            .parse()
            .map_err(|allowed| Error::input(format_args!("shard: is {text}; {allowed}")))?;
        Ok(Self(shard))
    }
}

/// Runs a sweep in a directory, as `oneiro sweep run --yes --out` does, or continues it; with a shard, only its runs, which
/// [`merge`] makes tables of. `jobs` limits the runs at a time.
///
/// # Errors
/// Exit 3 if the plan is invalid or the directory holds another sweep; exit 4 without such a device; exit 5 if recorded data are
/// damaged; exit 6 if the disk is full; exit 75 if the task was stopped: the same call continues it.
pub fn sweep(
    plan: &Path,
    out: &Path,
    shard: Option<SweepShard>,
    jobs: Option<u32>,
    backend: &str,
    task: &Task,
) -> Result<Option<Tables>> {
    let arguments = SweepRun {
        sweep: plan.to_owned(),
        out: Some(out.to_owned()),
        shard: shard.map(|SweepShard(shard)| shard),
        time_budget: None,
        checkpoint_every: Duration::from_secs(10),
        jobs,
        yes: true,
        backend: Backend::named(backend),
        print_slurm: false,
        shards: None,
        beside: Beside {
            watch: false,
            open: false,
        },
    };
    if jobs.is_some_and(|jobs| !(1..=1_000_000).contains(&jobs)) {
        return Err(Error::input("jobs: is out of range; allowed: 1 to 1000000"));
    }
    let written = device::threaded(|| {
        let mut means = Means {
            engine: &|| engine(backend, task),
            watch: &mut |_, steps, _| {
                task.expect(steps);
                Box::new(Counted(task))
            },
        };
        sweep::by(&arguments, &mut means, device::quiet())
    })?;
    Ok(written.map(Tables::from))
}

/// Writes the tables of a sweep whose shards are done, as `oneiro sweep merge` does: into the first directory, or into `out`.
///
/// # Errors
/// Exit 1 if runs are missing; exit 3 if a directory holds no sweep or another one; exit 5 if recorded data are damaged; exit 6 if
/// the disk is full.
pub fn merge(directories: &[PathBuf], out: Option<&Path>) -> Result<Tables> {
    Ok(sweep::merge(directories, out, device::quiet())?.into())
}
