//! Robots by the reference models, in worlds that reach every branch of what they sense, of bodies that meet and of the missions that
//! ship: for [`crate::composed`].

use std::sync::Arc;

use oneiro::arena::{Arena, Block, Obstacle, Wall};
use oneiro::batch::{Batch, Rollout, TraceRequest};
use oneiro::compose::{Kind, OwnPart, OwnParts, Part};
use oneiro::differential::{Build, Contact, Differential};
use oneiro::network::Network;
use oneiro::random::{Key, pcg4d};
use oneiro::reference::{Model, Reference};
use oneiro::world::{Controller, Task, World, WorldSpec};

use crate::composed::Subject;
use crate::epucks::{QUIET, disc, dodecagon, epucks, lamp};

const MISSIONS: [(&str, &str); 7] = [
    (
        "aggregation",
        include_str!("../../experiments/evostick/aggregation.wgsl"),
    ),
    ("foraging", include_str!("../../experiments/evostick/foraging.wgsl")),
    ("cues", include_str!("../../experiments/evostick/cues.wgsl")),
    ("shelter", include_str!("../../experiments/evostick/shelter.wgsl")),
    ("network", include_str!("../../experiments/evostick/network.wgsl")),
    ("coverage", include_str!("../../experiments/evostick/coverage.wgsl")),
    (
        "exploration",
        include_str!("../../experiments/evostick/exploration.wgsl"),
    ),
];

/// A user's task and mission in one part, each with a memory.
const OWN: &str = "
struct TaskState {
    met: u32,
    way: f32,
}
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    let way = before.way + abs(now.moved.displacement) + now.perceived.prox_0 + now.real.light_3;
    return Reward(floor_at(episode, now.end.xy) - 0.001f * way, TaskState(before.met + u32(now.collided), way));
}
struct MissionState {
    middle: vec2<f32>,
}
fn mission_cycle(episode: Episode, step: u32, before: MissionState) -> Tally {
    let own = clusters_within(episode, 150.0f);
    return Tally(f32(own.largest) + 0.1f * f32(own.count), MissionState(0.5f * (before.middle + robot_pose(episode, 3u).xy)));
}
fn mission_score(episode: Episode, own: MissionState, sum: f32) -> f32 {
    return sum + 0.001f * own.middle.x;
}
";

/// A dodecagon with the floor and the walls of the missions.
fn arena_within(apothem: f32) -> Arena {
    let mut arena = dodecagon(apothem.into(), apothem - 36.0);
    arena.floor = Some(0.498);
    arena.wall_height = Some(80.0);
    arena
}

fn wall(from: [f32; 2], to: [f32; 2]) -> Wall {
    Wall {
        from,
        to,
        ..Wall::default()
    }
}

/// The arena of a mission with ambient cues: a black disc, a white one and a lamp.
fn cues() -> Arena {
    let mut arena = arena_within(1226.0);
    arena.patches = vec![disc(0.0, 600.0, 300.0, 0.0), disc(0.0, -600.0, 300.0, 1.0)];
    arena.lights = vec![lamp(0.0, 1250.0, 750.0, 2.0)];
    arena
}

/// A small arena with objects of all kinds and lamps that they hide, one of them low and beyond the sides.
fn cluttered() -> Arena {
    let mut arena = arena_within(700.0);
    arena.walls.insert(0, wall([-300.0, 400.0], [300.0, 250.0]));
    arena.blocks.push(Block {
        x: -300.0,
        y: -200.0,
        length: 200.0,
        width: 80.0,
        heading: 0.1,
        ..Block::default()
    });
    arena.obstacles.push(Obstacle {
        x: 300.0,
        y: -100.0,
        radius: 60.0,
        ..Obstacle::default()
    });
    arena.lights = vec![lamp(0.0, -650.0, 300.0, 5.0), lamp(900.0, 300.0, 100.0, 1.0)];
    arena.patches = vec![disc(200.0, 200.0, 300.0, 0.0), disc(-200.0, 200.0, 300.0, 1.0)];
    arena
}

/// A shelter open to one side, before a lamp.
fn shelter() -> Arena {
    let mut arena = arena_within(700.0);
    let corners = [[-250.0, 150.0], [-250.0, -150.0], [250.0, -150.0], [250.0, 150.0]];
    for side in corners.windows(2).rev() {
        arena.walls.insert(0, wall(side[0], side[1]));
    }
    arena.patches = vec![disc(0.0, 0.0, 300.0, 1.0)];
    arena.lights = vec![lamp(0.0, 1250.0, 750.0, 2.0)];
    arena
}

/// A triangle, in whose corners robots press each other.
fn wedge() -> Arena {
    let mut arena = Arena::polygon(&[[-1700.0, -700.0], [1700.0, -700.0], [0.0, 1300.0]], None);
    arena.floor = Some(0.498);
    arena.patches = vec![disc(-550.0, -200.0, 300.0, 0.0), disc(550.0, -200.0, 300.0, 0.0)];
    arena
}

/// A field without walls.
fn open() -> Arena {
    Arena {
        walls: Vec::new(),
        floor: Some(0.498),
        ..Arena::rectangle(1000.0, 1000.0)
    }
}

