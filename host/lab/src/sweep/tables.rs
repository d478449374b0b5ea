//! Tables of a sweep: one row per run, in long form one row per generation of each run, and the champions' genes.
//! Whichever processes did the runs, in whatever order, the files have the same bytes.

use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use oneiro::world::GeneLayout;
use oneiro_base::console::counted;
use oneiro_base::contents::Column;
use oneiro_base::disk;
use oneiro_base::exit::{Failure, Result};
use oneiro_base::plain;
use oneiro_report::csv::cell;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use toml::Value;

use super::contents::{CHAMPIONS, GENERATIONS, RESULTS, RUN, SUMS, columns_of_champions, columns_of_generations};
use super::journal::Generations;
use super::store::{AllFinished, Finished, Store};
use super::{Plan, RunIndex, Sweep};

/// Tables written by [`write()`].
#[derive(Debug)]
pub struct Written {
    pub runs: usize,
    /// BLAKE3 hash of the tables of results and of generations, one after the other.
    pub hash: String,
    pub files: Vec<PathBuf>,
}

impl Sweep {
    /// A cell's values as written in the table of results; empty for keys that only other rows of a list have.
    pub fn levels(&self, cell: usize) -> Vec<String> {
        self.file()
            .values(cell)
            .into_iter()
            .map(|value| value.map_or_else(String::new, |(value, _)| text(value)))
            .collect()
    }
}

/// A value as written in a table: strings without quotes.
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
pub fn write(directory: &Path, sweep: &Sweep, plan: &Plan, finished: &AllFinished) -> Result<Written> {
    finished.is_all_of(sweep)?;
    let (hash, tables) = write_finished(directory, sweep, plan, finished)?;
    let converted = tables
        .par_iter()
        .map(|(table, columns)| also_as_parquet(table, columns));
    let converted: Vec<Result<_>> = converted.collect();
    let mut files: Vec<PathBuf> = tables.into_iter().map(|(table, _)| table).collect();
    for parquet in converted {
        files.extend(parquet?);
    }
    let named_hash = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        Ok((name.into_owned(), hash_of(path)?))
    };
    let sums = Sums {
        hash: hash.clone(),
        files: files.par_iter().map(named_hash).collect::<Result<_>>()?,
    };
    disk::write(&directory.join(SUMS), &disk::json(&sums))?;
    disk::sync_directory(directory)?;
    Ok(Written {
        runs: finished.runs.len(),
        hash,
        files,
    })
}

/// Tables with their columns.
type Tables = Vec<(PathBuf, Vec<Column>)>;

/// Writes the tables of the finished runs. Returns the hash of the first two, and all with their columns.
fn write_finished(directory: &Path, sweep: &Sweep, plan: &Plan, finished: &AllFinished) -> Result<(String, Tables)> {
    let [results, generations, champions] = [RESULTS, GENERATIONS, CHAMPIONS].map(|name| directory.join(name));
    let genes = columns_of_champions(&plan.layouts);
    // Where runs are short, their tables are a third of the work.
    let (hash, written) = rayon::join(
        || -> Result<String> {
            let mut hasher = blake3::Hasher::new();
            disk::write_through(&results, |file| {
                let mut table = Table::new(&results, file, &mut hasher);
                write_results(&mut table, sweep, plan, finished)?;
                table.finish()
            })?;
            disk::write_through(&generations, |file| {
                let mut table = Table::new(&generations, file, &mut hasher);
                write_generations(&mut table, plan, finished)?;
                table.finish()
            })?;
            Ok(hasher.finalize().to_hex().to_string())
        },
        || match &genes[..] {
            [] => Ok(()),
            genes => disk::write_through(&champions, |file| {
                let written = write_champions(file, genes, sweep, plan, finished);
                written.map_err(|error| Failure::storage(&champions, &error.into()))
            }),
        },
    );
    let hash = hash?;
    written?;
    let mut tables = vec![
        (results, sweep.columns(plan)),
        (generations, columns_of_generations(plan.columns)),
    ];
    if !genes.is_empty() {
        tables.push((champions, genes));
    }
    Ok((hash, tables))
}

