//! Swarms with one genome: bodies don't overlap, sensors notice others, missions see all robots; refusals.

use std::f64::consts::TAU;
use std::sync::Arc;

use crate::composed::Subject;
use oneiro::arena::{Arena, Obstacle, Patch, Wall};
use oneiro::batch::{Batch, Outcome, Rollout, Trace, TraceRequest, WorldKind, Worlds};
use oneiro::compose::{DetailKind, Kind, OwnPart, OwnParts, Part};
use oneiro::cpu::Cpu;
use oneiro::differential::{Build, Contact, Differential, Sensor, SensorKind};
use oneiro::evaluator::{Control, Evaluator};
use oneiro::random::{Key, pcg4d};
use oneiro::world::{Controller, Robot, Task, World, WorldSpec};

const CONTROLLER: &str = include_str!("../../experiments/aggregation/controller.wgsl");
const MISSION: &str = include_str!("../../experiments/aggregation/mission.wgsl");

/// The published controller: unseen left and right, seen left and right.
const PUBLISHED: [f32; 4] = [-0.7, -1.0, 1.0, -1.0];
const BODY: f32 = 37.0;
/// The greatest overlap that is allowed, mm: `OVERLAP` of `physics/contacts.wgsl`, and roundings.
const OVERLAP: f64 = 1.001;

fn own(kind: Kind, text: &str) -> OwnPart {
    let part = Part::new(kind, "own.wgsl", text).unwrap_or_else(|refused| panic!("{refused}"));
    OwnPart::new(Arc::new(part), &[]).unwrap()
}

fn robots(count: u32, contact: Contact, sensors: Vec<Sensor>) -> Robot {
    Robot {
        body_radius: BODY,
        build: Build::Differential(Differential {
            wheel_noise: Some(0.05),
            count: Some(count),
            contact: Some(contact),
            sensors,
            ..Differential::new(51.0, 128.0)
        }),
        ..Robot::khepera()
    }
}

fn sensor(name: &str, kind: SensorKind, heading: f32, range: f32) -> Sensor {
    Sensor {
        name: name.into(),
        kind,
        heading,
        range: Some(range),
        ..Sensor::default()
    }
}

/// An arena without walls.
fn open(side: f32) -> Arena {
    Arena {
        walls: Vec::new(),
        ..Arena::rectangle(side, side)
    }
}

/// Aggregation without computation, in a square of this side.
fn aggregation(count: u32, contact: Contact, side: f32, cycles: u32) -> WorldSpec {
    WorldSpec {
        robot: robots(count, contact, vec![sensor("sees", SensorKind::Sight, 0.0, 1e5)]),
        arena: open(side),
        controller: Controller::Own,
        task: Task::Own,
        own: OwnParts::from([own(Kind::Controller, CONTROLLER), own(Kind::Task, MISSION)]),
        cycles,
        ..WorldSpec::miglino1995()
    }
}

/// A robot's task and a mission in one part, each with a memory.
const BOTH: &str = "
struct TaskState {
    carried: u32,
    way: f32,
}
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    let grey = floor_at(episode, now.end.xy);
    let way = before.way + abs(now.moved.displacement) + f32(robot_number(episode)) * now.perceived.front;
    return Reward(grey - select(0.0f, 0.25f, now.collided), TaskState(before.carried + u32(grey < 0.5f), way));
}
struct MissionState {
    middle: vec2<f32>,
    cycles: i32,
}
fn mission_begin(episode: Episode) -> MissionState {
    return MissionState(robot_pose(episode, robots(episode) - 1u).xy, -1);
}
fn mission_cycle(episode: Episode, step: u32, before: MissionState) -> Tally {
    let pose = robot_pose(episode, 0u);
    return Tally(f32(clusters_within(episode, 200.0f).largest), MissionState(0.5f * (before.middle + pose.xy), before.cycles + 1));
}
fn mission_score(episode: Episode, own: MissionState, sum: f32) -> f32 {
    return sum + 0.001f * own.middle.x + f32(own.cycles);
}
";

