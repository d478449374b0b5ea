//! Compares fleets' records with the batched study of the same experiment.

use std::path::{Path, PathBuf};

use oneiro::foraging::Light;
use oneiro::swarm::Line;
use oneiro_base::exit::{Failure, Result};
use oneiro_base::plain;
use oneiro_evolve::encapsulated::GREATEST;
use oneiro_lab::engine::handle::Engine;
use oneiro_lab::swarm::Plan;
use oneiro_lab::swarm::clock::Clock;
use oneiro_lab::swarm::job::SwarmJob;
use oneiro_lab::swarm::record::RobotInterval;
use oneiro_statistics::{Interval, bootstrap_interval, mean, variance};
use rand::SeedableRng;
use rand_pcg::Pcg64;
use serde::{Deserialize, Serialize};

use crate::daemon::intervals::INTERVALS;

/// The probability of each figure's interval.
pub const LEVEL: f64 = 0.9;
const RESAMPLES: usize = 10_000;

/// What came of a run. Only intervals count that all robots end before the experiment does.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Figures {
    /// The run: a directory, or a seed.
    pub run: String,
    /// Food that all robots brought.
    pub food: f64,
    /// The fraction of simulators that have the light where it is, in the last fifth of the intervals (one interval or
    /// more).
    pub right: f64,
    /// The mean gene of simulators there.
    pub gene: f64,
    /// Intervals of robots that are not in the record, or that a daemon did not live through.
    pub missed: u32,
}

/// A robot's interval.
#[derive(Clone, Copy, Debug, Deserialize)]
struct Row {
    interval: u32,
    s0: f32,
    brought: u32,
    missed: u8,
}

/// The intervals that all robots end.
fn intervals(plan: &Plan) -> u32 {
    let last = plan.settings.seconds();
    let whole = |clock: &Clock| last.saturating_sub(clock.offset) / clock.interval;
    plan.clocks().iter().map(whole).min().unwrap_or(0)
}

/// The figures of a run from its robots' intervals.
fn figures(plan: &Plan, run: String, rows: impl IntoIterator<Item = Row>) -> Figures {
    let (count, robots) = (intervals(plan), plan.settings.world.robots);
    let [_, light] = plan.settings.case.lights();
    let rows: Vec<Row> = rows.into_iter().filter(|row| row.interval < count).collect();
    let late = || {
        rows.iter()
            .filter(|row| row.interval >= count.saturating_sub((count / 5).max(1)))
    };
    let lived = rows.iter().filter(|row| row.missed == 0).count() as u32;
    Figures {
        run,
        food: rows.iter().map(|row| f64::from(row.brought)).sum(),
        right: mean(late().map(|row| f64::from(u8::from(Light::of_gene(row.s0) == light)))),
        gene: mean(late().map(|row| f64::from(row.s0))),
        missed: (count * robots).saturating_sub(lived),
    }
}

/// The figures of a fleet's record: the directory of a twin, or of a fleet after `oneiro fleet collect`.
///
/// # Errors
/// Exit 3: there is no table of intervals; exit 5: a table that is not one.
pub fn of_directory(plan: &Plan, directory: &Path) -> Result<Figures> {
    let of_twin = directory.join("robots");
    let tables: Vec<PathBuf> = if of_twin.is_dir() {
        (0..plan.settings.world.robots)
            .map(|robot| of_twin.join(robot.to_string()).join(INTERVALS))
            .collect()
    } else {
        vec![directory.join(INTERVALS)]
    };
    let mut rows = Vec::new();
    for path in tables.iter().filter(|path| path.is_file()) {
        let damaged = |error: csv::Error| Failure::corrupt(format_args!("{}: {error}", path.display()));
        let table = plain::open_table(path).map_err(|error| Failure::storage(path, &error))?;
        let mut table = csv::Reader::from_reader(table);
        for row in table.deserialize() {
            let row: Row = row.map_err(damaged)?;
            let (food, genes) = (plan.settings.limits().food, 0.0..=GREATEST as f32);
            if row.brought > food || !genes.contains(&row.s0) {
                let (path, Row { brought, s0, .. }) = (path.display(), row);
                return Err(Failure::corrupt(format_args!(
                    "{path}: interval {}: brought is {brought} and s0 {s0}; allowed: up to {food}, and 0 to {GREATEST}",
                    row.interval
                )));
            }
            rows.push(row);
        }
    }
    if rows.is_empty() {
        return Err(Failure::input(format_args!(
            "{}: has no {INTERVALS} with an interval; allowed: the directory of a twin, or of a fleet after `oneiro fleet collect`",
            directory.display()
        )));
    }
    Ok(figures(plan, directory.display().to_string(), rows))
}

