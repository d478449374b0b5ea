//! A study's file: the values that it changes in an experiment, and its arms, which are named sets of further changes.
//! The papers' studies are compiled in; a user's file can replace one.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use oneiro_base::exit::{Failure, Result};
use oneiro_base::files;
pub use oneiro_experiments::{MIGLINO1995, ODOWD2014, Study as Shipped};
use oneiro_lab::experiment::kinds::FileKind;
use oneiro_lab::experiment::source::{Parsed, Setting, Source};
use serde::Deserialize;
use toml::{Table, Value};

use super::assumptions::Assumption;

/// A study's file, read from disk or compiled in.
pub struct StudyFile {
    shipped: &'static Shipped,
    /// Path of the file; `None` if it is compiled in.
    path: Option<PathBuf>,
    text: Cow<'static, str>,
}

impl StudyFile {
    /// Reads a user's file, or takes the compiled-in one.
    ///
    /// # Errors
    /// Exit 3 if the file doesn't exist or isn't text.
    pub fn open(shipped: &'static Shipped, path: Option<&Path>) -> Result<Self> {
        let text = match path {
            None => Cow::Borrowed(shipped.text),
            Some(path) => {
                let text = FileKind::Study.text(path)?;
                FileKind::Study.parsed(path, &text)?;
                Cow::Owned(text)
            }
        };
        Ok(Self {
            shipped,
            path: path.map(Path::to_owned),
            text,
        })
    }

    /// Hash of a user's study file; `None` for the compiled-in one.
    pub(crate) fn own_hash(&self) -> Option<String> {
        self.path
            .is_some()
            .then(|| blake3::hash(self.text.as_bytes()).to_hex()[..16].to_owned())
    }

    /// Reads the file's values under an arm and converts them; the conversion may refuse a value, with its place in the
    /// file.
    ///
    /// # Errors
    /// Exit 3: the file, line and column (or the arm), the key, the value found and the values allowed.
    pub fn under<T: for<'a> Deserialize<'a>, U>(
        &self,
        arm: &Arm,
        make: impl FnOnce(T, &Source<'_>) -> Result<U>,
    ) -> Result<U> {
        let name = self.path.as_deref().unwrap_or(Path::new(self.shipped.path));
        let name = name.display().to_string();
        let settings = arm.settings(&name);
        let parsed = Parsed::new(name, &self.text)?;
        let (values, source) = Source::read(&parsed, &settings)?;
        make(values, &source)
    }

    /// The arms, grouped by subject.
    ///
    /// # Errors
    /// As [`StudyFile::under`].
    pub fn groups(&self) -> Result<Vec<Group>> {
        /// The rest of the file is read by the study.
        #[derive(Deserialize)]
        struct File {
            #[serde(default)]
            arms: Vec<Group>,
        }
        self.under(&Arm::main(), |file: File, _| Ok(file.arms))
    }

    /// The unchanged study, and then all other arms.
    ///
    /// # Errors
    /// As [`StudyFile::under`].
    pub fn arms(&self) -> Result<Vec<Arm>> {
        let others = self.groups()?.into_iter().flat_map(|group| group.arms);
        Ok(std::iter::once(Arm::main()).chain(others).collect())
    }

    /// Finds an arm by name.
    ///
    /// # Errors
    /// Exit 2 with the names of all arms.
    pub(crate) fn arm(&self, name: &str) -> Result<Arm> {
        if name == Arm::MAIN {
            return Ok(Arm::main());
        }
        let arms = self.arms()?;
        let names: Vec<&str> = arms.iter().map(|arm| arm.name.as_str()).collect();
        let unknown = Failure::usage(format_args!("--arm {name}: no such arm; allowed: {}", names.join(", ")));
        arms.into_iter().find(|arm| arm.name == name).ok_or(unknown)
    }

    /// Path and text of the experiment that a file names, or of the compiled-in one if it names none.
    ///
    /// # Errors
    /// Exit 3 if the file doesn't exist or isn't text.
    pub fn experiment(&self, named: Option<&str>) -> Result<(PathBuf, Cow<'static, str>)> {
        match (&self.path, named) {
            (Some(study), Some(named)) => {
                let path = study.parent().unwrap_or(Path::new("")).join(named);
                let text = files::text(&path)?;
                Ok((path, Cow::Owned(text)))
            }
            _ => Ok((
                self.shipped.experiment_path.into(),
                Cow::Borrowed(self.shipped.experiment),
            )),
        }
    }
}

/// Arms that vary the same subject.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Group {
    pub about: String,
    pub arms: Vec<Arm>,
}

/// An alternative to one of the study's assumptions.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct Arm {
    /// Name on the command line and in files.
    pub name: String,
    /// One-line description of the assumption.
    pub words: String,
    /// Values that replace those of the study's file.
    #[serde(flatten)]
    changes: Table,
}

impl Arm {
    /// Name of the unchanged study.
    pub(crate) const MAIN: &str = "main";