/// The tables of a sweep that may be unfinished.
#[derive(Debug)]
pub struct Readable {
    /// The folder that has them.
    folder: PathBuf,
    /// Whether they are of this reading alone, and removed after it.
    is_temporary: bool,
    /// Planned runs that aren't in them, in ascending order.
    pub missing: Vec<RunIndex>,
    /// Warnings about damaged records.
    pub problems: Vec<String>,
}

impl Readable {
    /// The tables of a sweep's directory; as long as there are none, those of the runs that its shards have finished, which are written
    /// into a temporary folder in `beside`.
    ///
    /// # Errors
    /// Exit 3 if no run is finished; exit 5 if a table was changed or a record is damaged; exit 6 if reading or writing fails.
    pub fn of(store: &Store, sweep: &Sweep, plan: &Plan, beside: &Path) -> Result<Self> {
        let directory = store.directory();
        if directory.join(RESULTS).exists() && directory.join(GENERATIONS).exists() {
            if directory.join(SUMS).exists() {
                // Nothing is computed from a table that was changed.
                verify(directory)?;
            }
            return Ok(Self {
                folder: directory.to_owned(),
                is_temporary: false,
                missing: Vec::new(),
                problems: Vec::new(),
            });
        }
        let mut finished = AllFinished::default();
        store.finished(Some(&plan.ids), &mut finished)?;
        if finished.runs.is_empty() {
            // Says what to do.
            table(directory, RESULTS)?;
        }
        let folder = beside.join(format!(".partial-{}", std::process::id()));
        plain::make_new_directory(&folder).map_err(|error| Failure::storage(&folder, &error))?;
        let own = Self {
            folder,
            is_temporary: true,
            missing: finished.missing(sweep).collect(),
            problems: std::mem::take(&mut finished.problems),
        };
        write_finished(&own.folder, sweep, plan, &finished)?;
        Ok(own)
    }

    /// The path of a table.
    pub fn table(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }
}

impl Drop for Readable {
    fn drop(&mut self) {
        if self.is_temporary {
            // What is left over does no harm.
            let _ = std::fs::remove_dir_all(&self.folder);
        }
    }
}

/// State of the tables when they were written. All hashes are BLAKE3.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sums {
    /// Of the tables of results and of generations, one after the other, which `oneiro sweep merge` prints.
    pub hash: String,
    /// Of each table's file.
    pub files: BTreeMap<String, String>,
}

/// Hash of a table's file, which may be too large for the memory.
fn hash_of(path: &Path) -> Result<String> {
    let hash = plain::hash(path).map_err(|error| Failure::storage(path, &error))?;
    Ok(hash.to_hex().to_string())
}

/// Hash of the tables of results and of generations, one after the other.
fn hash_of_both(directory: &Path) -> Result<String> {
    let mut hasher = blake3::Hasher::new();
    for name in [RESULTS, GENERATIONS] {
        let path = directory.join(name);
        let hashed = plain::open_table(&path).and_then(|table| hasher.update_reader(table).map(|_| ()));
        hashed.map_err(|error| Failure::storage(&path, &error))?;
    }
    Ok(hasher.finalize().to_hex().to_string())
}

