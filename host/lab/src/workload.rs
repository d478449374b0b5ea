//! Episodes for comparing and timing devices: worlds of every kind and random genomes, the same on every machine.

use std::sync::Arc;

use oneiro::arena::Arena;
use oneiro::batch::{Batch, Rollout, TraceRequest, Worlds};
use oneiro::foraging::{Foraging, Light};
use oneiro::parameter::Invalid;
use oneiro::random::{Key, pcg4d};
use oneiro::surrogate::{Differences, Surrogate};
use oneiro::swarm::{self, Lamp, Order, Swarm};
use oneiro::tables::SensorTable;
use oneiro::world::{Activation, Controller, Difference, Noise, Robot, Speed, Start, Task, World, WorldSpec};

/// Cycles of an episode, as in the 1995 paper.
pub const CYCLES: u32 = 500;

/// The controllers of the catalogue.
pub const CONTROLLERS: [(&str, Controller); 3] = [
    ("perceptron", Controller::Perceptron),
    ("hidden", Controller::Hidden { units: 5 }),
    ("recurrent", Controller::Recurrent),
];

/// The paper's three conditions, and everything at once.
pub fn noises() -> [(&'static str, Noise); 4] {
    let sensor = Noise {
        sensor: (0.0, 0.4),
        ..Noise::default()
    };
    let conservative = Noise {
        walk_range: 30.0,
        walk_step: 1.5,
        ..Noise::default()
    };
    let all = Noise {
        sensor: (-0.2, 0.2),
        motor: 0.1,
        ..conservative
    };
    [
        ("none", Noise::default()),
        ("sensor", sensor),
        ("conservative", conservative),
        ("all", all),
    ]
}

/// A robot with tables for the objects of all arenas. If it has no table for blocks, it gets one with random readings for each of four
/// points of view: here only bits are compared, not behaviour.
fn knowing_blocks(robot: &Robot) -> Robot {
    const CLASS: &str = "block";
    let mut sensors = (*robot.sensors).clone();
    if sensors.class(CLASS).is_none()
        && let Some(first) = sensors.classes.first()
    {
        let mut table = SensorTable {
            class: CLASS.into(),
            views: 4,
            ..first.clone()
        };
        let reading = |cell: usize, sensor: usize| {
            let [word, ..] = pcg4d([cell as u32, sensor as u32, 0, 0x626c_6f63]);
            // Readings up to the maximum, few of them large.
            (word >> 22 & word >> 12 & 1023) as u16
        };
        let count = table.sensors as usize;
        table.readings = (0..table.cells() * count)
            .map(|at| reading(at / count, at % count))
            .collect();
        sensors.classes.push(table);
    }
    Robot {
        sensors: Arc::new(sensors),
        ..robot.clone()
    }
}

/// Worlds of one controller: each arena of the catalogue with each noise, the tasks and starts taking turns.
///
/// # Errors
/// None, as the tests show.
pub fn worlds(controller: &Controller, robot: &Robot) -> Result<Vec<World>, Invalid> {
    let mut worlds = Vec::new();
    let robot = &knowing_blocks(robot);
    let speeds = [Speed::Unsigned, Speed::Signed];
    let differences = [Difference::Root, Difference::Square];
    let activations = [Activation::Real, Activation::Perceived, Activation::None];
    for arena in Arena::NAMES.into_iter().filter_map(Arena::named) {
        for (_, noise) in noises() {
            let turn = worlds.len();
            let field = arena.field;
            let start = if turn % 5 == 4 {
                // The lower left corner is free in every arena's field.
                Start::At {
                    x: field.x + 0.125 * field.width,
                    y: field.y + 0.125 * field.height,
                    heading: 0.3,
                }
            } else {
                Start::Random
            };
            worlds.push(World::new(WorldSpec {
                robot: Robot {
                    turn_before_move: [0.0, 0.5, 1.0][turn % 3],
                    ..robot.clone()
                },
                arena: arena.clone(),
                noise,
                controller: controller.clone(),
                task: Task::Avoidance {
                    speed: speeds[turn % 2],
                    difference: differences[turn / 2 % 2],
                    activation: activations[turn % 3],
                    // The small arenas have cells that fit.
                    new_cell: if turn % 4 == 1 && field.width * field.height < 300_000.0 {
                        3.0
                    } else {
                        0.0
                    },
                },
                start,
                cycles: CYCLES,
                ..WorldSpec::miglino1995()
            })?);
        }
    }
    Ok(worlds)
}

/// Worlds of one controller with a surrogate: each arena of the catalogue, without any difference from the simulator, with the drawn
/// differences, and with twice as much.
///
/// # Errors
/// None, as the tests show.
pub fn surrogates(controller: &Controller, robot: &Robot) -> Result<Vec<World>, Invalid> {
    let mut worlds = Vec::new();
    let robot = &knowing_blocks(robot);
    for arena in Arena::NAMES.into_iter().filter_map(Arena::named) {
        for severity in [0.0, 1.0, 2.0] {
            let seed = worlds.len() as u64;
            worlds.push(World::new(WorldSpec {
                robot: robot.clone(),
                surrogate: Some(Arc::new(Surrogate::drawn(seed, Differences::all(severity)))),
                arena: arena.clone(),
                controller: controller.clone(),
                cycles: CYCLES,
                ..WorldSpec::miglino1995()
            })?);
        }
    }
    Ok(worlds)
}

/// On-board simulators of foragers: each scenario, with and without noise.
pub fn foragers() -> Vec<Foraging> {
    let quiet = |forager| Foraging {
        light_noise: 0.0,
        wheel_noise: 0.0,
        escape: 0.0,
        ..forager
    };
    [Light::OverNest, Light::Nowhere, Light::OppositeNest]
        .map(Foraging::odowd2014)
        .into_iter()
        .flat_map(|forager| [forager, quiet(forager)])
        .collect()
}

/// Worlds of swarms: that of the 2014 study, and a crowd without differences.
pub fn swarms() -> Vec<Swarm> {
    let short = |swarm: Swarm| Swarm {
        forager: Foraging {
            cycles: 300,
            ..swarm.forager
        },
        interval: 200,
        ..swarm
    };
    let crowd = Swarm {
        differences: swarm::Differences::NONE,
        line_of_sight: false,
        ..Swarm::odowd2014(24)
    };
    [Swarm::odowd2014(10), crowd].map(short).into()
}

/// A batch of swarms with random controllers and lights. Half of the robots are switched on later.
///
/// # Errors
/// More episodes than a batch can hold.
pub fn swarm_batch(worlds: &Worlds, rollouts: u32, seed: u32, trace: Option<TraceRequest>) -> Result<Batch, Invalid> {
    let swarms = swarms();
    let scenarios = [Light::OverNest, Light::Nowhere, Light::OppositeNest];
    let inputs: Vec<Vec<f32>> = (0..rollouts)
        .map(|index| {
            let swarm = &swarms[index as usize % swarms.len()];
            let lamp = Lamp {
                first: scenarios[index as usize % 3],
                then: scenarios[index as usize / 3 % 3],
                moves: 150,
            };
            let order = |robot| {
                let [a, b, c, d] = pcg4d([seed, index, robot, 0x7377_6d73]).map(|word| (word % 100) as f32 / 100.0);
                Order {
                    before: (robot % 2 == 0).then_some([a, b]),
                    after: [c, d],
                    at: 10 * (robot % 9),
                    begins: Some(100),
                }
            };
            swarm.inputs(&lamp, &(0..swarm.robots).map(order).collect::<Vec<_>>())
        })
        .collect();
    let rollouts: Vec<Rollout<'_>> = inputs
        .iter()
        .enumerate()
        .map(|(index, genes)| Rollout {
            world: index % swarms.len(),
            genes,
            key: Key::rollout(u64::from(seed), 0, index as u64, 0),
        })
        .collect();
    worlds.batch(&rollouts, trace)
}

/// An episode of each genome in the first of some worlds.
pub fn rollouts(genomes: &[Vec<f32>]) -> Vec<Rollout<'_>> {
    let lives = (0..).zip(genomes).map(|(index, genes)| Rollout {
        world: 0,
        genes,
        key: Key::rollout(1, 0, index, 0),
    });
    lives.collect()
}

