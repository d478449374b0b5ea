//! Saved states of optimisers.

use oneiro_base::exit::{Failure, Result};
use oneiro_base::sealed;
use serde::de::DeserializeOwned;

use super::settings::{Ranges, Settings};

pub(super) use oneiro_base::sealed::seal;

/// Hash of everything that decides an optimiser's results besides the fitness and behaviour that it gets.
pub(super) fn owner(settings: &Settings, seed: u64, ranges: &Ranges) -> blake3::Hash {
    let mut decisive = serde_json::to_vec(&(settings, seed, ranges.len())).expect("settings are numbers and words");
    if ranges.iter().any(Option::is_some) {
        decisive.extend(serde_json::to_vec(ranges).expect("ranges are numbers"));
    }
    blake3::hash(&decisive)
}

/// Opens a state.
///
/// # Errors
/// Exit 5 for a state that is damaged, or of another algorithm, version or settings.
pub(super) fn open<T: DeserializeOwned>(name: &str, version: u32, owner: &blake3::Hash, bytes: &[u8]) -> Result<T> {
    sealed::open(name, version, owner, bytes)
        .map_err(|problem| Failure::corrupt(format_args!("the saved state of the optimiser {problem}")))
}

/// Refuses a state that was sealed with other lengths than its optimiser has.
pub(super) fn corrupt() -> Failure {
    Failure::corrupt("the saved state of the optimiser has other lengths")
}
