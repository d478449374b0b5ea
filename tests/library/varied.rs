//! Noise that shipped kernels don't have: what each value does, and refusals.
//! `tests/library/parity.rs` compares it with the witness.

use oneiro::batch::{Record, Trace};
use oneiro::differential::{Build, Differential};
use oneiro::world::{Drawn, Noise, World, WorldSpec};

use crate::composed::Subject;
use crate::described::{self, subject, traces};
use crate::lives::choices::varied;

const LIVES: usize = 40;

fn spec(noise: Noise) -> WorldSpec {
    WorldSpec {
        noise,
        cycles: 100,
        ..WorldSpec::miglino1995()
    }
}

fn words(traces: &[Trace]) -> Vec<u32> {
    traces.iter().flat_map(Trace::words).collect()
}

/// Episodes that are pinned ([`crate::composed`]).
pub(crate) fn subjects() -> Vec<Subject> {
    let subject = |(name, spec)| subject(name, WorldSpec { cycles: 100, ..spec });
    varied().into_iter().map(subject).collect()
}

/// Each reading as perceived over the same before noise, of readings that are neither 0 nor clipped.
fn gains(trace: &Trace, sensor: usize) -> Vec<f32> {
    let of = |details: &[u32]| {
        let [perceived, real] = [sensor, 8 + sensor].map(|place| f32::from_bits(details[place]));
        (real > 0.05 && real < 0.6).then_some(perceived / real)
    };
    trace.lines().filter_map(|(_, details)| of(details)).collect()
}

#[test]
fn a_life_keeps_its_gains() {
    let noise = |drawn| Noise {
        gain: Some(0.5),
        drawn: Some(drawn),
        ..Noise::NONE
    };
    let spread = |drawn| {
        let lived = traces(spec(noise(drawn)), LIVES);
        let ranges = lived.iter().flat_map(|trace| {
            (0..8).filter_map(|sensor| {
                let gains = gains(trace, sensor);
                let least = gains.iter().copied().reduce(f32::min)?;
                let most = gains.iter().copied().reduce(f32::max)?;
                assert!(least >= 0.499 && most <= 1.501, "{least} {most}");
                (gains.len() > 4).then_some((least, most))
            })
        });
        ranges.collect::<Vec<_>>()
    };
    let of_life = spread(Drawn::Life);
    assert!(of_life.len() > 20 && of_life.iter().all(|(least, most)| most - least < 1e-5));
    // Lives and sensors differ.
    assert!(of_life.iter().any(|(least, _)| *least < 0.7) && of_life.iter().any(|(_, most)| *most > 1.3));
    assert!(spread(Drawn::Cycle).iter().any(|(least, most)| most - least > 0.2));
}

/// Records and those after them, without the cycles that end in a collision.
fn free(trace: &Trace) -> Vec<(Record, Record)> {
    let records: Vec<Record> = trace.lines().map(|(record, _)| *record).collect();
    let pairs = records.windows(2).map(|pair| (pair[0], pair[1]));
    pairs.filter(|(now, _)| now.collided == 0.0).collect()
}

/// How far the heading turns from a record to the next, in turns from -0.5 to 0.5.
fn turn(now: &Record, next: &Record) -> f32 {
    let turn = next.heading - now.heading;
    turn - (turn + 0.5).floor()
}

#[test]
fn a_robot_that_veers_turns_by_its_way() {
    let noise = |drawn| Noise {
        veer: Some(2.0),
        drawn: Some(drawn),
        ..Noise::NONE
    };
    // Of cycles in which both wheels go alike, and only those.
    let rates = |drawn| -> Vec<Vec<f32>> {
        let of = |trace: &Trace| {
            let straight = free(trace).into_iter();
            let straight = straight.filter(|(now, _)| now.speed_left == now.speed_right && now.speed_left > 0.5);
            straight
                .map(|(now, next)| 1e3 * turn(&now, &next) / (next.x - now.x).hypot(next.y - now.y))
                .collect()
        };
        traces(spec(noise(drawn)), 200).iter().map(of).collect()
    };
    let all: Vec<Vec<f32>> = rates(Drawn::Life).into_iter().filter(|own| own.len() > 1).collect();
    assert!(!all.is_empty());
    for own in &all {
        assert!(own.iter().all(|rate| rate.abs() <= 2.1), "{own:?}");
        assert!(own.iter().all(|rate| (rate - own[0]).abs() < 0.1), "{own:?}");
    }
    assert!(all.iter().any(|own| own[0].abs() > 0.2));
    let varies = |own: &Vec<f32>| own.iter().any(|rate| (rate - own[0]).abs() > 0.5);
    assert!(rates(Drawn::Cycle).iter().any(varies));
}

