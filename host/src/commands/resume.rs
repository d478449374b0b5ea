//! `oneiro resume`: goes on with runs that were stopped or killed.

use std::collections::BTreeMap;

use super::list;
use super::report::{self, Report};
use super::swarm;
use crate::cli;
use crate::console::Console;
use crate::device;
use crate::exit::Result;
use crate::record::{Done, SavedRun, Session, is_swarm_run};
use crate::run::{LOCKSTEP, Run, evolve};
use crate::watcher::Watcher;
use crate::worker::Worker;

/// Goes on with a run, or with all runs of a directory, from their last good checkpoints.
pub(crate) fn run(arguments: &cli::Resume, console: Console) -> Result {
    let (swarms, directories): (Vec<_>, Vec<_>) = list::runs(&arguments.run_dir)?
        .into_iter()
        .partition(|directory| is_swarm_run(directory));
    if !swarms.is_empty() {
        swarm::resume(&swarms, &arguments.backend, console)?;
        if directories.is_empty() {
            return Ok(());
        }
    }
    let mut done = Vec::new();
    // Runs of one experiment share batches.
    let mut groups: BTreeMap<String, Vec<SavedRun>> = BTreeMap::new();
    for directory in &directories {
        if let Some(result) = Done::read(directory)? {
            done.push(Report::read(directory, &result)?);
        } else {
            let run = SavedRun::open(directory)?;
            groups.entry(run.experiment().resolved_toml(0)).or_default().push(run);
        }
    }
    if !done.is_empty() {
        console.say(format!("{} of {} runs are done already", done.len(), directories.len()));
    }
    if !groups.is_empty() {
        let evaluator = device::open(&arguments.backend)?;
        console.say(format!("resuming on {}", device::name(evaluator.as_ref())));
        let session = Session::new(&arguments.backend.name, &evaluator.device());
        let worker = Worker::new(evaluator);
        let mut watcher = Watcher::new(console)?;
        for wave in groups.values().flat_map(|group| group.chunks(LOCKSTEP)) {
            let experiment = wave[0].experiment();
            let mut runs = Vec::with_capacity(wave.len());
            for saved in wave {
                let (run, problems) = Run::resume(saved, session.clone())?;
                for problem in problems {
                    console.say(format!("warning: {problem}"));
                }
                let generations = experiment.settings().evolution.generations;
                watcher.expect(experiment, u64::from(generations - run.evolution().generation()));
                runs.push(run);
            }
            let ended = evolve(experiment, runs, &worker, &mut watcher)?;
            for (run, result) in &ended {
                done.push(Report::new(run, result)?);
            }
        }
        watcher.finish(&worker.close());
    }
    done.sort_by(|a, b| a.directory.cmp(&b.directory));
    report::print(&done, directories.len() > 1, console)
}
