//! Connectivity of the swarm: who hears whom, and whose simulators are passed on.

use oneiro_report::numbers::{percent, shown};
use oneiro_report::page::{Cell, Head, Row, table};
use oneiro_statistics::mean;

use super::measures::runs_of;
use super::{DIGITS, case_name, evolving, named};
use crate::odowd2014::results::{Combination, Kind, Results, RobotInterval, Run};

pub(super) fn html(results: &Results, combination: &Combination) -> String {
    let head = [
        Head::Text("Case"),
        Head::Number("robots heard"),
        Head::Number("heard nobody, %"),
        Head::Number("swarm reached, %"),
        Head::Number("took another's simulator, %"),
        Head::Number("the same, fitness shuffled"),
    ];
    let robots = f64::from(results.robots.max(1));
    let rows: Vec<Row> = evolving()
        .filter_map(|case| {
            let own = runs_of(combination, case, Kind::Evolved);
            let null = runs_of(combination, case, Kind::FitnessShuffled);
            if own.is_empty() {
                return None;
            }
            let share = |runs: &[&Run], of: fn(&RobotInterval) -> bool| {
                Cell::number(percent(over(runs, |robot| f64::from(u8::from(of(robot))))))
            };
            let cells = vec![
                Cell::html(case_name(case)),
                Cell::number(shown(over(&own, |robot| f64::from(robot.heard)), DIGITS)),
                share(&own, |robot| robot.heard == 0),
                Cell::number(percent(over(&own, |robot| f64::from(robot.reached)) / robots)),
                Cell::number(percent(taken(&own))),
                Cell::number(percent(taken(&null))),
            ];
            Some(cells.into())
        })
        .collect();
    let words = "Of each robot in each minute, mean of all: how many others it heard; the part of the swarm, itself among \
                 it, that encounters of that minute join it to by whatever many steps; and how often the simulator that it \
                 went on with was another robot's.";
    table(&named("Encounters", combination), words, &head, &rows)
}

/// Share of intervals after which robots adopted another's simulator; nothing is adopted after the last.
fn taken(runs: &[&Run]) -> f64 {
    let decided = |run: &&Run| run.intervals.len().saturating_sub(1);
    let robots = runs
        .iter()
        .flat_map(|run| run.intervals.iter().take(decided(run)).flatten());
    mean(robots.map(|robot| f64::from(u8::from(robot.taken))))
}

/// Mean over all robots and intervals of some runs.
fn over(runs: &[&Run], of: impl Fn(&RobotInterval) -> f64) -> f64 {
    mean(runs.iter().flat_map(|run| run.intervals.iter().flatten()).map(of))
}
