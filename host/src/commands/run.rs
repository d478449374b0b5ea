//! `oneiro run`: runs an experiment, once or for many seeds.

use std::path::PathBuf;

use oneiro_base::console::Console;
use oneiro_base::exit::Result;
use oneiro_lab::device;
use oneiro_lab::engine::watcher::Watcher;
use oneiro_lab::record::{Directories, Done, RunPlace, Session};
use oneiro_lab::runs;

use super::places::{Places, seeds_and_places, sorted_out};
use super::report::{self, Report};
use super::watch::Page;
use crate::COMMIT;
use crate::cli;

/// Runs the experiment for each seed, except for finished runs.
pub(crate) fn run(arguments: &cli::Run, console: Console) -> Result {
    let experiment = runs::read(&arguments.experiment, &arguments.set)?;
    console.warn(experiment.warnings());
    if let Some(budget) = experiment.budget() {
        console.say(budget);
    }
    let (places, drawn) = seeds_and_places(arguments, &*experiment);
    let Places { done, todo } = sorted_out(places, &experiment, console)?;
    let title = match drawn {
        None => experiment.name().to_owned(),
        Some(seed) => format!("{}, seed {seed} (drawn),", experiment.name()),
    };
    let directories = todo
        .iter()
        .map(RunPlace::directory)
        .chain(done.iter().map(|(directory, _)| &**directory));
    let _page = Page::beside(&arguments.beside, directories, console)?;
    let new = run_all(todo, &title, &arguments.backend, console)?;
    let read = |(directory, done): &(PathBuf, Done)| Report::read(directory, done);
    let mut reports = done.iter().map(read).collect::<Result<Vec<_>>>()?;
    reports.extend(new);
    reports.sort_by_key(|report| report.seed);
    report::print(&reports, arguments.seeds.is_some(), console)
}

/// Does runs, each in its own directory.
pub(super) fn run_all(
    places: Vec<RunPlace>,
    title: &str,
    backend: &cli::Backend,
    console: Console,
) -> Result<Vec<Report>> {
    if places.is_empty() {
        return Ok(Vec::new());
    }
    let engine = backend.engine()?;
    console.say(format!("{title} on {}", engine.name()));
    let session = Session::new(COMMIT, &backend.name, engine.description());
    let mut runs = Directories::new(places, session, console);
    let mut watcher = Watcher::new(runs.steps(), "", None, console.bars());
    engine.run(runs.waiting(), Directories::MOST, &mut runs, &mut watcher)?;
    drop(watcher);
    let specialised = device::close(engine, console);
    let report =
        |(directory, done): (PathBuf, Done)| Report::read(&directory, &done).map(|report| report.run_now(specialised));
    runs.done().into_iter().map(report).collect()
}
