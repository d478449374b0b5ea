//! Pictures on the floor.

use std::collections::BTreeSet;
use std::f64::consts::TAU;
use std::sync::Arc;

use oneiro::arena::{Arena, Field, Patch};
use oneiro::batch::{Batch, Rollout};
use oneiro::compose::{Kind, OwnPart, OwnParts, Part};
use oneiro::cpu::Cpu;
use oneiro::differential::{Build, Differential, Sensor, SensorKind};
use oneiro::evaluator::{Control, Evaluator};
use oneiro::parameter::Datum;
use oneiro::picture::Picture;
use oneiro::random::Key;
use oneiro::surrogate::{Difference, Differences, Surrogate};
use oneiro::world::{ByKey, Collision, Robot, Task, Varied, World, WorldSpec};

use crate::composed::Subject;
use crate::described::{sensor, spec, subject, traces};

/// Where the picture lies, mm, and its cells.
const FIELD: Field = Field {
    x: 90.0,
    y: 60.0,
    width: 420.0,
    height: 330.0,
};
const CELLS: [u32; 2] = [37, 23];

/// The grey of a cell: 0 and 255 are among them.
fn grey(column: u32, row: u32) -> u8 {
    ((column * 53 + row * 101 + column * row * 7) % 256) as u8
}

fn picture() -> Picture {
    let [columns, rows] = CELLS;
    let greys = (0..rows).flat_map(|row| (0..columns).map(move |column| grey(column, row)));
    Picture::new([FIELD.x, FIELD.y], [FIELD.width, FIELD.height], CELLS, greys.collect()).unwrap()
}

/// Robots with sensors of the floor on a floor with a picture, and with a patch on that.
fn pictured(change: impl FnOnce(&mut WorldSpec, &mut Differential)) -> WorldSpec {
    spec(|spec, robot| {
        let ground = |name, heading, offset| Sensor {
            range: None,
            offset: Some(offset),
            ..sensor(name, SensorKind::Ground, heading, 0.0)
        };
        robot.sensors = vec![
            ground("middle", 0.0, 0.0),
            ground("left", 0.1, 38.0),
            sensor("ahead", SensorKind::Proximity, 0.0, 100.0),
        ];
        spec.arena.floor = Some(0.3);
        spec.arena.picture = Some(picture());
        spec.arena.patches = vec![Patch {
            x: 300.0,
            y: 200.0,
            radius: Some(60.0),
            grey: 0.7,
            ..Patch::default()
        }];
        change(spec, robot);
    })
}

/// Several of them.
fn swarm(count: u32) -> WorldSpec {
    pictured(|spec, robot| {
        spec.robot.collision = Collision::Undo;
        robot.count = Some(count);
    })
}

/// The reading at a place without what surrogates add; `None` so near to an edge that rounding matters.
fn expected([x, y]: [f64; 2]) -> Option<f32> {
    let near = |distance: f64| distance.abs() < 0.01;
    let from_patch = (x - 300.0).hypot(y - 200.0) - 60.0;
    if near(from_patch) {
        return None;
    }
    if from_patch < 0.0 {
        return Some(0.7);
    }
    let cell = |at: f64, low: f32, side: f32, count: u32| (at - f64::from(low)) / f64::from(side) * f64::from(count);
    let [column, row] = [
        cell(x, FIELD.x, FIELD.width, CELLS[0]),
        cell(y, FIELD.y, FIELD.height, CELLS[1]),
    ];
    if near(column - column.round()) || near(row - row.round()) {
        return None;
    }
    let is_within = (0.0..f64::from(CELLS[0])).contains(&column) && (0.0..f64::from(CELLS[1])).contains(&row);
    let read = || f32::from(grey(column as u32, row as u32)) * (1.0 / 255.0);
    Some(if is_within { read() } else { 0.3 })
}

