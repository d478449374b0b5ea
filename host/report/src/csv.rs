//! CSV files.

use std::borrow::Cow;

use ::csv::{QuoteStyle, Writer, WriterBuilder};
use oneiro_base::contents::Column;

use super::numbers::significant;

/// Significant digits of a number.
const DIGITS: usize = 6;

/// A CSV file in the making.
pub struct Csv(Writer<Vec<u8>>);

impl Csv {
    /// A file that has the names of its columns and no rows yet.
    pub fn new<'a>(columns: impl IntoIterator<Item = &'a Column>) -> Self {
        Self::with(QuoteStyle::Necessary, columns)
    }

    /// Starts a file for rows whose fields are already quoted where necessary.
    pub fn quoted_already<'a>(columns: impl IntoIterator<Item = &'a Column>) -> Self {
        Self::with(QuoteStyle::Never, columns)
    }

    fn with<'a>(quotes: QuoteStyle, columns: impl IntoIterator<Item = &'a Column>) -> Self {
        let mut csv = Self(WriterBuilder::new().quote_style(quotes).from_writer(Vec::new()));
        csv.row(columns.into_iter().map(|column| column.name.as_bytes()));
        csv
    }

    /// Adds a row with as many fields as there are columns.
    pub fn row(&mut self, fields: impl IntoIterator<Item = impl AsRef<[u8]>>) {
        for field in fields {
            let written = self.0.write_field(cell(field.as_ref()));
            written.expect("memory takes any field");
        }
        let written = self.0.write_record(None::<&[u8]>);
        written.expect("memory takes rows that have a field for each column");
    }

    /// The file's text.
    pub fn text(self) -> String {
        let bytes = self.0.into_inner().expect("memory takes what is left in the buffer");
        String::from_utf8(bytes).expect("all fields are text")
    }
}

/// A field in a table. Spreadsheets take a text for a formula, which they run, if it begins like one: such a text gets an
/// apostrophe before it, with which they show it unchanged. Numbers stay.
pub fn cell(field: &[u8]) -> Cow<'_, [u8]> {
    let quotes = usize::from(field.first() == Some(&b'"'));
    let text = &field[quotes..];
    let begins_formula = text.len() > 1 && b"=+-@\t\r".contains(&text[0]);
    let is_number = || str::from_utf8(text).is_ok_and(|text| text.parse::<f64>().is_ok());
    if begins_formula && !is_number() {
        Cow::Owned([&field[..quotes], b"'", text].concat())
    } else {
        Cow::Borrowed(field)
    }
}

/// Formats a number as a field.
pub fn number(x: f64) -> String {
    significant(x, DIGITS)
}

/// Formats a number as a field, empty if the number isn't finite.
pub fn known(x: f64) -> String {
    if x.is_finite() { number(x) } else { String::new() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_cell_is_a_formula() {
        let columns = [Column::text("a", ""), Column::text("b", "")];
        let mut csv = Csv::new(&columns);
        csv.row(["=cmd|x!A0.wgsl", "-0.5"]);
        csv.row(["@SUM(1,2)", "+1e-3"]);
        csv.row(["\tx", "-x"]);
        csv.row(["a=b", "-"]);
        csv.row(["-inf", ""]);
        assert_eq!(
            csv.text(),
            "a,b\n'=cmd|x!A0.wgsl,-0.5\n\"'@SUM(1,2)\",+1e-3\n'\tx,'-x\na=b,-\n-inf,\n"
        );
        assert_eq!(&*cell(b"\"=1,2\""), b"\"'=1,2\"");
    }
}
