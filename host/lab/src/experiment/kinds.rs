//! Kinds of TOML files that users write, and of directories that the program writes. A file of a kind that a command doesn't take is
//! refused, with its kind and what to type.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use oneiro_base::exit::{Failure, Result};
use oneiro_base::files;

use super::source::Parsed;

/// The file by which a run's directory is known: its experiment.
pub(crate) const CONFIG: &str = "config.toml";
/// The last file of a run, once it is finished.
pub(crate) const DONE: &str = "DONE";
/// The genes of a finished run's champion.
pub(crate) const CHAMPION_GENES: &str = "champion.npy";
/// The file by which a sweep's directory is known.
pub(crate) const MADE: &str = "sweep.json";

/// Whether a directory is a run's, readable or not.
pub fn is_run(directory: &Path) -> bool {
    directory.join(CONFIG).symlink_metadata().is_ok()
}

/// When a run or a sweep was begun; `None` if that can't be told.
pub fn begun(directory: &Path) -> Option<SystemTime> {
    let first = [CONFIG, MADE].map(|name| directory.join(name).symlink_metadata());
    first.into_iter().find_map(|file| file.ok()?.modified().ok())
}

/// Whether a directory is a sweep's.
pub fn is_sweep(directory: &Path) -> bool {
    directory.join(MADE).symlink_metadata().is_ok()
}

/// A kind of TOML file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileKind {
    Fleet,
    /// Of `oneiro on-board`.
    Robot,
    Study,
    Sweep,
    Experiment,
}

impl FileKind {
    /// In the order in which files are recognised: a fleet's file and a robot's also have keys of experiments.
    const ALL: [Self; 5] = [Self::Fleet, Self::Robot, Self::Study, Self::Sweep, Self::Experiment];

