//! Connectivity of the swarm: which robots hear each other, and which simulators are passed on.

use oneiro_report::numbers::{percent, shown};
use oneiro_report::page::{Cell, Head, Row, table};
use oneiro_statistics::mean;

use super::measures::runs_of;
use super::{DIGITS, case_name, evolving_cases, named};
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
    let rows: Vec<Row> = evolving_cases()
        .filter_map(|case| {
            let runs = runs_of(combination, case, Kind::Evolved);
            let null = runs_of(combination, case, Kind::FitnessShuffled);
            if runs.is_empty() {
                return None;
            }
            let share = |runs: &[&Run], of: fn(&RobotInterval) -> bool| {
                Cell::number(percent(over(runs, |robot| f64::from(u8::from(of(robot))))))
            };
            let cells = vec![
                Cell::html(case_name(case)),
                Cell::number(shown(over(&runs, |robot| f64::from(robot.heard)), DIGITS)),
                share(&runs, |robot| robot.heard == 0),
                Cell::number(percent(over(&runs, |robot| f64::from(robot.reached)) / robots)),
                Cell::number(percent(adoption_rate(&runs))),
                Cell::number(percent(adoption_rate(&null))),
            ];
            Some(cells.into())
        })
        .collect();
    let words = "Means over robots and minutes: how many others a robot heard; the part of the swarm, including \
                 itself, that the minute's encounters link it to, directly or through others; and how often it took \
                 another robot's simulator.";
    table(&named("Encounters", combination), words, &head, &rows)
}

/// Fraction of intervals after which robots adopted another's simulator; nothing is adopted after the last.
fn adoption_rate(runs: &[&Run]) -> f64 {
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
