//! Pucks, which robots push and carry.

use oneiro::arena::{Arena, Patch};
use oneiro::batch::{Batch, Rollout, Trace, TraceRequest};
use oneiro::compose::DetailKind;
use oneiro::cpu::Cpu;
use oneiro::differential::{Build, Contact, Differential, Sensor, SensorKind, Starts};
use oneiro::evaluator::{Control, Evaluator};
use oneiro::random::Key;
use oneiro::reference::Model;
use oneiro::world::{Collision, Poses, Pucks, Robot, Start, Task, World, WorldSpec};

use crate::composed::Subject;

const ROBOTS: u32 = 4;
const PUCKS: u32 = 9;
const BODY: f32 = 27.5;
const RADIUS: f32 = 22.0;
const CYCLES: u32 = 240;
const SIDES: [f32; 2] = [600.0, 500.0];

/// Robots that see pucks, other robots and walls.
fn spec(task: Task, pucks: Pucks) -> WorldSpec {
    let mut arena = Arena::rectangle(SIDES[0], SIDES[1]).with_obstacles([(300.0, 250.0)], 30.0);
    arena.patches.push(Patch {
        x: 120.0,
        y: 120.0,
        radius: Some(110.0),
        ..Patch::default()
    });
    let sensor = |name: &str, kind: SensorKind, heading: f32, range: f32| Sensor {
        name: name.to_owned(),
        kind,
        heading,
        range: Some(range),
        ..Sensor::default()
    };
    WorldSpec {
        task,
        arena,
        pucks,
        cycles: CYCLES,
        robot: Robot {
            body_radius: BODY,
            collision: Collision::Undo,
            build: Build::Differential(Differential {
                count: Some(ROBOTS),
                sensors: vec![
                    sensor("puck", SensorKind::Puck, 0.0, 700.0),
                    sensor("robot", SensorKind::Sight, 0.0, 700.0),
                    sensor("left", SensorKind::Proximity, 0.1, 60.0),
                    sensor("right", SensorKind::Proximity, -0.1, 60.0),
                    sensor("bump", SensorKind::Bumper, 0.0, 2.0),
                    Sensor {
                        name: "carries".to_owned(),
                        kind: SensorKind::Gripper,
                        ..Sensor::default()
                    },
                ],
                ..Differential::new(51.0, 150.0)
            }),
            ..Robot::khepera()
        },
        ..WorldSpec::miglino1995()
    }
}

fn some() -> Pucks {
    Pucks {
        count: Some(PUCKS),
        radius: Some(RADIUS),
        grip: Some(8.0),
        ..Pucks::default()
    }
}

fn world(spec: WorldSpec) -> World {
    World::new(spec).unwrap_or_else(|invalid| panic!("{invalid}"))
}

/// Episodes of robots that drive ahead, and turn more or less where they see something.
fn batch(world: &World, count: usize) -> Batch {
    let genome = |individual: usize| -> Vec<f32> {
        let gene = |index: usize| ((index * 7 + individual * 3) % 11) as f32 / 4.0 - 1.25;
        let bias = world.genes() / 2 - 1;
        (0..world.genes())
            .map(|index| gene(index) + if index % (bias + 1) == bias { 1.5 } else { 0.0 })
            .collect()
    };
    let genomes: Vec<_> = (0..count).map(genome).collect();
    let rollout = |(individual, genes)| Rollout {
        world: 0,
        genes,
        key: Key::rollout(5, 0, individual, 0),
    };
    let rollouts: Vec<_> = (0..).zip(genomes.iter().map(Vec::as_slice)).map(rollout).collect();
    Batch::new(std::slice::from_ref(world), &rollouts, Some(TraceRequest { every: 1 })).unwrap()
}

