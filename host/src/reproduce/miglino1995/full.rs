//! What `--full` adds: the study's first half again in other simulators, each tested in the same reality. The ranges
//! of noise that the paper chose among (claim C11), and simulators that are made from other tables or with noise
//! in the motors.

use std::sync::Arc;

use oneiro::tables::{SensorTable, SensorTables};
use oneiro::world::{Noise, Robot, World, WorldSpec};

use super::results::{Condition, Family, Variant};
use super::settings::Settings;
use super::study::Study;
use crate::exit::Result;

/// Upper ends of the sensor noise; the paper tried five and does not name the others.
const SENSOR_RANGES: [f32; 5] = [0.1, 0.2, 0.4, 0.6, 0.8];
/// Ranges of the conservative noise, mm; the paper does not name the others.
const WALK_RANGES: [f32; 5] = [7.5, 15.0, 30.0, 45.0, 60.0];

/// Every other simulator, with its name, its family and the value that it is about.
fn simulators(settings: &Settings, own: &Robot, other: &Robot) -> Vec<(Family, String, f64, WorldSpec)> {
    let world = |robot: &Robot, noise| WorldSpec {
        robot: Robot {
            sensors: settings.arm.looked_up(&robot.sensors),
            ..robot.clone()
        },
        noise,
        ..settings.world()
    };
    let sensor = SENSOR_RANGES.map(|high| {
        let noise = Noise {
            sensor: (0.0, high),
            ..Noise::NONE
        };
        (
            Family::SensorRange,
            format!("U(0, {high})"),
            f64::from(high),
            world(own, noise),
        )
    });
    let walk = WALK_RANGES.map(|range| {
        let noise = Noise {
            walk_range: range,
            ..settings.noise(Condition::Conservative)
        };
        (
            Family::WalkRange,
            format!("{range} mm"),
            f64::from(range),
            world(own, noise),
        )
    });
    let motor_noise = Noise {
        motor: 0.1,
        ..Noise::NONE
    };
    let averaged = Robot {
        sensors: Arc::new(average(&own.sensors, &other.sensors)),
        ..own.clone()
    };
    let others = [
        ("own samples", own, Noise::NONE),
        ("another robot's samples", other, Noise::NONE),
        ("the average of both robots' samples", &averaged, Noise::NONE),
        ("the tables compiled in", &Robot::khepera(), Noise::NONE),
        ("own samples, motor noise of 10 %", own, motor_noise),
    ]
    .map(|(name, robot, noise)| (Family::Simulator, name.to_owned(), 0.0, world(robot, noise)));
    sensor.into_iter().chain(walk).chain(others).collect()
}

/// Readings half way between two robots'.
fn average(one: &SensorTables, other: &SensorTables) -> SensorTables {
    let table = |table: &SensorTable| {
        let other = other.class(&table.class).map(|class| &other.classes[class]);
        let readings = table.readings.iter().enumerate().map(|(cell, own)| {
            let theirs = other.and_then(|other| other.readings.get(cell)).unwrap_or(own);
            std::array::from_fn(|sensor| own[sensor].midpoint(theirs[sensor]))
        });
        SensorTable {
            readings: readings.collect(),
            ..table.clone()
        }
    };
    SensorTables::new(one.classes.iter().map(table).collect())
}

/// Evolves in each of them and tests generation 200 in reality: the means of each run.
pub(crate) fn variants(settings: &Settings, study: &Study<'_>, own: &Robot, other: &Robot) -> Result<Vec<Variant>> {
    let simulators = simulators(settings, own, other);
    let worlds = simulators
        .iter()
        .map(|(.., spec)| World::new(spec.clone()))
        .collect::<std::result::Result<Vec<_>, _>>()?;
    let lived = study.elsewhere(&worlds)?;
    let rows = simulators.into_iter().zip(lived);
    Ok(rows
        .map(|((family, name, value, _), (simulated, real))| Variant {
            family,
            name,
            value,
            simulated,
            real,
        })
        .collect())
}
