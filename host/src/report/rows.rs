//! Numbers as lines of a CSV file.

use std::fmt::Display;

use crate::report::numbers::significant;

/// Significant digits of a number.
const DIGITS: usize = 6;

/// A line a row; all fields are numbers or names without commas and quotes.
pub(crate) struct Rows(pub(crate) String);

impl Rows {
    /// Nothing yet but the names of the columns.
    pub(crate) fn new(head: &str) -> Self {
        Self(format!("{head}\n"))
    }

    /// One more.
    pub(crate) fn row(&mut self, fields: impl IntoIterator<Item = impl Display>) {
        use std::fmt::Write;
        for (i, field) in fields.into_iter().enumerate() {
            let comma = if i > 0 { "," } else { "" };
            // Writing to a string can't fail.
            let _ = write!(self.0, "{comma}{field}");
        }
        self.0.push('\n');
    }
}

/// A number as it stands in a field.
pub(crate) fn number(x: f64) -> String {
    significant(x, DIGITS)
}
