//! Tables and figures of a swarm's run.

use std::fmt::Write;

use oneiro::foraging::Light;

use super::record::{RobotInterval, Run};
use super::settings::Settings;
use crate::statistics::mean;

/// The table of intervals: its file, and its first line.
pub(crate) const INTERVALS: &str = "intervals.csv";
pub(crate) const INTERVALS_HEAD: &str = "interval,robot,s0,chosen_under,g0,g1,real,simulated,heard,reached,taken\n";
/// The table of food: its file.
pub(crate) const FOOD: &str = "food.csv";

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
        let mut text = String::from("second,brought\n");
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
