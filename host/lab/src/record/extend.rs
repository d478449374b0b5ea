//! A larger budget for a run that was begun with a smaller one: `oneiro resume --generations` and `--episodes`.
//!
//! All files that change are written to a folder, whose renaming decides that the run is extended. From then on, whoever resumes the
//! run moves what is left of them to their places, so a kill at any time leaves the earlier run or the extended one.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use oneiro_base::console::Console;
use oneiro_base::disk;
use oneiro_base::exit::{Failure, Result};
use oneiro_base::plain;
use oneiro_base::utc::now;

use super::meta::Extended;
use super::recorder::{KEPT, Saved, is_busy, unusable};
use super::{CONFIG, DONE, META, Meta, SavedRun, Status};
use crate::engine::checkpoint;
use crate::engine::log::Log;
use crate::experiment::source::Setting;
use crate::runs::{self, Experiment, Recording};

/// The folder of the changed files, before it is complete and since.
const STAGED: &str = "extension.tmp";
const EXTENSION: &str = "extension";

/// A larger budget.
#[derive(Clone, Copy, Debug)]
pub enum Budget {
    Generations(u32),
    Episodes(u64),
}

impl Budget {
    /// Its key in an experiment.
    fn key(self) -> &'static str {
        match self {
            Self::Generations(_) => "evolution.generations",
            Self::Episodes(_) => "evolution.episodes",
        }
    }

    fn value(self) -> u64 {
        match self {
            Self::Generations(count) => count.into(),
            Self::Episodes(count) => count,
        }
    }

    /// The option of the command line, for messages.
    fn option(self) -> String {
        let name = self.key().trim_start_matches("evolution.");
        format!("--{name} {}", self.value())
    }
}

/// A run and the experiment with its larger budget.
#[derive(Debug)]
pub struct Extension {
    run: SavedRun,
    longer: Arc<dyn Experiment>,
    budget: Budget,
}

impl Extension {
    /// Checks that a run can have a larger budget. `None` if it has this one already.
    ///
    /// # Errors
    /// Exit 3 if it isn't a run, if its course depends on its budget, or if the budget isn't larger; exit 5 if its configuration or a
    /// result was changed since it was finished.
    pub fn of(directory: &Path, budget: Budget) -> Result<Option<Self>> {
        let run = SavedRun::open(directory)?;
        run.done()?;
        let (option, shown) = (budget.option(), directory.display());
        let refused = |problem: &str| Failure::input(format_args!("{option}: {shown}: {problem}"));
        let Some(own) = run.experiment().single() else {
            return Err(refused(
                "is a run of the foraging study, whose length is its minutes; allowed: runs of other experiments",
            ));
        };
        if !own.settings().evolution.is_open_ended() {
            let kind = own.evolution(0).optimizer().name();
            return Err(refused(&format!(
                "its optimiser, {kind}, plans all its episodes from the budget; allowed: other optimisers, or a new run with the larger \
                 budget"
            )));
        }
        if own.site().is_some() {
            return Err(refused(
                "its last generations were planned on a robot (reality.generations); allowed: runs without reality.robot, or a new run",
            ));
        }
        let value = i64::try_from(budget.value()).map_err(|_| refused("is too large"))?;
        let setting = Setting::at(format!("{option}: {shown}"), budget.key(), &value.into());
        let longer = runs::recorded_with(&run.config(), &[setting])?;
        let [is, was] = [&longer, run.experiment()].map(|own| own.identities().of(run.seed()));
        if is == was {
            return Ok(None);
        }
        let [new, old] = [&longer, run.experiment()].map(|own| own.length());
        if new <= old {
            let makes = match budget {
                Budget::Generations(_) => String::new(),
                Budget::Episodes(_) => format!("makes {new}, and "),
            };
            return Err(refused(&format!("{makes}the run has {old} generations; allowed: more")));
        }
        Ok(Some(Self { run, longer, budget }))
    }

    /// Gives the run its larger budget; it can be resumed then. Returns a message about it.
    ///
    /// # Errors
    /// Exit 3 if another process writes there, or if another version of the program wrote its checkpoints; exit 5 if none of them is
    /// good; exit 6 if writing fails.
    pub fn make(&self) -> Result<String> {
        let directory = self.run.directory();
        let _lock = disk::try_lock(directory)?.ok_or_else(|| is_busy(directory))?;
        if SavedRun::open(directory)?.identity() != self.run.identity() {
            return Err(Failure::input(format_args!(
                "{}: another process has just changed its budget; allowed: repeat the command",
                directory.display()
            )));
        }
        let staged = directory.join(STAGED);
        remove(&staged)?;
        plain::make_new_directory(&staged).map_err(|error| Failure::storage(&staged, &error))?;
        let from = self.checkpoints(&staged)?;
        let [old, new] = [self.run.experiment(), &self.longer].map(|own| own.length());
        self.note(&staged, from, [old, new])?;
        let config = self.longer.resolved_toml(self.run.seed());
        disk::write(&staged.join(CONFIG), config.as_bytes())?;
        disk::sync_directory(&staged)?;
        rename(&staged, &directory.join(EXTENSION))?;
        disk::sync_directory(directory)?;
        settle(directory)?;
        Ok(format!(
            "{}: {new} generations instead of {old}, continued from generation {from}",
            directory.display()
        ))
    }

