//! Swarms of many bodies, which find those near them by squares over the arena.

use oneiro::arena::{Arena, Patch};
use oneiro::batch::Trace;
use oneiro::cpu::Cpu;
use oneiro::differential::{Build, Differential, Sensor, SensorKind, Starts};
use oneiro::evaluator::{Control, Evaluator};
use oneiro::reference::Model;
use oneiro::world::{Collision, Pucks, Robot, Task, World, WorldSpec};

use crate::composed::Subject;
use crate::tasks::batch;

const BODY: f32 = 27.5;
const PUCK: f32 = 22.0;
/// Most bodies that all look at each other.
const FEW: u32 = 128;

/// Robots packed in a corner of a large room, where they push each other, pucks among them, and `far` pucks so far away that nothing
/// notices them.
fn spec(task: Task, count: u32, pucks: u32, far: u32) -> WorldSpec {
    let place = |index: u32, side: u32, apart: f32, from: [f32; 2]| {
        let [column, row] = [index % side, index / side].map(|at| at as f32);
        [from[0] + apart * column, from[1] + apart * row]
    };
    let side = f64::from(count).sqrt().ceil() as u32;
    let starts = (0..count).map(|robot| place(robot, side, 56.0, [40.0, 40.0])).collect();
    let beside = 40.0 + 56.0 * side as f32;
    let near = (0..pucks).map(|puck| place(puck, 2, 50.0, [beside, 100.0]));
    let away = (0..far).map(|puck| place(puck, 4, 60.0, [9000.0, 3000.0]));
    let places: Vec<_> = near.chain(away).collect();
    let sensor = |name: &str, kind: SensorKind, heading: f32, range: f32| Sensor {
        name: name.to_owned(),
        kind,
        heading,
        range: Some(range),
        ..Sensor::default()
    };
    let mut sensors = vec![
        sensor("robot", SensorKind::Sight, 0.0, 700.0),
        sensor("left", SensorKind::Proximity, 0.1, 60.0),
        sensor("right", SensorKind::Proximity, -0.1, 60.0),
        sensor("bump", SensorKind::Bumper, 0.0, 2.0),
    ];
    if !places.is_empty() {
        sensors.push(sensor("puck", SensorKind::Puck, 0.0, 700.0));
    }
    let mut arena = Arena::rectangle(10_000.0, 4000.0).with_obstacles([(beside + 200.0, 300.0)], 60.0);
    arena.patches.push(Patch {
        x: 120.0,
        y: 120.0,
        radius: Some(110.0),
        ..Patch::default()
    });
    WorldSpec {
        task,
        arena,
        cycles: 40,
        pucks: if places.is_empty() {
            Pucks::default()
        } else {
            Pucks {
                count: Some(pucks + far),
                radius: Some(PUCK),
                grip: Some(8.0),
                places: Some(Starts(places)),
                ..Pucks::default()
            }
        },
        robot: Robot {
            body_radius: BODY,
            collision: Collision::Undo,
            build: Build::Differential(Differential {
                count: Some(count),
                starts: Some(Starts(starts)),
                sensors,
                ..Differential::new(51.0, 150.0)
            }),
            ..Robot::khepera()
        },
        ..WorldSpec::miglino1995()
    }
}

fn world(spec: WorldSpec) -> World {
    World::new(spec).unwrap_or_else(|invalid| panic!("{invalid}"))
}

pub(crate) fn subjects() -> Vec<Subject> {
    [
        ("140 robots", spec(Task::StayTogether, 140, 0, 0)),
        ("120 robots and 12 pucks", spec(Task::BringPucks, 120, 12, 0)),
    ]
    .map(|(name, spec)| {
        // Of so few cycles for the interpreter.
        let world = world(WorldSpec { cycles: 6, ..spec });
        Subject::new(name, 20, 1, |count| batch(&world, count)).without_specialising()
    })
    .into()
}

/// Those near by have the bits of all: of each record, where the first robot, the other robots and the first pucks are and what the
/// robot sensed.
#[test]
fn bodies_that_are_far_away_change_nothing() {
    const ROBOTS: u32 = 119;
    const PUCKS: u32 = 9;
    let lived = |task: Task, far: u32| {
        let world = world(spec(task, ROBOTS, PUCKS, far));
        assert_eq!(
            world.kernel().wgsl.contains("fn search_around"),
            ROBOTS + PUCKS + far > FEW
        );
        let outcome = Cpu::new(Some(2))
            .unwrap()
            .evaluate(&batch(&world, 20), &Control::new())
            .unwrap();
        let all = (PUCKS..PUCKS + far).flat_map(|puck| ["x", "y"].map(|axis| format!("puck_{puck}.{axis}")));
        let away: Vec<String> = all.collect();
        let is_kept: Vec<bool> = world
            .details()
            .iter()
            .map(|detail| !away.contains(&detail.name))
            .collect();
        let mut moved = 0;
        let mut words = Vec::new();
        for trace in &outcome.traces {
            let mut before = None;
            for (record, details) in trace.lines() {
                let details = details.iter().zip(&is_kept).filter(|(_, is_kept)| **is_kept);
                let kept: Vec<u32> = details.map(|(word, _)| *word).collect();
                moved += usize::from(before.as_ref().is_some_and(|before| *before != kept));
                words.push(
                    [record.x, record.y, record.heading, record.collided]
                        .map(f32::to_bits)
                        .to_vec(),
                );
                words.push(kept.clone());
                before = Some(kept);
            }
        }
        let pushed = outcome
            .traces
            .iter()
            .flatten()
            .filter(|record| record.collided > 0.0)
            .count();
        (outcome.fitness, words, moved, pushed)
    };
    for task in [Task::StayTogether, Task::BringPucks] {
        let (all, near) = (lived(task, 0), lived(task, 5));
        assert!(all.1 == near.1, "{task:?}");
        // Pucks that nobody brings count in the other task.
        assert!(
            task != Task::StayTogether || all.0 == near.0,
            "{:?} {:?}",
            all.0,
            near.0
        );
        assert!(all.2 > 700 && all.3 > 100, "{} moves, {} in contact", all.2, all.3);
    }
}

#[test]
fn a_thousand_robots_live_and_more_are_refused() {
    let mut own = spec(Task::StayTogether, 1024, 0, 0);
    own.cycles = 5;
    let world = world(own.clone());
    let outcome = Cpu::new(Some(2))
        .unwrap()
        .evaluate(&batch(&world, 2), &Control::new())
        .unwrap();
    let words: Vec<u32> = outcome.traces.iter().flat_map(Trace::words).collect();
    assert!(
        !words.is_empty() && outcome.fitness.iter().all(|fitness| (0.5..=1.0).contains(fitness)),
        "{:?}",
        outcome.fitness
    );
    let refused = |spec: WorldSpec, field: &str, words: &str| {
        let invalid = World::new(spec).unwrap_err();
        assert!(invalid.field == field && invalid.problem.contains(words), "{invalid}");
    };
    refused(spec(Task::StayTogether, 1025, 0, 0), "robot.count", "1024");
    refused(spec(Task::StayTogether, 1020, 6, 0), "pucks.count", "1 to 4");
    refused(spec(Task::StayTogether, 1024, 6, 0), "pucks.count", "no pucks");
    if let Build::Differential(robot) = &mut own.robot.build {
        robot.count = Some(129);
        robot.model = Some(Model::Vectors);
    }
    refused(own, "robot.count", "1 to 128");
}