/// A genome whose genes are uniform in -`size` to `size`: genome number `index` of the seed `seed`.
pub fn genome(genes: usize, size: f32, seed: u32, index: u32) -> Vec<f32> {
    let words = (0..genes as u32)
        .step_by(4)
        .flat_map(|block| pcg4d([seed, index, block, 0x6765_6e65]));
    // 24 bits make a number that float32 holds exactly.
    words
        .map(|word| ((word >> 8) as f32 * (2.0 / 16_777_216.0) - 1.0) * size)
        .take(genes)
        .collect()
}

/// A batch of `rollouts` episodes that take turns over the worlds, with small and large genes in turn.
///
/// # Errors
/// More episodes than a batch can hold.
pub fn batch(worlds: &Worlds, rollouts: u32, seed: u32, trace: Option<TraceRequest>) -> Result<Batch, Invalid> {
    let genes = worlds.genes();
    let count = genes.len() as u32;
    let world_of = |index: u32| (index % count) as usize;
    let genomes: Vec<Vec<f32>> = (0..rollouts)
        .map(|index| {
            let size = if (index / count).is_multiple_of(2) { 1.0 } else { 8.0 };
            genome(genes[world_of(index)], size, seed, index)
        })
        .collect();
    let rollouts: Vec<Rollout<'_>> = (0..rollouts)
        .zip(&genomes)
        .map(|(index, genes)| Rollout {
            world: world_of(index),
            genes,
            key: Key::rollout(u64::from(seed), 0, u64::from(index), 0),
        })
        .collect();
    worlds.batch(&rollouts, trace)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn worlds_are_allowed_and_of_every_kind() {
        for (_, controller) in CONTROLLERS {
            let worlds = worlds(&controller, &Robot::khepera()).unwrap();
            assert_eq!(worlds.len(), Arena::NAMES.len() * noises().len());
            let tasks: Vec<Task> = worlds.iter().map(|world| world.spec().task).collect();
            let different = (0..tasks.len()).filter(|&i| !tasks[..i].contains(&tasks[i])).count();
            assert_eq!(different, 14, "twelve choices, and new cells in some");
            assert!(worlds.iter().any(|world| world.spec().start != Start::Random));
            assert!(batch(&Worlds::new(&worlds).unwrap(), 100, 1, None).is_ok());
            let surrogates = surrogates(&controller, &Robot::khepera()).unwrap();
            assert_eq!(surrogates.len(), Arena::NAMES.len() * 3);
            assert!(batch(&Worlds::new(&surrogates).unwrap(), 100, 1, None).is_ok());
        }
    }

    #[test]
    fn foragers_are_allowed() {
        let foragers = Worlds::new(&foragers()).unwrap();
        assert_eq!(foragers.genes(), [2; 6]);
        assert!(batch(&foragers, 100, 1, None).is_ok());
    }

    #[test]
    fn genomes_are_uniform_and_known() {
        let all: Vec<f32> = (0..1000).flat_map(|index| genome(18, 1.0, 1, index)).collect();
        assert!(all.iter().all(|gene| (-1.0..1.0).contains(gene)));
        let mean = all.iter().map(|&gene| f64::from(gene)).sum::<f64>() / all.len() as f64;
        assert!(mean.abs() < 0.02, "{mean}");
        assert_ne!(genome(18, 1.0, 1, 0), genome(18, 1.0, 1, 1));
        assert_ne!(genome(18, 1.0, 1, 0), genome(18, 1.0, 2, 0));
        assert_eq!(
            genome(2, 8.0, 1, 0),
            genome(18, 1.0, 1, 0)[..2]
                .iter()
                .map(|gene| gene * 8.0)
                .collect::<Vec<_>>()
        );
    }
}
