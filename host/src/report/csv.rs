//! CSV files.

use ::csv::{QuoteStyle, Writer, WriterBuilder};

use super::numbers::significant;
use crate::contents::Column;

/// Significant digits of a number.
const DIGITS: usize = 6;

/// A CSV file in the making.
pub(crate) struct Csv(Writer<Vec<u8>>);

impl Csv {
    /// A file that has the names of its columns and no rows yet.
    pub(crate) fn new<'a>(columns: impl IntoIterator<Item = &'a Column>) -> Self {
        Self::with(QuoteStyle::Necessary, columns)
    }

    /// Starts a file for rows whose fields are already quoted where necessary.
    pub(crate) fn quoted_already<'a>(columns: impl IntoIterator<Item = &'a Column>) -> Self {
        Self::with(QuoteStyle::Never, columns)
    }

    fn with<'a>(quotes: QuoteStyle, columns: impl IntoIterator<Item = &'a Column>) -> Self {
        let mut csv = Self(WriterBuilder::new().quote_style(quotes).from_writer(Vec::new()));
        csv.row(columns.into_iter().map(|column| column.name.as_bytes()));
        csv
    }

    /// Adds a row with as many fields as there are columns.
    pub(crate) fn row(&mut self, fields: impl IntoIterator<Item = impl AsRef<[u8]>>) {
        let written = self.0.write_record(fields);
        written.expect("memory takes rows that have a field for each column");
    }

    /// The file's text.
    pub(crate) fn text(self) -> String {
        let bytes = self.0.into_inner().expect("memory takes what is left in the buffer");
        String::from_utf8(bytes).expect("all fields are text")
    }
}

/// Formats a number as a field.
pub(crate) fn number(x: f64) -> String {
    significant(x, DIGITS)
}

/// Formats a number as a field, empty if the number isn't finite.
pub(crate) fn known(x: f64) -> String {
    if x.is_finite() { number(x) } else { String::new() }
}
