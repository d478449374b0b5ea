//! `oneiro robot`: finds robots on a wire, shows what they sense, drives them, switches their lights, and stops them; makes and
//! checks a simulator from what they measured.

use std::path::Path;
use std::time::{Duration, Instant};

use oneiro_base::answer::Answer;
use oneiro_base::console::{Console, columns};
use oneiro_base::exit::{Failure, Result};
use oneiro_base::files;
use oneiro_robots as robots;
use oneiro_robots::address::{Invalid, Wire, forms};
use oneiro_robots::error::{self, Error};
use oneiro_robots::link::{self, Port};
use oneiro_robots::recording::Recording;
use oneiro_robots::{Battery, Description, Group, Kind, Robot, stopped, unstopped};
use serde_json::{Value, json};

use crate::cli::{Robot as Arguments, RobotCommand, RobotLight, RobotLink, Switch};

pub(crate) mod calibrate;
mod drive;
mod sample;
mod tables;
mod watch;

/// Runs the subcommand.
pub(crate) fn run(arguments: &Arguments, console: Console) -> Result {
    match &arguments.command {
        RobotCommand::List => console.print_answer(&list()),
        RobotCommand::Ping(link) => ping(link, console),
        RobotCommand::Watch(arguments) => watch::run(arguments, console),
        RobotCommand::Drive(arguments) => drive::run(arguments, console),
        RobotCommand::Light(arguments) => light(arguments, console),
        RobotCommand::Stop(link) => stop(link, console),
        RobotCommand::Sample(arguments) => sample::run(arguments, console),
        RobotCommand::Calibrate(arguments) => calibrate::run(arguments, console),
        RobotCommand::Tables { command } => tables::run(command, console),
    }
}

/// The serial ports and the forms of addresses.
fn list() -> Answer {
    let ports = link::ports();
    let port = |port: &Port| json!({ "path": port.path, "about": port.about, "address": Wire::at(port).to_string() });
    let forms: Vec<[String; 2]> = forms();
    let form = |[form, robots]: &[String; 2]| json!({ "form": form, "robots": robots });
    let value = json!({
        "ports": ports.iter().map(port).collect::<Vec<_>>(),
        "addresses": forms.iter().map(form).collect::<Vec<_>>(),
    });
    let row = |port: &Port| vec![Wire::at(port).to_string(), known(&port.about).to_owned()];
    let text = match &ports.iter().map(row).collect::<Vec<_>>()[..] {
        [] => "no serial port was found\n".to_owned(),
        rows => columns(&["address", "port"], rows),
    };
    let forms: Vec<Vec<String>> = forms.into_iter().map(Into::into).collect();
    let forms = columns(&["form of address", "robots"], &forms);
    Answer::new(format!("{text}\n{forms}"), value)
}

/// Text of a cell, which is never empty.
fn known(text: &str) -> &str {
    if text.is_empty() { "-" } else { text }
}

/// Prints what a robot is and has, and how fast it answers.
fn ping(arguments: &RobotLink, console: Console) -> Result {
    connected(arguments, console, |wire, robot| {
        used(robot?, |robot| {
            let battery = match robot.battery() {
                Err(Error::Unsupported { .. }) => None,
                battery => Some(battery?),
            };
            let description = robot.description().clone();
            let timing = description.sensors.first().map(|group| Timing::of(robot, group.kind));
            let timing = timing.transpose()?;
            console.print_answer(&described(wire, &description, battery, timing.as_ref()))
        })
    })
}

/// Switches lights of a robot.
fn light(arguments: &RobotLight, console: Console) -> Result {
    connected(&arguments.link, console, |wire, robot| {
        used(robot?, |robot| {
            let description = robot.description();
            let numbers: error::Result<Vec<usize>> = arguments
                .lights
                .iter()
                .map(|name| description.light_named(name))
                .collect();
            let name = description.robot.clone();
            let is_on = arguments.state == Switch::On;
            for light in numbers? {
                robot.light(light, is_on)?;
            }
            let state = if is_on { "on" } else { "off" };
            let lights = &arguments.lights;
            console.print_answer(&Answer::new(
                format!("switched {state}: {} of the {name} at {wire}", lights.join(", ")),
                json!({ "address": wire.to_string(), "robot": name, "lights": lights, "state": state }),
            ))
        })
    })
}

