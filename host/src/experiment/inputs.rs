//! The files that an experiment names: found, read, and hashed, so that a run can keep copies.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use oneiro::tables::{self, MotorTable, SensorTables};

use super::settings::{self, BUILT_IN, SensorFiles, Settings};
use super::source::Source;
use crate::evolve::Population;
use crate::exit::{Failure, Result};
use crate::genomes;

/// The directory of a run's copies.
pub(crate) const DIRECTORY: &str = "inputs";

/// A file that an experiment names.
#[derive(Debug)]
pub(crate) struct Input {
    /// As the experiment has it.
    named: String,
    /// Its name in a run's directory.
    pub(crate) name: String,
    /// What it holds.
    pub(crate) bytes: Vec<u8>,
}

impl Input {
    fn hash(&self) -> String {
        blake3::hash(&self.bytes).to_hex().to_string()
    }
}

/// Reads the files that an experiment names.
pub(super) struct Inputs<'a> {
    /// Where the experiment lies.
    directory: &'a Path,
    source: &'a Source,
    /// Hashes that the experiment gives.
    hashes: &'a BTreeMap<String, String>,
    found: Vec<Input>,
    warnings: Vec<String>,
}

impl<'a> Inputs<'a> {
    pub(super) fn new(directory: &'a Path, source: &'a Source, hashes: &'a BTreeMap<String, String>) -> Self {
        Self {
            directory,
            source,
            hashes,
            found: Vec::new(),
            warnings: Vec::new(),
        }
    }

    /// The sensor tables.
    pub(super) fn sensors(&mut self, files: &SensorFiles) -> Result<Arc<SensorTables>> {
        let SensorFiles::Files(files) = files else {
            return Ok(SensorTables::khepera());
        };
        if files.is_empty() {
            return Err(self
                .source
                .invalid("robot.tables", "is empty; allowed: a file for each class of object"));
        }
        let paths = files
            .iter()
            .enumerate()
            .map(|(index, file)| self.take(&format!("robot.tables[{index}]"), file))
            .collect::<Result<Vec<_>>>()?;
        let import = SensorTables::read(&paths).map_err(|error| self.refused("robot.tables", error))?;
        self.warnings.extend(import.warnings);
        Ok(Arc::new(import.table))
    }

    /// The motor table.
    pub(super) fn motors(&mut self, file: &str, states: settings::MotorStates) -> Result<Arc<MotorTable>> {
        let states = match states {
            settings::MotorStates::Symmetric => tables::MotorStates::Symmetric20,
            settings::MotorStates::Asymmetric => tables::MotorStates::Asymmetric20,
            settings::MotorStates::Evorobot => tables::MotorStates::Evorobot21,
        };
        if file == BUILT_IN {
            return Ok(MotorTable::khepera(states));
        }
        let path = self.take("robot.motors", file)?;
        MotorTable::read(path, states)
            .map(Arc::new)
            .map_err(|error| self.refused("robot.motors", error))
    }

    /// The genes that an evolution starts from.
    pub(super) fn init(&mut self, file: Option<&str>, genes: usize, population: u32) -> Result<Option<Population>> {
        const KEY: &str = "evolution.init";
        let Some(file) = file else {
            return Ok(None);
        };
        let path = self.take(KEY, file)?;
        let genomes = genomes::read(&path, genes).map_err(|failure| self.source.invalid(KEY, failure))?;
        if genomes.len() != population as usize {
            let problem = format!(
                "{} holds {} genomes; allowed: as many as evolution.population, {population}",
                path.display(),
                genomes.len()
            );
            return Err(self.source.invalid(KEY, problem));
        }
        Ok(Some(genomes))
    }

    /// What was read, and what the user should know of it.
    pub(super) fn finish(self) -> Result<(Vec<Input>, Vec<String>)> {
        let is_named = |file: &String| self.found.iter().any(|input| input.named == *file);
        if let Some(file) = self.hashes.keys().find(|file| !is_named(file)) {
            let problem = "is a file that no other key names; allowed: hashes of the files that are named";
            return Err(self.source.invalid(&format!("files.{file}"), problem));
        }
        Ok((self.found, self.warnings))
    }

    /// Keeps a file and checks its hash, if one is given. Its path.
    fn take(&mut self, key: &str, file: &str) -> Result<PathBuf> {
        let path = self.directory.join(file);
        let bytes = fs::read(&path).map_err(|error| self.source.invalid(key, Failure::unreadable(&path, &error)))?;
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let input = Input {
            named: file.into(),
            name: format!("{DIRECTORY}/{name}"),
            bytes,
        };
        if let Some(expected) = self.hashes.get(file)
            && *expected != input.hash()
        {
            let problem = format!(
                "{} has changed: its BLAKE3 hash is {}, not {expected}",
                path.display(),
                input.hash()
            );
            return Err(self.source.invalid(key, problem));
        }
        if let Some(other) = self.found.iter().find(|other| other.name == input.name) {
            let problem = format!(
                "{file} and {} have one name; allowed: files of different names",
                other.named
            );
            return Err(self.source.invalid(key, problem));
        }
        self.found.push(input);
        Ok(path)
    }

    fn refused(&self, key: &str, error: tables::Error) -> Failure {
        self.source.invalid(key, error)
    }
}

/// Names files as a run's directory has them, and gives their hashes.
pub(super) fn rename(settings: &mut Settings, inputs: &[Input]) {
    let rename = |file: &mut String| {
        if let Some(input) = inputs.iter().find(|input| input.named == *file) {
            file.clone_from(&input.name);
        }
    };
    if let SensorFiles::Files(files) = &mut settings.robot.tables {
        files.iter_mut().for_each(rename);
    }
    rename(&mut settings.robot.motors);
    settings.evolution.init.iter_mut().for_each(rename);
    settings.files = inputs.iter().map(|input| (input.name.clone(), input.hash())).collect();
}
