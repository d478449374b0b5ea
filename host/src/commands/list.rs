//! `oneiro list`: the runs below a directory and their state.

use std::fs;
use std::path::{Path, PathBuf};

use oneiro_base::answer::Answer;
use oneiro_base::console::{Console, columns, decimal};
use oneiro_base::exit::{Code, Failure, Result};
use oneiro_base::files;
use oneiro_lab::experiment::kinds::{is_run, is_sweep};
use oneiro_lab::record::{SavedRun, State};
use serde_json::{Value, json};

use super::places::{RUNS, SWEEPS, found, no_runs, sort_by_age, typed};
use crate::cli::List;

/// Characters of a line, if names allow it.
const WIDTH: usize = 100;
/// Characters of an experiment's name that are shown in any case.
const SHORTEST: usize = 10;

/// Prints one line per run.
pub(crate) fn run(arguments: &List, console: Console) -> Result {
    let mut runs = match &arguments.dir {
        Some(named) => runs(&found(named, &[RUNS, SWEEPS], console)?)?,
        None => match runs(Path::new(RUNS)) {
            Err(failure) if failure.code() == Code::Input as u8 => return Err(no_runs()),
            runs => runs?,
        },
    };
    sort_by_age(&mut runs);
    let values: Vec<Value> = runs.iter().map(|directory| entry(directory)).collect();
    console.print_answer(&Answer::new(table(&runs, &values, console), values))
}

/// A row for each run, of at most [`WIDTH`] characters unless names are long.
fn table(runs: &[PathBuf], entries: &[Value], console: Console) -> String {
    let text = |value: &Value| match value {
        Value::Null => "-".to_owned(),
        Value::String(text) => text.clone(),
        other => other.to_string(),
    };
    // The usual name of a run has its experiment and its seed.
    let named = |(directory, entry): (&PathBuf, &Value)| {
        let usual = format!("{}-{}", text(&entry["name"]), text(&entry["seed"]));
        let name = directory.file_name().unwrap_or_default().to_string_lossy();
        entry["name"].is_null() || name.starts_with(&usual)
    };
    let is_named = runs.iter().zip(entries).all(named);
    let rows: Vec<Vec<String>> = runs
        .iter()
        .zip(entries)
        .map(|(directory, entry)| {
            let mut row = vec![typed(directory)];
            if !is_named {
                row.extend([text(&entry["name"]), text(&entry["seed"])]);
            }
            // A race ends when its budget is spent, mostly before the most generations that it can have.
            let generations = match &*text(&entry["state"]) {
                "done" => text(&entry["generation"]),
                _ => format!("{}/{}", text(&entry["generation"]), text(&entry["generations"])),
            };
            let hash = text(&entry["result"]);
            row.extend([text(&entry["state"]), generations, text(&entry["best"])]);
            row.push(console.hash(&hash).to_owned());
            row
        })
        .collect();
    let of_experiment = if is_named { &[][..] } else { &["experiment", "seed"] };
    let head = [&["run"], of_experiment, &["state", "generations", "best", "result"]].concat();
    let wide = columns(&head, &rows);
    let beyond = wide
        .lines()
        .map(|line| line.chars().count())
        .max()
        .unwrap_or_default()
        .saturating_sub(WIDTH);
    if is_named || beyond == 0 {
        return wide;
    }
    let longest = rows.iter().map(|row| row[1].chars().count()).max().unwrap_or_default();
    let allowed = longest.saturating_sub(beyond).max(SHORTEST);
    let short = |row: &Vec<String>| {
        let mut row = row.clone();
        if row[1].chars().count() > allowed {
            row[1] = row[1].chars().take(allowed - 2).collect::<String>() + "..";
        }
        row
    };
    columns(&head, &rows.iter().map(short).collect::<Vec<_>>())
}

/// The runs in a directory, in the order of the numbers in their names; or the directory itself if it is one.
///
/// # Errors
/// Exit 3 if there is no such directory, or no run in it.
pub(crate) fn runs(directory: &Path) -> Result<Vec<PathBuf>> {
    if is_run(directory) {
        return Ok(vec![directory.to_owned()]);
    }
    if directory.is_file() {
        let problem = "is a file; allowed: a run's directory, or one that holds runs";
        return Err(Failure::input(format_args!("{}: {problem}", directory.display())));
    }
    if is_sweep(directory) {
        let directory = directory.display();
        return Err(Failure::input(format_args!(
            "{directory}: is a sweep, not a run; `oneiro sweep status {directory}` shows its shards, `oneiro verify {directory}` checks \
             its tables, and `oneiro sweep extract {directory} RUN` repeats a run and compares it"
        )));
    }
    let entries = fs::read_dir(directory).map_err(|error| Failure::unreadable(directory, &error))?;
    let mut runs = Vec::new();
    for entry in entries {
        let path = entry.map_err(|error| Failure::storage(directory, &error))?.path();
        if is_run(&path) {
            runs.push(path);
        }
    }
    if runs.is_empty() {
        return Err(Failure::input(format_args!(
            "{}: is not a run directory and holds none; allowed: directories that `oneiro run` wrote",
            directory.display()
        )));
    }
    runs.sort_by(|a, b| files::by_numbers(a, b));
    Ok(runs)
}

/// The directory of a run.
///
/// # Errors
/// As [`runs`]; exit 3 if it holds runs instead.
pub(crate) fn one(directory: &Path) -> Result<PathBuf> {
    let mut runs = runs(directory)?;
    let first = runs.swap_remove(0);
    if first == directory {
        return Ok(first);
    }
    let (directory, first) = (directory.display(), first.display());
    Err(Failure::input(format_args!(
        "{directory}: holds runs; allowed: the directory of one, such as {first}"
    )))
}

/// Summary of a run. Its state says if it can't be read, or was changed after it was finished.
fn entry(directory: &Path) -> Value {
    let unreadable = |failure: Failure| {
        json!({
            "directory": directory.display().to_string(),
            "state": "unreadable",
            "problem": failure.to_string(),
        })
    };
    let run = match SavedRun::open(directory) {
        Ok(run) => run,
        Err(failure) => return unreadable(failure),
    };
    let mut entry = json!({
        "directory": directory.display().to_string(),
        "name": run.experiment().name(),
        "seed": run.seed(),
        "generation": null,
        "generations": run.experiment().length(),
        "best": null,
        "result": null,
    });
    let done = match run.done() {
        Ok(done) => done,
        Err(failure) if failure.code() == Code::Corrupt as u8 => {
            entry["state"] = "changed".into();
            entry["problem"] = failure.to_string().into();
            return entry;
        }
        Err(failure) => return unreadable(failure),
    };
    entry["state"] = match run.state(done.is_some()) {
        State::Done => "done",
        State::Running => "running",
        State::Stopped => "stopped",
        State::Interrupted => "interrupted",
    }
    .into();
    match run.experiment().progress(&run.known(done.is_some())) {
        Ok((steps, best)) => {
            entry["generation"] = steps.into();
            entry["best"] = best.map(decimal).into();
        }
        Err(failure) => return unreadable(failure),
    }
    entry["result"] = done.map(|done| done.result).into();
    entry
}
