//! `oneiro replay` for a swarm: a page that plays it.

use oneiro::swarm::SECOND;
use oneiro_base::answer::Answer;
use oneiro_base::console::Bars;
use oneiro_base::disk;
use oneiro_base::exit::{Failure, Result};
use oneiro_base::plain;
use oneiro_report::figures::{self, BEHAVIOURS, ForagersFrames, ForagersReplay, Genes, Teller};
use serde_json::json;

use super::{REPLAY, again, difference};
use crate::engine::handle::Engine;
use crate::experiment::swarm::SwarmExperiment;
use crate::runs::{Recorded, Replay, taken};
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
        ("--test", replay.test),
        ("--genome", replay.genome.is_some()),
        ("--elite", replay.elite.is_some()),
        ("--elites", replay.elites),
        ("--generation", replay.generation.is_some()),
        ("--generations", !replay.generations.is_empty()),
        ("--robot", replay.surrogate.is_some()),
        ("--trial", replay.trial != 0),
        ("--every", replay.every != 1),
    ];
    if let Some((option, _)) = given.into_iter().find(|(_, is_given)| *is_given) {
        return Err(Failure::usage(format_args!(
            "{option}: is given for the foraging study, which is replayed whole; allowed: with runs that have a champion"
        )));
    }
    taken::check(replay)?;
    let job = again(experiment, recorded.seed, engine, bars)?;
    let run = job.run();
    if let Some(problem) = difference(&job, recorded.directory)? {
        return Err(Failure::failed(format_args!(
            "{}: {problem}",
            recorded.directory.display()
        )));
    }
    // The first line is after a second.
    taken::check_moment(replay, SECOND, job.lines().len() + 1)?;
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
    let episode = ForagersReplay {
        title: &format!("{}, seed {}", experiment.name(), recorded.seed),
        foragers: &settings.swarm(),
        lamp: settings.case.lamp(SECOND * settings.light_moves()),
        names: &(1..=settings.world.robots).collect::<Vec<_>>(),
        acts: &BEHAVIOURS,
        teller: Teller::Arena,
        lines: &figures::moments(job.lines(), SECOND),
        genes: &genes,
    };
    let directory = replay.out;
    plain::make_directory(directory).map_err(|error| Failure::unreadable(directory, &error))?;
    let path = directory.join(REPLAY);
    disk::write(&path, figures::foragers_page(&episode).as_bytes())?;
    let taken = taken::write(replay, |side| ForagersFrames::new(&episode, side))?;
    let [picture, film] = taken.map(|file| file.map(|file| file.display().to_string()));
    let value = json!({
        "brought": run.total(),
        "page": path.display().to_string(),
        "picture": picture,
        "film": film,
        "device": engine.name(),
    });
    let page = path.display().to_string();
    let files: Vec<String> = std::iter::once(page).chain(picture).chain(film).collect();
    let text = format!("food {}, as recorded\n{}", run.total(), files.join("\n"));
    Ok(Answer::new(text, value))
}