pub(crate) fn subjects() -> Vec<Subject> {
    // Robots that begin at poses, next to pucks at drawn places.
    let pose = |robot: u32| [60.0 + 100.0 * robot as f32, 400.0, robot as f32 / 8.0];
    let poses = Start::Poses(Poses((0..ROBOTS).map(pose).collect()));
    [
        ("gathered", Task::GatherPucks, Start::Random),
        ("brought", Task::BringPucks, Start::Random),
        ("at poses", Task::GatherPucks, poses),
    ]
    .map(|(name, task, start)| {
        let world = world(WorldSpec {
            start,
            ..spec(task, some())
        });
        Subject::new(name, 48, 2, |count| batch(&world, count)).without_specialising()
    })
    .into()
}

/// Places of all pucks at the start of each cycle, and the robots'.
struct Seen {
    pucks: Vec<Vec<[f32; 2]>>,
    robots: Vec<Vec<[f32; 2]>>,
    fitness: f32,
}

fn places(world: &World, trace: &Trace, fitness: f32) -> Seen {
    let of = |kind: DetailKind, step: usize, words: &[u32]| -> Vec<[f32; 2]> {
        let details = world.details().iter().zip(words);
        let own: Vec<f32> = details
            .filter(|(detail, _)| detail.kind == kind)
            .map(|(_, word)| f32::from_bits(*word))
            .collect();
        own.chunks(step).map(|place| [place[0], place[1]]).collect()
    };
    let (mut pucks, mut robots) = (Vec::new(), Vec::new());
    for (record, details) in trace.lines() {
        pucks.push(of(DetailKind::Puck, 2, details));
        let mut all = vec![[record.x, record.y]];
        all.extend(of(DetailKind::Other, 3, details));
        robots.push(all);
    }
    Seen { pucks, robots, fitness }
}

fn lived(world: &World) -> Vec<Seen> {
    let outcome = Cpu::new(Some(1))
        .unwrap()
        .evaluate(&batch(world, 48), &Control::new())
        .unwrap();
    let episodes = outcome.traces.iter().zip(&outcome.fitness);
    episodes
        .map(|(trace, fitness)| places(world, trace, *fitness))
        .collect()
}

fn apart(a: [f32; 2], b: [f32; 2]) -> f32 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

#[test]
fn bodies_do_not_overlap_and_only_what_is_pushed_moves() {
    let world = world(spec(Task::GatherPucks, some()));
    let (mut moves, mut farthest) = (0, 0.0_f32);
    for seen in lived(&world) {
        for (cycle, (pucks, robots)) in seen.pucks.iter().zip(&seen.robots).enumerate() {
            assert_eq!((pucks.len(), robots.len()), (PUCKS as usize, ROBOTS as usize));
            let bodies: Vec<([f32; 2], f32)> = robots
                .iter()
                .map(|at| (*at, BODY))
                .chain(pucks.iter().map(|at| (*at, RADIUS)))
                .collect();
            for (first, (at, radius)) in bodies.iter().enumerate() {
                for (other, size) in &bodies[..first] {
                    assert!(
                        apart(*at, *other) > radius + size - 1.01,
                        "cycle {cycle}: {at:?} {other:?}"
                    );
                }
                assert!(apart(*at, [300.0, 250.0]) > 30.0 + radius - 1.01);
                for (along, side) in at.iter().zip(SIDES) {
                    assert!(
                        (radius - 1.01..side - radius + 1.01).contains(along),
                        "cycle {cycle}: {at:?}"
                    );
                }
            }
            let Some(next) = seen.pucks.get(cycle + 1) else {
                continue;
            };
            for (puck, (at, then)) in pucks.iter().zip(next).enumerate() {
                if at != then {
                    moves += 1;
                    // A robot moves 15 mm in a cycle; pucks may push each other on.
                    let near = |other: &[f32; 2], size: f32| apart(*at, *other) < RADIUS + size + 16.0;
                    let by_robot = robots.iter().any(|other| near(other, BODY));
                    let by_puck = (0..pucks.len())
                        .any(|other| other != puck && pucks[other] != next[other] && near(&pucks[other], RADIUS));
                    assert!(by_robot || by_puck, "cycle {cycle}: puck {puck} moved by itself");
                }
            }
        }
        for (first, last) in seen.pucks[0].iter().zip(seen.pucks.last().unwrap()) {
            farthest = farthest.max(apart(*first, *last));
        }
    }
    assert!(moves > 1000 && farthest > 150.0, "{moves} moves, {farthest} mm");
}

