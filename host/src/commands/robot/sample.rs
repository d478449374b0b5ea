//! `oneiro robot sample`: samples a robot's sensors and motors into tables that a simulator is made from.

use std::path::Path;

use oneiro::tables::SensorTables;
use oneiro::world::WorldSpec;
use oneiro_base::console::{Console, counted};
use oneiro_base::exit::{Failure, Result};
use oneiro_base::files;
use oneiro_lab::device;
use oneiro_lab::engine::signals::stop_signal;
use oneiro_lab::experiment::Experiment;
use oneiro_lab::reality::described::Described;
use oneiro_lab::reality::sampling::{self, Grid, Notebook};
use oneiro_lab::reality::site::{SEVERITY, Site};
use oneiro_robots::Kind;
use oneiro_robots::address::{Address, Wire};
use oneiro_robots::guard::values::Values;
use oneiro_robots::guard::wheels::Wanted;
use oneiro_robots::vehicle::guarded::{Guarded, Options};
use oneiro_robots::vehicle::{Profile, Vehicle};
use serde_json::json;

use crate::cli::RobotSample;
use objects::objects;
use person::{AtTerminal, Nobody, Person};
use walk::{Plan, Walk};

mod objects;
mod person;
mod walk;

/// Samples a robot and writes tables and pictures.
pub(crate) fn run(arguments: &RobotSample, console: Console) -> Result {
    if let Some(severity) = arguments.severity
        && !arguments.robot.starts_with("surrogate")
    {
        return Err(Failure::usage(format_args!(
            "--severity {severity}: is given with --robot {}, which has none; allowed: with --robot surrogate:SEED",
            arguments.robot
        )));
    }
    let path = Path::new(&arguments.robot);
    let is_experiment = path.extension().is_some_and(|extension| extension == "toml");
    let seed = match (is_experiment, arguments.robot.parse()) {
        (_, Ok(Address::Wire(wire))) => return wired(wire, arguments, console),
        (_, Ok(Address::Surrogate(seed))) => Some(seed),
        (true, Err(_)) => None,
        (false, Err(invalid)) => {
            let or = if invalid.is_no_address() {
                ", or FILE.toml, an experiment with a parametric robot"
            } else {
                ""
            };
            return Err(Failure::input(format_args!("--robot: {invalid}{or}")));
        }
    };
    if let Some(option) = arguments.wired.given() {
        return Err(Failure::input(format_args!(
            "{option}: is given with --robot {}; allowed: with a connected robot",
            arguments.robot
        )));
    }
    let Some(seed) = seed else {
        return described(path, arguments, console);
    };
    let site = Site::drawn(seed, arguments.severity.unwrap_or(SEVERITY));
    let objects = objects(&arguments.objects)?;
    let evaluations = arguments.backend.engine()?;
    let mut robot = site
        .sampled(&evaluations, &WorldSpec::miglino1995())
        .map_err(|trouble| Failure::input(format_args!("--robot {}: {trouble}", arguments.robot)))?;
    let samples = sampling::take(&mut *robot, &objects, &arguments.out, console.bars())?;
    drop(robot);
    device::close(evaluations, console);
    console.say(format!(
        "wrote {} tables of sensors and one of motors to {}",
        samples.sensors.classes.len(),
        arguments.out.display()
    ));
    say_next(&samples.sensors, arguments, console);
    Ok(())
}

/// Samples the described robot of an experiment.
fn described(path: &Path, arguments: &RobotSample, console: Console) -> Result {
    let experiment = Experiment::read(path, &[])?;
    let robot = Described::new(experiment.world().spec())
        .map_err(|problem| Failure::input(format_args!("--robot {}: {problem}", path.display())))?;
    let objects = objects(&arguments.objects)?;
    let engine = arguments.backend.engine()?;
    Notebook::open(&arguments.out, &robot.describe())?;
    let sensors = robot.sensors(&engine, &objects)?;
    let motors = robot.motors(&engine)?;
    sampling::write(&sensors, motors.as_ref(), &arguments.out)?;
    device::close(engine, console);
    let sensors_of_all = experiment.world().spec().robot.described_sensors().iter();
    let others: Vec<_> = sensors_of_all
        .map(|sensor| sensor.name.as_str())
        .filter(|name| !robot.names().contains(name))
        .collect();
    if !others.is_empty() {
        console.say(format!(
            "not sampled: {}, since tables have readings by the distance and bearing of an object; describe them in the experiment",
            others.join(", ")
        ));
    }
    let count = counted(sensors.sensors(), "sensor", "sensors");
    console.say(format!(
        "wrote {} of {count}{} to {}; their columns: {}",
        counted(sensors.classes.len(), "table", "tables"),
        if motors.is_some() { " and one of motors" } else { "" },
        arguments.out.display(),
        robot.names().join(", ")
    ));
    say_next(&sensors, arguments, console);
    Ok(())
}

