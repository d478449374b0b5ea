//! The numbers behind the figures, for readers who want to do their own statistics.

use super::measures::{BIN, G0, G1, MINUTE, S0, at_the_end, intervals, level, robots_at, runs_of, shares, total};
use super::{name, questions};
use crate::report::csv::{Csv, known, number};
use crate::studies::odowd2014::results::{Case, Combination, Kind, Results, Run};

/// Names and contents of the files: one row per run; one row per robot and interval of the runs that are as in the
/// paper; food in bins of 250 s; and by interval, over all runs of a case and kind, means and standard deviations of
/// genes and shares of what they select.
pub(crate) fn csv_files(results: &Results) -> Vec<(&'static str, String)> {
    vec![
        ("runs.csv", runs(results)),
        ("intervals.csv", robots(results)),
        ("rates.csv", rates(results)),
        ("genes.csv", genes(results)),
        ("bins.csv", bins(results)),
    ]
    .into_iter()
    .chain((!results.questions.is_empty()).then(|| ("questions.csv", questions::csv(results))))
    .collect()
}

/// Fields that identify a row's combination, case and kind.
fn whose(combination: &Combination, case: Case, kind: Kind) -> [String; 4] {
    [
        number(combination.scale),
        name(&combination.credit),
        name(&case),
        name(&kind),
    ]
}

/// A file whose rows begin with those fields.
fn file(columns: &str) -> Csv {
    Csv::new("scale,credit,case,kind".split(',').chain(columns.split(',')))
}

/// Runs with their identifying fields and their number.
fn all_runs(results: &Results) -> impl Iterator<Item = (Vec<String>, &Run)> {
    results.combinations.iter().flat_map(|combination| {
        combination.runs.iter().map(move |run| {
            let mut whose = Vec::from(whose(combination, run.case, run.kind));
            whose.push(run.number.to_string());
            (whose, run)
        })
    })
}

/// Cases and kinds that have runs, with their identifying fields.
fn groups(results: &Results) -> impl Iterator<Item = ([String; 4], Vec<&Run>)> {
    results.combinations.iter().flat_map(|combination| {
        let kinds = Case::ALL
            .into_iter()
            .flat_map(|case| Kind::ALL.map(|kind| (case, kind)));
        kinds.filter_map(move |(case, kind)| {
            let runs = runs_of(combination, case, kind);
            (!runs.is_empty()).then(|| (whose(combination, case, kind), runs))
        })
    })
}

fn runs(results: &Results) -> String {
    let mut table = file("run,brought,first_half,second_half,s0_opposite,s0_no_light,s0_over,s0,g0,g1");
    let half = results.light_moves_minute as usize * MINUTE;
    for (whose, run) in all_runs(results) {
        let (first, second) = run.brought.split_at(half.min(run.brought.len()));
        let brought = [total(&run.brought), total(first), total(second)].map(|food| food.to_string());
        let shares = shares(at_the_end(run), S0).map(known);
        let means = [S0, G0, G1].map(|gene| known(level(at_the_end(run), gene).0));
        table.row(whose.into_iter().chain(brought).chain(shares).chain(means));
    }
    table.text()
}

fn robots(results: &Results) -> String {
    let mut table = file("run,interval,robot,s0,chosen_under,g0,g1,real,simulated,heard,reached,taken");
    // The rows of all kinds would take a hundred megabytes.
    for (whose, run) in all_runs(results).filter(|(_, run)| run.kind == Kind::Evolved) {
        for (interval, robots) in run.intervals.iter().enumerate() {
            for (place, robot) in robots.iter().enumerate() {
                let gene = |x: f32| number(f64::from(x));
                let fields = [
                    interval.to_string(),
                    place.to_string(),
                    gene(robot.s0),
                    gene(robot.chosen_under),
                    gene(robot.g0),
                    gene(robot.g1),
                    gene(robot.real),
                    robot.simulated.map_or_else(String::new, gene),
                    robot.heard.to_string(),
                    robot.reached.to_string(),
                    u8::from(robot.taken).to_string(),
                ];
                table.row(whose.iter().cloned().chain(fields));
            }
        }
    }
    table.text()
}

fn rates(results: &Results) -> String {
    let mut table = file("run,from,to,brought,per_minute");
    for (whose, run) in all_runs(results) {
        let per_minute = super::measures::rates(run, BIN);
        for (bin, (food, rate)) in run.brought.chunks(BIN).zip(per_minute).enumerate() {
            let from = bin * BIN;
            let fields = [
                from.to_string(),
                (from + food.len()).to_string(),
                total(food).to_string(),
                number(rate),
            ];
            table.row(whose.iter().cloned().chain(fields));
        }
    }
    table.text()
}

fn genes(results: &Results) -> String {
    let mut table = file("interval,robots,s0_mean,s0_sd,g0_mean,g0_sd,g1_mean,g1_sd");
    for (whose, runs) in groups(results) {
        for interval in 0..intervals(&runs) {
            let at = || robots_at(&runs, interval);
            let levels = [S0, G0, G1].map(|gene| level(at(), gene));
            let levels = levels
                .into_iter()
                .flat_map(|(mean, deviation)| [known(mean), known(deviation)]);
            let place = [interval.to_string(), at().count().to_string()];
            table.row(whose.iter().cloned().chain(place).chain(levels));
        }
    }
    table.text()
}

fn bins(results: &Results) -> String {
    let mut table =
        file("interval,s0_opposite,s0_no_light,s0_over,g0_flees,g0_random,g0_seeks,g1_flees,g1_random,g1_seeks");
    for (whose, runs) in groups(results) {
        for interval in 0..intervals(&runs) {
            let shares = [S0, G0, G1].map(|gene| shares(robots_at(&runs, interval), gene));
            let shares = shares.into_iter().flatten().map(known);
            table.row(whose.iter().cloned().chain([interval.to_string()]).chain(shares));
        }
    }
    table.text()
}
