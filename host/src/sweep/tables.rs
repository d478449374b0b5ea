//! Tables of a sweep: one row per run, in long form one row per generation of each run, and the champions' genes.
//! Whichever processes did the runs, in whatever order, the files have the same bytes.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::fmt::Write as _;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use oneiro::world::Controller;
use toml::Value;

use super::contents::{CHAMPIONS, GENERATIONS, RESULTS, columns_of_champions, columns_of_generations};
use super::journal::Generations;
use super::store::{AllFinished, Finished};
use super::{Plan, RunIndex, Sweep};
use crate::contents::Column;
use crate::engine::disk;
use crate::exit::{Failure, Result};
use crate::report::csv::Csv;

/// Tables written by [`write()`].
#[derive(Debug)]
pub(crate) struct Written {
    pub(crate) runs: usize,
    /// BLAKE3 hash of the tables of results and of generations, one after the other.
    pub(crate) hash: String,
    pub(crate) files: Vec<PathBuf>,
}

impl Sweep {
    /// A cell's values as they stand in the table of results.
    pub(crate) fn levels(&self, cell: usize) -> Vec<String> {
        self.file()
            .values(cell)
            .into_iter()
            .map(|(value, _)| text(value))
            .collect()
    }
}

/// A value as it stands in a table: strings without quotes.
fn text(value: &Value) -> String {
    match value {
        Value::String(word) => word.clone(),
        other => other.to_string(),
    }
}

/// Writes the tables of all runs into a directory, replacing earlier ones.
///
/// # Errors
/// Exit 1 if runs are missing, exit 5 if recorded data is damaged, exit 6 if writing fails.
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
    let mut tables = vec![
        (results, sweep.columns(plan)),
        (generations, columns_of_generations(plan.columns)),
    ];
    let genes = columns_of_champions(&plan.controllers);
    if !genes.is_empty() {
        let champions = directory.join(CHAMPIONS);
        disk::write(&champions, champions_table(&genes, sweep, plan, finished).as_bytes())?;
        tables.push((champions, genes));
    }
    let mut files: Vec<PathBuf> = tables.iter().map(|(table, _)| table.clone()).collect();
    for (table, columns) in &tables {
        files.extend(also_as_parquet(table, columns)?);
    }
    disk::sync_directory(directory)?;
    Ok(Written {
        runs: finished.runs.len(),
        hash: hasher.finalize().to_hex().to_string(),
        files,
    })
}

/// Also writes a table as Parquet if the program was built with it.
#[cfg(feature = "parquet")]
fn also_as_parquet(table: &Path, columns: &[Column]) -> Result<Option<PathBuf>> {
    let path = table.with_extension("parquet");
    super::parquet::convert(table, &path, columns)?;
    Ok(Some(path))
}

#[cfg(not(feature = "parquet"))]
#[expect(clippy::unnecessary_wraps, reason = "the same as what can fail")]
fn also_as_parquet(_table: &Path, _columns: &[Column]) -> Result<Option<PathBuf>> {
    Ok(None)
}

fn write_results(table: &mut Table<'_>, sweep: &Sweep, plan: &Plan, finished: &AllFinished) -> Result {
    let mut line = |cells: Vec<String>| {
        let mut row = csv::Writer::from_writer(Vec::new());
        // Writing to memory can't fail.
        let _ = row.write_record(&cells);
        table.push(&row.into_inner().unwrap_or_default())
    };
    line(
        sweep
            .columns(plan)
            .into_iter()
            .map(|column| column.name.into_owned())
            .collect(),
    )?;
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

/// The genes of each run's champion. Genes that its controller doesn't have are empty.
fn champions_table(columns: &[Column], sweep: &Sweep, plan: &Plan, finished: &AllFinished) -> String {
    let genes = &columns[1..];
    let positions = |controller: Controller| -> Vec<Option<usize>> {
        let names = controller.gene_names();
        let position = |gene: &Column| names.iter().position(|name| *name == gene.name);
        genes.iter().map(position).collect()
    };
    // The positions of the columns' genes in each controller's genome: a sweep has few controllers and many runs.
    let mut known: Vec<(Option<Controller>, Vec<Option<usize>>)> = vec![(None, vec![None; genes.len()])];
    let mut table = Csv::new(columns);
    for (&run, Finished { line, .. }) in &finished.runs {
        let controller = plan.controllers[sweep.cell_of(run)];
        if known.iter().all(|(other, _)| *other != controller) {
            known.push((controller, controller.map_or_else(Vec::new, positions)));
        }
        let own = known.iter().find(|(other, _)| *other == controller);
        let cells = own.into_iter().flat_map(|(_, positions)| positions).map(|position| {
            let value = position.and_then(|position| line.champion.get(position));
            value.map(ToString::to_string).unwrap_or_default()
        });
        table.row(std::iter::once(run.to_string()).chain(cells));
    }
    table.text()
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
    /// Checks that shards have done all runs.
    ///
    /// # Errors
    /// Exit 1 with the missing runs.
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
