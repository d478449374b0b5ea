//! The one writer of a run's directory.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::path::{Path, PathBuf};

use oneiro::batch::Record;
use oneiro::random::Key;

use super::log::{Extent, Log, Prefix};
use super::{
    CONFIG, Checkpoint, Done, FITNESS, GENERATIONS, INDIVIDUALS, Individuals, LEARNING_CURVE, LOCK, Meta, PATH,
    POPULATION, Row, SavedRun, Session, Status, TRACE, champion, disk, done, npy, trace_csv,
};
use crate::evolve::{Champion, Evolution, Generation};
use crate::exit::{Failure, Result};
use crate::experiment::{Experiment, INPUTS};
use crate::report::figures::{self, Series};

/// What stands where a run is to go.
#[derive(Debug)]
pub(crate) enum Standing {
    /// Nothing.
    New,
    /// A run that is not finished.
    Unfinished,
    /// This very run, finished.
    Done(Done),
}

/// What stands in a directory where a run is to go.
///
/// # Errors
/// Exit 3 when it is something else, which is never overwritten.
pub(crate) fn standing(directory: &Path, identity: blake3::Hash) -> Result<Standing> {
    let refused = |what: &str| {
        Err(Failure::input(format_args!(
            "{}: {what}, and nothing is overwritten; name another directory with --out",
            directory.display()
        )))
    };
    if !directory
        .try_exists()
        .map_err(|error| Failure::unreadable(directory, &error))?
    {
        return Ok(Standing::New);
    }
    if let Some(done) = Done::read(directory)? {
        if done.experiment == identity.to_hex().as_str() {
            return Ok(Standing::Done(done));
        }
        return refused("holds the run of another experiment or seed");
    }
    if super::is_run(directory) {
        return Ok(Standing::Unfinished);
    }
    // What a run that was killed at once leaves behind is not in the way.
    let entries = fs::read_dir(directory).map_err(|error| Failure::unreadable(directory, &error))?;
    for entry in entries {
        let name = entry.map_err(|error| Failure::storage(directory, &error))?.file_name();
        if name != LOCK && name != INPUTS && !name.to_string_lossy().ends_with(disk::TEMPORARY) {
            return refused("exists and holds other files");
        }
    }
    Ok(Standing::New)
}

/// Writes a run's directory; as long as it lives, no other process does.
#[derive(Debug)]
pub(crate) struct Recorder {
    directory: PathBuf,
    _lock: File,
    identity: blake3::Hash,
    seed: u64,
    parents: u32,
    rows: Log,
    individuals: Option<Log>,
    meta: Meta,
}

/// What a finished run gave.
#[derive(Debug)]
pub(crate) struct Ended<'a> {
    /// What it was a run of.
    pub(crate) experiment: &'a Experiment,
    /// Its last generation.
    pub(crate) last: &'a Generation,
    /// The best individual.
    pub(crate) champion: &'a Champion,
    /// The keys of the champion's lives.
    pub(crate) keys: &'a [Key],
    /// The first of them.
    pub(crate) trace: &'a [Record],
    /// Cycles from one record of the trace to the next.
    pub(crate) every: u32,
}

impl Recorder {
    /// Starts a run's directory.
    ///
    /// # Errors
    /// Exit 3 when something stands there, or another process writes there; exit 6 when writing fails.
    pub(crate) fn create(directory: &Path, experiment: &Experiment, seed: u64, session: Session) -> Result<Self> {
        fs::create_dir_all(directory).map_err(|error| Failure::storage(directory, &error))?;
        let lock = lock(directory)?;
        // Another process may have been quicker.
        if !matches!(standing(directory, experiment.identity(seed))?, Standing::New) {
            return Err(Failure::input(format_args!(
                "{}: another process has begun this run",
                directory.display()
            )));
        }
        if !experiment.inputs().is_empty() {
            let inputs = directory.join(INPUTS);
            fs::create_dir_all(&inputs).map_err(|error| Failure::storage(&inputs, &error))?;
            for input in experiment.inputs() {
                disk::write(&directory.join(&input.name), &input.content.bytes)?;
            }
            disk::sync_directory(&inputs)?;
        }
        // From here on it is a run, and can be resumed.
        disk::write(&directory.join(CONFIG), experiment.resolved_toml(seed).as_bytes())?;
        disk::sync_directory(directory)?;
        Self::begin(directory, lock, experiment, seed, session)
    }