/// Samples a robot on a wire: somebody places it for each row.
fn wired(wire: Wire, arguments: &RobotSample, console: Console) -> Result {
    let options = &arguments.wired;
    let objects = objects(&arguments.objects)?;
    let stop = stop_signal()?;
    let mut nobody = Nobody::new(console);
    let mut terminal = if options.yes {
        None
    } else {
        Some(AtTerminal::new(console)?)
    };
    let person: &mut dyn Person = match &mut terminal {
        Some(terminal) => terminal,
        None => &mut nobody,
    };
    let wanted = Wanted {
        kinds: vec![Kind::Proximity],
        odometry: true,
    };
    let guarded = Options {
        wire,
        wanted,
        settings: options.values.clone(),
        record: options.record.clone(),
        tracker: None,
        number: None,
    };
    let usual = Grid::USUAL;
    let grid = Grid {
        nearest: options.nearest.unwrap_or(usual.nearest),
        spacing: options.spacing.unwrap_or(usual.spacing),
        rows: options.rows.unwrap_or(usual.rows),
    };
    walk::check(&objects, grid, &arguments.out)?;
    let allowed = Values::of(&options.values).map_err(Failure::input)?.speed_mm_s;
    if let Some(given) = options.full_speed.filter(|given| *given > allowed) {
        return Err(too_fast(given, "the guard allows", allowed));
    }
    let mut vehicle = Guarded::open(&guarded, stop.clone(), console)?;
    let plan = Plan {
        objects,
        grid,
        turns: options.turns.unwrap_or(1),
        full_mm_s: if options.no_motors {
            None
        } else {
            Some(full_speed(vehicle.profile(), options.full_speed)?)
        },
    };
    let (sensors, motors) = Walk::new(&mut vehicle, person, &plan, &arguments.out, &stop, console)?.go()?;
    sampling::write(&sensors, motors.as_ref(), &arguments.out)?;
    let at = |name: &str| arguments.out.join(format!("{name}.sam")).display().to_string();
    let tables: Vec<String> = sensors.classes.iter().map(|table| at(&table.class)).collect();
    let motors = motors.map(|_| at("motor"));
    console.print_line("", &json!({ "tables": tables, "motors": motors }))?;
    console.say(format!(
        "wrote {}{} to {}",
        counted(tables.len(), "table of sensors", "tables of sensors"),
        if motors.is_some() { " and one of motors" } else { "" },
        arguments.out.display()
    ));
    say_next(&sensors, arguments, console);
    Ok(())
}

/// Says how to look at the first table.
fn say_next(sensors: &SensorTables, arguments: &RobotSample, console: Console) {
    if let Some(first) = sensors.classes.first() {
        let table = arguments.out.join(format!("{}.sam", first.class));
        let table = files::for_shell(&table.display().to_string());
        console.next(format_args!("oneiro robot tables show {table}"));
    }
}

/// The speed in the state 10 of a wheel, mm/s.
///
/// # Errors
/// Exit 3: the robot has no odometers, or the speed is beyond its greatest.
fn full_speed(profile: &Profile, given: Option<f64>) -> Result<f64> {
    let Profile {
        robot,
        greatest_mm_s,
        unit_mm_s,
        ..
    } = profile;
    if !profile.has_odometers {
        return Err(Failure::input(format_args!(
            "the {robot} has no odometers, which measure its motors; allowed: --no-motors, and robot.wheel_base_mm and \
             robot.greatest_speed_mm_s in the experiment"
        )));
    }
    let own = 10.0 * unit_mm_s;
    let usual = if own >= greatest_mm_s / 20.0 {
        own.min(*greatest_mm_s)
    } else {
        *greatest_mm_s
    };
    match given {
        Some(given) if given > *greatest_mm_s => Err(too_fast(given, &format!("the {robot} has"), *greatest_mm_s)),
        given => Ok(given.unwrap_or(usual)),
    }
}

fn too_fast(given: f64, whose: &str, greatest: f64) -> Failure {
    Failure::input(format_args!(
        "--full-speed {given}: is more than {whose}; allowed: up to {greatest} mm/s, or more by --guard speed_mm_s=.."
    ))
}
