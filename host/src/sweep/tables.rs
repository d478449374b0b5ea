//! The tables of a sweep: a row for each run, and in long form one for each of its generations. Whatever did the runs,
//! and in which order, the files have the same bytes.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::fmt::Write as _;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use toml::Value;

use super::journal::Generations;
use super::store::{AllFinished, Finished};
use super::{Plan, RunIndex, Sweep};
use crate::engine::disk;
use crate::exit::{Failure, Result};
use crate::runs::Holds;

/// The tables' names.
pub(crate) const RESULTS: &str = "results.csv";
pub(crate) const GENERATIONS: &str = "generations.csv";

/// Tables that were written.
#[derive(Debug)]
pub(crate) struct Written {
    pub(crate) runs: usize,
    /// The BLAKE3 hash of both files, one after the other.
    pub(crate) hash: String,
    pub(crate) files: Vec<PathBuf>,
}

impl Sweep {
    /// The columns of the table of results: the run and its id, the swept keys, the seed, what the run gave, and the hash
    /// of its results.
    pub(crate) fn columns(&self, plan: &Plan) -> Vec<(String, Holds)> {
        let mut columns = vec![("run".into(), Holds::Whole), ("id".into(), Holds::Text)];
        columns.extend(self.file().axes.iter().flat_map(|axis| {
            axis.keys.iter().enumerate().map(|(index, key)| {
                let values = axis.levels.iter().map(|level| &level[index].0);
                (key.clone(), holds(values))
            })
        }));
        columns.push(("seed".into(), Holds::Whole));
        columns.extend(plan.outcomes.iter().map(|(name, holds)| ((*name).into(), *holds)));
        columns.push(("result".into(), Holds::Text));
        columns
    }

    /// A cell's values as the table of results has them.
    pub(crate) fn levels(&self, cell: usize) -> Vec<String> {
        self.file()
            .values(cell)
            .into_iter()
            .map(|(value, _)| text(value))
            .collect()
    }
}

/// The columns of the table of generations: the run, and those of a run's own table.
fn columns_of_generations(plan: &Plan) -> Vec<(String, Holds)> {
    let own = plan.columns.iter().map(|(name, holds)| ((*name).into(), *holds));
    std::iter::once(("run".into(), Holds::Whole)).chain(own).collect()
}

fn holds<'a>(values: impl Iterator<Item = &'a Value>) -> Holds {
    values.fold(Holds::Whole, |known, value| match (known, value) {
        (Holds::Whole, Value::Integer(_)) => Holds::Whole,
        (Holds::Whole | Holds::Number, Value::Integer(_) | Value::Float(_)) => Holds::Number,
        _ => Holds::Text,
    })
}

/// A value as a table has it: words without quotes.
fn text(value: &Value) -> String {
    match value {
        Value::String(word) => word.clone(),
        other => other.to_string(),
    }
}

/// Writes the tables of all runs into a directory, in place of those that are there.
///
/// # Errors
/// Exit 1 when runs are missing, exit 5 when what was recorded is damaged, exit 6 when writing fails.
pub(crate) fn write(directory: &Path, sweep: &Sweep, plan: &Plan, finished: &AllFinished) -> Result<Written> {
    finished.is_all_of(sweep)?;
    let mut hasher = blake3::Hasher::new();
    let results = directory.join(RESULTS);
    disk::write_through(&results, |file| {
        let mut table = Table::new(&results, file, &mut hasher);
        write_results(&mut table, sweep, plan, finished)?;
        table.finish()
    })?;
    let generations = directory.join(GENERATIONS);
    disk::write_through(&generations, |file| {
        let mut table = Table::new(&generations, file, &mut hasher);
        write_generations(&mut table, plan, finished)?;
        table.finish()
    })?;
    let mut files = vec![results, generations];
    let columns = [sweep.columns(plan), columns_of_generations(plan)];
    for (index, columns) in columns.iter().enumerate() {
        files.extend(also_as_parquet(&files[index], columns)?);
    }
    disk::sync_directory(directory)?;
    Ok(Written {
        runs: finished.runs.len(),
        hash: hasher.finalize().to_hex().to_string(),
        files,
    })
}

