//! The study of Miglino, Lund and Nolfi (1995): sample a robot, evolve in the simulator made from the samples, move
//! to reality, evolve on, and hold every claim of the paper against what came out.

pub(crate) mod arms;
mod full;
mod interpolation;
mod judge;
mod real_lives;
pub(crate) mod report;
pub(crate) mod results;
pub(crate) mod settings;
pub(crate) mod study;

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use clap::ValueEnum;
use oneiro::tables::{MotorSamples, MotorTable, SensorTables};
use oneiro::world::Robot;
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::cli::Miglino1995;
use crate::commands::sample;
use crate::console::{Console, columns};
use crate::engine::handle::Engine;
use crate::exit::{Failure, Result};
use crate::reality::Object;
use crate::reality::sampling::{self, Averaged};
use crate::record::write_whole;
use crate::studies::claims::Claim;
use crate::studies::directory;
use crate::{device, progress};
use arms::Arm;
use results::{Results, Run, Variant};
use settings::{REAL, SIMULATED, Settings};
use study::Study;

/// Runs of a condition that a study may have.
const GREATEST_RUNS: u32 = 1000;
/// Runs of a condition that advance together and are kept together.
const COHORT: u32 = 5;

/// Does the whole study, or goes on with it.
pub(crate) fn run(arguments: &Miglino1995, console: Console) -> Result {
    let evaluations = device::engine(&arguments.backend)?;
    if arguments.calibrate {
        calibrate(arguments.seed, &evaluations, console)?;
    } else {
        whole(arguments, &evaluations, console)?;
    }
    device::close(evaluations, console);
    Ok(())
}

/// The study that was asked for, and with `--sensitivity` under every other assumption too.
fn whole(arguments: &Miglino1995, evaluations: &Engine, console: Console) -> Result {
    directory::check_runs(arguments.runs, GREATEST_RUNS)?;
    let robot = sample::robot_seed(&arguments.robot)?;
    let under = |arm| -> Result<(Settings, Option<Robot>)> {
        let recordings = recordings(&arguments.tables, arm, console)?;
        let settings = Settings {
            seed: arguments.seed,
            runs: arguments.runs,
            robot,
            severity: arguments.severity,
            arm,
            full: arguments.full,
            tables: recordings.as_ref().map(hashes).unwrap_or_default(),
        };
        Ok((settings, recordings))
    };
    let (settings, recordings) = under(arguments.arm)?;
    let directory = arguments
        .out
        .clone()
        .unwrap_or_else(|| directory::usual("miglino1995", settings.seed, &settings));
    let main = study(&settings, recordings, evaluations, &directory, console)?;
    main.report(&directory, &[])?;
    if arguments.sensitivity {
        let mut arms = vec![(Arm::Main, main.claims.clone())];
        for &arm in Arm::value_variants().iter().filter(|arm| **arm != Arm::Main) {
            let (settings, recordings) = under(arm)?;
            let own = directory.join("arms").join(arm.name());
            console.say(format!("arm {}", arm.name()));
            let studied = study(&settings, recordings, evaluations, &own, console)?;
            studied.report(&own, &[])?;
            arms.push((arm, studied.claims));
        }
        let named: Vec<_> = arms.iter().map(|(arm, claims)| (arm.name(), claims.clone())).collect();
        directory::write_sensitivity(&directory, &named)?;
        main.report(&directory, &arms)?;
    }
    directory::tell(&main.claims, &directory, console)
}

/// A study that was done: all that its report is made of.
struct Studied<'a> {
    settings: &'a Settings,
    sensors: Arc<SensorTables>,
    results: Results,
    claims: Vec<Claim>,
}

impl Studied<'_> {
    /// Writes its report, with what came out under other assumptions where that is known.
    fn report(&self, directory: &Path, arms: &[(Arm, Vec<Claim>)]) -> Result {
        let world = self.settings.world();
        let html = report::html(&report::Study {
            results: &self.results,
            claims: &self.claims,
            sensors: &self.sensors,
            arena: &world.arena,
            body_radius: world.robot.body_radius,
            robot: &self.settings.describe(),
            seed: self.settings.seed,
            arms,
        });
        write_whole(&directory.join("report.html"), html.as_bytes())
    }
}

