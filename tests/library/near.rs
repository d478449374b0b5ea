//! Arenas of many objects and of many patches, of which robots look at those that are near.

use std::collections::BTreeSet;
use std::sync::Arc;

use oneiro::arena::{Arena, Block, Light, Obstacle, Patch, Wall};
use oneiro::batch::{Batch, Rollout, Trace};
use oneiro::compose::{Kind, OwnPart, OwnParts, Part};
use oneiro::cpu::Cpu;
use oneiro::differential::{Build, Differential, Sensor, SensorKind};
use oneiro::evaluator::{Control, Evaluator};
use oneiro::parameter::Datum;
use oneiro::picture::Picture;
use oneiro::random::Key;
use oneiro::surrogate::{Differences, Surrogate};
use oneiro::world::{ByKey, Collision, Robot, Task, Varied, World, WorldSpec};

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

/// Scores what parts are told of the floor: beneath the robot, and where it lies ahead of some robots and behind others.
const TOLD: &str = "\
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    let beneath = floor_at(episode, now.end.xy);
    return Reward(beneath + 3.0 * floor_at(episode, now.end.xy + vec2(-90.0, 70.0)) + now.real.energy, before);
}
";

/// A floor of 44 discs and rectangles, most of them over others and each of another grey, and more beyond its sides: so many before those in
/// the list, and so many after.
fn patched(count: Option<u32>, [before, after]: [usize; 2]) -> WorldSpec {
    let mut spec = spec(count, 0);
    let near = (0..44_u16).map(|place| {
        let is_disc = place % 3 > 0;
        Patch {
            x: f32::from(place * 397 % 1600),
            y: f32::from(place * 283 % 1200),
            radius: is_disc.then(|| 150.0 + 2.0 * f32::from(place)),
            sides: (!is_disc).then(|| [500.0, 170.0 + f32::from(place)]),
            heading: 0.07 * f32::from(place % 13),
            grey: f32::from(place) / 64.0,
            charges: Some(place % 11 == 5),
        }
    });
    let beyond = |place: usize| Patch {
        x: 5000.0 + 200.0 * (place % 30) as f32,
        y: 200.0 * (place / 30) as f32,
        radius: Some(80.0),
        grey: 0.99,
        ..Patch::default()
    };
    let (before, after) = ((0..before).map(beyond), (before..before + after).map(beyond));
    spec.arena.patches = before.chain(near).chain(after).collect();
    let ground = |name: &str, heading: f32, offset: f32| Sensor {
        name: name.to_owned(),
        kind: SensorKind::Ground,
        heading,
        offset: Some(offset),
        ..Sensor::default()
    };
    let Build::Differential(robot) = &mut spec.robot.build else {
        unreachable!("it is a parametric robot");
    };
    robot
        .sensors
        .extend([ground("floor_left", 0.1, 30.0), ground("floor_middle", 0.0, 0.0)]);
    robot.sensors.push(Sensor {
        name: "energy".to_owned(),
        kind: SensorKind::Battery,
        ..Sensor::default()
    });
    robot.battery = Some(3.0);
    let part = Part::new(Kind::Task, "told.wgsl", TOLD).unwrap_or_else(|refused| panic!("{refused}"));
    spec.own = OwnParts::from([OwnPart::new(Arc::new(part), &[]).unwrap()]);
    spec.task = Task::Own;
    spec
}

/// The same on a picture.
fn on_a_picture(mut spec: WorldSpec) -> WorldSpec {
    let greys = (0..30 * 20_u32).map(|cell| (cell * 37 % 251) as u8).collect();
    spec.arena.picture = Some(Picture::new([300.0, 200.0], [900.0, 600.0], [30, 20], greys).unwrap());
    spec
}

pub(crate) fn subjects() -> Vec<Subject> {
    let subject = |(name, spec): (&str, WorldSpec)| {
        let world = World::new(spec).unwrap_or_else(|invalid| panic!("{name}: {invalid}"));
        Subject::new(name, 64, 2, |count| batch(&world, count)).without_specialising()
    };
    let all = [
        ("alone", spec(None, 100)),
        ("four robots", spec(Some(4), 100)),
        ("patches", on_a_picture(patched(None, [600, 700]))),
        ("four robots on patches", patched(Some(4), [600, 700])),
    ];
    all.into_iter().map(subject).collect()
}

/// The fitness of episodes, the words of their traces, and the number of collisions.
fn lived(spec: WorldSpec) -> (Vec<f32>, Vec<u32>, usize) {
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
}