/// Robots with sensors of all kinds that notice others, among walls, an obstacle and a patch.
fn crowd(count: u32, contact: Contact, controller: Controller) -> WorldSpec {
    let patch = Patch {
        x: 300.0,
        y: 300.0,
        radius: Some(200.0),
        ..Patch::default()
    };
    let obstacle = Obstacle {
        x: 700.0,
        y: 400.0,
        radius: 60.0,
        ..Obstacle::default()
    };
    let slanted = Wall {
        from: [100.0, 900.0],
        to: [500.0, 700.0],
        ..Wall::default()
    };
    let mut arena = Arena::rectangle(1500.0, 1200.0);
    arena.walls.push(slanted);
    arena.obstacles.push(obstacle);
    arena.patches.push(patch);
    let placed = Sensor {
        bearing: Some(0.25),
        ..sensor("aside", SensorKind::Proximity, 0.05, 150.0)
    };
    let sensors = vec![
        sensor("front", SensorKind::Proximity, 0.0, 200.0),
        sensor("behind", SensorKind::Distance, 0.5, 300.0),
        placed,
        sensor("touch", SensorKind::Bumper, 0.0, 2.0),
        sensor("sees", SensorKind::Sight, 0.1, 800.0),
    ];
    WorldSpec {
        robot: robots(count, contact, sensors),
        arena,
        controller,
        task: Task::Own,
        own: OwnParts::from([own(Kind::Task, BOTH)]),
        cycles: 100,
        ..WorldSpec::miglino1995()
    }
}

/// Genes from -1 to 1.
fn genome(life: u32, genes: usize) -> Vec<f32> {
    let word = |gene: usize| pcg4d([life, gene as u32, 0, 2026])[0];
    (0..genes)
        .map(|gene| (word(gene) % 2001) as f32 / 1000.0 - 1.0)
        .collect()
}

/// Lives of random genomes, the first of the published one if it has as many genes.
fn batch(world: &World, lives: u32, every: u32) -> Batch {
    let mut genomes: Vec<_> = (0..lives).map(|life| genome(life, world.genes())).collect();
    if world.genes() == PUBLISHED.len() {
        genomes[0] = PUBLISHED.to_vec();
    }
    let lives: Vec<_> = (0_u64..)
        .zip(&genomes)
        .map(|(life, genes)| Rollout {
            world: 0,
            genes,
            key: Key::rollout(1, 0, life, 0),
        })
        .collect();
    let trace = (every > 0).then_some(TraceRequest { every });
    Batch::new(std::slice::from_ref(world), &lives, trace).unwrap()
}

fn evaluated(evaluator: &mut dyn Evaluator, batch: &Batch) -> Outcome {
    evaluator.evaluate(batch, &Control::new()).unwrap()
}

fn lived(batch: &Batch) -> Outcome {
    evaluated(&mut Cpu::new(Some(2)).unwrap(), batch)
}

fn bits(numbers: &[f32]) -> Vec<u32> {
    numbers.iter().map(|number| number.to_bits()).collect()
}

/// Worlds of all contacts, controllers and numbers of robots.
fn worlds() -> Vec<(&'static str, World)> {
    let specs = [
        ("push", aggregation(10, Contact::Push, 600.0, 200)),
        ("stop", aggregation(10, Contact::Stop, 600.0, 200)),
        ("one", aggregation(1, Contact::Push, 600.0, 100)),
        ("forty", aggregation(40, Contact::Push, 1300.0, 50)),
        ("many", aggregation(128, Contact::Push, 2200.0, 30)),
        ("perceptron", crowd(7, Contact::Push, Controller::Perceptron)),
        ("recurrent", crowd(20, Contact::Push, Controller::Recurrent)),
        ("hidden", crowd(12, Contact::Stop, Controller::Hidden { units: 3 })),
    ];
    specs
        .map(|(name, spec)| {
            (
                name,
                World::new(spec).unwrap_or_else(|invalid| panic!("{name}: {invalid}")),
            )
        })
        .into()
}

/// Episodes that are pinned ([`crate::composed`]).
pub(crate) fn subjects() -> Vec<Subject> {
    let subject = |(name, world): (&str, World)| {
        // The interpreter takes a second for each world of twenty robots.
        let few = if world.robots() <= 20 { 2 } else { 0 };
        Subject::new(name, 70, few, move |episodes| batch(&world, episodes as u32, 7))
    };
    worlds().into_iter().map(subject).collect()
}

