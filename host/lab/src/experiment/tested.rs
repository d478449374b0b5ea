//! An experiment with the values of its table `[test]`, which only tests have.

use std::path::Path;

use oneiro::parameter::Datum;
use oneiro_base::exit::{Failure, Result};

use super::inputs::{DIRECTORY, Files, Input};
use super::settings::Overrides;
use super::source::{Parsed, Setting, Source};
use super::{Experiment, values};

/// The table, and the tables and keys that it may have: those of episodes.
pub(super) const TEST: &str = "test";
const TESTED: [&str; 9] = [
    "arena", "cycles", "noise", "pucks", "robot", "start", "task", "trials", "worlds",
];

/// Why an experiment can't have its values of tests.
#[derive(Clone, Debug)]
pub(super) struct NotTested {
    pub(super) problem: String,
    /// Whether its file is wrong, and not only settings don't go with these values.
    pub(super) is_of_file: bool,
}

impl Experiment {
    /// This experiment with its values of tests, which settings override, except for those that a sweep varies.
    pub(super) fn tested(
        &self,
        path: &Path,
        file: &Parsed<'_>,
        set: &[Setting],
        files: &Files,
        source: &Source<'_>,
    ) -> Result<Self> {
        let refused = |problem: String| Err(source.invalid(TEST, problem));
        let (swept, others): (Vec<Setting>, _) = set.iter().cloned().partition(Setting::is_swept);
        let mut all = swept;
        let mut keys = Vec::new();
        for (key, datum) in &self.settings.test.0 {
            let table = key.split(['.', '[']).next().unwrap_or_default();
            if !TESTED.contains(&table) {
                return refused(format!("has {key:?}; allowed: keys of {}", TESTED.join(", ")));
            }
            if key.contains("[]") {
                return refused(format!(
                    "has {key:?}; allowed: the number of an element, as in \"arena.obstacles[0].x_mm\""
                ));
            }
            for key in paths(key, datum) {
                if keys.contains(&key) {
                    return refused(format!("has {key} twice; allowed: each key once"));
                }
                keys.push(key);
            }
            let place = source.place_of(&format!("{TEST}.{key}"));
            all.push(Setting::at(
                format!("{place}: {TEST}"),
                key,
                &values::value(datum, None),
            ));
        }
        all.extend(others);
        let invalid = |failure: Failure| {
            let words = failure.to_string();
            if words.contains(&format!(": {TEST}: ")) {
                return failure;
            }
            source.invalid(
                TEST,
                format_args!("makes another experiment, which is refused: {words}"),
            )
        };
        let (mut test, _) = Self::untested(path, file, &all, files).map_err(invalid)?;
        test.settings.test = Overrides::default();
        test.values.remove(TEST);
        let other = |own: &&Input| !self.inputs.iter().any(|input| input.name == own.name);
        if let Some(input) = test.inputs.iter().find(other) {
            return refused(format!(
                "names a file, {}, that the experiment doesn't name; allowed: files that it names too",
                input.name.trim_start_matches(DIRECTORY).trim_start_matches('/')
            ));
        }
        if test.world.gene_layout() != self.world.gene_layout() {
            return refused(
                "changes the genes; allowed: keys that don't, so that the same genomes can be tested".to_owned(),
            );
        }
        Ok(test)
    }

    /// Checks the values of tests of its file. Settings may not go with these, which matters only to those who ask for them.
    ///
    /// # Errors
    /// Exit 3 if the file's values are wrong.
    pub fn check_test(&self) -> Result {
        match &self.test {
            Some(Err(NotTested {
                problem,
                is_of_file: true,
            })) => Err(Failure::input(problem)),
            _ => Ok(()),
        }
    }

    /// The same experiment with its values of tests, which `--test` asks for.
    ///
    /// # Errors
    /// Exit 3 if it has none, and if settings don't go with them.
    pub fn tested_in(&self) -> Result<&Self> {
        match &self.test {
            Some(Ok(test)) => Ok(test),
            Some(Err(NotTested { problem, .. })) => Err(Failure::input(problem)),
            None => Err(Failure::input(format_args!(
                "the experiment {} has no table [test]; allowed: one with values for tests",
                self.name()
            ))),
        }
    }
}

/// The keys of a value of tests, which may be a table.
fn paths(key: &str, datum: &Datum) -> Vec<String> {
    match datum {
        Datum::Table(table) => {
            let inner = |(name, datum): &(String, Datum)| paths(&format!("{key}.{name}"), datum);
            table.iter().flat_map(inner).collect()
        }
        _ => vec![key.to_owned()],
    }
}