    /// Goes on with a run from its newest good checkpoint, or from the start when there was none yet. Lines behind the
    /// checkpoint are cut off. The checkpoint, and what is to be told of those that are not good.
    ///
    /// # Errors
    /// Exit 3 when another process writes there; exit 5 when there are checkpoints and none of them is good; exit 6
    /// when writing fails.
    pub(crate) fn resume(run: &SavedRun, session: Session) -> Result<(Self, Option<Checkpoint>, Vec<String>)> {
        let (directory, experiment, seed) = (run.directory(), run.experiment(), run.seed());
        let lock = lock(directory)?;
        let mut warnings = Vec::new();
        for (_, path) in Checkpoint::list(directory)? {
            match Good::load(&path, directory, experiment, seed) {
                Ok(good) => {
                    let checkpoint = good.checkpoint.clone();
                    let recorder = Self::go_on(directory, lock, experiment, seed, session, good)?;
                    return Ok((recorder, Some(checkpoint), warnings));
                }
                Err(problem) => warnings.push(format!("{}: {problem}; it is not used", path.display())),
            }
        }
        if warnings.is_empty() {
            return Ok((Self::begin(directory, lock, experiment, seed, session)?, None, warnings));
        }
        Err(Failure::corrupt(format_args!(
            "no checkpoint of this run is good: {}",
            warnings.join("; ")
        )))
    }

    /// Begins with generation 0.
    fn begin(directory: &Path, lock: File, experiment: &Experiment, seed: u64, session: Session) -> Result<Self> {
        let mut rows = Log::create(directory.join(GENERATIONS))?;
        rows.push(Row::HEAD.as_bytes())?;
        let mut individuals = None;
        if experiment.settings().record.individuals {
            let log = individuals.insert(Log::create(directory.join(INDIVIDUALS))?);
            log.push(&Individuals::header(experiment))?;
        }
        Self::new(directory, lock, experiment, seed, session, rows, individuals)
    }

    /// Begins with a checkpoint's generation.
    fn go_on(
        directory: &Path,
        lock: File,
        experiment: &Experiment,
        seed: u64,
        mut session: Session,
        good: Good,
    ) -> Result<Self> {
        session.from_generation = good.checkpoint.generation;
        let rows = Log::cut_back(directory.join(GENERATIONS), good.rows)?;
        let individuals = good
            .individuals
            .map(|prefix| Log::cut_back(directory.join(INDIVIDUALS), prefix));
        Self::new(
            directory,
            lock,
            experiment,
            seed,
            session,
            rows,
            individuals.transpose()?,
        )
    }

    fn new(
        directory: &Path,
        lock: File,
        experiment: &Experiment,
        seed: u64,
        session: Session,
        rows: Log,
        individuals: Option<Log>,
    ) -> Result<Self> {
        let evolution = &experiment.settings().evolution;
        let meta = Meta::begin(directory, experiment.name(), seed, evolution.generations, session)?;
        Ok(Self {
            directory: directory.to_owned(),
            _lock: lock,
            identity: experiment.identity(seed),
            seed,
            parents: evolution.parents,
            rows,
            individuals,
            meta,
        })
    }

    /// Where it writes.
    pub(crate) fn directory(&self) -> &Path {
        &self.directory
    }

    /// Records a generation.
    pub(crate) fn push(&mut self, generation: &Generation) -> Result {
        self.rows.push(Row::new(generation, self.parents).line().as_bytes())?;
        if let Some(individuals) = &mut self.individuals {
            let population = &generation.population;
            let mut bytes = Vec::with_capacity(size_of::<f32>() * population.len() * (population.genes() + 1));
            for (genome, fitness) in population.genomes().zip(&generation.fitness) {
                for value in genome.iter().chain([fitness]) {
                    bytes.extend_from_slice(&value.to_le_bytes());
                }
            }
            individuals.push(&bytes)?;
        }
        Ok(())
    }

    /// Makes sure that a run can go on from here, whatever happens.
    pub(crate) fn checkpoint(&mut self, evolution: &Evolution) -> Result {
        let checkpoint = Checkpoint {
            identity: self.identity,
            generation: evolution.generation(),
            population: evolution.ask().clone(),
            champion: evolution.champion().cloned(),
            rows: self.rows.sync()?,
            individuals: self.individuals.as_mut().map(Log::sync).transpose()?,
        };
        checkpoint.save(&self.directory)
    }

    /// Writes a checkpoint and notes that the run was stopped. One that only lacks its results keeps the checkpoint that
    /// it has: what a checkpoint holds is a generation that is still to live.
    pub(crate) fn stop(&mut self, evolution: &Evolution) -> Result {
        if self.meta.status == Status::Done {
            return Ok(());
        }
        if !evolution.is_finished() {
            self.checkpoint(evolution)?;
        }
        self.ended(Status::Stopped, evolution.generation(), evolution.champion())
    }

    fn ended(&mut self, status: Status, generation: u32, champion: Option<&Champion>) -> Result {
        self.meta.generation = generation;
        self.meta.best = champion.map(|champion| champion.fitness);
        self.meta.end(&self.directory, status)
    }

