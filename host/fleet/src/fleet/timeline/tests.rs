use oneiro_evolve::random::{Stream, Uniform, stream};
use rand::Rng;
use rand::distr::Distribution;

use super::*;

const MINUTES: u64 = 50;

/// A number from 0 to 1.
fn share(random: &mut dyn Rng) -> f64 {
    Uniform { low: 0.0, high: 1.0 }.sample(random)
}

/// A made-up swarm of known clocks.
struct Made {
    /// Of each robot's starts: when it was by true time, ms, and its number.
    boots: Vec<Vec<(f64, u32)>>,
    /// How much too fast each robot's clock is, as a share.
    fast: Vec<f64>,
    lines: Vec<Line>,
}

impl Made {
    /// A robot clock's reading at a true time, and the start that it counts from.
    fn at(&self, robot: usize, time: f64) -> (f64, u32) {
        let (start, boot) = *self.boots[robot].iter().rfind(|(start, _)| *start <= time).unwrap();
        ((time - start) * (1.0 + self.fast[robot]), boot)
    }

    /// The maximum error between two robots' aligned clocks, over all minutes, ms.
    fn greatest_error(&self, clocks: &[Clock], robots: &[usize]) -> f64 {
        let mut greatest = 0.0_f64;
        for minute in 1..MINUTES {
            let time = 60_000.0 * minute as f64;
            let off = robots.iter().map(|&robot| {
                let (at, boot) = self.at(robot, time);
                let is_own = |clock: &&Clock| (clock.robot as usize, clock.boot) == (robot, boot);
                clocks.iter().find(is_own).unwrap().time(at).unwrap() - time
            });
            let (least, most) = off.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), off| {
                (a.min(off), b.max(off))
            });
            greatest = greatest.max(most - least);
        }
        greatest
    }
}

fn event(robot: usize, (at, boot): (f64, u32), values: Value) -> Line {
    let mut line = json!({ "at_ms": at.round() as u64, "experiment_ms": null, "boot": boot });
    let (Value::Object(line), Value::Object(values)) = (&mut line, values) else {
        panic!("objects")
    };
    line.extend(values);
    Line::read(robot as u32, &Value::Object(line.clone()).to_string()).unwrap()
}

/// Robots that say something once a second, and hear their two neighbours of a ring during every third minute, with delays from `delay`.
/// A quarter of the messages is lost. Robot 3 is started again twice.
fn made(robots: usize, seed: u64, delay: impl Fn(&mut dyn Rng, usize, usize, f64) -> f64) -> Made {
    let mut random = stream(seed, Stream::Exchange, 0);
    let boots = (0..robots)
        .map(|robot| {
            let first = -1e7 * share(&mut random);
            if robot == 3 {
                vec![(first, 1), (1.2e6, 2), (2.1e6, 3)]
            } else {
                vec![(first, 1)]
            }
        })
        .collect();
    let fast = (0..robots).map(|_| 2e-4 * (share(&mut random) - 0.5)).collect();
    let mut made = Made {
        boots,
        fast,
        lines: Vec::new(),
    };
    for second in 0..60 * MINUTES {
        for robot in 0..robots {
            let said = 1000.0 * second as f64 + 1000.0 * share(&mut random);
            let (_, boot) = made.at(robot, said);
            let sequence = (u64::from(boot) << 32) + second;
            made.lines.push(event(
                robot,
                made.at(robot, said),
                json!({ "event": "said", "sequence": sequence }),
            ));
            for other in [(robot + 1) % robots, (robot + robots - 1) % robots] {
                let is_near = (second / 60) % 3 == (robot.min(other) as u64) % 3;
                let is_lost = share(&mut random) < 0.25;
                if other != robot && is_near && !is_lost {
                    let heard = said + delay(&mut random, robot, other, said);
                    let values = json!({ "event": "heard", "sender": robot, "sequence": sequence });
                    made.lines.push(event(other, made.at(other, heard), values));
                }
            }
        }
    }
    made
}

/// Delays of a network: 2 ms, and on average 10 ms of waiting.
fn waiting(random: &mut dyn Rng) -> f64 {
    2.0 - 10.0 * (1.0 - share(random)).ln()
}

#[test]
fn clocks_of_known_offset_and_drift_are_aligned_to_some_milliseconds() {
    for seed in 0..3 {
        let made = made(10, seed, |random, _, _, _| waiting(random));
        let clocks = align(&made.lines);
        assert_eq!(clocks.len(), 12);
        let all: Vec<usize> = (0..10).collect();
        let error = made.greatest_error(&clocks, &all);
        assert!(error < 4.0, "seed {seed}: {error} ms");
        for clock in &clocks {
            assert!([By::Reference, By::Contacts].contains(&clock.by), "{clock:?}");
            assert!(
                clock.pairs > 3 && clock.residual < 4.0 && clock.bound < 15.0,
                "{clock:?}"
            );
        }
        // Drifts relative to that of the reference.
        let reference = clocks.iter().find(|clock| clock.by == By::Reference).unwrap();
        for clock in &clocks {
            let true_drift = made.fast[reference.robot as usize] - made.fast[clock.robot as usize];
            assert!((clock.drift - true_drift).abs() < 3e-6, "{clock:?}: {true_drift}");
        }
        // The control: with the same offsets and no rates, the same clocks are tens of milliseconds off.
        let rigid = |clock: &Clock| Clock {
            drift: 0.0,
            ..clock.clone()
        };
        let rigid: Vec<Clock> = clocks.iter().map(rigid).collect();
        assert!(made.greatest_error(&rigid, &all) > 40.0);
    }
}

