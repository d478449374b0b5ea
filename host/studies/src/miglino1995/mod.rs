//! The study of Miglino, Lund and Nolfi (1995): sample a robot, evolve in a simulator made from the samples, transfer
//! to reality, continue evolving there, and test every claim of the paper.

mod calibration;
mod evolving;
mod full;
mod interpolation;
mod judge;
mod measures;
mod planned;
mod real_episodes;
mod report;
mod results;
mod second;
pub mod settings;
mod study;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use oneiro::tables::{MotorSamples, MotorStates, MotorTable, SensorTables};
use oneiro::world::Robot;
use oneiro_report::numbers::fixed;

#[cfg(any(test, feature = "testing"))]
pub(super) use self::second::contents as contents_of_second;
pub use self::second::judge_sweeps;
use crate::assumptions::Assumption;
use crate::claims::Claim;
use crate::directory::{self, Directory, Reproduction, Request};
use crate::file::{Arm, Edition, MIGLINO1995, StudyFile};
use crate::verdicts::Sensitivity;
use crate::{Findings, sweep_results};
use oneiro_base::answer::Answer;
use oneiro_base::console::{Console, columns};
use oneiro_base::contents::Entry;
use oneiro_base::exit::{Failure, Result};
use oneiro_base::progress;
use oneiro_lab::device::{self, Backend};
use oneiro_lab::engine::handle::Engine;
use oneiro_lab::reality::Object;
use oneiro_lab::reality::sampling::{self, Averaged};
use oneiro_lab::reality::site::{LIVES, Site};
use oneiro_robots::address::{Address, Wire};
use oneiro_statistics::mean;
use results::{Results, Run, Variant};
use settings::{Asked, Calibration, Settings};
use study::Study;

/// Most runs of a condition.
const GREATEST_RUNS: u32 = 1000;
/// Runs of a condition that advance, and are saved, together, where reality is a simulation.
const COHORT: u32 = 5;

/// Runs or resumes the whole study, with the files of a recorded robot's tables, if there are any.
pub fn run(asked: &Asked, tables: &[PathBuf], request: &Request<'_>, console: Console) -> Result<Answer<Findings>> {
    let evaluations = device::engine(request.backend)?;
    let file = StudyFile::open(&MIGLINO1995, request.file)?.in_edition(request.edition)?;
    if let Some(severity) = asked.severity
        && !request.sensitivity
        && file.arm(request.arm)?.changes(["reality", "severity"])
    {
        return Err(Failure::input(format_args!(
            "--severity {severity}: is given with --arm {}, which sets it; allowed: one of the two",
            request.arm
        )));
    }
    let least = match &asked.robot {
        Address::Surrogate(_) => 2,
        Address::Wire(wire) => {
            check_connected(wire, asked, tables, request)?;
            1
        }
    };
    let allowed = least..=GREATEST_RUNS;
    if let Some(runs) = asked.runs {
        directory::check_runs(runs, &allowed)?;
    }
    let under = |arm: &str| -> Result<Whole<'_>> {
        let states = Settings::new(&file, arm, asked.clone())?.states();
        let recordings = recordings(tables, states, console)?;
        let asked = Asked {
            tables: recordings.as_ref().map(hashes).unwrap_or_default(),
            ..asked.clone()
        };
        let settings = Settings::new(&file, arm, asked)?;
        directory::check_runs(settings.runs, &allowed)?;
        Ok(Whole {
            settings,
            recordings,
            evaluations: &evaluations,
        })
    };
    let found = directory::reproduce(request, &file, under, console)?;
    device::close(evaluations, console);
    Ok(found)
}

