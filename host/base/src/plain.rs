//! Plain files: the only code of the program that opens files and makes directories (`clippy.toml` refuses it elsewhere).
//!
//! A directory may come from somebody else. A name in it may be that of a pipe, which is never read to its end, a device,
//! or a link to a file of the user's. So only plain files are read, up to a size; a new file is made under a name that nothing
//! has; and nothing is written through a link.

#![expect(clippy::disallowed_methods, reason = "all other code uses these functions")]

use std::borrow::Cow;
use std::fs::{self, File, FileType, Metadata, OpenOptions};
use std::io::{self, Read};
use std::path::Path;

/// Maximum size of a file that is read into memory, bytes: the genes of large populations.
pub const MAXIMUM: u64 = 16 << 30;
/// Maximum size of a JSON file that describes a directory, bytes.
pub const MAXIMUM_NOTE: u64 = 64 << 20;
/// Maximum size of a table that is read piece by piece, bytes.
pub(crate) const MAXIMUM_TABLE: u64 = 1 << 40;

/// Why a file is not opened: it is not a plain one, too large, or a link.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct Refused(Cow<'static, str>);

fn refused(problem: impl Into<Cow<'static, str>>) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, Refused(problem.into()))
}

/// Whether an error is a refusal of this module.
pub(crate) fn is_refusal(error: &io::Error) -> bool {
    error
        .get_ref()
        .is_some_and(<dyn std::error::Error + Send + Sync>::is::<Refused>)
}

/// The kind of a file that is not a plain one.
fn other_kind(kind: FileType) -> Option<&'static str> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        if kind.is_fifo() {
            return Some("a pipe");
        }
        if kind.is_socket() {
            return Some("a socket");
        }
        if kind.is_char_device() || kind.is_block_device() {
            return Some("a device");
        }
    }
    match kind {
        kind if kind.is_file() => None,
        kind if kind.is_dir() => Some("a directory"),
        kind if kind.is_symlink() => Some("a link"),
        _ => Some("no plain file"),
    }
}

fn must_be_plain(metadata: &Metadata) -> io::Result<()> {
    match other_kind(metadata.file_type()) {
        None => Ok(()),
        Some(kind) => Err(refused(format!("is {kind}; allowed: a file"))),
    }
}

/// Opens a plain file to read it, also one behind a link.
///
/// # Errors
/// It is no plain file ([`is_refusal`]), or the system's error.
pub fn open(path: &Path) -> io::Result<File> {
    open_plain(OpenOptions::new().read(true), path, true)
}

/// Opens a plain file that exists, also one behind a link if links are followed.
fn open_plain(options: &mut OpenOptions, path: &Path, follows: bool) -> io::Result<File> {
    let look = if follows { fs::metadata } else { fs::symlink_metadata };
    // Opening a device may do something already, and opening a pipe waits.
    must_be_plain(&look(path)?)?;
    #[cfg(unix)]
    {
        let link = if follows { 0 } else { libc::O_NOFOLLOW };
        std::os::unix::fs::OpenOptionsExt::custom_flags(options, libc::O_NONBLOCK | link);
    }
    let file = options.open(path)?;
    must_be_plain(&file.metadata()?)?;
    Ok(file)
}

