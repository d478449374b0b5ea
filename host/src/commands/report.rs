//! Output about finished runs.

use std::path::{Path, PathBuf};

use oneiro_base::answer::Answer;
use oneiro_base::console::{Console, columns};
use oneiro_base::exit::Result;
use oneiro_lab::record::{Done, SavedRun};
use oneiro_lab::runs::Summary;
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};

use super::places::{RUNS, typed};

/// Summary of a finished run.
#[derive(Debug)]
pub(super) struct Report {
    pub(super) directory: PathBuf,
    pub(super) seed: u64,
    summary: Summary,
    /// Hash of the results.
    pub(super) result: String,
    /// Share of the command's robot-steps that kernels specialised to their worlds have simulated, if the run was done now.
    specialised: Option<f64>,
}

impl Report {
    /// Reads a finished run.
    pub(super) fn read(directory: &Path, done: &Done) -> Result<Self> {
        let run = SavedRun::open(directory)?;
        Ok(Self {
            directory: directory.to_owned(),
            seed: run.seed(),
            summary: run.experiment().summary(&run.known(true))?,
            result: done.result.clone(),
            specialised: None,
        })
    }

    /// The report of a run that was done now.
    pub(super) fn run_now(self, specialised: f64) -> Self {
        Self {
            specialised: Some(specialised),
            ..self
        }
    }

    fn cell(&self, column: &str) -> String {
        let own = self.summary.cells.iter().find(|(name, _)| *name == column);
        own.map_or_else(|| "-".to_owned(), |(_, cell)| cell.clone())
    }
}

impl Serialize for Report {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("directory", &self.directory)?;
        map.serialize_entry("seed", &self.seed)?;
        for (name, value) in &self.summary.values {
            map.serialize_entry(name, value)?;
        }
        map.serialize_entry("result", &self.result)?;
        if let Some(specialised) = self.specialised {
            map.serialize_entry("specialised", &specialised)?;
        }
        map.end()
    }
}

/// Prints reports: a single one by itself, or several as a list.
pub(super) fn print(reports: &[Report], as_list: bool, console: Console) -> Result {
    console.warn(reports.iter().flat_map(|report| &report.summary.warnings));
    match reports {
        [report] if !as_list => {
            let (label, line) = &report.summary.line;
            let width = label.len().max("result".len()) + 2;
            let text = format!(
                "{label:<width$}{line}\n{:<width$}{}\n{:<width$}{}",
                "result",
                console.hash(&report.result),
                "run",
                report.directory.display()
            );
            console.print_answer(&Answer::new(text, report))?;
        }
        _ => {
            // Each kind of run has its own columns.
            let mut names: Vec<&str> = Vec::new();
            for (name, _) in reports.iter().flat_map(|report| &report.summary.cells) {
                if !names.contains(name) {
                    names.push(name);
                }
            }
            let row = |report: &Report| {
                let mut row = vec![report.directory.display().to_string(), report.seed.to_string()];
                row.extend(names.iter().map(|name| report.cell(name)));
                row.push(console.hash(&report.result).to_owned());
                row
            };
            let rows: Vec<Vec<String>> = reports.iter().map(row).collect();
            let head = [&["run", "seed"][..], &names, &["result"]].concat();
            console.print_answer(&Answer::new(columns(&head, &rows), reports))?;
        }
    }
    say_next(reports, console);
    Ok(())
}

/// Says where the results are, and what to type next.
fn say_next(reports: &[Report], console: Console) {
    /// Files that people open first.
    const FILES: [&str; 6] = [
        "report.html",
        "champion.json",
        "path.svg",
        "generations.csv",
        "intervals.csv",
        "food.csv",
    ];
    let word = |report: &Report| if report.specialised.is_some() { "wrote" } else { "see" };
    match reports {
        [] => {}
        [report] => {
            let directory = &report.directory;
            let files: Vec<&str> = FILES
                .into_iter()
                .filter(|name| directory.join(name).is_file())
                .collect();
            console.say(format!(
                "{} {}: {}",
                word(report),
                directory.display(),
                files.join(", ")
            ));
            console.next(format_args!("oneiro replay {}", typed(directory)));
        }
        [first, .., last] => {
            let [from, to] = [first, last].map(|report| report.directory.display());
            console.say(format!("{} {} runs: {from} to {to}", word(last), reports.len()));
            let folder = first.directory.parent().unwrap_or(Path::new(""));
            console.next(match folder.to_str() {
                Some(RUNS) => "oneiro list".to_owned(),
                _ if folder.as_os_str().is_empty() => "oneiro list .".to_owned(),
                _ => format!("oneiro list {}", typed(folder)),
            });
        }
    }
}
