//! Output: data to standard output, messages to standard error. All that is shown goes through here, where characters that control
//! a terminal are escaped: names of files, keys, comments and what robots' computers say may have any.

#![expect(clippy::disallowed_methods, reason = "all other code prints by these functions")]

use std::borrow::Cow;
use std::fmt::{Display, Write as _};
use std::io::{self, IsTerminal, Write};

use serde::Serialize;
use serde_json::Value;

use crate::answer::Answer;
use crate::exit::{Failure, Result};

/// Options for the output of all commands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Output {
    /// Whether to print data as JSON.
    pub json: bool,
    /// Whether to hide all messages except errors, and the progress bar.
    pub quiet: bool,
    /// Whether text has whole hashes.
    pub verbose: bool,
}

/// Whether progress is shown, on standard error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bars {
    /// If standard error is a terminal.
    Shown,
    Hidden,
}

/// Prints data and messages.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Console {
    output: Output,
}

impl Console {
    /// Applies `--json` and `--quiet`.
    pub fn new(output: Output) -> Self {
        Self { output }
    }

    /// Whether data go to a person's terminal.
    pub fn has_screen(self) -> bool {
        !self.output.json && io::stdout().is_terminal()
    }

    /// Whether messages and progress are hidden.
    pub fn quiet(self) -> bool {
        self.output.quiet
    }

    /// Whether progress is shown.
    pub fn bars(self) -> Bars {
        if self.quiet() { Bars::Hidden } else { Bars::Shown }
    }

    /// Prints an answer: its messages, then its text or its JSON.
    pub fn print_answer<T: Serialize>(self, answer: &Answer<T>) -> Result {
        self.warn(&answer.warnings);
        for message in &answer.messages {
            self.say(message);
        }
        self.print_text(&answer.text)?;
        self.print_json(&answer.value)
    }

    /// Prints text, unless `--json` is given. With [`Self::print_json`] for data whose text comes piece by piece, and whose JSON is
    /// a whole.
    pub fn print_text(self, text: impl AsRef<str>) -> Result {
        if self.output.json {
            return Ok(());
        }
        self.print_plain(text)
    }

    /// Prints data as JSON, indented, if `--json` is given.
    pub fn print_json(self, value: &impl Serialize) -> Result {
        if !self.output.json {
            return Ok(());
        }
        let text = serde_json::to_string_pretty(value).map_err(Failure::failed)?;
        Self::print(&shown_in_json(&text))
    }

    /// Prints one of several data that come one after another, as text or as a line of JSON.
    pub fn print_line(self, text: impl AsRef<str>, value: &Value) -> Result {
        if self.output.json {
            self.print_json_line(value)
        } else {
            self.print_text(text)
        }
    }

    /// Prints data as a line of JSON, also without `--json`.
    pub fn print_json_line(self, value: &Value) -> Result {
        Self::print(&shown_in_json(&value.to_string()))
    }

    /// Prints text that has no other form, such as a script.
    pub fn print_plain(self, text: impl AsRef<str>) -> Result {
        Self::print(&shown(text.as_ref()))
    }

