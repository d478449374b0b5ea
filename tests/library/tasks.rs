//! Tasks without code.

use std::sync::Arc;

use oneiro::arena::{Arena, Light, Patch};
use oneiro::batch::{Batch, Rollout, TraceRequest};
use oneiro::compose::{Kind, OwnPart, OwnParts, Part};
use oneiro::cpu::Cpu;
use oneiro::differential::{Build, Differential};
use oneiro::evaluator::{Control, Evaluator};
use oneiro::parameter::Choice;
use oneiro::random::Key;
use oneiro::tasks::READY;
use oneiro::world::{Collision, Pucks, Robot, Task, World, WorldSpec};

use crate::composed::Subject;

const EPISODES: usize = 48;
const CYCLES: u32 = 400;

/// A world with what every task needs.
fn spec(task: Task, count: Option<u32>) -> WorldSpec {
    let patch = |x, y, radius| Patch {
        x,
        y,
        radius: Some(radius),
        ..Patch::default()
    };
    let mut arena = Arena::rectangle(500.0, 400.0).with_obstacles([(250.0, 200.0)], 30.0);
    arena.patches = vec![
        patch(150.0, 100.0, 90.0),
        patch(250.0, 100.0, 90.0),
        patch(250.0, 320.0, 70.0),
    ];
    arena.lights = vec![
        Light {
            x: 50.0,
            y: 350.0,
            ..Light::default()
        },
        Light {
            x: 450.0,
            y: 350.0,
            ..Light::default()
        },
    ];
    let pucks = match task {
        Task::GatherPucks | Task::BringPucks => Pucks {
            count: Some(4),
            radius: Some(27.0),
            grip: Some(5.0),
            ..Pucks::default()
        },
        _ => Pucks::default(),
    };
    WorldSpec {
        task,
        arena,
        pucks,
        robot: Robot {
            build: Build::Differential(Differential {
                count,
                ..Differential::new(51.0, 200.0)
            }),
            collision: if count.is_none() {
                Collision::Slide
            } else {
                Collision::Undo
            },
            ..Robot::khepera()
        },
        cycles: CYCLES,
        ..WorldSpec::miglino1995()
    }
}

fn worlds() -> Vec<(String, WorldSpec)> {
    let mut worlds = Vec::new();
    for ready in READY {
        for count in [None, Some(3)] {
            if count.is_some() || !ready.is_for_swarms() {
                let name = if count.is_some() { "a swarm's " } else { "" };
                worlds.push((format!("{name}{}", ready.word), spec(ready.task, count)));
            }
        }
    }
    worlds
}

/// Episodes of robots that drive far in all ways.
pub(crate) fn batch(world: &World, count: usize) -> Batch {
    let gene = |gene: usize| ((gene * 5 + 3) % 13) as f32 / 3.0 - 2.0;
    let genomes: Vec<Vec<f32>> = (0..count)
        .map(|individual| (0..world.genes()).map(|index| gene(index + 3 * individual)).collect())
        .collect();
    let rollout = |(individual, genes)| Rollout {
        world: 0,
        genes,
        key: Key::rollout(2, 0, individual, 0),
    };
    let rollouts: Vec<_> = (0..).zip(genomes.iter().map(Vec::as_slice)).map(rollout).collect();
    Batch::new(std::slice::from_ref(world), &rollouts, Some(TraceRequest { every: 1 })).unwrap()
}

pub(crate) fn subjects() -> Vec<Subject> {
    let subject = |(name, spec): (String, WorldSpec)| {
        let world = World::new(spec).unwrap_or_else(|invalid| panic!("{name}: {invalid}"));
        let is_alone = world.robots() == 1;
        let subject = Subject::new(name, EPISODES, 2, |count| batch(&world, count)).without_specialising();
        if is_alone { subject } else { subject.without_gpu() }
    };
    worlds().into_iter().map(subject).collect()
}

fn fitness(spec: WorldSpec) -> Vec<f32> {
    let world = World::new(spec).unwrap_or_else(|invalid| panic!("{invalid}"));
    let mut cpu = Cpu::new(Some(1)).unwrap();
    cpu.evaluate(&batch(&world, EPISODES), &Control::new()).unwrap().fitness
}

