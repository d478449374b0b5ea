//! Files named by the user: read completely, and never overwritten; directories in the order of their numbers.

pub mod directory;

use std::cmp::Ordering;
use std::ffi::{OsStr, OsString};
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Component, Path, PathBuf};

use oneiro::parameter;

use crate::disk::TEMPORARY;
use crate::exit::{Failure, Result};
use crate::{plain, program};

/// Maximum bytes of a user's file: an experiment, a sweep, or a part. Reading one takes up to 300 times as much memory.
pub const GREATEST_TEXT: usize = 1 << 20;

/// Reads the text of a file that a user writes.
///
/// # Errors
/// Exit 3 if it doesn't exist, isn't text, or has more than [`GREATEST_TEXT`] bytes; exit 6 if reading fails otherwise.
pub fn text(path: &Path) -> Result<String> {
    as_text(path, read(path, GREATEST_TEXT as u64)?)
}

/// Converts the bytes of a file that a user writes to text.
///
/// # Errors
/// Exit 3 if they aren't text, or more than [`GREATEST_TEXT`].
pub fn as_written(path: &Path, bytes: Vec<u8>) -> Result<String> {
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
pub fn as_text(path: &Path, bytes: Vec<u8>) -> Result<String> {
    String::from_utf8(bytes).map_err(|error| {
        let (path, bytes) = (path.display(), error.as_bytes());
        if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
            return Failure::input(format_args!("{path}: is UTF-16; allowed: UTF-8, so save it as that"));
        }
        let before = &bytes[..error.utf8_error().valid_up_to()];
        let line = before.split(|byte| *byte == b'\n').count();
        Failure::input(format_args!(
            "{path}:{line}: is not UTF-8; allowed: text, saved as UTF-8"
        ))
    })
}

/// Reads an input file.
///
/// # Errors
/// Exit 3 if it doesn't exist, or is a pipe, a device or a directory, with what to name instead, or is larger than
/// [`plain::MAXIMUM`]; exit 6 if reading fails otherwise.
pub fn bytes(path: &Path) -> Result<Vec<u8>> {
    read(path, plain::MAXIMUM)
}

fn read(path: &Path, most: u64) -> Result<Vec<u8>> {
    plain::read(path, most).map_err(|error| {
        if path.is_dir() {
            Failure::input(instead_of_directory(path))
        } else {
            Failure::unreadable(path, &error)
        }
    })
}

