//! Lives that are commanded cycle by cycle: with the commands of a controller they have the bits of its life as a whole, in which
//! cycles others are meanwhile and however they are grouped. So do those of swarms, with commands for each robot.

use std::sync::Arc;

use crate::described;
use oneiro::arena::Arena;
use oneiro::batch::{Batch, Rollout, Trace, TraceRequest};
use oneiro::compose::{DetailKind, Kind, OwnPart, OwnParts, Part};
use oneiro::cpu::Cpu;
use oneiro::differential::{Build, Differential, Sensor, SensorKind};
use oneiro::evaluator::{Control, Evaluator};
use oneiro::foraging::Forager;
use oneiro::random::Key;
use oneiro::stepped::{Error, GREATEST_CYCLES, Stepped};
use oneiro::surrogate::{Differences, Surrogate};
use oneiro::world::{Controller, Noise, Poses, Robot, Start, Task, World, WorldSpec};

/// Sensors and a task that remember, draw random numbers and end some lives early.
const OWN: [(Kind, &str); 2] = [
    (
        Kind::Sensor,
        "struct SensorReadings { x: f32, before: f32 }
struct SensorState { last: f32 }
fn sensor_cycle(episode: Episode, step: u32, pose: vec3<f32>, before: SensorState) -> Sensed {
    let chance = random(episode, STREAM_OWN_SENSOR, step, 0u).x;
    return Sensed(SensorReadings(pose.x * 0.001f + chance, before.last), SensorState(pose.y * 0.001f));
}",
    ),
    (
        Kind::Task,
        "struct TaskState { path: f32 }
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    let apart = vec2<f32>(now.end.x - now.start.x, now.end.y - now.start.y);
    let way = abs(apart.x) + abs(apart.y);
    return Reward(way * (1.0f - highest(now.real)) + now.outputs.x, TaskState(before.path + way));
}
fn task_ends(episode: Episode, own: TaskState) -> bool { return own.path > 250.0f; }
fn task_score(episode: Episode, own: TaskState, sum: f32) -> f32 { return sum + own.path; }",
    ),
];

fn parts(texts: [(Kind, &str); 2]) -> OwnParts {
    OwnParts::from(texts.map(|(kind, text)| {
        let part = Part::new(kind, &format!("{}.wgsl", kind.word()), text).unwrap();
        OwnPart::new(Arc::new(part), &[]).unwrap()
    }))
}

/// Worlds of every kind of robot, with all that lives remember between cycles.
fn specs() -> Vec<(&'static str, WorldSpec)> {
    let noisy = Noise {
        sensor: (0.0, 0.4),
        walk_range: 30.0,
        walk_step: 1.5,
        motor: 0.1,
        ..Noise::NONE
    };
    let khepera = WorldSpec {
        noise: noisy,
        controller: Controller::Recurrent,
        task: Task::AVOIDANCE.with_new_cell(2.0),
        cycles: 60,
        ..WorldSpec::miglino1995()
    };
    let own = WorldSpec {
        own: parts(OWN),
        task: Task::Own,
        ..khepera.clone()
    };
    let surrogate = WorldSpec {
        surrogate: Some(Arc::new(Surrogate::drawn(3, Differences::all(1.0)))),
        noise: Noise::NONE,
        task: Task::AVOIDANCE,
        ..khepera.clone()
    };
    let forager = WorldSpec {
        controller: Controller::Perceptron,
        cycles: 60,
        ..WorldSpec::foraging(Forager::ODOWD2014)
    };
    let described = described::spec(|spec, _| {
        spec.noise.motor = 0.1;
        spec.cycles = 60;
    });
    let poses = WorldSpec {
        start: Start::Poses(Poses(vec![
            [100.0, 100.0, 0.0],
            [150.0, 100.0, 0.25],
            [100.0, 150.0, 0.5],
        ])),
        noise: Noise::NONE,
        ..khepera.clone()
    };
    vec![
        ("khepera", khepera),
        ("own parts", own),
        ("surrogate", surrogate),
        ("forager", forager),
        ("described", described),
        ("poses", poses),
        ("swarm", swarm(None)),
        ("swarm with a mission", swarm(Some(MISSION))),
    ]
}