const LOUD: Reference = Reference {
    proximity_noise: Some(0.3),
    light_noise: Some(0.9),
    ground_noise: Some(0.5),
    grey_left: Some([0.2, 0.5]),
    signal_range: Some(250.0),
    signal_loss: Some(0.4),
    signal_cycles: Some(3),
    attraction: Some(5.0),
    body_height: Some(40.0),
    ..Reference::DEFAULT
};

/// `EvoStick`'s network.
fn evostick() -> Controller {
    Controller::Network(Network {
        slope: Some(4.924_273),
        interleaved: Some(true),
        ..Network::default()
    })
}

fn spec(model: Model, count: u32, arena: Arena, mission: &str) -> WorldSpec {
    let text = MISSIONS
        .iter()
        .find(|(name, _)| *name == mission)
        .map_or(OWN, |own| own.1);
    let part = Part::new(Kind::Task, "own.wgsl", text).unwrap_or_else(|refused| panic!("{refused}"));
    WorldSpec {
        robot: epucks(model, Reference::DEFAULT, count),
        arena,
        controller: evostick(),
        task: Task::Own,
        own: OwnParts::from([OwnPart::new(Arc::new(part), &[]).unwrap()]),
        cycles: 60,
        ..WorldSpec::miglino1995()
    }
}

/// The world, with its robot changed.
fn with(mut spec: WorldSpec, change: impl Fn(&mut Differential)) -> WorldSpec {
    match &mut spec.robot.build {
        Build::Differential(own) => change(own),
        _ => unreachable!(),
    }
    spec
}

fn worlds() -> Vec<(&'static str, World)> {
    use Model::{Rm11, Rm12};
    let long = |spec: WorldSpec| WorldSpec { cycles: 400, ..spec };
    let quiet = |own: &mut Differential| {
        (own.reference, own.wheel_noise, own.wheel_noise_law) = (QUIET, None, None);
    };
    let loud = |own: &mut Differential| {
        (own.reference, own.wheel_noise, own.wheel_noise_law) = (LOUD, Some(0.2), None);
    };
    let stop = |own: &mut Differential| own.contact = Some(Contact::Stop);
    let specs = [
        ("cues", spec(Rm11, 20, cues(), "cues")),
        ("foraging", long(spec(Rm12, 20, cues(), "foraging"))),
        ("shelter", spec(Rm11, 20, shelter(), "shelter")),
        ("coverage, stop", with(spec(Rm12, 20, cues(), "coverage"), stop)),
        ("exploration", spec(Rm12, 7, arena_within(1226.0), "exploration")),
        ("network, open", spec(Rm11, 12, open(), "network")),
        ("aggregation, wedge", long(spec(Rm11, 40, wedge(), "aggregation"))),
        (
            "aggregation, wedge, stop",
            with(spec(Rm12, 40, wedge(), "aggregation"), stop),
        ),
        ("own, quiet", with(spec(Rm11, 15, cluttered(), "own"), quiet)),
        ("own, loud", with(spec(Rm11, 15, cluttered(), "own"), loud)),
        ("cluttered, quiet", with(spec(Rm12, 20, cluttered(), "cues"), quiet)),
        ("cluttered, loud", with(spec(Rm12, 20, cluttered(), "cues"), loud)),
        ("cluttered, one", spec(Rm11, 1, cluttered(), "cues")),
        ("many", with(spec(Rm12, 100, cues(), "cues"), loud)),
    ];
    specs
        .map(|(name, spec)| {
            let world = World::new(spec).unwrap_or_else(|invalid| panic!("{name}: {invalid}"));
            (name, world)
        })
        .into()
}

/// Lives of random genomes, with genes from -5 to 5.
fn batch(world: &World, lives: u32) -> Batch {
    let gene = |life: u32, gene: usize| (pcg4d([life, gene as u32, 0, 2028])[0] % 10_001) as f32 / 1000.0 - 5.0;
    let genome = |life| (0..world.genes()).map(|own| gene(life, own)).collect::<Vec<_>>();
    let genomes: Vec<_> = (0..lives).map(genome).collect();
    let lives: Vec<_> = (0_u64..)
        .zip(&genomes)
        .map(|(life, genes)| Rollout {
            world: 0,
            genes,
            key: Key::rollout(7, 0, life, 0),
        })
        .collect();
    Batch::new(std::slice::from_ref(world), &lives, Some(TraceRequest { every: 7 })).unwrap()
}

/// Episodes that are pinned ([`crate::composed`]).
pub(crate) fn subjects() -> Vec<Subject> {
    let subject = |(name, world): (&str, World)| {
        // The interpreter takes a second for each episode of twenty robots.
        let few = usize::from(world.robots() <= 20 && world.spec().cycles <= 60);
        let subject = Subject::new(name, 40, few, move |episodes| batch(&world, episodes as u32));
        if name == "foraging" {
            subject
        } else {
            subject.without_gpu().without_specialising()
        }
    };
    worlds().into_iter().map(subject).collect()
}
