//! Slurm: a job array that does a sweep, and the shard of each of its tasks.

use std::env;
use std::path::{Path, absolute};
use std::time::Duration;

use oneiro_base::console::{Console, counted};
use oneiro_base::exit::{Failure, Result};
use oneiro_base::files::for_shell;
use oneiro_base::program;
use oneiro_lab::sweep::Sweep;
use oneiro_lab::sweep::store::Shard;

use super::sweep::directory;
use crate::cli::SweepRun;

/// The script, with names in braces as placeholders.
const SCRIPT: &str = include_str!("slurm.sh");
/// Tasks without `--shards`.
const SHARDS: u32 = 8;
/// Processors per task without `--threads`.
const PROCESSORS: u16 = 4;
/// Time limit of a task without `--time-budget`: the limit of many clusters.
const LONGEST: Duration = Duration::from_hours(24);
/// Time that a task gets to stop, after a signal or the end of its budget.
const STOPPING: Duration = Duration::from_mins(2);

/// The job array that does a sweep in as many shards as the command line says, at most one for each run.
///
/// # Errors
/// Exit 6 if this directory has no name.
pub(crate) fn script(sweep: &Sweep, arguments: &SweepRun, console: Console) -> Result<String> {
    let runs = u32::try_from(sweep.runs()).unwrap_or(u32::MAX);
    if let Some(shards) = arguments.shards.filter(|shards| *shards > runs) {
        console.say(format!(
            "warning: --shards {shards}: the sweep has {}, so the array has no more tasks than that",
            counted(runs, "run", "runs")
        ));
    }
    let shards = arguments.shards.unwrap_or(SHARDS).min(runs);
    let whole = |path: &Path| match absolute(path) {
        Ok(path) => Ok(for_shell(&path.display().to_string())),
        Err(error) => Err(Failure::storage(path, &error)),
    };
    let program = match program::path() {
        Ok(program) => whole(&program)?,
        Err(error) => return Err(Failure::storage(Path::new("oneiro"), &error)),
    };
    let out = whole(&directory(arguments, sweep))?;
    let backend = &arguments.backend;
    let mut command = vec![
        program.clone(),
        "sweep run".into(),
        whole(&arguments.sweep)?,
        "--out".into(),
        out.clone(),
    ];
    let mut option = |name: &str, value: String| command.push(format!("{name} {}", for_shell(&value)));
    option("--backend", backend.name.clone());
    option("--recheck", backend.recheck.to_string());
    option("--checkpoint-every", seconds(arguments.checkpoint_every));
    if let Some(budget) = arguments.time_budget {
        option("--time-budget", seconds(budget));
    }
    if let Some(jobs) = arguments.jobs {
        option("--jobs", jobs.to_string());
    }
    if arguments.yes {
        command.push("--yes".into());
    }
    let limit = arguments.time_budget.map_or(LONGEST, |budget| budget + 2 * STOPPING);
    let values = [
        ("{name}", sweep.name().to_owned()),
        ("{shards}", shards.to_string()),
        ("{cpus}", backend.threads.unwrap_or(PROCESSORS).to_string()),
        ("{time}", clock(limit)),
        ("{signal}", STOPPING.as_secs().to_string()),
        ("{folder}", folder()?),
        ("{command}", command.join(" ")),
        ("{merge}", format!("{program} sweep merge {out}")),
    ];
    Ok(values
        .iter()
        .fold(SCRIPT.to_owned(), |script, (name, value)| script.replace(name, value)))
}

/// Directory of the tasks' logs: the one where the script was made.
fn folder() -> Result<String> {
    env::current_dir()
        .map(|folder| folder.display().to_string())
        .map_err(|error| Failure::storage(Path::new("."), &error))
}

fn seconds(time: Duration) -> String {
    format!("{}s", time.as_secs_f64())
}

/// Formats a time for Slurm, rounded up to minutes.
fn clock(time: Duration) -> String {
    let minutes = time.as_secs().div_ceil(60);
    format!("{}:{:02}:00", minutes / 60, minutes % 60)
}

/// The shard of the array task that this process is, if it is one. Tasks may be numbered from any number on, without
/// gaps.
///
/// # Errors
/// Exit 3 if the tasks' numbers have gaps.
pub(crate) fn shard(console: Console) -> Result<Option<Shard>> {
    let number = |name: &str| env::var(name).ok().and_then(|text| text.parse::<u32>().ok());
    let Some(task) = number("SLURM_ARRAY_TASK_ID") else {
        return Ok(None);
    };
    let (least, greatest, count) = (
        number("SLURM_ARRAY_TASK_MIN").unwrap_or(1),
        number("SLURM_ARRAY_TASK_MAX").unwrap_or(task),
        number("SLURM_ARRAY_TASK_COUNT").unwrap_or(1),
    );
    let has_gaps = greatest
        .checked_sub(least)
        .is_none_or(|span| span.checked_add(1) != Some(count));
    if has_gaps || !(least..=greatest).contains(&task) {
        return Err(Failure::input(format_args!(
            "SLURM_ARRAY_TASK_ID is {task} of {count} tasks from {least} to {greatest}; allowed: an array without gaps, \
             or --shard I/N"
        )));
    }
    let shard = Shard {
        index: task - least + 1,
        of: count,
    };
    console.say(format!("shard {shard}, by SLURM_ARRAY_TASK_ID"));
    Ok(Some(shard))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_written_for_shells_and_slurm() {
        assert_eq!(clock(Duration::from_hours(2)), "2:00:00");
        assert_eq!(clock(Duration::from_secs(61)), "0:02:00");
        assert_eq!(clock(Duration::from_hours(100)), "100:00:00");
        assert_eq!(seconds(Duration::from_millis(1500)), "1.5s");
    }
}