/// Refuses options that only a surrogate has, and a connected robot without samples, which need a person to be taken.
fn check_connected(wire: &Wire, asked: &Asked, tables: &[PathBuf], request: &Request<'_>) -> Result {
    let options = [
        ("--severity", asked.severity.is_some()),
        ("--full", asked.full),
        ("--sensitivity", request.sensitivity),
    ];
    if let Some((option, _)) = options.iter().find(|(_, is_given)| *is_given) {
        return Err(Failure::input(format_args!(
            "{option}: is given with --robot {wire}; allowed: with a surrogate"
        )));
    }
    if tables.is_empty() {
        return Err(Failure::input(format_args!(
            "--robot {wire}: lacks --tables, the samples that its simulator is made from; take them with `oneiro robot sample \
             --robot {wire} --objects wall,round --out samples`, and add --tables \
             samples/wall.sam,samples/round.sam,samples/motor.sam"
        )));
    }
    Ok(())
}

/// A study under one arm, with a recorded robot if recordings are given.
struct Whole<'a> {
    settings: Settings,
    recordings: Option<Robot>,
    evaluations: &'a Engine,
}

impl Whole<'_> {
    /// Runs the study with reality at a site.
    fn at(&self, site: Site, directory: &Directory, console: Console) -> Result<(Arc<SensorTables>, Results)> {
        let Self {
            settings, evaluations, ..
        } = self;
        let robot = match &self.recordings {
            Some(robot) => robot.clone(),
            None => sampled_robot(settings, evaluations, &directory.folder("robot")?, console)?,
        };
        let study = Study::new(settings, robot.clone(), site, evaluations, console)?;
        let start = Instant::now();
        let to_and_fro = study.to_and_fro()?;
        let life_within_two_seconds = start.elapsed().as_secs_f64() < 2.0 * to_and_fro.len() as f64;
        let evolution = settings.evolution();
        let results = Results {
            simulated_generations: settings.simulated_generations(),
            real_generations: settings.reality.generations,
            population: evolution.population,
            parents: evolution.parents,
            cycles: settings.world().cycles,
            assumptions: settings.assumptions(),
            differences: study.differences()?,
            to_and_fro,
            life_within_two_seconds,
            is_wired: settings.is_wired(),
            variants: if settings.is_full() {
                directory.kept("variants", || variants(settings, &study, &robot, evaluations))?
            } else {
                Vec::new()
            },
            runs: cohorts(settings, &study, evaluations, directory, console)?,
        };
        Ok((Arc::clone(study.sensors()), results))
    }
}

impl Reproduction for Whole<'_> {
    const NAME: &'static str = "miglino1995";

    /// The sampled sensors, and the results of the study that used them.
    type Found = (Arc<SensorTables>, Results);

    fn seed(&self) -> u64 {
        self.settings.seed()
    }

    fn record(&self) -> String {
        self.settings.record()
    }

    fn assumptions(&self) -> Vec<Assumption> {
        self.settings.assumptions()
    }

    fn run(&self, directory: &Directory, console: Console) -> Result<Self::Found> {
        let site = self.settings.site().recorded(directory.join(LIVES), console);
        self.at(site, directory, console)
    }

    fn judge(&self, (sensors, results): &Self::Found) -> Vec<Claim> {
        let settings = &self.settings;
        judge::judge(&judge::Judging {
            results,
            sensors,
            is_real_robot: self.recordings.is_some(),
            corners: measures::corners(&settings.world().arena),
            edition: settings.edition,
            planned: settings.is_calibrated_main().then(|| &*planned::PLANNED),
        })
    }

    fn json(&self, (_, results): &Self::Found) -> Result<Vec<u8>> {
        serde_json::to_vec(results).map_err(Failure::failed)
    }

    fn contents(&self) -> Vec<Entry> {
        let settings = &self.settings;
        contents(self.recordings.is_none(), settings.is_full(), settings.is_wired())
    }

    fn csv(&self, (_, results): &Self::Found) -> Vec<(&'static str, String)> {
        report::csv_files(results)
    }

    fn html(&self, (sensors, results): &Self::Found, claims: &[Claim], arms: Option<&Sensitivity>) -> String {
        let world = self.settings.world();
        report::html(&report::Report {
            results,
            claims,
            sensors,
            arena: &world.arena,
            body_radius: world.robot.body_radius,
            robot: &self.settings.describe(),
            seed: self.seed(),
            edition: self.settings.edition,
            arms,
        })
    }
}

