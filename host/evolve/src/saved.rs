//! Saved states of optimisers.

use oneiro_base::sealed;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::error::{Error, Result};
use super::settings::{Ranges, Settings};

/// Everything that decides an optimiser's results besides the fitness and behaviour that it gets.
#[derive(Clone, Debug)]
pub(super) struct Owner {
    settings: Settings,
    seed: u64,
    ranges: Ranges,
    hash: blake3::Hash,
}

impl Owner {
    pub(super) fn new(settings: &Settings, seed: u64, ranges: &Ranges) -> Self {
        Self {
            settings: settings.clone(),
            seed,
            ranges: ranges.clone(),
            hash: owner(settings, seed, ranges),
        }
    }

    /// Makes it the owner of states of an evolution with this many generations.
    pub(super) fn set_generations(&mut self, generations: u32) {
        self.settings.generations = generations;
        self.hash = owner(&self.settings, self.seed, &self.ranges);
    }
}

/// Its hash.
fn owner(settings: &Settings, seed: u64, ranges: &Ranges) -> blake3::Hash {
    let mut decisive = serde_json::to_vec(&(settings, seed, ranges.len())).expect("settings are numbers and words");
    if ranges.iter().any(Option::is_some) {
        decisive.extend(serde_json::to_vec(ranges).expect("ranges are numbers"));
    }
    blake3::hash(&decisive)
}

/// Seals a state.
pub(super) fn seal(name: &str, version: u32, owner: &Owner, state: &impl Serialize) -> Vec<u8> {
    sealed::seal(name, version, &owner.hash, state)
}

/// Opens a state.
///
/// # Errors
/// A state that is damaged, or of another algorithm, version or settings.
pub(super) fn open<T: DeserializeOwned>(name: &str, version: u32, owner: &Owner, bytes: &[u8]) -> Result<T> {
    sealed::open(name, version, &owner.hash, bytes).map_err(Error::Sealed)
}

#[cfg(test)]
mod tests {
    use super::super::Kind;
    use super::super::settings::Descriptor;
    use super::*;

    /// States of earlier versions are continued: these hashes are theirs. Later optimisers' values are no part of them
    /// while they have their defaults.
    #[test]
    fn hashes_of_settings_stay() {
        for (kind, expected) in [
            (
                Kind::Genetic,
                "75d6fd73ee9d48ddb76fd866b8e20bb90e71279efc417eec12cdacd8fad6ea07",
            ),
            (
                Kind::OpenEs,
                "b16a436b5e740cc35a7cf10b7f55f8fd5978931171640bc88359ec4582133c2e",
            ),
            (
                Kind::Race,
                "90cd8e3d69990f9b5608782eb46a7c8b8c7641664492832b4269cafb9a41a989",
            ),
        ] {
            let mut settings = Settings {
                kind,
                descriptors: vec![Descriptor::named("x", [0.0, 1.0], 3)],
                ..Settings::default()
            };
            if kind == Kind::OpenEs {
                (settings.strategy.sigma, settings.strategy.learning_rate) = (Some(0.02), Some(0.01));
            }
            let tables = &mut settings.tables;
            (tables.grid.levels, tables.race.lives, tables.opponents.first_gene) = (4, 7000, "a".into());
            settings.complete(3, 2, false);
            assert_eq!(owner(&settings, 1, &vec![None; 3]).to_string(), expected, "{kind:?}");
        }
        let defaults = serde_json::to_string(&Settings::default()).unwrap();
        assert!(
            defaults.ends_with(r#""novelty":{"neighbours":15,"added":6}}"#),
            "{defaults}"
        );
    }
}
