//! `oneiro robot calibrate`: how well a simulator predicts a robot.

use std::fmt::Write as _;

use oneiro_base::answer::Answer;
use oneiro_base::console::{Console, counted};
use oneiro_base::contents::{Column, Entry, README, describe};
use oneiro_base::disk;
use oneiro_base::exit::{Failure, Result};
use oneiro_base::files;
use oneiro_base::files::directory::Filling;
use oneiro_lab::calibrate::readings::{Errors, RANGES};
use oneiro_lab::calibrate::{Calibration, logged, page};
use oneiro_lab::device;
use oneiro_lab::experiment::Experiment;
use oneiro_report::csv::{Csv, known};
use oneiro_report::numbers::significant;
use oneiro_report::page::{FIGURES, FIGURES_ABOUT, write as write_page};
use serde_json::json;

use crate::cli::RobotCalibrate;
use crate::commands::places::settings_typed;

const PAGE: &str = "calibration.html";
const ERRORS: &str = "errors.csv";
const SETTINGS: &str = "settings.toml";

static COLUMNS: [Column; 6] = [
    Column::text("sensor", "its name in the experiment"),
    Column::text(
        "distance",
        "from the robot's rim to the nearest object; `all` for all distances",
    ),
    Column::whole("cycles", "", "cycles that were compared"),
    Column::number("mean", "", "mean of reading minus prediction, as activations"),
    Column::number("deviation", "", "its standard deviation"),
    Column::number("size", "", "the root of its mean square"),
];

/// Compares, and writes the page, the table and the settings.
pub(crate) fn run(arguments: &RobotCalibrate, console: Console) -> Result {
    let out = &arguments.out;
    let is_own = |name: &str| [PAGE, FIGURES, ERRORS, SETTINGS, README].contains(&name);
    let filling = Filling::begin("--out", out, is_own)?;
    let experiment = Experiment::read(&arguments.experiment, &arguments.set)?;
    let world = experiment.world();
    let sensors = world.spec().robot.build.readings();
    let mut lives = Vec::new();
    for directory in &arguments.log {
        lives.extend(logged::lives(directory, &sensors)?);
    }
    if lives.is_empty() {
        return Err(Failure::input("--log: has no complete episode; allowed: one and more"));
    }
    let engine = arguments.backend.engine()?;
    let calibration = Calibration::of(world, &lives, &engine)?;
    device::close(engine, console);
    let settings = calibration.settings(world);
    let html = page::page(experiment.name(), &calibration, &settings);
    write_page(out, PAGE, &html)?;
    for (file, text) in [(ERRORS, &errors(&calibration)), (SETTINGS, &settings)] {
        disk::write(&out.join(file), text.as_bytes())?;
    }
    describe(out, "Calibration of a simulator by episodes on a robot", &contents())?;
    filling.finish()?;
    let text = format!("{}\n{settings}", summary(&calibration));
    console.print_answer(&Answer::new(text, value(&calibration)))?;
    let experiment = files::for_shell(&arguments.experiment.display().to_string());
    console.say(format!(
        "wrote {0}: {PAGE}, and {SETTINGS} with values for {1}; copy those that you want into that file",
        out.display(),
        arguments.experiment.display()
    ));
    console.next(format_args!(
        "oneiro check {experiment}{}",
        settings_typed(&arguments.set)
    ));
    Ok(())
}

/// The files of the directory.
pub(crate) fn contents() -> Vec<Entry> {
    vec![
        Entry::file(PAGE, "the comparison, with figures"),
        Entry::file(format!("{FIGURES}/"), FIGURES_ABOUT),
        Entry::table(ERRORS, "errors of readings: one row per sensor and distance", &COLUMNS),
        Entry::file(
            SETTINGS,
            "resulting values for an experiment, with comments; nothing uses them automatically",
        ),
    ]
}

/// Names of the ranges of distances, and of all.
fn ranges() -> impl Iterator<Item = &'static str> {
    RANGES.iter().map(|(_, name)| *name).chain(["all"])
}

fn errors(calibration: &Calibration) -> String {
    let mut csv = Csv::new(&COLUMNS);
    for sensor in &calibration.readings.sensors {
        for (range, errors) in ranges().zip(&sensor.at) {
            let Errors { count, mean, deviation } = *errors;
            let [mean, deviation, size] = [mean, deviation, errors.size()].map(known);
            csv.row([
                sensor.name.clone(),
                range.into(),
                count.to_string(),
                mean,
                deviation,
                size,
            ]);
        }
    }
    csv.text()
}

fn summary(calibration: &Calibration) -> String {
    let readings = &calibration.readings;
    let lives = counted(calibration.lives, "episode", "episodes");
    let mut text = format!(
        "{lives}, {}; readings are {:.0} ms old\n",
        counted(calibration.cycles, "cycle", "cycles"),
        1000.0 * readings.age
    );
    for sensor in &readings.sensors {
        let all = sensor.at.last().map_or(f64::NAN, Errors::size);
        // Writing to a string can't fail.
        let _ = writeln!(text, "  {:<16} error {}", sensor.name, significant(all, 3));
    }
    match &calibration.moves {
        Some(moves) => {
            let [left, right] = moves.gains.map(|gain| significant(gain, 4));
            let _ = writeln!(
                text,
                "  wheels turn at {left} (left) and {right} (right) times their commands, {:.0} ms later",
                1000.0 * moves.latency
            );
        }
        None => text += "  the robot has no odometers, or nothing moved\n",
    }
    text
}

fn value(calibration: &Calibration) -> serde_json::Value {
    let number = |x: f64| if x.is_finite() { json!(x) } else { json!(null) };
    let readings = &calibration.readings;
    let sensors: Vec<_> = readings
        .sensors
        .iter()
        .map(|sensor| {
            let at = ranges().zip(&sensor.at).map(|(range, errors)| {
                json!({
                    "distance": range,
                    "cycles": errors.count,
                    "mean": number(errors.mean),
                    "deviation": number(errors.deviation),
                })
            });
            json!({ "sensor": sensor.name, "errors": at.collect::<Vec<_>>() })
        })
        .collect();
    let moves = calibration.moves.as_ref().map(|moves| {
        json!({
            "gains": moves.gains.map(number),
            "latency_s": moves.latency,
            "deviation_mm": moves.deviation.map(number),
            "relative_deviation": number(moves.relative),
            "noise": number(moves.noise()),
        })
    });
    json!({
        "episodes": calibration.lives,
        "cycles": calibration.cycles,
        "compared": readings.compared,
        "left_out": readings.left_out,
        "reading_age_s": readings.age,
        "sensor_noise": readings.noise(),
        "sensors": sensors,
        "moves": moves,
    })
}
