//! `oneiro sample`: samples a robot's sensors and motors into tables that a simulator is made from.

use oneiro::world::WorldSpec;

use crate::cli::Sample;
use crate::console::Console;
use crate::device;
use crate::exit::{Failure, Result};
use crate::reality::Object;
use crate::reality::sampling;
use crate::reality::site::{self, Site};

/// Samples a robot and writes tables and pictures.
pub(crate) fn run(arguments: &Sample, console: Console) -> Result {
    let site = Site::drawn(site::seed_of(&arguments.robot)?, arguments.severity);
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
