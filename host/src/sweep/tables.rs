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

use super::journal::Generations;
use super::store::{AllFinished, Finished};
use super::{Plan, RunIndex, Sweep};
use crate::engine::disk;
use crate::exit::{Failure, Result};
use crate::report::csv::Csv;
use crate::runs::Holds;

/// File names of the tables.
pub(crate) const RESULTS: &str = "results.csv";
pub(crate) const GENERATIONS: &str = "generations.csv";
pub(crate) const CHAMPIONS: &str = "champions.csv";

/// Tables written by [`write()`].
#[derive(Debug)]
pub(crate) struct Written {
    pub(crate) runs: usize,
    /// BLAKE3 hash of the tables of results and of generations, one after the other.
    pub(crate) hash: String,
    pub(crate) files: Vec<PathBuf>,
}

impl Sweep {
    /// Columns of the table of results: the run and its id, the swept keys, the seed, the run's results, and their
    /// hash.
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

    /// A cell's values as they stand in the table of results.
    pub(crate) fn levels(&self, cell: usize) -> Vec<String> {
        self.file()
            .values(cell)
            .into_iter()
            .map(|(value, _)| text(value))
            .collect()
    }
}

/// Columns of the table of generations: the run, and the columns of a run's own table.
fn columns_of_generations(plan: &Plan) -> Vec<(String, Holds)> {
    let own = plan.columns.iter().map(|(name, holds)| ((*name).into(), *holds));
    std::iter::once(("run".into(), Holds::Whole)).chain(own).collect()
}

/// The columns of the table of champions: the run, and the genes of all cells' controllers by their names. None of runs
/// without champions.
fn columns_of_champions(plan: &Plan) -> Vec<(String, Holds)> {
    let mut controllers: Vec<Controller> = Vec::new();
    for &controller in plan.controllers.iter().flatten() {
        if !controllers.contains(&controller) {
            controllers.push(controller);
        }
    }
    let mut columns = Vec::new();
    for gene in controllers.into_iter().flat_map(Controller::gene_names) {
        let column = (gene, Holds::Number);
        if !columns.contains(&column) {
            columns.push(column);
        }
    }
    if !columns.is_empty() {
        columns.insert(0, ("run".into(), Holds::Whole));
    }
    columns
}

fn holds<'a>(values: impl Iterator<Item = &'a Value>) -> Holds {
    values.fold(Holds::Whole, |known, value| match (known, value) {
        (Holds::Whole, Value::Integer(_)) => Holds::Whole,
        (Holds::Whole | Holds::Number, Value::Integer(_) | Value::Float(_)) => Holds::Number,
        _ => Holds::Text,
    })
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
        (generations, columns_of_generations(plan)),
    ];
    let genes = columns_of_champions(plan);
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

/// The genes of each run's champion. Those that its controller does not have are empty.
fn champions_table(columns: &[(String, Holds)], sweep: &Sweep, plan: &Plan, finished: &AllFinished) -> String {
    let mut table = Csv::new(columns.iter().map(|(name, _)| name));
    for (&run, Finished { line, .. }) in &finished.runs {
        let names = plan.controllers[sweep.cell_of(run)].map_or_else(Vec::new, Controller::gene_names);
        let genes: BTreeMap<&String, &f32> = names.iter().zip(&line.champion).collect();
        let gene = |(name, _): &(String, Holds)| genes.get(name).map(ToString::to_string).unwrap_or_default();
        table.row(std::iter::once(run.to_string()).chain(columns[1..].iter().map(gene)));
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
