//! Arenas of many objects, of which robots look at those that are near.

use oneiro::arena::{Arena, Block, Obstacle, Wall};
use oneiro::batch::Trace;
use oneiro::cpu::Cpu;
use oneiro::differential::{Build, Differential, Sensor, SensorKind};
use oneiro::evaluator::{Control, Evaluator};
use oneiro::world::{Collision, Robot, World, WorldSpec};

use crate::composed::Subject;
use crate::tasks::batch;

/// A room with objects of all kinds in a pattern of 200 mm, and `far` more of them beyond its sides, where nothing notices them.
fn spec(count: Option<u32>, far: usize) -> WorldSpec {
    let mut arena = Arena::rectangle(1600.0, 1200.0);
    for place in 0..40_u16 {
        let [x, y] = [
            f32::from(place % 8) * 200.0 + 100.0,
            f32::from(place / 8) * 220.0 + 130.0,
        ];
        match place % 3 {
            0 => arena.walls.push(Wall {
                from: [x - 30.0, y],
                to: [x + 30.0, y + 20.0],
                ..Wall::default()
            }),
            1 => arena.obstacles.push(Obstacle {
                x,
                y,
                radius: 20.0,
                ..Obstacle::default()
            }),
            _ => arena.blocks.push(Block {
                x,
                y,
                length: 50.0,
                width: 15.0,
                heading: 0.1,
                ..Block::default()
            }),
        }
    }
    for place in 0..far {
        arena.obstacles.push(Obstacle {
            x: 5000.0 + 200.0 * (place % 30) as f32,
            y: 200.0 * (place / 30) as f32,
            radius: 10.0,
            ..Obstacle::default()
        });
    }
    let sensor = |name: &str, kind: SensorKind, heading: f32| Sensor {
        name: name.to_owned(),
        kind,
        heading,
        range: Some(70.0),
        ..Sensor::default()
    };
    WorldSpec {
        arena,
        cycles: 80,
        robot: Robot {
            collision: if count.is_none() {
                Collision::Slide
            } else {
                Collision::Undo
            },
            build: Build::Differential(Differential {
                count,
                sensors: vec![
                    sensor("left", SensorKind::Proximity, 0.1),
                    sensor("right", SensorKind::Proximity, -0.1),
                    sensor("ahead", SensorKind::Distance, 0.0),
                ],
                ..Differential::new(51.0, 150.0)
            }),
            ..Robot::khepera()
        },
        ..WorldSpec::miglino1995()
    }
}

pub(crate) fn subjects() -> Vec<Subject> {
    [None, Some(4)]
        .map(|count| {
            let world = World::new(spec(count, 100)).unwrap();
            let name = if count.is_none() { "alone" } else { "four robots" };
            Subject::new(name, 64, 2, |count| batch(&world, count)).without_specialising()
        })
        .into()
}

/// Looking at what is near has the bits of looking at everything.
#[test]
fn objects_that_are_far_away_change_nothing() {
    let lived = |spec: WorldSpec| {
        let world = World::new(spec).unwrap_or_else(|invalid| panic!("{invalid}"));
        let mut cpu = Cpu::new(Some(1)).unwrap();
        let outcome = cpu.evaluate(&batch(&world, 64), &Control::new()).unwrap();
        let words: Vec<u32> = outcome.traces.iter().flat_map(Trace::words).collect();
        let collisions = outcome
            .traces
            .iter()
            .flatten()
            .filter(|record| record.collided > 0.0)
            .count();
        (outcome.fitness, words, collisions)
    };
    for count in [None, Some(4)] {
        // 44 objects, and 1344 of which 1300 are far away. With a sensor that sees far, 44 are looked at without a grid.
        let seeing = |far| {
            let mut spec = spec(count, far);
            if let Build::Differential(robot) = &mut spec.robot.build {
                robot.sensors[2].range = Some(500.0);
            }
            spec
        };
        let (few, many) = (seeing(0), seeing(1300));
        for (spec, by_grid) in [(&few, false), (&many, true)] {
            let world = World::new(spec.clone()).unwrap();
            assert_eq!(world.kernel().name.contains("+near"), by_grid);
        }
        let (few, many) = (lived(few), lived(many));
        assert!(few.2 > 50, "{} collisions", few.2);
        assert_eq!(few, many);
    }
}

#[test]
fn limits_of_objects_are_refused() {
    let refused = |spec: WorldSpec, words: &str| {
        let invalid = World::new(spec).unwrap_err();
        assert!(invalid.field == "arena" && invalid.problem.contains(words), "{invalid}");
    };
    refused(spec(None, 4100), "0 to 4096 together");
    let mut crowded = spec(None, 0);
    crowded.arena.obstacles.extend((0..600_u16).map(|place| Obstacle {
        x: 700.0 + f32::from(place) * 0.01,
        y: 500.0,
        radius: 5.0,
        ..Obstacle::default()
    }));
    refused(crowded, "near one place; allowed: 512");
    let mut sampled = WorldSpec::miglino1995();
    sampled.arena.obstacles = spec(None, 100).arena.obstacles;
    refused(sampled, "0 to 64 together");
}
