//! Tables and figures of a swarm's run.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::ops::Range;

use oneiro::foraging::Light;
use oneiro::swarm::SECOND;
use oneiro_base::contents::{Column, OutcomeColumn, head};
use oneiro_report::numbers::fixed;

use super::measures::MINUTE;
use super::on_board::OnBoard;
use super::record::{RobotInterval, Run};
use super::settings::Settings;
use crate::engine::job::Named;
use crate::exchange::Message;

/// Columns of an interval that the table of a robot's daemon also has.
pub const ROBOT: Column = Column::whole("robot", "", "its number, from 0");
pub const SIMULATOR: Column = Column::number("s0", "0 to 0.99", "the gene of its simulator");
pub const CHOSEN_UNDER: Column = Column::number(
    "chosen_under",
    "0 to 0.99",
    "the gene of the simulator in which the acting controller was chosen",
);
pub const WITH_FOOD: Column = Column::number(
    "g0",
    "0 to 0.99",
    "the gene of the acting controller's behaviour with food, at the interval's end",
);
pub const WITHOUT_FOOD: Column = Column::number("g1", "0 to 0.99", "the gene of its behaviour without food");
pub const HEARD: Column = Column::whole("heard", "robots", "the number of robots whose messages it received");
pub const TAKEN: Column = Column::whole(
    "taken",
    "",
    "1 if its next simulator came from another robot, else 0, also where the experimenter sets all simulators",
);

