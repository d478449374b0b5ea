//! `oneiro replay` for a swarm: a page that plays it.

use oneiro::swarm::SECOND;
use oneiro_base::answer::Answer;
use oneiro_base::console::Bars;
use oneiro_base::disk;
use oneiro_base::exit::{Failure, Result};
use oneiro_base::plain;
use oneiro_report::figures::{self, BEHAVIOURS, ForagersReplay, Genes, Teller};
use serde_json::json;

use super::{REPLAY, again, difference};
use crate::engine::handle::Engine;
use crate::experiment::swarm::SwarmExperiment;
use crate::runs::{Recorded, Replay};
use crate::swarm::record::RobotInterval;

/// Repeats a finished run and writes a page that plays it.
pub(super) fn run(
    experiment: &SwarmExperiment,
    recorded: &Recorded<'_>,
    replay: &Replay<'_>,
    engine: &Engine,
    bars: Bars,
) -> Result<Answer> {
    // A typed value that equals the default can't be told from it.
    let given = [
        ("--start", replay.start.is_some()),
        ("--seed", replay.seed.is_some()),
        ("--genome", replay.genome.is_some()),
        ("--elite", replay.elite.is_some()),
        ("--elites", replay.elites),
        ("--generation", replay.generation.is_some()),
        ("--generations", !replay.generations.is_empty()),
        ("--robot", replay.surrogate.is_some()),
        ("--trial", replay.trial != 0),
        ("--every", replay.every != 1),
        ("--picture", replay.picture.is_some()),
        ("--film", replay.film.is_some()),
    ];
    if let Some((option, _)) = given.into_iter().find(|(_, is_given)| *is_given) {
        return Err(Failure::usage(format_args!(
            "{option}: is given for the foraging study, which is replayed whole; allowed: with runs that have a champion"
        )));
    }
    let job = again(experiment, recorded.seed, engine, bars)?;
    let run = job.run();
    if let Some(problem) = difference(&run, recorded.directory)? {
        return Err(Failure::failed(format_args!(
            "{}: {problem}",
            recorded.directory.display()
        )));
    }
    let settings = experiment.settings();
    let genes: Vec<Vec<Genes>> = (0..run.intervals.first().map_or(0, Vec::len))
        .map(|robot| {
            let clock = settings.clock.interval_s;
            let of = |(interval, robots): (usize, &Vec<_>)| {
                let own: &RobotInterval = &robots[robot];
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
    let page = figures::foragers_page(&ForagersReplay {
        title: &format!("{}, seed {}", experiment.name(), recorded.seed),
        foragers: &settings.swarm(),
        lamp: settings.case.lamp(SECOND * settings.light_moves()),
        names: &(1..=settings.world.robots).collect::<Vec<_>>(),
        acts: &BEHAVIOURS,
        teller: Teller::Arena,
        lines: &figures::moments(job.lines(), SECOND),
        genes: &genes,
    });
    let directory = replay.out;
    plain::make_directory(directory).map_err(|error| Failure::unreadable(directory, &error))?;
    let path = directory.join(REPLAY);
    disk::write(&path, page.as_bytes())?;
    let value = json!({
        "brought": run.total(),
        "page": path.display().to_string(),
        "device": engine.name(),
    });
    let text = format!("food {}, as recorded\n{}", run.total(), path.display());
    Ok(Answer::new(text, value))
}
