//! A sweep's directory: its origin, and the work of its shards.
//!
//! | file | contents |
//! |---|---|
//! | `sweep.json` | the origin, see [`Made`]; written after everything else that each process brings |
//! | `sweep.toml`, `sweep/` | the sweep's file, and the files that it names |
//! | `experiment/` | the experiment's file, and the files that it names |
//! | `shard-I-of-N/` | a process's [journal](super::journal) |
//! | `results.csv`, `generations.csv`, `champions.csv` | the [tables](super::tables) of all runs, once all are done |

use std::collections::BTreeMap;
use std::fmt;
use std::fs;
use std::io;
use std::path::{Component, Path, PathBuf};
use std::str::FromStr;

use oneiro_base::console::counted;
use oneiro_base::disk::{self, LOCK};
use oneiro_base::exit::{Failure, Result};
use oneiro_base::files;
use oneiro_base::files::directory::{Form, Holds};
use oneiro_base::plain;
use serde::{Deserialize, Serialize};

use super::file::{Reality, Robots};
use super::journal::{Line, Logged};
use super::{Plan, RunIndex, Sweep};
use crate::experiment::kinds::{MADE, is_run};

const SWEEP: &str = "sweep.toml";
const NAMED: &str = "sweep";
const EXPERIMENT: &str = "experiment";
const SHARD: &str = "shard-";

/// A sweep's directory.
const FORM: Form<'_> = Form {
    mark: MADE,
    before: &[SWEEP, NAMED, EXPERIMENT],
    option: "--out",
};

/// The part of a sweep's runs that one process does: every `of`-th run, beginning with number `index`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Shard {
    /// From 1.
    pub index: u32,
    pub of: u32,
}

impl Shard {
    /// All runs.
    pub const ALL: Self = Self { index: 1, of: 1 };

    /// The shard's runs.
    pub fn runs(self, all: usize) -> impl Iterator<Item = RunIndex> {
        (self.index - 1..all as RunIndex).step_by(self.of as usize)
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.index, self.of)
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        const GREATEST: u32 = 100_000;
        let numbers = text
            .split_once('/')
            .and_then(|(index, of)| Some((index.parse().ok()?, of.parse().ok()?)));
        match numbers {
            Some((index, of)) if 1 <= index && index <= of && of <= GREATEST => Ok(Self { index, of }),
            _ => Err(format!(
                "allowed: I/N with I from 1 to N, N up to {GREATEST}, such as 3/8"
            )),
        }
    }
}

/// Origin of a directory: results of another program or of other runs are never mixed with it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Made {
    format: String,
    version: u32,
    /// The program's version, and the hash of its kernels.
    program: String,
    kernels: String,
    /// Path of the experiment's file in the directory.
    experiment: PathBuf,
    /// Path of the folder in the directory from which the files that the sweep's file names are looked for.
    folder: PathBuf,
    /// Name of the sweep.
    pub name: String,
    pub runs: usize,
    pub cells: usize,
    /// Total robot-steps of all runs.
    pub steps: u64,
    /// Hash of all runs' ids, and of the settings of reality.
    identity: String,
}

const FORMAT: &str = "oneiro sweep";
/// Version 3 had values without names.
const VERSION: u32 = 4;

/// Keys that every version writes.
#[derive(Debug, Deserialize)]
struct Head {
    format: String,
    version: u32,
    program: String,
}

impl Head {
    /// Refuses directories made by another version of the program, naming it.
    fn is_own(&self) -> std::result::Result<(), String> {
        let Self {
            format,
            version,
            program,
        } = self;
        let own = env!("CARGO_PKG_VERSION");
        if (format.as_str(), *version) != (FORMAT, VERSION) {
            return Err(format!(
                "is of version {version} of the format \"{format}\"; allowed: version {VERSION} of \"{FORMAT}\". Finish it with \
                 the program that began it, or begin again in another directory"
            ));
        }
        if program != own {
            return Err(format!("was made by oneiro {program}; this is {own}"));
        }
        Ok(())
    }
}

impl Made {
    fn new(sweep: &Sweep, plan: &Plan) -> Self {
        Self {
            format: FORMAT.into(),
            version: VERSION,
            program: env!("CARGO_PKG_VERSION").into(),
            kernels: kernels(),
            experiment: PathBuf::new(),
            folder: PathBuf::new(),
            name: sweep.name().into(),
            runs: sweep.runs(),
            cells: sweep.file().cells(),
            steps: plan.steps(sweep, 0..sweep.runs() as RunIndex),
            identity: identity(sweep, plan).to_hex().to_string(),
        }
    }

