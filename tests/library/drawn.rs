//! Worlds that vary, zones of starts, and what parts see of the world.

use std::sync::Arc;

use oneiro::arena::{Arena, Block, Field, Light, Obstacle, Patch, Wall};
use oneiro::batch::{Batch, Rollout, Trace, TraceRequest};
use oneiro::compose::{Kind, OwnPart, OwnParts, Part};
use oneiro::cpu::Cpu;
use oneiro::differential::{Build, Differential, Starts};
use oneiro::evaluator::{Control, Evaluator};
use oneiro::foraging::Forager;
use oneiro::parameter::Datum;
use oneiro::random::Key;
use oneiro::world::{ByKey, Poses, Robot, Start, Task, Varied, World, WorldSpec, Zone};

use crate::composed::Subject;

/// Individuals and trials of a batch.
const INDIVIDUALS: u64 = 5;
const TRIALS: u64 = 13;

fn range(least: f32, greatest: f32) -> Datum {
    Datum::List(vec![Datum::Single(least), Datum::Single(greatest)])
}

fn by_key<const N: usize>(values: [(&str, Datum); N]) -> ByKey {
    ByKey(values.map(|(key, values)| (key.to_owned(), values)).into())
}

/// Obstacles and noise that are drawn for seven worlds.
fn drawn() -> Varied {
    Varied {
        count: Some(7),
        seed: Some(3),
        vary: by_key([
            ("arena.obstacles[].x_mm", range(100.0, 500.0)),
            ("noise.sensor", Datum::List(vec![range(0.0, 0.1), range(0.2, 0.3)])),
        ]),
        choose: by_key([(
            "arena.obstacles[1].radius_mm",
            Datum::List(vec![Datum::Single(15.0), Datum::Single(40.0)]),
        )]),
    }
}

fn poses() -> Start {
    Start::Poses(Poses(vec![[60.0, 60.0, 0.0], [60.0, 290.0, 0.5], [540.0, 60.0, -0.25]]))
}

/// Two starts of three robots.
fn swarm_poses() -> Start {
    Start::Poses(Poses(vec![
        [60.0, 60.0, 0.0],
        [60.0, 290.0, 0.5],
        [540.0, 60.0, -0.25],
        [200.0, 500.0, 0.125],
        [300.0, 500.0, 0.0625],
        [700.0, 400.0, 0.0],
    ]))
}

fn alone() -> WorldSpec {
    WorldSpec {
        cycles: 40,
        ..WorldSpec::miglino1995()
    }
}

/// A parametric robot with eyes for the floor and for objects, or several of them.
fn parametric(count: Option<u32>) -> WorldSpec {
    let mut spec = WorldSpec {
        robot: Robot {
            build: Build::Differential(Differential {
                count,
                ..Differential::new(51.0, 128.0)
            }),
            ..Robot::khepera()
        },
        arena: Arena::rectangle(800.0, 600.0).with_obstacles([(400.0, 300.0), (600.0, 150.0)], 30.0),
        ..alone()
    };
    spec.arena.patches.push(Patch {
        x: 200.0,
        y: 200.0,
        radius: Some(160.0),
        ..Patch::default()
    });
    spec
}

fn genes(world: &World, individual: u64) -> Vec<f32> {
    let gene = |gene: usize| ((gene as u64 * 7 + individual * 11) % 17) as f32 / 4.0 - 2.0;
    (0..world.genes()).map(gene).collect()
}

/// All trials of all individuals of a generation, or their first ones.
fn batch(world: &World, count: usize) -> Batch {
    let genomes: Vec<Vec<f32>> = (0..INDIVIDUALS).map(|individual| genes(world, individual)).collect();
    let rollouts: Vec<_> = (0..INDIVIDUALS)
        .flat_map(|individual| (0..TRIALS).map(move |trial| (individual, trial)))
        .map(|(individual, trial)| Rollout {
            world: 0,
            genes: &genomes[individual as usize],
            key: Key::rollout(9, 4, individual, trial),
        })
        .take(count)
        .collect();
    Batch::new(std::slice::from_ref(world), &rollouts, Some(TraceRequest { every: 1 })).unwrap()
}

