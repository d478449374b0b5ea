//! Tables and figures of a swarm's run.

use std::fmt::Write;

use oneiro::foraging::Light;

use super::record::{RobotInterval, Run};
use super::settings::Settings;
use crate::contents::{Column, head};
use crate::statistics::mean;

/// The table of intervals: its file, and its columns.
pub(crate) const INTERVALS: &str = "intervals.csv";
pub(crate) static INTERVALS_COLUMNS: [Column; 11] = [
    Column::whole(
        "interval",
        "",
        "its number, from 0, by the robot's own clock (`swarm.clock.interval_s`)",
    ),
    Column::whole("robot", "", "its number, from 0"),
    Column::number("s0", "0 to 0.99", "the gene of its simulator"),
    Column::number(
        "chosen_under",
        "0 to 0.99",
        "the gene of the simulator in which the acting controller was chosen",
    ),
    Column::number(
        "g0",
        "0 to 0.99",
        "the gene of the acting controller's behaviour with food, at the interval's end",
    ),
    Column::number("g1", "0 to 0.99", "the gene of its behaviour without food"),
    Column::number(
        "real",
        "",
        "its fitness in the arena during this interval; in the study's null model, that of another robot",
    ),
    Column::number(
        "simulated",
        "",
        "the same controller's fitness in the simulator in which it was chosen; empty in the first interval",
    ),
    Column::whole("heard", "robots", "the number of robots that it heard"),
    Column::whole(
        "reached",
        "robots",
        "the number of robots linked to it by this interval's encounters, itself included",
    ),
    Column::whole("taken", "", "1 if its next simulator came from another robot, else 0"),
];
/// The table of food: its file, and its columns.
pub(crate) const FOOD: &str = "food.csv";
pub(crate) static FOOD_COLUMNS: [Column; 2] = [
    Column::whole("second", "s", "its number, from 0"),
    Column::whole("brought", "items", "food that all robots brought in that second"),
];

/// A line for each robot in an interval.
pub(crate) fn interval_rows(interval: usize, robots: &[RobotInterval]) -> String {
    let mut text = String::new();
    for (robot, own) in robots.iter().enumerate() {
        let simulated = own.simulated.map(|fitness| fitness.to_string()).unwrap_or_default();
        // Writing to a string can't fail.
        let _ = writeln!(
            text,
            "{interval},{robot},{},{},{},{},{},{simulated},{},{},{}",
            own.s0,
            own.chosen_under,
            own.g0,
            own.g1,
            own.real,
            own.heard,
            own.reached,
            u8::from(own.taken)
        );
    }
    text
}

impl Run {
    /// All lines of the table of intervals but the first.
    pub(crate) fn interval_rows(&self) -> String {
        let robots = self.intervals.iter().enumerate();
        robots
            .map(|(interval, robots)| interval_rows(interval, robots))
            .collect()
    }

    /// The table of food: a line for each second.
    pub(crate) fn food_table(&self) -> String {
        let mut text = head(&FOOD_COLUMNS);
        for (second, food) in self.brought.iter().enumerate() {
            let _ = writeln!(text, "{second},{food}");
        }
        text
    }

    /// Total food that the swarm collected.
    pub(crate) fn total(&self) -> u32 {
        self.brought.iter().map(|&food| u32::from(food)).sum()
    }

    /// Row in a sweep's table of results: food in total and per robot-minute; and of the last fifth of the time, food
    /// per robot-minute, the share of simulators that have the light where it is, and their mean gene.
    pub(crate) fn cells(&self, settings: &Settings) -> Vec<String> {
        let robots = f64::from(settings.world.robots);
        let rate = |brought: &[u16]| {
            let food: f64 = brought.iter().copied().map(f64::from).sum();
            60.0 * food / (brought.len() as f64 * robots)
        };
        let late = |length: usize| length - length / 5;
        let [_, light] = settings.case.lights();
        let genes: Vec<f64> = self.intervals[late(self.intervals.len())..]
            .iter()
            .flatten()
            .map(|own| f64::from(own.s0))
            .collect();
        let right: Vec<f64> = genes
            .iter()
            .map(|&gene| f64::from(u8::from(Light::of_gene(gene as f32) == light)))
            .collect();
        vec![
            self.total().to_string(),
            format!("{:.6}", rate(&self.brought)),
            format!("{:.6}", rate(&self.brought[late(self.brought.len())..])),
            format!("{:.6}", mean(&right)),
            format!("{:.6}", mean(&genes)),
        ]
    }
}