    /// Reason why another directory's results don't belong with these.
    fn differs_from(&self, other: &Self) -> Option<String> {
        if self.kernels != other.kernels {
            return Some(format!(
                "was made with other kernels ({:.8}; this program's are {:.8})",
                other.kernels, self.kernels
            ));
        }
        if (self.runs, self.cells) != (other.runs, other.cells) {
            return Some(format!(
                "is of another sweep, of {} in {}; this one has {} in {}",
                counted(other.runs, "run", "runs"),
                counted(other.cells, "cell", "cells"),
                self.runs,
                self.cells
            ));
        }
        (self.identity != other.identity).then(|| {
            "is of another sweep: as many runs, but of other values, seeds or files; compare its sweep.toml and \
             experiment with yours"
                .into()
        })
    }
}

/// Hash of everything that decides a sweep's results.
fn identity(sweep: &Sweep, plan: &Plan) -> blake3::Hash {
    let mut hasher = blake3::Hasher::new();
    for id in &plan.ids {
        hasher.update(id.as_bytes());
    }
    match &sweep.file().reality {
        Some(Reality {
            robots: Robots::Own(_), ..
        }) => {
            hasher.update(b"own");
        }
        Some(
            reality @ Reality {
                robots: Robots::Numbered(robots),
                ..
            },
        ) => {
            hasher.update(&reality.severity().to_bits().to_le_bytes());
            for robot in robots {
                hasher.update(&robot.to_le_bytes());
            }
        }
        None => (),
    }
    hasher.finalize()
}

/// Hash of the kernels' sources: another kernel may give other bits.
fn kernels() -> String {
    let mut hasher = blake3::Hasher::new();
    for kernel in oneiro_shaders::KERNELS {
        hasher.update(kernel.wgsl.as_bytes());
    }
    hasher.finalize().to_hex().to_string()
}

/// A sweep's directory.
#[derive(Debug)]
pub struct Store {
    directory: PathBuf,
    made: Made,
}

/// A finished run, and the shard whose journal has it.
#[derive(Clone, Debug)]
pub struct Finished {
    pub shard: usize,
    pub line: Line,
}

/// Work finished by all shards.
#[derive(Debug, Default)]
pub struct AllFinished {
    /// Directories of the shards.
    pub shards: Vec<PathBuf>,
    /// Finished runs by index.
    pub runs: BTreeMap<RunIndex, Finished>,
    /// Warnings about damaged lines.
    pub problems: Vec<String>,
}

impl Store {
    /// Makes a sweep's directory, or checks that an existing one belongs to this sweep.
    ///
    /// # Errors
    /// Exit 3 if the directory holds something else, or results of another sweep or program, with the difference; exit
    /// 6 if writing fails.
    pub fn prepare(directory: &Path, sweep: &Sweep, plan: &Plan) -> Result<Self> {
        let made = Made::new(sweep, plan);
        files::must_not_be_file(directory)?;
        plain::make_directory(directory).map_err(|error| Failure::unreadable(directory, &error))?;
        if Self::made(directory)?.is_none() {
            Self::make(directory, sweep, plan, made.clone())?;
        }
        if let Some(difference) = Self::made(directory)?.and_then(|other| made.differs_from(&other)) {
            return Err(Failure::input(format_args!(
                "{}: {difference}; name another directory with --out",
                directory.display()
            )));
        }
        Ok(Self {
            directory: directory.to_owned(),
            made,
        })
    }

    /// Shards may begin at the same time: the first one makes the directory.
    fn make(directory: &Path, sweep: &Sweep, plan: &Plan, made: Made) -> Result {
        // Directories of something else don't even get a lock file.
        if FORM.refuse_others(directory)? == Holds::Mark {
            return Ok(());
        }
        let path = directory.join(LOCK);
        let lock = disk::lock_file(&path)?;
        lock.lock().map_err(|error| Failure::storage(&path, &error))?;
        if Self::made(directory)?.is_some() {
            return Ok(());
        }
        let [folder, experiment] = bring(directory, sweep)?;
        let made = Made {
            experiment,
            folder,
            ..made
        };
        super::contents::describe(directory, sweep, plan)?;
        disk::write(&directory.join(MADE), &disk::json(&made))?;
        disk::sync_directory(directory)
    }