/// Sensors and a mission of a swarm: readings of where others look, memory, rewards of each robot and of all, and an early end.
const MISSION: [(Kind, &str); 2] = [
    (
        Kind::Sensor,
        "struct SensorReadings { other: f32, before: f32 }
struct SensorState { last: f32 }
fn sensor_cycle(episode: Episode, step: u32, pose: vec3<f32>, before: SensorState) -> Sensed {
    let chance = random(episode, STREAM_OWN_SENSOR, step, 0u).x;
    let other = robot_pose(episode, (robot_number(episode) + 1u) % robots(episode));
    return Sensed(SensorReadings(other.z + chance, before.last), SensorState(pose.y * 0.001f));
}",
    ),
    (
        Kind::Task,
        "struct TaskState { path: f32 }
struct MissionState { far: u32 }
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    let apart = vec2<f32>(now.end.x - now.start.x, now.end.y - now.start.y);
    let way = abs(apart.x) + abs(apart.y);
    return Reward(way * (1.0f - now.real.left), TaskState(before.path + way));
}
fn mission_cycle(episode: Episode, step: u32, before: MissionState) -> Tally {
    let first = robot_pose(episode, 0u);
    let last = robot_pose(episode, 2u);
    let is_far = abs(first.x - last.x) + abs(first.y - last.y) > 450.0f;
    return Tally(0.001f * first.x, MissionState(before.far + select(0u, 1u, is_far)));
}
fn mission_ends(episode: Episode, own: MissionState) -> bool { return own.far > 15u; }",
    ),
];

/// Three robots that push each other, with noise.
fn swarm(custom: Option<[(Kind, &str); 2]>) -> WorldSpec {
    let eye = |name: &str, heading| Sensor {
        name: name.into(),
        kind: SensorKind::Proximity,
        heading,
        range: Some(60.0),
        ..Sensor::default()
    };
    WorldSpec {
        robot: Robot {
            body_radius: 35.0,
            build: Build::Differential(Differential {
                count: Some(3),
                sensors: vec![eye("left", 0.1), eye("right", -0.1)],
                ..Differential::new(53.0, 120.0)
            }),
            ..Robot::khepera()
        },
        arena: Arena::rectangle(500.0, 500.0),
        noise: Noise {
            sensor: (0.0, 0.2),
            ..Noise::NONE
        },
        task: if custom.is_some() { Task::Own } else { Task::AVOIDANCE },
        own: custom.map_or_else(OwnParts::default, parts),
        cycles: 60,
        ..WorldSpec::miglino1995()
    }
}

/// Genes of either sign, from the number of a life.
fn genes(life: usize, count: usize) -> Vec<f32> {
    let gene = |gene: usize| ((life * 31 + gene * 17) % 41) as f32 * 0.25 - 5.0;
    (0..count).map(gene).collect()
}

fn key(life: usize) -> Key {
    Key::rollout(7, 0, life as u64, life as u64 % 4)
}

/// Whole lives: traces of each robot, and fitness.
fn whole(spec: &WorldSpec, lives: usize) -> (World, Vec<Vec<Trace>>, Vec<f32>) {
    let mut world = World::new(spec.clone()).unwrap();
    let robots = world.robots();
    if robots > 1 {
        world = world.observed().unwrap();
    }
    let genomes: Vec<Vec<f32>> = (0..lives).map(|life| genes(life, world.genes())).collect();
    let rollout = |(life, genes)| Rollout {
        world: 0,
        genes,
        key: key(life),
    };
    let rollouts: Vec<_> = genomes.iter().map(Vec::as_slice).enumerate().map(rollout).collect();
    let batch = Batch::new(&[&world], &rollouts, Some(TraceRequest { every: 1 })).unwrap();
    let outcome = Cpu::new(Some(2)).unwrap().evaluate(&batch, &Control::new()).unwrap();
    let traces = outcome.traces.iter().map(|trace| trace.by_robot(robots)).collect();
    (world, traces, outcome.fitness)
}

