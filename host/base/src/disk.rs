//! Writing files that survive a power cut intact.

use std::fs::{self, File, TryLockError};
use std::io::{self, Write};
use std::path::{Component, Path, PathBuf};
use std::thread;
use std::time::Duration;

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::exit::{Failure, Result};
use crate::plain;

/// Suffix of unfinished files.
pub const TEMPORARY: &str = ".tmp";

/// Writes a file completely or not at all, and waits until its content is on disk. Its name is on disk after
/// [`sync_directory`].
pub fn write(path: &Path, bytes: &[u8]) -> Result {
    write_through(path, |file| all(path, file, bytes))
}

/// Like [`write()`], for a file that is too large for memory: `fill` writes it.
///
/// # Errors
/// Those of `fill`, and exit 6 if the file can't be created, synced or renamed.
pub fn write_through(path: &Path, fill: impl FnOnce(&mut File) -> Result) -> Result {
    replace(path, fill, File::sync_all)
}

/// Writes a file that nothing depends on: completely or not at all, but a power cut may lose it.
pub fn note(path: &Path, bytes: &[u8]) -> Result {
    replace(path, |file| all(path, file, bytes), |_| Ok(()))
}

fn all(path: &Path, file: &mut File, bytes: &[u8]) -> Result {
    file.write_all(bytes).map_err(|error| Failure::storage(path, &error))
}

fn replace(path: &Path, fill: impl FnOnce(&mut File) -> Result, sync: fn(&File) -> io::Result<()>) -> Result {
    let mut temporary = path.as_os_str().to_owned();
    temporary.push(TEMPORARY);
    let temporary = PathBuf::from(temporary);
    let storage = |error| Failure::storage(path, &error);
    // One that a kill has left is replaced.
    let mut file = plain::create_anew(&temporary).map_err(|error| match error {
        error if plain::is_refusal(&error) => Failure::storage(&temporary, &error),
        error => storage(error),
    })?;
    let written = fill(&mut file)
        .and_then(|()| sync(&file).map_err(storage))
        .and_then(|()| fs::rename(&temporary, path).map_err(storage));
    written.inspect_err(|_| {
        // If this fails too, the error that follows names the file.
        let _ = fs::remove_file(&temporary);
    })
}

/// Does tasks that wait for the disk, each in a thread: together they wait hardly longer than one. Returns their
/// results in order.
///
/// # Errors
/// The error of the first task that has one; the others are still done.
pub fn at_once<T: Send>(tasks: impl Iterator<Item = impl FnOnce() -> Result<T> + Send>) -> Result<Vec<T>> {
    thread::scope(|scope| {
        let threads: Vec<_> = tasks.map(|task| scope.spawn(task)).collect();
        let crashed = |_| Err(Failure::broken("a writer of results"));
        let results: Vec<_> = threads
            .into_iter()
            .map(|thread| thread.join().unwrap_or_else(crashed))
            .collect();
        results.into_iter().collect()
    })
}

/// The bytes of a JSON file that people also read.
pub fn json(value: &impl Serialize) -> Vec<u8> {
    let mut text = Vec::with_capacity(1024);
    serde_json::to_writer_pretty(&mut text, value).expect("the program's values are numbers, words and lists");
    text.push(b'\n');
    text
}

/// Waits until a directory's names are on disk.
pub fn sync_directory(path: &Path) -> Result {
    plain::sync_directory(path).map_err(|error| Failure::storage(path, &error))
}

/// Makes a folder below a directory, with those between, and returns its path. Those that are there may not be behind links.
///
/// # Errors
/// Exit 3 if a link or a file has the name of one, or the folder would be elsewhere; exit 6.
pub fn make_folder(directory: &Path, folder: impl AsRef<Path>) -> Result<PathBuf> {
    let mut path = directory.to_owned();
    for part in folder.as_ref().components() {
        path.push(part);
        match part {
            Component::Normal(_) => plain::make_folder(&path).map_err(|error| Failure::storage(&path, &error))?,
            Component::CurDir => (),
            _ => {
                let (path, directory) = (path.display(), directory.display());
                return Err(Failure::input(format_args!("{path}: allowed: a folder of {directory}")));
            }
        }
    }
    Ok(path)
}

/// The file of a directory that the one process locks which writes there.
pub const LOCK: &str = "lock";

/// Locks a directory for this process, as long as the file is open; none if another process writes there.
///
/// # Errors
/// Exit 6.
pub fn try_lock(directory: &Path) -> Result<Option<File>> {
    /// A process that is being started has copies of this one's locks for a moment, those that have been released among them.
    const ATTEMPTS: u32 = 4;
    const MOMENT: Duration = Duration::from_millis(10);
    let path = directory.join(LOCK);
    let file = lock_file(&path)?;
    for _ in 0..ATTEMPTS {
        match file.try_lock() {
            Ok(()) => return Ok(Some(file)),
            Err(TryLockError::WouldBlock) => thread::sleep(MOMENT),
            Err(TryLockError::Error(error)) => return Err(Failure::storage(&path, &error)),
        }
    }
    Ok(None)
}

/// Opens a file for locking, and creates it if it isn't there.
pub fn lock_file(path: &Path) -> Result<File> {
    plain::append_or_create(path).map_err(|error| Failure::storage(path, &error))
}

/// Reads the bytes of a file that the program itself has written.
pub fn read(path: &Path) -> Result<Vec<u8>> {
    plain::read(path, plain::MAXIMUM).map_err(|error| match error.kind() {
        io::ErrorKind::NotFound => Failure::corrupt(format_args!("{}: is missing", path.display())),
        _ => Failure::storage(path, &error),
    })
}

/// Reads the bytes of a file that the program itself has written; `None` if it does not exist.
pub fn read_if_there(path: &Path) -> Result<Option<Vec<u8>>> {
    match plain::read(path, plain::MAXIMUM) {
        Ok(bytes) => Ok(Some(bytes)),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(Failure::storage(path, &error)),
    }
}

/// Reads a JSON file that the program itself has written; `None` if it does not exist.
pub fn json_if_there<T: DeserializeOwned>(path: &Path) -> Result<Option<T>> {
    match plain::read(path, plain::MAXIMUM_NOTE) {
        Ok(bytes) => parsed(path, &bytes).map(Some),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(Failure::storage(path, &error)),
    }
}

/// Parses the content of a JSON file that the program itself has written.
pub fn parsed<T: DeserializeOwned>(path: &Path, json: &[u8]) -> Result<T> {
    serde_json::from_slice(json).map_err(|error| Failure::corrupt(format_args!("{}: {error}", path.display())))
}

/// Reads the text of a file that the program itself has written.
pub fn read_text(path: &Path) -> Result<String> {
    String::from_utf8(read(path)?).map_err(|_| Failure::corrupt(format_args!("{}: is no longer text", path.display())))
}
