//! Swarms with a genome for each robot or team: genes reach their robots and no others; refusals; missions that end the episode of all
//! robots.

use std::sync::Arc;

use oneiro::arena::{Arena, Patch};
use oneiro::automode::{Form, Modules};
use oneiro::batch::{Batch, Outcome, Rollout, Trace, TraceRequest};
use oneiro::compose::{Kind, OwnPart, OwnParts, Part};
use oneiro::cpu::Cpu;
use oneiro::differential::{Build, Contact, Differential, Genomes, Sensor, SensorKind, Starts};
use oneiro::network::{Layer, LayerKind, Network};
use oneiro::world::{Controller, Robot, Task, World, WorldSpec};

use crate::composed::Subject;
use crate::modules::{self, batch, evaluated, genome, key};

const MACHINES: Controller = Controller::StateMachine(Modules::DEFAULT);
const TREES: Controller = Controller::BehaviourTree(Modules::DEFAULT);

/// Four genes: the speeds of both wheels, and how much a robot nearby changes them.
const OWN: &str = "
const CONTROLLER_GENES: u32 = 4u;
struct ControllerState {
    last: f32,
}
fn controller_begin(episode: Episode) -> ControllerState {
    return ControllerState(gene(episode, 3u));
}
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    let near = reading(readings, 0u) + before.last;
    let outputs = vec2<f32>(logistic(gene(episode, 0u) + near * gene(episode, 2u)), logistic(gene(episode, 1u) - near));
    return Command(outputs, ControllerState(0.5f * near));
}
";

const MISSION: &str = "
struct MissionState {
    dark: u32,
}
fn mission_cycle(episode: Episode, step: u32, before: MissionState) -> Tally {
    var dark = 0u;
    for (var robot = 0u; robot < robots(episode); robot++) {
        dark += select(0u, 1u, floor_at(episode, robot_pose(episode, robot).xy) < 0.1f);
    }
    return Tally(f32(dark) + 0.01f * f32(clusters_within(episode, 150.0f).largest), MissionState(dark));
}
";

/// Ends a life once two robots are on the dark floor. The score does not depend on the number of cycles left.
const ENDS: &str = "
fn mission_ends(episode: Episode, own: MissionState) -> bool {
    return own.dark >= 2u;
}
fn mission_score(episode: Episode, own: MissionState, sum: f32) -> f32 {
    return sum + 100.0f * f32(own.dark);
}
";

fn own(kind: Kind, text: &str) -> OwnPart {
    let part = Part::new(kind, "own.wgsl", text).unwrap_or_else(|refused| panic!("{refused}"));
    OwnPart::new(Arc::new(part), &[]).unwrap()
}

fn teams(teams: &[u32]) -> Genomes {
    Genomes::Teams(teams.to_vec())
}

/// Robots of a few sensors on a floor with a dark patch.
fn spec(count: u32, genomes: Genomes, controller: Controller) -> WorldSpec {
    let sensor = |name: &str, kind, heading, range| Sensor {
        name: name.into(),
        kind,
        heading,
        range: Some(range),
        ..Sensor::default()
    };
    let sensors = vec![
        sensor("front", SensorKind::Proximity, 0.0, 200.0),
        sensor("sees", SensorKind::Sight, 0.1, 800.0),
    ];
    let mut arena = Arena::rectangle(900.0, 700.0);
    arena.patches.push(Patch {
        x: 300.0,
        y: 300.0,
        radius: Some(200.0),
        ..Patch::default()
    });
    let mut parts = OwnParts::from([own(Kind::Task, MISSION)]);
    if controller == Controller::Own {
        parts.insert(Arc::new(own(Kind::Controller, OWN)));
    }
    WorldSpec {
        robot: Robot {
            body_radius: 37.0,
            build: Build::Differential(Differential {
                wheel_noise: Some(0.05),
                count: Some(count),
                genomes,
                sensors,
                ..Differential::new(51.0, 128.0)
            }),
            ..Robot::khepera()
        },
        arena,
        controller,
        task: Task::Own,
        own: parts,
        cycles: 60,
        ..WorldSpec::miglino1995()
    }
}