/// Details of a kind in a record.
fn details(world: &World, trace: &Trace, record: usize, kind: DetailKind) -> Vec<u32> {
    let details = world.details().iter().zip(trace.details(record));
    let found = details.filter(|(detail, _)| detail.kind == kind);
    found.map(|(_, word)| *word).collect()
}

/// A robot's earnings in a record: its own, and those of all robots together.
fn earned(world: &World, of_life: &[Trace], robot: usize, record: usize) -> f32 {
    let together = of_life[0][record].reward;
    let alone = |robot: usize| {
        let words = details(world, &of_life[robot], record, DetailKind::Earned);
        words.first().map_or(0.0, |&word| f32::from_bits(word))
    };
    if of_life.len() == 1 {
        return together;
    }
    let all: f32 = (0..of_life.len()).map(alone).sum();
    alone(robot) + (together - all)
}

/// Steps lives with the commands of whole ones, of which each begins `apart` cycles after the one before, and compares each cycle.
/// Returns the number of cycles compared, and how many lives ended early.
fn compared(spec: &WorldSpec, lives: usize, apart: usize) -> (usize, usize) {
    let (world, traces, fitness) = whole(spec, lives);
    let (mut cpu, control) = (Cpu::new(Some(2)).unwrap(), Control::new());
    let mut stepped = Stepped::new(spec, lives).unwrap();
    let (width, robots) = (stepped.names().len(), stepped.robots());
    let (mut cycles, mut ended) = (0, 0);
    let mut next = vec![0; lives];
    let bits = |numbers: &[f32]| numbers.iter().map(|number| number.to_bits()).collect::<Vec<_>>();
    let mut turn = 0;
    let (mut who, mut commands) = (Vec::new(), Vec::new());
    loop {
        let begun = (0..lives).filter(|life| life * apart == turn);
        let begun: Vec<_> = begun.map(|life| (life, key(life))).collect();
        let before = stepped.fitness().to_vec();
        stepped
            .step_and_begin(&mut cpu, &control, &who, &commands, &begun)
            .unwrap();
        for &life in &who {
            for robot in 0..robots {
                let record = &traces[life][robot][next[life]];
                let reward = stepped.rewards()[life * robots + robot];
                let earned = f64::from(earned(&world, &traces[life], robot, next[life]));
                // A score rewards its change: here the way of the cycle more than what the task gives.
                let is_scored = robots == 1 && spec.own.get(Kind::Task).is_some();
                let change = f64::from(stepped.fitness()[life]) - f64::from(before[life]);
                assert!(!is_scored || change > earned - 1e-3, "{change}, {earned}: {record:?}");
                let expected = if is_scored { change } else { earned };
                // Sums of several robots' rewards are rounded in another order.
                let most = if robots == 1 {
                    0.0
                } else {
                    1e-5 * expected.abs().max(1.0)
                };
                assert!((reward - expected).abs() <= most, "{reward}, {expected}: {record:?}");
            }
            next[life] += 1;
            cycles += 1;
            assert_eq!(stepped.cycles()[life] as usize, next[life]);
            let is_last = next[life] == traces[life][0].len();
            assert_eq!(
                stepped.alive()[life],
                !is_last,
                "life {life} after {} cycles",
                next[life]
            );
            let whole = traces[life].iter().map(|trace| trace.get(next[life]));
            for (robot, record) in whole.enumerate() {
                let pose = stepped.poses()[life * robots + robot];
                let expected = record.map_or(pose, |record| [record.x, record.y, record.heading]);
                assert_eq!(bits(&pose), bits(&expected), "pose of life {life}");
            }
            if is_last {
                assert_eq!(
                    stepped.fitness()[life].to_bits(),
                    fitness[life].to_bits(),
                    "fitness of life {life}"
                );
                assert_eq!(stepped.ended()[life], next[life] < spec.cycles as usize);
                ended += usize::from(stepped.ended()[life]);
            }
        }
        who = (0..lives).filter(|&life| stepped.alive()[life]).collect();
        commands.clear();
        for &life in &who {
            for (robot, trace) in traces[life].iter().enumerate() {
                let record = &trace[next[life]];
                let own = &stepped.readings()[(life * robots + robot) * width..][..width];
                assert_eq!(
                    bits(own),
                    details(&world, trace, next[life], DetailKind::Perceived),
                    "readings of life {life}"
                );
                commands.extend([record.left, record.right]);
            }
        }
        turn += 1;
        if turn > lives * apart && who.is_empty() {
            break;
        }
    }
    assert!(next.iter().zip(&traces).all(|(next, traces)| *next == traces[0].len()));
    (cycles, ended)
}

