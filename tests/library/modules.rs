//! Shared by the tests of state machines, of behaviour trees and of several genomes: a world, lives in it, and `AutoMoDe`'s modules by
//! a second program, written from `docs/controllers.md`.

use oneiro::arena::Arena;
use oneiro::automode::{Behaviour, Condition, Crowd};
use oneiro::batch::{Batch, Outcome, Rollout, TraceRequest};
use oneiro::compose::{DetailKind, Kind};
use oneiro::differential::Build;
use oneiro::evaluator::{Control, Evaluator};
use oneiro::parameter::Choice;
use oneiro::random::{Key, pcg4d};
use oneiro::reference::{Model, Reference};
use oneiro::world::{Controller, World, WorldSpec};

use crate::composed::Subject;
use crate::epucks::{disc, epucks, lamp};

/// E-pucks on a floor of three greys, with a lamp.
pub(crate) fn spec(controller: Controller, count: u32) -> WorldSpec {
    let corner = |side: f32| [side, -side];
    let [a, b] = corner(900.0);
    let mut arena = Arena::polygon(&[[b, b], [a, b], [a, a], [b, a]], None);
    arena.floor = Some(0.498);
    arena.wall_height = Some(80.0);
    arena.patches = vec![disc(-500.0, 0.0, 350.0, 0.0), disc(500.0, 0.0, 350.0, 1.0)];
    arena.lights = vec![lamp(0.0, -1000.0, 750.0, 5.0)];
    let reference = Reference {
        signal_loss: Some(0.7),
        ..Reference::DEFAULT
    };
    WorldSpec {
        robot: epucks(Model::Vectors, reference, count),
        arena,
        controller,
        cycles: 100,
        ..WorldSpec::miglino1995()
    }
}

/// A genome whose genes are uniform in their ranges, or from -3 to 3.
pub(crate) fn genome(world: &World, life: u32) -> Vec<f32> {
    let gene = |(index, range): (usize, Option<[f32; 2]>)| {
        let [least, greatest] = range.unwrap_or([-3.0, 3.0]);
        let share = (pcg4d([life, index as u32, 0, 2029])[0] >> 8) as f32 / 16_777_216.0;
        least + share * (greatest - least)
    };
    world.gene_layout().ranges().into_iter().enumerate().map(gene).collect()
}

/// The key of a life of a batch.
pub(crate) fn key(life: u64) -> Key {
    Key::rollout(1, 0, life, 0)
}

pub(crate) fn batch(world: &World, genomes: &[Vec<f32>], every: u32) -> Batch {
    let lives: Vec<_> = (0_u64..)
        .zip(genomes)
        .map(|(life, genes)| Rollout {
            world: 0,
            genes,
            key: key(life),
        })
        .collect();
    Batch::new(std::slice::from_ref(world), &lives, Some(TraceRequest { every })).unwrap()
}

pub(crate) fn evaluated(evaluator: &mut dyn Evaluator, batch: &Batch) -> Outcome {
    evaluator.evaluate(batch, &Control::new()).unwrap()
}

/// The numbers, from 0 to less than 1, that a robot draws in a cycle: four of each block.
pub(crate) fn drawn(key: [u32; 2], step: u32, block: u32) -> [f64; 4] {
    let [a, b] = key;
    pcg4d([a, b, step, 6 << 16 | block]).map(|word| f64::from(word >> 8) / 16_777_216.0)
}

/// The wheels' speeds, as shares of the greatest, along a vector.
pub(crate) fn along([ahead, left]: [f64; 2]) -> [f64; 2] {
    if ahead.hypot(left) < 0.1 {
        return [1.0, 1.0];
    }
    let inner = left.atan2(ahead).cos().max(-0.5);
    if left > 0.0 { [inner, 1.0] } else { [1.0, inner] }
}

