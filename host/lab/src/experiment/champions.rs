//! Champions of finished runs, with which an evolution may begin. Only files are read: nothing here runs an experiment.

use std::collections::BTreeMap;
use std::path::Path;

use oneiro::world::GeneLayout;
use oneiro_base::disk;
use oneiro_base::exit::{Failure, Result};
use oneiro_base::files;
use oneiro_base::plain;
use serde::Deserialize;

use super::kinds::{CHAMPION_GENES, CONFIG, DONE, is_run};
use super::source::Parsed;
use super::{Experiment, Files};
use crate::genomes;

/// A run's champion, in the directory of that name among the copies of a sweep.
pub(super) const COPY: &str = "genome.json";

/// The part of a run's `DONE` that is read here.
#[derive(Deserialize)]
struct Done {
    result: String,
    files: BTreeMap<String, String>,
}

/// A file with the champion of a finished run and the names of its genes, given the run's directory or a sweep's copy of it.
///
/// # Errors
/// Exit 3 if it is neither, or of the foraging study; exit 1 if the run isn't finished; exit 5 if it was changed since.
pub(super) fn read(directory: &Path) -> Result<Vec<u8>> {
    let shown = directory.display();
    let copy = directory.join(COPY);
    if !is_run(directory) {
        if copy.is_file() {
            return files::bytes(&copy);
        }
        return Err(Failure::input(format_args!(
            "{shown}: is a directory, but no run's; allowed: a file of genomes, or a run's directory"
        )));
    }
    let layout = layout(directory)?;
    let Some(done) = disk::json_if_there::<Done>(&directory.join(DONE))? else {
        return Err(Failure::failed(format_args!(
            "{shown}: is not finished, so it has no champion yet; `oneiro resume {shown}` continues it"
        )));
    };
    for name in [CONFIG, CHAMPION_GENES] {
        let path = directory.join(name);
        let hash = plain::hash(&path).map_err(|error| Failure::storage(&path, &error))?;
        if done.files.get(name).is_none_or(|known| hash.to_hex().as_str() != known) {
            return Err(Failure::corrupt(format_args!(
                "{shown}: {name} is not what was recorded; this was changed since the run was finished"
            )));
        }
    }
    let champion = genomes::recorded(&directory.join(CHAMPION_GENES), &layout)?;
    Ok(genomes::json(champion.genome(0), &layout.names(), &done.result))
}

/// The genes of a run's controller.
///
/// # Errors
/// Exit 3 if its configuration is invalid, or of the foraging study.
pub(super) fn layout(directory: &Path) -> Result<GeneLayout> {
    let config = directory.join(CONFIG);
    let text = files::text(&config)?;
    let values = Parsed::new(config.display().to_string(), &text)?.recorded();
    if values.has("swarm") {
        return Err(Failure::input(format_args!(
            "{}: is a run of the foraging study, whose controllers evolve together; allowed: runs of other experiments",
            directory.display()
        )));
    }
    let experiment = Experiment::of(&config, &values, &[], &Files::default())?;
    Ok(experiment.world().gene_layout().clone())
}
