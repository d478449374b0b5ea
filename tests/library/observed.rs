//! Worlds whose robots are all traced: the same lives, and of each robot what the ordinary trace has of the first, where it is, whom
//! it hears and what it earns.

use oneiro::arena::Arena;
use oneiro::automode::Modules;
use oneiro::batch::{Batch, Outcome, Record, Rollout, Trace, TraceRequest, Worlds};
use oneiro::compose::{DetailKind, Kind};
use oneiro::cpu::Cpu;
use oneiro::differential::{Build, Contact, Differential, Sensor, SensorKind};
use oneiro::evaluator::{Control, Evaluator};
use oneiro::random::{Key, pcg4d};
use oneiro::reference::{Model, Reference};
use oneiro::world::{Controller, Robot, Task, World, WorldSpec};

use crate::composed::Subject;
use crate::epucks::{disc, epucks, lamp};

const CYCLES: u32 = 60;

/// `count` e-pucks with state machines, that hear each other around walls.
fn machines(count: u32) -> WorldSpec {
    let mut arena = Arena::polygon(
        &[[-900.0, -900.0], [900.0, -900.0], [900.0, 900.0], [-900.0, 900.0]],
        None,
    );
    arena.floor = Some(0.498);
    arena.wall_height = Some(80.0);
    arena.patches = vec![disc(-500.0, 0.0, 350.0, 0.0), disc(500.0, 0.0, 350.0, 1.0)];
    arena.lights = vec![lamp(0.0, -1000.0, 750.0, 5.0)];
    WorldSpec {
        robot: epucks(Model::Vectors, Reference::DEFAULT, count),
        arena,
        controller: Controller::StateMachine(Modules::DEFAULT),
        cycles: CYCLES,
        ..WorldSpec::miglino1995()
    }
}

/// Robots without messages, with a perceptron.
fn described() -> WorldSpec {
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
                count: Some(5),
                contact: Some(Contact::Stop),
                sensors: vec![eye("left", 0.1), eye("right", -0.1)],
                ..Differential::new(53.0, 120.0)
            }),
            ..Robot::khepera()
        },
        arena: Arena::rectangle(600.0, 600.0),
        task: Task::AVOIDANCE,
        cycles: CYCLES,
        ..WorldSpec::miglino1995()
    }
}

fn genome(world: &World, life: u32) -> Vec<f32> {
    let gene = |(index, range): (usize, Option<[f32; 2]>)| {
        let [least, greatest] = range.unwrap_or([-3.0, 3.0]);
        let share = (pcg4d([life, index as u32, 0, 77])[0] >> 8) as f32 / 16_777_216.0;
        least + share * (greatest - least)
    };
    world.gene_layout().ranges().into_iter().enumerate().map(gene).collect()
}

fn rollouts(genomes: &[Vec<f32>]) -> Vec<Rollout<'_>> {
    (0_u64..)
        .zip(genomes)
        .map(|(life, genes)| Rollout {
            world: 0,
            genes,
            key: Key::rollout(3, 0, life, 0),
        })
        .collect()
}

fn lived(world: &World, genomes: &[Vec<f32>]) -> Outcome {
    let request = Some(TraceRequest { every: 1 });
    let batch = Batch::new(std::slice::from_ref(world), &rollouts(genomes), request).unwrap();
    Cpu::new(Some(2)).unwrap().evaluate(&batch, &Control::new()).unwrap()
}

/// The words of the details of one kind.
fn words(world: &World, details: &[u32], wanted: DetailKind) -> Vec<u32> {
    let each = world.details().iter().zip(details);
    each.filter(|(own, _)| own.kind == wanted)
        .map(|(_, word)| *word)
        .collect()
}

fn without_fitness(record: &Record) -> Record {
    Record {
        fitness: 0.0,
        ..*record
    }
}

