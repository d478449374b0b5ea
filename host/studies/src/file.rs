//! A study's file: the values that it changes in an experiment, and its arms, which are named sets of further changes.
//! The papers' studies are compiled in; a user's file can replace one.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use oneiro::parameter::{Choice, Choices};
use oneiro_base::exit::{Failure, Result};
use oneiro_base::files;
pub use oneiro_experiments::{MIGLINO1995, ODOWD2014, Study as Shipped};
use oneiro_lab::experiment::kinds::FileKind;
use oneiro_lab::experiment::source::{Parsed, Setting, Source};
use serde::Deserialize;
use toml::{Table, Value};

use super::assumptions::Assumption;

/// An edition of a study: its values, its criteria and its arms.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Edition {
    First,
    /// The contents of a study's file.
    #[default]
    Second,
}

impl Choice for Edition {
    const CHOICES: Choices<Self> = &[
        (
            "second",
            Self::Second,
            "bodies slide in the simulator, at its calibrated severities",
        ),
        (
            "first",
            Self::First,
            "superseded: the simulator undoes collisions, and the severity is 1.75",
        ),
    ];
}

/// The values in which an earlier edition differs, and their sources.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct Earlier {
    #[serde(default)]
    pub(crate) sources: BTreeMap<String, String>,
    #[serde(flatten)]
    changes: Table,
}

/// A study's file, read from disk or compiled in, in one of its editions.
pub struct StudyFile {
    shipped: &'static Shipped,
    /// Path of the file; `None` if it is compiled in.
    path: Option<PathBuf>,
    text: Cow<'static, str>,
    edition: Edition,
    /// What an earlier edition changes.
    changes: Table,
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
            edition: Edition::default(),
            changes: Table::new(),
        })
    }

    /// Takes the values of an edition.
    ///
    /// # Errors
    /// Exit 3 if the file does not have it; as [`StudyFile::under`].
    pub fn in_edition(self, edition: Edition) -> Result<Self> {
        /// The rest of the file is read by the study.
        #[derive(Deserialize)]
        struct File {
            #[serde(default)]
            editions: BTreeMap<String, Earlier>,
        }
        if edition == Edition::default() {
            return Ok(self);
        }
        let word = edition.word();
        let earlier = self.under(&Arm::main(), |mut file: File, source| {
            let earlier = file.editions.remove(word);
            let problem = "is missing; allowed: a table, as in the shipped file";
            earlier.ok_or_else(|| source.invalid(&format!("editions.{word}"), problem))
        })?;
        Ok(Self {
            edition,
            changes: earlier.changes,
            ..self
        })
    }

    /// The edition whose values it has.
    pub(crate) fn edition(&self) -> Edition {
        self.edition
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
        let of_edition = placed(&format!("{name}: edition {}", self.edition.word()), &self.changes);
        let settings: Vec<Setting> = of_edition.into_iter().chain(arm.settings(&name)).collect();
        let parsed = Parsed::new(name, &self.text)?;
        let (values, source) = Source::read(&parsed, &settings)?;
        make(values, &source)
    }

    /// The edition's arms, grouped by subject.
    ///
    /// # Errors
    /// As [`StudyFile::under`].
    pub fn groups(&self) -> Result<Vec<Group>> {
        let mut groups = self.all_groups()?;
        groups.retain(|group| group.is_of(self.edition));
        Ok(groups)
    }

    /// The arms of all editions.
    fn all_groups(&self) -> Result<Vec<Group>> {
        /// The rest of the file is read by the study.
        #[derive(Deserialize)]
        struct File {
            #[serde(default)]
            arms: Vec<Group>,
        }
        self.under(&Arm::main(), |file: File, _| Ok(file.arms))
    }

    /// The unchanged study, and then all other arms of the edition.
    ///
    /// # Errors
    /// As [`StudyFile::under`].
    pub fn arms(&self) -> Result<Vec<Arm>> {
        self.groups().map(Arm::main_and)
    }

    /// The same of all editions.
    ///
    /// # Errors
    /// As [`StudyFile::under`].
    pub fn arms_of_all_editions(&self) -> Result<Vec<Arm>> {
        self.all_groups().map(Arm::main_and)
    }

    /// Finds an arm by name.
    ///
    /// # Errors
    /// Exit 2 with the names of all arms, or with the edition that has it.
    pub(crate) fn arm(&self, name: &str) -> Result<Arm> {
        if name == Arm::MAIN {
            return Ok(Arm::main());
        }
        let arms = self.arms()?;
        let names: Vec<&str> = arms.iter().map(|arm| arm.name.as_str()).collect();
        let names = names.join(", ");
        let unknown = || -> Result<Failure> {
            let has = |group: &Group| group.arms.iter().any(|arm| arm.name == name);
            let group = self.all_groups()?.into_iter().find(has);
            Ok(Failure::usage(match group.and_then(|group| group.edition) {
                None => format!("--arm {name}: no such arm; allowed: {names}"),
                Some(other) => {
                    let here = self.edition.word();
                    format!(
                        "--arm {name}: is an arm of the {other} edition; allowed: --edition {other}, or of the {here}: {names}"
                    )
                }
            }))
        };
        match arms.iter().find(|arm| arm.name == name) {
            Some(arm) => Ok(arm.clone()),
            None => Err(unknown()?),
        }
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
    /// The only edition that has them.
    edition: Option<String>,
    pub arms: Vec<Arm>,
}

impl Group {
    fn is_of(&self, edition: Edition) -> bool {
        self.edition.as_deref().is_none_or(|name| name == edition.word())
    }
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

    /// Whether it changes a key, or one below it.
    pub(crate) fn changes(&self, [table, key]: [&str; 2]) -> bool {
        self.changes.get(table).is_some_and(|own| own.get(key).is_some())
    }

    /// The unchanged study.
    pub(crate) fn main() -> Self {
        Self {
            name: Self::MAIN.into(),
            words: "The study's own values".into(),
            changes: Table::new(),
        }
    }

    /// The unchanged study, and the arms of some groups.
    fn main_and(groups: Vec<Group>) -> Vec<Self> {
        let others = groups.into_iter().flat_map(|group| group.arms);
        std::iter::once(Self::main()).chain(others).collect()
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
        placed(&format!("{file}: arm {}", self.name), &self.changes)
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

/// Settings from one place.
fn placed(place: &str, changes: &Table) -> Vec<Setting> {
    let values = leaves(changes).into_iter();
    values
        .map(|(key, value)| Setting::at(place.to_owned(), &key, &value))
        .collect()
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