pub(crate) fn holds(condition: Condition, ground: f64, neighbours: f64) -> f64 {
    let more_than =
        |crowd: Crowd| 1.0 / (1.0 + (f64::from(crowd.steepness) * (f64::from(crowd.neighbours) - neighbours)).exp());
    match condition {
        Condition::BlackFloor(p) => {
            if ground == 0.0 {
                p.into()
            } else {
                0.0
            }
        }
        Condition::GreyFloor(p) => {
            if ground == 0.5 {
                p.into()
            } else {
                0.0
            }
        }
        Condition::WhiteFloor(p) => {
            if ground == 1.0 {
                p.into()
            } else {
                0.0
            }
        }
        Condition::NeighbourCount(crowd) => more_than(crowd),
        Condition::InvertedNeighbourCount(crowd) => 1.0 - more_than(crowd),
        Condition::FixedProbability(p) => p.into(),
    }
}

/// What a behaviour does in a cycle, as shares of the greatest speed, and for how many cycles exploration turns then; `readings` in the
/// order of the model's.
pub(crate) fn act(
    behaviour: Behaviour,
    readings: &[f64],
    mut turning: i32,
    key: [u32; 2],
    step: u32,
) -> ([f64; 2], i32) {
    let [near, light, others] = [0, 2, 6].map(|first| [readings[first], readings[first + 1]]);
    let plus = |a: f64, v: [f64; 2], b: f64, w: [f64; 2]| [a * v[0] + b * w[0], a * v[1] + b * w[1]];
    let wheels = match behaviour {
        Behaviour::Exploration { .. } if turning > 0 => {
            turning -= 1;
            [-1.0, 1.0]
        }
        Behaviour::Exploration { .. } if turning < 0 => {
            turning += 1;
            [1.0, -1.0]
        }
        Behaviour::Exploration { turning: most } => {
            if near[0].hypot(near[1]) >= 0.1 && near[1].atan2(near[0]).abs() <= std::f64::consts::FRAC_PI_2 {
                let cycles = ((drawn(key, step, 2)[0] * f64::from(most + 1)) as i32).max(1);
                turning = if near[1] < 0.0 { cycles } else { -cycles };
            }
            [1.0, 1.0]
        }
        Behaviour::Stop => [0.0, 0.0],
        Behaviour::Phototaxis => along(plus(1.0, light, -5.0, near)),
        Behaviour::AntiPhototaxis => along(plus(-1.0, light, -5.0, near)),
        Behaviour::Attraction { strength } => along(plus(strength.into(), others, -6.0, near)),
        Behaviour::Repulsion { strength } => along(plus((-strength).into(), others, -5.0, near)),
    };
    (wheels, turning)
}

/// The places of what robots perceive and of what their controller remembers, in a trace's details.
pub(crate) fn places(world: &World) -> [Vec<usize>; 2] {
    [DetailKind::Perceived, DetailKind::Memory(Kind::Controller)].map(|kind| {
        let all = (0..).zip(world.details());
        all.filter(|(_, own)| own.kind == kind)
            .map(|(index, _)| index)
            .collect()
    })
}

/// The first robot's key in a life of a batch.
pub(crate) fn key_of(life: u64) -> [u32; 2] {
    let [a, b] = key(life).words;
    let [a, b, ..] = pcg4d([a, b, 0, 0xff00]);
    [a, b]
}

/// Whether wheels are not those that were recorded.
pub(crate) fn is_off(wheels: [f64; 2], recorded: [f32; 2]) -> bool {
    let is_off = |(wheel, output): (f64, f32)| (0.5 + 0.5 * wheel - f64::from(output)).abs() > 1e-5;
    wheels.into_iter().zip(recorded).any(is_off)
}

/// Robots without the readings that modules use are refused.
pub(crate) fn check_refusal(controller: &Controller) {
    let mut other = spec(controller.clone(), 3);
    if let Build::Differential(own) = &mut other.robot.build {
        own.model = Some(Model::Rm11);
    }
    let single = WorldSpec {
        controller: controller.clone(),
        ..WorldSpec::miglino1995()
    };
    for spec in [other, single] {
        let expected = format!(
            "controller.kind: is `{}`; allowed: only with robot.model = \"rm1.1-vectors\"",
            controller.word()
        );
        assert_eq!(World::new(spec).unwrap_err().to_string(), expected);
    }
}

/// Episodes in a world that are pinned.
pub(crate) fn subject(name: &str, world: &World) -> Subject {
    let genomes: Vec<_> = (0..70).map(|episode| genome(world, episode)).collect();
    Subject::new(name, 70, 2, |episodes| batch(world, &genomes[..episodes], 7))
}