    /// Name of the kind, for messages.
    fn words(self) -> &'static str {
        match self {
            Self::Fleet => "a fleet's file",
            Self::Robot => "a file of a robot's computer",
            Self::Study => "a study's file",
            Self::Sweep => "a sweep's file",
            Self::Experiment => "an experiment",
        }
    }

    /// Keys by which its files are known, with `experiment`.
    fn keys(self) -> &'static [&'static str] {
        match self {
            Self::Fleet => &["robots", "operator", "binary", "ssh"],
            Self::Robot => &["address", "transfers", "lives", "radio", "beacon"],
            Self::Study => &["conditions", "questions", "variants", "arms"],
            Self::Sweep => &["seeds", "seeds_by", "grid", "list", "random"],
            Self::Experiment => &[
                "cycles",
                "trials",
                "arena",
                "noise",
                "sensor",
                "controller",
                "task",
                "start",
                "evolution",
                "record",
                "swarm",
            ],
        }
    }

    /// What to type for a file of this kind.
    fn commands(self, path: &str) -> String {
        match self {
            Self::Fleet => format!("`oneiro fleet plan {path}` checks it"),
            Self::Robot => format!("`oneiro on-board {path}` runs it on the robot's computer"),
            Self::Study => format!("`oneiro reproduce STUDY --study {path}` runs it"),
            Self::Sweep => format!("`oneiro sweep plan {path}` checks it, `oneiro sweep run {path}` runs it"),
            Self::Experiment => format!("`oneiro check {path}` checks it, `oneiro run {path}` runs it"),
        }
    }

    /// Whether a file has this kind's keys. Only an experiment names no experiment; a fleet's file also has keys of its robots' files.
    fn is_of(self, values: &Parsed<'_>) -> bool {
        let names_one = values.has("experiment");
        let has_keys = || self.keys().iter().any(|key| values.has(key));
        match self {
            Self::Experiment => !names_one && has_keys(),
            Self::Robot => names_one && has_keys() && !Self::Fleet.is_of(values),
            Self::Fleet | Self::Study | Self::Sweep => has_keys(),
        }
    }

    /// The kind of a file given as one of this kind, if it is another; `None` if it may be of this kind.
    fn mistaken(self, values: &Parsed<'_>) -> Option<Self> {
        if self.is_of(values) {
            return None;
        }
        let other = Self::ALL.into_iter().find(|kind| kind.is_of(values));
        let names_one = self == Self::Experiment && values.has("experiment");
        other.or(names_one.then_some(Self::Sweep))
    }

    /// Reads the text of a file given as one of this kind.
    ///
    /// # Errors
    /// Exit 3: there is none, it is a directory or a file for something else, isn't text or is too long; exit 6 if reading fails.
    pub fn text(self, path: &Path) -> Result<String> {
        /// Files that other arguments take, or that this program writes.
        const OTHERS: [&str; 8] = ["npy", "csv", "json", "sam", "sample", "svg", "html", "parquet"];
        if path.is_dir() {
            return Err(self.is_directory(path));
        }
        let shown = path.display();
        let extension = path
            .extension()
            .and_then(|extension| extension.to_str())
            .unwrap_or_default();
        let problem = match extension {
            "wgsl" => format!(
                "is a part, not {}; allowed: the TOML file of an experiment that names it (docs/extend.md)",
                self.words()
            ),
            other if OTHERS.contains(&other) => format!("is not {}; allowed: a TOML file", self.words()),
            _ => {
                return match fs::metadata(path) {
                    Err(error) if error.kind() == io::ErrorKind::NotFound => Err(self.is_missing(path, &error)),
                    _ => files::text(path),
                };
            }
        };
        Err(Failure::input(format_args!("{shown}: {problem}")))
    }

    /// Parses a file given as one of this kind.
    ///
    /// # Errors
    /// Exit 3: the place of invalid TOML, or what it is instead.
    pub fn parsed<'a>(self, path: &Path, text: &'a str) -> Result<Parsed<'a>> {
        let values = Parsed::new(path.display().to_string(), text)?;
        self.must_be(path, &values)?;
        Ok(values)
    }

    /// Refuses a file of another kind given as one of this kind.
    ///
    /// # Errors
    /// Exit 3: what it is, and what to type.
    pub(crate) fn must_be(self, path: &Path, values: &Parsed<'_>) -> Result {
        let Some(other) = self.mistaken(values) else {
            return Ok(());
        };
        let path = path.display().to_string();
        let commands = other.commands(&files::for_shell(&path));
        let (is, not) = (other.words(), self.words());
        Err(Failure::input(format_args!("{path}: is {is}, not {not}; {commands}")))
    }

    /// For a directory given instead of a file.
    fn is_directory(self, directory: &Path) -> Failure {
        const MOST: usize = 4;
        let shown = directory.display();
        let typed = files::for_shell(&shown.to_string());
        let words = self.words();
        if is_run(directory) {
            return Failure::input(format_args!(
                "{shown}: is a run's directory, not {words}; its experiment is {shown}/{CONFIG}, and `oneiro resume {typed}` finishes \
                 the run"
            ));
        }
        if is_sweep(directory) {
            return Failure::input(format_args!(
                "{shown}: is a sweep's directory, not {words}; `oneiro sweep status {typed}` shows how far it is"
            ));
        }
        let names: Vec<String> = toml_files(directory)
            .iter()
            .take(MOST)
            .map(|path| path.display().to_string())
            .collect();
        let such_as = if names.is_empty() {
            String::new()
        } else {
            format!(", such as {}", names.join(", "))
        };
        Failure::input(format_args!(
            "{shown}: is a directory, not {words}; allowed: a TOML file{such_as}"
        ))
    }

    /// For a file that doesn't exist, with the one that could be meant.
    fn is_missing(self, path: &Path, error: &io::Error) -> Failure {
        /// Where this project has its experiments.
        const USUAL: &str = "experiments";
        let failure = Failure::unreadable(path, error);
        let is_toml = |path: &Path| path.extension().is_some_and(|extension| extension == "toml") && path.is_file();
        let meant = files::nearest(path, is_toml).or_else(|| {
            let alone = path.components().count() == 1;
            alone.then(|| files::nearest(&Path::new(USUAL).join(path), is_toml))?
        });
        match meant {
            Some(meant) => failure.and_say(&format!("; did you mean {}?", meant.display())),
            None if self == Self::Experiment => failure.and_say("; `oneiro new NAME` writes an experiment"),
            None => failure,
        }
    }
}

