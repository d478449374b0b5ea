//! Results kept in files, called goldens: a test computes them again and fails if they differ.
//!
//! A mismatch prints the old and the new rows, and writes the new ones beside the file, as `FILE.new`. To accept them,
//! run the same test again with `ONEIRO_ACCEPT="reason"`: if it finds the rows of `FILE.new`, the file is replaced, and
//! the reason is added to `CHANGES.md` in the same folder; that run fails too. If `CI` is set, nothing is written.
//! `docs/testing.md` has more.

#![allow(dead_code, reason = "each test target uses what it needs")]

use std::collections::BTreeMap;
use std::fmt::{Display, Write as _};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs};

/// Rows of a golden file, ordered so that results follow those they depend on: the first row that differs shows where a
/// difference begins. Each has a stage, a subject, and the pinned value.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Rows(Vec<String>);

/// Words of a row shown in addition to their digest.
const SHOWN: usize = 4;

impl Rows {
    /// Adds a row of plain text.
    pub(crate) fn text(&mut self, stage: &str, subject: &str, text: impl Display) {
        let row = format!("{stage} | {subject} | {text}");
        assert!(!row.contains('\n'), "a row is a line: {row}");
        assert!(
            !self.0.iter().any(|other| key(other) == key(&row)),
            "two rows of one name: {row}"
        );
        self.0.push(row);
    }

    /// Adds a row of words: their number, their digest, and the first of them.
    pub(crate) fn words(&mut self, stage: &str, subject: &str, words: &[u32]) {
        let first = words.iter().map(|word| format!("{word:08x}"));
        self.digested(stage, subject, "words", words, first);
    }

    /// Adds a row of numbers: how many, the digest of their bits, and the first of them.
    pub(crate) fn numbers(&mut self, stage: &str, subject: &str, numbers: &[f32]) {
        let words: Vec<u32> = numbers.iter().map(|number| number.to_bits()).collect();
        let first = numbers.iter().map(|number| format!("{number:?}"));
        self.digested(stage, subject, "numbers", &words, first);
    }

    /// Adds a row of bytes: their number and their digest.
    pub(crate) fn bytes(&mut self, stage: &str, subject: &str, bytes: &[u8]) {
        self.text(stage, subject, format_args!("{} bytes, {}", bytes.len(), digest(bytes)));
    }

    fn digested(&mut self, stage: &str, subject: &str, unit: &str, words: &[u32], shown: impl Iterator<Item = String>) {
        let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
        let first = shown.take(SHOWN).collect::<Vec<_>>().join(" ");
        self.text(
            stage,
            subject,
            format_args!("{} {unit}, {}: {first}", words.len(), digest(&bytes)),
        );
    }
}

impl Display for Rows {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.0.iter().try_for_each(|row| writeln!(f, "{row}"))
    }
}

/// 64 bits of a hash.
pub(crate) fn digest(bytes: &[u8]) -> String {
    blake3::hash(bytes).to_hex()[..16].to_owned()
}

/// Stage and subject of a row.
fn key(row: &str) -> &str {
    let second = row.match_indices(" | ").nth(1);
    second.map_or(row, |(end, _)| &row[..end])
}

/// Fails unless a golden file agrees with the results.
///
/// # Panics
/// If it doesn't.
pub(crate) fn check(path: &Path, found: &str) {
    if let Some(problem) = problem(path, found) {
        panic!("{problem}");
    }
}

/// Describes how a golden file differs from the results; `None` if it doesn't.
pub(crate) fn problem(path: &Path, found: &str) -> Option<String> {
    compared(path, found, &Renewal::of_this_run()).err()
}

/// Fails unless a folder has exactly these golden files and their list of changes.
///
/// # Panics
/// If a file is missing or superfluous.
pub(crate) fn check_folder(folder: &Path, files: &[String]) {
    if let Err(problem) = all_used(folder, files) {
        panic!("{problem}");
    }
}

/// Settings for renewing goldens.
#[derive(Clone, Debug, Default)]
pub(crate) struct Renewal {
    /// Nothing is written in continuous integration.
    pub(crate) ci: bool,
    /// Reason why the differences are right.
    pub(crate) reason: Option<String>,
}

impl Renewal {
    fn of_this_run() -> Self {
        Self {
            ci: env::var_os("CI").is_some(),
            reason: env::var("ONEIRO_ACCEPT").ok().map(|reason| {
                let reason = reason.trim();
                assert!(
                    !reason.is_empty() && !reason.contains('\n'),
                    "ONEIRO_ACCEPT has no reason in one line"
                );
                reason.to_owned()
            }),
        }
    }
}

/// Compares results with a golden file.
///
/// # Errors
/// The differences, and what to do about them.
pub(crate) fn compared(path: &Path, found: &str, renewal: &Renewal) -> Result<(), String> {
    let new = beside(path);
    let kept = fs::read_to_string(path).unwrap_or_default();
    let io = |error: std::io::Error| format!("{}: {error}", path.display());
    if kept == found {
        if !renewal.ci {
            // Results from before the code was put right again.
            let _ = fs::remove_file(&new);
        }
        let Err(problem) = accepted(path, &kept) else {
            return Ok(());
        };
        let Some(reason) = renewal.reason.as_deref().filter(|_| !renewal.ci) else {
            return Err(problem);
        };
        log(path, found, reason, &[]).map_err(io)?;
        return Err(format!("{}: accepted: {reason}; the next run passes", path.display()));
    }
    let differences = differences(path, &kept, found);
    let mut message = format!("{} differs:\n{}", path.display(), shown(&differences));
    match &renewal.reason {
        _ if renewal.ci => message += "nothing is written where CI is set",
        Some(reason) if fs::read_to_string(&new).is_ok_and(|seen| seen == found) => {
            log(path, found, reason, &differences).map_err(io)?;
            fs::rename(&new, path).map_err(io)?;
            let _ = write!(message, "accepted: {reason}; the next run passes");
        }
        _ => {
            fs::write(&new, found).map_err(io)?;
            let _ = write!(
                message,
                "{} has what was found; if it is right, run this test again with ONEIRO_ACCEPT=\"why\"",
                new.display()
            );
        }
    }
    Err(message)
}

