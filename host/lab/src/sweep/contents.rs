//! Contents of a sweep's directory: its files, and the columns of its tables.

use std::path::Path;

use oneiro::world::GeneLayout;
use oneiro_base::contents::{self, Column, Entry, Holds};
use oneiro_base::exit::Result;
use toml::Value;

use super::file::Axis;
use super::{Plan, Sweep};

/// File names of the tables.
pub const RESULTS: &str = "results.csv";
pub const GENERATIONS: &str = "generations.csv";
pub const CHAMPIONS: &str = "champions.csv";
/// The tables' hashes.
pub const SUMS: &str = "tables.json";

impl Sweep {
    /// The columns of the table of results.
    pub fn columns(&self, plan: &Plan) -> Vec<Column> {
        let swept = self.file().axes.iter().flat_map(|axis| {
            axis.keys.iter().enumerate().map(|(index, key)| {
                let values = axis.levels.iter().filter_map(|level| Some(&level[index].as_ref()?.0));
                Column::new("", "", SWEPT, holds(values)).named(key.clone())
            })
        });
        columns_of_results(swept.collect(), plan.outcomes.clone())
    }
}

/// Description of a swept key's column.
const SWEPT: &str = "the value of this key of the experiment; empty if the run's row of the list lacks it";
pub(super) static RUN: Column = Column::whole(
    "run",
    "",
    "its number, from 0: cell by cell, and seed by seed within a cell",
);

/// The run and its id, the swept keys, the seed, the run's values, and the hash of its results.
fn columns_of_results(swept: Vec<Column>, outcomes: Vec<Column>) -> Vec<Column> {
    let id = Column::text("id", "the hash of the run's experiment and seed");
    let seed = Column::whole("seed", "", "the run's seed");
    let result = "the hash of the run's results, the same as in `DONE` of a directory of this run";
    [
        vec![RUN.clone(), id],
        swept,
        vec![seed],
        outcomes,
        vec![Column::text("result", result)],
    ]
    .concat()
}

/// The run, and the columns of its kind's table.
pub(super) fn columns_of_generations(own: &[Column]) -> Vec<Column> {
    [std::slice::from_ref(&RUN), own].concat()
}

/// The run, and the genes of all cells' controllers by name. Empty for runs without champions.
pub(super) fn columns_of_champions(layouts: &[Option<GeneLayout>]) -> Vec<Column> {
    let mut kinds: Vec<&GeneLayout> = Vec::new();
    for layout in layouts.iter().flatten() {
        if !kinds.contains(&layout) {
            kinds.push(layout);
        }
    }
    let mut columns = Vec::new();
    for name in kinds.into_iter().flat_map(GeneLayout::names) {
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
    "a gene of the run's champion; empty if its controller has no such gene",
);

/// The files of a sweep's directory except its tables.
fn other_entries() -> Vec<Entry> {
    vec![
        Entry::file("sweep.toml", "the sweep's file"),
        Entry::file("experiment/", "the experiment's file, and the files that it names"),
        Entry::file(
            "sweep.json",
            "the program version and kernels that made the directory, and the number of runs",
        ),
        Entry::file("lock", "locked while a process prepares the directory"),
        Entry::file(
            "shard-I-of-N/",
            "the work of one process; 1-of-1 if the sweep isn't split",
        ),
        Entry::file(
            "shard-I-of-N/results.log",
            "one line per finished run, with its row of the tables",
        ),
        Entry::file(
            "shard-I-of-N/generations.log",
            "rows of `generations.csv` for finished runs",
        ),
        Entry::file(
            "shard-I-of-N/checkpoint-N",
            "the two newest checkpoints of runs in progress",
        ),
        Entry::file(
            "shard-I-of-N/sessions.json",
            "provenance, not part of the results: programs, devices and times",
        ),
        Entry::file(
            "shard-I-of-N/lock",
            "locked by the process that is working on the shard",
        ),
    ]
}

/// The files of a sweep's directory: its tables with their columns, once for each format, and all others.
fn entries(tables: [Vec<Column>; 3], factors: &[Column], also_parquet: bool, names_files: bool) -> Vec<Entry> {
    let [results, generations, champions] = tables;
    let mut all = vec![
        Entry::table(RESULTS, "one row per run; written when all runs are finished", &results),
        Entry::table(
            GENERATIONS,
            "one row per run and generation; for swarms, per run, interval and robot",
            &generations,
        ),
    ];
    if !champions.is_empty() {
        all.push(Entry::table(CHAMPIONS, "the genes of each run's champion", &champions));
    }
    if also_parquet {
        let names = [RESULTS, GENERATIONS, CHAMPIONS];
        let parquet = |name: &str| {
            let about =
                format!("`{name}` as Parquet, for faster reading; only from a program built with `--features parquet`");
            Entry::file(name.replace("csv", "parquet"), about)
        };
        all.extend(
            names[..if champions.is_empty() { 2 } else { 3 }]
                .iter()
                .map(|name| parquet(name)),
        );
    }
    all.push(Entry::file(
        SUMS,
        "the BLAKE3 hashes of the tables, written with them; `oneiro verify` compares them",
    ));
    all.extend(super::report::contents(factors));
    all.push(Entry::file(
        "runs/",
        "written by `oneiro sweep extract`: run directories",
    ));
    if names_files {
        all.push(Entry::file("sweep/", "the files that the sweep's file names"));
    }
    all.extend(other_entries());
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
        columns_of_champions(&plan.layouts),
    ];
    let factors = sweep.file().axes.iter().flat_map(Axis::factors);
    let factors: Vec<Column> = factors
        .map(|factor| Column::text("", SWEPT).named(factor.clone()))
        .collect();
    let names_files = sweep.files(true).iter().any(|(name, _)| Path::new(name).is_relative());
    let entries = entries(tables, &factors, cfg!(feature = "parquet"), names_files);
    contents::describe(directory, &format!("{}: a sweep of oneiro", sweep.name()), &entries)
}

/// The files of any sweep's directory, given its runs' values, steps and controllers.
#[cfg(any(test, feature = "testing"))]
pub fn all_entries(outcomes: Vec<Column>, steps: &[Column], champions: bool) -> Vec<Entry> {
    let key = Column::text("KEY", "the value of a swept key, one column per key");
    let gene = Column::number(
        "GENE",
        "",
        "a gene of the run's champion, one column per gene; empty if its controller has no such gene",
    );
    let champions = if champions { vec![RUN.clone(), gene] } else { Vec::new() };
    let tables = [
        columns_of_results(vec![key.clone()], outcomes),
        columns_of_generations(steps),
        champions,
    ];
    entries(tables, &[key], true, true)
}

fn holds<'a>(values: impl Iterator<Item = &'a Value>) -> Holds {
    values.fold(Holds::Whole, |known, value| match (known, value) {
        (Holds::Whole, Value::Integer(_)) => Holds::Whole,
        (Holds::Whole | Holds::Number, Value::Integer(_) | Value::Float(_)) => Holds::Number,
        _ => Holds::Text,
    })
}
