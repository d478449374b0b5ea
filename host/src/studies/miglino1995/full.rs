//! What `--full` adds: the study's first half again in other simulators, each tested in the same reality. The ranges
//! of noise that the paper chose among (claim C11), displacement of one size that changes never, slowly or at once,
//! and simulators that are made from other tables or with noise in the motors.

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
/// Greatest steps of a walk within the paper's 30 mm, mm, and what that makes of the displacement. A step of up to
/// twice the range, folded back into it, lands anywhere there with equal chance, wherever it started: an envelope
/// of noise of the same size that forgets in each cycle what it was in the one before.
const DISPLACEMENTS: [(f32, &str); 3] = [
    (0.0, "drawn once a life"),
    (1.5, "a slow walk, as in the paper"),
    (60.0, "drawn anew each cycle"),
];

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
    let displacement = DISPLACEMENTS.map(|(step, name)| {
        let noise = Noise {
            walk_step: step,
            ..Noise::CONSERVATIVE
        };
        (
            Family::Displacement,
            name.to_owned(),
            f64::from(step),
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
    sensor
        .into_iter()
        .chain(walk)
        .chain(displacement)
        .chain(others)
        .collect()
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

#[cfg(test)]
mod tests {
    use super::super::arms::Arm;
    use super::super::tests;
    use super::*;

    fn settings() -> Settings {
        Settings {
            full: true,
            ..tests::settings(Arm::Main, 1.0)
        }
    }

    #[test]
    fn displacements_are_of_one_size_and_differ_in_how_they_change() {
        let robot = Robot::khepera();
        let all = simulators(&settings(), &robot, &robot);
        let displaced: Vec<_> = all
            .iter()
            .filter(|(family, ..)| *family == Family::Displacement)
            .collect();
        let noises: Vec<_> = displaced.iter().map(|(.., world)| world.noise).collect();
        assert_eq!(
            noises.iter().map(|noise| noise.walk_step).collect::<Vec<_>>(),
            [0.0, 1.5, 60.0]
        );
        for noise in &noises {
            assert_eq!((noise.walk_range, noise.sensor, noise.motor), (30.0, (0.0, 0.0), 0.0));
        }
        for (_, name, _, world) in all {
            assert!(World::new(world).is_ok(), "{name}");
        }
    }

    /// As the kernels fold a walk back, from anywhere within its range a step of up to twice the range ends evenly
    /// spread over it.
    #[test]
    fn the_greatest_step_forgets_where_it_was() {
        const RANGE: f64 = 30.0;
        const DRAWS: u32 = 6000;
        let reflected = |x: f64| {
            let below = if x < -RANGE { -2.0 * RANGE - x } else { x };
            if below > RANGE { 2.0 * RANGE - below } else { below }
        };
        let spread = |from: f64, step: f64| {
            let mut tenths = [0_u32; 10];
            for draw in 0..DRAWS {
                let share = (f64::from(draw) + 0.5) / f64::from(DRAWS);
                let to = reflected(from + (2.0 * share - 1.0) * step);
                tenths[((to + RANGE) / (2.0 * RANGE) * 10.0) as usize] += 1;
            }
            tenths
        };
        for from in [-29.7, -12.3, 0.0, 21.0] {
            for tenth in spread(from, 2.0 * RANGE) {
                assert!(tenth.abs_diff(DRAWS / 10) <= 2, "{tenth} from {from}");
            }
        }
        assert!(spread(21.0, 1.5).contains(&0), "a small step does not");
    }
}