/// Lives that go on from their states are those that never stopped.
#[test]
fn lives_go_on_from_their_states() {
    let spec = aggregation(10, Contact::Push, 600.0, 100);
    let world = World::new(spec).unwrap();
    let worlds = Worlds::new(std::slice::from_ref(&world)).unwrap();
    let genomes: Vec<_> = (0..20).map(|life| genome(life, 4)).collect();
    let lives: Vec<_> = (0_u64..)
        .zip(&genomes)
        .map(|(life, genes)| Rollout {
            world: 0,
            genes,
            key: Key::rollout(1, 0, life, 0),
        })
        .collect();
    let whole = lived(&worlds.batch(&lives, None).unwrap());
    let first = lived(&worlds.stretch(&lives, 0..37, &[], None).unwrap());
    let second = lived(&worlds.stretch(&lives, 37..100, &first.states, None).unwrap());
    assert_eq!(bits(&second.fitness), bits(&whole.fitness));
    assert_ne!(bits(&first.fitness), bits(&whole.fitness));
    assert_eq!(first.states[0].len(), world.state_words() as usize);
}

/// Poses of all robots at the start of each cycle: x and y in mm, heading in turns.
fn poses(world: &World, trace: &Trace) -> Vec<Vec<[f64; 3]>> {
    let others: Vec<usize> = (0..)
        .zip(world.details())
        .filter(|(_, own)| own.kind == DetailKind::Other)
        .map(|(index, _)| index)
        .collect();
    let each = trace.lines().map(|(record, details)| {
        let first = [record.x, record.y, record.heading].map(f64::from);
        let others = others
            .chunks(3)
            .map(|pose| [pose[0], pose[1], pose[2]].map(|word| f64::from(f32::from_bits(details[word]))));
        std::iter::once(first).chain(others).collect()
    });
    each.collect()
}

/// The overlap of the two bodies of a world that overlap most, mm; below 0 if none do.
fn overlap(poses: &[[f64; 3]]) -> f64 {
    let mut most = f64::MIN;
    for (index, a) in poses.iter().enumerate() {
        for b in &poses[..index] {
            most = most.max(2.0 * f64::from(BODY) - (a[0] - b[0]).hypot(a[1] - b[1]));
        }
    }
    most
}

/// No two bodies overlap by more than the bound, nor does a body and a wall, however dense the crowd; and pushed robots do move.
#[test]
fn bodies_do_not_overlap_beyond_the_bound() {
    for (name, world) in worlds() {
        let spec = world.spec().clone();
        let outcome = lived(&batch(&world, 40, 1));
        let (mut most, mut touching) = (f64::MIN, 0);
        for trace in &outcome.traces {
            for poses in poses(&world, trace) {
                assert_eq!(poses.len(), world.robots() as usize);
                let overlap = overlap(&poses);
                most = most.max(overlap);
                touching += u32::from(overlap > -0.1);
                for pose in &poses {
                    for wall in &spec.arena.walls {
                        let depth = f64::from(BODY) - from_wall(wall, pose);
                        assert!(depth < OVERLAP, "{name}: {depth} mm in a wall");
                    }
                    for obstacle in &spec.arena.obstacles {
                        let apart = (pose[0] - f64::from(obstacle.x)).hypot(pose[1] - f64::from(obstacle.y));
                        assert!(f64::from(BODY + obstacle.radius) - apart < OVERLAP, "{name}");
                    }
                }
            }
        }
        assert!(most < OVERLAP, "{name}: {most} mm");
        if name != "one" {
            assert!(touching > 100, "{name}: bodies touch in {touching} cycles");
        }
    }
}

/// Distance of a pose from a wall.
fn from_wall(wall: &Wall, pose: &[f64; 3]) -> f64 {
    let [from, to] = [wall.from, wall.to].map(|end| end.map(f64::from));
    let span = [to[0] - from[0], to[1] - from[1]];
    let own = [pose[0] - from[0], pose[1] - from[1]];
    let share = (own[0] * span[0] + own[1] * span[1]) / (span[0] * span[0] + span[1] * span[1]);
    let share = share.clamp(0.0, 1.0);
    (own[0] - share * span[0]).hypot(own[1] - share * span[1])
}

