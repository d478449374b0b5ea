//! An experiment: a run's complete configuration but its seed, from one TOML file.

mod check;
mod inputs;
pub(crate) mod settings;
mod source;
pub(crate) mod swarm;
mod world;

use std::path::Path;

use oneiro::world::World;

use crate::evolve::Population;
use crate::exit::Result;
use crate::files;
pub(crate) use inputs::DIRECTORY as INPUTS;
use inputs::{Input, Inputs};
use settings::Settings;
use source::Source;

/// A checked experiment, its world, and the files that it names.
#[derive(Debug)]
pub(crate) struct Experiment {
    /// All values, defaults included; files by the names that a run's directory gives them.
    settings: Settings,
    world: World,
    init: Option<Population>,
    inputs: Vec<Input>,
    warnings: Vec<String>,
}

impl Experiment {
    /// Reads an experiment's file, with `key=value` settings that go before what it says. Files that it names are
    /// looked for from where it lies.
    ///
    /// # Errors
    /// Exit 3: the file and the line and column in it (or the setting), the key, what it is, and what is allowed.
    pub(crate) fn read(path: &Path, set: &[String]) -> Result<Self> {
        let text = files::text(path)?;
        let (mut settings, source): (Settings, _) = Source::read(&path.display().to_string(), text, set)?;
        if settings.name.is_empty() {
            settings.name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        }
        Self::new(settings, &source, path.parent().unwrap_or(Path::new("")))
    }

    fn new(mut settings: Settings, source: &Source, directory: &Path) -> Result<Self> {
        check::check(&settings).map_err(|invalid| source.invalid(&invalid.field, &invalid.problem))?;
        check::complete(&mut settings);
        let mut inputs = Inputs::new(directory, source, &settings.files);
        let world = world::world(&settings, source, &mut inputs)?;
        let init = inputs.init(
            settings.evolution.init.as_deref(),
            world.genes(),
            settings.evolution.population,
        )?;
        let (inputs, warnings) = inputs.finish()?;
        inputs::rename(&mut settings, &inputs);
        Ok(Self {
            settings,
            world,
            init,
            inputs,
            warnings,
        })
    }

    /// Its name.
    pub(crate) fn name(&self) -> &str {
        &self.settings.name
    }

    /// All its values.
    pub(crate) fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Where its robots live.
    pub(crate) fn world(&self) -> &World {
        &self.world
    }

    /// The genes to start from, if it names a file of them.
    pub(crate) fn init(&self) -> Option<&Population> {
        self.init.as_ref()
    }

    /// The files that it names, for a run's directory.
    pub(crate) fn inputs(&self) -> &[Input] {
        &self.inputs
    }

    /// What the user should know of its files, although they are allowed.
    pub(crate) fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// The experiment of a run with every default written out, as TOML: read again, it is this run's experiment.
    pub(crate) fn resolved_toml(&self, seed: u64) -> String {
        toml(&Settings {
            seed: Some(seed),
            ..self.settings.clone()
        })
    }

    /// What decides a run's results: the same with nothing of what is recorded, and when.
    pub(crate) fn identity(&self, seed: u64) -> blake3::Hash {
        let record = settings::Record::default();
        blake3::hash(
            toml(&Settings {
                seed: Some(seed),
                record,
                ..self.settings.clone()
            })
            .as_bytes(),
        )
    }
}

fn toml(settings: &Settings) -> String {
    toml::to_string(settings).expect("settings are tables of numbers, words and lists")
}

#[cfg(test)]
mod tests;