pub(crate) fn subjects() -> Vec<Subject> {
    let with = |spec: WorldSpec, varied: Varied, start: Start| World::new(WorldSpec { varied, start, ..spec }).unwrap();
    let ring = || {
        Start::Zone(Zone {
            x: Some(400.0),
            y: Some(300.0),
            radius: Some(250.0),
            inner: Some(80.0),
            ..Zone::default()
        })
    };
    let vary_floor = Varied {
        vary: by_key([("arena.patches[0].x_mm", range(150.0, 600.0))]),
        count: Some(5),
        ..Varied::default()
    };
    let nest = Start::Zone(Zone {
        patch: Some(0),
        ..Zone::default()
    });
    let worlds = [
        ("poses", with(alone(), Varied::default(), poses())),
        ("drawn", with(alone(), drawn(), Start::Random)),
        ("both", with(alone(), drawn(), poses())),
        ("ring", with(parametric(None), Varied::default(), ring())),
        ("swarm in a ring", with(parametric(Some(3)), Varied::default(), ring())),
        ("swarm in its nest", with(parametric(Some(3)), vary_floor.clone(), nest)),
        (
            "swarm at its poses",
            with(parametric(Some(3)), vary_floor, swarm_poses()),
        ),
        ("told", told(parametric(None))),
        ("told to a swarm", told(parametric(Some(2)))),
    ];
    let subject = |(name, world): (&str, World)| {
        let subject = Subject::new(name, (INDIVIDUALS * TRIALS) as usize, 3, |count| batch(&world, count));
        subject.without_specialising()
    };
    worlds.into_iter().map(subject).collect()
}

fn traces(batch: &Batch) -> Vec<(u32, Trace)> {
    let mut cpu = Cpu::new(Some(1)).unwrap();
    let outcome = cpu.evaluate(batch, &Control::new()).unwrap();
    outcome
        .fitness
        .iter()
        .map(|fitness| fitness.to_bits())
        .zip(outcome.traces)
        .collect()
}

/// A forager's arena is as large as its numbers say, in each world.
#[test]
fn a_foragers_arena_may_be_drawn() {
    let of = |key: &str, range: Datum| {
        World::new(WorldSpec {
            varied: Varied {
                count: Some(3),
                vary: by_key([(key, range)]),
                ..Varied::default()
            },
            ..WorldSpec::foraging(Forager::ODOWD2014)
        })
    };
    let world = of("arena.radius_mm", range(400.0, 700.0)).unwrap();
    let widths: Vec<f32> = world
        .variants()
        .iter()
        .map(|world| world.spec().arena.field.width)
        .collect();
    assert!(
        widths[0] != widths[1] && widths.iter().all(|width| (800.0..=1400.0).contains(width)),
        "{widths:?}"
    );
    assert!(of("arena.light_noise", range(0.0, 0.1)).is_ok());
    let refused = of("arena.food_items", range(2.0, 5.0)).unwrap_err().to_string();
    assert!(
        refused.contains("\"arena.food_items\", which is no number with a fraction"),
        "{refused}"
    );
}

/// Robots of a swarm begin exactly at their poses, in turns.
#[test]
fn a_swarms_robots_begin_at_their_poses() {
    let spec = WorldSpec {
        start: swarm_poses(),
        ..parametric(Some(3))
    };
    let Start::Poses(Poses(poses)) = &spec.start else {
        unreachable!()
    };
    let observed = World::new(spec.clone()).unwrap().observed().unwrap();
    assert_eq!(observed.variants().len(), 2);
    let genes = genes(&observed, 1);
    for trial in 0..5 {
        let rollout = Rollout {
            world: 0,
            genes: &genes,
            key: Key::rollout(9, 4, 0, trial),
        };
        let batch = Batch::new(
            std::slice::from_ref(&observed),
            &[rollout],
            Some(TraceRequest { every: 1 }),
        )
        .unwrap();
        let (_, trace) = traces(&batch).pop().unwrap();
        for (robot, own) in trace.by_robot(3).iter().enumerate() {
            let first = own.iter().next().unwrap();
            let [x, y, heading] = poses[trial as usize % 2 * 3 + robot];
            assert_eq!(
                [first.x, first.y, first.heading],
                [x, y, heading.rem_euclid(1.0)],
                "robot {robot} in trial {trial}"
            );
        }
    }
}