/// The files of the study's directory that other studies don't have.
pub(super) fn contents(has_samples: bool, is_full: bool, is_wired: bool) -> Vec<Entry> {
    let mut all = report::contents(is_full);
    if is_wired {
        let lives = "with a connected robot: the record of all its episodes, from which a stopped study continues";
        all.push(Entry::file(format!("{LIVES}/"), lives));
    }
    if has_samples {
        let robot = "the sampled robot: a table and a picture per kind of object, the motors, and each row as sampled";
        all.push(Entry::file("robot/", robot));
    }
    if is_full {
        let variants = "with `--full`: finished runs in other simulators, from which a stopped study continues";
        all.push(Entry::file("variants", variants));
    }
    all
}

/// The recorded robot, if recordings are given.
fn recordings(paths: &[PathBuf], states: MotorStates, console: Console) -> Result<Option<Robot>> {
    if paths.is_empty() {
        return Ok(None);
    }
    let is_motor = |path: &&PathBuf| path.file_stem().is_some_and(|name| name == "motor");
    let (motors, sensors): (Vec<_>, Vec<_>) = paths.iter().partition(is_motor);
    let import = SensorTables::read(&sensors).map_err(Failure::input)?;
    console.warn(import.warnings);
    let motors = match motors.first() {
        Some(path) => Arc::new(MotorTable::read(path, states).map_err(Failure::input)?),
        None => MotorTable::khepera(states),
    };
    Ok(Some(Robot {
        sensors: Arc::new(import.table),
        motors,
        ..Robot::khepera()
    }))
}

/// Hashes of a robot's recordings.
fn hashes(robot: &Robot) -> Vec<String> {
    let hash = |text: String| blake3::hash(text.as_bytes()).to_hex()[..16].to_owned();
    let sensors = robot.sensors.classes.iter().map(|table| hash(table.text()));
    sensors.chain([hash(format!("{:?}", robot.motors.cells))]).collect()
}

/// The simulated robot made from the surrogate's samples.
fn sampled_robot(settings: &Settings, evaluations: &Engine, directory: &Path, console: Console) -> Result<Robot> {
    let objects = Object::of_the_paper();
    let site = settings.site();
    let mut robot = site.sampled(evaluations, &settings.world())?;
    let samples = match settings.samples.turns {
        1 => sampling::take(&mut *robot, &objects, directory, console.bars())?,
        turns => sampling::take(
            &mut Averaged::new(&mut *robot, turns),
            &objects,
            directory,
            console.bars(),
        )?,
    };
    Ok(simulated_robot(settings, samples.sensors, &samples.motors))
}

/// A simulated robot made from samples.
fn simulated_robot(settings: &Settings, sensors: Arc<SensorTables>, motors: &MotorSamples) -> Robot {
    let motors = MotorTable::new(motors, settings.states());
    Robot {
        sensors,
        motors: Arc::new(motors.expect("all speeds were sampled")),
        ..Robot::khepera()
    }
}

/// Samples a robot without saving the samples, and makes the simulated robot from them.
fn sampled_unkept(settings: &Settings, site: &Site, evaluations: &Engine) -> Result<Robot> {
    let mut robot = site.sampled(evaluations, &settings.world())?;
    let mut averaged = Averaged::new(&mut *robot, settings.samples.turns);
    let samples = sampling::sample_unkept(&mut averaged, &Object::of_the_paper())?;
    Ok(simulated_robot(settings, samples.sensors, &samples.motors))
}

