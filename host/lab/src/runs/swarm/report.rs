//! The page of a swarm's finished run: food, fitness and genes through time, what was set, and what to do next.

use oneiro_base::console::counted;
use oneiro_report::figures::{Band, Panel, Spread, evenly, grid};
use oneiro_report::numbers::count;
use oneiro_report::page::{Section, document, facts, figure};

use super::super::report::{commands, settings};
use super::REPLAY;
use crate::experiment::swarm::SwarmExperiment;
use crate::swarm::record::{RobotInterval, Run};

const MINUTE: usize = 60;
const COLOUR: &str = "#2b3a8f";

/// The page.
pub(super) fn html(experiment: &SwarmExperiment, seed: u64, run: &Run) -> String {
    let own = experiment.settings();
    let food: u64 = run.brought.iter().map(|&food| u64::from(food)).sum();
    let about = facts(&[
        ("case", own.case.title().to_owned()),
        ("swarm", counted(own.world.robots, "robot", "robots")),
        ("time", counted(own.minutes, "minute", "minutes")),
        ("food", format!("{} items brought to the nest", count(food))),
    ]);
    let words = "Food that the swarm brings to the nest in each minute and, if simulators evolve, real fitness and genes in each interval: \
                 the mean of all robots, shaded from the lowest to the highest.";
    let next = [
        ("replay RUN", format!("play the run: {REPLAY}")),
        ("verify --recompute RUN", "compute the run again and compare".to_owned()),
    ];
    let sections = [
        Section::new("run", "Run", about + &figure("Figure 1", words, &curves(run))),
        Section::new("settings", "Settings", settings(&experiment.changed())),
        Section::new("next", "What to do next", commands(&next)),
    ];
    let lead = "<p class=\"lead\">A swarm of the foraging study.</p>\n";
    document(&format!("{}, seed {seed}", experiment.name()), lead, &sections)
}

fn curves(run: &Run) -> String {
    let minutes = run.brought.chunks(MINUTE).map(|seconds| {
        let sum = seconds.iter().copied().map(f64::from).sum();
        Spread {
            low: sum,
            mean: sum,
            high: sum,
        }
    });
    let food = panel("Food", "minute", "items a minute", evenly(0.5, 1.0, minutes));
    let of_robots = |value: fn(&RobotInterval) -> f32| {
        let spread = run.intervals.iter().map(|robots| spread(robots.iter().map(value)));
        evenly(0.0, 1.0, spread)
    };
    let fitness = panel("Real fitness", "interval", "fitness", of_robots(|own| own.real));
    let gene = |title, value| Panel {
        high: 1.0,
        ..panel(title, "interval", "gene, 0 to 0.99", of_robots(value))
    };
    let genes = [
        gene("S0: the light in the simulator", |own| own.s0),
        gene("G0: behaviour with food", |own| own.g0),
        gene("G1: behaviour without food", |own| own.g1),
    ];
    let title = "Food, fitness and genes";
    if run.intervals.is_empty() {
        grid(title, &[&[food]])
    } else {
        grid(title, &[&[food, fitness], &genes])
    }
}

fn panel<'a>(title: &'a str, across: &'a str, up: &'a str, values: Vec<(f64, Spread)>) -> Panel<'a> {
    Panel {
        title,
        across,
        up,
        from: 0.0,
        to: values.last().map_or(1.0, |(at, _)| at.ceil()),
        low: values.iter().map(|(_, own)| own.low).fold(0.0, f64::min),
        high: values.iter().map(|(_, own)| own.high).fold(0.0, f64::max),
        bands: vec![Band {
            label: "",
            colour: COLOUR,
            dash: "",
            values,
        }],
        ..Panel::default()
    }
}

/// Minimum, mean and maximum over the robots.
fn spread(values: impl Iterator<Item = f32> + Clone) -> Spread {
    let values = values.map(f64::from);
    let sum: f64 = values.clone().sum();
    Spread {
        low: values.clone().fold(f64::INFINITY, f64::min),
        mean: sum / values.clone().count() as f64,
        high: values.fold(f64::NEG_INFINITY, f64::max),
    }
}