#[test]
fn stepped_lives_are_whole_lives() {
    for (name, spec) in specs() {
        let mut early = 0;
        for (lives, apart) in [(1, 0), (70, 0), (67, 1)] {
            let (cycles, ended) = compared(&spec, lives, apart);
            assert!(cycles > 10 * lives, "{name}: {cycles} cycles");
            early += ended;
        }
        let may_end = ["own parts", "swarm with a mission"].contains(&name);
        assert_eq!(early > 0, may_end, "{name}: {early} lives ended early");
    }
}

/// A command that differs by one unit in the last place shows.
#[test]
fn another_command_is_another_life() {
    // Sampled motors have few speeds; those of a described robot are any.
    let spec = described::spec(|spec, _| spec.cycles = 60);
    let (mut cpu, control) = (Cpu::new(Some(1)).unwrap(), Control::new());
    let mut stepped = Stepped::new(&spec, 2).unwrap();
    stepped.begin(&mut cpu, &control, &[(0, key(5)), (1, key(5))]).unwrap();
    let next = f32::from_bits(0.75_f32.to_bits() + 1);
    let mut differs = false;
    for _ in 0..20 {
        stepped
            .step(&mut cpu, &control, &[0, 1], &[0.75, 0.5, next, 0.5])
            .unwrap();
        let (one, other) = stepped.readings().split_at(stepped.names().len());
        differs |= stepped.rewards()[0].to_bits() != stepped.rewards()[1].to_bits() || one != other;
    }
    assert!(differs);
}

#[test]
fn what_is_not_allowed_is_refused() {
    let (_, spec) = specs().remove(0);
    let (mut cpu, control) = (Cpu::new(Some(1)).unwrap(), Control::new());
    let message = |result: Result<(), Error>| result.unwrap_err().to_string();
    let long = WorldSpec {
        cycles: GREATEST_CYCLES + 1,
        ..spec.clone()
    };
    let error = Stepped::new(&long, 1).unwrap_err().to_string();
    assert_eq!(
        error,
        "cycles: is 1000000; allowed: 1 to 999999 if episodes are stepped"
    );
    let error = Stepped::new(&spec, 0).unwrap_err().to_string();
    assert_eq!(error, "episodes: are 0; allowed: 1 to 1048576");
    let mut stepped = Stepped::new(&spec, 2).unwrap();
    let error = message(stepped.step(&mut cpu, &control, &[0], &[0.5, 0.5]));
    assert_eq!(
        error,
        "episodes: names episode 0, which has ended or not begun; allowed: running episodes"
    );
    stepped.begin(&mut cpu, &control, &[(0, key(0)), (1, key(1))]).unwrap();
    let mut refused = |who: &[usize], commands: &[f32]| message(stepped.step(&mut cpu, &control, who, commands));
    assert_eq!(refused(&[2], &[0.5, 0.5]), "episodes: is 2; allowed: 0 to 1");
    assert_eq!(
        refused(&[1, 1], &[0.5; 4]),
        "episodes: names episode 1 twice; allowed: each once"
    );
    assert_eq!(refused(&[1], &[0.5]), "commands: are 1; allowed: 2 for each episode");
    let error = refused(&[0, 1], &[0.5, 0.5, 0.5, f32::NAN]);
    assert_eq!(error, "commands[1][1]: is NaN; allowed: 0 to 1");
    // What was refused has changed nothing.
    assert_eq!(stepped.cycles(), [0, 0]);
}