/// Stops a robot's wheels. Connecting stops them, and closing stops them again.
fn stop(arguments: &RobotLink, console: Console) -> Result {
    connected(arguments, console, |wire, robot| {
        let stopped = robot.and_then(|mut robot| {
            stopped(&mut *robot)?;
            Ok(robot.description().robot.clone())
        });
        let robot = stopped.map_err(|error| unstopped(&error))?;
        console.print_answer(&Answer::new(
            format!("stopped: the {robot} at {wire} has confirmed it"),
            json!({ "address": wire.to_string(), "robot": robot, "stopped": true }),
        ))
    })
}

/// Connects to the robot at an address, and finishes the recording of its link, whatever `work` returns.
///
/// # Errors
/// Exit 3 for the address or the recording's path, exit 6 if the recording can't be written, and those of `work`.
fn connected<T>(
    arguments: &RobotLink,
    console: Console,
    work: impl FnOnce(&Wire, error::Result<Box<dyn Robot>>) -> Result<T>,
) -> Result<T> {
    let wire = wire(&arguments.address)?;
    let recording = arguments.record.as_deref().map(recording).transpose()?;
    console.say(format!("connecting to {wire}"));
    let outcome = work(&wire, robots::connect(&wire, recording.as_ref()));
    match (outcome, recording.and_then(Recording::finish)) {
        (outcome, None) => outcome,
        (Ok(_), Some(problem)) => Err(Failure::unwritten(problem)),
        (Err(failure), Some(problem)) => {
            console.say(problem);
            Err(failure)
        }
    }
}

/// The link that an address names.
///
/// # Errors
/// Exit 3: it is not valid, or names none.
pub(super) fn wire(address: &str) -> Result<Wire> {
    address.parse().map_err(|invalid: Invalid| Failure::input(invalid))
}

/// A recording in a new file.
///
/// # Errors
/// Exit 3 or 6: it can't be created.
pub(super) fn recording(path: &Path) -> Result<Recording> {
    Recording::create(path).map_err(|error| files::uncreated(path, &error))
}

/// Uses a robot, and stops it however that ended.
fn used(mut robot: Box<dyn Robot>, work: impl FnOnce(&mut dyn Robot) -> Result) -> Result {
    let outcome = work(&mut *robot);
    match (outcome, stopped(&mut *robot)) {
        (outcome, Ok(())) => outcome,
        (Ok(()), Err(error)) => Err(unstopped(&error)),
        (Err(failure), Err(error)) if failure.to_string() == error.to_string() => Err(unstopped(&error)),
        (Err(failure), Err(error)) => Err(unstopped(&error).and(failure)),
    }
}

/// How long readings of sensors took.
struct Timing {
    kind: Kind,
    /// In ascending order.
    times: Vec<Duration>,
    /// Greatest age of a value when it arrived.
    age: Duration,
}

impl Timing {
    const READINGS: usize = 20;

    /// Reads sensors one time after another.
    fn of(robot: &mut dyn Robot, kind: Kind) -> error::Result<Self> {
        let (mut times, mut age) = (Vec::new(), Duration::ZERO);
        for _ in 0..Self::READINGS {
            let start = Instant::now();
            age = age.max(robot.sense(&[kind])?.age);
            times.push(start.elapsed());
        }
        times.sort_unstable();
        Ok(Self { kind, times, age })
    }

    /// Least, median and greatest time, ms.
    fn summary(&self) -> [f64; 3] {
        let at = |index: usize| milliseconds(self.times[index]);
        let middle = Self::READINGS / 2;
        [at(0), f64::midpoint(at(middle - 1), at(middle)), at(Self::READINGS - 1)]
    }
}

