//! Writing that a power cut can't tear.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use crate::exit::{Failure, Result};

/// What unfinished files end in.
pub(crate) const TEMPORARY: &str = ".tmp";

/// Writes a file whole or not at all, and waits until its content is on the disk; its name is there after
/// [`sync_directory`].
pub(crate) fn write(path: &Path, bytes: &[u8]) -> Result {
    replace(path, bytes, File::sync_all)
}

/// Writes a file that nothing depends on: whole or not at all, but a power cut may take it.
pub(crate) fn note(path: &Path, bytes: &[u8]) -> Result {
    replace(path, bytes, |_| Ok(()))
}

/// What ends the writing of a file: the disk, or what was to be written.
pub(crate) enum Trouble {
    Disk(io::Error),
    Other(Failure),
}

/// What [`stream`]'s content comes to.
pub(crate) type Streamed = std::result::Result<(), Trouble>;

impl From<io::Error> for Trouble {
    fn from(error: io::Error) -> Self {
        Self::Disk(error)
    }
}

impl From<Failure> for Trouble {
    fn from(failure: Failure) -> Self {
        Self::Other(failure)
    }
}

/// The same as [`write`] for what is too long to be held.
pub(crate) fn stream(path: &Path, write: impl FnOnce(&mut BufWriter<File>) -> Streamed) -> Result {
    let temporary = temporary(path);
    let whole = || -> Streamed {
        let mut file = BufWriter::with_capacity(1 << 20, File::create(&temporary)?);
        write(&mut file)?;
        file.flush()?;
        file.get_ref().sync_all()?;
        Ok(fs::rename(&temporary, path)?)
    };
    whole().map_err(|trouble| match trouble {
        Trouble::Disk(error) => Failure::storage(path, &error),
        Trouble::Other(failure) => failure,
    })
}

/// What a file is called until it is whole.
fn temporary(path: &Path) -> PathBuf {
    let mut temporary = path.as_os_str().to_owned();
    temporary.push(TEMPORARY);
    PathBuf::from(temporary)
}

fn replace(path: &Path, bytes: &[u8], sync: fn(&File) -> io::Result<()>) -> Result {
    let temporary = temporary(path);
    let write = || -> io::Result<()> {
        let mut file = File::create(&temporary)?;
        file.write_all(bytes)?;
        sync(&file)?;
        fs::rename(&temporary, path)
    };
    write().map_err(|error| Failure::storage(path, &error))
}

/// Waits until a directory's names are on the disk.
pub(crate) fn sync_directory(path: &Path) -> Result {
    // Elsewhere a directory can't be opened as a file, and renaming is a matter of the file system's journal.
    if cfg!(unix) {
        File::open(path)
            .and_then(|directory| directory.sync_all())
            .map_err(|error| Failure::storage(path, &error))?;
    }
    Ok(())
}

/// The bytes of a file that the program wrote itself.
pub(crate) fn read(path: &Path) -> Result<Vec<u8>> {
    fs::read(path).map_err(|error| match error.kind() {
        io::ErrorKind::NotFound => Failure::corrupt(format_args!("{}: is missing", path.display())),
        _ => Failure::storage(path, &error),
    })
}

/// The text of such a file.
pub(crate) fn read_text(path: &Path) -> Result<String> {
    String::from_utf8(read(path)?)
        .map_err(|_| Failure::corrupt(format_args!("{}: is no text any more", path.display())))
}