/// The TOML files of a directory, in the order of the numbers in their names; none if it can't be read.
fn toml_files(directory: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(directory).into_iter().flatten().flatten();
    let is_toml = |path: &PathBuf| path.extension().is_some_and(|extension| extension == "toml") && path.is_file();
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.path()).filter(is_toml).collect();
    files.sort_by(|a, b| files::by_numbers(a, b));
    files
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each shipped file is recognised as its kind, and accepted as no other.
    #[test]
    fn shipped_files_are_recognised() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let mut folders = vec![root.join("experiments"), root.join("studies")];
        let mut counts = [0; 5];
        while let Some(folder) = folders.pop() {
            for entry in fs::read_dir(&folder).unwrap() {
                let path = entry.unwrap().path();
                if path.is_dir() {
                    folders.push(path);
                    continue;
                }
                if path.extension().is_none_or(|extension| extension != "toml")
                    || ["claims.toml", "planned.toml", "Cargo.toml"]
                        .iter()
                        .any(|other| path.ends_with(other))
                {
                    continue;
                }
                let text = fs::read_to_string(&path).unwrap();
                let values = Parsed::new("a.toml".into(), &text).unwrap();
                let folder = folder.file_name().unwrap();
                let kind = match path.file_name().unwrap().to_str().unwrap() {
                    "study.toml" => FileKind::Study,
                    "experiment.toml" => FileKind::Experiment,
                    _ if folder == "experiments" || folder == "elsewhere" => FileKind::Experiment,
                    _ => FileKind::Sweep,
                };
                counts[kind as usize] += 1;
                for wanted in FileKind::ALL {
                    let expected = (wanted != kind).then_some(kind);
                    assert_eq!(wanted.mistaken(&values), expected, "{} as {wanted:?}", path.display());
                }
            }
        }
        assert!(
            counts[FileKind::Study as usize] >= 2 && counts[FileKind::Sweep as usize] >= 10,
            "{counts:?}"
        );
    }

    #[test]
    fn files_of_robots_are_recognised() {
        for (text, kind) in [
            (
                "experiment = \"a.toml\"\naddress = \"serial:COM3\"\nseed = 1\ndirectory = \"state\"",
                FileKind::Robot,
            ),
            (
                "experiment = \"a.toml\"\nrobot = 3\nkey = \"k\"\n[radio]\nlisten = \"x\"",
                FileKind::Robot,
            ),
            (
                "experiment = \"a.toml\"\nseed = 1\noperator = \"x\"\n[radio]\n[[robots]]\nnumber = 0",
                FileKind::Fleet,
            ),
            ("binary = \"oneiro\"\n[[robots]]\nnumber = 1", FileKind::Fleet),
        ] {
            let values = Parsed::new("a.toml".into(), text).unwrap();
            for wanted in FileKind::ALL {
                let expected = (wanted != kind).then_some(kind);
                assert_eq!(wanted.mistaken(&values), expected, "{text} as {wanted:?}");
            }
        }
        // A mistake in a file of the wanted kind doesn't make it another's.
        for (text, wanted) in [
            ("robots = 5\ncycles = 3", FileKind::Experiment),
            ("cycels = 3", FileKind::Experiment),
            ("experimnt = \"a.toml\"\nseeds = \"1..3\"", FileKind::Sweep),
            ("", FileKind::Experiment),
        ] {
            assert_eq!(
                wanted.mistaken(&Parsed::new("a.toml".into(), text).unwrap()),
                None,
                "{text}"
            );
        }
    }
}