    /// Prints a text, and adds a missing line end; nothing if it is empty.
    fn print(text: &str) -> Result {
        if text.is_empty() {
            return Ok(());
        }
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

    /// Prints why the program ends, also if `--quiet` is given.
    pub fn fail(self, failure: &Failure) {
        self.ask(format!("oneiro: {failure}"));
    }

    /// Asks a person to do something, also if `--quiet` is given.
    pub fn ask(self, text: impl AsRef<str>) {
        // If standard error is closed, there is nobody to read it.
        let _ = writeln!(io::stderr(), "{}", shown(text.as_ref()));
    }

    /// Prints a message, unless `--quiet` is given.
    pub fn say(self, text: impl AsRef<str>) {
        if !self.output.quiet {
            self.ask(text);
        }
    }

    /// Says what to type next, unless `--quiet` is given.
    pub fn next(self, command: impl Display) {
        self.say(format!("next: {command}"));
    }

    /// A hash as text shows it: 12 digits, or all with `--verbose`.
    pub fn hash(self, hash: &str) -> &str {
        const SHORT: usize = 12;
        let end = if self.output.verbose { hash.len() } else { SHORT };
        hash.get(..end).unwrap_or(hash)
    }

    /// Prints warnings as messages.
    pub fn warn(self, warnings: impl IntoIterator<Item = impl Display>) {
        for warning in warnings {
            self.say(format!("warning: {warning}"));
        }
    }
}

/// Whether a character would act on a terminal, or change what others look like, instead of being shown: controls of both sets,
/// separators of lines and paragraphs, marks that turn the direction of writing, and invisible ones.
fn is_hidden(c: char) -> bool {
    c.is_control()
        || matches!(
            c,
            '\u{61c}' | '\u{200b}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}' | '\u{feff}'
                | '\u{fff9}'..='\u{fffb}' | '\u{e0000}'..='\u{e007f}'
        )
}

/// A text to show: control characters, which act on a terminal, are escaped, such as `\u{1b}`. Lines and tabs stay.
pub fn shown(text: &str) -> Cow<'_, str> {
    escaped(text, "\n\t", |c, text| text.extend(c.escape_default()))
}

/// A text to show within a line, such as a cell: also ends of lines and tabs are escaped.
fn shown_in_line(text: &str) -> Cow<'_, str> {
    escaped(text, "", |c, text| text.extend(c.escape_default()))
}

/// JSON to show: the control characters that JSON allows in strings are escaped in the way of JSON.
pub fn shown_in_json(json: &str) -> Cow<'_, str> {
    escaped(json, "\n\t", |c, text| {
        for unit in c.encode_utf16(&mut [0; 2]) {
            // Writing to a string can't fail.
            let _ = write!(text, "\\u{unit:04x}");
        }
    })
}

/// Escapes what is hidden, except for what is allowed.
fn escaped<'a>(text: &'a str, allowed: &str, escape: impl Fn(char, &mut String)) -> Cow<'a, str> {
    let is_escaped = |c: char| is_hidden(c) && !allowed.contains(c);
    if !text.contains(is_escaped) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        if is_escaped(c) {
            escape(c, &mut shown);
        } else {
            shown.push(c);
        }
    }
    Cow::Owned(shown)
}

/// A float32 for JSON: the shortest decimal that reads back as the same number; null if it isn't finite.
pub fn decimal(value: f32) -> Value {
    value.to_string().parse::<f64>().map_or(Value::Null, Value::from)
}

/// A count with its noun, singular or plural.
pub fn counted<N: Copy + Display + PartialEq + From<u8>>(count: N, one: &str, many: &str) -> String {
    format!("{count} {}", if count == N::from(1) { one } else { many })
}

