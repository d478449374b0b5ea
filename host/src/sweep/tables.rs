//! The tables of a sweep: a row for each run, and in long form one for each of its generations. Whatever did the runs,
//! and in which order, the files have the same bytes.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use toml::Value;

use super::journal::Generations;
use super::store::{AllFinished, Finished};
use super::table::Holds;
use super::{Plan, RunIndex, Sweep};
use crate::exit::{Failure, Result};
use crate::record::disk;

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
    pub(crate) fn columns(&self) -> Vec<(String, Holds)> {
        let mut columns = vec![("run".into(), Holds::Whole), ("id".into(), Holds::Text)];
        columns.extend(self.file().axes.iter().flat_map(|axis| {
            axis.keys.iter().enumerate().map(|(index, key)| {
                let values = axis.levels.iter().map(|level| &level[index].0);
                (key.clone(), holds(values))
            })
        }));
        columns.push(("seed".into(), Holds::Whole));
        columns.extend(self.outcomes().into_iter().map(|(name, holds)| (name.into(), holds)));
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
    if finished.runs.len() < sweep.runs() {
        return Err(missing(sweep, finished));
    }
    let files = [directory.join(RESULTS), directory.join(GENERATIONS)];
    let mut hasher = blake3::Hasher::new();
    disk::stream(&files[0], |file| {
        results(Hashed(file, &mut hasher), sweep, plan, finished)
    })?;
    disk::stream(&files[1], |file| {
        generations(Hashed(file, &mut hasher), sweep, finished)
    })?;
    disk::sync_directory(directory)?;
    Ok(Written {
        runs: finished.runs.len(),
        hash: hasher.finalize().to_hex().to_string(),
        files: files.to_vec(),
    })
}

fn results(file: impl Write, sweep: &Sweep, plan: &Plan, finished: &AllFinished) -> disk::Streamed {
    let mut table = csv::Writer::from_writer(file);
    table
        .write_record(sweep.columns().iter().map(|(name, _)| name))
        .map_err(io::Error::from)?;
    for (&run, Finished { line, .. }) in &finished.runs {
        let mut row = vec![run.to_string(), plan.ids[run as usize].to_hex().to_string()];
        row.extend(sweep.levels(sweep.cell_of(run)));
        row.push(sweep.seed_of(run).to_string());
        row.extend(line.cells.iter().cloned());
        row.push(line.result.clone());
        table.write_record(&row).map_err(io::Error::from)?;
    }
    Ok(table.flush()?)
}

fn generations(mut file: impl Write, sweep: &Sweep, finished: &AllFinished) -> disk::Streamed {
    write!(file, "run,{}", sweep.generations_head())?;
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
            let _ = std::fmt::Write::write_fmt(&mut rows, format_args!("{run},{row}\n"));
        }
        file.write_all(rows.as_bytes())?;
    }
    Ok(())
}

/// Says which runs no shard has done.
fn missing(sweep: &Sweep, finished: &AllFinished) -> Failure {
    const SHOWN: usize = 10;
    let all = sweep.runs();
    let shown: Vec<String> = (0..all as RunIndex)
        .filter(|run| !finished.runs.contains_key(run))
        .take(SHOWN)
        .map(|run| run.to_string())
        .collect();
    let count = all - finished.runs.len();
    let more = if count > shown.len() { ", ..." } else { "" };
    Failure::failed(format_args!(
        "{count} of {all} runs are missing: {}{more}; `oneiro sweep run` does them",
        shown.join(", ")
    ))
}

/// Writes, and hashes what is written.
struct Hashed<'a, W>(W, &'a mut blake3::Hasher);

impl<W: Write> Write for Hashed<'_, W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.0.write(bytes)?;
        self.1.update(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
}
