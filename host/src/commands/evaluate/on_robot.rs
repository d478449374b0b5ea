//! `oneiro evaluate --robot`: the same lives on a robot, or on a surrogate.

use std::time::Duration;

use crate::cli::{Evaluate, OnRobot};
use crate::console::Console;
use crate::device;
use crate::exit::{Failure, Result};
use crate::lives::{LifeIndex, Lives};
use crate::reality::site::{self, SEVERITY, Site, Wired};
use crate::reality::wired::Values;
use crate::reality::{Life, Reality};
use crate::robots::address::Address;
use crate::robots::tracker;

/// Lives all lives on a robot, one after the other, those of a surrogate all at once. Returns their fitness, by genome.
///
/// # Errors
/// Exit 3 for an address or values that are not allowed; those of the robot and of the record of its lives.
pub(super) fn lived(address: &str, arguments: &Evaluate, lives: &Lives<'_>, console: Console) -> Result<Vec<f32>> {
    let site = site(address, &arguments.on_robot, console)?;
    let all: Vec<(LifeIndex, Life<'_>)> = indices(lives).map(|index| (index, life(lives, index))).collect();
    let spec = lives.worlds[0].spec();
    if let Some(time) = site.time(all.len() as u64, spec.cycles) {
        console.say(time);
    }
    let engine = device::engine(&arguments.backend)?;
    let mut robot = site.open(&engine, spec)?;
    console.say(format!("on {}", robot.describe()));
    let fitness = if site.is_wired() {
        one_by_one(&mut *robot, &all, console)?
    } else {
        let all: Vec<Life<'_>> = all.into_iter().map(|(_, life)| life).collect();
        let lived = robot.live(&all, false)?;
        lived.into_iter().map(|life| life.fitness).collect()
    };
    // It is stopped before the results are printed.
    drop(robot);
    drop(site);
    device::close(engine, console);
    Ok(fitness)
}

fn one_by_one(robot: &mut dyn Reality, all: &[(LifeIndex, Life<'_>)], console: Console) -> Result<Vec<f32>> {
    let mut fitness = Vec::with_capacity(all.len());
    for (at, (LifeIndex { genome, number }, life)) in all.iter().enumerate() {
        for lived in robot.live(std::slice::from_ref(life), false)? {
            console.say(format!(
                "life {} of {}: genome {genome}, trial {number}, fitness {}",
                at + 1,
                all.len(),
                lived.fitness
            ));
            fitness.push(lived.fitness);
        }
    }
    Ok(fitness)
}

/// The robot at an address.
fn site(address: &str, values: &OnRobot, console: Console) -> Result<Site> {
    match (site::address(address)?, &values.lives) {
        (Address::Surrogate(seed), None) => Ok(Site::drawn(seed, values.severity.unwrap_or(SEVERITY))),
        (Address::Surrogate(_), Some(_)) => Err(Failure::usage(format_args!(
            "--lives: {address} is simulated, and its lives need no record; allowed: with a robot on a wire"
        ))),
        (Address::Wire(_), None) => Err(Failure::usage(format_args!(
            "--robot {address}: lacks --lives DIR; allowed: a directory where its lives are recorded"
        ))),
        (Address::Wire(wire), Some(directory)) => {
            let limit = Duration::from_millis(values.tracker_age);
            let tracker = values.tracker.as_deref().map(|text| {
                tracker::Values::parse(text, limit)
                    .map_err(|problem| Failure::input(format_args!("--tracker {text}: {problem}")))
            });
            let tracker = tracker.transpose()?;
            let own = Values {
                starts: values.between,
                walk: Values::cycles(values.walk),
                speed_mm_s: values.speed,
                sensors: values.sensors.clone(),
                directory: directory.clone(),
                tracker,
            };
            Ok(Site::Wired(Wired::new(wire, own, &values.guard, console)))
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
