//! The additions of `--full`: the study's simulated half repeated in other simulators, each tested in the same reality.

use std::sync::Arc;

use oneiro::tables::{SensorTable, SensorTables};
use oneiro::world::{Robot, World, WorldSpec};
use oneiro_base::exit::Result;

use super::results::Variant;
use super::settings::{Settings, Tables};
use super::study::Study;

/// Averages the readings of two robots.
fn average(one: &SensorTables, other: &SensorTables) -> SensorTables {
    let table = |table: &SensorTable| {
        let other = other.class(&table.class).map(|class| &other.classes[class]);
        let readings = table.readings.iter().enumerate().map(|(at, reading)| {
            let theirs = other.and_then(|other| other.readings.get(at)).unwrap_or(reading);
            reading.midpoint(*theirs)
        });
        SensorTable {
            readings: readings.collect(),
            ..table.clone()
        }
    };
    SensorTables::new(one.classes.iter().map(table).collect())
}

/// Evolves in each other simulator and tests the transferred generation in reality; returns the mean fitness of each
/// run.
pub(crate) fn variants(settings: &Settings, study: &Study<'_>, robot: &Robot, other: &Robot) -> Result<Vec<Variant>> {
    let averaged = Robot {
        sensors: Arc::new(average(&robot.sensors, &other.sensors)),
        ..robot.clone()
    };
    let built_in = Robot::khepera();
    let worlds: std::result::Result<Vec<World>, _> = settings
        .variants
        .iter()
        .map(|simulator| {
            let robot = match simulator.tables {
                Tables::Own => robot,
                Tables::Another => other,
                Tables::Average => &averaged,
                Tables::BuiltIn => &built_in,
            };
            World::new(WorldSpec {
                robot: Robot {
                    sensors: settings.looked_up(&robot.sensors),
                    collision: simulator.world.robot.collision,
                    ..robot.clone()
                },
                ..simulator.world.clone()
            })
        })
        .collect();
    let lived = study.elsewhere(&worlds?)?;
    let rows = settings.variants.iter().zip(lived);
    Ok(rows
        .map(|(simulator, (simulated, real))| Variant {
            family: simulator.family,
            name: simulator.name.clone(),
            value: simulator.value,
            simulated,
            real,
        })
        .collect())
}

#[cfg(test)]
mod tests {
    /// The kernels reflect a walk at the ends of its range, so a step of up to twice the range, from anywhere, ends
    /// uniformly distributed over it.
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