    /// The unchanged study.
    pub(crate) fn main() -> Self {
        Self {
            name: Self::MAIN.into(),
            words: "As preregistered".into(),
            changes: Table::new(),
        }
    }

    /// Whether the arm changes nothing.
    pub(crate) fn is_main(&self) -> bool {
        self.changes.is_empty()
    }

    /// Keys of the values that it replaces.
    pub(crate) fn changed_keys(&self) -> Vec<String> {
        leaves(&self.changes).into_iter().map(|(key, _)| key).collect()
    }

    fn settings(&self, file: &str) -> Vec<Setting> {
        let place = format!("{file}: arm {}", self.name);
        let values = leaves(&self.changes).into_iter();
        values
            .map(|(key, value)| Setting::at(place.clone(), &key, &value))
            .collect()
    }

    /// Rows of the report's table of assumptions: each value by its key, with its source. For values that the arm
    /// changes, the source is the arm.
    pub(crate) fn assumptions<'a>(
        &self,
        values: impl IntoIterator<Item = (String, String)>,
        source: impl Fn(&str) -> Option<&'a str>,
    ) -> Vec<Assumption> {
        let changed = self.changed_keys();
        let words = format!("arm {}: {}", self.name, self.words);
        let rows = values.into_iter().map(|(name, value)| {
            // In the study's file, the values of all conditions stand under `set`.
            let is_changed = changed
                .iter()
                .any(|key| *key == name || key.strip_prefix("set.") == Some(&name));
            let source = if is_changed {
                &words
            } else {
                source(&name).unwrap_or_default()
            };
            Assumption {
                value,
                source: source.into(),
                name,
            }
        });
        let arm = (!self.is_main()).then(|| Assumption {
            name: "arm".into(),
            value: self.name.clone(),
            source: self.words.clone(),
        });
        arm.into_iter().chain(rows).collect()
    }
}

/// Values of a table and its nested tables by dotted key.
pub fn leaves(table: &Table) -> Vec<(String, Value)> {
    fn collect(table: &Table, prefix: &str, all: &mut Vec<(String, Value)>) {
        for (key, value) in table {
            let key = format!("{prefix}{key}");
            match value {
                Value::Table(table) => collect(table, &format!("{key}."), all),
                _ => all.push((key, value.clone())),
            }
        }
    }
    let mut all = Vec::new();
    collect(table, "", &mut all);
    all
}

/// Converts the values of a table under a key of a study's file into settings with their place.
pub fn settings(under: &str, table: &Table, source: &Source<'_>) -> Vec<Setting> {
    let values = leaves(table).into_iter();
    values
        .map(|(key, value)| Setting::at(source.place_of(&format!("{under}.{key}")), &key, &value))
        .collect()
}

/// Values of an experiment that affect results, formatted for readers, by key.
pub fn listed(resolved: &str) -> BTreeMap<String, String> {
    let table: Table = resolved.parse().expect("a resolved experiment is TOML");
    let decides =
        |key: &str| !["name", "seed"].contains(&key) && !["record.", "files."].iter().any(|no| key.starts_with(no));
    let values = leaves(&table).into_iter().filter(|(key, _)| decides(key));
    values.map(|(key, value)| (key, words(&value))).collect()
}

/// Formats a value for readers: strings without quotes.
pub fn words(value: &Value) -> String {
    match value {
        Value::String(word) => word.clone(),
        // In single precision, as written in the file.
        Value::Float(number) => (*number as f32).to_string(),
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compiled-in texts equal the repository's, and studies name experiments in the same folder.
    #[test]
    fn shipped_studies_name_the_experiments_that_are_compiled_in_with_them() {
        for shipped in [&MIGLINO1995, &ODOWD2014] {
            let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
            let table: Table = shipped.text.parse().unwrap();
            let named = root
                .join(shipped.path)
                .parent()
                .unwrap()
                .join(table["experiment"].as_str().unwrap());
            let compiled_in = root.join(shipped.experiment_path);
            assert_eq!(named.canonicalize().unwrap(), compiled_in.canonicalize().unwrap());
        }
    }

    #[test]
    fn arms_have_names_and_words_of_their_own_and_change_something() {
        for shipped in [&MIGLINO1995, &ODOWD2014] {
            let file = StudyFile::open(shipped, None).unwrap();
            let arms: Vec<Arm> = file
                .groups()
                .unwrap()
                .into_iter()
                .flat_map(|group| group.arms)
                .collect();
            for (place, arm) in arms.iter().enumerate() {
                assert!(!arm.is_main() && !arm.words.is_empty(), "{}", arm.name);
                let differs =
                    |other: &Arm| other.name != arm.name && other.words != arm.words && other.changes != arm.changes;
                assert!(arms[..place].iter().all(differs), "{}", arm.name);
                assert_eq!(file.arm(&arm.name).unwrap(), *arm);
            }
            let refusal = file.arm("only-magic").unwrap_err().to_string();
            assert!(
                refusal.contains("allowed: main, ") && refusal.contains(&arms[3].name),
                "{refusal}"
            );
        }
    }
}