/// Rows as text in columns: words aligned left, numbers right.
pub fn columns(head: &[&str], rows: &[Vec<String>]) -> String {
    let in_lines = |row: &Vec<String>| row.iter().map(|cell| shown_in_line(cell).into_owned()).collect();
    let rows: Vec<Vec<String>> = rows.iter().map(in_lines).collect();
    let cells = |column: usize| rows.iter().filter_map(move |row| row.get(column));
    let layout: Vec<(usize, bool)> = (0..head.len())
        .map(|column| {
            let longest = cells(column).map(|cell| cell.chars().count()).max().unwrap_or(0);
            let is_words = cells(column).any(|cell| is_word(cell));
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
    for row in &rows {
        text += &line(&mut row.iter().map(String::as_str));
    }
    text
}

/// Whether a cell is no number: a name, or a hash, which may begin with digits. A number may have a unit after a space.
fn is_word(cell: &str) -> bool {
    let is_of_hash = |letter: char| letter.is_ascii_hexdigit() && letter.is_ascii_alphabetic() && letter != 'e';
    cell.starts_with(|first: char| !"-+.0123456789".contains(first))
        || cell
            .split(' ')
            .next()
            .is_some_and(|first| first.len() > 8 && first.contains(is_of_hash))
}

/// Columns of a line on a terminal.
const TERMINAL: usize = 100;

/// The same with words in the last column, which go on below themselves where a line would be longer than a terminal's.
pub fn wrapped(head: &[&str], rows: &[Vec<String>]) -> String {
    let Some((words, head)) = head.split_last() else {
        return String::new();
    };
    let narrow: Vec<Vec<String>> = rows
        .iter()
        .map(|row| row[..head.len().min(row.len())].to_vec())
        .collect();
    let lines = columns(head, &narrow);
    let width = lines.lines().map(|line| line.chars().count()).max().unwrap_or(0);
    let last = rows.iter().map(|row| row.get(head.len()).map_or("", String::as_str));
    let mut text = String::new();
    for (line, words) in lines.lines().zip(std::iter::once(*words).chain(last)) {
        let mut line = format!("{line:<width$}  ");
        let mut has_words = false;
        for word in shown_in_line(words).split_whitespace() {
            if has_words && line.chars().count() + 1 + word.chars().count() > TERMINAL {
                text += &(line + "\n");
                line = " ".repeat(width + 2);
                has_words = false;
            }
            if has_words {
                line.push(' ');
            }
            line += word;
            has_words = true;
        }
        text += &(line.trim_end().to_owned() + "\n");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A hash is aligned as a word whichever digits the first has.
    #[test]
    fn hashes_are_words_and_numbers_with_units_are_not() {
        let table = columns(
            &["n", "result", "time"],
            &[["1", "0fbeeec4b682", "9.8 s"].map(str::to_owned).into()],
        );
        assert_eq!(table, "n  result         time\n1  0fbeeec4b682  9.8 s\n");
        assert!(!is_word("-1.25e-10") && !is_word("1000000000") && is_word("none"));
    }

    #[test]
    fn words_go_on_below_themselves() {
        let long = "2, lagged: undecided: the 95 % interval of the difference in the rate of a light over the nest and at random \
                    spans 0; 5 more";
        let rows = [["D1", "undecided", long], ["D12", "holds", ""]].map(|row| row.map(str::to_owned).to_vec());
        assert_eq!(
            wrapped(&["claim", "verdict", "reason"], &rows),
            "claim  verdict    reason\n\
             D1     undecided  2, lagged: undecided: the 95 % interval of the difference in the rate of a light\n                  \
             over the nest and at random spans 0; 5 more\n\
             D12    holds\n"
        );
    }

    #[test]
    fn decimals_are_short() {
        assert_eq!(decimal(305.615_6).to_string(), "305.6156");
        assert_eq!(decimal(f32::NAN), Value::Null);
        assert_eq!(decimal(f32::INFINITY), Value::Null);
    }

    #[test]
    fn what_acts_on_a_terminal_is_escaped() {
        assert_eq!(shown("ärm\n\tx \u{1f916}"), "ärm\n\tx \u{1f916}");
        assert_eq!(shown("a\u{1b}[2Jb\rc\u{7f}\u{9b}"), r"a\u{1b}[2Jb\rc\u{7f}\u{9b}");
        assert_eq!(
            shown("gpj\u{202e}\u{2028}\u{2066}\u{200e}"),
            r"gpj\u{202e}\u{2028}\u{2066}\u{200e}"
        );
        let rows = [vec!["a\nb".to_owned()], vec!["\u{8}".to_owned()]];
        assert_eq!(columns(&["x"], &rows), "x\na\\nb\n\\u{8}\n");
        // Each character is shown either unchanged, or as plain letters that name it.
        for c in (0..=0x0010_ffff).filter_map(char::from_u32) {
            let text = c.to_string();
            let (escaped, json) = (shown(&text), shown_in_json(&text));
            assert!(
                escaped == text || escaped.chars().all(|c| c.is_ascii_graphic()),
                "{escaped}"
            );
            assert!(
                escaped.chars().all(|c| "\n\t".contains(c) || !is_hidden(c)),
                "{escaped}"
            );
            let escaped = serde_json::to_string(&text).unwrap();
            assert_eq!(serde_json::from_str::<String>(&shown_in_json(&escaped)).unwrap(), text);
            assert!(json.chars().all(|c| "\n\t".contains(c) || !is_hidden(c)), "{json}");
        }
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