fn robot(spec: &mut WorldSpec) -> &mut Differential {
    match &mut spec.robot.build {
        Build::Differential(own) => own,
        _ => unreachable!("robots are described"),
    }
}

fn world(spec: WorldSpec) -> World {
    World::new(spec).unwrap_or_else(|invalid| panic!("{invalid}"))
}

/// A network with units of two kinds that remember.
fn recurrent_layers() -> Controller {
    let layer = |kind, units| Layer {
        kind,
        units,
        ..Layer::default()
    };
    Controller::Network(Network {
        layers: vec![layer(LayerKind::Elman, 3), layer(LayerKind::Ctrnn, 2)],
        ..Network::default()
    })
}

/// Worlds with all kinds of controllers.
fn specs() -> Vec<(&'static str, WorldSpec)> {
    let machines = |count, genomes, controller| {
        let mut spec = modules::spec(controller, count);
        robot(&mut spec).genomes = genomes;
        spec
    };
    let mut placed = spec(3, Genomes::Heterogeneous, Controller::Hidden { units: 3 });
    robot(&mut placed).starts = Some(Starts(vec![[150.0, 200.0], [350.0, 200.0], [700.0, 500.0]]));
    robot(&mut placed).contact = Some(Contact::Stop);
    vec![
        ("perceptrons", spec(7, Genomes::Heterogeneous, Controller::Perceptron)),
        (
            "recurrent, teams",
            spec(6, teams(&[0, 2, 0, 1, 2, 0]), Controller::Recurrent),
        ),
        ("hidden, placed", placed),
        ("layers", spec(4, Genomes::Heterogeneous, recurrent_layers())),
        ("own, teams", spec(5, teams(&[1, 1, 0, 0, 1]), Controller::Own)),
        ("machines", machines(3, Genomes::Heterogeneous, MACHINES)),
        ("trees, teams", machines(5, teams(&[0, 1, 1, 0, 1]), TREES)),
    ]
}

fn lived(batch: &Batch) -> Outcome {
    evaluated(&mut Cpu::new(Some(2)).unwrap(), batch)
}

fn bits(outcome: &Outcome) -> Vec<u32> {
    let fitness = outcome.fitness.iter().map(|fitness| fitness.to_bits());
    fitness.chain(outcome.traces.iter().flat_map(Trace::words)).collect()
}

/// Episodes that are pinned ([`crate::composed`]).
pub(crate) fn subjects() -> Vec<Subject> {
    let mut ending = spec(5, Genomes::Heterogeneous, Controller::Perceptron);
    ending
        .own
        .insert(Arc::new(own(Kind::Task, &format!("{MISSION}{ENDS}"))));
    let subject = |(name, spec)| {
        let world = world(spec);
        let genomes: Vec<_> = (0..70).map(|episode| genome(&world, episode)).collect();
        let subject = Subject::new(name, 70, 2, |episodes| batch(&world, &genomes[..episodes], 7));
        if name == "own, teams" {
            subject
        } else {
            subject.without_gpu()
        }
    };
    specs().into_iter().chain([("ends", ending)]).map(subject).collect()
}

/// A genome that has the same controller for each robot or team is that controller in a homogeneous world, bit for bit.
#[test]
fn the_same_genes_for_all_are_one_genome() {
    for (name, spec) in specs() {
        let mut shared = spec.clone();
        robot(&mut shared).genomes = Genomes::Homogeneous;
        let [several, shared] = [spec, shared].map(world);
        let genomes: Vec<_> = (0..20).map(|life| genome(&shared, life)).collect();
        let controllers = several.genes() / shared.genes();
        assert!(controllers > 1 && several.gene_layout().controller() == shared.gene_layout().all());
        let repeated: Vec<_> = genomes.iter().map(|own| own.repeat(controllers)).collect();
        let expected = bits(&lived(&batch(&shared, &genomes, 7)));
        assert!(bits(&lived(&batch(&several, &repeated, 7))) == expected, "{name}");
        // Other genes for the last of them are seen.
        let mut others = repeated;
        for (own, life) in others.iter_mut().zip(100..) {
            let last = several.genes() - shared.genes();
            own[last..].copy_from_slice(&genome(&shared, life));
        }
        assert!(bits(&lived(&batch(&several, &others, 7))) != expected, "{name}");
    }
}

