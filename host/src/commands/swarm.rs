//! What `run`, `resume`, `replay`, `audit` and `check` do for experiments with a swarm.

use std::fs;
use std::path::{Path, PathBuf};

use oneiro::swarm::SECOND;
use serde::Serialize;
use serde_json::json;

use super::places::{Places, seeds_and_places, sorted_out};
use crate::cli;
use crate::console::{Console, columns};
use crate::device;
use crate::evaluations::Evaluations;
use crate::exit::{Code, Failure, Result};
use crate::experiment::swarm::SwarmExperiment;
use crate::progress;
use crate::record::{Done, SavedSwarm, Session, SwarmRecorder, write_whole};
use crate::report::figures::{self, Genes, SwarmReplay};
use crate::run::LOCKSTEP;
use crate::swarm::job::SwarmJob;
use crate::swarm::lived::Run;
use crate::swarm::{drive, live, steps};
use crate::watcher::stop_signal;

/// A finished run in a few values.
#[derive(Debug, Serialize)]
pub(super) struct Report {
    directory: PathBuf,
    seed: u64,
    /// Food that the swarm brought in all; none for a run that was done before.
    brought: Option<u32>,
    /// The result's hash.
    pub(super) result: String,
}

/// Runs the experiment for each seed; what is done already is not done again.
pub(super) fn run(arguments: &cli::Run, console: Console) -> Result {
    let experiment = SwarmExperiment::read(&arguments.experiment, &arguments.set)?;
    let places = seeds_and_places(arguments, experiment.seed(), console, |seed| {
        format!(
            "{}-{seed}-{}",
            experiment.name(),
            &experiment.identity(seed).to_hex()[..8]
        )
    });
    let Places { done: kept, new } = sorted_out(places, |seed| experiment.identity(seed), console)?;
    let known = |(seed, directory, done): &(u64, PathBuf, Done)| report(directory, *seed, None, done);
    let mut reports: Vec<Report> = kept.iter().map(known).collect();
    let runs = new
        .iter()
        .map(|(seed, directory)| (&experiment, *seed, directory.as_path()));
    reports.extend(done(&runs.collect::<Vec<_>>(), &arguments.backend, console)?);
    reports.sort_by_key(|report| report.seed);
    print(&reports, arguments.seeds.is_some(), console)
}

/// Does runs again that were stopped.
pub(super) fn resume(directories: &[PathBuf], backend: &cli::Backend, console: Console) -> Result {
    let mut reports = Vec::new();
    let mut saved = Vec::new();
    for directory in directories {
        let run = SavedSwarm::open(directory)?;
        match Done::read(directory)? {
            Some(done) => reports.push(report(directory, run.seed(), None, &done)),
            None => saved.push(run),
        }
    }
    let runs = saved.iter().map(|run| (run.experiment(), run.seed(), run.directory()));
    reports.extend(done(&runs.collect::<Vec<_>>(), backend, console)?);
    reports.sort_by(|a, b| a.directory.cmp(&b.directory));
    print(&reports, directories.len() > 1, console)
}

/// Does runs, those that last equally long in lockstep.
pub(super) fn done(
    runs: &[(&SwarmExperiment, u64, &Path)],
    backend: &cli::Backend,
    console: Console,
) -> Result<Vec<Report>> {
    let mut reports = Vec::new();
    if runs.is_empty() {
        return Ok(reports);
    }
    let evaluator = device::open(backend)?;
    console.say(format!("{} on {}", runs[0].0.name(), device::name(evaluator.as_ref())));
    let session = Session::new(&backend.name, &evaluator.device());
    let evaluations = Evaluations::new(evaluator, stop_signal()?);
    let all: u64 = runs
        .iter()
        .map(|(experiment, seed, _)| steps(&experiment.plan(*seed)))
        .sum();
    progress::watched(all, "foraging", console, &evaluations.control, || -> Result {
        let pace = |(experiment, ..): &(&SwarmExperiment, u64, &Path)| {
            let own = experiment.settings();
            (own.minutes, own.clock.clone())
        };
        for alike in runs
            .chunk_by(|a, b| pace(a) == pace(b))
            .flat_map(|alike| alike.chunks(LOCKSTEP))
        {
            let mut recorders = alike
                .iter()
                .map(|(experiment, seed, directory)| {
                    SwarmRecorder::begin(directory, experiment, *seed, session.clone())
                })
                .collect::<Result<Vec<_>>>()?;
            let plans: Vec<_> = alike
                .iter()
                .map(|(experiment, seed, _)| experiment.plan(*seed))
                .collect();
            let lived = live(&plans, &|batch| evaluations.evaluate(batch));
            let lived = match lived {
                Ok(lived) => lived,
                Err(failure) => {
                    for recorder in &mut recorders {
                        recorder.stop()?;
                    }
                    return Err(failure);
                }
            };
            for ((recorder, run), (_, seed, _)) in recorders.iter_mut().zip(&lived).zip(alike) {
                let done = recorder.finish(run)?;
                reports.push(report(recorder.directory(), *seed, Some(run), &done));
            }
        }
        Ok(())
    })?;
    device::tell_warnings(evaluations.close().as_ref(), console);
    Ok(reports)
}

fn report(directory: &Path, seed: u64, run: Option<&Run>, done: &Done) -> Report {
    Report {
        directory: directory.to_owned(),
        seed,
        brought: run.map(Run::total),
        result: done.result.clone(),
    }
}

