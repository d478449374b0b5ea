//! `oneiro sample`: samples a robot's sensors and motors into tables that a simulator is made from.

use std::path::Path;

use oneiro::world::WorldSpec;

use crate::cli::Sample;
use crate::console::Console;
use crate::exit::{Failure, Result};
use crate::reality::sampling::{self, Notebook, Samples};
use crate::reality::site::{self, Site};
use crate::reality::{Object, Reality};
use crate::record::write_whole;
use crate::report::figures;
use crate::{device, progress};

/// Samples a robot and writes tables and pictures.
pub(crate) fn run(arguments: &Sample, console: Console) -> Result {
    let site = Site::drawn(robot_seed(&arguments.robot)?, arguments.severity);
    let objects = objects(&arguments.objects)?;
    let evaluations = device::engine(&arguments.backend)?;
    let mut robot = site
        .open(&evaluations, &WorldSpec::miglino1995())
        .map_err(|trouble| Failure::input(format_args!("--robot {}: {trouble}", arguments.robot)))?;
    let samples = take(&mut *robot, &objects, &arguments.out, console)?;
    drop(robot);
    device::close(evaluations, console);
    console.say(format!(
        "wrote {} tables of sensors and one of motors to {}",
        samples.sensors.classes.len(),
        arguments.out.display()
    ));
    Ok(())
}

/// Parses the seed of `--robot`.
pub(crate) fn robot_seed(robot: &str) -> Result<u64> {
    site::seed_of(robot).map_err(|problem| Failure::input(format_args!("--robot {problem}")))
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
                "--objects {name}: is there twice; allowed: each once"
            )));
        }
        objects.push(object);
    }
    Ok(objects)
}

/// Takes the samples that are missing, and writes `CLASS.sam` and `CLASS.svg` for each object, and `motor.sam`.
pub(crate) fn take(
    reality: &mut dyn Reality,
    objects: &[Object],
    directory: &Path,
    console: Console,
) -> Result<Samples> {
    let notebook = Notebook::open(directory, &reality.describe())?;
    let bar = progress::rows(sampling::rows(objects), "sampling", console);
    let samples = sampling::sample(reality, objects, &notebook, &|| bar.inc(1))?;
    bar.finish_and_clear();
    for table in &samples.sensors.classes {
        write_whole(&directory.join(format!("{}.sam", table.class)), table.text().as_bytes())?;
        let picture = figures::sensor_table(table);
        write_whole(&directory.join(format!("{}.svg", table.class)), picture.as_bytes())?;
    }
    write_whole(&directory.join("motor.sam"), samples.motors.text().as_bytes())?;
    Ok(samples)
}
