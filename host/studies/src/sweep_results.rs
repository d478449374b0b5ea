//! Reads the tables of finished sweeps that the second editions of the studies judge, and writes theirs.

use std::fmt::Display;
use std::path::{Path, PathBuf};

use csv::{Reader, StringRecord};
use oneiro_base::contents::{Entry, describe};
use oneiro_base::disk;
use oneiro_base::exit::{Failure, Result};
use oneiro_base::plain;
use oneiro_lab::sweep::tables;
use serde_json::{Number, Value};

use crate::{Findings, Row};

/// A run's row in a sweep's table of results.
pub(super) struct ResultRow<'a> {
    path: &'a Path,
    /// Directory of the sweeps whose tables are allowed, for messages.
    allowed: &'a str,
    head: &'a StringRecord,
    row: StringRecord,
    line: usize,
}

impl ResultRow<'_> {
    /// A cell, if the table has its column.
    pub(super) fn find(&self, column: &str) -> Option<&str> {
        let place = self.head.iter().position(|header| header == column)?;
        Some(&self.row[place])
    }

    /// A cell of a column that the table must have.
    pub(super) fn cell(&self, column: &str) -> Result<&str> {
        self.find(column)
            .ok_or_else(|| missing_column(self.path, column, self.allowed))
    }

    /// A number that `is_allowed` accepts; `words` describe such numbers.
    pub(super) fn number(&self, column: &str, is_allowed: fn(&f64) -> bool, words: &str) -> Result<f64> {
        let cell = self.cell(column)?;
        let known = cell.parse().ok().filter(is_allowed);
        known.ok_or_else(|| self.bad(format_args!("{column} is {cell:?}; allowed: {words}")))
    }

    /// The run's seed.
    pub(super) fn seed(&self) -> Result<u64> {
        let seed = self.cell("seed")?.parse();
        seed.map_err(|_| self.bad("has no seed; allowed: a whole number"))
    }

    /// Refuses the row.
    pub(super) fn bad(&self, problem: impl Display) -> Failure {
        bad(self.path, self.line, problem)
    }
}

/// Refuses a line of a table.
pub(super) fn bad(path: &Path, line: usize, problem: impl Display) -> Failure {
    Failure::input(format_args!("{}:{line}: {problem}", path.display()))
}

fn missing_column(path: &Path, column: &str, allowed: &str) -> Failure {
    let problem = format_args!("has no column {column}; allowed: the table of a sweep of {allowed}");
    bad(path, 1, problem)
}

/// Calls `take` for each row of a sweep's table, which must have the given columns.
pub(super) fn each_row(
    (path, text): (&Path, &str),
    allowed: &str,
    columns: &[&str],
    mut take: impl FnMut(&ResultRow<'_>) -> Result,
) -> Result {
    let mut table = Reader::from_reader(text.as_bytes());
    let head = &table.headers().map_err(|error| bad(path, 1, error))?.clone();
    if let Some(column) = columns
        .iter()
        .find(|column| head.iter().all(|header| header != **column))
    {
        return Err(missing_column(path, column, allowed));
    }
    for (row, line) in table.records().zip(2..) {
        let row = row.map_err(|error| bad(path, line, error))?;
        take(&ResultRow {
            path,
            allowed,
            head,
            row,
            line,
        })?;
    }
    Ok(())
}

/// Calls `parse` with the path and text of each finished sweep's table of results.
pub(super) fn each_table(sweeps: &[PathBuf], mut parse: impl FnMut(&Path, &str) -> Result) -> Result {
    sweeps.iter().try_for_each(|directory| {
        let path = tables::table(directory, "results.csv")?;
        parse(&path, &disk::read_text(&path)?)
    })
}

/// A row of a table by its columns.
pub(super) fn row<'a>(columns: impl IntoIterator<Item = &'a str>, cells: impl IntoIterator<Item = &'a str>) -> Row {
    let value = |cell: &str| {
        let number = cell.parse().ok().and_then(Number::from_f64);
        number.map_or_else(|| cell.into(), Value::Number)
    };
    let cells = columns.into_iter().zip(cells);
    cells.map(|(column, cell)| (column.to_owned(), value(cell))).collect()
}

/// Tables by the names of their files, which the program wrote.
pub(super) fn findings(files: &[(&str, String)]) -> Findings {
    let rows = |text: &str| {
        let mut table = Reader::from_reader(text.as_bytes());
        let head = table.headers().expect("the table has a first line").clone();
        let rows = table.records().map(|cells| cells.expect("rows have all columns"));
        rows.map(|cells| row(&head, &cells)).collect()
    };
    let name = |file: &str| file.trim_end_matches(".csv").to_owned();
    Findings::Tables(files.iter().map(|(file, text)| (name(file), rows(text))).collect())
}

/// Writes tables to a directory, and describes them there.
pub(super) fn write(out: &Path, what: &str, files: &[(&str, String)], contents: &[Entry]) -> Result {
    plain::make_directory(out).map_err(|error| Failure::storage(out, &error))?;
    for (name, text) in files {
        disk::write(&out.join(name), text.as_bytes())?;
    }
    describe(out, what, contents)
}