/// Explains that a directory was named instead of a file, and suggests files in it.
fn instead_of_directory(directory: &Path) -> String {
    /// Extensions that commands read, except for TOML's: genomes, tables.
    const READ: [&str; 5] = ["npy", "csv", "json", "sam", "sample"];
    const MOST: usize = 4;
    let is_read = |path: &Path| {
        let extension = path.extension().and_then(|extension| extension.to_str());
        extension.is_some_and(|extension| READ.contains(&extension)) && path.is_file()
    };
    let entries = fs::read_dir(directory).into_iter().flatten().flatten();
    let mut files: Vec<_> = entries.map(|entry| entry.path()).filter(|path| is_read(path)).collect();
    files.sort_by(|a, b| {
        let kind = |path: &Path| {
            READ.iter()
                .position(|read| path.extension().is_some_and(|ending| ending == *read))
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
pub fn by_numbers(a: &Path, b: &Path) -> Ordering {
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

/// The path of a file or directory most like one that doesn't exist: each name in it that isn't there is replaced by the most similar one.
/// `is_meant` accepts files; extensions don't make names similar. `None` if none is similar.
pub fn nearest(path: &Path, is_meant: impl Fn(&Path) -> bool) -> Option<PathBuf> {
    let mut found = PathBuf::new();
    let mut parts = path.components().peekable();
    while let Some(part) = parts.next() {
        let next = found.join(part);
        let is_last = parts.peek().is_none();
        if !matches!(part, Component::Normal(_)) || next.is_dir() && !is_last {
            found = next;
            continue;
        }
        let folder = if found.as_os_str().is_empty() {
            Path::new(".")
        } else {
            &found
        };
        let entries = fs::read_dir(folder).ok()?.flatten().map(|entry| entry.path());
        let is_like = |path: &PathBuf| if is_last { is_meant(path) } else { path.is_dir() };
        let mut names: Vec<PathBuf> = entries
            .filter(is_like)
            .filter_map(|path| Some(path.file_name()?.into()))
            .collect();
        names.sort_by(|a, b| by_numbers(a, b));
        let stem = |name: &Path| {
            let stem = if is_last { name.file_stem() } else { name.file_name() };
            stem.and_then(OsStr::to_str).unwrap_or_default().to_owned()
        };
        let stems: Vec<String> = names.iter().map(|name| stem(name)).collect();
        let meant = parameter::nearest(stems.iter().map(String::as_str), &stem(Path::new(&part)))?;
        let at = stems.iter().position(|stem| stem == meant)?;
        found.push(&names[at]);
    }
    Some(found)
}

/// Part of a path. Of numbers without leading zeros the longer is the greater.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
enum Part<'a> {
    Number(usize, &'a [u8]),
    Words(&'a [u8]),
}

/// Refuses a path that exists, or whose directory doesn't.
///
/// # Errors
/// Exit 3.
pub fn must_be_new(path: &Path) -> Result {
    must_not_exist(path)?;
    must_have_directory(path)
}

/// Refuses a file's path whose directory doesn't exist.
fn must_have_directory(path: &Path) -> Result {
    let (Some(directory), path) = (missing_directory(path), path.display()) else {
        return Ok(());
    };
    let directory = directory.display();
    Err(Failure::input(format_args!(
        "{path}: there is no directory {directory}; allowed: a file in one that exists"
    )))
}

/// The directory of a file's path if it isn't there.
fn missing_directory(path: &Path) -> Option<&Path> {
    path.parent()
        .filter(|directory| !directory.as_os_str().is_empty() && !directory.is_dir())
}

/// Refuses the name of a picture, an option's value, that isn't that of an SVG.
///
/// # Errors
/// Exit 3.
pub fn must_be_svg(option: &str, path: &Path) -> Result {
    must_end_in(option, path, "svg", "the picture is an SVG")
}

/// Refuses a file's name with another extension; `written` names the content.
///
/// # Errors
/// Exit 3.
pub fn must_end_in(option: &str, path: &Path, extension: &str, written: &str) -> Result {
    let is_it = |ending: &OsStr| ending.eq_ignore_ascii_case(extension);
    if path.extension().is_some_and(is_it) {
        return Ok(());
    }
    let path = path.display();
    Err(Failure::input(format_args!(
        "{option} {path}: {written}; allowed: a name that ends in .{extension}"
    )))
}

/// Refuses a path that exists.
///
/// # Errors
/// Exit 3.
pub fn must_not_exist(path: &Path) -> Result {
    if path.symlink_metadata().is_ok() {
        tidy(path);
        Err(exists(path))
    } else {
        Ok(())
    }
}

/// Refuses the name of a file where a directory's is wanted.
///
/// # Errors
/// Exit 3.
pub fn must_not_be_file(directory: &Path) -> Result {
    if directory.is_file() {
        let directory = directory.display();
        return Err(Failure::input(format_args!(
            "{directory}: is a file; allowed: a directory's name"
        )));
    }
    Ok(())
}

/// Writes a new file: completely or not at all. One that has these bytes already stays.
///
/// # Errors
/// Exit 3 if the path exists or its directory doesn't, exit 6 if writing fails.
pub fn write_new(path: &Path, bytes: &[u8]) -> Result {
    // A command that was killed when its file was complete continues.
    if is_already(path, bytes) {
        tidy(path);
        return Ok(());
    }
    write_as(plain::create_anew, path, bytes)
}

/// Whether a file has these bytes.
pub fn is_already(path: &Path, bytes: &[u8]) -> bool {
    plain::read(path, bytes.len() as u64).is_ok_and(|known| known == bytes)
}

/// Writes a new file that on Unix only its owner can read: completely or not at all.
///
/// # Errors
/// As [`write_new`].
pub fn write_secret(path: &Path, bytes: &[u8]) -> Result {
    write_as(plain::create_secret_anew, path, bytes)
}

/// The name of a new file until it is complete. The next call replaces the rest that a kill has left of it.
fn unfinished(path: &Path) -> PathBuf {
    let mut name = OsString::from(".");
    name.push(path.file_name().unwrap_or_default());
    name.push(TEMPORARY);
    path.with_file_name(name)
}

/// Removes the first name of a file that has got its own, if a kill came between.
fn tidy(path: &Path) {
    let temporary = unfinished(path);
    if plain::is_same(&temporary, path) {
        // Otherwise it is in the way of nobody.
        let _ = fs::remove_file(temporary);
    }
}

fn write_as(create: fn(&Path) -> io::Result<File>, path: &Path, bytes: &[u8]) -> Result {
    must_be_new(path)?;
    let temporary = unfinished(path);
    let mut file = create(&temporary).map_err(|error| uncreated(path, &error))?;
    let written = file
        .write_all(bytes)
        .and_then(|()| file.sync_all())
        .map_err(|error| Failure::storage(path, &error))
        .and_then(|()| plain::take_name(&temporary, path).map_err(|error| uncreated(path, &error)));
    // It may have been renamed.
    let _ = fs::remove_file(&temporary);
    written
}

/// For a new file that the user named and that can't be created: exit 3 if it exists or its directory doesn't, else exit 6.
pub fn uncreated(path: &Path, error: &io::Error) -> Failure {
    match error.kind() {
        io::ErrorKind::AlreadyExists => exists(path),
        _ => must_have_directory(path)
            .err()
            .unwrap_or_else(|| Failure::unreadable(path, error)),
    }
}

fn exists(path: &Path) -> Failure {
    Failure::input(format_args!(
        "{}: exists already, and nothing is overwritten; name another file",
        path.display()
    ))
}

/// The lines of a text that have an end.
pub fn whole_lines(text: &str) -> &str {
    &text[..text.rfind('\n').map_or(0, |end| end + 1)]
}

/// The command that called this program, as a shell takes it.
pub fn command() -> String {
    let words = program::words().into_iter().skip(1);
    let words: Vec<String> = words.map(|word| for_shell(&word.to_string_lossy())).collect();
    format!("oneiro {}", words.join(" "))
}

/// Quotes a word for a shell.
pub fn for_shell(word: &str) -> String {
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