#[test]
fn pucks_that_do_not_yield_stand_still() {
    let fixed = Pucks {
        yields: Some(0.0),
        ..some()
    };
    for seen in lived(&world(spec(Task::GatherPucks, fixed))) {
        assert!(seen.pucks.iter().all(|pucks| *pucks == seen.pucks[0]));
    }
}

#[test]
fn the_fitness_of_gathering_is_what_the_task_says() {
    let world = world(spec(Task::GatherPucks, some()));
    let spread = |pucks: &[[f32; 2]]| {
        let mean = |axis: usize| pucks.iter().map(|at| f64::from(at[axis])).sum::<f64>() / f64::from(PUCKS);
        let middle = [mean(0), mean(1)];
        let squared = |at: &[f32; 2]| {
            (0..2)
                .map(|axis| (f64::from(at[axis]) - middle[axis]).powi(2))
                .sum::<f64>()
        };
        pucks.iter().map(squared).sum::<f64>()
    };
    let mut all = Vec::new();
    for seen in lived(&world) {
        // The last cycle's end isn't in a trace.
        let last = seen.pucks.last().unwrap();
        let mut cluster = vec![0];
        let mut largest = 0;
        let mut left: Vec<usize> = (1..last.len()).collect();
        loop {
            let linked = |puck: &usize| {
                cluster
                    .iter()
                    .any(|own| apart(last[*own], last[*puck]) < 2.0 * RADIUS + 20.0)
            };
            let Some(at) = left.iter().position(linked) else {
                largest = largest.max(cluster.len());
                let Some(next) = left.pop() else { break };
                cluster = vec![next];
                continue;
            };
            cluster.push(left.remove(at));
        }
        let expected = largest as f64 / f64::from(PUCKS) + 1.0 - (spread(last) / spread(&seen.pucks[0])).min(1.0);
        all.push((f64::from(seen.fitness) - expected).abs());
    }
    all.sort_by(f64::total_cmp);
    // A robot that pushes in the last cycle changes both a little.
    assert!(all[all.len() / 2] < 0.01 && all[all.len() - 1] < 0.35, "{all:?}");
}

#[test]
fn robots_carry_pucks_to_the_nest_and_put_them_down() {
    let world = world(spec(Task::BringPucks, some()));
    let home = |at: &[f32; 2]| apart(*at, [120.0, 120.0]) < 110.0;
    let (mut carried, mut put_down) = (0_usize, 0);
    for seen in lived(&world) {
        let cycles = f64::from(CYCLES);
        let mut expected = 0.0;
        // A cycle's end is the start of the next one.
        let ends = seen.pucks.iter().zip(&seen.robots).skip(1);
        let mut before = [false; PUCKS as usize];
        for (pucks, robots) in ends {
            for (puck, at) in pucks.iter().enumerate() {
                // Only a carried one is where a robot is.
                let is_carried = robots.contains(at);
                carried += usize::from(is_carried);
                if is_carried {
                    expected += 0.1 / cycles / f64::from(ROBOTS);
                } else if home(at) {
                    expected += 1.0 / f64::from(PUCKS) / cycles;
                }
                put_down += usize::from(before[puck] && !is_carried && home(at));
                before[puck] = is_carried;
            }
            for robot in robots {
                assert!(pucks.iter().filter(|at| *at == robot).count() <= 1);
            }
        }
        assert!(
            (f64::from(seen.fitness) - expected).abs() < 1.1 / cycles,
            "{} {expected}",
            seen.fitness
        );
    }
    assert!(carried > 1000 && put_down > 20, "{carried} {put_down}");
}