/// Looking at what is near has the bits of looking at everything.
#[test]
fn objects_that_are_far_away_change_nothing() {
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

/// The last patch at a place counts, whether it is found by a grid or among all.
#[test]
fn patches_that_are_far_away_change_nothing() {
    type Change<'a> = &'a dyn Fn(WorldSpec) -> WorldSpec;
    let surrogate = |spec: WorldSpec| WorldSpec {
        surrogate: Some(Arc::new(Surrogate::drawn(5, Differences::all(1.5)))),
        ..spec
    };
    let cases: [(Option<u32>, usize, Change<'_>); 4] = [
        (None, 600, &|spec| spec),
        (None, 600, &on_a_picture),
        (Some(4), 600, &on_a_picture),
        // It draws by their numbers how much light patches throw back.
        (None, 0, &surrogate),
    ];
    for (case, (count, before, change)) in cases.into_iter().enumerate() {
        let of = |far| change(patched(count, far));
        let (few, many) = (of([0, 0]), of([before, 700]));
        for (spec, by_grid) in [(&few, false), (&many, true)] {
            let world = World::new(spec.clone()).unwrap_or_else(|invalid| panic!("{invalid}"));
            assert_eq!(world.kernel().name.contains("+patches"), by_grid, "case {case}");
        }
        let few = lived(few);
        let mut fitness: Vec<_> = few.0.iter().map(|own| own.to_bits()).collect();
        fitness.sort_unstable();
        fitness.dedup();
        assert!(fitness.len() > 50, "{} scores in case {case}", fitness.len());
        assert!(few == lived(many), "case {case}");
    }
    // Without charging patches batteries run down, so the test above tells whether they charge.
    let mut uncharged = patched(None, [600, 700]);
    for own in &mut uncharged.arena.patches {
        own.charges = None;
    }
    assert!(lived(uncharged).0 != lived(patched(None, [600, 700])).0);
}

/// Drawn worlds, whose grids have different lists, share a kernel.
#[test]
fn drawn_patches_have_grids() {
    let fitness = |far| {
        let range = Datum::List(vec![Datum::Single(100.0), Datum::Single(1500.0)]);
        let names = [3, 4, 7].map(|patch_number| format!("arena.patches[{patch_number}].x_mm"));
        let world = World::new(WorldSpec {
            varied: Varied {
                vary: ByKey(names.map(|name| (name, range.clone())).into()),
                count: Some(8),
                ..Varied::default()
            },
            ..patched(None, [0, far])
        });
        let world = world.unwrap_or_else(|invalid| panic!("{invalid}"));
        assert_eq!(world.kernel().name.contains("+patches"), far > 0);
        let genes = vec![0.25; world.genes()];
        let rollout = |trial| Rollout {
            world: 0,
            genes: &genes,
            key: Key::rollout(3, 0, 0, trial),
        };
        let rollouts: Vec<_> = (0..24).map(rollout).collect();
        let batch = Batch::new(std::slice::from_ref(&world), &rollouts, None).unwrap();
        let outcome = Cpu::new(Some(1)).unwrap().evaluate(&batch, &Control::new());
        outcome
            .unwrap()
            .fitness
            .iter()
            .map(|own| own.to_bits())
            .collect::<Vec<_>>()
    };
    let few = fitness(0);
    assert_eq!(few, fitness(1300));
    assert!(few.iter().collect::<BTreeSet<_>>().len() > 15, "{few:?}");
}

/// 4,096 patches are looked up by a grid. One more is refused; too many at a place and too many lights are also refused.
#[test]
fn limits_of_patches_are_refused() {
    lived(WorldSpec {
        cycles: 5,
        ..patched(None, [0, 4096 - 44])
    });
    let refused = |spec: WorldSpec, message: &str| assert_eq!(World::new(spec).unwrap_err().to_string(), message);
    refused(
        patched(None, [0, 4097 - 44]),
        "arena.patches: has 4097 elements; allowed: up to 4096",
    );
    let mut sampled = WorldSpec::miglino1995();
    let spec = patched(None, [0, 4097 - 44]);
    (sampled.own, sampled.task) = (spec.own, Task::Own);
    sampled.arena.patches = spec.arena.patches;
    refused(sampled, "arena.patches: has 4097 elements; allowed: up to 4096");
    let mut crowded = patched(None, [0, 0]);
    let own = crowded.arena.patches[1].clone();
    crowded.arena.patches = vec![own; 513];
    refused(
        crowded.clone(),
        "arena.patches: has 513 patches near one place; allowed: 512",
    );
    crowded.arena.patches.pop();
    assert!(World::new(crowded).is_ok());
    let mut lit = patched(None, [0, 0]);
    lit.arena.lights = vec![
        Light {
            x: 0.0,
            y: 0.0,
            ..Light::default()
        };
        65
    ];
    refused(lit, "arena.lights: has 65 elements; allowed: up to 64");
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
