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

use crate::cli::List;

/// The directory of runs that have no other.
const USUAL: &str = "runs";

/// Prints one line per run.
pub(crate) fn run(arguments: &List, console: Console) -> Result {
    let usual = Path::new(USUAL);
    if arguments.dir.is_none() && !usual.exists() {
        return Err(Failure::input(format_args!(
            "there are no runs here yet, and no directory `{USUAL}`; allowed: the name of a directory with runs"
        )));
    }
    let runs = runs(arguments.dir.as_deref().unwrap_or(usual))?;
    let runs: Vec<Value> = runs.iter().map(|directory| entry(directory)).collect();
    let text = |value: &Value| match value {
        Value::Null => "-".to_owned(),
        Value::String(text) => text.clone(),
        other => other.to_string(),
    };
    let rows: Vec<Vec<String>> = runs
        .iter()
        .map(|entry| {
            let hash: String = text(&entry["result"]).chars().take(12).collect();
            let generations = format!("{}/{}", text(&entry["generation"]), text(&entry["generations"]));
            let cells = [
                &entry["directory"],
                &entry["name"],
                &entry["seed"],
                &entry["state"],
                &entry["best"],
            ]
            .map(text);
            let [directory, name, seed, state, best] = cells;
            vec![directory, name, seed, state, generations, best, hash]
        })
        .collect();
    let head = ["run", "experiment", "seed", "state", "generations", "best", "result"];
    console.print_answer(&Answer::new(columns(&head, &rows), runs))
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