/// A row that differs.
struct Difference {
    /// Stage of the row, or the line of a file that has no rows.
    stage: String,
    old: Option<String>,
    new: Option<String>,
}

fn differences(path: &Path, kept: &str, found: &str) -> Vec<Difference> {
    if path.extension().is_some_and(|extension| extension == "rows") {
        let find = |text: &str, row: &str| -> Option<String> {
            text.lines().find(|other| key(other) == key(row)).map(str::to_owned)
        };
        let stage = |row: &str| row.split(" | ").next().unwrap_or_default().to_owned();
        let changed = found.lines().map(|row| Difference {
            stage: stage(row),
            old: find(kept, row),
            new: Some(row.to_owned()),
        });
        let unused = kept
            .lines()
            .filter(|row| find(found, row).is_none())
            .map(|row| Difference {
                stage: stage(row),
                old: Some(row.to_owned()),
                new: None,
            });
        changed.chain(unused).filter(|row| row.old != row.new).collect()
    } else {
        let lines = kept.lines().count().max(found.lines().count());
        let line = |text: &str, index| text.lines().nth(index).map(str::to_owned);
        (0..lines)
            .map(|index| Difference {
                stage: format!("line {}", index + 1),
                old: line(kept, index),
                new: line(found, index),
            })
            .filter(|line| line.old != line.new)
            .take(GREATEST)
            .collect()
    }
}

/// Most differences in a message.
const GREATEST: usize = 20;

fn shown(differences: &[Difference]) -> String {
    let Some(first) = differences.first() else {
        return "  the same rows in another order\n".to_owned();
    };
    let mut text = format!("  the first difference is in {}\n", first.stage);
    for Difference { old, new, .. } in differences.iter().take(GREATEST) {
        let _ = match (old, new) {
            (Some(old), Some(new)) => writeln!(text, "  old: {old}\n  new: {new}"),
            (None, Some(new)) => writeln!(text, "  not in the file: {new}"),
            (Some(old), None) => writeln!(text, "  nothing uses: {old}"),
            (None, None) => Ok(()),
        };
    }
    if differences.len() > GREATEST {
        let _ = writeln!(text, "  and {} more", differences.len() - GREATEST);
    }
    text
}

fn beside(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".new");
    name.into()
}

const LOG: &str = "CHANGES.md";
const LOG_BEGINS: &str = "# Why goldens changed\n\n\
    A line for each accepted change, the latest last: the file, its digest, the reason, and how many rows of each stage \
    changed.\nTests write it; a file that is not as its last line says fails.\n\n";

fn log_of(path: &Path) -> PathBuf {
    path.with_file_name(LOG)
}

fn entry(path: &Path, text: &str) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    format!("- `{name}` {}: ", digest(text.as_bytes()))
}

fn log(path: &Path, text: &str, reason: &str, differences: &[Difference]) -> std::io::Result<()> {
    let mut stages = BTreeMap::<&str, u32>::new();
    for difference in differences {
        let name = difference.stage.split(' ').next().unwrap_or_default();
        *stages.entry(name).or_default() += 1;
    }
    let stages: Vec<String> = stages.iter().map(|(stage, count)| format!("{count} {stage}")).collect();
    let log = log_of(path);
    let mut file = fs::OpenOptions::new().create(true).append(true).open(&log)?;
    let head = if file.metadata()?.len() == 0 { LOG_BEGINS } else { "" };
    let changed = if stages.is_empty() {
        "as it was".to_owned()
    } else {
        stages.join(", ")
    };
    let line = format!("{head}{}{reason} ({changed})\n", entry(path, text));
    file.write_all(line.as_bytes())
}

/// Whether the last change of a file was accepted as it stands.
fn accepted(path: &Path, text: &str) -> Result<(), String> {
    let log = fs::read_to_string(log_of(path)).unwrap_or_default();
    let own = entry(path, text);
    let name = own.split_inclusive('`').take(2).collect::<String>();
    let last = log.lines().rfind(|line| line.starts_with(&name));
    if last.is_some_and(|line| line.starts_with(&own)) {
        return Ok(());
    }
    Err(format!(
        "{} was changed by hand: {} has no reason for it; put it back, or run this test with ONEIRO_ACCEPT=\"why\"",
        path.display(),
        log_of(path).display()
    ))
}

/// Checks that a folder has exactly these golden files.
///
/// # Errors
/// Missing files and unused ones.
pub(crate) fn all_used(folder: &Path, files: &[String]) -> Result<(), String> {
    let is_new = |name: &str| Path::new(name).extension().is_some_and(|extension| extension == "new");
    let entries = fs::read_dir(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let mut unused: Vec<String> = entries
        .filter_map(|entry| Some(entry.ok()?.file_name().to_string_lossy().into_owned()))
        .filter(|name| name != LOG && !is_new(name) && !files.contains(name))
        .collect();
    unused.sort();
    if unused.is_empty() {
        return Ok(());
    }
    Err(format!("{}: nothing uses {}", folder.display(), unused.join(", ")))
}