/// In the first cycle, before robots have met, another gene changes what its own robots do and what no others do. Each robot's genes
/// are where the world says, and some of each have an effect.
#[test]
fn a_gene_is_of_its_own_robots() {
    for (name, spec) in specs() {
        let world = world(spec);
        let observed = world.observed().unwrap();
        let robots = world.robots();
        let base = genome(&world, 1);
        let all = batch(&world, std::slice::from_ref(&base), 1);
        // Neighbours of a value within its range.
        let ranges = world.gene_layout().ranges();
        let other = |gene: usize| {
            let mut own = base.clone();
            own[gene] = match ranges[gene] {
                None => own[gene] + 1.5,
                Some([least, greatest]) if own[gene] > f32::midpoint(least, greatest) => least,
                Some([_, greatest]) => 0.99 * greatest,
            };
            own
        };
        let genomes: Vec<_> = (0..world.genes()).map(other).collect();
        // The same starts and noise for all.
        let key = key(0);
        let all_genomes = std::iter::once(&base).chain(&genomes);
        let lives: Vec<_> = all_genomes.map(|genes| Rollout { world: 0, genes, key }).collect();
        let batch = Batch::new(&[&observed], &lives, Some(TraceRequest { every: 1 })).unwrap();
        let outcome = lived(&batch);
        let did = |life: usize| -> Vec<[u32; 2]> {
            let traces = outcome.traces[life].by_robot(robots);
            traces
                .iter()
                .map(|own| [own[0].left, own[0].right].map(f32::to_bits))
                .collect()
        };
        let (before, mut reached) = (did(0), vec![0; robots as usize]);
        for gene in 0..world.genes() {
            for (robot, (own, was)) in did(gene + 1).iter().zip(&before).enumerate() {
                if own != was {
                    assert!(
                        world.genes_of(robot as u32).contains(&gene),
                        "{name}: gene {gene}, robot {robot}"
                    );
                    reached[robot] += 1;
                }
            }
        }
        assert!(reached.iter().all(|genes| *genes > 0), "{name}: {reached:?}");
        // The observed world is the same as the other.
        assert_eq!(outcome.fitness[0].to_bits(), lived(&all).fitness[0].to_bits(), "{name}");
    }
}

#[test]
fn genes_have_the_names_of_their_robots_or_teams() {
    let names = |spec| world(spec).gene_layout().names();
    let all = names(spec(3, Genomes::Heterogeneous, Controller::Perceptron));
    assert_eq!(all.len(), 3 * 6);
    assert_eq!(all[0], "robot_0.front_to_left");
    assert_eq!(all[17], "robot_2.bias_right");
    let all = names(spec(4, teams(&[1, 0, 0, 1]), Controller::Own));
    assert_eq!(
        all,
        [0, 1]
            .map(|team| [0, 1, 2, 3].map(|gene| format!("team_{team}.gene_{gene}")))
            .concat()
    );
    assert_eq!(
        names(spec(3, Genomes::Homogeneous, Controller::Perceptron))[5],
        "bias_right"
    );
    // What a gene depends on is of the same machine, and each machine has its line in a text.
    let mut machines = modules::spec(MACHINES, 2);
    robot(&mut machines).genomes = Genomes::Heterogeneous;
    let machines = world(machines);
    let genes = machines.gene_layout().all();
    for (first, second) in genes[..97].iter().zip(&genes[97..]) {
        assert_eq!(second.only, first.only.map(|(gene, values)| (97 + gene, values)));
        assert_eq!((second.kind, second.range), (first.kind, first.range));
    }
    let form = Form::of(machines.gene_layout()).unwrap();
    let genome = genome(&machines, 2);
    let text = form.text(&genome);
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 2);
    assert_eq!(lines[1], form.text(&genome[machines.genes_of(1)]));
}

