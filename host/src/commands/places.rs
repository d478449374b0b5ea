//! Directories of runs, and their seeds.

use std::hash::BuildHasher;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use oneiro_base::console::Console;
use oneiro_base::exit::Result;
use oneiro_lab::record::{Done, SavedRun, Standing, standing};

use crate::cli;

/// The seeds and their runs' directories, and the seed if it was drawn. `own` is the experiment's seed; `name` makes the
/// default name of a run's directory.
pub(super) fn seeds_and_places(
    arguments: &cli::Run,
    own: Option<u64>,
    name: impl Fn(u64) -> String,
) -> (Vec<(u64, PathBuf)>, Option<u64>) {
    let usual = |seed: u64| Path::new("runs").join(name(seed));
    if let Some(seeds) = &arguments.seeds {
        let own = |seed| arguments.out.as_ref().map(|out| out.join(format!("seed-{seed}")));
        let place = |seed| (seed, own(seed).unwrap_or_else(|| usual(seed)));
        return (seeds.clone().map(place).collect(), None);
    }
    let given = arguments.seed.or(own);
    let seed = given.unwrap_or_else(drawn_seed);
    let place = (seed, arguments.out.clone().unwrap_or_else(|| usual(seed)));
    (vec![place], given.is_none().then_some(seed))
}

/// Runs by their directories: finished ones with their results, those that were begun, and new ones with their seeds.
pub(crate) struct Places {
    pub(crate) done: Vec<(PathBuf, Done)>,
    pub(crate) unfinished: Vec<SavedRun>,
    pub(crate) new: Vec<(u64, PathBuf)>,
}

/// Checks all directories before anything begins.
///
/// # Errors
/// Exit 3 if one holds something else; exit 5 if one holds a run that was changed after it was finished.
pub(crate) fn sorted_out(
    places: Vec<(u64, PathBuf)>,
    identity: impl Fn(u64) -> blake3::Hash,
    console: Console,
) -> Result<Places> {
    let mut sorted = Places {
        done: Vec::new(),
        unfinished: Vec::new(),
        new: Vec::new(),
    };
    let all = places.len();
    for (seed, directory) in places {
        match standing(&directory, identity(seed))? {
            Standing::New => sorted.new.push((seed, directory)),
            Standing::Done(result) => sorted.done.push((directory, result)),
            Standing::Unfinished(run) => sorted.unfinished.push(run),
        }
    }
    if !sorted.done.is_empty() {
        already_done(sorted.done.len(), all, console);
    }
    if !sorted.unfinished.is_empty() {
        let are = if sorted.unfinished.len() == 1 { "was" } else { "were" };
        console.say(format!(
            "{} of {all} runs {are} begun before, and continue",
            sorted.unfinished.len()
        ));
    }
    Ok(sorted)
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