#[test]
fn observed_lives_are_the_same_lives() {
    for spec in [machines(20), machines(33), described()] {
        let world = World::new(spec).unwrap();
        let observed = world.observed().unwrap();
        let genomes: Vec<_> = (0..3).map(|life| genome(&world, life)).collect();
        let (plain, all) = (lived(&world, &genomes), lived(&observed, &genomes));
        assert_eq!(
            plain.fitness.iter().map(|own| own.to_bits()).collect::<Vec<_>>(),
            all.fitness.iter().map(|own| own.to_bits()).collect::<Vec<_>>()
        );
        for ((plain, all), fitness) in plain.traces.iter().zip(&all.traces).zip(&all.fitness) {
            let robots = all.by_robot(world.robots());
            assert!(robots.iter().all(|own| own.len() == CYCLES as usize));
            for (cycle, (record, details)) in plain.lines().enumerate() {
                assert_eq!(
                    without_fitness(record),
                    without_fitness(&robots[0][cycle]),
                    "cycle {cycle}"
                );
                for kind in [
                    DetailKind::Perceived,
                    DetailKind::Real,
                    DetailKind::Memory(Kind::Controller),
                ] {
                    let own = words(&observed, robots[0].details(cycle), kind);
                    assert_eq!(words(&world, details, kind), own, "{kind:?}, cycle {cycle}");
                }
                let others: Vec<u32> = robots[1..]
                    .iter()
                    .flat_map(|own| [own[cycle].x, own[cycle].y, own[cycle].heading].map(f32::to_bits))
                    .collect();
                assert_eq!(words(&world, details, DetailKind::Other), others, "cycle {cycle}");
            }
            let last = robots.iter().map(|own| own.last().unwrap().fitness.to_bits());
            assert!(last.into_iter().all(|bits| bits == fitness.to_bits()));
        }
    }
}

#[test]
fn robots_are_told_whom_they_hear() {
    let world = World::new(machines(40)).unwrap().observed().unwrap();
    let neighbours = world.details().iter().position(|own| own.name == "neighbours").unwrap();
    let outcome = lived(&world, &[genome(&world, 1)]);
    let (mut heard, mut most) = (0, 0);
    for (robot, trace) in outcome.traces[0].by_robot(40).iter().enumerate() {
        for (_, details) in trace.lines() {
            let senders = words(&world, details, DetailKind::Heard);
            assert_eq!(senders.len(), 2);
            assert_eq!(senders[robot / 32] >> (robot % 32) & 1, 0, "its own message");
            let count = senders[0].count_ones() + senders[1].count_ones();
            assert_eq!(count as f32, f32::from_bits(details[neighbours]));
            heard += count;
            most = most.max(senders[1]);
        }
    }
    assert!(heard > 1000 && most > 0, "{heard} messages");
}

#[test]
fn what_each_robot_earns_adds_up() {
    let world = World::new(described()).unwrap().observed().unwrap();
    let outcome = lived(&world, &[genome(&world, 2)]);
    let robots = outcome.traces[0].by_robot(5);
    let mut total = 0.0;
    for cycle in 0..CYCLES as usize {
        let own = |trace: &Trace| f32::from_bits(words(&world, trace.details(cycle), DetailKind::Earned)[0]);
        let sum = robots.iter().map(own).fold(0.0, |sum, own| sum + own);
        assert_eq!(sum.to_bits(), robots[0][cycle].reward.to_bits(), "cycle {cycle}");
        total += sum;
    }
    assert!(total > 0.0);
    assert_eq!(total.to_bits(), outcome.fitness[0].to_bits());
}

#[test]
fn lives_cut_into_stretches_are_traced_alike() {
    let world = World::new(machines(7)).unwrap().observed().unwrap();
    let genomes = [genome(&world, 4)];
    let whole = lived(&world, &genomes).traces.remove(0);
    let (mut cpu, mut pieces, mut states) = (Cpu::new(Some(1)).unwrap(), Trace::default(), Vec::new());
    let worlds = Worlds::new(std::slice::from_ref(&world)).unwrap();
    for cycles in [0..7, 7..8, 8..CYCLES] {
        let request = Some(TraceRequest { every: 1 });
        let batch = worlds.stretch(&rollouts(&genomes), cycles, &states, request).unwrap();
        let outcome = cpu.evaluate(&batch, &Control::new()).unwrap();
        pieces.append(&outcome.traces[0]);
        states = outcome.states;
    }
    assert_eq!(whole, pieces);
}

/// Episodes that are pinned ([`crate::composed`]).
pub(crate) fn subjects() -> Vec<Subject> {
    let subject = |(name, spec)| {
        let world = World::new(spec).unwrap().observed().unwrap();
        let genomes: Vec<_> = (0..3).map(|episode| genome(&world, episode)).collect();
        Subject::new(name, 3, 3, |episodes| {
            let rollouts = rollouts(&genomes[..episodes]);
            Batch::new(std::slice::from_ref(&world), &rollouts, Some(TraceRequest { every: 7 })).unwrap()
        })
    };
    [("machines", machines(7)), ("parametric", described())]
        .map(subject)
        .into()
}

#[test]
fn only_robots_that_live_together_are_observed() {
    let alone = World::new(WorldSpec::miglino1995()).unwrap().observed().unwrap_err();
    assert_eq!(
        alone.to_string(),
        "robot.count: is not set; allowed: only swarms are observed"
    );
}