    /// Writes the results, and `DONE` when all of them are on the disk.
    pub(crate) fn finish(&mut self, ended: &Ended<'_>) -> Result<Done> {
        self.rows.sync()?;
        let mut files = vec![CONFIG, GENERATIONS];
        if let Some(individuals) = &mut self.individuals {
            individuals.sync()?;
            files.push(INDIVIDUALS);
        }
        files.extend(ended.experiment.inputs().iter().map(|input| input.name.as_str()));

        let rows = super::saved::rows(&self.directory)?;
        let pictures = [
            (TRACE, trace_csv(ended.trace, ended.every).into_bytes()),
            (PATH, self.path_svg(ended).into_bytes()),
            (LEARNING_CURVE, self.learning_curve_svg(&rows).into_bytes()),
        ];
        let results = results(ended.last, ended.champion, self.seed, ended.keys);
        for (name, bytes) in results.iter().chain(&pictures) {
            disk::write(&self.directory.join(name), bytes)?;
            files.push(name);
        }
        disk::sync_directory(&self.directory)?;
        let done = Done::of(&self.directory, self.identity, &files)?;
        self.ended(Status::Done, self.meta.generations, Some(ended.champion))?;
        done.write(&self.directory)?;
        Ok(done)
    }

    fn path_svg(&self, ended: &Ended<'_>) -> String {
        let world = ended.experiment.world().spec();
        let Champion {
            generation, individual, ..
        } = ended.champion;
        let name = ended.experiment.name();
        let title = format!(
            "{name}, seed {}: individual {individual} of generation {generation}",
            self.seed
        );
        figures::life(&world.arena, world.robot.body_radius, &title, ended.trace, ended.every)
    }

    fn learning_curve_svg(&self, rows: &[Row]) -> String {
        let series = |label, value: fn(&Row) -> f64| Series {
            label,
            values: rows.iter().map(value).collect(),
        };
        let title = format!("{}, seed {}", self.meta.name, self.seed);
        let peak = format!("mean of the best {}", self.parents);
        figures::learning_curve(
            &title,
            "fitness",
            &[
                series("best", |row| f64::from(row.best)),
                series(&peak, |row| row.peak),
                series("mean", |row| row.mean),
            ],
        )
    }
}

/// The files of what a run ended with.
fn results(last: &Generation, champion: &Champion, seed: u64, keys: &[Key]) -> [(&'static str, Vec<u8>); 4] {
    let population = &last.population;
    let [of_champion, genes_of_champion] = champion::files(champion, seed, keys);
    [
        of_champion,
        genes_of_champion,
        (
            POPULATION,
            npy(&[population.len(), population.genes()], population.values()),
        ),
        (FITNESS, npy(&[population.len()], &last.fitness)),
    ]
}

/// The hash of a run's results, as its directory's `DONE` would have it. `rows` are those of its generations.
pub(crate) fn result(
    experiment: blake3::Hash,
    rows: &str,
    last: &Generation,
    champion: &Champion,
    seed: u64,
    keys: &[Key],
) -> String {
    let table = Row::HEAD.to_owned() + rows;
    let results = results(last, champion, seed, keys);
    let others = results.iter().map(|(name, bytes)| (*name, &bytes[..]));
    let files: Vec<_> = std::iter::once((GENERATIONS, table.as_bytes())).chain(others).collect();
    done::result_of(experiment, &files)
}

/// Keeps other processes from writing to a run's directory.
pub(super) fn lock(directory: &Path) -> Result<File> {
    try_lock(directory)?.ok_or_else(|| {
        Failure::input(format_args!(
            "{}: another process works on this run; allowed: one at a time",
            directory.display()
        ))
    })
}

/// The same, or nothing if another process writes there.
pub(crate) fn try_lock(directory: &Path) -> Result<Option<File>> {
    let path = directory.join(LOCK);
    let file = OpenOptions::new().create(true).truncate(false).write(true).open(&path);
    let file = file.map_err(|error| Failure::storage(&path, &error))?;
    match file.try_lock() {
        Ok(()) => Ok(Some(file)),
        Err(TryLockError::WouldBlock) => Ok(None),
        Err(TryLockError::Error(error)) => Err(Failure::storage(&path, &error)),
    }
}

/// A checkpoint that can be gone on from, and what the logs held then.
struct Good {
    checkpoint: Checkpoint,
    rows: Prefix,
    individuals: Option<Prefix>,
}

impl Good {
    /// Reads a checkpoint of a run, or says what is wrong with it.
    fn load(path: &Path, directory: &Path, experiment: &Experiment, seed: u64) -> std::result::Result<Self, String> {
        let checkpoint = Checkpoint::load(path)?;
        let evolution = &experiment.settings().evolution;
        if checkpoint.identity != experiment.identity(seed)
            || checkpoint.population.genes() != experiment.world().genes()
            || checkpoint.population.len() != evolution.population as usize
            || checkpoint.generation >= evolution.generations
            || checkpoint.individuals.is_some() != experiment.settings().record.individuals
        {
            return Err(format!("belongs to another experiment than {CONFIG}"));
        }
        let prefix = |name: &str, extent: &Extent| {
            Prefix::of(&directory.join(name), extent).ok_or_else(|| format!("{name} is not what it was then"))
        };
        let rows = prefix(GENERATIONS, &checkpoint.rows)?;
        let individuals = checkpoint
            .individuals
            .as_ref()
            .map(|extent| prefix(INDIVIDUALS, extent))
            .transpose()?;
        Ok(Self {
            checkpoint,
            rows,
            individuals,
        })
    }
}
