//! The program's directories: one way to begin one, to continue one, and to recognise one before it is complete, so
//! that any killed command can be continued.

use std::fs::{self, File};
use std::io::{Read, Seek, Write};
use std::path::{Path, PathBuf};

use crate::contents::README;
use crate::disk::{self, LOCK, TEMPORARY};
use crate::exit::{Failure, Result};
use crate::files;
use crate::plain;

/// A kind of directory.
pub struct Form<'a> {
    /// The file that makes a directory one of this kind. It is written whole, and before it nothing that must be kept.
    pub mark: &'a str,
    /// Names that may be there before the mark, with the lock, the description and unfinished files of these names.
    pub before: &'a [&'a str],
    /// The option that names such a directory.
    pub option: &'a str,
}

/// What a directory holds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Holds {
    /// Nothing, or what a killed process leaves before it has written the mark. It may not exist.
    Nothing,
    /// The mark.
    Mark,
    /// Something else, such as this.
    Other(String),
}

impl Form<'_> {
    /// Tells what a directory holds.
    ///
    /// # Errors
    /// Exit 3 if it is a file, or if its mark is no plain file; exit 6 if it can't be read.
    pub fn look(&self, directory: &Path) -> Result<Holds> {
        files::must_not_be_file(directory)?;
        // Before the lock and the mark: another process may be filling the directory, and makes these first and last.
        let names = names(directory)?;
        if self.is_at(directory)? {
            return Ok(Holds::Mark);
        }
        // Every command locks a directory before it fills it.
        let is_begun = plain::open(&directory.join(LOCK)).is_ok();
        let is_own = |name: &str| {
            let whole = name.strip_suffix(TEMPORARY).unwrap_or(name);
            let is_before = name == LOCK || whole == README || self.before.contains(&whole);
            (is_begun && is_before) || (whole == self.mark && name != whole)
        };
        let other = names.into_iter().find(|name| !is_own(name));
        Ok(other.map_or(Holds::Nothing, Holds::Other))
    }

    /// Whether a directory has the mark.
    ///
    /// # Errors
    /// Exit 3 if the mark is no plain file; exit 6 if it can't be looked at.
    pub fn is_at(&self, directory: &Path) -> Result<bool> {
        let mark = directory.join(self.mark);
        match plain::open(&mark) {
            Ok(_) => Ok(true),
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(false),
            Err(error) => Err(Failure::unreadable(&mark, &error)),
        }
    }

    /// Locks a directory that is empty or has the mark, or makes one. It stays locked while the returned file is open.
    ///
    /// # Errors
    /// Exit 3 as [`Form::look`], or if it holds something else; `busy` if another process has it; exit 6.
    pub fn take(&self, directory: &Path, busy: impl FnOnce() -> Failure) -> Result<(File, Holds)> {
        // Others' directories don't even get a lock.
        self.refuse_others(directory)?;
        plain::make_directory(directory).map_err(|error| files::uncreated(directory, &error))?;
        let lock = disk::try_lock(directory)?.ok_or_else(busy)?;
        // Another process may have been faster.
        Ok((lock, self.refuse_others(directory)?))
    }

    /// Refuses a directory that holds something else.
    ///
    /// # Errors
    /// Exit 3 as [`Form::look`], or if it does.
    pub fn refuse_others(&self, directory: &Path) -> Result<Holds> {
        match self.look(directory)? {
            Holds::Other(name) => Err(holds_others(directory, &name, self.option)),
            holds => Ok(holds),
        }
    }
}

fn holds_others(directory: &Path, name: &str, option: &str) -> Failure {
    Failure::input(format_args!(
        "{}: exists and holds other files, and nothing is overwritten; here {name}; name another directory with {option}",
        directory.display()
    ))
}

/// What is in a directory that something could have.
#[derive(Debug)]
pub enum Found<T> {
    Free,
    /// Its earlier work.
    Own(T),
    /// Something else: a description.
    Other(String),
}

/// The directory of something that has a name.
#[derive(Debug)]
pub struct Named<T> {
    pub directory: PathBuf,
    /// Its earlier work there.
    pub own: Option<T>,
    /// Why it is not the directory of the plain name: a sentence.
    pub why: Option<String>,
}