#[test]
fn every_word_has_a_task_and_the_same_bits_as_a_copy() {
    let words: Vec<&str> = Task::CHOICES.iter().map(|(word, ..)| *word).collect();
    for ready in READY {
        assert!(words.contains(&ready.word) && ready.task.word() == ready.word);
    }
    for (name, own) in worlds() {
        let ready = own.task.ready().unwrap();
        let part = Arc::new(Part::new(Kind::Task, "copy.wgsl", ready.text).unwrap());
        let copy = WorldSpec {
            task: Task::Own,
            own: OwnParts::from([OwnPart::new(Arc::clone(&part), &[]).unwrap()]),
            ..own.clone()
        };
        let earned = fitness(own.clone());
        assert_eq!(earned, fitness(copy), "{name}");
        // Robots differ, and each value has an effect.
        assert!(earned.iter().any(|own| *own != earned[0]), "{name}: {earned:?}");
        for value in part.values() {
            let changed = match &*value.name {
                "nest" | "goal" => 1.0,
                "dark" => 0.0,
                _ => 0.5 * f64::from(value.default) + 0.2,
            };
            let set = OwnPart::new(Arc::clone(&part), &[(&value.name, changed)]).unwrap();
            let changed_fitness = fitness(WorldSpec {
                own: OwnParts::from([set]),
                ..own.clone()
            });
            assert_ne!(earned, changed_fitness, "{name}: {} = {changed}", value.name);
        }
    }
}

#[test]
fn arenas_without_what_a_task_needs_are_refused() {
    for (name, own) in worlds() {
        let bare = WorldSpec {
            arena: Arena {
                walls: Vec::new(),
                ..Arena::rectangle(500.0, 400.0)
            },
            ..own.clone()
        };
        let needs = ![Task::Cover, Task::StayTogether, Task::GatherPucks].contains(&own.task);
        let refused = World::new(bare).err().map(|invalid| invalid.field);
        assert_eq!(refused.is_some_and(|field| field == "task.kind"), needs, "{name}");
    }
    let alone = World::new(spec(Task::StayTogether, None)).unwrap_err();
    assert!(alone.problem.contains("robot.count"), "{alone}");
}

/// What each task counts, told from the traces.
#[test]
fn fitness_is_what_the_task_says() {
    let traced = |task: Task| {
        let world = World::new(spec(task, None)).unwrap();
        let mut cpu = Cpu::new(Some(1)).unwrap();
        let outcome = cpu.evaluate(&batch(&world, EPISODES), &Control::new()).unwrap();
        outcome.fitness.into_iter().zip(outcome.traces).collect::<Vec<_>>()
    };
    let ends = |trace: &oneiro::batch::Trace| -> Vec<[f64; 2]> {
        // The start of a cycle is the end of the one before; the last one's end isn't in a trace.
        (1..trace.len())
            .map(|cycle| [f64::from(trace[cycle].x), f64::from(trace[cycle].y)])
            .collect()
    };
    let away = |at: &[f64; 2], to: [f64; 2]| (at[0] - to[0]).hypot(at[1] - to[1]);
    let mut arrived = 0;
    for (fitness, trace) in traced(Task::Reach) {
        let goal = [150.0, 100.0];
        let way = away(&[trace[0].x.into(), trace[0].y.into()], goal);
        let all = ends(&trace);
        let expected = match all.iter().position(|at| away(at, goal) < 90.0) {
            Some(cycle) => {
                arrived += 1;
                2.0 - (cycle + 1) as f64 / f64::from(CYCLES)
            }
            None => 1.0 - all.iter().map(|at| away(at, goal)).fold(way, f64::min) / way,
        };
        // The cycle whose end isn't known may have brought it nearer.
        assert!((f64::from(fitness) - expected).abs() < 0.08, "{fitness} {expected}");
    }
    assert!(arrived > 2 && arrived < EPISODES, "{arrived}");
    let mut brought = 0;
    for (fitness, trace) in traced(Task::Collect) {
        let (mut carries, mut expected) = (false, 0.0);
        for at in ends(&trace) {
            let is_home = away(&at, [150.0, 100.0]) < 90.0;
            let is_at_food = away(&at, [250.0, 100.0]) < 90.0 || away(&at, [250.0, 320.0]) < 70.0;
            if carries && is_home {
                (carries, expected) = (false, expected + 1.0);
                brought += 1;
            } else if !carries && is_at_food {
                (carries, expected) = (true, expected + 0.5);
            }
        }
        assert!((f64::from(fitness) - expected).abs() <= 1.0, "{fitness} {expected}");
    }
    assert!(brought > 0);
    for (fitness, trace) in traced(Task::Cover) {
        let cells: std::collections::BTreeSet<[u32; 2]> = ends(&trace)
            .iter()
            .map(|[x, y]| [(x * 16.0 / 500.0) as u32, (y * 16.0 / 400.0) as u32])
            .collect();
        let expected = cells.len() as f64 / 256.0;
        assert!(
            (f64::from(fitness) - expected).abs() <= 1.01 / 256.0,
            "{fitness} {expected}"
        );
    }
    for (fitness, trace) in traced(Task::Phototaxis) {
        let near = |at: &[f64; 2]| away(at, [50.0, 350.0]).min(away(at, [450.0, 350.0])) / 1000.0;
        let expected: f64 = ends(&trace).iter().map(|at| (1.0 - near(at)) / f64::from(CYCLES)).sum();
        assert!(
            (f64::from(fitness) - expected).abs() < 1.1 / f64::from(CYCLES),
            "{fitness} {expected}"
        );
    }
}
