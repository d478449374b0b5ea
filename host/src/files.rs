//! Files that a user names: read whole, and never overwritten.

use std::fs::{self, OpenOptions};
use std::io::{self, Write};
use std::path::Path;

use crate::exit::{Failure, Result};

/// Reads the text of an input file.
///
/// # Errors
/// Exit 3 when there is no such text file, exit 6 when reading fails otherwise.
pub(crate) fn text(path: &Path) -> Result<String> {
    fs::read_to_string(path).map_err(|error| Failure::unreadable(path, &error))
}

/// Refuses a path that exists.
///
/// # Errors
/// Exit 3.
pub(crate) fn must_be_new(path: &Path) -> Result {
    if path.symlink_metadata().is_ok() {
        Err(exists(path))
    } else {
        Ok(())
    }
}

/// Writes a new file.
///
/// # Errors
/// Exit 3 when the path exists or its directory doesn't, exit 6 when writing fails; a file begun is removed.
pub(crate) fn write_new(path: &Path, bytes: &[u8]) -> Result {
    let mut file = match OpenOptions::new().write(true).create_new(true).open(path) {
        Ok(file) => file,
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => return Err(exists(path)),
        Err(error) => return Err(Failure::unreadable(path, &error)),
    };
    file.write_all(bytes).and_then(|()| file.sync_all()).map_err(|error| {
        // What can't be removed is told by the error that follows.
        let _ = fs::remove_file(path);
        Failure::storage(path, &error)
    })
}

fn exists(path: &Path) -> Failure {
    Failure::input(format_args!(
        "{}: exists already, and nothing is overwritten; name another file",
        path.display()
    ))
}
