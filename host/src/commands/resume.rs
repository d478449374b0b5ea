//! `oneiro resume`: resumes runs that were stopped or killed.

use std::path::PathBuf;

use oneiro_base::console::Console;
use oneiro_base::exit::Result;
use oneiro_base::files;
use oneiro_lab::record::{Done, RunPlace, SavedRun};

use super::list;
use super::places::{RUNS, already_done, named_or_newest};
use super::report::{self, Report};
use super::run::run_all;
use crate::cli;

/// Resumes a run, or all runs of a directory, from their last good checkpoints.
pub(crate) fn run(arguments: &cli::Resume, console: Console) -> Result {
    let named = named_or_newest(arguments.run_dir.as_deref(), &[RUNS], console)?;
    let directories = list::runs(&named)?;
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
