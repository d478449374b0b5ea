//! `oneiro new`: an experiment to start from, and the keys that it may have.

use std::fs;
use std::path::{Path, PathBuf};

use oneiro::compose;
use oneiro::tasks::Ready;
use oneiro_base::answer::Answer;
use oneiro_base::console::Console;
use oneiro_base::exit::{Failure, Result};
use oneiro_base::files;
use oneiro_base::plain;
use oneiro_experiments::{EXAMPLES, Example};
use oneiro_lab::experiment::robots::Shipped;
use oneiro_lab::experiment::start::{Robots, Start};
use serde_json::json;

use crate::cli::New;
use crate::examples;

mod keys;

/// Writes `NAME.toml`, and a file for each named part; or an example with its parts; or lists keys.
pub(crate) fn run(arguments: &New, console: Console) -> Result {
    if let Some(part) = &arguments.keys {
        return console.print_answer(&keys::list(part)?);
    }
    match &arguments.example {
        None => template(arguments, console),
        Some(none) if none.is_empty() => console.print_answer(&list()),
        Some(name) => example(name, arguments.out.as_deref(), console),
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
fn example(name: &str, out: Option<&Path>, console: Console) -> Result {
    let found = examples::named("--example", name, |_| true)?;
    write(
        found.files,
        out,
        if found.is_sweep() { SWEEP } else { EXPERIMENT },
        console,
    )
}

/// The robot of a task that is copied, unless --robot names another: one whose sensors the task may need.
const OF_TASK: &str = "epuck";
/// The robot of a swarm, unless --robot names another.
const OF_SWARM: &str = "epuck-rm1.1";

/// Writes an experiment to start from.
fn template(arguments: &New, console: Console) -> Result {
    let given = arguments.name.as_deref().unwrap_or_default();
    let name = plain("NAME", "an experiment", given.strip_suffix(".toml").unwrap_or(given))?;
    let task = arguments.task.as_deref().filter(|_| !arguments.forager);
    let ready = task.and_then(|task| Ready::named(task.strip_suffix(".wgsl").unwrap_or(task)));
    not_another_task(arguments)?;
    let is_for_swarms = ready.is_some_and(Ready::is_for_swarms);
    // Robots with a reference model have no pucks.
    let has_pucks = ready.is_some_and(Ready::has_pucks);
    let of_task = ready.map(|_| if is_for_swarms && !has_pucks { OF_SWARM } else { OF_TASK });
    let robot = arguments
        .robot
        .as_deref()
        .or((arguments.swarm && !has_pucks).then_some(OF_SWARM))
        .or(of_task);
    let robots = match robot.map(Shipped::named).transpose()? {
        Some(robot) if (arguments.swarm || is_for_swarms) && !robot.may_swarm() => {
            return Err(Failure::input(format_args!(
                "--robot {}: is too fast for a swarm; allowed in swarms: robots that move at most 0.75 of their radius in a cycle",
                robot.name
            )));
        }
        Some(robot) if has_pucks && robot.is_for_swarms() => {
            return Err(Failure::input(format_args!(
                "--robot {}: has a reference model, and no pucks; allowed: robots without",
                robot.name
            )));
        }
        Some(robot) if arguments.swarm || is_for_swarms || robot.is_for_swarms() => Robots::Swarm(robot),
        Some(robot) => Robots::Parametric(robot),
        None if arguments.forager => Robots::Forager,
        None => Robots::Khepera,
    };
    let is_swarm = matches!(robots, Robots::Swarm(_));
    let mut parts = Vec::new();
    for (kind, part) in [
        (compose::Kind::Sensor, arguments.sensor.as_deref()),
        (compose::Kind::Controller, arguments.controller.as_deref()),
        (
            compose::Kind::Task,
            arguments.task.as_deref().or(is_swarm.then_some(name)),
        ),
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
    let start = Start { name, robots, parts };
    let text = if arguments.all_keys {
        start.whole()
    } else {
        start.short()
    };
    let mut files = vec![(format!("{name}.toml"), text)];
    files.extend(
        start
            .parts
            .iter()
            .map(|(kind, file)| (file.clone(), start.part(*kind).to_owned())),
    );
    write(&files, arguments.out.as_deref(), EXPERIMENT, console)
}

/// Tasks that are part of the kernels that ship.
const WITHOUT_FILE: [&str; 2] = ["avoidance", "foraging"];

/// A file that is called after a task of Oneiro has that task, and no other.
fn not_another_task(arguments: &New) -> Result {
    let Some(task) = arguments.task.as_deref() else {
        return Ok(());
    };
    let word = task.strip_suffix(".wgsl").unwrap_or(task);
    let problem = if Ready::named(word).is_some() && arguments.forager {
        "is no task of foragers; allowed with --forager: another name, for a custom task"
    } else if WITHOUT_FILE.contains(&word) {
        "has no file in WGSL; allowed: task.kind in an experiment, or another name for a custom task"
    } else {
        return Ok(());
    };
    Err(Failure::input(format_args!("--task {task}: {problem}")))
}

/// The commands that check an experiment and run it.
const EXPERIMENT: [&str; 2] = ["check", "run"];
/// Those of a sweep.
const SWEEP: [&str; 2] = ["sweep plan", "sweep run"];

/// Writes files into a folder, an experiment's or a sweep's first, and says what to do next. Files that are already there with the same bytes stay:
/// experiments share parts, and a command that was killed goes on.
fn write<Name: AsRef<str>, Content: AsRef<[u8]>>(
    all: &[(Name, Content)],
    out: Option<&Path>,
    [check, run]: [&str; 2],
    console: Console,
) -> Result {
    let out = out.unwrap_or(Path::new(""));
    let all: Vec<(PathBuf, &[u8])> = all
        .iter()
        .map(|(file, content)| (out.join(file.as_ref()), content.as_ref()))
        .collect();
    let is_new = |(path, content): &&(PathBuf, &[u8])| !files::is_already(path, content);
    let new: Vec<_> = all.iter().filter(is_new).collect();
    for (path, _) in &new {
        // Its folder is made.
        files::must_not_exist(path).map_err(|failure| failure.and_say(", or write into another folder: --out DIR"))?;
    }
    for (index, (path, content)) in new.iter().enumerate() {
        let folder = path.parent().unwrap_or(path);
        // The current directory has no name.
        let made = if folder.as_os_str().is_empty() {
            Ok(())
        } else {
            plain::make_directory(folder).map_err(|error| files::uncreated(folder, &error))
        };
        let written = made.and_then(|()| files::write_new(path, content));
        written.inspect_err(|_| {
            // All or none; the error that follows says what to do.
            for (written, _) in &new[..index] {
                let _ = fs::remove_file(written);
            }
            // It stays if it holds anything else.
            let _ = fs::remove_dir(folder);
        })?;
    }
    let path = files::for_shell(&all[0].0.display().to_string());
    let next = format!("next: oneiro {check} {path}, then oneiro {run} {path}");
    let names: Vec<String> = new.iter().map(|(path, _)| path.display().to_string()).collect();
    console.say(match &names[..] {
        [] => format!("{path} is already there, unchanged; {next}"),
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
