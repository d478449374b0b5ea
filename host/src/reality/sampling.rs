//! Sampling a robot, by section 3.2 of Miglino et al. (1995): what its sensors read of an object at each bearing and
//! distance while it turns before it, and what each pair of speeds does.

use std::fs;
use std::path::{Path, PathBuf};

use oneiro::tables::{MotorSamples, SENSORS, SensorTable, SensorTables};
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::{Driven, Object, Reality, Turned, patiently};
use crate::exit::{Failure, Result};
use crate::record::write_whole;

/// Bearings of a turn.
const BEARINGS: u32 = 180;
/// Rows of a table.
const ROWS: u32 = 20;
/// From the rim to the object in the first row, mm.
const NEAREST: f32 = 5.0;
/// From one row to the next, mm.
const SPACING: f32 = 2.0;

/// The 20 speeds of a wheel, in the robot's unit.
fn speeds() -> impl Iterator<Item = i32> + Clone {
    (-10..=10).filter(|speed| *speed != 0)
}

/// A robot's samples.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Samples {
    /// A table for each object.
    pub(crate) sensors: SensorTables,
    /// What the motors do.
    pub(crate) motors: MotorSamples,
}

/// Where samples are kept row by row as they are taken, so that a robot need not do again what it has done.
#[derive(Debug)]
pub(crate) struct Notebook {
    /// None: nothing is kept.
    directory: Option<PathBuf>,
}

impl Notebook {
    /// Opens one, which may hold rows of the same robot.
    ///
    /// # Errors
    /// Exit 3 if it holds those of another robot; exit 6 if it can't be written.
    pub(crate) fn open(directory: &Path, robot: &str) -> Result<Self> {
        let rows = directory.join("rows");
        fs::create_dir_all(&rows).map_err(|error| Failure::storage(&rows, &error))?;
        let name = rows.join("robot.txt");
        match fs::read_to_string(&name) {
            Ok(known) if known == robot => (),
            Ok(known) => {
                return Err(Failure::input(format_args!(
                    "{}: holds samples of another robot, {known}; allowed: {robot}, or another directory",
                    directory.display()
                )));
            }
            Err(_) => write_whole(&name, robot.as_bytes())?,
        }
        Ok(Self { directory: Some(rows) })
    }

    /// A row that was taken before, or the one that is taken now.
    fn row<T: Serialize + DeserializeOwned>(&self, name: &str, take: impl FnOnce() -> Result<T>) -> Result<T> {
        let Some(directory) = &self.directory else {
            return take();
        };
        let path = directory.join(format!("{name}.json"));
        if let Ok(bytes) = fs::read(&path) {
            return serde_json::from_slice(&bytes)
                .map_err(|error| Failure::corrupt(format_args!("{}: {error}", path.display())));
        }
        let row = take()?;
        let text = serde_json::to_vec(&row).map_err(Failure::failed)?;
        write_whole(&path, &text)?;
        Ok(row)
    }
}

/// Rows of a whole sampling: what a progress bar counts.
pub(crate) fn rows(objects: &[Object]) -> u64 {
    u64::from(ROWS) * objects.len() as u64 + speeds().count() as u64
}

/// Samples a robot before each object, and its motors; `done` is called after each row.
///
/// # Errors
/// What the robot can't do; exit 6 if a row can't be kept.
pub(crate) fn sample(
    reality: &mut dyn Reality,
    objects: &[Object],
    notebook: &Notebook,
    done: &dyn Fn(),
) -> Result<Samples> {
    let mut classes = Vec::new();
    for object in objects {
        let mut taken = Vec::new();
        for number in 0..ROWS {
            taken.push(notebook.row(&format!("{}-{number:02}", object.class), || {
                row(reality, object, number)
            })?);
            done();
        }
        classes.push(table(&object.class, &taken));
    }
    let mut taken = Vec::new();
    for (number, left) in speeds().enumerate() {
        taken.push(notebook.row(&format!("motors-{number:02}"), || motors_row(reality, left))?);
        done();
    }
    Ok(Samples {
        sensors: SensorTables::new(classes),
        motors: motors(&taken),
    })
}

/// Samples a robot in one go, for a simulation that takes a second.
pub(crate) fn sample_unkept(reality: &mut dyn Reality, objects: &[Object]) -> Result<Samples> {
    sample(reality, objects, &Notebook { directory: None }, &|| ())
}

/// One row of a sensor table: the first reading in each bearing's interval as the robot turns.
fn row(reality: &mut dyn Reality, object: &Object, row: u32) -> Result<Vec<[u16; SENSORS]>> {
    let gap = NEAREST + row as f32 * SPACING;
    let turn = patiently(|| reality.turn_before(object, gap))?;
    binned(&turn).map_err(|bearing| {
        let low = f64::from(bearing) * 360.0 / f64::from(BEARINGS);
        Failure::failed(format_args!(
            "sampling {} at {gap} mm: no reading between {low} and {} degrees; the robot turns too fast",
            object.class,
            low + 360.0 / f64::from(BEARINGS)
        ))
    })
}

/// The first reading of each bearing's interval, or the first interval without one.
fn binned(turn: &[Turned]) -> std::result::Result<Vec<[u16; SENSORS]>, u32> {
    let mut cells = vec![None; BEARINGS as usize];
    for moment in turn {
        let bearing = ((moment.bearing * f64::from(BEARINGS)) as usize).min(BEARINGS as usize - 1);
        cells[bearing].get_or_insert(moment.readings);
    }
    (0..).zip(cells).map(|(bearing, cell)| cell.ok_or(bearing)).collect()
}

/// A table from its rows.
fn table(class: &str, rows: &[Vec<[u16; SENSORS]>]) -> SensorTable {
    SensorTable {
        class: class.into(),
        rows: rows.len() as u32,
        bearings: BEARINGS,
        nearest: NEAREST,
        spacing: SPACING,
        readings: rows.concat(),
    }
}

/// What one speed of the left wheel does with each of the right.
fn motors_row(reality: &mut dyn Reality, left: i32) -> Result<Vec<Driven>> {
    speeds()
        .map(|right| patiently(|| reality.drive((left, right))))
        .collect()
}

/// The motors' samples from their rows.
fn motors(rows: &[Vec<Driven>]) -> MotorSamples {
    let all = || rows.iter().flatten();
    MotorSamples {
        speeds: speeds().collect(),
        // Files count turns clockwise.
        degrees: all().map(|driven| (0.0 - driven.turn * 360.0) as f32).collect(),
        centimetres: all().map(|driven| (driven.displacement / 10.0) as f32).collect(),
    }
}