/// The first robot's bit is what a ray through the poses of all meets, and its proximity the distance to it, in double precision.
#[test]
fn sensors_notice_other_robots() {
    let range = 400.0;
    let sensors = vec![
        sensor("sees", SensorKind::Sight, 0.0, 1e5),
        sensor("near", SensorKind::Distance, 0.25, range),
    ];
    let spec = WorldSpec {
        robot: robots(12, Contact::Push, sensors),
        controller: Controller::Perceptron,
        ..aggregation(12, Contact::Push, 900.0, 150)
    };
    let own = OwnParts::from([own(Kind::Task, MISSION)]);
    let world = World::new(WorldSpec { own, ..spec }).unwrap();
    let outcome = lived(&batch(&world, 30, 1));
    let read = |name: &str, details: &[u32]| {
        let is_it = |own: &oneiro::compose::Detail| own.kind == DetailKind::Real && own.name == name;
        f32::from_bits(details[world.details().iter().position(is_it).unwrap()])
    };
    // The distance along a ray from the first robot to the rim of another.
    let ray = |poses: &[[f64; 3]], turned: f64| {
        let angle = TAU * (poses[0][2] + turned);
        let mut nearest = (f64::INFINITY, f64::INFINITY);
        for other in &poses[1..] {
            let to = [other[0] - poses[0][0], other[1] - poses[0][1]];
            let along = to[0] * angle.cos() + to[1] * angle.sin();
            let aside = to[0] * angle.sin() - to[1] * angle.cos();
            let body = f64::from(BODY);
            if along > 0.0 {
                nearest.1 = nearest.1.min((aside.abs() - body).abs());
            }
            if along > 0.0 && aside.abs() < body {
                nearest.0 = nearest.0.min(along - (body * body - aside * aside).sqrt());
            }
        }
        nearest
    };
    let (mut seen, mut near) = (0, 0);
    for trace in &outcome.traces {
        for (poses, (_, details)) in poses(&world, trace).iter().zip(trace.lines()) {
            // A ray that grazes a body may be rounded either way.
            let (distance, grazing) = ray(poses, 0.0);
            if grazing > 0.01 {
                assert_eq!(read("sees", details) > 0.5, distance.is_finite(), "{poses:?}");
                seen += u32::from(distance.is_finite());
            }
            let (distance, grazing) = ray(poses, 0.25);
            let share = ((distance - f64::from(BODY)) / f64::from(range)).clamp(0.0, 1.0);
            if grazing > 0.01 {
                assert!((f64::from(read("near", details)) - share).abs() < 1e-3, "{poses:?}");
                near += u32::from(share < 1.0);
            }
        }
    }
    assert!(seen > 500 && near > 500, "{seen} and {near}");
}

/// Clusters and dispersion of the mission are those of the poses, in double precision.
#[test]
fn a_mission_sees_all_robots() {
    let world = World::new(aggregation(10, Contact::Push, 900.0, 300)).unwrap();
    let outcome = lived(&batch(&world, 40, 1));
    let memory = |name: &str, details: &[u32]| {
        let is_it = |own: &oneiro::compose::Detail| own.kind == DetailKind::Memory(Kind::Task) && own.name == name;
        details[world.details().iter().position(is_it).unwrap()]
    };
    let mut several = 0;
    for (trace, fitness) in outcome.traces.iter().zip(&outcome.fitness) {
        let poses = poses(&world, trace);
        let lines: Vec<_> = trace.lines().collect();
        let mut sum = 0.0;
        for second in (9..299).step_by(10) {
            // Poses after this cycle.
            let now = &poses[second + 1];
            let mean = [0, 1].map(|axis| now.iter().map(|pose| pose[axis]).sum::<f64>() / 10.0);
            let squares = now
                .iter()
                .map(|pose| (pose[0] - mean[0]).powi(2) + (pose[1] - mean[1]).powi(2));
            let dispersion = squares.sum::<f64>() / (4.0 * f64::from(BODY).powi(2));
            let found = f64::from(f32::from_bits(memory("dispersion", lines[second].1)));
            assert!((found / dispersion - 1.0).abs() < 1e-4, "{found}, not {dispersion}");
            sum += dispersion * (second + 1) as f64 / 10.0;
            let (clusters, largest) = clusters(now, 4.0 * f64::from(BODY));
            assert_eq!(memory("clusters", lines[second].1), clusters);
            assert_eq!(memory("largest", lines[second].1), largest);
            several += u32::from(clusters > 1 && largest > 2);
        }
        let last = f64::from(f32::from_bits(memory("dispersion", lines[299].1)));
        sum += 30.0 * last;
        assert!(
            (f64::from(*fitness) / -sum - 1.0).abs() < 1e-3,
            "{fitness}, not {}",
            -sum
        );
    }
    assert!(several > 100, "{several}");
}