/// The figures of batched runs.
///
/// # Errors
/// Those of the engine.
pub fn batched(plans: &[Plan], engine: &Engine) -> Result<Vec<Figures>> {
    let jobs = plans
        .iter()
        .cloned()
        .map(|plan| SwarmJob::new(plan).keeping_lines())
        .collect();
    let jobs = engine.finished(jobs, &mut ())?;
    let of_job = |(plan, job): (&Plan, &SwarmJob)| figures(plan, plan.seed.to_string(), rows(plan, job));
    Ok(plans.iter().zip(&jobs).map(of_job).collect())
}

fn rows(plan: &Plan, job: &SwarmJob) -> Vec<Row> {
    let (clocks, lines) = (plan.clocks(), job.lines());
    let brought = |robot: usize, interval: usize| {
        let seconds = clocks[robot].seconds_of(interval as u32);
        let lines = lines.iter().take(seconds.end as usize).skip(seconds.start as usize);
        lines.map(|line: &Line| line.robots[robot].brought).sum()
    };
    let of_interval = |(interval, robots): (usize, &Vec<_>)| {
        let of_robot = |(robot, of_robot): (usize, &RobotInterval)| Row {
            interval: interval as u32,
            s0: of_robot.s0,
            brought: brought(robot, interval),
            missed: 0,
        };
        robots.iter().enumerate().map(of_robot).collect::<Vec<_>>()
    };
    job.run().intervals.iter().enumerate().flat_map(of_interval).collect()
}

/// A figure of both sides.
#[derive(Clone, Debug, Serialize)]
pub struct Compared {
    /// Its name, with its unit.
    pub figure: &'static str,
    /// Mean and standard deviation of the fleet's runs, and of the batched ones; a single run has no deviation (NaN, null in JSON).
    pub fleet: [f64; 2],
    pub batched: [f64; 2],
    /// How much more the fleet has: a fraction of the batched runs' mean if `is_share`. None where that is 0.
    pub difference: Option<f64>,
    /// The ends of its interval; none where there is no share of a mean that may be 0, and where one side has a single run.
    pub interval: Option<[f64; 2]>,
    pub is_share: bool,
}

/// Compares the means of both sides, with bootstrap intervals.
pub fn compare(fleet: &[Figures], batched: &[Figures]) -> Vec<Compared> {
    type Figure = fn(&Figures) -> f64;
    let all: [(&str, Figure, bool); 3] = [
        ("food, items", |figures| figures.food, true),
        ("right simulators, fraction", |figures| figures.right, false),
        ("gene of simulators", |figures| figures.gene, false),
    ];
    let compared = |(figure, of, is_share): (&'static str, Figure, bool)| {
        let [fleet, batched] = [fleet, batched].map(|side| side.iter().map(of).collect::<Vec<f64>>());
        let difference = |a: &[f64], b: &[f64]| {
            let difference = mean(a) - mean(b);
            if is_share { difference / mean(b) } else { difference }
        };
        let mut random = Pcg64::seed_from_u64(0);
        let of_both = |both: &[Vec<f64>]| difference(&both[0], &both[1]);
        let interval = bootstrap_interval(&[&fleet, &batched], of_both, LEVEL, RESAMPLES, &mut random);
        // One run does not show how runs differ.
        let interval = interval.ok().filter(|_| fleet.len().min(batched.len()) > 1);
        let side = |sample: &[f64]| [mean(sample), variance(sample).sqrt()];
        Compared {
            figure,
            fleet: side(&fleet),
            batched: side(&batched),
            difference: Some(difference(&fleet, &batched)).filter(|difference| difference.is_finite()),
            interval: interval.map(|Interval { low, high }| [low, high]),
            is_share,
        }
    };
    all.into_iter().map(compared).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use oneiro_lab::swarm::record::Kind;
    use oneiro_lab::swarm::settings::Settings;

    /// A robot's table has what its computer has written there: numbers that no robot can have are no figures.
    #[test]
    fn impossible_numbers_of_a_robot_are_refused() {
        let plan = Plan {
            settings: Settings::default(),
            kind: Kind::Evolved,
            number: 0,
            seed: 1,
        };
        let directory = std::env::temp_dir().join(format!("oneiro-compare-{}", std::process::id()));
        std::fs::create_dir_all(&directory).unwrap();
        for (row, is_valid) in [
            ("0,0.5,15000,0", true),
            ("0,0.99,0,1", true),
            ("4294967295,0.5,7,0", true),
            ("0,0.5,15001,0", false),
            ("0,0.5,4294967295,0", false),
            ("0,NaN,1,0", false),
            ("0,1.5,1,0", false),
            ("0,-inf,1,0", false),
            ("0,0.5,-1,0", false),
        ] {
            let text = format!("interval,s0,brought,missed\n{row}\n");
            std::fs::write(directory.join(INTERVALS), text).unwrap();
            let outcome = of_directory(&plan, &directory);
            assert_eq!(outcome.is_ok(), is_valid, "{row}: {:?}", outcome.err());
            assert!(outcome.err().is_none_or(|refusal| refusal.code() == 5), "{row}");
        }
        std::fs::remove_dir_all(&directory).unwrap();
    }
}