/// Writes a table once more, in a program that can.
#[cfg(feature = "parquet")]
fn also_as_parquet(table: &Path, columns: &[(String, Holds)]) -> Result<Option<PathBuf>> {
    let path = table.with_extension("parquet");
    super::parquet::convert(table, &path, columns)?;
    Ok(Some(path))
}

#[cfg(not(feature = "parquet"))]
#[expect(clippy::unnecessary_wraps, reason = "the same as what can fail")]
fn also_as_parquet(_table: &Path, _columns: &[(String, Holds)]) -> Result<Option<PathBuf>> {
    Ok(None)
}

fn write_results(table: &mut Table<'_>, sweep: &Sweep, plan: &Plan, finished: &AllFinished) -> Result {
    let mut line = |cells: Vec<String>| {
        let mut row = csv::Writer::from_writer(Vec::new());
        // Writing to memory can't fail.
        let _ = row.write_record(&cells);
        table.push(&row.into_inner().unwrap_or_default())
    };
    line(sweep.columns(plan).into_iter().map(|(name, _)| name).collect())?;
    for (&run, Finished { line: known, .. }) in &finished.runs {
        let mut cells = vec![run.to_string(), plan.ids[run as usize].to_hex().to_string()];
        cells.extend(sweep.levels(sweep.cell_of(run)));
        cells.push(sweep.seed_of(run).to_string());
        cells.extend(known.cells.iter().cloned());
        cells.push(known.result.clone());
        line(cells)?;
    }
    Ok(())
}

fn write_generations(table: &mut Table<'_>, plan: &Plan, finished: &AllFinished) -> Result {
    table.push(format!("run,{}", String::from_utf8_lossy(&plan.head)).as_bytes())?;
    let mut journals: BTreeMap<usize, Generations> = BTreeMap::new();
    let mut rows = String::new();
    for (run, Finished { shard, line }) in &finished.runs {
        let journal = match journals.entry(*shard) {
            Entry::Occupied(open) => open.into_mut(),
            Entry::Vacant(new) => new.insert(Generations::open(&finished.shards[*shard])?),
        };
        rows.clear();
        for row in journal.of(line)?.lines() {
            // Writing to a string can't fail.
            let _ = writeln!(rows, "{run},{row}");
        }
        table.push(rows.as_bytes())?;
    }
    Ok(())
}

/// A file that is hashed as it is written.
struct Table<'a> {
    path: &'a Path,
    file: BufWriter<&'a mut File>,
    hasher: &'a mut blake3::Hasher,
}

impl<'a> Table<'a> {
    fn new(path: &'a Path, file: &'a mut File, hasher: &'a mut blake3::Hasher) -> Self {
        Self {
            path,
            file: BufWriter::with_capacity(1 << 20, file),
            hasher,
        }
    }

    fn push(&mut self, bytes: &[u8]) -> Result {
        self.hasher.update(bytes);
        self.file
            .write_all(bytes)
            .map_err(|error| Failure::storage(self.path, &error))
    }

    fn finish(mut self) -> Result {
        self.file.flush().map_err(|error| Failure::storage(self.path, &error))
    }
}

impl AllFinished {
    /// Says which runs no shard has done, if any.
    ///
    /// # Errors
    /// Exit 1.
    pub(crate) fn is_all_of(&self, sweep: &Sweep) -> Result {
        const SHOWN: usize = 10;
        let all = sweep.runs();
        let count = all - self.runs.len();
        if count == 0 {
            return Ok(());
        }
        let missing = (0..all as RunIndex).filter(|run| !self.runs.contains_key(run));
        let shown: Vec<String> = missing.take(SHOWN).map(|run| run.to_string()).collect();
        let more = if count > shown.len() { ", ..." } else { "" };
        Err(Failure::failed(format_args!(
            "{count} of {all} runs are missing: {}{more}; `oneiro sweep run` does them",
            shown.join(", ")
        )))
    }
}