#[test]
fn the_first_command_is_late_by_the_delay() {
    let lived = |noise| traces(spec(noise), LIVES);
    let late = Noise {
        delay: Some(1.0),
        drawn: Some(Drawn::Life),
        ..Noise::NONE
    };
    let way = |trace: &Trace| {
        let (now, next) = *free(trace).first()?;
        Some((next.x - now.x).hypot(next.y - now.y))
    };
    // A robot stands still before its first command, and starts and genes are the same without noise.
    let shares: Vec<f32> = lived(late)
        .iter()
        .zip(&lived(Noise::NONE))
        .filter_map(|(late, prompt)| Some((way(late)?, way(prompt)?)))
        .filter(|(_, prompt)| *prompt > 1.0)
        .map(|(late, prompt)| late / prompt)
        .collect();
    assert!(
        shares.len() > 5 && shares.iter().all(|share| (-1e-3..=1.001).contains(share)),
        "{shares:?}"
    );
    assert!(
        shares.iter().any(|share| *share < 0.4) && shares.iter().any(|share| *share > 0.6),
        "{shares:?}"
    );
}

/// What draws nothing is no noise, and values of 0 need no kernel of their own.
#[test]
fn nothing_drawn_is_no_noise() {
    let quiet = words(&traces(spec(Noise::NONE), LIVES));
    let of_life = Noise {
        drawn: Some(Drawn::Life),
        ..Noise::NONE
    };
    assert!(quiet == words(&traces(spec(of_life), LIVES)));
    let zero = Noise {
        gain: Some(0.0),
        veer: Some(0.0),
        delay: Some(0.0),
        drawn: Some(Drawn::Cycle),
        ..Noise::NONE
    };
    let kernel = |noise| World::new(spec(noise)).unwrap().kernel().name;
    assert_eq!(kernel(zero), kernel(Noise::NONE));
    assert_ne!(kernel(of_life), kernel(Noise::NONE));
    let least = Noise {
        gain: Some(0.01),
        ..of_life
    };
    assert!(quiet != words(&traces(spec(least), LIVES)));
}

#[test]
fn only_robots_sampled_as_a_whole_have_it() {
    let refused = |noise: Noise, key: &str, allowed: &str| {
        let mut spec = described::spec(|_, _| ());
        spec.noise = noise;
        let invalid = World::new(spec.clone()).unwrap_err();
        assert_eq!(invalid.field, key);
        assert!(invalid.problem.contains(allowed), "{}", invalid.problem);
        spec.noise = Noise::NONE;
        spec.robot.build = Build::Differential(Differential::new(60.0, 200.0));
        World::new(spec).unwrap();
    };
    let allowed = "is not 0; allowed: 0, or robot.kind = \"sampled\"";
    let none = Noise::NONE;
    refused(
        Noise {
            gain: Some(0.5),
            ..none
        },
        "noise.gain",
        allowed,
    );
    refused(
        Noise {
            veer: Some(0.5),
            ..none
        },
        "noise.veer_turns_per_m",
        allowed,
    );
    refused(
        Noise {
            delay: Some(0.5),
            ..none
        },
        "noise.delay_cycles",
        allowed,
    );
    let of_life = Noise {
        drawn: Some(Drawn::Life),
        ..none
    };
    refused(
        of_life,
        "noise.drawn",
        "is `life`; allowed: `cycle`, or robot.kind = \"sampled\"",
    );
    let beyond = World::new(spec(Noise {
        delay: Some(1.5),
        ..none
    }))
    .unwrap_err();
    assert!(beyond.problem.contains("allowed: 0 to 1"), "{}", beyond.problem);
}
