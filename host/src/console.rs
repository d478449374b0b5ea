//! Output: data to standard output, messages to standard error.

use std::fmt::Display;
use std::io::{self, Write};

use clap::Args;

use crate::exit::{Failure, Result};

/// Options for the output of all commands.
#[derive(Args, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Output {
    /// Print data as JSON
    #[arg(long, global = true, display_order = 900)]
    pub(crate) json: bool,
    /// Hide all messages but errors, and the progress bar
    #[arg(long, short, global = true, display_order = 901)]
    pub(crate) quiet: bool,
}

/// Prints data and messages.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Console {
    output: Output,
}

impl Console {
    /// Applies `--json` and `--quiet`.
    pub(crate) fn new(output: Output) -> Self {
        Self { output }
    }

    /// Whether data are printed as JSON.
    pub(crate) fn json(self) -> bool {
        self.output.json
    }

    /// Whether messages and progress are hidden.
    pub(crate) fn quiet(self) -> bool {
        self.output.quiet
    }

    /// Prints data, and adds a missing line end.
    #[expect(clippy::unused_self, reason = "all that is printed goes through the console")]
    pub(crate) fn data(self, text: impl AsRef<str>) -> Result {
        let text = text.as_ref();
        let mut stdout = io::stdout().lock();
        stdout
            .write_all(text.as_bytes())
            .and_then(|()| {
                if text.ends_with('\n') {
                    Ok(())
                } else {
                    stdout.write_all(b"\n")
                }
            })
            .and_then(|()| stdout.flush())
            .map_err(|error| Failure::stdout(&error))
    }

    /// Prints data as JSON, indented.
    pub(crate) fn json_data(self, value: &impl serde::Serialize) -> Result {
        let text = serde_json::to_string_pretty(value).map_err(Failure::failed)?;
        self.data(text)
    }

    /// Asks a person to do something, also if `--quiet` is given.
    #[expect(clippy::unused_self, reason = "all that is printed goes through the console")]
    pub(crate) fn ask(self, text: impl AsRef<str>) {
        // If standard error is closed, there is nobody to read it.
        let _ = writeln!(io::stderr(), "{}", text.as_ref());
    }

    /// Prints a message, unless `--quiet` is given.
    pub(crate) fn say(self, text: impl AsRef<str>) {
        if !self.output.quiet {
            // If standard error is closed, there is nobody to read the message.
            let _ = writeln!(io::stderr(), "{}", text.as_ref());
        }
    }

    /// Prints warnings as messages.
    pub(crate) fn warn(self, warnings: impl IntoIterator<Item = impl Display>) {
        for warning in warnings {
            self.say(format!("warning: {warning}"));
        }
    }
}

/// A float32 for JSON: the shortest decimal that reads back as the same number; null if it isn't finite.
pub(crate) fn decimal(value: f32) -> serde_json::Value {
    value
        .to_string()
        .parse::<f64>()
        .map_or(serde_json::Value::Null, serde_json::Value::from)
}

/// A count with its noun, singular or plural.
pub(crate) fn counted<N: Copy + Display + PartialEq + From<u8>>(count: N, one: &str, many: &str) -> String {
    format!("{count} {}", if count == N::from(1) { one } else { many })
}

/// Rows as text in columns: words aligned left, numbers right.
pub(crate) fn columns(head: &[&str], rows: &[Vec<String>]) -> String {
    let cells = |column: usize| rows.iter().filter_map(move |row| row.get(column));
    let layout: Vec<(usize, bool)> = (0..head.len())
        .map(|column| {
            let longest = cells(column).map(|cell| cell.chars().count()).max().unwrap_or(0);
            let is_words = cells(column).any(|cell| cell.starts_with(|first: char| !"-+.0123456789".contains(first)));
            (longest.max(head[column].chars().count()), is_words || column == 0)
        })
        .collect();
    let line = |cells: &mut dyn Iterator<Item = &str>| {
        let cells: Vec<String> = cells
            .zip(&layout)
            .map(|(cell, &(width, is_words))| {
                if is_words {
                    format!("{cell:<width$}")
                } else {
                    format!("{cell:>width$}")
                }
            })
            .collect();
        cells.join("  ").trim_end().to_owned() + "\n"
    };
    let mut text = line(&mut head.iter().copied());
    for row in rows {
        text += &line(&mut row.iter().map(String::as_str));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::{columns, decimal};

    #[test]
    fn decimals_are_short() {
        assert_eq!(decimal(305.615_6).to_string(), "305.6156");
        assert_eq!(decimal(f32::NAN), serde_json::Value::Null);
        assert_eq!(decimal(f32::INFINITY), serde_json::Value::Null);
    }

    #[test]
    fn columns_line_up() {
        let rows = [
            vec!["a".to_owned(), "1.5".to_owned()],
            vec!["long".to_owned(), "10".to_owned()],
        ];
        assert_eq!(columns(&["x", "n"], &rows), "x       n\na     1.5\nlong   10\n");
    }
}
