//! Sampling a robot, by section 3.2 of Miglino et al. (1995): what its sensors read of an object at each bearing and
//! distance while it turns before it, and what each pair of speeds does.

use oneiro::tables::{MotorSamples, SENSORS, SensorTable};

use super::{Driven, Object, Reality, Turned, patiently};
use crate::exit::{Failure, Result};

/// Bearings of a turn, and distances from the rim.
pub(crate) const BEARINGS: u32 = 180;
/// Rows of a table.
pub(crate) const ROWS: u32 = 20;
/// The first row's distance and that from row to row, mm.
pub(crate) const NEAREST: f32 = 5.0;
/// From one row to the next, mm.
pub(crate) const SPACING: f32 = 2.0;

/// The 20 speeds of a wheel, in the robot's unit.
pub(crate) fn speeds() -> impl Iterator<Item = i32> + Clone {
    (-10..=10).filter(|speed| *speed != 0)
}

/// One row of a sensor table: the first reading in each bearing's interval as the robot turns.
pub(crate) fn row(reality: &mut dyn Reality, object: &Object, row: u32) -> Result<Vec<[u16; SENSORS]>> {
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
pub(crate) fn table(class: &str, rows: &[Vec<[u16; SENSORS]>]) -> SensorTable {
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
pub(crate) fn motors_row(reality: &mut dyn Reality, left: i32) -> Result<Vec<Driven>> {
    speeds()
        .map(|right| patiently(|| reality.drive((left, right))))
        .collect()
}

/// The motors' samples from their rows.
pub(crate) fn motors(rows: &[Vec<Driven>]) -> MotorSamples {
    let all = || rows.iter().flatten();
    MotorSamples {
        speeds: speeds().collect(),
        // Files count turns clockwise.
        degrees: all().map(|driven| (0.0 - driven.turn * 360.0) as f32).collect(),
        centimetres: all().map(|driven| (driven.displacement / 10.0) as f32).collect(),
    }
}
