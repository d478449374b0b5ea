//! Files named by the user: read completely, and never overwritten; directories in the order of their numbers.

use std::cmp::Ordering;
use std::fs::{self, OpenOptions};
use std::io::{self, Write};
use std::path::Path;

use crate::exit::{Failure, Result};

/// Most bytes of a file that a user writes: an experiment, a sweep, or a part. Reading one takes up to 300 times as much
/// memory.
pub(crate) const GREATEST_TEXT: usize = 1 << 20;

/// Reads the text of a file that a user writes.
///
/// # Errors
/// Exit 3 if it doesn't exist, isn't text, or has more than [`GREATEST_TEXT`] bytes; exit 6 if reading fails otherwise.
pub(crate) fn text(path: &Path) -> Result<String> {
    as_written(path, bytes(path)?)
}

/// Converts the bytes of a file that a user writes to text.
///
/// # Errors
/// Exit 3 if they aren't text, or more than [`GREATEST_TEXT`].
pub(crate) fn as_written(path: &Path, bytes: Vec<u8>) -> Result<String> {
    if bytes.len() > GREATEST_TEXT {
        let (path, size) = (path.display(), bytes.len());
        return Err(Failure::input(format_args!(
            "{path}: has {size} bytes; allowed: up to {GREATEST_TEXT}"
        )));
    }
    as_text(path, bytes)
}

/// Converts the bytes of an input file to text.
///
/// # Errors
/// Exit 3 if they aren't text.
pub(crate) fn as_text(path: &Path, bytes: Vec<u8>) -> Result<String> {
    String::from_utf8(bytes)
        .map_err(|error| Failure::input(format_args!("{}: is not text: {}", path.display(), error.utf8_error())))
}

/// Reads an input file.
///
/// # Errors
/// Exit 3 if it doesn't exist, or is a device or a directory, with what to name instead; exit 6 if reading fails otherwise.
pub(crate) fn bytes(path: &Path) -> Result<Vec<u8>> {
    if is_device(path) {
        let path = path.display();
        return Err(Failure::input(format_args!("{path}: is a device; allowed: a file")));
    }
    fs::read(path).map_err(|error| {
        if path.is_dir() {
            Failure::input(instead_of_directory(path))
        } else {
            Failure::unreadable(path, &error)
        }
    })
}

/// Whether a path is that of a device, which may have no end.
fn is_device(path: &Path) -> bool {
    #[cfg(unix)]
    if let Ok(metadata) = fs::metadata(path) {
        use std::os::unix::fs::FileTypeExt;
        return metadata.file_type().is_char_device() || metadata.file_type().is_block_device();
    }
    let _ = path;
    false
}

/// Says that a directory was named instead of a file, and which of its files could be meant.
fn instead_of_directory(directory: &Path) -> String {
    /// Extensions that commands read: experiments and sweeps, genomes, tables.
    const READ: [&str; 6] = ["toml", "npy", "csv", "json", "sam", "sample"];
    const MOST: usize = 4;
    let is_read = |path: &Path| {
        let extension = path.extension().and_then(|extension| extension.to_str());
        extension.is_some_and(|extension| READ.contains(&extension)) && path.is_file()
    };
    let entries = fs::read_dir(directory).into_iter().flatten().flatten();
    let mut files: Vec<_> = entries.map(|entry| entry.path()).filter(|path| is_read(path)).collect();
    // Experiments first.
    files.sort_by(|a, b| {
        let kind = |path: &Path| {
            READ.iter()
                .position(|read| path.extension().is_some_and(|own| own == *read))
        };
        kind(a).cmp(&kind(b)).then_with(|| by_numbers(a, b))
    });
    let names: Vec<String> = files.iter().take(MOST).map(|path| path.display().to_string()).collect();
    let such_as = if names.is_empty() {
        String::new()
    } else {
        format!(", such as {}", names.join(", "))
    };
    format!("{}: is a directory; allowed: a file{such_as}", directory.display())
}

