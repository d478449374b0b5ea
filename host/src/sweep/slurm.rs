//! Slurm: a job array that does a sweep, and which shard a task of one is.

use std::env;

use crate::cli::SweepRun;
use crate::console::Console;
use crate::exit::{Failure, Result};
use super::store::Shard;

/// The job array.
pub(crate) fn script(_arguments: &SweepRun) -> Result<String> {
    Err(Failure::failed("not yet"))
}

/// The shard of the array's task that this process is, if it is one: tasks are numbered from any number on, without
/// gaps.
///
/// # Errors
/// Exit 3 when the tasks' numbers have gaps.
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
    if greatest.checked_sub(least).is_none_or(|span| span + 1 != count) || !(least..=greatest).contains(&task) {
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
