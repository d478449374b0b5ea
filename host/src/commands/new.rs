//! `oneiro new`: a commented experiment to start from.

use std::fs;
use std::path::Path;

use crate::cli::New;
use crate::console::Console;
use crate::exit::{Failure, Result};
use crate::experiment::reference::{self, Kind};
use crate::files;

/// Writes `NAME.toml`, and `TASK.wgsl` if a task is named.
pub(crate) fn run(arguments: &New, console: Console) -> Result {
    let name = plain(
        "NAME",
        "an experiment",
        arguments.name.strip_suffix(".toml").unwrap_or(&arguments.name),
    )?;
    let path = format!("{name}.toml");
    let task = arguments.task.as_ref().map(|task| {
        let task = plain("--task", "a task", task.strip_suffix(".wgsl").unwrap_or(task))?;
        Ok::<_, Failure>(format!("{task}.wgsl"))
    });
    let task = task.transpose()?;
    let kind = match &task {
        Some(part) => Kind::OwnTask(part),
        None if arguments.swarm => Kind::Swarm,
        None => Kind::Single,
    };
    files::write_new(Path::new(&path), reference::example(name, kind).as_bytes())?;
    let mut written = path.clone();
    if let Some(part) = &task {
        files::write_new(Path::new(part), reference::TASK.as_bytes()).inspect_err(|_| {
            // Both or none; the error that follows says what to do.
            let _ = fs::remove_file(&path);
        })?;
        written = format!("{path} and {part}");
    }
    console.say(format!(
        "wrote {written}; next: oneiro check {path}, then oneiro run {path}"
    ));
    Ok(())
}

/// Checks a name that becomes a file's.
fn plain<'a>(argument: &str, what: &str, name: &'a str) -> Result<&'a str> {
    let allowed = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    if name.is_empty() || name.len() > 64 || name.starts_with(['-', '.']) || !name.chars().all(allowed) {
        return Err(Failure::input(format_args!(
            "{argument}: `{name}` can't name {what}; allowed: up to 64 letters, digits, -, _ and ., not beginning with - or ."
        )));
    }
    Ok(name)
}