/// Every episode of a world that varies has the bits of the world that it says is the episode's.
#[test]
fn an_episode_takes_one_of_the_worlds() {
    let world = World::new(WorldSpec {
        varied: drawn(),
        start: poses(),
        ..alone()
    })
    .unwrap();
    assert_eq!(world.variants().len(), 21);
    let all = traces(&batch(&world, usize::MAX));
    let mut taken = [false; 21];
    for individual in 0..INDIVIDUALS {
        for trial in 0..TRIALS {
            let key = Key::rollout(9, 4, individual, trial);
            // Individuals of a generation share worlds.
            assert_eq!(world.variant(key), world.variant(Key::rollout(9, 4, 0, trial)));
            taken[world.variant(key)] = true;
            let genes = genes(&world, individual);
            let rollout = Rollout {
                world: 0,
                genes: &genes,
                key,
            };
            let own = world.of(key);
            let Start::At { x, y, .. } = own.spec().start else {
                panic!("a variant has one start");
            };
            assert_eq!([x, y], [[60.0, 60.0], [60.0, 290.0], [540.0, 60.0]][trial as usize % 3]);
            let alone = Batch::new(std::slice::from_ref(own), &[rollout], Some(TraceRequest { every: 1 })).unwrap();
            let (fitness, trace) = traces(&alone).remove(0);
            let (other_fitness, other_trace) = &all[(individual * TRIALS + trial) as usize];
            assert_eq!(fitness, *other_fitness);
            assert!(trace.words().eq(other_trace.words()));
        }
    }
    assert!(taken.iter().filter(|taken| **taken).count() > 6, "{taken:?}");
    assert_ne!(
        (0..20)
            .map(|trial| world.variant(Key::rollout(9, 4, 0, trial)))
            .collect::<Vec<_>>(),
        (0..20)
            .map(|trial| world.variant(Key::rollout(9, 5, 0, trial)))
            .collect::<Vec<_>>(),
    );
}

fn obstacles(varied: Varied) -> Vec<Vec<[f32; 2]>> {
    let world = World::new(WorldSpec { varied, ..alone() }).unwrap();
    let of = |world: &World| {
        let obstacles = world.spec().arena.obstacles.iter();
        obstacles.map(|own| [own.x, own.radius]).collect()
    };
    world.variants().iter().map(of).collect()
}

#[test]
fn draws_are_within_their_ranges_and_depend_on_nothing_else() {
    let all = obstacles(drawn());
    for [first, second, third] in all.iter().map(|own| [own[0], own[1], own[2]]) {
        assert!([first, second, third].iter().all(|[x, _]| (100.0..=500.0).contains(x)));
        assert!(first[0] != second[0] && second[0] != third[0]);
        assert!([15.0, 40.0].contains(&second[1]) && first[1] == 27.5);
    }
    let radii: Vec<f32> = all.iter().map(|own| own[1][1]).collect();
    assert!(radii.contains(&15.0) && radii.contains(&40.0), "{radii:?}");
    // Fewer keys, and more worlds: the draws of the others stay.
    let fewer = obstacles(Varied {
        count: Some(9),
        vary: by_key([("arena.obstacles[].x_mm", range(100.0, 500.0))]),
        choose: ByKey::default(),
        ..drawn()
    });
    for (own, other) in all.iter().zip(&fewer) {
        assert!(own.iter().zip(other).all(|(own, other)| own[0] == other[0]));
    }
    let of_another_seed = obstacles(Varied {
        seed: Some(4),
        ..drawn()
    });
    assert!(all.iter().zip(&of_another_seed).all(|(own, other)| own[0] != other[0]));
}

