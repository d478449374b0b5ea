//! Where runs go, and from which seeds they start.

use std::hash::BuildHasher;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use crate::cli;
use crate::console::Console;

/// The seeds and their runs' directories; `own` is the experiment's seed, `name` what a run's directory is called where
/// the user names none.
pub(super) fn seeds_and_places(
    arguments: &cli::Run,
    own: Option<u64>,
    console: Console,
    name: impl Fn(u64) -> String,
) -> Vec<(u64, PathBuf)> {
    let usual = |seed: u64| Path::new("runs").join(name(seed));
    if let Some(seeds) = &arguments.seeds {
        let own = |seed| arguments.out.as_ref().map(|out| out.join(format!("seed-{seed}")));
        return seeds
            .clone()
            .map(|seed| (seed, own(seed).unwrap_or_else(|| usual(seed))))
            .collect();
    }
    let seed = arguments.seed.or(own).unwrap_or_else(|| {
        let seed = drawn_seed();
        console.say(format!("seed {seed}, drawn"));
        seed
    });
    vec![(seed, arguments.out.clone().unwrap_or_else(|| usual(seed)))]
}

/// A seed that nobody chose, below 2^53 so that every reader of JSON reads it right.
fn drawn_seed() -> u64 {
    // The system draws the keys of this hasher.
    std::hash::RandomState::new().hash_one(SystemTime::now()) >> 11
}
