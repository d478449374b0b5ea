//! The controllers that acted in a recorded run, by themselves.

use std::path::Path;

use oneiro::foraging::{Forager, Light};
use oneiro::world::{World, WorldSpec};
use oneiro_base::disk;
use oneiro_base::exit::{Failure, Result};
use serde::Deserialize;

use crate::experiment::swarm::SwarmExperiment;
use crate::swarm::tables::INTERVALS;

/// What acted on a robot at the end of an interval: a row of the table of intervals.
#[derive(Clone, Copy, Debug, Deserialize)]
pub struct Acting {
    pub interval: u32,
    pub robot: u32,
    /// The gene of the simulator in which it was chosen.
    chosen_under: f32,
    g0: f32,
    g1: f32,
    /// Its fitness in the arena, in this interval.
    pub real: f32,
}

impl Acting {
    /// Reads that of a robot, in the last interval unless there is a number, from a finished run's directory.
    ///
    /// # Errors
    /// Exit 3 for a robot or an interval that there isn't, exit 5 if the table isn't what was written.
    pub fn read(directory: &Path, robot: u32, interval: Option<u32>) -> Result<Self> {
        let path = directory.join(INTERVALS);
        let text = disk::read_text(&path)?;
        let rows = csv::Reader::from_reader(text.as_bytes()).into_deserialize();
        let rows: Vec<Self> = rows
            .collect::<std::result::Result<_, _>>()
            .map_err(|error| Failure::corrupt(format_args!("{}: {error}", path.display())))?;
        let Some(last) = rows.last() else {
            return Err(Failure::input(format_args!(
                "{}: is a run of the case `random`, in which nothing evolves; allowed: runs of other cases",
                directory.display()
            )));
        };
        let allowed = |label: &str, number: u32, most: u32| {
            if number > most {
                let problem = format_args!("{label}: is {number}; allowed: 0 to {most}");
                return Err(Failure::input(problem));
            }
            Ok(())
        };
        let interval = interval.unwrap_or(last.interval);
        allowed("--number", robot, last.robot)?;
        allowed("--interval", interval, last.interval)?;
        let found = rows.iter().find(|row| (row.robot, row.interval) == (robot, interval));
        found
            .copied()
            .ok_or_else(|| Failure::corrupt(format_args!("{}: has not all robots", path.display())))
    }

    /// The genes of its behaviours, with food and without.
    pub fn genome(&self) -> [f32; 2] {
        [self.g0, self.g1]
    }

    /// Where the lamp was in the simulator in which it was chosen.
    pub fn light(&self) -> Light {
        Light::of_gene(self.chosen_under)
    }
}

/// The world of a robot's simulator, with the light there.
///
/// # Errors
/// Exit 3 for values that a single forager can't have.
pub fn simulator(experiment: &SwarmExperiment, light: Light) -> Result<World> {
    let settings = experiment.settings();
    let forager = Forager {
        foraging: settings.simulator(light),
        food_earns: settings.clock.interval_s as f32,
    };
    World::new(WorldSpec::foraging(forager))
        .map_err(|invalid| Failure::input(format_args!("{}: {invalid}", experiment.name())))
}
