//! Directories of runs and sweeps: those that commands make, and those that people name.

use std::cmp::Reverse;
use std::ffi::OsStr;
use std::fs;
use std::hash::BuildHasher;
use std::io;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;
use std::time::SystemTime;

use oneiro::parameter;
use oneiro_base::console::Console;
use oneiro_base::exit::{Failure, Result};
use oneiro_base::files;
use oneiro_lab::experiment::kinds::{begun, is_run, is_sweep};
use oneiro_lab::record::{self, Begun, Done, RunPlace, Standing, standing};
use oneiro_lab::runs::Experiment;

use crate::cli;

/// Where runs and studies are unless `--out` names a directory.
pub(super) const RUNS: &str = "runs";
/// Where sweeps are then.
pub(super) const SWEEPS: &str = "sweeps";

/// The place of a run.
pub(crate) enum Place {
    /// A directory that somebody has named.
    Directory(PathBuf),
    /// A name: its directory, or the next with a letter if another run has that.
    Name(PathBuf),
}

/// The seeds and their runs' places, and the seed if it was drawn.
pub(super) fn seeds_and_places(arguments: &cli::Run, experiment: &dyn Experiment) -> (Vec<(u64, Place)>, Option<u64>) {
    let usual = |seed: u64| Place::Name(Path::new(RUNS).join(format!("{}-{seed}", experiment.name())));
    if let Some(seeds) = &arguments.seeds {
        let place = |seed| match &arguments.out {
            Some(out) => (seed, Place::Directory(out.join(format!("seed-{seed}")))),
            None => (seed, usual(seed)),
        };
        return (seeds.clone().map(place).collect(), None);
    }
    let given = arguments.seed.or(experiment.seed());
    let seed = given.unwrap_or_else(drawn_seed);
    let place = arguments.out.clone().map_or_else(|| usual(seed), Place::Directory);
    (vec![(seed, place)], given.is_none().then_some(seed))
}

/// Runs by their directories: finished ones with their results, and those to be done, begun ones first.
pub(crate) struct Places {
    pub(crate) done: Vec<(PathBuf, Done)>,
    pub(crate) todo: Vec<RunPlace>,
}

/// Checks all directories before anything begins.
///
/// # Errors
/// Exit 3 if one holds something else; exit 5 if one holds a run that was changed after it was finished.
pub(crate) fn sorted_out(
    places: Vec<(u64, Place)>,
    experiment: &Arc<dyn Experiment>,
    console: Console,
) -> Result<Places> {
    let identities = experiment.identities();
    let (mut done, mut todo, mut new) = (Vec::new(), Vec::new(), Vec::new());
    let all = places.len();
    for (seed, place) in places {
        let identity = identities.of(seed);
        let (directory, standing, name) = match place {
            Place::Directory(directory) => {
                let standing = standing(&directory, identity)?;
                (directory, standing, None)
            }
            Place::Name(name) => {
                let named = record::named(&name, &**experiment, seed, identity)?;
                if let Some(why) = named.why {
                    console.say(why);
                }
                let standing = match named.own {
                    None => Standing::New,
                    Some(Begun::Unfinished(run)) => Standing::Unfinished(run),
                    Some(Begun::Done(done)) => Standing::Done(done),
                };
                (named.directory, standing, Some(name))
            }
        };
        match standing {
            Standing::New => new.push(RunPlace::New {
                experiment: Arc::clone(experiment),
                seed,
                directory,
                name,
            }),
            Standing::Done(result) => done.push((directory, result)),
            Standing::Unfinished(run) => todo.push(RunPlace::Saved(run)),
        }
    }
    if !done.is_empty() {
        already_done(done.len(), all, console);
    }
    if !todo.is_empty() {
        console.say(done_of(todo.len(), all, "continued"));
    }
    todo.extend(new);
    Ok(Places { done, todo })
}