/// A task that scores what it is told of the floor at places on and beside the picture.
fn told(mut spec: WorldSpec) -> World {
    let is_swarm = matches!(&spec.robot.build, Build::Differential(robot) if robot.count.is_some());
    let [cycle, score] = if is_swarm {
        [
            "fn mission_cycle(episode: Episode, step: u32, before: MissionState) -> Tally { return Tally(0.0, before); }",
            "mission_score(episode: Episode, memory: MissionState",
        ]
    } else {
        [
            "fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward { return Reward(0.0, before); }",
            "task_score(episode: Episode, memory: TaskState",
        ]
    };
    let text = format!(
        "{cycle}
        fn {score}, sum: f32) -> f32 {{
            var all = floor_at(episode, vec2(300.0, 200.0)) + 10.0 * floor_at(episode, vec2(20.0, 20.0));
            for (var place = 0u; place < 64u; place++) {{
                all += f32(place) * floor_at(episode, vec2(97.52 + 6.08 * f32(place), 381.02 - 4.76 * f32(place)));
            }}
            return all;
        }}"
    );
    let part = Part::new(Kind::Task, "told.wgsl", &text).unwrap_or_else(|refused| panic!("{refused}"));
    spec.own = OwnParts::from([OwnPart::new(Arc::new(part), &[]).unwrap()]);
    spec.task = Task::Own;
    spec.cycles = 2;
    World::new(spec).unwrap_or_else(|invalid| panic!("{invalid}"))
}

/// A Khepera, which senses no floor, on the same one.
fn sampled() -> WorldSpec {
    let of = pictured(|_, _| ());
    WorldSpec {
        robot: Robot::khepera(),
        arena: Arena {
            blocks: Vec::new(),
            obstacles: Vec::new(),
            ..of.arena.clone()
        },
        ..of
    }
}

