//! `oneiro new`: a commented experiment to start from, and the keys that it may have.

use std::fs;
use std::path::Path;

use oneiro::compose;
use oneiro::parameter::nearest;
use oneiro_base::answer::Answer;
use oneiro_base::console::Console;
use oneiro_base::exit::{Failure, Result};
use oneiro_base::files;
use oneiro_base::plain;
use oneiro_lab::experiment::examples::{EXAMPLES, Example};
use oneiro_lab::experiment::reference::{self, Template};
use oneiro_lab::experiment::robots;
use oneiro_lab::experiment::values::instead;
use serde_json::json;

use crate::cli::New;

mod keys;

/// Writes `NAME.toml`, and a file for each part that is named; or an example with its parts; or lists keys.
pub(crate) fn run(arguments: &New, console: Console) -> Result {
    if let Some(part) = &arguments.keys {
        return console.print_answer(&keys::list(part)?);
    }
    match &arguments.example {
        None => template(arguments, console),
        Some(none) if none.is_empty() => console.print_answer(&list()),
        Some(name) => example(name, console),
    }
}

/// Lists the examples.
fn list() -> Answer {
    let width = EXAMPLES.iter().map(|own| own.name.len()).max().unwrap_or_default() + 2;
    let line = |own: &Example| format!("{:<width$}{}\n", own.name, own.about);
    let value = |own: &Example| json!({ "name": own.name, "about": own.about });
    Answer::new(
        EXAMPLES.iter().map(line).collect::<String>(),
        EXAMPLES.iter().map(value).collect(),
    )
}

/// Writes an example and its parts.
fn example(name: &str, console: Console) -> Result {
    let Some(found) = EXAMPLES.iter().find(|own| own.name == name) else {
        let names: Vec<&str> = EXAMPLES.iter().map(|own| own.name).collect();
        let instead = instead(nearest(names.iter().copied(), name), &names.join(", "));
        return Err(Failure::input(format_args!(
            "--example {name}: is unknown{instead}. `oneiro new --swarm NAME` writes the 2014 study's experiment"
        )));
    };
    write(found.files, console)
}

/// Writes an experiment with every value at its default.
fn template(arguments: &New, console: Console) -> Result {
    let given = arguments.name.as_deref().unwrap_or_default();
    let name = plain("NAME", "an experiment", given.strip_suffix(".toml").unwrap_or(given))?;
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
        parts if arguments.forager => Template::Forager(parts),
        [] => Template::Single,
        parts => Template::Own(parts),
    };
    let text = match &arguments.robot {
        Some(robot) => reference::described(name, robots::text(robot)?, &parts),
        None => reference::example(name, template),
    };
    let mut files = vec![(path.clone(), text)];
    files.extend(
        parts
            .iter()
            .map(|(kind, file)| (file.clone(), reference::part(*kind, arguments.forager).to_owned())),
    );
    write(&files, console)
}

/// Writes files, an experiment's first, and says what to do next. Files that are there already, as they would be written, stay:
/// experiments share parts, and a command that was killed goes on.
fn write<Text: AsRef<str>>(all: &[(Text, Text)], console: Console) -> Result {
    let is_new = |(file, text): &&(Text, Text)| !files::is_already(Path::new(file.as_ref()), text.as_ref().as_bytes());
    let new: Vec<_> = all.iter().filter(is_new).collect();
    for (file, _) in &new {
        // Its folder is made.
        files::must_not_exist(Path::new(file.as_ref()))?;
    }
    for (index, (file, text)) in new.iter().enumerate() {
        let path = Path::new(file.as_ref());
        let folder = path.parent().unwrap_or(path);
        // The current directory has no name.
        let made = if folder.as_os_str().is_empty() {
            Ok(())
        } else {
            plain::make_directory(folder).map_err(|error| files::uncreated(folder, &error))
        };
        let written = made.and_then(|()| files::write_new(path, text.as_ref().as_bytes()));
        written.inspect_err(|_| {
            // All or none; the error that follows says what to do.
            for (written, _) in &new[..index] {
                let _ = fs::remove_file(written.as_ref());
            }
            // It stays if it holds anything else.
            let _ = fs::remove_dir(folder);
        })?;
    }
    let path = all[0].0.as_ref();
    let next = format!("next: oneiro check {path}, then oneiro run {path}");
    let names: Vec<&str> = new.iter().map(|(file, _)| file.as_ref()).collect();
    console.say(match &names[..] {
        [] => format!("{path} is already there, as it would be written; {next}"),
        names => format!("wrote {}; {next}", names.join(", ")),
    });
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
