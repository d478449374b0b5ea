//! `oneiro resume`: resumes runs that were stopped or killed.

use std::path::PathBuf;

use oneiro_base::console::Console;
use oneiro_base::exit::Result;
use oneiro_base::files;
use oneiro_lab::record::{self, Budget, Done, Extension, RunPlace, SavedRun};

use super::list;
use super::places::{RUNS, already_done, named_or_newest};
use super::report::{self, Report};
use super::run::run_all;
use crate::cli;

/// Gives runs the larger budget of the command line, once all of them can have it.
fn extend(arguments: &cli::Resume, directories: &[PathBuf], console: Console) -> Result {
    for directory in directories {
        record::complete(directory)?;
    }
    let generations = arguments.generations.map(Budget::Generations);
    let Some(budget) = generations.or(arguments.episodes.map(Budget::Episodes)) else {
        return Ok(());
    };
    let extensions = directories.iter().map(|directory| Extension::of(directory, budget));
    let extensions = extensions.collect::<Result<Vec<_>>>()?;
    for extension in extensions.iter().flatten() {
        console.say(extension.make()?);
    }
    Ok(())
}

/// Resumes a run, or all runs of a directory, from their last good checkpoints.
pub(crate) fn run(arguments: &cli::Resume, console: Console) -> Result {
    let named = named_or_newest(arguments.run_dir.as_deref(), &[RUNS], console)?;
    let directories = list::runs(&named)?;
    extend(arguments, &directories, console)?;
    let mut done = Vec::new();
    let mut saved = Vec::new();
    for directory in &directories {
        let run = SavedRun::open(directory)?;
        match run.done()? {
            Some(result) => done.push((directory.clone(), result)),
            None => saved.push(RunPlace::Saved(run)),
        }
    }
    if !done.is_empty() {
        already_done(done.len(), directories.len(), console);
    }
    let resumed = run_all(saved, "resuming", &arguments.backend, console)?;
    let read = |(directory, done): &(PathBuf, Done)| Report::read(directory, done);
    let mut reports = done.iter().map(read).collect::<Result<Vec<_>>>()?;
    reports.extend(resumed);
    reports.sort_by(|a, b| files::by_numbers(&a.directory, &b.directory));
    report::print(&reports, directories.len() > 1, console)
}