    /// Writes the checkpoints of the longer run, and its tables that begin otherwise. Returns the generation of the newest.
    fn checkpoints(&self, staged: &Path) -> Result<u32> {
        let (directory, seed) = (self.run.directory(), self.run.seed());
        let recording = Recording::Directory {
            path: directory,
            console: Console::default(),
        };
        let [old, new] = [self.run.experiment(), &self.longer].map(|own| own.tables(recording));
        let (mut newest, mut problems) = (None, Vec::new());
        for (number, path) in checkpoint::list(directory)? {
            let saved = match checkpoint::read::<Saved>(&path, &self.run.identity()) {
                Ok(saved) => saved,
                Err(problem) => {
                    problems.push((path, problem));
                    continue;
                }
            };
            let mut tables = Vec::new();
            for ((old, new), extent) in old.iter().zip(&new).zip(&saved.tables) {
                let path = directory.join(old.file);
                let target = newest.is_none().then(|| staged.join(old.file));
                let replaced = Log::with_head(&path, extent, old.head.len(), &new.head, target.as_deref())?;
                tables.push(replaced.ok_or_else(|| {
                    Failure::corrupt(format_args!("{}: is not what it was at its checkpoint", path.display()))
                })?);
            }
            let longer = Saved {
                progress: saved.progress,
                tables,
                job: self.longer.extended(&**self.run.experiment(), seed, &saved.job)?,
            };
            checkpoint::write(staged, number, KEPT, &self.longer.identities().of(seed), &longer)?;
            newest = newest.or(Some(longer.progress.done));
        }
        match newest {
            None if !problems.is_empty() => Err(unusable(directory, &problems)),
            newest => Ok(newest.unwrap_or(0)),
        }
    }

    /// Writes the metadata of the longer run.
    fn note(&self, staged: &Path, from: u32, generations: [u32; 2]) -> Result {
        let Some(mut meta) = Meta::read(self.run.directory()) else {
            return Ok(());
        };
        meta.extended.push(Extended {
            at: now(),
            key: self.budget.key().into(),
            value: self.budget.value(),
            generations,
            from_generation: from,
            result: self.run.done()?.map(|done| done.result),
        });
        meta.status = Status::Stopped;
        meta.generation = from;
        meta.generations = generations[1];
        meta.budget = self.longer.budget();
        disk::write(&staged.join(META), &disk::json(&meta))
    }
}

/// Whether a kill has left an extension of a run that is decided, but not complete.
pub(super) fn is_unsettled(directory: &Path) -> bool {
    directory.join(EXTENSION).symlink_metadata().is_ok()
}

/// Completes an extension that was killed.
///
/// # Errors
/// Exit 3 if another process writes there; exit 6.
pub fn complete(directory: &Path) -> Result {
    if !is_unsettled(directory) {
        return Ok(());
    }
    let _lock = disk::try_lock(directory)?.ok_or_else(|| is_busy(directory))?;
    settle(directory)
}

/// Moves the files of an extension to their places, the configuration last.
fn settle(directory: &Path) -> Result {
    let extension = directory.join(EXTENSION);
    let failed = |error| Failure::storage(&extension, &error);
    // A run may come from someone else, with a link in this place.
    if !extension.symlink_metadata().map_err(failed)?.is_dir() {
        return Err(is_no_extension(&extension));
    }
    let mut names = Vec::new();
    for entry in fs::read_dir(&extension).map_err(failed)? {
        let entry = entry.map_err(failed)?;
        if !entry.file_type().map_err(failed)?.is_file() {
            return Err(is_no_extension(&entry.path()));
        }
        names.push(entry.file_name());
    }
    let done = directory.join(DONE);
    if !names.is_empty() && done.symlink_metadata().is_ok() {
        fs::remove_file(&done).map_err(|error| Failure::storage(&done, &error))?;
        disk::sync_directory(directory)?;
    }
    names.sort_by_key(|name| name == CONFIG);
    for name in names {
        if name == CONFIG {
            disk::sync_directory(directory)?;
        }
        rename(&extension.join(&name), &directory.join(&name))?;
    }
    disk::sync_directory(directory)?;
    remove(&extension)?;
    disk::sync_directory(directory)
}

fn is_no_extension(path: &Path) -> Failure {
    Failure::input(format_args!(
        "{}: is not what `oneiro resume --generations` writes; allowed: remove it",
        path.display()
    ))
}

fn rename(from: &Path, to: &Path) -> Result {
    fs::rename(from, to).map_err(|error| Failure::storage(to, &error))
}

/// Removes a folder, if it is there.
fn remove(folder: &Path) -> Result {
    if folder.symlink_metadata().is_err() {
        return Ok(());
    }
    fs::remove_dir_all(folder).map_err(|error| Failure::storage(folder, &error))
}