fn told_worlds() -> [(&'static str, World); 3] {
    [
        ("told", told(pictured(|_, _| ()))),
        ("told to a swarm", told(swarm(2))),
        ("told to a Khepera", told(sampled())),
    ]
}

fn batch(world: &World, count: usize) -> Batch {
    let genes = vec![0.25; world.genes()];
    let rollout = |trial| Rollout {
        world: 0,
        genes: &genes,
        key: Key::rollout(3, 0, 0, trial),
    };
    let rollouts: Vec<_> = (0..count as u64).map(rollout).collect();
    Batch::new(std::slice::from_ref(world), &rollouts, None).unwrap()
}

/// Episodes that are pinned ([`crate::composed`]).
pub(crate) fn subjects() -> Vec<Subject> {
    let varied = |spec: &mut WorldSpec| {
        let range = Datum::List(vec![Datum::Single(150.0), Datum::Single(450.0)]);
        spec.varied = Varied {
            vary: ByKey(vec![("arena.patches[0].x_mm".to_owned(), range)]),
            count: Some(3),
            ..Varied::default()
        };
    };
    let drawn = pictured(|spec, _| varied(spec));
    let surrogate = WorldSpec {
        surrogate: Some(Arc::new(Surrogate::drawn(5, Differences::all(1.75)))),
        ..pictured(|_, _| ())
    };
    let described = [
        ("alone", pictured(|_, _| ())),
        ("four robots", swarm(4)),
        ("drawn worlds", drawn),
        ("a surrogate", surrogate),
    ];
    let described = described.map(|(name, spec)| {
        let subject = subject(name, spec);
        if name == "alone" {
            subject
        } else {
            subject.without_specialising()
        }
    });
    let told = told_worlds()
        .map(|(name, world)| Subject::new(name, 8, 2, move |count| batch(&world, count)).without_specialising());
    described.into_iter().chain(told).collect()
}

#[test]
fn sensors_read_the_greys_of_the_picture() {
    let mut greys = BTreeSet::new();
    for trace in traces(pictured(|_, _| ()), 150) {
        for (record, details) in trace.lines().step_by(3) {
            let (x, y, heading) = (f64::from(record.x), f64::from(record.y), f64::from(record.heading));
            for (index, turns, offset) in [(0, 0.0, 0.0), (1, 0.1, 38.0)] {
                let angle = (heading + turns) * TAU;
                let Some(expected) = expected([x + offset * angle.cos(), y + offset * angle.sin()]) else {
                    continue;
                };
                // Readings without noise come after those with it.
                assert_eq!(f32::from_bits(details[3 + index]), expected, "{record:?}");
                greys.insert(expected.to_bits());
            }
        }
    }
    assert!(greys.len() > 200, "{} greys", greys.len());
}

/// A surrogate's floor returns more light or less: all cells of the picture alike.
#[test]
fn a_surrogate_reads_more_or_less_light_from_it() {
    let only = Differences::all(0.0).with(Difference::Reflectivity, 1.0);
    let spec = WorldSpec {
        surrogate: Some(Arc::new(Surrogate::drawn(5, only))),
        ..pictured(|_, _| ())
    };
    let mut factors = Vec::new();
    for trace in traces(spec, 40) {
        for (record, details) in trace.lines().step_by(5) {
            let [x, y] = [f64::from(record.x), f64::from(record.y)];
            let is_on_patch = (x - 300.0).hypot(y - 200.0) < 61.0;
            // Whiter ones may read as white.
            if let Some(grey) = expected([x, y]).filter(|grey| !is_on_patch && (0.1..0.8).contains(grey)) {
                factors.push(f32::from_bits(details[3]) / grey);
            }
        }
    }
    assert!(factors.len() > 100 && (factors[0] - 1.0).abs() > 0.01, "{factors:?}");
    assert!(
        factors.iter().all(|factor| (factor - factors[0]).abs() < 1e-5),
        "{factors:?}"
    );
}

#[test]
fn parts_are_told_the_greys_of_the_picture() {
    let mut sum = 0.7 + 10.0 * 0.3_f32;
    for place in 0..64_u8 {
        let place = f32::from(place);
        let at = [97.52 + 6.08 * place, 381.02 - 4.76 * place].map(f64::from);
        sum += place * expected(at).expect("no place is near an edge");
    }
    for (name, world) in told_worlds() {
        let outcome = Cpu::new(Some(1))
            .unwrap()
            .evaluate(&batch(&world, 3), &Control::new())
            .unwrap();
        for fitness in outcome.fitness {
            assert!((fitness - sum).abs() < 1e-2, "{name}: {fitness}, not {sum}");
        }
    }
}

#[test]
fn robots_that_sense_no_floor_have_no_picture() {
    let invalid = World::new(sampled()).unwrap_err();
    let text = WorldSpec {
        arena: Arena {
            floor: None,
            patches: Vec::new(),
            ..sampled().arena
        },
        ..sampled()
    };
    assert!(invalid.to_string().starts_with("arena.floor: is given"), "{invalid}");
    let invalid = World::new(text).unwrap_err();
    assert!(
        invalid
            .to_string()
            .starts_with("arena.picture: is given, but sampled robots"),
        "{invalid}"
    );
}

#[test]
fn a_picture_that_no_robot_gets_to_is_named() {
    let far = Picture::new([5000.0, 0.0], [100.0; 2], [2, 1], vec![0, 255]).unwrap();
    let spec = pictured(|spec, _| spec.arena.picture = Some(far));
    assert_eq!(World::new(spec).unwrap().unreached(), ["arena.picture"]);
    assert!(World::new(pictured(|_, _| ())).unwrap().unreached().is_empty());
}

#[test]
fn places_and_sides_out_of_range_are_refused() {
    for (low, sides, key) in [
        ([0.0; 2], [0.0, 10.0], "arena.picture.sides_mm"),
        ([f32::NAN, 0.0], [10.0; 2], "arena.picture.x_mm"),
        ([0.0, 99_990.0], [20.0; 2], "arena.picture.y_mm"),
    ] {
        let picture = Picture::new(low, sides, [1, 1], vec![0]).unwrap();
        let invalid = World::new(pictured(|spec, _| spec.arena.picture = Some(picture))).unwrap_err();
        assert_eq!(invalid.field, key, "{invalid}");
    }
}