/// What somebody names: a path, or the name of a directory in one of `folders`, or the beginning of a single such name.
///
/// # Errors
/// Exit 3 if there is none, with the nearest name, or if several names begin so.
pub(super) fn found(path: &Path, folders: &[&str], console: Console) -> Result<PathBuf> {
    const SHOWN: usize = 5;
    let is_missing = |error: io::Error| matches!(error.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory);
    if !path.symlink_metadata().is_err_and(is_missing) {
        return Ok(path.to_owned());
    }
    let mut all = Vec::new();
    for folder in folders {
        let within = path.strip_prefix(folder).unwrap_or(path);
        let mut parts = within.components();
        if let (Some(Component::Normal(name)), None) = (parts.next(), parts.next()) {
            let names = directories(Path::new(folder));
            if names.iter().any(|own| own.as_os_str() == name) {
                return Ok(Path::new(folder).join(name));
            }
            all.push((folder, name.to_string_lossy(), names));
        }
    }
    let begins = |start: &str, name: &OsStr| !start.is_empty() && name.as_encoded_bytes().starts_with(start.as_bytes());
    let mut meant: Vec<PathBuf> = Vec::new();
    for (folder, start, names) in &all {
        let own = names.iter().filter(|name| begins(start, name.as_os_str()));
        meant.extend(own.map(|name| Path::new(folder).join(name)));
    }
    let shown = path.display();
    if let [only] = &meant[..] {
        console.say(format!("{shown}: {}", only.display()));
        return Ok(only.clone());
    }
    if !meant.is_empty() {
        let names: Vec<String> = meant
            .iter()
            .take(SHOWN)
            .map(|path| path.display().to_string())
            .collect();
        let more = match meant.len().saturating_sub(SHOWN) {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        return Err(Failure::input(format_args!(
            "{shown}: is the beginning of {} names: {}{more}; allowed: one of them, or enough letters of it",
            meant.len(),
            names.join(", ")
        )));
    }
    let is_alike = |own: &Path| match path.extension() {
        None => own.is_dir(),
        extension => own.extension() == extension,
    };
    let nearest = all.iter().find_map(|(folder, start, names)| {
        let words = names.iter().filter_map(|name| name.to_str());
        parameter::nearest(words, start).map(|name| Path::new(folder).join(name))
    });
    let nearest = nearest.or_else(|| files::nearest(path, is_alike));
    let hint = match nearest {
        Some(nearest) => format!("; did you mean {}?", nearest.display()),
        None if folders.contains(&RUNS) && !newest_first(RUNS, is_run).is_empty() => {
            "; `oneiro list` shows the runs here".to_owned()
        }
        None => String::new(),
    };
    Err(Failure::input(format_args!("{shown}: does not exist{hint}")))
}

/// The run or the directory of runs that is named; otherwise the newest run.
///
/// # Errors
/// As [`found`]; exit 3 if there is no run.
pub(super) fn named_or_newest(named: Option<&Path>, folders: &[&str], console: Console) -> Result<PathBuf> {
    if let Some(path) = named {
        return found(path, folders, console);
    }
    let newest = newest_first(RUNS, is_run).into_iter().next().ok_or_else(no_runs)?;
    console.say(format!("the newest run is {}", newest.display()));
    Ok(newest)
}

/// The sweep that is named; otherwise the newest.
///
/// # Errors
/// As [`found`]; exit 3 if there is no sweep.
pub(super) fn sweep_or_newest(named: Option<&Path>, console: Console) -> Result<PathBuf> {
    if let Some(path) = named {
        return found(path, &[SWEEPS], console);
    }
    let Some(newest) = newest_first(SWEEPS, is_sweep).into_iter().next() else {
        return Err(Failure::input(format_args!(
            "{SWEEPS}: has no sweeps yet; allowed: a sweep's directory, as `oneiro sweep run SWEEP.toml` writes it"
        )));
    };
    console.say(format!("the newest sweep is {}", newest.display()));
    Ok(newest)
}

/// For a command that needs a run where there is none.
pub(super) fn no_runs() -> Failure {
    Failure::input(format_args!(
        "{RUNS}: has no runs yet; `oneiro run EXPERIMENT.toml --seed 1` makes one, and `oneiro new NAME` writes an experiment"
    ))
}

/// The runs or sweeps in a folder: those that were begun last come first.
fn newest_first(folder: &str, is_own: fn(&Path) -> bool) -> Vec<PathBuf> {
    let folder = Path::new(folder);
    let mut all: Vec<PathBuf> = directories(folder).into_iter().map(|name| folder.join(name)).collect();
    all.retain(|directory| is_own(directory));
    sort_by_age(&mut all);
    all
}

/// Sorts runs or sweeps: those that were begun last come first. The names decide between those that were begun at the same time.
pub(super) fn sort_by_age(all: &mut [PathBuf]) {
    all.sort_by(|a, b| files::by_numbers(b, a));
    all.sort_by_cached_key(|directory| Reverse(begun(directory)));
}

/// The names of the directories in a folder, in the order of the numbers in them; none if it can't be read.
fn directories(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let mut names: Vec<PathBuf> = entries
        .filter(|entry| entry.path().is_dir())
        .map(|entry| entry.file_name().into())
        .collect();
    names.sort_by(|a, b| files::by_numbers(a, b));
    names
}

/// The options that set an experiment's values, each after a blank.
pub(super) fn settings_typed(set: &[String]) -> String {
    let typed = set.iter().flat_map(|set| [" --set ".to_owned(), files::for_shell(set)]);
    typed.collect()
}

/// What to type for a directory: its name alone if it is a run or a study of [`RUNS`] or a sweep of [`SWEEPS`], and nothing else has that.
pub(super) fn typed(directory: &Path) -> String {
    let mut name = directory;
    for folder in [RUNS, SWEEPS] {
        if let Ok(within) = directory.strip_prefix(folder)
            && within.components().count() == 1
            && within.symlink_metadata().is_err()
            && (folder == RUNS || Path::new(RUNS).join(within).symlink_metadata().is_err())
        {
            name = within;
        }
    }
    files::for_shell(&name.display().to_string())
}

/// Says how many of all runs need not be done again.
pub(super) fn already_done(done: usize, all: usize, console: Console) {
    console.say(done_of(done, all, "already done"));
}

/// How many of all runs are in a state, such as `1 of 3 runs is done`.
pub(super) fn done_of(count: usize, all: usize, state: &str) -> String {
    match (count, all) {
        (1, 1) => format!("the run is {state}"),
        (0, 1) => format!("the run is not {state}"),
        (1, _) => format!("1 of {all} runs is {state}"),
        _ => format!("{count} of {all} runs are {state}"),
    }
}

/// A random seed below 2^53, so that every JSON reader reads it right.
fn drawn_seed() -> u64 {
    // The operating system draws the keys of this hasher.
    std::hash::RandomState::new().hash_one(SystemTime::now()) >> 11
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_run_is_no_fraction() {
        for (count, all, words) in [
            (1, 1, "the run is done"),
            (0, 1, "the run is not done"),
            (1, 3, "1 of 3 runs is done"),
            (2, 3, "2 of 3 runs are done"),
            (0, 3, "0 of 3 runs are done"),
        ] {
            assert_eq!(done_of(count, all, "done"), words);
        }
    }
}
