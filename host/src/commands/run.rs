//! `oneiro run`: evolves, once or for many seeds.

use std::path::PathBuf;

use super::places::{Places, seeds_and_places, sorted_out};
use super::report::{self, Report};
use super::swarm;
use crate::cli;
use crate::console::Console;
use crate::device;
use crate::exit::Result;
use crate::experiment::Experiment;
use crate::experiment::swarm::is_swarm;
use crate::record::{Done, Session};
use crate::run::{LOCKSTEP, Run, evolve};
use crate::watcher::Watcher;
use crate::worker::Worker;

/// Runs the experiment for each seed; what is done already is not done again.
pub(crate) fn run(arguments: &cli::Run, console: Console) -> Result {
    if is_swarm(&arguments.experiment)? {
        return swarm::run(arguments, console);
    }
    let experiment = Experiment::read(&arguments.experiment, &arguments.set)?;
    for warning in experiment.warnings() {
        console.say(format!("warning: {warning}"));
    }
    let places = seeds_and_places(arguments, experiment.settings().seed, console, |seed| {
        let identity = experiment.identity(seed).to_hex();
        format!("{}-{seed}-{}", experiment.name(), &identity[..8])
    });
    let Places { done, new } = sorted_out(places, |seed| experiment.identity(seed), console)?;
    let read = |(_, directory, result): &(u64, PathBuf, Done)| Report::read(directory, result);
    let mut done = done.iter().map(read).collect::<Result<Vec<_>>>()?;
    done.extend(evolved(&experiment, &new, &arguments.backend, console)?);
    done.sort_by_key(|report| report.seed);
    report::print(&done, arguments.seeds.is_some(), console)
}

/// Does runs from seeds, each in a directory of its own.
pub(super) fn evolved(
    experiment: &Experiment,
    runs: &[(u64, PathBuf)],
    backend: &cli::Backend,
    console: Console,
) -> Result<Vec<Report>> {
    let mut done = Vec::new();
    if runs.is_empty() {
        return Ok(done);
    }
    let evaluator = device::open(backend)?;
    console.say(format!("{} on {}", experiment.name(), device::name(evaluator.as_ref())));
    let session = Session::new(&backend.name, &evaluator.device());
    let worker = Worker::new(evaluator);
    let mut watcher = Watcher::new(console)?;
    watcher.expect(
        experiment,
        runs.len() as u64 * u64::from(experiment.settings().evolution.generations),
    );
    for wave in runs.chunks(LOCKSTEP) {
        let start = |(seed, directory): &(u64, PathBuf)| Run::start(experiment, *seed, directory, session.clone());
        let runs = wave.iter().map(start).collect::<Result<Vec<_>>>()?;
        let ended = evolve(experiment, runs, &worker, &mut watcher)?;
        for (run, result) in &ended {
            done.push(Report::new(run, result)?);
        }
    }
    watcher.finish(&worker.close());
    Ok(done)
}