#[test]
fn pucks_start_where_they_are_placed() {
    let places = vec![[100.0, 100.0], [400.0, 100.0], [500.0, 400.0]];
    let placed = Pucks {
        count: Some(3),
        places: Some(Starts(places.clone())),
        ..some()
    };
    for seen in lived(&world(spec(Task::GatherPucks, placed))) {
        assert_eq!(seen.pucks[0], places);
    }
}

#[test]
fn what_does_not_fit_is_refused() {
    let refused = |change: &dyn Fn(&mut WorldSpec), field: &str, words: &str| {
        let mut own = spec(Task::Cover, some());
        change(&mut own);
        let invalid = World::new(own).err().unwrap_or_else(|| panic!("{field} is accepted"));
        assert!(invalid.field == field && invalid.problem.contains(words), "{invalid}");
    };
    let robot = |spec: &mut WorldSpec, change: &dyn Fn(&mut Differential)| {
        let Build::Differential(robot) = &mut spec.robot.build else {
            unreachable!()
        };
        change(robot);
    };
    refused(
        &|spec| spec.pucks.count = None,
        "pucks.radius_mm",
        "only with pucks.count",
    );
    refused(&|spec| spec.pucks.radius = None, "pucks", "radius_mm");
    refused(&|spec| spec.pucks.radius = Some(19.9), "pucks.radius_mm", "at least 20");
    refused(&|spec| spec.pucks.yields = Some(0.95), "pucks.yields", "0.9");
    refused(&|spec| spec.pucks.count = Some(128), "pucks.count", "1 to 127");
    refused(&|spec| spec.pucks.count = Some(100), "pucks.count", "beside the robots");
    refused(
        &|spec| spec.pucks.places = Some(Starts(vec![[100.0, 100.0]])),
        "pucks.places_mm",
        "one for each puck, 9",
    );
    let places = |places: &[[f32; 2]]| {
        let places = places.to_vec();
        move |spec: &mut WorldSpec| {
            spec.pucks.count = Some(places.len() as u32);
            spec.pucks.places = Some(Starts(places.clone()));
        }
    };
    refused(
        &places(&[[100.0, 100.0], [130.0, 100.0]]),
        "pucks.places_mm",
        "overlapping places 0 and 1",
    );
    refused(&places(&[[300.0, 290.0]]), "pucks.places_mm", "touches an object");
    refused(&places(&[[900.0, 290.0]]), "pucks.places_mm", "outside of the arena");
    let started = |spec: &mut WorldSpec| {
        places(&[[100.0, 100.0]])(spec);
        let starts = Starts(vec![[120.0, 130.0], [200.0, 400.0], [400.0, 400.0], [500.0, 100.0]]);
        robot(spec, &|robot| robot.starts = Some(starts.clone()));
    };
    refused(&started, "pucks.places_mm", "where robot 0 starts");
    refused(
        &|spec| robot(spec, &|robot| robot.contact = Some(Contact::Stop)),
        "pucks.count",
        "push",
    );
    refused(
        &|spec| robot(spec, &|robot| robot.model = Some(Model::Vectors)),
        "pucks.count",
        "robot.model",
    );
    let alone = |spec: &mut WorldSpec| {
        robot(spec, &|robot| {
            robot.count = None;
            robot.sensors.truncate(0);
        });
    };
    refused(&alone, "pucks.count", "robot.count");
    refused(
        &|spec| spec.pucks = Pucks::default(),
        "robot.sensors[0].kind",
        "only with pucks.count",
    );
    let khepera = WorldSpec {
        pucks: some(),
        ..WorldSpec::miglino1995()
    };
    assert_eq!(World::new(khepera).unwrap_err().field, "pucks.count");
}