    /// Opens a sweep's directory.
    ///
    /// # Errors
    /// Exit 3 if it isn't one.
    pub fn open(directory: &Path) -> Result<Self> {
        let refused = |problem: &str| Err(Failure::input(format_args!("{}: {problem}", directory.display())));
        if let Err(error) = fs::metadata(directory) {
            return Err(Failure::unreadable(directory, &error));
        }
        if directory.is_file() {
            return refused("is a file; allowed: the directory of a sweep");
        }
        if is_run(directory) {
            return refused("is a run's directory, not a sweep's; allowed: one that `oneiro sweep run` wrote");
        }
        let Some(made) = Self::made(directory)? else {
            return refused(&format!("is not a sweep directory: there is no {MADE} in it"));
        };
        Ok(Self {
            directory: directory.to_owned(),
            made,
        })
    }

    /// Origin of a directory, if it is a sweep's.
    fn made(directory: &Path) -> Result<Option<Made>> {
        let path = directory.join(MADE);
        let bytes = match plain::read(&path, plain::MAXIMUM_NOTE) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(Failure::unreadable(&path, &error)),
        };
        let head: Head = disk::parsed(&path, &bytes)?;
        // First of all: files of another version may have other keys.
        head.is_own()
            .map_err(|difference| Failure::input(format_args!("{}: {difference}", directory.display())))?;
        disk::parsed(&path, &bytes).map(Some)
    }

    /// Path of the directory.
    pub fn directory(&self) -> &Path {
        &self.directory
    }

    /// Origin of the directory.
    pub fn what(&self) -> &Made {
        &self.made
    }

    /// The sweep with all its runs.
    ///
    /// # Errors
    /// Exit 3 if this program would give other results for it.
    pub fn sweep(&self) -> Result<(Sweep, Plan)> {
        let paths = [Path::new(SWEEP), &self.made.experiment, &self.made.folder];
        let [file, experiment, folder] = paths.map(|name| self.directory.join(name));
        let sweep = Sweep::moved(&self.made.name, &file, experiment, &folder)?;
        let plan = sweep.plan()?;
        match Made::new(&sweep, &plan).differs_from(&self.made) {
            None => Ok((sweep, plan)),
            Some(difference) => Err(Failure::input(format_args!(
                "{}: {difference}",
                self.directory.display()
            ))),
        }
    }

    /// Hash that its shards' checkpoints carry.
    pub fn identity(&self) -> Result<blake3::Hash> {
        blake3::Hash::from_hex(&self.made.identity).map_err(|error| {
            Failure::corrupt(format_args!(
                "{}: identity: {error}",
                self.directory.join(MADE).display()
            ))
        })
    }

    /// Path of a shard's journal.
    pub fn journal(&self, shard: Shard) -> PathBuf {
        self.directory.join(Self::journal_name(shard))
    }

    fn journal_name(shard: Shard) -> String {
        format!("{SHARD}{}-of-{}", shard.index, shard.of)
    }

    /// Path of a shard's journal, which is made.
    ///
    /// # Errors
    /// Exit 3 if a link or a file has its name; exit 6.
    pub fn make_journal(&self, shard: Shard) -> Result<PathBuf> {
        disk::make_folder(&self.directory, Self::journal_name(shard))
    }

    /// Existing journals, in the order of their shards.
    pub fn journals(&self) -> Result<Vec<(Shard, PathBuf)>> {
        let failed = |error| Failure::storage(&self.directory, &error);
        let mut found = Vec::new();
        for entry in fs::read_dir(&self.directory).map_err(failed)? {
            let entry = entry.map_err(failed)?;
            let name = entry.file_name();
            let shard = name
                .to_str()
                .and_then(|name| name.strip_prefix(SHARD)?.replace("-of-", "/").parse::<Shard>().ok());
            found.extend(shard.map(|shard| (shard, entry.path())));
        }
        found.sort();
        Ok(found)
    }

    /// Checks that another directory has results of the same sweep by the same program.
    ///
    /// # Errors
    /// Exit 3 with the difference.
    pub fn fits(&self, other: &Self) -> Result {
        match self.made.differs_from(&other.made) {
            None => Ok(()),
            Some(difference) => Err(Failure::input(format_args!(
                "{}: {difference}; allowed: shards of the sweep in {}",
                other.directory.display(),
                self.directory.display()
            ))),
        }
    }

    /// Adds the runs that any shard has finished. `ids` are the sweep's, if known.
    ///
    /// # Errors
    /// Exit 5 if two shards have different results of the same run.
    pub fn finished(&self, ids: Option<&[blake3::Hash]>, all: &mut AllFinished) -> Result {
        for (_, directory) in self.journals()? {
            let Logged { lines, problems, .. } = Logged::read(&directory)?;
            all.problems.extend(problems);
            self.add(directory, lines, ids, all)?;
        }
        Ok(())
    }

    /// Adds the finished runs of one shard.
    ///
    /// # Errors
    /// As [`Store::finished`].
    pub fn add(
        &self,
        directory: PathBuf,
        lines: Vec<Line>,
        ids: Option<&[blake3::Hash]>,
        all: &mut AllFinished,
    ) -> Result {
        let shard = all.shards.len();
        for line in lines {
            let is_known = match ids {
                Some(ids) => ids
                    .get(line.run as usize)
                    .is_some_and(|id| id.to_hex().as_str() == line.id),
                None => (line.run as usize) < self.made.runs,
            };
            if !is_known {
                return Err(Failure::corrupt(format_args!(
                    "{}: has run {} with the id {}, which is none of this sweep's",
                    directory.display(),
                    line.run,
                    line.id
                )));
            }
            if let Some(other) = all.runs.get(&line.run)
                && (&other.line.result, &other.line.outcomes, &other.line.blake3)
                    != (&line.result, &line.outcomes, &line.blake3)
            {
                return Err(Failure::corrupt(format_args!(
                    "run {} has the result {} in {} and {} in {}; one of the machines can't be trusted: \
                         `oneiro device test` tells which",
                    line.run,
                    other.line.result,
                    all.shards
                        .get(other.shard)
                        .map_or_else(|| directory.display(), |other| other.display()),
                    line.result,
                    directory.display()
                )));
            }
            all.runs.insert(line.run, Finished { shard, line });
        }
        all.shards.push(directory);
        Ok(())
    }
}