/// Checks that a sweep's tables are what was written. Returns their hashes.
///
/// # Errors
/// Exit 1 if there are none yet, or if they have no hashes; exit 5 with each table that is another now, or missing.
pub fn verify(directory: &Path) -> Result<Sums> {
    let path = directory.join(SUMS);
    let Some(sums) = disk::json_if_there::<Sums>(&path)? else {
        let directory = directory.display();
        return Err(Failure::failed(format_args!(
            "{directory}: has no {SUMS} with the hashes of its tables; `oneiro sweep merge {directory}` writes both once all \
             runs are done"
        )));
    };
    let mut problems = Vec::new();
    for name in [RESULTS, GENERATIONS] {
        if !sums.files.contains_key(name) {
            problems.push(format!("{name} is not listed in {SUMS}"));
        }
    }
    for (name, hash) in &sums.files {
        let table = directory.join(name);
        // A name must be that of a file in the directory.
        if Path::new(name).file_name() != Some(name.as_ref()) || !table.exists() {
            problems.push(format!("{name} is missing"));
        } else if hash_of(&table)? != *hash {
            problems.push(format!("{name} is not what was written"));
        }
    }
    if problems.is_empty() && hash_of_both(directory)? != sums.hash {
        problems.push(format!("the hash in {SUMS} is another"));
    }
    if problems.is_empty() {
        return Ok(sums);
    }
    let (directory, problems) = (directory.display(), problems.join("; "));
    Err(Failure::corrupt(format_args!(
        "{directory}: {problems}; `oneiro sweep merge`, with the directories of all shards, writes the tables again"
    )))
}

/// The path of a table of a sweep's directory.
///
/// # Errors
/// Exit 3 if there is none yet, with how many runs are done and what to do.
pub fn table(directory: &Path, name: &str) -> Result<PathBuf> {
    let path = directory.join(name);
    if path.exists() {
        return Ok(path);
    }
    let store = Store::open(directory)?;
    let mut finished = AllFinished::default();
    store.finished(None, &mut finished)?;
    let (done, all, directory) = (finished.runs.len(), store.what().runs, directory.display());
    let instead = if done < all {
        "repeat the `oneiro sweep run` that began it for the rest".to_owned()
    } else {
        format!("`oneiro sweep merge {directory}` writes it")
    };
    Err(Failure::input(format_args!(
        "{directory}: has no {name} yet: {done} of {all} runs are done here; {instead}. `oneiro sweep merge {directory} OTHERS` \
         joins shards in other directories"
    )))
}

/// The runs that are in a directory's table of results; none if there is no table.
///
/// # Errors
/// Exit 6 if reading fails.
pub fn runs_in(directory: &Path, runs: usize) -> Result<BTreeSet<RunIndex>> {
    let path = directory.join(RESULTS);
    if !path.exists() {
        return Ok(BTreeSet::new());
    }
    let mut table =
        csv::Reader::from_reader(plain::open_table(&path).map_err(|error| Failure::storage(&path, &error))?);
    let head = table
        .headers()
        .map_err(|error| Failure::storage(&path, &error.into()))?;
    let Some(column) = head.iter().position(|name| name == RUN.name) else {
        return Ok(BTreeSet::new());
    };
    let rows = table.records().map_while(csv::Result::ok);
    let runs_of_rows = rows.filter_map(|row| row.get(column)?.parse::<RunIndex>().ok());
    Ok(runs_of_rows.filter(|run| (*run as usize) < runs).collect())
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
    let path = table.path;
    let mut rows = csv::Writer::from_writer(&mut table.rows);
    let mut write = || -> csv::Result<()> {
        rows.write_record(sweep.columns(plan).iter().map(|column| column.name.as_bytes()))?;
        let (mut of, mut levels) = (0, sweep.levels(0));
        for (&run, Finished { line, .. }) in &finished.runs {
            if sweep.cell_of(run) != of {
                of = sweep.cell_of(run);
                levels = sweep.levels(of);
            }
            rows.write_field(run.to_string())?;
            rows.write_field(&line.id)?;
            levels
                .iter()
                .try_for_each(|level| rows.write_field(cell(level.as_bytes())))?;
            rows.write_field(sweep.seed_of(run).to_string())?;
            // Outcomes that only runs of other cells have are empty.
            let outcome = |column: &Column| line.outcomes.get(&column.name).map_or("", String::as_str);
            plan.outcomes
                .iter()
                .try_for_each(|column| rows.write_field(cell(outcome(column).as_bytes())))?;
            rows.write_field(&line.result)?;
            rows.write_record(None::<&[u8]>)?;
        }
        Ok(rows.flush()?)
    };
    write().map_err(|error| Failure::storage(path, &error.into()))
}