/// One study in its directory, all but its report: what is kept there already is not done again.
fn study<'a>(
    settings: &'a Settings,
    recordings: Option<Robot>,
    evaluations: &Engine,
    directory: &Path,
    console: Console,
) -> Result<Studied<'a>> {
    directory::open(directory, settings)?;
    let robot = match recordings {
        Some(robot) => robot,
        None => sampled(settings, evaluations, &directory.join("robot"), console)?,
    };
    let study = Study::new(settings, robot.clone(), evaluations)?;
    let begun = Instant::now();
    let to_and_fro = study.to_and_fro()?;
    let life_within_two_seconds = begun.elapsed().as_secs_f64() < 2.0 * to_and_fro.len() as f64;
    let results = Results {
        simulated_generations: SIMULATED,
        real_generations: REAL,
        population: settings.evolution().population,
        parents: settings.evolution().parents,
        cycles: settings.world().cycles,
        assumptions: settings.assumptions(),
        differences: study.differences()?,
        to_and_fro,
        life_within_two_seconds,
        variants: if settings.full {
            variants(settings, &study, &robot, evaluations, directory)?
        } else {
            Vec::new()
        },
        runs: cohorts(settings, &study, evaluations, directory, console)?,
    };
    let claims = judge::judge(&results, study.sensors());
    let text = serde_json::to_vec(&results).map_err(Failure::failed)?;
    write_whole(&directory.join("results.json"), &text)?;
    directory::write_claims(directory, &claims)?;
    for (name, csv) in report::csv_files(&results) {
        write_whole(&directory.join(name), csv.as_bytes())?;
    }
    Ok(Studied {
        settings,
        sensors: Arc::clone(study.sensors()),
        results,
        claims,
    })
}

/// The robot of recordings, if there are any.
fn recordings(paths: &[PathBuf], arm: Arm, console: Console) -> Result<Option<Robot>> {
    if paths.is_empty() {
        return Ok(None);
    }
    let is_motor = |path: &&PathBuf| path.file_stem().is_some_and(|name| name == "motor");
    let (motors, sensors): (Vec<_>, Vec<_>) = paths.iter().partition(is_motor);
    let import = SensorTables::read(&sensors).map_err(Failure::input)?;
    for warning in import.warnings {
        console.say(format!("warning: {warning}"));
    }
    let motors = match motors.first() {
        Some(path) => Arc::new(MotorTable::read(path, arm.states()).map_err(Failure::input)?),
        None => MotorTable::khepera(arm.states()),
    };
    Ok(Some(Robot {
        sensors: Arc::new(import.table),
        motors,
        ..Robot::khepera()
    }))
}

/// Hashes of what a robot was recorded to do.
fn hashes(robot: &Robot) -> Vec<String> {
    let hash = |text: String| blake3::hash(text.as_bytes()).to_hex()[..16].to_owned();
    let sensors = robot.sensors.classes.iter().map(|table| hash(table.text()));
    sensors.chain([hash(format!("{:?}", robot.motors.cells))]).collect()
}

/// The robot of the surrogate's samples.
fn sampled(settings: &Settings, evaluations: &Engine, directory: &Path, console: Console) -> Result<Robot> {
    let objects = Object::of_the_paper();
    let mut robot = settings
        .reality()
        .open(evaluations, &settings.world())
        .map_err(Failure::input)?;
    let samples = match settings.arm.turns() {
        1 => sample::take(&mut *robot, &objects, directory, console)?,
        turns => sample::take(&mut Averaged::new(&mut *robot, turns), &objects, directory, console)?,
    };
    Ok(simulated_robot(samples.sensors, &samples.motors, settings.arm))
}

/// The robot of a simulator that is made from samples.
fn simulated_robot(sensors: SensorTables, motors: &MotorSamples, arm: Arm) -> Robot {
    let motors = MotorTable::new(motors, arm.states());
    Robot {
        sensors: Arc::new(sensors),
        motors: Arc::new(motors.expect("all speeds were sampled")),
        ..Robot::khepera()
    }
}

