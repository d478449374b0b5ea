//! `oneiro evaluate --robot`: the same lives on a robot, or on a surrogate.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use oneiro_base::console::Console;
use oneiro_base::exit::{Failure, Result};
use oneiro_lab::device;
use oneiro_lab::lives::{LifeIndex, Lives};
use oneiro_lab::reality::site::{Robots, SEVERITY, Site, Wired};
use oneiro_lab::reality::wired::Values;
use oneiro_lab::reality::{Life, Lived};
use oneiro_robots::tracker;

use crate::cli::{Evaluate, OnRobot};

/// Lives all lives on robots, each of which takes one after the other, or those of a surrogate all at once. Returns their fitness, by
/// genome.
///
/// # Errors
/// Exit 3 for an address or values that are not allowed; those of the robots and of the record of their lives.
pub(super) fn lived(arguments: &Evaluate, lives: &Lives<'_>, console: Console) -> Result<Vec<f32>> {
    let site = site(&arguments.on_robot, console)?;
    let (indices, all): (Vec<LifeIndex>, Vec<Life<'_>>) =
        indices(lives).map(|index| (index, life(lives, index))).unzip();
    let spec = lives.worlds[0].spec();
    if let Some(time) = site.time(all.len() as u64, spec.cycles) {
        console.say(time);
    }
    let engine = arguments.backend.engine()?;
    let mut robot = site.open(&engine, spec)?;
    console.say(format!("on {}", robot.describe()));
    let ended = AtomicUsize::new(0);
    let told = |life: usize, lived: &Lived| {
        let LifeIndex { genome, number } = indices[life];
        console.say(format!(
            "episode {} of {}: genome {genome}, trial {number}, fitness {}",
            1 + ended.fetch_add(1, Ordering::Relaxed),
            indices.len(),
            lived.fitness
        ));
    };
    let lived = if site.is_wired() {
        robot.live_each(&all, false, &told)?
    } else {
        robot.live(&all, false)?
    };
    // It is stopped before the results are printed.
    drop(robot);
    drop(site);
    device::close(engine, console);
    Ok(lived.into_iter().map(|life| life.fitness).collect())
}

/// The robots at their addresses.
fn site(values: &OnRobot, console: Console) -> Result<Site> {
    let addresses = || values.robots.join(" ");
    let refused = |problem: String| Failure::input(format_args!("--robot: {problem}"));
    match (Robots::at(&values.robots).map_err(refused)?, &values.log) {
        (Robots::Surrogate(seed), None) => Ok(Site::drawn(seed, values.severity.unwrap_or(SEVERITY))),
        (Robots::Surrogate(_), Some(_)) => Err(Failure::usage(format_args!(
            "--log: {} is simulated, and its episodes need no record; allowed: with a connected robot",
            addresses()
        ))),
        (Robots::Wired(_), None) => Err(Failure::usage(format_args!(
            "--robot {}: lacks --log DIR; allowed: a directory for the log of its episodes",
            addresses()
        ))),
        (Robots::Wired(wires), Some(directory)) => {
            let limit = Duration::from_millis(values.tracker_age);
            let tracker = |text: &String| {
                tracker::Values::parse(text, limit)
                    .map_err(|problem| Failure::input(format_args!("--tracker {text}: {problem}")))
            };
            let own = Values {
                starts: values.between,
                walk: Values::cycles(values.walk),
                speed_mm_s: values.speed,
                sensors: values.sensors.clone(),
                directory: directory.clone(),
                trackers: values.trackers.iter().map(tracker).collect::<Result<_>>()?,
            };
            let wired = Wired::new(wires, own, &values.guard, console);
            Ok(Site::Wired(wired.map_err(refused)?))
        }
    }
}

/// All lives, by genome.
fn indices(lives: &Lives<'_>) -> impl Iterator<Item = LifeIndex> {
    let count = lives.count;
    (0..lives.genomes.len()).flat_map(move |genome| (0..count).map(move |number| LifeIndex { genome, number }))
}

fn life<'a>(lives: &Lives<'a>, LifeIndex { genome, number }: LifeIndex) -> Life<'a> {
    Life {
        genes: lives.genomes.genome(genome),
        key: lives.keys.of(genome, number),
        start: None,
    }
}
