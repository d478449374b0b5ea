//! `DONE`: that a run is finished, and the hashes of what it gave.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::{
    CHAMPION, CHAMPION_GENES, CONFIG, DONE, FITNESS, GENERATIONS, POPULATION, SavedRun, SavedSwarm, disk, is_swarm_run,
};
use crate::exit::{Failure, Result};
use crate::swarm::tables::{FOOD, INTERVALS};

/// The last file of a run. All hashes are BLAKE3.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Done {
    /// The hash of the results: of the lines `HASH  NAME` of the experiment and of each of its results, see [`results`]. The same
    /// for every backend, number of threads, path and time.
    pub(crate) result: String,
    /// The hash of the resolved experiment and the seed.
    pub(crate) experiment: String,
    /// The hash of each file of the run.
    pub(crate) files: BTreeMap<String, String>,
}

/// The files of a run that are results and nothing else, and those of a swarm's.
const RESULTS: [&str; 5] = [GENERATIONS, CHAMPION, CHAMPION_GENES, POPULATION, FITNESS];
const SWARM_RESULTS: [&str; 2] = [INTERVALS, FOOD];

/// The hash of a run's results, as its `DONE` would have it, from what its files would hold.
pub(super) fn result_of(experiment: blake3::Hash, files: &[(&str, &[u8])]) -> String {
    let hash = |(name, bytes): &(&str, &[u8])| ((*name).to_owned(), blake3::hash(bytes).to_hex().to_string());
    Done::new(experiment.to_hex().to_string(), files.iter().map(hash).collect()).result
}

/// The results of a run with these files.
fn results(files: &BTreeMap<String, String>) -> &'static [&'static str] {
    if files.contains_key(INTERVALS) {
        &SWARM_RESULTS
    } else {
        &RESULTS
    }
}

impl Done {
    /// Of an experiment and files with their hashes.
    fn new(experiment: String, files: BTreeMap<String, String>) -> Self {
        let line = |name: &str| format!("{}  {name}\n", files.get(name).map_or("", String::as_str));
        let own: String = results(&files).iter().map(|name| line(name)).collect();
        let lines = format!("{experiment}  experiment\n") + &own;
        Self {
            result: blake3::hash(lines.as_bytes()).to_hex().to_string(),
            experiment,
            files,
        }
    }

    /// Hashes a run's files as they are on the disk.
    pub(super) fn of(directory: &Path, experiment: blake3::Hash, files: &[&str]) -> Result<Self> {
        let hash = |name: &&str| {
            let bytes = disk::read(&directory.join(name))?;
            Ok(((*name).to_owned(), blake3::hash(&bytes).to_hex().to_string()))
        };
        let files = files.iter().map(hash).collect::<Result<_>>()?;
        Ok(Self::new(experiment.to_hex().to_string(), files))
    }

    /// Reads a run's, if it is done.
    pub(crate) fn read(directory: &Path) -> Result<Option<Self>> {
        let path = directory.join(DONE);
        match fs::read(&path) {
            Ok(bytes) => match serde_json::from_slice(&bytes) {
                Ok(done) => Ok(Some(done)),
                Err(error) => Err(Failure::corrupt(format_args!("{}: {error}", path.display()))),
            },
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(Failure::storage(&path, &error)),
        }
    }

    /// Writes a run's.
    pub(super) fn write(&self, directory: &Path) -> Result {
        let mut text = serde_json::to_string_pretty(self).expect("words");
        text.push('\n');
        disk::write(&directory.join(DONE), text.as_bytes())?;
        disk::sync_directory(directory)
    }
}

/// What decides the results of a run of any kind.
fn identity(directory: &Path) -> Result<blake3::Hash> {
    if is_swarm_run(directory) {
        return Ok(SavedSwarm::open(directory)?.identity());
    }
    let run = SavedRun::open(directory)?;
    Ok(run.experiment().identity(run.seed()))
}

/// Checks a finished run: each file's hash, the experiment's, and the result's.
///
/// # Errors
/// Exit 3 when it is no run, exit 1 when it is not finished, exit 5 with all that differs.
pub(crate) fn verify(directory: &Path) -> Result<Done> {
    let identity = identity(directory)?;
    let Some(done) = Done::read(directory)? else {
        return Err(Failure::failed(format_args!(
            "{}: is not finished, so there is nothing to verify",
            directory.display()
        )));
    };
    let names: Vec<&str> = done.files.keys().map(String::as_str).collect();
    let missing = results(&done.files)
        .iter()
        .copied()
        .chain([CONFIG])
        .filter(|name| !names.contains(name))
        .map(|name| format!("{name} is not listed"));
    let mut problems: Vec<String> = missing.collect();
    for name in names {
        match fs::read(directory.join(name)) {
            Ok(bytes) if done.files[name] == blake3::hash(&bytes).to_hex().as_str() => (),
            Ok(_) => problems.push(format!("{name} is not what was recorded")),
            Err(error) => problems.push(format!("{name}: {error}")),
        }
    }
    if done.experiment != identity.to_hex().as_str() {
        problems.push("the experiment is another".into());
    }
    if done.result != Done::new(done.experiment.clone(), done.files.clone()).result {
        problems.push("the result's hash is another".into());
    }
    if problems.is_empty() {
        return Ok(done);
    }
    Err(Failure::corrupt(format_args!(
        "{}: {}",
        directory.display(),
        problems.join("; ")
    )))
}