#[test]
fn starts_fill_their_zone() {
    let zone = |zone: Zone, count: Option<u32>| {
        let world = World::new(WorldSpec {
            start: Start::Zone(zone),
            ..parametric(count)
        })
        .unwrap();
        let traces = traces(&batch(&world, usize::MAX));
        traces
            .iter()
            .map(|(_, trace)| [trace[0].x, trace[0].y])
            .collect::<Vec<_>>()
    };
    let away = |[x, y]: [f32; 2], [to_x, to_y]: [f32; 2]| (x - to_x).hypot(y - to_y);
    for count in [None, Some(3)] {
        let rectangle = zone(
            Zone {
                x: Some(200.0),
                y: Some(400.0),
                sides: Some([300.0, 200.0]),
                ..Zone::default()
            },
            count,
        );
        assert!(
            rectangle
                .iter()
                .all(|[x, y]| (50.0..=350.0).contains(x) && (300.0..=500.0).contains(y))
        );
        assert!(rectangle.iter().any(|[x, _]| *x < 120.0) && rectangle.iter().any(|[x, _]| *x > 280.0));
        let middle = [400.0, 300.0];
        let ring = zone(
            Zone {
                x: Some(400.0),
                y: Some(300.0),
                radius: Some(250.0),
                inner: Some(200.0),
                ..Zone::default()
            },
            count,
        );
        assert!(ring.iter().all(|at| (199.99..=250.01).contains(&away(*at, middle))));
        // Uniform over the area: half of them outside of the root of the mean of the squares, 226 mm.
        let outside = ring.iter().filter(|at| away(**at, middle) > 226.4).count();
        assert!(
            (ring.len() / 4..3 * ring.len() / 4).contains(&outside),
            "{outside} of {}",
            ring.len()
        );
        let patch = zone(
            Zone {
                patch: Some(0),
                ..Zone::default()
            },
            count,
        );
        assert!(patch.iter().all(|at| away(*at, [200.0, 200.0]) <= 160.01));
    }
}

#[test]
fn what_cannot_vary_is_refused() {
    let refused = |spec: WorldSpec, key: &str, words: &str| {
        let invalid = World::new(spec).unwrap_err();
        assert!(
            invalid.field.starts_with(key) && invalid.problem.contains(words),
            "{invalid}"
        );
    };
    let vary = |key: &str, values: Datum| WorldSpec {
        varied: Varied {
            vary: by_key([(key, values)]),
            ..Varied::default()
        },
        ..alone()
    };
    refused(
        vary("arena.obstacles[0].x", range(1.0, 2.0)),
        "worlds.vary",
        "did you mean arena.obstacles[].x_mm",
    );
    refused(
        vary("arena.obstacles[9].x_mm", range(1.0, 2.0)),
        "worlds.vary",
        "doesn't have",
    );
    refused(
        vary("arena.lights[].x_mm", range(1.0, 2.0)),
        "worlds.vary",
        "doesn't have",
    );
    refused(
        vary("robot.count", range(1.0, 2.0)),
        "worlds.vary",
        "no number with a fraction",
    );
    refused(
        vary("evolution.generations", range(1.0, 2.0)),
        "worlds.vary",
        "no number of a world",
    );
    refused(
        vary("arena.obstacles[0].x_mm", range(2.0, 1.0)),
        "worlds.vary",
        "[minimum, maximum]",
    );
    refused(vary("noise.sensor", range(0.0, 1.0)), "worlds.vary", "two such ranges");
    refused(
        vary("arena.obstacles[0].x_mm", range(0.0, 9e9)),
        "worlds",
        "makes world",
    );
    let spec = WorldSpec {
        varied: Varied {
            seed: Some(1),
            ..Varied::default()
        },
        ..alone()
    };
    refused(spec, "worlds.seed", "no number is drawn");
    // The same number by two keys.
    let mut twice = drawn();
    twice
        .vary
        .0
        .push(("arena.obstacles[0].x_mm".to_owned(), range(300.0, 310.0)));
    let spec = WorldSpec {
        varied: twice,
        ..alone()
    };
    refused(
        spec,
        "worlds.vary",
        "whose arena.obstacles[0].x_mm another key also draws",
    );
    let at = |poses: Vec<[f32; 3]>| WorldSpec {
        start: Start::Poses(Poses(poses)),
        ..alone()
    };
    refused(at(Vec::new()), "start.poses", "has 0 poses");
    refused(
        at(vec![[60.0, 60.0, 0.0], [300.0, 175.0, 0.0]]),
        "start.poses",
        "pose 1",
    );
    refused(
        at(vec![[60.0, 60.0, 0.0], [900.0, 175.0, 0.0]]),
        "start.poses",
        "pose 1",
    );
    let zone = |zone: Zone| WorldSpec {
        start: Start::Zone(zone),
        ..alone()
    };
    let disc = Zone {
        x: Some(300.0),
        y: Some(175.0),
        radius: Some(100.0),
        ..Zone::default()
    };
    refused(zone(Zone::default()), "start.kind", "without a place");
    refused(zone(Zone { radius: None, ..disc }), "start.kind", "without a size");
    refused(
        zone(Zone {
            radius: Some(500.0),
            ..disc
        }),
        "start",
        "within the arena",
    );
    refused(
        zone(Zone {
            inner: Some(100.0),
            ..disc
        }),
        "start.inner",
        "1 mm less",
    );
    refused(
        zone(Zone {
            sides: Some([9.0; 2]),
            ..disc
        }),
        "start.sides_mm",
        "together with a radius",
    );
    refused(zone(Zone { patch: Some(0), ..disc }), "start.patch", "either");
    refused(
        zone(Zone {
            patch: Some(0),
            ..Zone::default()
        }),
        "start.patch",
        "0 patches",
    );
    refused(
        zone(Zone {
            radius: Some(20.0),
            ..disc
        }),
        "start",
        "free in 0 %",
    );
    let swarm = |start| WorldSpec {
        start,
        ..parametric(Some(4))
    };
    refused(
        swarm(poses()),
        "start.poses",
        "has 3 poses; allowed: a pose for each of 4 robots",
    );
    let at = Start::At {
        x: 60.0,
        y: 60.0,
        heading: 0.0,
    };
    refused(swarm(at), "start.kind", "is `at`; allowed: only without robot.count");
    let near = [60.0, 65.0, 110.0, 400.0].map(|x| [x, 60.0, 0.0]);
    refused(
        swarm(Start::Poses(Poses(near.into()))),
        "start.poses",
        "overlapping places 0 and 1",
    );
    let mut twice = swarm(Start::Poses(Poses(
        [60.0, 160.0, 260.0, 360.0].map(|x| [x, 60.0, 0.0]).into(),
    )));
    if let Build::Differential(robot) = &mut twice.robot.build {
        robot.starts = Some(Starts([60.0, 160.0, 260.0, 360.0].map(|x| [x, 160.0]).into()));
    }
    refused(twice, "start.kind", "together with robot.starts_mm");
}

