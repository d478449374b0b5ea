//! A described robot, the arena that it lives in and its geometry in double precision, for tests of what it senses and does.

use std::f64::consts::TAU;

use crate::composed::Subject;
use crate::lives;
use oneiro::arena::{Arena, Block, Obstacle};
use oneiro::batch::{Batch, Trace};
use oneiro::cpu::Cpu;
use oneiro::differential::{Build, Differential, Sensor, SensorKind};
use oneiro::evaluator::{Control, Evaluator};
use oneiro::world::{Collision, World, WorldSpec};

pub(crate) const RADIUS: f64 = 40.0;

pub(crate) fn sensor(name: &str, kind: SensorKind, heading: f32, range: f32) -> Sensor {
    Sensor {
        name: name.into(),
        kind,
        heading,
        range: Some(range),
        ..Sensor::default()
    }
}

pub(crate) fn robot() -> Differential {
    Differential {
        sensors: vec![
            sensor("ahead", SensorKind::Proximity, 0.0, 100.0),
            sensor("left", SensorKind::Distance, 0.2, 150.0),
            Sensor {
                offset: Some(0.0),
                ..sensor("back", SensorKind::Distance, -0.45, 90.0)
            },
            Sensor {
                width: Some(0.3),
                ..sensor("bump", SensorKind::Bumper, 0.0, 5.0)
            },
            sensor("right", SensorKind::Proximity, -0.2, 80.0),
        ],
        ..Differential::new(60.0, 200.0)
    }
}

pub(crate) fn arena() -> Arena {
    Arena {
        blocks: vec![Block {
            x: 420.0,
            y: 420.0,
            length: 120.0,
            width: 60.0,
            heading: 0.07,
            class: "whatever".into(),
        }],
        obstacles: vec![Obstacle {
            x: 180.0,
            y: 400.0,
            radius: 30.0,
            class: "anything".into(),
        }],
        ..Arena::rectangle(600.0, 600.0)
    }
}

pub(crate) fn spec(change: impl FnOnce(&mut WorldSpec, &mut Differential)) -> WorldSpec {
    let mut own = robot();
    let mut spec = WorldSpec {
        arena: arena(),
        cycles: 150,
        ..WorldSpec::miglino1995()
    };
    spec.robot.body_radius = RADIUS as f32;
    spec.robot.collision = Collision::Slide;
    change(&mut spec, &mut own);
    spec.robot.build = Build::Differential(own);
    spec
}

/// Traced lives in one world, with genes from -2 to 2.
fn batch(world: &World, lives: usize) -> Batch {
    let moderate = |_, genes: &mut [f32]| genes.iter_mut().for_each(|gene| *gene *= 0.4);
    lives::batch_with(std::slice::from_ref(world), lives, Some(1), moderate)
}

pub(crate) fn traces(spec: WorldSpec, lives: usize) -> Vec<Trace> {
    let world = World::new(spec).unwrap();
    let outcome = Cpu::new(Some(2))
        .unwrap()
        .evaluate(&batch(&world, lives), &Control::new());
    outcome.unwrap().traces
}

/// Distance from a point to the nearest point of each object, and the direction of that point.
pub(crate) fn objects([x, y]: [f64; 2]) -> [(f64, f64); 6] {
    let to = |[px, py]: [f64; 2]| ((px - x).hypot(py - y), (py - y).atan2(px - x));
    let (sine, cosine) = (0.07 * TAU).sin_cos();
    let along = ((x - 420.0) * cosine + (y - 420.0) * sine).clamp(-60.0, 60.0);
    let across = ((y - 420.0) * cosine - (x - 420.0) * sine).clamp(-30.0, 30.0);
    let (distance, direction) = to([180.0, 400.0]);
    [
        to([0.0, y]),
        to([600.0, y]),
        to([x, 0.0]),
        to([x, 600.0]),
        (distance - 30.0, direction),
        to([
            420.0 + along * cosine - across * sine,
            420.0 + along * sine + across * cosine,
        ]),
    ]
}

/// Distance along a ray to the nearest object, by small steps.
pub(crate) fn ray([x, y]: [f64; 2], angle: f64, range: f64) -> f64 {
    const STEP: f64 = 0.02;
    let mut distance = 0.0;
    while distance < range {
        let at = [x + distance * angle.cos(), y + distance * angle.sin()];
        let is_out = !(0.0..=600.0).contains(&at[0]) || !(0.0..=600.0).contains(&at[1]);
        let least = objects(at)
            .iter()
            .fold(f64::MAX, |least, (distance, _)| least.min(*distance));
        if is_out || least <= STEP / 2.0 {
            return distance;
        }
        // Nothing is nearer than that.
        distance += (0.9 * least).max(STEP);
    }
    range
}

/// Episodes in a world that are pinned.
pub(crate) fn subject(name: impl Into<String>, spec: WorldSpec) -> Subject {
    let world = World::new(spec).unwrap();
    Subject::new(name, 200, 4, |episodes| batch(&world, episodes))
}
