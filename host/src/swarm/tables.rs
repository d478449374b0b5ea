//! Tables and figures of a swarm's run.

use std::fmt::Write;
use std::ops::Range;

use super::record::{RobotInterval, Run};
use super::settings::Settings;
use crate::contents::{Column, head};

/// Columns of an interval that the table of a robot's own daemon has as well.
pub(crate) const ROBOT: Column = Column::whole("robot", "", "its number, from 0");
pub(crate) const SIMULATOR: Column = Column::number("s0", "0 to 0.99", "the gene of its simulator");
pub(crate) const CHOSEN_UNDER: Column = Column::number(
    "chosen_under",
    "0 to 0.99",
    "the gene of the simulator in which the acting controller was chosen",
);
pub(crate) const WITH_FOOD: Column = Column::number(
    "g0",
    "0 to 0.99",
    "the gene of the acting controller's behaviour with food, at the interval's end",
);
pub(crate) const WITHOUT_FOOD: Column = Column::number("g1", "0 to 0.99", "the gene of its behaviour without food");
pub(crate) const HEARD: Column = Column::whole("heard", "robots", "the number of robots that it heard");
pub(crate) const TAKEN: Column = Column::whole("taken", "", "1 if its next simulator came from another robot, else 0");

/// The table of intervals: its file, and its columns.
pub(crate) const INTERVALS: &str = "intervals.csv";
pub(crate) static INTERVALS_COLUMNS: [Column; 11] = [
    Column::whole(
        "interval",
        "",
        "its number, from 0, by the robot's own clock (`swarm.clock.interval_s`)",
    ),
    ROBOT,
    SIMULATOR,
    CHOSEN_UNDER,
    WITH_FOOD,
    WITHOUT_FOOD,
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
    HEARD,
    Column::whole(
        "reached",
        "robots",
        "the number of robots linked to it by this interval's encounters, itself included",
    ),
    TAKEN,
];
/// The table of food: its file, and its columns.
pub(crate) const FOOD: &str = "food.csv";
pub(crate) static FOOD_COLUMNS: [Column; 2] = [
    Column::whole("second", "s", "its number, from 0"),
    Column::whole("brought", "items", "food that all robots brought in that second"),
];

/// What a run gives in a sweep's table of results. "Before the move" is before the light may move (`swarm.light_moves_minute`).
pub(crate) static OUTCOMES: [Column; 21] = [
    Column::whole("brought", "items", "food that all robots brought"),
    Column::number("rate", "items a robot-minute", "food brought"),
    Column::number(
        "late_rate",
        "items a robot-minute",
        "food in the last fifth of the time",
    ),
    Column::number(
        "before_rate",
        "items a robot-minute",
        "food in the 250 s before the light may move",
    ),
    Column::number("after_rate", "items a robot-minute", "food in the 500 s after that"),
    Column::number(
        "second_rate",
        "items a robot-minute",
        "food from when the light may move to the end",
    ),
    Column::number(
        "late_right",
        "0 to 1",
        "the share of simulators with the light in its true position, in the last fifth of the intervals",
    ),
    Column::number(
        "before_right",
        "0 to 1",
        "the same in the ten intervals before the light may move",
    ),
    Column::number(
        "before_later",
        "0 to 1",
        "in these intervals the share with the light where it is at the end",
    ),
    Column::number(
        "second_later",
        "0 to 1",
        "the share with the light where it is at the end, from when it may move",
    ),
    Column::number(
        "settled_later",
        "0 to 1",
        "the share with the light where it is at the end, after the first fifth of the intervals",
    ),
    Column::number(
        "first_s0",
        "0 to 0.99",
        "the mean gene of simulators in the intervals before the light may move",
    ),
    Column::number("before_s0", "0 to 0.99", "the same in the last ten of them"),
    Column::number("late_s0", "0 to 0.99", "the same in the last fifth of the intervals"),
    Column::number(
        "second_s0_deviation",
        "",
        "the standard deviation of that gene over robots and intervals, from when the light may move",
    ),
    Column::number("late_s0_deviation", "", "the same in the last fifth of the intervals"),
    Column::number(
        "late_g0",
        "0 to 0.99",
        "the mean gene of acting controllers for behaviour with food, in the last fifth of the intervals",
    ),
    Column::number("late_g0_deviation", "", "its standard deviation"),
    Column::number("late_g1", "0 to 0.99", "the mean gene for behaviour without food"),
    Column::number("late_g1_deviation", "", "its standard deviation"),
    Column::number(
        "chosen_area",
        "0 to 1",
        "the area under the curve of real fitness for \"the simulator in which the controller was chosen is right\"; NaN if all or none are",
    ),
];
/// Seconds of a bin of the paper's Figure 5.
const BIN: usize = 250;

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

    /// Row in a sweep's table of results: [`OUTCOMES`].
    pub(crate) fn cells(&self, settings: &Settings) -> Vec<String> {
        let robots = f64::from(settings.world.robots);
        let seconds = self.brought.len();
        let rate = |seconds: Range<usize>| {
            let brought = &self.brought[seconds];
            let food: f64 = brought.iter().copied().map(f64::from).sum();
            60.0 * food / (brought.len() as f64 * robots)
        };
        let late = |length: usize| length - length / 5;
        // The second and the interval in which the light may move.
        let moves_at = (settings.light_moves() as usize).min(seconds);
        let moves = (settings.light_moves() / settings.clock.interval_s) as usize;
        let end = self.intervals.len();
        let (before, second, last) = (moves.saturating_sub(10)..moves, moves..end.max(moves), late(end)..end);
        let [now, then] = settings.case.lights();
        let rates = [
            rate(0..seconds),
            rate(late(seconds)..seconds),
            rate(moves_at.saturating_sub(BIN)..moves_at),
            rate(moves_at..(moves_at + 2 * BIN).min(seconds)),
            rate(moves_at..seconds),
        ];
        let shares = [
            self.share(then, last.clone()),
            self.share(now, before.clone()),
            self.share(then, before.clone()),
            self.share(then, second.clone()),
            self.share(then, end / 5..end),
        ];
        let genes = [
            self.mean(|own| own.s0, 0..moves),
            self.mean(|own| own.s0, before),
            self.mean(|own| own.s0, last.clone()),
            self.deviation(|own| own.s0, second),
            self.deviation(|own| own.s0, last.clone()),
            self.mean(|own| own.g0, last.clone()),
            self.deviation(|own| own.g0, last.clone()),
            self.mean(|own| own.g1, last.clone()),
            self.deviation(|own| own.g1, last),
        ];
        let area = self.area(moves, |interval, robot| self.intervals[interval][robot].chosen_under);
        let numbers = rates
            .into_iter()
            .chain(shares)
            .chain(genes)
            .chain([area.unwrap_or(f64::NAN)]);
        std::iter::once(self.total().to_string())
            .chain(numbers.map(|number| format!("{number:.6}")))
            .collect()
    }
}