/// Reads a plain file of at most `most` bytes.
///
/// # Errors
/// As [`open`]; it is larger, or there is not enough memory.
pub fn read(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let file = open(path)?;
    let length = file.metadata()?.len();
    let too_large = |length| refused(format!("has {length} bytes; allowed: up to {most}"));
    if length > most {
        return Err(too_large(length));
    }
    let mut bytes = Vec::new();
    bytes
        .try_reserve_exact(length as usize + 1)
        .map_err(|_| io::Error::from(io::ErrorKind::OutOfMemory))?;
    // The file may grow at the same time.
    file.take(most.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most {
        return Err(too_large(bytes.len() as u64));
    }
    Ok(bytes)
}

/// Opens a table to read it piece by piece.
///
/// # Errors
/// As [`open`]; it has more than [`MAXIMUM_TABLE`] bytes.
pub fn open_table(path: &Path) -> io::Result<File> {
    let file = open(path)?;
    let length = file.metadata()?.len();
    if length > MAXIMUM_TABLE {
        return Err(refused(format!("has {length} bytes; allowed: up to {MAXIMUM_TABLE}")));
    }
    Ok(file)
}

/// The BLAKE3 hash of a plain file.
///
/// # Errors
/// As [`open_table`].
pub fn hash(path: &Path) -> io::Result<blake3::Hash> {
    let mut hasher = blake3::Hasher::new();
    hasher.update_reader(open_table(path)?)?;
    Ok(hasher.finalize())
}

/// Makes a new file: nothing may have its name, not even a link.
///
/// # Errors
/// The name is taken (`AlreadyExists`), or the system's error.
pub fn create(path: &Path) -> io::Result<File> {
    OpenOptions::new().write(true).create_new(true).open(path)
}

/// Makes a new file instead of an existing one; of a link, only the link is removed.
///
/// # Errors
/// A directory has the name ([`is_refusal`]), or the system's error.
pub fn create_anew(path: &Path) -> io::Result<File> {
    anew(&OpenOptions::new(), path)
}

/// Like [`create_anew`], for a file that on Unix only its owner can read.
///
/// # Errors
/// As [`create_anew`].
pub(crate) fn create_secret_anew(path: &Path) -> io::Result<File> {
    let mut options = OpenOptions::new();
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    anew(&options, path)
}

fn anew(options: &OpenOptions, path: &Path) -> io::Result<File> {
    let create = || options.clone().write(true).create_new(true).open(path);
    create().or_else(|error| {
        if error.kind() != io::ErrorKind::AlreadyExists {
            return Err(error);
        }
        if fs::symlink_metadata(path)?.is_dir() {
            return Err(refused("is a directory; allowed: a file"));
        }
        fs::remove_file(path)?;
        create()
    })
}

/// Opens an existing file to append to it.
fn go_on(options: &mut OpenOptions, path: &Path) -> io::Result<File> {
    let file = open_plain(options.write(true), path, false)?;
    #[cfg(unix)]
    if std::os::unix::fs::MetadataExt::nlink(&file.metadata()?) > 1 {
        return Err(refused(
            "has another name (a hard link), under which it would also change; allowed: a copy of it",
        ));
    }
    Ok(file)
}

/// Opens a file to write at its end.
///
/// # Errors
/// There is none (`NotFound`); it is a link, a file that has another name too, or no plain file ([`is_refusal`]); or the system's
/// error.
pub fn append(path: &Path) -> io::Result<File> {
    go_on(OpenOptions::new().append(true), path)
}

/// Like [`append`], and makes the file if there is none.
///
/// # Errors
/// As [`append`].
pub fn append_or_create(path: &Path) -> io::Result<File> {
    let mut options = OpenOptions::new();
    match options.append(true).create_new(true).open(path) {
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => append(path),
        made => made,
    }
}

/// Opens a file to read it and to write in it, or makes it.
///
/// # Errors
/// As [`append`].
pub(crate) fn edit(path: &Path) -> io::Result<File> {
    let mut options = OpenOptions::new();
    options.read(true);
    match options.clone().write(true).create_new(true).open(path) {
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => go_on(&mut options, path),
        made => made,
    }
}

/// Gives a file its name, which nothing may have. Its name until now may stay: remove it.
///
/// # Errors
/// The name is taken (`AlreadyExists`), or the system's error.
pub(crate) fn take_name(now: &Path, path: &Path) -> io::Result<()> {
    match fs::hard_link(now, path) {
        Err(error) if error.kind() != io::ErrorKind::AlreadyExists => {
            // Some file systems have no second names.
            if path.symlink_metadata().is_ok() {
                return Err(io::ErrorKind::AlreadyExists.into());
            }
            fs::rename(now, path)
        }
        linked => linked,
    }
}

/// Whether two names are those of one file.
pub fn is_same(a: &Path, b: &Path) -> bool {
    #[cfg(unix)]
    if let (Ok(a), Ok(b)) = (a.symlink_metadata(), b.symlink_metadata()) {
        use std::os::unix::fs::MetadataExt;
        return a.is_file() && (a.dev(), a.ino()) == (b.dev(), b.ino());
    }
    // Elsewhere files have one name.
    let _ = (a, b);
    false
}

/// Waits until a directory's names are on disk.
///
/// # Errors
/// The system's.
pub fn sync_directory(path: &Path) -> io::Result<()> {
    // Elsewhere a directory can't be opened as a file, and the file system's journal takes care of renames.
    if cfg!(unix) {
        File::open(path)?.sync_all()?;
    }
    Ok(())
}

/// Makes a directory that the user named, and those above it. It may exist, also behind a link.
///
/// # Errors
/// The system's.
pub fn make_directory(path: &Path) -> io::Result<()> {
    fs::create_dir_all(path)
}

/// Makes a directory that nothing has the name of.
///
/// # Errors
/// The name is taken (`AlreadyExists`), or the system's error.
pub fn make_new_directory(path: &Path) -> io::Result<()> {
    fs::create_dir(path)
}

/// Makes a folder of a directory, unless it has it. It may not be behind a link: files would be written to somewhere else.
///
/// # Errors
/// A link or a file has its name ([`is_refusal`]), or the system's error.
pub fn make_folder(path: &Path) -> io::Result<()> {
    match fs::create_dir(path) {
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
            match other_kind(fs::symlink_metadata(path)?.file_type()) {
                Some("a directory") => Ok(()),
                kind => Err(refused(format!(
                    "is {}; allowed: a directory",
                    kind.unwrap_or("a file")
                ))),
            }
        }
        made => made,
    }
}