fn write_generations(table: &mut Table<'_>, plan: &Plan, finished: &AllFinished) -> Result {
    table.push(format!("run,{}", String::from_utf8_lossy(&plan.table.head)).as_bytes())?;
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

/// Writes the genes of each run's champion. Genes that its controller doesn't have are empty.
fn write_champions(
    out: &mut File,
    columns: &[Column],
    sweep: &Sweep,
    plan: &Plan,
    finished: &AllFinished,
) -> csv::Result<()> {
    let genes = &columns[1..];
    let positions = |layout: &GeneLayout| -> Vec<Option<usize>> {
        let names = layout.names();
        let position = |gene: &Column| names.iter().position(|name| *name == gene.name);
        genes.iter().map(position).collect()
    };
    // The positions of the columns' genes in each controller's genome: a sweep has few controllers and many runs.
    let mut known: Vec<(Option<&GeneLayout>, Vec<Option<usize>>)> = vec![(None, vec![None; genes.len()])];
    let mut rows = csv::Writer::from_writer(out);
    rows.write_record(columns.iter().map(|column| column.name.as_bytes()))?;
    for (&run, Finished { line, .. }) in &finished.runs {
        let layout = plan.layouts[sweep.cell_of(run)].as_ref();
        if known.iter().all(|(other, _)| *other != layout) {
            known.push((layout, layout.map_or_else(Vec::new, positions)));
        }
        let own = known.iter().find(|(other, _)| *other == layout);
        let champion: Vec<&str> = line.champion.split(',').collect();
        rows.write_field(run.to_string())?;
        for position in own.into_iter().flat_map(|(_, positions)| positions) {
            let gene = position.and_then(|position| champion.get(position));
            rows.write_field(gene.copied().unwrap_or_default())?;
        }
        rows.write_record(None::<&[u8]>)?;
    }
    Ok(rows.flush()?)
}

/// A table being written. Long pieces are hashed and written faster.
struct Table<'a> {
    path: &'a Path,
    rows: BufWriter<Hashed<'a>>,
}

/// A file that is hashed while it is written.
struct Hashed<'a> {
    file: &'a mut File,
    hasher: &'a mut blake3::Hasher,
}

impl<'a> Table<'a> {
    fn new(path: &'a Path, file: &'a mut File, hasher: &'a mut blake3::Hasher) -> Self {
        const PIECE: usize = 1 << 18;
        let rows = BufWriter::with_capacity(PIECE, Hashed { file, hasher });
        Self { path, rows }
    }

    fn push(&mut self, bytes: &[u8]) -> Result {
        let written = self.rows.write_all(bytes);
        written.map_err(|error| Failure::storage(self.path, &error))
    }

    fn finish(mut self) -> Result {
        self.rows.flush().map_err(|error| Failure::storage(self.path, &error))
    }
}

impl Write for Hashed<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.file.write(bytes)?;
        self.hasher.update(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl AllFinished {
    /// The runs that no shard has finished.
    fn missing(&self, sweep: &Sweep) -> impl Iterator<Item = RunIndex> {
        (0..sweep.runs() as RunIndex).filter(|run| !self.runs.contains_key(run))
    }

    /// Checks that shards have done all runs.
    ///
    /// # Errors
    /// Exit 1 with the missing runs.
    pub fn is_all_of(&self, sweep: &Sweep) -> Result {
        const SHOWN: usize = 10;
        let all = sweep.runs();
        let count = all - self.runs.len();
        if count == 0 {
            return Ok(());
        }
        let shown: Vec<String> = self.missing(sweep).take(SHOWN).map(|run| run.to_string()).collect();
        let more = if count > shown.len() { ", ..." } else { "" };
        let are = if count == 1 { "is" } else { "are" };
        Err(Failure::failed(format_args!(
            "{count} of {} {are} missing: {}{more}; `oneiro sweep run` does them",
            counted(all, "run", "runs"),
            shown.join(", ")
        )))
    }
}