/// The study's first half in other simulators; what was kept is not done again.
fn variants(
    settings: &Settings,
    study: &Study<'_>,
    own: &Robot,
    evaluations: &Engine,
    directory: &Path,
) -> Result<Vec<Variant>> {
    kept(&directory.join("variants.json"), || {
        let objects = Object::of_the_paper();
        let site = settings.other_reality();
        let mut robot = site.open(evaluations, &settings.world()).map_err(Failure::input)?;
        let mut averaged = Averaged::new(&mut *robot, settings.arm.turns());
        let samples = sampling::sample_unkept(&mut averaged, &objects)?;
        let other = simulated_robot(samples.sensors, &samples.motors, settings.arm);
        full::variants(settings, study, own, &other)
    })
}

/// What a file holds, or what is made now and then kept there.
fn kept<T: Serialize + DeserializeOwned>(path: &Path, make: impl FnOnce() -> Result<T>) -> Result<T> {
    if let Ok(bytes) = fs::read(path) {
        return serde_json::from_slice(&bytes)
            .map_err(|error| Failure::corrupt(format_args!("{}: {error}", path.display())));
    }
    let made = make()?;
    write_whole(path, &serde_json::to_vec(&made).map_err(Failure::failed)?)?;
    Ok(made)
}

/// All runs, some at a time; those that were kept are not run again.
fn cohorts(
    settings: &Settings,
    study: &Study<'_>,
    evaluations: &Engine,
    directory: &Path,
    console: Console,
) -> Result<Vec<Run>> {
    let cohorts = directory.join("cohorts");
    fs::create_dir_all(&cohorts).map_err(|error| Failure::storage(&cohorts, &error))?;
    let mut runs: Vec<Run> = Vec::new();
    let life = u64::from(settings.world().cycles) * u64::from(settings.evolution().population);
    // A generation a generation, and generation 200 some times more.
    let generations = SIMULATED + REAL + 5 + settings.arm.champion_lives().unwrap_or(0);
    let steps = 3 * u64::from(settings.runs) * u64::from(generations) * life + evaluations.control.steps();
    progress::watched(steps, "evolving", console, &evaluations.control, || -> Result {
        for first in (0..settings.runs).step_by(COHORT as usize) {
            let numbers = first..(first + COHORT).min(settings.runs);
            runs.extend(kept(&cohorts.join(format!("{first:04}.json")), || {
                study.cohort(numbers)
            })?);
        }
        Ok(())
    })?;
    Ok(runs)
}

/// The gap between simulation and reality without noise, by severity: what the severity is chosen by.
fn calibrate(seed: u64, evaluations: &Engine, console: Console) -> Result {
    /// Of `docs/preregistration-1995.md`.
    const ROBOTS: std::ops::RangeInclusive<u64> = 1001..=1005;
    const RUNS: u32 = 5;
    let mut rows = Vec::new();
    for quarter in 0..=8_u8 {
        let severity = f32::from(quarter) / 4.0;
        let mut gaps = Vec::new();
        for robot in ROBOTS {
            let settings = Settings {
                seed,
                runs: RUNS,
                robot,
                severity,
                arm: Arm::Main,
                full: false,
                tables: Vec::new(),
            };
            let objects = Object::of_the_paper();
            let site = settings.reality();
            let mut own = site.open(evaluations, &settings.world()).map_err(Failure::input)?;
            let samples = sampling::sample_unkept(&mut *own, &objects)?;
            let study = Study::new(
                &settings,
                simulated_robot(samples.sensors, &samples.motors, settings.arm),
                evaluations,
            )?;
            gaps.push(study.gap_without_noise(RUNS)?);
        }
        let mean = gaps.iter().sum::<f64>() / gaps.len() as f64;
        let row: Vec<String> = [f64::from(severity), mean]
            .iter()
            .chain(&gaps)
            .map(|value| format!("{value:.3}"))
            .collect();
        console.say(format!("severity {severity}: d {mean:.3}"));
        rows.push(row);
    }
    let head = ["severity", "mean d", "1001", "1002", "1003", "1004", "1005"];
    console.data(columns(&head, &rows))
}

#[cfg(test)]
mod tests;
