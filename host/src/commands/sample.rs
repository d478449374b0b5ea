//! `oneiro sample`: samples a robot's sensors and motors into tables that a simulator is made from.

use std::path::Path;

use oneiro::world::WorldSpec;

use crate::cli::Sample;
use crate::console::{Console, counted};
use crate::device;
use crate::exit::{Failure, Result};
use crate::experiment::Experiment;
use crate::reality::Object;
use crate::reality::described::Described;
use crate::reality::sampling::{self, Notebook};
use crate::reality::site::{self, Site};
use crate::studies::miglino1995::settings::SEVERITY;

/// Samples a robot and writes tables and pictures.
pub(crate) fn run(arguments: &Sample, console: Console) -> Result {
    let path = Path::new(&arguments.robot);
    if path.extension().is_some_and(|extension| extension == "toml") {
        return described(path, arguments, console);
    }
    let severity = arguments.severity.unwrap_or(SEVERITY);
    let site = Site::drawn(site::seed_of(&arguments.robot)?, severity);
    let objects = objects(&arguments.objects)?;
    let evaluations = device::engine(&arguments.backend)?;
    let mut robot = site
        .open(&evaluations, &WorldSpec::miglino1995())
        .map_err(|trouble| Failure::input(format_args!("--robot {}: {trouble}", arguments.robot)))?;
    let samples = sampling::take(&mut *robot, &objects, &arguments.out, console)?;
    drop(robot);
    device::close(evaluations, console);
    console.say(format!(
        "wrote {} tables of sensors and one of motors to {}",
        samples.sensors.classes.len(),
        arguments.out.display()
    ));
    Ok(())
}

/// Samples the described robot of an experiment.
fn described(path: &Path, arguments: &Sample, console: Console) -> Result {
    if let Some(severity) = arguments.severity {
        return Err(Failure::usage(format_args!(
            "--severity {severity}: is given for a described robot, which has none; allowed: with --robot surrogate:SEED"
        )));
    }
    let experiment = Experiment::read(path, &[])?;
    let robot = Described::new(experiment.world().spec())
        .map_err(|problem| Failure::input(format_args!("--robot {}: {problem}", path.display())))?;
    let objects = objects(&arguments.objects)?;
    let engine = device::engine(&arguments.backend)?;
    Notebook::open(&arguments.out, &robot.describe())?;
    let sensors = robot.sensors(&engine, &objects)?;
    let motors = robot.motors(&engine)?;
    sampling::write(&sensors, motors.as_ref(), &arguments.out)?;
    device::close(engine, console);
    let count = counted(sensors.sensors(), "sensor", "sensors");
    console.say(format!(
        "wrote {} of {count}{} to {}; their columns: {}",
        counted(sensors.classes.len() as u32, "table", "tables"),
        if motors.is_some() { " and one of motors" } else { "" },
        arguments.out.display(),
        robot.names().join(", ")
    ));
    Ok(())
}

fn objects(names: &[String]) -> Result<Vec<Object>> {
    let mut objects: Vec<Object> = Vec::new();
    for name in names {
        let object = Object::named(name).ok_or_else(|| {
            Failure::input(format_args!(
                "--objects {name}: no such object; allowed: {}",
                Object::NAMES.join(", ")
            ))
        })?;
        if objects.contains(&object) {
            return Err(Failure::input(format_args!(
                "--objects {name}: is given twice; allowed: each once"
            )));
        }
        objects.push(object);
    }
    Ok(objects)
}