/// The number of clusters of robots linked by less than `reach`, and the robots in the largest.
fn clusters(poses: &[[f64; 3]], reach: f64) -> (u32, u32) {
    let mut label: Vec<usize> = (0..poses.len()).collect();
    for _ in poses {
        for (own, a) in poses.iter().enumerate() {
            for (other, b) in poses.iter().enumerate() {
                if (a[0] - b[0]).hypot(a[1] - b[1]) < reach {
                    label[own] = label[own].min(label[other]);
                }
            }
        }
    }
    let sizes: Vec<u32> = (0..poses.len())
        .map(|own| label.iter().filter(|&&label| label == own).count() as u32)
        .collect();
    (
        sizes.iter().filter(|&&size| size > 0).count() as u32,
        *sizes.iter().max().unwrap(),
    )
}

/// A robot that pushes another moves it along; one that stops does not.
#[test]
fn robots_push_or_stop() {
    // All drive straight ahead as fast as they can.
    let ahead = "const CONTROLLER_GENES: u32 = 1u;
        fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
            let speed = select(0.5f, 1.0f, robot_number(episode) == 0u);
            return Command(vec2<f32>(speed, speed), before);
        }";
    let moved = |contact| {
        let own = OwnParts::from([own(Kind::Controller, ahead), own(Kind::Task, MISSION)]);
        let spec = aggregation(30, contact, 1400.0, 100);
        let world = World::new(WorldSpec { own, ..spec }).unwrap();
        let outcome = lived(&batch(&world, 64, 1));
        let way = |trace: &Trace| {
            let poses = poses(&world, trace);
            let (first, last) = (&poses[0], &poses[99]);
            let each = first.iter().zip(last).skip(1);
            each.map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1])).sum::<f64>()
        };
        outcome.traces.iter().map(way).sum::<f64>()
    };
    assert_eq!(moved(Contact::Stop), 0.0);
    let pushed = moved(Contact::Push);
    assert!(pushed > 1000.0, "{pushed} mm");
}

/// What can't be is refused with what can.
#[test]
fn refusals_say_what_is_allowed() {
    let refused = |spec: WorldSpec| World::new(spec).unwrap_err().to_string();
    let single = |change: fn(&mut Differential)| {
        let mut spec = aggregation(10, Contact::Push, 900.0, 100);
        let Build::Differential(own) = &mut spec.robot.build else {
            unreachable!()
        };
        change(own);
        refused(spec)
    };
    assert_eq!(
        single(|own| (own.count, own.contact) = (None, None)),
        "robot.sensors[0].kind: is sight; allowed: only with robot.count"
    );
    assert_eq!(
        single(|own| {
            own.count = None;
            own.contact = None;
            own.sensors.clear();
        }),
        "task.part: has a mission (`mission_cycle`); allowed: only in swarms, with robot.count"
    );
    assert_eq!(
        single(|own| own.count = Some(1025)),
        "robot.count: is 1025; allowed: 1 to 1024"
    );
    assert!(single(|own| own.count = Some(60)).starts_with("robot.count: is 60, but half of the arena has room"));
    assert!(single(|own| own.greatest_speed = Some(300.0)).starts_with(
        "robot.greatest_speed_mm_s: robots move up to \
                                                                        31."
    ));
    let twice = "struct TaskState { way: f32 } struct MissionState { way: u32 }
        fn mission_cycle(episode: Episode, step: u32, before: MissionState) -> Tally { return Tally(0.0f, before); }";
    let twice = Part::new(Kind::Task, "own.wgsl", twice).unwrap_err().to_string();
    assert!(
        twice.contains("in `MissionState`: `way` is also in `TaskState`"),
        "{twice}"
    );
    let ends =
        "fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward { return Reward(1.0f, before); }
        fn task_ends(episode: Episode, own: TaskState) -> bool { return true; }";
    let own = OwnParts::from([own(Kind::Controller, CONTROLLER), own(Kind::Task, ends)]);
    assert!(
        refused(WorldSpec {
            own,
            ..aggregation(10, Contact::Push, 900.0, 100)
        })
        .starts_with("task.part: has `task_ends`")
    );
}