/// Copies the sweep's file, the experiment's, and the files that they name, so that the directory can be moved. Files
/// with absolute paths stay where they are. Returns the new paths of the folder from which the sweep's file names files, and
/// of the experiment's file.
fn bring(directory: &Path, sweep: &Sweep) -> Result<[PathBuf; 2]> {
    let (experiment, text) = sweep.experiment();
    let name = PathBuf::from(experiment.file_name().unwrap_or_default());
    let named = |of_sweep| {
        let files = sweep.files(of_sweep).into_iter();
        files.map(|(name, content)| (name.into(), content.bytes.clone()))
    };
    let own = (name.clone(), text.as_bytes().to_vec());
    let experiment = copied(directory, EXPERIMENT, std::iter::once(own).chain(named(false)))?.join(name);
    let folder = copied(directory, NAMED, named(true))?;
    let path = sweep.path();
    disk::write(&directory.join(SWEEP), &files::bytes(path)?)?;
    Ok([folder, experiment])
}

/// Copies files with relative names below a folder of the directory, and returns the folder that the names start from.
fn copied(directory: &Path, root: &str, files: impl Iterator<Item = (PathBuf, Vec<u8>)>) -> Result<PathBuf> {
    let files: Vec<_> = files.filter(|(name, _)| name.is_relative()).collect();
    // Nested as deep as names lead up, so that all of them stay inside.
    let is_up = |part: &Component<'_>| *part == Component::ParentDir;
    let ups = files
        .iter()
        .map(|(name, _)| name.components().filter(is_up).count())
        .max();
    let below = std::iter::repeat_n("below", ups.unwrap_or(0));
    let own: PathBuf = std::iter::once(root).chain(below).collect();
    if !files.is_empty() {
        // Names lead up from it.
        disk::make_folder(directory, &own)?;
    }
    for (name, bytes) in files {
        let path = own.join(name);
        let folder = inside(path.parent().unwrap_or(Path::new("")));
        let folder = disk::make_folder(directory, folder)?;
        disk::write(&folder.join(path.file_name().unwrap_or_default()), &bytes)?;
        disk::sync_directory(&folder)?;
    }
    Ok(own)
}

/// A path without its steps upwards.
fn inside(path: &Path) -> PathBuf {
    let mut inside = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir => drop(inside.pop()),
            part => inside.push(part),
        }
    }
    inside
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_share_all_runs_out() {
        for of in [1, 3, 7] {
            let mut runs: Vec<RunIndex> = (1..=of).flat_map(|index| Shard { index, of }.runs(20)).collect();
            runs.sort_unstable();
            assert_eq!(runs, (0..20).collect::<Vec<_>>());
        }
        assert_eq!("3/8".parse(), Ok(Shard { index: 3, of: 8 }));
        for text in ["0/8", "9/8", "3", "a/b", "1/0", "1/1000000", "-1/2"] {
            text.parse::<Shard>().unwrap_err();
        }
    }
}
