//! Contents of the directories that the program writes. Each file and each column of a table is described once, next to
//! the code that writes it. The first lines of the tables, the `README.md` in each directory, and `docs/files.md` are
//! made from that.

use std::borrow::Cow;
use std::path::Path;

use crate::disk;
use crate::exit::Result;

/// The file that describes a directory.
pub const README: &str = "README.md";

/// Type of a column's cells. An empty cell is a missing value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Holds {
    /// Integers from -2^63 to 2^63 - 1.
    Whole,
    /// Numbers in f64, including NaN and infinities.
    Number,
    /// Text.
    Text,
}

/// A column of a table.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    pub name: Cow<'static, str>,
    /// Nothing for counts, shares, scores and words.
    pub unit: &'static str,
    pub about: Cow<'static, str>,
    pub holds: Holds,
    /// Whether less of it is better, where runs are ranked by it.
    pub is_less_better: bool,
}

impl Column {
    /// Whole numbers.
    pub const fn whole(name: &'static str, unit: &'static str, about: &'static str) -> Self {
        Self::new(name, unit, about, Holds::Whole)
    }

    /// Numbers.
    pub const fn number(name: &'static str, unit: &'static str, about: &'static str) -> Self {
        Self::new(name, unit, about, Holds::Number)
    }

    /// Words.
    pub const fn text(name: &'static str, about: &'static str) -> Self {
        Self::new(name, "", about, Holds::Text)
    }

    /// Of cells that hold this.
    pub const fn new(name: &'static str, unit: &'static str, about: &'static str, holds: Holds) -> Self {
        Self {
            name: Cow::Borrowed(name),
            unit,
            about: Cow::Borrowed(about),
            holds,
            is_less_better: false,
        }
    }

    /// The same, of which less is better.
    pub const fn less_is_better(mut self) -> Self {
        self.is_less_better = true;
        self
    }

    /// What it holds, in words.
    pub fn words(&self) -> &str {
        &self.about
    }

    /// The same under another name.
    pub fn named(self, name: impl Into<Cow<'static, str>>) -> Self {
        Self {
            name: name.into(),
            ..self
        }
    }

    /// The same with more words.
    pub fn about(self, about: String) -> Self {
        Self {
            about: about.into(),
            ..self
        }
    }
}

/// A column of a sweep's table of results, and the function that gives a finished run's value.
#[derive(Debug)]
pub struct OutcomeColumn<F> {
    pub column: Column,
    pub value: F,
}

impl<F> OutcomeColumn<F> {
    pub const fn new(column: Column, value: F) -> Self {
        Self { column, value }
    }
}

/// The first line of a table.
pub fn head<'a>(columns: impl IntoIterator<Item = &'a Column>) -> String {
    let names: Vec<&str> = columns.into_iter().map(|column| &*column.name).collect();
    names.join(",") + "\n"
}

/// A file, or several that are called alike.
#[derive(Clone, Debug)]
pub struct Entry {
    name: Cow<'static, str>,
    pub about: Cow<'static, str>,
    /// Of a table.
    columns: Vec<Column>,
}

impl Entry {
    /// A file that is no table.
    pub fn file(name: impl Into<Cow<'static, str>>, about: impl Into<Cow<'static, str>>) -> Self {
        Self {
            name: name.into(),
            about: about.into(),
            columns: Vec::new(),
        }
    }

    /// Whether a file or folder has its name.
    #[cfg(all(unix, feature = "twin"))]
    pub fn is_called(&self, name: &str) -> bool {
        self.name == name
    }

    /// A table as CSV.
    pub fn table<'a>(name: &'static str, about: &'static str, columns: impl IntoIterator<Item = &'a Column>) -> Self {
        Self {
            columns: columns.into_iter().cloned().collect(),
            ..Self::file(name, about)
        }
    }
}

/// Writes the description of a directory there.
///
/// # Errors
/// Exit 6 when writing fails.
pub fn describe(directory: &Path, what: &str, entries: &[Entry]) -> Result {
    let readme = Entry::file(README, "this description");
    let all = [&[readme], entries].concat();
    let text = format!("{what}\n{}\n{}", "=".repeat(what.chars().count()), tables(&all, "---"));
    disk::note(&directory.join(README), text.as_bytes())
}

/// All entries as tables, those of columns under headings.
pub fn tables(entries: &[Entry], heading: &str) -> String {
    let quoted = |name: &str| format!("`{name}`");
    let files = entries
        .iter()
        .map(|Entry { name, about, .. }| [quoted(name), about.to_string()]);
    let mut text = table(["file", "content"], &files.collect::<Vec<_>>());
    for Entry { name, columns, .. } in entries.iter().filter(|entry| !entry.columns.is_empty()) {
        let rows = columns.iter().map(|column| {
            let Column { name, unit, about, .. } = column;
            [quoted(name), (*unit).to_owned(), about.to_string()]
        });
        let title = match heading {
            "---" => format!("\n{name}\n{}\n", "-".repeat(name.chars().count())),
            marks => format!("\n{marks} `{name}`\n"),
        };
        text += &title;
        text += &table(["column", "unit", "content"], &rows.collect::<Vec<_>>());
    }
    text
}

/// A table whose columns line up, as plain text and as Markdown.
pub fn table<const COLUMNS: usize>(head: [&str; COLUMNS], rows: &[[String; COLUMNS]]) -> String {
    let head = head.map(str::to_owned);
    let width = |column: usize| {
        let cells = rows.iter().chain([&head]).map(|row| row[column].chars().count());
        // The last column has nothing to line up with.
        if column + 1 == COLUMNS {
            0
        } else {
            cells.max().unwrap_or(0)
        }
    };
    let widths: [usize; COLUMNS] = std::array::from_fn(width);
    let line = |cells: [String; COLUMNS]| {
        let cells = cells
            .iter()
            .zip(widths)
            .map(|(cell, width)| format!(" {cell:<width$} |"));
        format!("|{}\n", cells.collect::<String>())
    };
    let rule = widths.map(|width| "-".repeat(width.max(3)));
    let rows = rows.iter().cloned().map(line);
    format!("\n{}{}{}", line(head.clone()), line(rule), rows.collect::<String>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_line_up_and_have_a_unit_where_there_is_one() {
        let columns = [
            Column::whole("cycle", "100 ms", "its number"),
            Column::number("x", "", "a score"),
        ];
        let entries = [
            Entry::file("a", "a file"),
            Entry::table("trace.csv", "a table", &columns),
        ];
        assert_eq!(head(&columns), "cycle,x\n");
        assert_eq!(
            tables(&entries, "---"),
            "
| file        | content |
| ----------- | --- |
| `a`         | a file |
| `trace.csv` | a table |

trace.csv
---------

| column  | unit   | content |
| ------- | ------ | --- |
| `cycle` | 100 ms | its number |
| `x`     |        | a score |
"
        );
    }
}