fn milliseconds(time: Duration) -> f64 {
    (time.as_secs_f64() * 1e6).round() / 1e3
}

/// What a robot is and has.
fn described(wire: &Wire, description: &Description, battery: Option<Battery>, timing: Option<&Timing>) -> Answer {
    Answer::new(
        text(wire, description, battery, timing),
        value(wire, description, battery, timing),
    )
}

/// A description for JSON.
fn value(wire: &Wire, description: &Description, battery: Option<Battery>, timing: Option<&Timing>) -> Value {
    let group = |group: &Group| {
        let (least, greatest) = group.range;
        json!({
            "kind": group.kind.to_string(),
            "names": group.names,
            "unit": group.unit,
            "least": number(least),
            "greatest": number(greatest),
        })
    };
    let wheels = description.wheels;
    let timing = timing.map(|timing| {
        let [min, median, max] = timing.summary();
        json!({
            "kind": timing.kind.to_string(),
            "readings": Timing::READINGS,
            "min_ms": min,
            "median_ms": median,
            "max_ms": max,
            "age_ms": milliseconds(timing.age),
        })
    });
    json!({
        "address": wire.to_string(),
        "robot": description.robot,
        "firmware": description.firmware,
        "sensors": description.sensors.iter().map(group).collect::<Vec<_>>(),
        "wheels": {
            "unit": wheels.unit,
            "greatest": wheels.greatest,
            "unit_mm_s": wheels.mm_s,
            "base_mm": wheels.base_mm,
            "mm_per_count": wheels.mm_per_count,
        },
        "lights": description.lights,
        "battery": battery.map(|battery| json!({ "volts": battery.volts, "low": battery.low })),
        "round_trip": timing,
    })
}

/// A description for people.
fn text(wire: &Wire, description: &Description, battery: Option<Battery>, timing: Option<&Timing>) -> String {
    let wheels = description.wheels;
    let odometers = match wheels.mm_per_count {
        Some(mm) => format!("a count of their odometers is {mm:.4} mm"),
        None => "no odometers".to_owned(),
    };
    let battery = battery.map_or("not reported".to_owned(), |battery| {
        let volts = battery
            .volts
            .map_or("voltage not reported".to_owned(), |volts| format!("{volts:.2} V"));
        volts + if battery.low { ", low: charge it" } else { "" }
    });
    let lights = match description.lights {
        [] => "none".to_owned(),
        lights => lights.join(", "),
    };
    let timing = timing.map_or("no sensors to read".to_owned(), |timing| {
        let [min, median, max] = timing.summary();
        format!(
            "{} readings of {}: min {min:.1} ms, median {median:.1} ms, max {max:.1} ms; values up to {:.0} ms old",
            Timing::READINGS,
            timing.kind,
            milliseconds(timing.age)
        )
    });
    let rows: Vec<Vec<String>> = description.sensors.iter().map(row).collect();
    format!(
        "{robot} at {wire}\nfirmware: {firmware}\nwheels: stopped; up to {greatest} {unit}, which is {mm_s:.0} mm/s; {base} mm \
         apart; {odometers}\nbattery: {battery}\nlights: {lights}\nround trip: {timing}\n\n{sensors}",
        robot = description.robot,
        firmware = description.firmware,
        greatest = wheels.greatest,
        unit = wheels.unit,
        mm_s = f64::from(wheels.greatest) * wheels.mm_s,
        base = wheels.base_mm,
        sensors = columns(&["sensors", "unit", "range", "names"], &rows),
    )
}

fn row(group: &Group) -> Vec<String> {
    let (least, greatest) = group.range;
    vec![
        group.kind.to_string(),
        known(group.unit).to_owned(),
        format!("{least} to {greatest}"),
        group.names.join(", "),
    ]
}

/// A number for JSON; whole ones without a point.
fn number(value: f64) -> Value {
    if value.fract() == 0.0 && value.abs() < 1e15 {
        (value as i64).into()
    } else {
        value.into()
    }
}