/// Orders paths by the numbers in them: `run-2` comes before `run-10`.
pub(crate) fn by_numbers(a: &Path, b: &Path) -> Ordering {
    fn parts(path: &Path) -> impl Iterator<Item = Part<'_>> {
        let bytes = path.as_os_str().as_encoded_bytes();
        bytes
            .chunk_by(|a, b| a.is_ascii_digit() == b.is_ascii_digit())
            .map(|part| {
                if part[0].is_ascii_digit() {
                    let zeros = part.iter().take_while(|digit| **digit == b'0').count();
                    Part::Number(part.len() - zeros, &part[zeros..])
                } else {
                    Part::Words(part)
                }
            })
    }
    parts(a).cmp(parts(b)).then_with(|| a.cmp(b))
}

/// Part of a path. Of numbers without leading zeros the longer is the greater.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
enum Part<'a> {
    Number(usize, &'a [u8]),
    Words(&'a [u8]),
}

/// Refuses a path that exists.
///
/// # Errors
/// Exit 3.
pub(crate) fn must_be_new(path: &Path) -> Result {
    must_be_new_as(path, "file")
}

/// Refuses a directory's path that exists.
///
/// # Errors
/// Exit 3.
pub(crate) fn directory_must_be_new(path: &Path) -> Result {
    must_be_new_as(path, "directory")
}

fn must_be_new_as(path: &Path, what: &str) -> Result {
    if path.symlink_metadata().is_ok() {
        Err(exists(path, what))
    } else {
        Ok(())
    }
}

/// Refuses the name of a file where a directory's is wanted.
///
/// # Errors
/// Exit 3.
pub(crate) fn must_not_be_file(directory: &Path) -> Result {
    if directory.is_file() {
        let directory = directory.display();
        return Err(Failure::input(format_args!(
            "{directory}: is a file; allowed: a directory's name"
        )));
    }
    Ok(())
}

/// Writes a new file.
///
/// # Errors
/// Exit 3 if the path exists or its directory doesn't, exit 6 if writing fails; a partial file is removed.
pub(crate) fn write_new(path: &Path, bytes: &[u8]) -> Result {
    write_as(&mut OpenOptions::new(), path, bytes)
}

/// Like [`write_new`], for a file that on Unix only its owner can read.
pub(crate) fn write_secret(path: &Path, bytes: &[u8]) -> Result {
    let mut options = OpenOptions::new();
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    write_as(&mut options, path, bytes)
}

fn write_as(options: &mut OpenOptions, path: &Path, bytes: &[u8]) -> Result {
    let file = options.write(true).create_new(true).open(path);
    let mut file = file.map_err(|error| uncreated(path, &error))?;
    file.write_all(bytes).and_then(|()| file.sync_all()).map_err(|error| {
        // If this fails too, the error that follows names the file.
        let _ = fs::remove_file(path);
        Failure::storage(path, &error)
    })
}

/// For a new file that the user named and that can't be created: exit 3 if it exists or its directory doesn't, else exit 6.
pub(crate) fn uncreated(path: &Path, error: &io::Error) -> Failure {
    match error.kind() {
        io::ErrorKind::AlreadyExists => exists(path, "file"),
        _ => Failure::unreadable(path, error),
    }
}

fn exists(path: &Path, what: &str) -> Failure {
    Failure::input(format_args!(
        "{}: exists already, and nothing is overwritten; name another {what}",
        path.display()
    ))
}

/// Quotes a word for a shell.
pub(crate) fn for_shell(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./:=,".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_quoted_for_shells() {
        assert_eq!(for_shell("/a/b-1.toml"), "/a/b-1.toml");
        assert_eq!(for_shell("it's $HOME"), r"'it'\''s $HOME'");
        assert_eq!(for_shell(""), "''");
    }

    #[test]
    fn numbers_in_paths_count_as_numbers() {
        let sorted = [
            "run-1",
            "run-2",
            "run-2-a",
            "run-02-b",
            "run-10",
            "run-18446744073709551616",
            "run-a",
            "runs",
        ];
        for a in 0..sorted.len() {
            for b in 0..sorted.len() {
                let order = by_numbers(Path::new(sorted[a]), Path::new(sorted[b]));
                assert_eq!(order, a.cmp(&b), "{} and {}", sorted[a], sorted[b]);
            }
        }
        assert_ne!(by_numbers(Path::new("a1"), Path::new("a01")), Ordering::Equal);
    }
}
