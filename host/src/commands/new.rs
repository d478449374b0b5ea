//! `oneiro new`: a commented experiment to start from.

use std::fs;
use std::path::Path;

use oneiro::compose;

use crate::cli::New;
use crate::console::Console;
use crate::exit::{Failure, Result};
use crate::experiment::reference::{self, Template};
use crate::files;

/// Writes `NAME.toml`, and a file for each part that is named.
pub(crate) fn run(arguments: &New, console: Console) -> Result {
    let name = plain(
        "NAME",
        "an experiment",
        arguments.name.strip_suffix(".toml").unwrap_or(&arguments.name),
    )?;
    let path = format!("{name}.toml");
    let mut parts = Vec::new();
    for (kind, part) in [
        (compose::Kind::Sensor, &arguments.sensor),
        (compose::Kind::Controller, &arguments.controller),
        (compose::Kind::Task, &arguments.task),
    ] {
        if let Some(part) = part {
            let word = kind.word();
            let stem = part.strip_suffix(".wgsl").unwrap_or(part);
            let file = format!("{}.wgsl", plain(&format!("--{word}"), &format!("a {word}"), stem)?);
            if parts.iter().any(|(_, other)| *other == file) {
                let problem = format!("--{word}: {file} is named twice; allowed: a file for each part");
                return Err(Failure::input(problem));
            }
            parts.push((kind, file));
        }
    }
    let template = match &parts[..] {
        [] if arguments.swarm => Template::Swarm,
        [] => Template::Single,
        parts => Template::Own(parts),
    };
    let mut files = vec![(path.clone(), reference::example(name, template))];
    files.extend(
        parts
            .iter()
            .map(|(kind, file)| (file.clone(), reference::part(*kind).to_owned())),
    );
    for (index, (file, text)) in files.iter().enumerate() {
        files::write_new(Path::new(file), text.as_bytes()).inspect_err(|_| {
            // All or none; the error that follows says what to do.
            for (written, _) in &files[..index] {
                let _ = fs::remove_file(written);
            }
        })?;
    }
    let written: Vec<&str> = files.iter().map(|(file, _)| file.as_str()).collect();
    console.say(format!(
        "wrote {}; next: oneiro check {path}, then oneiro run {path}",
        written.join(", ")
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
