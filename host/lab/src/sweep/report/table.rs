//! Reader of recorded tables, row by row.

use std::fmt::Display;
use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use csv::{ErrorKind, Reader, StringRecord};
use oneiro_base::exit::{Failure, Result};
use oneiro_base::plain;

/// A CSV file whose first line names its columns, and the row read last.
pub(crate) struct Table<'a> {
    path: &'a Path,
    reader: Reader<BufReader<File>>,
    head: StringRecord,
    row: StringRecord,
    /// Whether the last line lacks its end because writing was interrupted.
    is_cut: bool,
}

impl<'a> Table<'a> {
    /// Opens a file and reads the names of its columns.
    ///
    /// # Errors
    /// Exit 3 if it doesn't exist, exit 5 if it has no first line, exit 6 if reading fails.
    pub(crate) fn open(path: &'a Path) -> Result<Self> {
        let (file, is_cut) = open(path).map_err(|error| Failure::unreadable(path, &error))?;
        let mut reader = Reader::from_reader(BufReader::with_capacity(1 << 16, file));
        let head = reader.headers().cloned().map_err(|error| failure(path, error))?;
        let table = Self {
            path,
            reader,
            head,
            row: StringRecord::new(),
            is_cut,
        };
        if table.head.is_empty() {
            return Err(table.corrupt_at(1, "is empty; a table begins with the names of its columns"));
        }
        Ok(table)
    }

    /// Index of a column.
    ///
    /// # Errors
    /// Exit 5 if there is no column with that name.
    pub(crate) fn column(&self, name: &str) -> Result<usize> {
        let place = self.head.iter().position(|column| column == name);
        place.ok_or_else(|| self.corrupt_at(1, format_args!("has no column \u{201c}{name}\u{201d}")))
    }

    /// Indices of several columns.
    ///
    /// # Errors
    /// Exit 5 if a name has no column.
    pub(crate) fn columns(&self, names: &[String]) -> Result<Vec<usize>> {
        names.iter().map(|name| self.column(name)).collect()
    }

    /// Reads the next row; false at the end.
    ///
    /// # Errors
    /// Exit 5 if it has too few or too many cells, isn't text, or is cut short; exit 6 if reading fails.
    pub(crate) fn advance(&mut self) -> Result<bool> {
        let last = self.line();
        let has_row = self.reader.read_record(&mut self.row);
        match has_row.map_err(|error| failure(self.path, error))? {
            true => Ok(true),
            false if self.is_cut => Err(self.corrupt_at(last, "is cut short: it does not end")),
            false => Ok(false),
        }
    }

    /// A cell of this row.
    pub(crate) fn cell(&self, column: usize) -> &str {
        // A row has as many cells as the first line, which column indices come from.
        self.row.get(column).unwrap_or_default()
    }

    /// A cell with a whole number.
    ///
    /// # Errors
    /// Exit 5 if it is anything else.
    pub(crate) fn whole(&self, column: usize) -> Result<u64> {
        let cell = self.cell(column);
        cell.parse().map_err(|_| self.not_a(column, "whole number"))
    }

    /// A cell with a number: NaN if it is empty or not finite.
    ///
    /// # Errors
    /// Exit 5 if it is anything else.
    pub(crate) fn number(&self, column: usize) -> Result<f64> {
        let cell = self.cell(column);
        if cell.is_empty() {
            return Ok(f64::NAN);
        }
        let number: f64 = cell.parse().map_err(|_| self.not_a(column, "number"))?;
        Ok(if number.is_finite() { number } else { f64::NAN })
    }

    /// A cell with a gene.
    ///
    /// # Errors
    /// Exit 5 if it is anything else.
    pub(crate) fn gene(&self, column: usize) -> Result<f32> {
        // By way of f64 it would be rounded twice.
        let gene: Option<f32> = self.cell(column).parse().ok();
        gene.filter(|gene| gene.is_finite())
            .ok_or_else(|| self.not_a(column, "gene"))
    }

    /// Exit 5 with a problem of this row.
    pub(crate) fn corrupt(&self, problem: impl Display) -> Failure {
        self.corrupt_at(self.line(), problem)
    }

    fn not_a(&self, column: usize, what: &str) -> Failure {
        let (name, cell) = (self.head.get(column).unwrap_or_default(), self.cell(column));
        self.corrupt(format_args!("{name}: \u{201c}{cell}\u{201d} is no {what}"))
    }

    fn line(&self) -> u64 {
        self.row.position().map_or(1, csv::Position::line)
    }

    fn corrupt_at(&self, line: u64, problem: impl Display) -> Failure {
        corrupt(self.path, Some(line), problem)
    }
}

/// Opens the file, and finds whether its last line lacks its end.
fn open(path: &Path) -> io::Result<(File, bool)> {
    let mut file = plain::open_table(path)?;
    let mut last = [b'\n'];
    if file.seek(SeekFrom::End(0))? > 0 {
        file.seek(SeekFrom::End(-1))?;
        file.read_exact(&mut last)?;
    }
    file.rewind()?;
    Ok((file, last != *b"\n"))
}

fn corrupt(path: &Path, line: Option<u64>, problem: impl Display) -> Failure {
    match line {
        Some(line) => Failure::corrupt(format_args!("{}: line {line}: {problem}", path.display())),
        None => Failure::corrupt(format_args!("{}: {problem}", path.display())),
    }
}

/// Converts an error of the CSV reader.
fn failure(path: &Path, error: csv::Error) -> Failure {
    let line = error.position().map(csv::Position::line);
    match error.into_kind() {
        ErrorKind::Io(error) => Failure::storage(path, &error),
        ErrorKind::UnequalLengths { expected_len, len, .. } => corrupt(
            path,
            line,
            format_args!("has {len} cells; the table has {expected_len} columns"),
        ),
        ErrorKind::Utf8 { .. } => corrupt(path, line, "is not UTF-8 text"),
        kind => corrupt(path, line, format_args!("{kind:?}")),
    }
}