fn print(reports: &[Report], as_list: bool, console: Console) -> Result {
    let food = |report: &Report| report.brought.map_or_else(|| "-".to_owned(), |food| food.to_string());
    match reports {
        [report] if !as_list && console.json() => console.json_data(report),
        _ if console.json() => console.json_data(&reports),
        [report] if !as_list => console.data(format!(
            "food    {}\nresult  {}\nrun     {}",
            food(report),
            report.result,
            report.directory.display()
        )),
        _ => {
            let row = |report: &Report| {
                let hash = report.result.chars().take(12).collect();
                vec![
                    report.directory.display().to_string(),
                    report.seed.to_string(),
                    food(report),
                    hash,
                ]
            };
            let rows: Vec<Vec<String>> = reports.iter().map(row).collect();
            console.data(columns(&["run", "seed", "food", "result"], &rows))
        }
    }
}

/// Runs a swarm again and compares it with what was recorded. The device, the swarm, and its run.
fn again(saved: &SavedSwarm, backend: &cli::Backend, console: Console) -> Result<(String, SwarmJob, Run)> {
    saved.is_done()?;
    let evaluator = device::open(backend)?;
    let name = device::name(evaluator.as_ref());
    let evaluations = Evaluations::new(evaluator, stop_signal()?);
    let plan = saved.experiment().plan(saved.seed());
    let all = steps(&plan);
    let mut job = SwarmJob::new(plan).keeping_lines();
    progress::watched(all, "foraging", console, &evaluations.control, || {
        drive(std::slice::from_mut(&mut job), &|batch| evaluations.evaluate(batch))
    })?;
    let run = job.run();
    device::tell_warnings(evaluations.close().as_ref(), console);
    saved.compare(&run)?;
    Ok((name, job, run))
}

/// Lives a run again and writes a page that plays it.
pub(super) fn replay(arguments: &cli::Replay, console: Console) -> Result {
    let saved = SavedSwarm::open(&arguments.run_dir)?;
    let (device, job, run) = again(&saved, &arguments.backend, console)?;
    let settings = saved.experiment().settings();
    let genes: Vec<Vec<Genes>> = (0..run.intervals.first().map_or(0, Vec::len))
        .map(|robot| {
            let clock = settings.clock.interval_s;
            let of = |(interval, robots): (usize, &Vec<_>)| {
                let own: &crate::swarm::lived::RobotInterval = &robots[robot];
                Genes {
                    cycle: SECOND * (u32::from(run.switched_on[robot]) + interval as u32 * clock),
                    s0: own.s0,
                    g0: own.g0,
                    g1: own.g1,
                }
            };
            run.intervals.iter().enumerate().map(of).collect()
        })
        .collect();
    let page = figures::swarm_page(&SwarmReplay {
        title: &format!("{}, seed {}", saved.experiment().name(), saved.seed()),
        swarm: &settings.swarm(),
        lamp: saved.experiment().plan(saved.seed()).lamp(),
        every: SECOND,
        lines: job.lines(),
        genes: &genes,
    });
    let directory = arguments.out.as_deref().unwrap_or(saved.directory());
    fs::create_dir_all(directory).map_err(|error| Failure::unreadable(directory, &error))?;
    let path = directory.join("replay.html");
    write_whole(&path, page.as_bytes())?;
    if console.json() {
        return console.json_data(&json!({
            "brought": run.total(),
            "page": path.display().to_string(),
            "device": device,
        }));
    }
    console.data(format!("food {}, as recorded\n{}", run.total(), path.display()))
}

/// Lives whole runs again and says whether they are what was recorded; fails if one is not.
pub(super) fn audit(directories: &[PathBuf], backend: &cli::Backend, console: Console) -> Result {
    let mut audited = Vec::new();
    let mut others = Vec::new();
    for directory in directories {
        let mut entry = json!({ "directory": directory.display().to_string() });
        match again(&SavedSwarm::open(directory)?, backend, console) {
            Ok((device, ..)) => {
                if !console.json() {
                    console.data(format!("{}: as recorded, all of it, on {device}", directory.display()))?;
                }
                entry["device"] = device.into();
            }
            Err(failure) if failure.code() == Code::Failed as u8 => {
                entry["problem"] = failure.to_string().into();
                others.push(failure.to_string());
            }
            Err(failure) => return Err(failure),
        }
        audited.push(entry);
    }
    if console.json() {
        console.json_data(&audited)?;
    }
    if others.is_empty() {
        return Ok(());
    }
    Err(Failure::failed(others.join("; ")))
}

/// What an experiment amounts to.
pub(super) fn check(arguments: &cli::Check, console: Console) -> Result {
    let experiment = SwarmExperiment::read(&arguments.experiment, &arguments.set)?;
    let settings = experiment.settings();
    let work = steps(&experiment.plan(0));
    if arguments.out.is_some() {
        return Err(Failure::usage("--out: an arena of a swarm is drawn by `oneiro replay`"));
    }
    if console.json() {
        return console.json_data(&json!({
            "name": experiment.name(),
            "robot_steps": work,
            "settings": settings,
        }));
    }
    console.data(format!(
        "{} is valid\n  case        {}\n  robots      {}, for {} minutes\n  arena       radius {} mm\n  work        {:.1} \
         million robot-steps a run",
        experiment.name(),
        settings.case.title(),
        settings.robots,
        settings.minutes,
        settings.arena.radius_mm,
        work as f64 / 1e6
    ))
}