/// Chooses the directory `name`, or `name-b`, `name-c` and so on: the first with earlier work, else the first that is free.
///
/// # Errors
/// Those of `look`.
pub fn named<T>(name: &Path, look: impl Fn(&Path) -> Result<Found<T>>) -> Result<Named<T>> {
    /// Directories that are looked at in any case: an earlier one may have been removed.
    const LEAST: usize = 26;
    let (mut free, mut reason) = (None, None);
    let mut number = 0;
    loop {
        let directory = lettered(name, number);
        let own = match look(&directory)? {
            Found::Own(own) => Some((directory, Some(own))),
            Found::Free => {
                free.get_or_insert(directory);
                None
            }
            Found::Other(other) => {
                reason.get_or_insert(other);
                None
            }
        };
        number += 1;
        let chosen = own.or_else(|| {
            if number >= LEAST {
                free.take().map(|free| (free, None))
            } else {
                None
            }
        });
        if let Some((directory, own)) = chosen {
            let why = reason
                .filter(|_| own.is_none() && directory != name)
                .map(|reason| format!("{} {reason}, so this goes to {}", name.display(), directory.display()));
            return Ok(Named { directory, own, why });
        }
    }
}

/// The name itself, then with `-b` to `-z`, `-aa` and so on.
fn lettered(name: &Path, number: usize) -> PathBuf {
    let mut letters = Vec::new();
    let mut rest = number + 1;
    while rest > 0 {
        rest -= 1;
        letters.insert(0, b'a' + (rest % 26) as u8);
        rest /= 26;
    }
    let mut path = name.as_os_str().to_owned();
    if number > 0 {
        path.push("-");
        path.push(String::from_utf8_lossy(&letters).as_ref());
    }
    path.into()
}

/// The names in a directory, in their order; none if it doesn't exist.
fn names(directory: &Path) -> Result<Vec<String>> {
    let entries = match fs::read_dir(directory) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        entries => entries.map_err(|error| Failure::unreadable(directory, &error))?,
    };
    let name = |entry: std::io::Result<fs::DirEntry>| Ok(entry?.file_name().to_string_lossy().into_owned());
    let mut names = entries
        .map(name)
        .collect::<std::io::Result<Vec<_>>>()
        .map_err(|error| Failure::storage(directory, &error))?;
    names.sort_unstable();
    Ok(names)
}

/// A directory that one command fills. Until it is complete, a file in it has the command: the same command begins it again.
#[derive(Debug)]
pub struct Filling {
    directory: PathBuf,
    /// Whether there was no such directory.
    is_new: bool,
    _lock: File,
}

impl Filling {
    const FILE: &str = "unfinished";

    /// Begins to fill a directory: a new or empty one, or one that this command has begun before. Its files whose names
    /// `is_own` accepts are then removed. `option` is the user's name for it.
    ///
    /// # Errors
    /// Exit 3 if it holds anything else, or another command's or a running one's files; exit 6.
    pub fn begin(option: &str, directory: &Path, is_own: impl Fn(&str) -> bool) -> Result<Self> {
        let command = files::command() + "\n";
        let place = format!("{option} {}", directory.display());
        files::must_not_be_file(directory)?;
        let path = directory.join(Self::FILE);
        let names = names(directory)?;
        if !names.is_empty() && !names.iter().any(|name| name == Self::FILE) {
            return Err(Failure::input(format_args!(
                "{place}: exists and is not empty, and nothing is overwritten; name another directory"
            )));
        }
        let storage = |error| Failure::storage(&path, &error);
        let is_new = !directory.exists();
        plain::make_directory(directory).map_err(|error| files::uncreated(directory, &error))?;
        let mut file = plain::edit(&path).map_err(storage)?;
        if file.try_lock().is_err() {
            return Err(Failure::input(format_args!(
                "{place}: another process is filling it; allowed: one at a time"
            )));
        }
        let mut begun_by = String::new();
        file.read_to_string(&mut begun_by).map_err(storage)?;
        // A kill may have been faster than its line.
        let is_whole = begun_by.ends_with('\n');
        if is_whole && begun_by != command {
            return Err(Failure::input(format_args!(
                "{place}: is unfinished; allowed: the command that began it, `{}`, or another directory",
                begun_by.trim_end()
            )));
        }
        for name in names.iter().filter(|name| *name != Self::FILE) {
            if !is_own(name.strip_suffix(TEMPORARY).unwrap_or(name)) {
                return Err(holds_others(directory, name, option));
            }
        }
        for name in names.iter().filter(|name| *name != Self::FILE) {
            let old = directory.join(name);
            let is_folder = old.symlink_metadata().is_ok_and(|old| old.is_dir());
            let removed = if is_folder {
                fs::remove_dir_all(&old)
            } else {
                fs::remove_file(&old)
            };
            removed.map_err(|error| Failure::storage(&old, &error))?;
        }
        if !is_whole {
            file.rewind()
                .and_then(|()| file.set_len(0))
                .and_then(|()| file.write_all(command.as_bytes()))
                .map_err(storage)?;
        }
        Ok(Self {
            directory: directory.to_owned(),
            is_new,
            _lock: file,
        })
    }