/// All robots stop in the cycle before which their mission ends; the life has the score of one that could not have been longer.
#[test]
fn a_mission_ends_the_life_of_all_robots() {
    let ends = format!("{MISSION}{ENDS}");
    let with = |cycles: u32, text: &str| {
        let mut spec = spec(5, Genomes::Homogeneous, Controller::Perceptron);
        spec.own.insert(Arc::new(own(Kind::Task, text)));
        world(WorldSpec { cycles, ..spec })
    };
    let endless = format!(
        "{MISSION}fn mission_score{}",
        ENDS.split_once("fn mission_score").unwrap().1
    );
    let long = with(60, &ends);
    let genomes: Vec<_> = (0..100).map(|life| genome(&long, life)).collect();
    let outcome = lived(&batch(&long, &genomes, 1));
    let lengths: Vec<usize> = outcome.traces.iter().map(|own| own.len()).collect();
    let early = lengths.iter().filter(|length| **length < 60).count();
    assert!((10..=90).contains(&early), "{early} of 100 lives end early");
    assert!(
        lengths.iter().any(|length| (1..10).contains(length)) && lengths.iter().any(|length| (30..60).contains(length))
    );
    for cycles in [1, 7, 30] {
        // Lives that are over by then, and others, are those of a shorter world without an end.
        let short = lived(&batch(&with(cycles, &endless), &genomes, 1));
        let own = lived(&batch(&with(cycles, &ends), &genomes, 1));
        for (life, length) in lengths.iter().enumerate() {
            let over = (*length).min(cycles as usize);
            assert_eq!(own.traces[life].len(), over);
            let equal = short.fitness[life].to_bits() == own.fitness[life].to_bits();
            assert!(
                equal || *length < cycles as usize,
                "life {life} of {length}, {cycles} cycles"
            );
            let words = |trace: &Trace| trace.thinned(0, 1).words().collect::<Vec<_>>();
            assert!(words(&short.traces[life]).starts_with(&words(&own.traces[life])));
            if *length == cycles as usize {
                assert_eq!(own.fitness[life].to_bits(), outcome.fitness[life].to_bits());
            }
        }
    }
    // An observed world ends in the same cycle, and a stretch after the end changes nothing.
    let observed = lived(&batch(&long.observed().unwrap(), &genomes, 1));
    for (life, trace) in observed.traces.iter().enumerate() {
        assert_eq!(trace.by_robot(5)[4].len(), lengths[life]);
    }
    assert_eq!(
        observed.fitness.iter().map(|own| own.to_bits()).collect::<Vec<_>>(),
        outcome.fitness.iter().map(|own| own.to_bits()).collect::<Vec<_>>()
    );
    let never = lived(&batch(
        &with(60, &ends.replace("own.dark >= 2u", "own.dark >= 99u")),
        &genomes,
        1,
    ));
    assert!(never.traces.iter().all(|own| own.len() == 60));
    let at_once = lived(&batch(&with(60, &ends.replace("own.dark >= 2u", "true")), &genomes, 1));
    assert!(at_once.traces.iter().all(|own| own.is_empty()) && at_once.fitness.iter().all(|own| *own == 0.0));
}

#[test]
fn refusals_say_what_is_allowed() {
    let refused = |spec: WorldSpec| World::new(spec).unwrap_err().to_string();
    let of = |count, genomes| refused(spec(count, genomes, Controller::Perceptron));
    assert_eq!(
        of(4, teams(&[0, 1])),
        "robot.genomes: has 2 teams; allowed: one for each robot, 4"
    );
    assert_eq!(
        of(3, teams(&[0, 2, 2])),
        "robot.genomes: has no robot in team 1; allowed: teams that are numbered from 0 on, each with a robot"
    );
    assert_eq!(
        of(2, teams(&[0, u32::MAX])),
        "robot.genomes: has no robot in team 1; allowed: teams that are numbered from 0 on, each with a robot"
    );
    let layer = Layer {
        units: 1024,
        ..Layer::default()
    };
    let network = Network {
        layers: vec![layer],
        ..Network::default()
    };
    let many = spec(15, Genomes::Heterogeneous, Controller::Network(network));
    assert_eq!(
        refused(many),
        "robot.genomes: makes 15 genomes of 5122 genes each, 76830; allowed: up to 65536 genes in all, with fewer teams or a smaller \
         controller"
    );
    let mut alone = spec(2, Genomes::Heterogeneous, Controller::Perceptron);
    let own = robot(&mut alone);
    (own.count, own.sensors) = (None, Vec::new());
    assert_eq!(
        refused(alone),
        "robot.genomes: is given; allowed: only with robot.count"
    );
}