/// The table of intervals: its file, and its columns.
pub const INTERVALS: &str = "intervals.csv";
pub static INTERVALS_COLUMNS: [Column; 11] = [
    Column::whole(
        "interval",
        "",
        "its number, from 0, by the robot's clock (`swarm.clock.interval_s`)",
    ),
    ROBOT,
    SIMULATOR,
    CHOSEN_UNDER,
    WITH_FOOD,
    WITHOUT_FOOD,
    Column::number("real", "", "its fitness in the arena during this interval"),
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
pub const FOOD: &str = "food.csv";
pub(crate) static FOOD_COLUMNS: [Column; 2] = [
    Column::whole("second", "s", "its number, from 0"),
    Column::whole("brought", "items", "food that all robots brought in that second"),
];

/// The table of food that robots brought: its file, and its columns.
pub const DEPOSITS: &str = "deposits.csv";
pub(crate) static DEPOSITS_COLUMNS: [Column; 6] = [
    Column::number("time_s", "s", "when the item was brought, since the start"),
    ROBOT,
    Column::whole("interval", "", "the robot's interval"),
    Column::number(
        "into_s",
        "s",
        "the time since the interval began: the item earns the rest of the interval (equation 1)",
    ),
    Column::number("x_mm", "mm", "where the robot was"),
    Column::number("y_mm", "mm", "likewise"),
];
/// The table of controllers on board: its file, and its columns.
pub const CONTROLLERS: &str = "controllers.csv";
pub(crate) static CONTROLLERS_COLUMNS: [Column; 7] = [
    Column::whole("interval", "", "its number, from 0, by the robot's clock"),
    ROBOT,
    Column::whole("controller", "", "its number in the robot's population, from 0"),
    Column::number("g0", "0 to 0.99", "the gene of its behaviour with food"),
    Column::number("g1", "0 to 0.99", "the gene of its behaviour without food"),
    Column::number("simulated", "", "its fitness in the robot's simulator"),
    Column::whole(
        "rank",
        "",
        "from 0, the best; the parents (`swarm.controllers.parents`) are the next interval's first controllers",
    ),
];
/// The table of pairs that robots stored: its file, and its columns.
pub const PAIRS: &str = "pairs.csv";
pub(crate) static PAIRS_COLUMNS: [Column; 9] = [
    Column::whole("interval", "", "the interval of the robot that ends"),
    ROBOT,
    Column::whole("rank", "", "from 0, the pair with the highest fitness"),
    Column::whole("sender", "", "the robot that sent the pair"),
    Column::whole("sent_interval", "", "the sender's interval that the fitness is of"),
    SIMULATOR,
    Column::number(
        "fitness",
        "",
        "the fitness credited to that simulator, as last received",
    ),
    Column::number("g0", "0 to 0.99", "the gene of the sender's controller with food"),
    Column::number("g1", "0 to 0.99", "the gene of the sender's controller without food"),
];

/// A column of a sweep's table of results, and its value.
type Outcome = OutcomeColumn<fn(&Lived<'_>) -> String>;

/// A run's values in a sweep's table of results. "Before the move" is before the light may move (`swarm.light_moves_minute`). Those about
/// simulators are NaN where there are none (`swarm.control`).
static OUTCOMES: [Outcome; 24] = [
    OutcomeColumn::new(
        Column::whole("brought", "items", "food that all robots brought"),
        |own| own.run.total().to_string(),
    ),
    OutcomeColumn::new(Column::number("rate", "items a robot-minute", "food brought"), |own| {
        fixed(own.rate(0..own.seconds()), 6)
    }),
    OutcomeColumn::new(
        Column::number(
            "late_rate",
            "items a robot-minute",
            "food in the last fifth of the time",
        ),
        |own| fixed(own.rate(late(own.seconds())..own.seconds()), 6),
    ),
    OutcomeColumn::new(
        Column::number(
            "before_rate",
            "items a robot-minute",
            "food in the 250 s before the light may move",
        ),
        |own| fixed(own.rate(own.moves_at().saturating_sub(BIN)..own.moves_at()), 6),
    ),
    OutcomeColumn::new(
        Column::number("after_rate", "items a robot-minute", "food in the 500 s after that"),
        |own| {
            fixed(
                own.rate(own.moves_at()..(own.moves_at() + 2 * BIN).min(own.seconds())),
                6,
            )
        },
    ),
    OutcomeColumn::new(
        Column::number(
            "second_rate",
            "items a robot-minute",
            "food from when the light may move to the end",
        ),
        |own| fixed(own.rate(own.moves_at()..own.seconds()), 6),
    ),
    OutcomeColumn::new(
        Column::number(
            "late_right",
            "0 to 1",
            "the fraction of simulators with the light in its true position, in the last fifth of the intervals; where `swarm.control` has no simulators, it and all others about them are NaN",
        ),
        |own| own.simulators(own.run.share(own.light_at_the_end(), own.last())),
    ),
    OutcomeColumn::new(
        Column::number(
            "before_right",
            "0 to 1",
            "the same in the ten intervals before the light may move",
        ),
        |own| own.simulators(own.run.share(own.light_at_first(), own.before())),
    ),
    OutcomeColumn::new(
        Column::number(
            "before_later",
            "0 to 1",
            "in these intervals the fraction with the light where it is at the end",
        ),
        |own| own.simulators(own.run.share(own.light_at_the_end(), own.before())),
    ),
    OutcomeColumn::new(
        Column::number(
            "second_later",
            "0 to 1",
            "the fraction with the light where it is at the end, from when it may move",
        ),
        |own| own.simulators(own.run.share(own.light_at_the_end(), own.second())),
    ),
    OutcomeColumn::new(
        Column::number(
            "settled_later",
            "0 to 1",
            "the fraction with the light where it is at the end, after the first fifth of the intervals",
        ),
        |own| {
            own.simulators(
                own.run
                    .share(own.light_at_the_end(), own.intervals() / 5..own.intervals()),
            )
        },
    ),
    OutcomeColumn::new(
        Column::number(
            "first_s0",
            "0 to 0.99",
            "the mean gene of simulators in the intervals before the light may move",
        ),
        |own| own.simulators(own.run.mean(|robot| robot.s0, 0..own.moves())),
    ),
    OutcomeColumn::new(
        Column::number("before_s0", "0 to 0.99", "the same in the last ten of them"),
        |own| own.simulators(own.run.mean(|robot| robot.s0, own.before())),
    ),
    OutcomeColumn::new(
        Column::number("late_s0", "0 to 0.99", "the same in the last fifth of the intervals"),
        |own| own.simulators(own.run.mean(|robot| robot.s0, own.last())),
    ),
    OutcomeColumn::new(
        Column::number(
            "second_s0_deviation",
            "",
            "the standard deviation of that gene over robots and intervals, from when the light may move",
        ),
        |own| own.simulators(own.run.deviation(|robot| robot.s0, own.second())),
    ),
    OutcomeColumn::new(
        Column::number("late_s0_deviation", "", "the same in the last fifth of the intervals"),
        |own| own.simulators(own.run.deviation(|robot| robot.s0, own.last())),
    ),
    OutcomeColumn::new(
        Column::number(
            "late_g0",
            "0 to 0.99",
            "the mean gene of acting controllers for behaviour with food, in the last fifth of the intervals",
        ),
        |own| fixed(own.run.mean(|robot| robot.g0, own.last()), 6),
    ),
    OutcomeColumn::new(
        Column::number("late_g0_deviation", "", "its standard deviation"),
        |own| fixed(own.run.deviation(|robot| robot.g0, own.last()), 6),
    ),
    OutcomeColumn::new(
        Column::number("late_g1", "0 to 0.99", "the mean gene for behaviour without food"),
        |own| fixed(own.run.mean(|robot| robot.g1, own.last()), 6),
    ),
    OutcomeColumn::new(
        Column::number("late_g1_deviation", "", "its standard deviation"),
        |own| fixed(own.run.deviation(|robot| robot.g1, own.last()), 6),
    ),
    OutcomeColumn::new(
        Column::number(
            "chosen_area",
            "0 to 1",
            "the area under the curve of real fitness for \"the simulator in which the controller was chosen is right\"; NaN if all or none are",
        ),
        |own| own.simulators(own.area()),
    ),
    OutcomeColumn::new(
        Column::number(
            "matched_min",
            "min",
            "the time when at least half of the simulators had the light in its true position, over five intervals, for the first time; the whole time if they never did",
        )
        .less_is_better(),
        |own| own.simulators(own.matched()),
    ),
    OutcomeColumn::new(
        Column::number(
            "takeover_min",
            "min",
            "the time when all simulators of an interval descended from one robot's first simulator; the whole time if they never did, NaN if something else than exchange changes simulators",
        )
        .less_is_better(),
        |own| fixed(own.takeover(), 6),
    ),
    OutcomeColumn::new(
        Column::number(
            "lineages",
            "",
            "the number of robots from whose first simulators those of the last interval descend; NaN likewise",
        ),
        |own| {
            own.lineages_at(own.intervals().wrapping_sub(1))
                .map_or("NaN".to_owned(), |count| count.to_string())
        },
    ),
];

/// The columns of a run's values in a sweep's table of results.
pub fn outcomes() -> Vec<Column> {
    OUTCOMES.iter().map(|outcome| outcome.column.clone()).collect()
}

/// Intervals over which simulators must match reality: fewer would take chance for a match.
const MATCHED_INTERVALS: usize = 5;

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

/// A line for an item that a robot brought in a cycle of an interval that began in another cycle.
pub(crate) fn deposit_row(cycle: u32, robot: usize, interval: u32, began: u32, at: [f32; 2]) -> String {
    // Both end with the cycle.
    let [time, into] = [cycle + 1, cycle + 1 - began].map(|cycles| f64::from(cycles) / f64::from(SECOND));
    format!("{time},{robot},{interval},{into},{},{}\n", at[0], at[1])
}

/// A line for each controller of a robot in an interval.
pub(crate) fn controller_rows(interval: u32, robot: usize, own: &OnBoard, fitness: &[f32]) -> String {
    let mut text = String::new();
    for (index, ([g0, g1], simulated)) in own.controllers().iter().zip(fitness).enumerate() {
        let rank = own
            .ranking
            .iter()
            .position(|&ranked| ranked == index)
            .unwrap_or_default();
        let _ = writeln!(text, "{interval},{robot},{index},{g0},{g1},{simulated},{rank}");
    }
    text
}

/// A line for each pair of a robot at an interval's end, the best first.
pub(crate) fn pair_rows(interval: u32, robot: usize, pairs: &[Message]) -> String {
    let mut text = String::new();
    for (rank, pair) in pairs.iter().enumerate() {
        let [g0, g1] = pair.controller;
        let _ = writeln!(
            text,
            "{interval},{robot},{rank},{},{},{},{},{g0},{g1}",
            pair.sender, pair.interval, pair.simulator, pair.fitness
        );
    }
    text
}

impl Run {
    /// All lines of the table of intervals except the first.
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
    pub fn total(&self) -> u32 {
        self.brought.iter().map(|&food| u32::from(food)).sum()
    }

    /// Its values in a sweep's table of results.
    pub fn outcomes(&self, settings: &Settings) -> Named {
        let own = Lived { run: self, settings };
        let named = |outcome: &Outcome| (outcome.column.name.clone(), (outcome.value)(&own));
        OUTCOMES.iter().map(named).collect()
    }
}

/// A run that has ended, for its values in a sweep's table.
struct Lived<'a> {
    run: &'a Run,
    settings: &'a Settings,
}

impl Lived<'_> {
    /// A value that is about simulators.
    fn simulators(&self, value: f64) -> String {
        let has_some = self.run.kind.has_simulators() && !self.run.intervals.is_empty();
        fixed(if has_some { value } else { f64::NAN }, 6)
    }

    fn seconds(&self) -> usize {
        self.run.brought.len()
    }

    fn intervals(&self) -> usize {
        self.run.intervals.len()
    }

    /// The second in which the light may move.
    fn moves_at(&self) -> usize {
        (self.settings.light_moves() as usize).min(self.seconds())
    }

    /// The interval in which the light may move.
    fn moves(&self) -> usize {
        (self.settings.light_moves() / self.settings.clock.interval_s) as usize
    }

    /// The ten intervals before that.
    fn before(&self) -> Range<usize> {
        self.moves().saturating_sub(10)..self.moves()
    }

    /// The intervals from then on.
    fn second(&self) -> Range<usize> {
        self.moves()..self.intervals().max(self.moves())
    }

    /// The last fifth of the intervals.
    fn last(&self) -> Range<usize> {
        late(self.intervals())..self.intervals()
    }

    fn light_at_first(&self) -> Light {
        self.settings.case.lights()[0]
    }

    fn light_at_the_end(&self) -> Light {
        self.settings.case.lights()[1]
    }

    /// Items that a robot brought in a minute, in some seconds.
    fn rate(&self, seconds: Range<usize>) -> f64 {
        let brought = &self.run.brought[seconds];
        let food: f64 = brought.iter().copied().map(f64::from).sum();
        60.0 * food / (brought.len() as f64 * f64::from(self.settings.world.robots))
    }

    /// Minutes until half of the simulators of [`MATCHED_INTERVALS`] are right. They are counted, since fractions round.
    fn matched(&self) -> f64 {
        let is_matched = |end: &usize| {
            let first = end - MATCHED_INTERVALS;
            let robots = self.run.intervals[first..*end].iter().zip(first..);
            let robots = robots.flat_map(|(robots, interval)| {
                let light = self.settings.case.light_in(interval, self.moves());
                robots.iter().map(move |own| Light::of_gene(own.s0) == light)
            });
            let (right, all) = robots.fold((0, 0), |(right, all), is_right| {
                (right + usize::from(is_right), all + 1)
            });
            2 * right >= all
        };
        let end = (MATCHED_INTERVALS..=self.intervals()).find(is_matched);
        let seconds = end.map_or(self.seconds(), |end| end * self.settings.clock.interval_s as usize);
        seconds as f64 / MINUTE as f64
    }

    /// The number of robots from whose first simulators those of an interval descend.
    fn lineages_at(&self, interval: usize) -> Option<usize> {
        let robots = self
            .run
            .intervals
            .get(interval)
            .filter(|_| self.run.kind.has_lineages())?;
        let founders: BTreeSet<u16> = robots.iter().map(|own| own.founder).collect();
        Some(founders.len())
    }

    /// Minutes until all simulators descend from one.
    fn takeover(&self) -> f64 {
        if self.lineages_at(0).is_none() {
            return f64::NAN;
        }
        let end = (0..self.intervals()).find(|&interval| self.lineages_at(interval) == Some(1));
        let seconds = end.map_or(self.seconds(), |end| end * self.settings.clock.interval_s as usize);
        seconds as f64 / MINUTE as f64
    }

    fn area(&self) -> f64 {
        let chosen_under = |interval: usize, robot: usize| self.run.intervals[interval][robot].chosen_under;
        self.run.area(self.moves(), chosen_under).unwrap_or(f64::NAN)
    }
}

/// Where the last fifth begins.
fn late(length: usize) -> usize {
    length - length / 5
}
