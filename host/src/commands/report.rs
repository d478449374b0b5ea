//! What is printed of finished runs.

use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::console::{Console, columns};
use crate::evolve::Champion;
use crate::exit::{Failure, Result};
use crate::record::{Done, SavedRun, rows};
use crate::run::Run;

/// A finished run in a few values.
#[derive(Debug, Serialize)]
pub(super) struct Report {
    pub(super) directory: PathBuf,
    pub(super) seed: u64,
    /// The best score, and its 32 bits in hex.
    fitness: f32,
    bits: String,
    /// When it lived, and which it was.
    generation: u32,
    individual: u32,
    /// Scores of the whole run that are NaN.
    nan: u64,
    /// The result's hash.
    pub(super) result: String,
}

impl Report {
    /// Of a run that has just ended.
    pub(super) fn new(run: &Run, done: &Done) -> Result<Self> {
        let champion = run
            .evolution()
            .champion()
            .ok_or_else(|| Failure::failed("a run has no champion"))?;
        Self::of(run.directory(), run.seed(), champion, done)
    }

    /// Of a run that ended some time ago.
    pub(super) fn read(directory: &Path, done: &Done) -> Result<Self> {
        let run = SavedRun::open(directory)?;
        Self::of(directory, run.seed(), &run.champion()?, done)
    }

    fn of(directory: &Path, seed: u64, champion: &Champion, done: &Done) -> Result<Self> {
        Ok(Self {
            directory: directory.to_owned(),
            seed,
            fitness: champion.fitness,
            bits: format!("{:08x}", champion.fitness.to_bits()),
            generation: champion.generation,
            individual: champion.individual,
            nan: rows(directory)?.iter().map(|row| u64::from(row.nan)).sum(),
            result: done.result.clone(),
        })
    }
}

/// Prints reports: one by itself, or several as a list.
pub(super) fn print(reports: &[Report], as_list: bool, console: Console) -> Result {
    for Report { directory, nan, .. } in reports.iter().filter(|report| report.nan > 0) {
        console.say(format!(
            "warning: {}: {nan} scores were NaN; they ranked last",
            directory.display()
        ));
    }
    match reports {
        [report] if !as_list && console.json() => console.json_data(report),
        _ if console.json() => console.json_data(&reports),
        [report] if !as_list => console.data(format!(
            "champion  fitness {} (bits {}), individual {} of generation {}\nresult    {}\nrun       {}",
            report.fitness,
            report.bits,
            report.individual,
            report.generation,
            report.result,
            report.directory.display()
        )),
        _ => {
            let row = |report: &Report| {
                vec![
                    report.directory.display().to_string(),
                    report.seed.to_string(),
                    report.fitness.to_string(),
                    report.generation.to_string(),
                    report.result.chars().take(12).collect(),
                ]
            };
            let rows: Vec<Vec<String>> = reports.iter().map(row).collect();
            console.data(columns(&["run", "seed", "fitness", "generation", "result"], &rows))
        }
    }
}