/// A world with one of everything, whose task scores what it is told.
fn told(mut spec: WorldSpec) -> World {
    let is_swarm = matches!(&spec.robot.build, Build::Differential(robot) if robot.count.is_some());
    spec.arena.floor = Some(0.75);
    spec.arena.patches.push(Patch {
        x: 300.0,
        y: 500.0,
        sides: Some([100.0, 40.0]),
        heading: 0.25,
        grey: 0.5,
        ..Patch::default()
    });
    if spec.arena.walls.is_empty() {
        spec.arena.walls = Arena::rectangle(800.0, 600.0).walls;
    }
    spec.arena.walls.push(Wall {
        from: [500.0, 400.0],
        to: [500.0, 600.0],
        ..Wall::default()
    });
    spec.arena.obstacles.push(Obstacle {
        x: 100.0,
        y: 500.0,
        radius: 25.0,
        ..Obstacle::default()
    });
    spec.arena.blocks.push(Block {
        x: 700.0,
        y: 500.0,
        length: 60.0,
        width: 20.0,
        heading: 0.25,
        ..Block::default()
    });
    spec.arena.lights.push(Light {
        x: 10.0,
        y: 20.0,
        brightness: 0.5,
        ..Light::default()
    });
    let function = if is_swarm {
        "mission_score(episode: Episode, memory: MissionState"
    } else {
        "task_score(episode: Episode, memory: TaskState"
    };
    let cycle = if is_swarm {
        "fn mission_cycle(episode: Episode, step: u32, before: MissionState) -> Tally { return Tally(0.0, before); }"
    } else {
        "fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward { return Reward(0.0, before); }"
    };
    let robots = if is_swarm { 2 } else { 1 };
    let text = format!(
        "{cycle}
        fn {function}, sum: f32) -> f32 {{
            let light = arena_light(episode, 7u);
            let disc = arena_patch(episode, 0u);
            let mat = arena_patch(episode, 1u);
            let wall = arena_wall(episode, 4u);
            let obstacle = arena_obstacle(episode, 2u);
            let block = arena_block(episode, 0u);
            let field = arena_field(episode);
            var right = 0u;
            right += u32(arena_lights(episode) == 1u && all(light.place == vec2(10.0, 20.0)) && light.height == 0.0);
            right += u32(light.brightness == 0.5 && light.intensity == 1.0);
            right += u32(arena_patches(episode) == 2u && all(disc.place == vec2(200.0, 200.0)) && disc.radius == 160.0);
            right += u32(all(disc.half_sides == vec2(0.0, 0.0)) && disc.grey == 0.0 && mat.radius == 0.0 && mat.grey == 0.5);
            right += u32(all(mat.half_sides == vec2(50.0, 20.0)) && all(mat.along == vec2(0.0, 1.0)));
            right += u32(arena_walls(episode) == 5u && all(wall.start == vec2(500.0, 400.0)) && all(wall.end == vec2(500.0, 600.0)));
            right += u32(arena_obstacles(episode) == 3u && all(obstacle.place == vec2(100.0, 500.0)) && obstacle.radius == 25.0);
            right += u32(arena_blocks(episode) == 1u && all(block.place == vec2(700.0, 500.0)));
            right += u32(all(block.half_sides == vec2(30.0, 10.0)) && all(block.along == vec2(0.0, 1.0)));
            right += u32(all(field.low == vec2(0.0, 0.0)) && all(field.high == vec2(800.0, 600.0)));
            right += u32(on_patch(episode, 0u, vec2(200.0, 310.0)) && !on_patch(episode, 0u, vec2(200.0, 370.0)));
            right += u32(on_patch(episode, 1u, vec2(310.0, 540.0)) && !on_patch(episode, 1u, vec2(340.0, 510.0)) && !on_patch(episode, 2u, vec2(310.0, 540.0)));
            right += u32(floor_at(episode, vec2(200.0, 200.0)) == 0.0 && floor_at(episode, vec2(300.0, 500.0)) == 0.5 && floor_at(episode, vec2(700.0, 300.0)) == 0.75);
            right += u32(abs(clearance(episode, vec2(100.0, 400.0), 900.0) - (75.0 - body_radius(episode))) < 0.001);
            right += u32(clearance(episode, vec2(100.0, 400.0), 20.0) == 20.0 && clearance(episode, vec2(700.0, 500.0), 20.0) < 0.0);
            right += u32(robots(episode) == {robots}u && robot_number(episode) == 0u);
            return f32(right) + 100.0 * f32(trial(episode));
        }}"
    );
    let part = Part::new(Kind::Task, "told.wgsl", &text).unwrap_or_else(|refused| panic!("{refused}"));
    spec.own = OwnParts::from([OwnPart::new(Arc::new(part), &[]).unwrap()]);
    spec.task = Task::Own;
    spec.cycles = 2;
    World::new(spec).unwrap_or_else(|invalid| panic!("{invalid}"))
}

#[test]
fn parts_are_told_of_the_whole_world() {
    for count in [None, Some(2)] {
        let world = told(parametric(count));
        for (index, (fitness, _)) in traces(&batch(&world, usize::MAX)).into_iter().enumerate() {
            let trial = index as u64 % TRIALS;
            assert_eq!(
                f32::from_bits(fitness),
                16.0 + 100.0 * trial as f32,
                "{count:?}, {index}"
            );
        }
    }
}

/// A single robot starts at random in a polygon or a disc, too.
#[test]
fn a_robot_alone_starts_anywhere_in_a_polygon() {
    let corners = [[0.0, 0.0], [800.0, 0.0], [400.0, 700.0]];
    let world = World::new(WorldSpec {
        arena: Arena::polygon(&corners, Some(100.0)),
        ..parametric(None)
    })
    .unwrap();
    let Field { x, y, width, .. } = world.spec().arena.field;
    let starts = traces(&batch(&world, usize::MAX));
    let away = |trace: &Trace| (trace[0].x - x - 0.5 * width).hypot(trace[0].y - y - 0.5 * width);
    assert!(starts.iter().all(|(_, trace)| away(trace) <= 100.01));
    assert!(starts.iter().any(|(_, trace)| away(trace) > 80.0));
}
