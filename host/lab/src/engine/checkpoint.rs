//! Checkpoints: everything that jobs need in order to resume, in a [sealed] file, which never loads if a bit of it is wrong. Run
//! directories and shards of sweeps use the same files, `checkpoint-N`, and keep the two newest.

use std::fs;
use std::path::{Path, PathBuf};

use oneiro_base::disk;
use oneiro_base::exit::{Failure, Result};
use oneiro_base::plain;
use oneiro_base::sealed::{self, Problem};
use serde::Serialize;
use serde::de::DeserializeOwned;

const FORMAT: &str = "oneiro checkpoint";
/// Version 1 had two formats, of runs and of sweeps; version 2 had no outcomes of runs; version 3 had no rounds of races.
const VERSION: u32 = 5;
const PREFIX: &str = "checkpoint-";

/// Explains why a checkpoint can't be used; `owner` is the run or sweep that it should belong to.
pub(crate) fn words(problem: &Problem, owner: &str) -> String {
    match problem {
        Problem::Damaged => problem.to_string(),
        Problem::Owner => format!("belongs to another {owner}"),
        Problem::Other(_) => "was written by another version of oneiro".into(),
    }
}

/// Writes a checkpoint and waits until it is on disk. Keeps the newest `kept` and removes the others.
///
/// # Errors
/// Exit 6 if writing fails.
pub(crate) fn write(
    directory: &Path,
    number: u64,
    kept: usize,
    identity: &blake3::Hash,
    content: &impl Serialize,
) -> Result {
    disk::write(
        &directory.join(format!("{PREFIX}{number}")),
        &sealed::seal(FORMAT, VERSION, identity, content),
    )?;
    disk::sync_directory(directory)?;
    prune(directory, kept)
}

/// Removes all checkpoints except the newest `kept`.
///
/// # Errors
/// Exit 6.
pub(crate) fn prune(directory: &Path, kept: usize) -> Result {
    for (_, path) in list(directory)?.into_iter().skip(kept) {
        fs::remove_file(&path).map_err(|error| Failure::storage(&path, &error))?;
    }
    Ok(())
}

/// Reads a checkpoint, or returns the reason why it can't be used.
pub(crate) fn read<T: DeserializeOwned>(path: &Path, identity: &blake3::Hash) -> std::result::Result<T, Problem> {
    // A file that can't be read is as useless as a damaged one.
    let bytes = plain::read(path, plain::MAXIMUM).map_err(|_| Problem::Damaged)?;
    sealed::open(FORMAT, VERSION, identity, &bytes)
}

/// A directory's checkpoints with their numbers, newest first.
///
/// # Errors
/// Exit 6 if the directory can't be read.
pub(crate) fn list(directory: &Path) -> Result<Vec<(u64, PathBuf)>> {
    let failed = |error| Failure::storage(directory, &error);
    let mut found = Vec::new();
    for entry in fs::read_dir(directory).map_err(failed)? {
        let entry = entry.map_err(failed)?;
        let name = entry.file_name();
        let number = name.to_str().and_then(|name| name.strip_prefix(PREFIX)?.parse().ok());
        found.extend(number.map(|number| (number, entry.path())));
    }
    found.sort_unstable_by(|a, b| b.cmp(a));
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn identity() -> blake3::Hash {
        blake3::hash(b"an experiment")
    }

    fn directory(name: &str) -> PathBuf {
        let directory = std::env::temp_dir().join(format!("oneiro-checkpoints-{name}-{}", std::process::id()));
        fs::create_dir_all(&directory).unwrap();
        directory
    }

    /// Formats of earlier versions: a line of JSON and values for runs, an identity and values for sweeps.
    #[test]
    fn checkpoints_of_earlier_versions_are_refused_as_such() {
        let directory = directory("versions");
        for content in [
            &b"{\"format\":\"oneiro checkpoint\",\"version\":1,\"experiment\":\"ab\",\"generation\":28}\n\0\0\0\0"[..],
            &[&identity().as_bytes()[..], &[0]].concat(),
        ] {
            let path = directory.join("checkpoint-1");
            fs::write(&path, [content, blake3::hash(content).as_bytes()].concat()).unwrap();
            let problem = read::<u32>(&path, &identity()).unwrap_err();
            assert!(matches!(problem, Problem::Other(_)), "{problem}");
            assert!(words(&problem, "experiment").contains("another version of oneiro"));
        }
        fs::remove_dir_all(&directory).unwrap();
    }

    #[test]
    fn the_newest_are_kept() {
        let directory = directory("kept");
        for number in [8, 9, 10, 100] {
            write(&directory, number, 2, &identity(), &number).unwrap();
        }
        let list: Vec<u64> = list(&directory)
            .unwrap()
            .into_iter()
            .map(|(number, _)| number)
            .collect();
        assert_eq!(list, [100, 10]);
        assert_eq!(read(&directory.join("checkpoint-10"), &identity()), Ok(10_u64));
        let other = read::<u64>(&directory.join("checkpoint-10"), &blake3::hash(b"another"));
        assert_eq!(other, Err(Problem::Owner));
        fs::remove_dir_all(&directory).unwrap();
    }
}