/// The study's simulated half in other simulators.
fn variants(settings: &Settings, study: &Study<'_>, robot: &Robot, evaluations: &Engine) -> Result<Vec<Variant>> {
    let Some(site) = settings.other_site() else {
        return Ok(Vec::new());
    };
    let other = sampled_unkept(settings, &site, evaluations)?;
    full::variants(settings, study, robot, &other)
}

/// All runs, one cohort at a time; saved ones aren't run again.
fn cohorts(
    settings: &Settings,
    study: &Study<'_>,
    evaluations: &Engine,
    directory: &Directory,
    console: Console,
) -> Result<Vec<Run>> {
    let mut runs: Vec<Run> = Vec::new();
    // With fewer runs at once, a connected robot completes its first runs earlier. Conditions still take turns.
    let cohort = if settings.is_wired() { 1 } else { COHORT };
    let saved = |first: u32| format!("cohorts/{first:04}");
    let mut all = || -> Result {
        for first in (0..settings.runs).step_by(cohort as usize) {
            let numbers = first..(first + cohort).min(settings.runs);
            runs.extend(directory.kept(&saved(first), || study.cohort(numbers))?);
        }
        Ok(())
    };
    if settings.is_wired() {
        let left = (0..settings.runs).filter(|&first| !directory.join(&saved(first)).exists());
        if let Some(time) = settings.time(left.count() as u32) {
            console.say(time);
        }
        all()?;
    } else {
        let life = u64::from(settings.world().cycles) * u64::from(settings.evolution().population);
        // One step per generation, a few more for the transferred one.
        let generations = settings.evolution().generations + 5 + settings.champion.lives;
        let steps = 3 * u64::from(settings.runs) * u64::from(generations) * life + evaluations.control.steps();
        progress::watched(steps, "evolving", console.bars(), &evaluations.control, all)?;
    }
    Ok(runs)
}

/// Measures the gap between simulation and reality without noise by severity; the first edition's severity was chosen from it.
pub fn calibrate(file: Option<&Path>, seed: u64, backend: &Backend, console: Console) -> Result<Answer<Findings>> {
    let evaluations = device::engine(backend)?;
    let file = StudyFile::open(&MIGLINO1995, file)?.in_edition(Edition::First)?;
    let of = |robot: u64, severity: Option<f32>| {
        let asked = Asked {
            seed,
            runs: None,
            robot: Address::Surrogate(robot),
            severity,
            full: false,
            tables: Vec::new(),
        };
        Settings::new(&file, Arm::MAIN, asked)
    };
    let Calibration {
        runs,
        robots,
        severities,
    } = of(0, None)?.calibration;
    let mut rows = Vec::new();
    for severity in severities {
        let mut gaps = Vec::new();
        for &robot in &robots {
            let settings = of(robot, Some(severity))?;
            let robot = sampled_unkept(&settings, &settings.site(), &evaluations)?;
            let study = Study::new(&settings, robot, settings.site(), &evaluations, console)?;
            gaps.push(study.gap_without_noise(runs)?);
        }
        let mean = mean(&gaps);
        let row: Vec<String> = [f64::from(severity), mean]
            .iter()
            .chain(&gaps)
            .map(|value| fixed(*value, 3))
            .collect();
        console.say(format!("severity {severity}: d {}", fixed(mean, 3)));
        rows.push(row);
    }
    let robots: Vec<String> = robots.iter().map(u64::to_string).collect();
    let head: Vec<&str> = ["severity", "mean d"]
        .into_iter()
        .chain(robots.iter().map(String::as_str))
        .collect();
    device::close(evaluations, console);
    let table = rows
        .iter()
        .map(|cells| sweep_results::row(head.iter().copied(), cells.iter().map(String::as_str)));
    let tables = BTreeMap::from([("calibration".to_owned(), table.collect())]);
    Ok(Answer::new(columns(&head, &rows), Findings::Tables(tables)))
}

#[cfg(test)]
mod tests;
