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

use super::file::Axis;
use super::journal::Generations;
use super::store::{AllFinished, Finished};
use super::{Plan, RunIndex, Sweep};
use crate::contents::{Column, Entry as Contents, Holds};
use crate::engine::disk;
use crate::exit::{Failure, Result};
use crate::report::csv::Csv;

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
    /// The columns of the table of results.
    pub(crate) fn columns(&self, plan: &Plan) -> Vec<Column> {
        let swept = self.file().axes.iter().flat_map(|axis| {
            axis.keys.iter().enumerate().map(|(index, key)| {
                let values = axis.levels.iter().map(|level| &level[index].0);
                Column::new("", "", SWEPT, holds(values)).named(key.clone())
            })
        });
        columns_of_results(swept.collect(), plan.outcomes.clone())
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

/// What a column of a swept key holds.
const SWEPT: &str = "the value of this key of the experiment";
static RUN: Column = Column::whole("run", "", "its number, from 0: cell by cell, in each cell seed by seed");

/// The run and its id, the swept keys, the seed, what the run gave, and the hash of its results.
fn columns_of_results(swept: Vec<Column>, outcomes: Vec<Column>) -> Vec<Column> {
    let id = Column::text("id", "the hash of the run's experiment and seed");
    let seed = Column::whole("seed", "", "the run's seed");
    let result = "the hash of the run's results, as `DONE` has it in a directory of this run";
    [
        vec![RUN.clone(), id],
        swept,
        vec![seed],
        outcomes,
        vec![Column::text("result", result)],
    ]
    .concat()
}

/// The run, and the columns of its own table.
fn columns_of_generations(own: &[Column]) -> Vec<Column> {
    [std::slice::from_ref(&RUN), own].concat()
}

/// The run, and the genes of all cells' controllers by their names. Nothing of runs without champions.
fn columns_of_champions(controllers: &[Option<Controller>]) -> Vec<Column> {
    let mut kinds: Vec<Controller> = Vec::new();
    for &controller in controllers.iter().flatten() {
        if !kinds.contains(&controller) {
            kinds.push(controller);
        }
    }
    let mut columns = Vec::new();
    for name in kinds.into_iter().flat_map(Controller::gene_names) {
        let gene = GENE.clone().named(name);
        if !columns.contains(&gene) {
            columns.push(gene);
        }
    }
    if !columns.is_empty() {
        columns.insert(0, RUN.clone());
    }
    columns
}

static GENE: Column = Column::number(
    "",
    "",
    "a gene of the run's champion; empty where its controller has no such gene",
);

/// The files of a sweep's directory but its tables.
fn other_contents() -> Vec<Contents> {
    vec![
        Contents::file("sweep.toml", "the sweep's file"),
        Contents::file("experiment/", "the experiment's file, and the files that it names"),
        Contents::file(
            "sweep.json",
            "which program and which kernels made the directory, and of how many runs it is",
        ),
        Contents::file("lock", "held by the process that makes the directory"),
        Contents::file("shard-I-of-N/", "what one process does, by itself 1 of 1"),
        Contents::file(
            "shard-I-of-N/results.log",
            "a line for each finished run, with its row of the tables",
        ),
        Contents::file("shard-I-of-N/generations.log", "the finished runs' rows of generations"),
        Contents::file(
            "shard-I-of-N/checkpoint-N",
            "the two newest checkpoints of runs under way",
        ),
        Contents::file(
            "shard-I-of-N/sessions.json",
            "nothing of the results: programs, devices and times",
        ),
        Contents::file("shard-I-of-N/lock", "held by the process that works on the shard"),
    ]
}

/// The files of a sweep's directory: its tables with their columns, once for each format, and all others.
fn contents(tables: [Vec<Column>; 3], factors: &[Column], also_parquet: bool) -> Vec<Contents> {
    let [results, generations, champions] = tables;
    let mut all = vec![
        Contents::table(RESULTS, "when all runs are done: a row for each run", &results),
        Contents::table(
            GENERATIONS,
            "a row for each run and generation; of swarms for each run, interval and robot",
            &generations,
        ),
    ];
    if !champions.is_empty() {
        all.push(Contents::table(
            CHAMPIONS,
            "the genes of each run's champion",
            &champions,
        ));
    }
    if also_parquet {
        let names = [RESULTS, GENERATIONS, CHAMPIONS];
        let parquet = |name: &str| {
            let about = format!("`{name}` again, for quicker reading, by programs built with `--features parquet`");
            Contents::file(name.replace("csv", "parquet"), about)
        };
        all.extend(
            names[..if champions.is_empty() { 2 } else { 3 }]
                .iter()
                .map(|name| parquet(name)),
        );
    }
    all.extend(super::report::contents(factors));
    all.push(Contents::file(
        "runs/",
        "after `oneiro sweep extract`: directories of runs",
    ));
    all.extend(other_contents());
    all
}

/// Writes the description of a sweep's directory there.
///
/// # Errors
/// Exit 6 when writing fails.
pub(super) fn describe(directory: &Path, sweep: &Sweep, plan: &Plan) -> Result {
    let tables = [
        sweep.columns(plan),
        columns_of_generations(plan.columns),
        columns_of_champions(&plan.controllers),
    ];
    let factors = sweep.file().axes.iter().flat_map(Axis::factors);
    let factors: Vec<Column> = factors
        .map(|factor| Column::text("", SWEPT).named(factor.clone()))
        .collect();
    let contents = contents(tables, &factors, cfg!(feature = "parquet"));
    crate::contents::describe(directory, &format!("{}: a sweep of oneiro", sweep.name()), &contents)
}

/// The files of the directory of any sweep, whose runs give this and have these steps and controllers.
#[cfg(test)]
pub(crate) fn all_contents(outcomes: Vec<Column>, steps: &[Column], champions: bool) -> Vec<Contents> {
    let key = Column::text("KEY", "a column for each swept key: its value");
    let gene = Column::number(
        "GENE",
        "",
        "a column for each gene, by its name; empty where a run's controller has no such gene",
    );
    let champions = if champions { vec![RUN.clone(), gene] } else { Vec::new() };
    let tables = [
        columns_of_results(vec![key.clone()], outcomes),
        columns_of_generations(steps),
        champions,
    ];
    contents(tables, &[key], true)
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

/// The genes of each run's champion. Those that its controller does not have are empty.
fn champions_table(columns: &[Column], sweep: &Sweep, plan: &Plan, finished: &AllFinished) -> String {
    let mut table = Csv::new(columns);
    for (&run, Finished { line, .. }) in &finished.runs {
        let names = plan.controllers[sweep.cell_of(run)].map_or_else(Vec::new, Controller::gene_names);
        let genes: BTreeMap<&str, &f32> = names.iter().map(String::as_str).zip(&line.champion).collect();
        let gene = |gene: &Column| genes.get(&*gene.name).map(ToString::to_string).unwrap_or_default();
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
