//! `DONE`: marks a run as finished, with the hashes of its results.

use std::collections::BTreeMap;
use std::io;
use std::path::Path;

use oneiro_base::disk;
use oneiro_base::exit::{Failure, Result};
use oneiro_base::plain;
use serde::{Deserialize, Serialize};

use super::{CONFIG, DONE, SavedRun};

/// The last file of a run. All hashes are BLAKE3.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Done {
    /// Hash of the results: of the lines `HASH  NAME` of the experiment and of each of its results. The same for every backend, number of threads, path and time.
    pub result: String,
    /// Hash of the resolved experiment and the seed.
    pub experiment: String,
    /// Hash of each file of the run.
    pub files: BTreeMap<String, String>,
}

/// Hash of a run's results, as in its `DONE`, from the contents of its files.
pub(crate) fn result_of(experiment: blake3::Hash, results: &[&str], files: &[(&str, &[u8])]) -> String {
    result(&experiment.to_hex(), results, |name| {
        let (_, bytes) = files.iter().find(|(own, _)| *own == name)?;
        Some(blake3::hash(bytes).to_hex())
    })
}

/// Hash of results, from the hash of each file.
fn result<S: AsRef<str>>(experiment: &str, results: &[&str], hash_of: impl Fn(&str) -> Option<S>) -> String {
    let mut lines = String::with_capacity(96 * (1 + results.len()));
    lines.extend([experiment, "  experiment\n"]);
    for name in results {
        lines += hash_of(name).as_ref().map_or("", AsRef::as_ref);
        lines.extend(["  ", name, "\n"]);
    }
    blake3::hash(lines.as_bytes()).to_hex().to_string()
}

impl Done {
    /// Makes it from an experiment, files with their hashes, and the names of the results among them.
    fn new(experiment: String, files: BTreeMap<String, String>, results: &[&str]) -> Self {
        Self {
            result: result(&experiment, results, |name| files.get(name)),
            experiment,
            files,
        }
    }

    /// Hashes a run's files on disk.
    pub(super) fn of(directory: &Path, experiment: blake3::Hash, files: &[&str], results: &[&str]) -> Result<Self> {
        let hash = |name: &&str| {
            let path = directory.join(name);
            let hash = plain::hash(&path).map_err(|error| Failure::storage(&path, &error))?;
            Ok(((*name).to_owned(), hash.to_hex().to_string()))
        };
        let files = files.iter().map(hash).collect::<Result<_>>()?;
        Ok(Self::new(experiment.to_hex().to_string(), files, results))
    }

    /// Reads a run's `DONE`, if it is finished. What it says may not be true: see [`SavedRun::done`].
    pub(super) fn read(directory: &Path) -> Result<Option<Self>> {
        disk::json_if_there(&directory.join(DONE))
    }

    /// Writes a run's `DONE`.
    pub(super) fn write(&self, directory: &Path) -> Result {
        disk::write(&directory.join(DONE), &disk::json(self))?;
        disk::sync_directory(directory)
    }
}

/// Checks a finished run: each file's hash, the experiment's, and the result's.
///
/// # Errors
/// Exit 3 if it isn't a run, exit 1 if it isn't finished, exit 5 with everything that differs.
pub fn verify(directory: &Path) -> Result<Done> {
    let run = SavedRun::open(directory)?;
    let Some(done) = Done::read(directory)? else {
        return Err(Failure::failed(format_args!(
            "{0}: is not finished, so there is nothing to verify; `oneiro resume {0}` continues it",
            directory.display()
        )));
    };
    done.check(&run, |_| true)?;
    Ok(done)
}

impl Done {
    /// Checks it against a run: the files that `is_checked` accepts, including the configuration and the results.
    ///
    /// # Errors
    /// Exit 5 with everything that differs.
    pub(super) fn check(&self, run: &SavedRun, is_checked: impl Fn(&str) -> bool) -> Result {
        let directory = run.directory();
        let results = run.experiment().results();
        let mut problems = Vec::new();
        for name in results.iter().copied().chain([CONFIG]) {
            if !self.files.contains_key(name) {
                problems.push(format!("{name} is not listed"));
            }
        }
        for (name, hash) in &self.files {
            if !is_checked(name) {
                continue;
            }
            match plain::hash(&directory.join(name)) {
                Ok(found) if found.to_hex().as_str() == hash => (),
                Ok(_) => problems.push(format!("{name} is not what was recorded")),
                Err(error) if error.kind() == io::ErrorKind::NotFound => problems.push(format!("{name} is missing")),
                Err(error) => problems.push(format!("{name}: {error}")),
            }
        }
        let identity = run.identity().to_hex();
        if self.experiment != identity.as_str() {
            problems.push("the experiment is another".into());
        }
        if self.result != Self::new(self.experiment.clone(), self.files.clone(), &results).result {
            problems.push("the result's hash is another".into());
        }
        if problems.is_empty() {
            return Ok(());
        }
        Err(Failure::corrupt(format_args!(
            "{}: {}; this was changed since the run was finished",
            directory.display(),
            problems.join("; ")
        )))
    }
}
