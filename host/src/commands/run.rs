//! `oneiro run`: evolves, once or for many seeds.

use std::path::PathBuf;

use super::places::seeds_and_places;
use super::report::{self, Report};
use super::swarm;
use crate::cli;
use crate::console::Console;
use crate::device;
use crate::exit::{Failure, Result};
use crate::experiment::Experiment;
use crate::experiment::swarm::is_swarm;
use crate::record::{Session, Standing, standing};
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
    let mut done = Vec::new();
    let mut new = Vec::new();
    // Nothing begins before every place is known to be free.
    let places = seeds_and_places(arguments, experiment.settings().seed, console, |seed| {
        let identity = experiment.identity(seed).to_hex();
        format!("{}-{seed}-{}", experiment.name(), &identity[..8])
    });
    for (seed, directory) in places {
        match standing(&directory, experiment.identity(seed))? {
            Standing::New => new.push((seed, directory)),
            Standing::Done(result) => done.push(Report::read(&directory, &result)?),
            Standing::Unfinished => {
                let directory = directory.display();
                return Err(Failure::input(format_args!(
                    "{directory}: holds a run that is not finished, and nothing is overwritten; \
                     go on with it: oneiro resume {directory}"
                )));
            }
        }
    }
    if !done.is_empty() {
        console.say(format!(
            "{} of {} runs are done already",
            done.len(),
            done.len() + new.len()
        ));
    }
    if !new.is_empty() {
        let evaluator = device::open(&arguments.backend)?;
        console.say(format!("{} on {}", experiment.name(), device::name(evaluator.as_ref())));
        let session = Session::new(&arguments.backend.name, &evaluator.device());
        let worker = Worker::new(evaluator);
        let mut watcher = Watcher::new(console)?;
        watcher.expect(
            &experiment,
            new.len() as u64 * u64::from(experiment.settings().evolution.generations),
        );
        for wave in new.chunks(LOCKSTEP) {
            let start = |(seed, directory): &(u64, PathBuf)| Run::start(&experiment, *seed, directory, session.clone());
            let runs = wave.iter().map(start).collect::<Result<Vec<_>>>()?;
            let ended = evolve(&experiment, runs, &worker, &mut watcher)?;
            for (run, result) in &ended {
                done.push(Report::new(run, result)?);
            }
        }
        watcher.finish(&worker.close());
    }
    done.sort_by_key(|report| report.seed);
    report::print(&done, arguments.seeds.is_some(), console)
}