    /// Says that the directory is complete.
    ///
    /// # Errors
    /// Exit 6.
    pub fn finish(self) -> Result {
        disk::sync_directory(&self.directory)?;
        let path = self.directory.join(Self::FILE);
        fs::remove_file(&path).map_err(|error| Failure::storage(&path, &error))
    }
}

impl Drop for Filling {
    /// Leaves nothing of a command that has failed before it wrote anything: another may be right.
    fn drop(&mut self) {
        if names(&self.directory).is_ok_and(|names| names == [Self::FILE]) {
            // A directory that stays names its command.
            let removed = fs::remove_file(self.directory.join(Self::FILE));
            if self.is_new && removed.is_ok() {
                let _ = fs::remove_dir(&self.directory);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::thread;

    use super::*;

    const FORM: Form<'_> = Form {
        mark: "mark.json",
        before: &["early"],
        option: "--out",
    };

    #[test]
    fn the_first_directory_with_own_work_or_the_first_free_one_is_chosen() {
        let chosen = |others: &[&str], own: &str| {
            let named = named(Path::new("runs/x-1"), |path| {
                let name = path.file_name().unwrap().to_str().unwrap();
                Ok(match name {
                    name if name == own => Found::Own(()),
                    name if others.contains(&name) => Found::Other("has other settings".into()),
                    _ => Found::Free,
                })
            });
            let named = named.unwrap();
            assert_eq!(named.own.is_some(), !own.is_empty());
            assert_eq!(
                named.why.is_some(),
                own.is_empty() && !others.is_empty() && others[0] == "x-1"
            );
            named.directory.file_name().unwrap().to_str().unwrap().to_owned()
        };
        assert_eq!(chosen(&[], ""), "x-1");
        assert_eq!(chosen(&["x-1", "x-1-b"], ""), "x-1-c");
        assert_eq!(chosen(&["x-1", "x-1-b"], "x-1-c"), "x-1-c");
        assert_eq!(chosen(&["x-1-b"], ""), "x-1");
        // The first was removed since.
        assert_eq!(chosen(&["x-1-b"], "x-1-d"), "x-1-d");
        let all: Vec<String> = (0..28)
            .map(|number| lettered(Path::new("x"), number).display().to_string())
            .collect();
        assert_eq!(
            [&*all[0], &all[1], &all[25], &all[26], &all[27]],
            ["x", "x-b", "x-z", "x-aa", "x-ab"]
        );
        let taken: Vec<String> = all.iter().map(|name| name.replacen('x', "x-1", 1)).collect();
        let taken: Vec<&str> = taken.iter().map(String::as_str).collect();
        assert_eq!(chosen(&taken, ""), "x-1-ac");
    }

    /// Shards of a sweep begin at the same time: one may look while another makes the directory.
    #[test]
    fn a_directory_that_is_being_made_is_never_somebody_elses() {
        let root = std::env::temp_dir().join(format!("oneiro-directory-{}", std::process::id()));
        let places: Vec<_> = (0..500).map(|number| root.join(number.to_string())).collect();
        thread::scope(|scope| {
            scope.spawn(|| {
                for place in &places {
                    let (_lock, holds) = FORM.take(place, || Failure::failed("busy")).unwrap();
                    assert_eq!(holds, Holds::Nothing);
                    for name in FORM.before.iter().chain([&FORM.mark]) {
                        disk::note(&place.join(name), b"").unwrap();
                    }
                }
            });
            for place in &places {
                loop {
                    match FORM.look(place).unwrap() {
                        Holds::Mark => break,
                        Holds::Nothing => (),
                        Holds::Other(name) => panic!("{}: {name}", place.display()),
                    }
                }
            }
        });
        fs::remove_dir_all(root).unwrap();
    }
}