/// A robot takes its datagrams once in 100 ms, and each at another moment: what is stated as the bound holds.
#[test]
fn clocks_of_robots_that_look_once_in_a_cycle_are_within_the_stated_bound() {
    let made = made(10, 7, |random, _, other, said| {
        let arrives = said + waiting(random);
        let phase = 37.0 * other as f64 % 100.0;
        phase + 100.0 * ((arrives - phase) / 100.0).ceil() - said
    });
    let clocks = align(&made.lines);
    let bound = clocks.iter().map(|clock| clock.bound).fold(0.0, f64::max);
    let error = made.greatest_error(&clocks, &(0..10).collect::<Vec<_>>());
    assert!(error < bound && bound < 60.0, "{error} ms, bound {bound} ms");
}

/// A robot that nobody heard is placed by the beacon; one that heard nothing at all has no time, and both say so.
#[test]
fn robots_without_contact_say_so() {
    let mut made = made(4, 1, |random, _, _, _| waiting(random));
    for second in 0..100 {
        let at = 1000.0 * f64::from(second);
        made.lines.push(event(
            8,
            (at, 1),
            json!({ "event": "said", "sequence": second, "experiment_ms": at as i64 + 777 }),
        ));
        made.lines
            .push(event(9, (at, 1), json!({ "event": "said", "sequence": second })));
    }
    // Being heard is not enough: without an answer the time on the way is not known.
    made.lines.push(event(
        0,
        (5.0, 1),
        json!({ "event": "heard", "sender": 9, "sequence": 3 }),
    ));
    let clocks = align(&made.lines);
    let of = |robot: u32| clocks.iter().find(|clock| clock.robot == robot).unwrap();
    assert_eq!((of(8).by, of(8).time(1000.0)), (By::Beacon, Some(1777.0)));
    assert_eq!((of(9).by, of(9).time(1000.0)), (By::Nothing, None));
    assert_eq!(of(9).row(), "9,1,nothing,100,,,49500.000,0,,,\n");
    assert!(of(0).by == By::Contacts || of(0).by == By::Reference);
}

/// The timeline has the experiment's time where robots know it.
#[test]
fn the_timeline_has_the_experiment_s_time() {
    let mut made = made(4, 2, |random, _, _, _| waiting(random));
    // True time is the experiment's, which robots know to 20 ms.
    let mut random = stream(5, Stream::Exchange, 0);
    for second in 0..600 {
        let time = 5000.0 * f64::from(second);
        let known = time + 40.0 * (share(&mut random) - 0.5);
        let at = made.at(2, time);
        made.lines.push(event(
            2,
            at,
            json!({ "event": "interval", "experiment_ms": known as i64 }),
        ));
    }
    let clocks = align(&made.lines);
    for robot in 0..4 {
        let (at, boot) = made.at(robot, 1.5e6);
        let clock = clocks
            .iter()
            .find(|clock| (clock.robot as usize, clock.boot) == (robot, boot))
            .unwrap();
        let error = clock.time(at).unwrap() - 1.5e6;
        assert!(error.abs() < 20.0, "robot {robot}: {error} ms");
    }
}

#[test]
fn no_lines_and_torn_lines_are_no_clocks() {
    assert_eq!(align(&[]), []);
    for text in [
        "",
        "{",
        "{\"at_ms\":1}",
        "{\"at_ms\":1,\"boot\":-1}",
        "[1]",
        "{\"at_ms\":\"x\",\"boot\":1}",
    ] {
        assert_eq!(Line::read(0, text), None, "{text}");
    }
}

/// Times beyond a computer's lifetime are none.
#[test]
fn impossible_times_are_torn_lines() {
    let line = |at: &str, boot: &str| {
        Line::read(
            0,
            &format!("{{\"at_ms\":{at},\"boot\":{boot},\"experiment_ms\":1e300}}"),
        )
    };
    assert_eq!(line("1000000000000", "1").unwrap().experiment_ms, None);
    for (at, boot) in [
        ("1e13", "1"),
        ("-1e300", "1"),
        ("1e999", "1"),
        ("null", "1"),
        ("1", "4294967296"),
        ("1", "-1"),
    ] {
        assert_eq!(line(at, boot), None, "{at} {boot}");
    }
}
