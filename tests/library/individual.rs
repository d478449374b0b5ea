//! Surrogates of described robots: without differences the simulator's lives, to the bit; each difference changes what it should and
//! nothing else, by as much as it was drawn; and all devices agree.

use std::collections::BTreeSet;
use std::f64::consts::TAU;
use std::sync::Arc;

use oneiro::arena::{Arena, Light, Patch};
use oneiro::batch::{Record, Trace};
use oneiro::differential::{Differential, Response, Sensor, SensorKind};
use oneiro::surrogate::{Difference, Differences, Object, Surrogate};
use oneiro::tables::{MotorStates, MotorTable, SensorTables};
use oneiro::world::{Collision, Noise, Start, World, WorldSpec};

use crate::composed::Subject;
use crate::described::{ray, robot, sensor, spec, subject, traces};

const SEED: u64 = 5;
/// Distance between the wheels, mm, and their greatest speed, mm/s, as `described` has them.
const BASE: f64 = 60.0;
const SPEED: f64 = 200.0;

/// Sensors of each kind but sampled ones, among lights and on a floor with patches.
fn full(change: impl FnOnce(&mut WorldSpec, &mut Differential)) -> WorldSpec {
    spec(|spec, robot| {
        spec.arena.lights = vec![Light {
            x: 300.0,
            y: 550.0,
            brightness: 0.9,
            ..Light::default()
        }];
        spec.arena.floor = Some(0.7);
        spec.arena.patches = vec![Patch {
            x: 250.0,
            y: 200.0,
            radius: Some(150.0),
            grey: 0.4,
            ..Patch::default()
        }];
        robot.battery = Some(60.0);
        robot.sensors.extend([
            Sensor {
                offset: Some(20.0),
                ..sensor("lamp", SensorKind::Light, 0.1, 900.0)
            },
            Sensor {
                range: None,
                ..sensor("floor", SensorKind::Ground, 0.0, 0.0)
            },
            Sensor {
                range: None,
                ..sensor("energy", SensorKind::Battery, 0.0, 0.0)
            },
            Sensor {
                bearing: Some(0.3),
                ..sensor("aside", SensorKind::Proximity, 0.1, 120.0)
            },
            Sensor {
                response: Some(Response(vec![[0.0, 1.0], [20.0, 0.6], [100.0, 0.05]])),
                ..sensor("curved", SensorKind::Proximity, 0.4, 110.0)
            },
        ]);
        change(spec, robot);
    })
}

/// A robot with a Khepera's sampled sensors and motors, in its arena.
fn sampled(change: impl FnOnce(&mut WorldSpec, &mut Differential)) -> WorldSpec {
    spec(|spec, own| {
        spec.arena = Arena::miglino1995();
        spec.robot.sensors = SensorTables::khepera();
        spec.robot.motors = MotorTable::khepera(MotorStates::Evorobot21);
        spec.robot.collision = Collision::Undo;
        let sensors = ["a", "b", "c", "d"].map(|name| Sensor {
            range: None,
            ..sensor(name, SensorKind::Sampled, 0.0, 0.0)
        });
        *own = Differential {
            sensors: sensors.into(),
            ..Differential::sampled()
        };
        own.sensors.push(sensor("ahead", SensorKind::Proximity, 0.0, 60.0));
        change(spec, own);
    })
}

fn living_as(spec: &WorldSpec, differences: Differences) -> WorldSpec {
    WorldSpec {
        surrogate: Some(Arc::new(Surrogate::drawn(SEED, differences))),
        ..spec.clone()
    }
}

/// Worlds with each kind of sensor, drive and collision.
fn worlds() -> Vec<WorldSpec> {
    let collisions = [Collision::Undo, Collision::KeepTurn, Collision::Slide, Collision::Stick];
    let full_ones = collisions.map(|collision| {
        full(|spec, robot| {
            spec.robot.collision = collision;
            if collision == Collision::KeepTurn {
                (robot.acceleration, robot.latency, robot.speeds) = (Some(700.0), Some(2), 7);
            }
        })
    });
    let sampled_ones = [Collision::Undo, Collision::Slide].map(|collision| {
        sampled(|spec, robot| {
            spec.robot.collision = collision;
            robot.turn_before_move = (collision == Collision::Slide).then_some(0.5);
            robot.latency = (collision == Collision::Slide).then_some(1);
        })
    });
    [&full_ones[..], &sampled_ones].concat()
}

/// Episodes that are pinned ([`crate::composed`]).
pub(crate) fn subjects() -> Vec<Subject> {
    let subject = |(index, spec)| {
        let severity = [1.0, 1.75, 2.0][index % 3];
        subject(
            format!("world {index}, severity {severity}"),
            living_as(&spec, Differences::all(severity)),
        )
    };
    worlds().into_iter().enumerate().map(subject).collect()
}

#[test]
fn without_differences_lives_are_the_simulators() {
    for spec in worlds() {
        let own = traces(spec.clone(), 100);
        let moved = own.iter().filter(|trace| trace[0].x != trace[60].x).count();
        let collided: usize = own
            .iter()
            .map(|trace| trace.iter().filter(|r| r.collided > 0.0).count())
            .sum();
        assert!(moved > 60 && collided > 100, "{moved} {collided}");
        assert!(
            traces(living_as(&spec, Differences::all(0.0)), 100) == own,
            "{:?}",
            spec.robot.collision
        );
        assert!(
            traces(living_as(&spec, Differences::all(0.01)), 100) != own,
            "{:?}",
            spec.robot.collision
        );
    }
}

/// A sensor's reading in a line of a trace.
fn reading(details: &[u32], sensor: usize) -> f64 {
    f64::from(f32::from_bits(details[sensor]))
}

/// Names of the sensors that read something else in the first cycle of any life, and whether robots with the same commands get
/// elsewhere in it, or their sensors lag behind them.
fn changed(spec: &WorldSpec, difference: Difference) -> (BTreeSet<String>, bool, bool) {
    let sensors = spec.robot.described_sensors();
    let own = traces(spec.clone(), 120);
    let others = traces(living_as(spec, Differences::only(1.0, difference)), 120);
    let (mut names, mut moves, mut lags) = (BTreeSet::new(), false, false);
    for (own, other) in own.iter().zip(&others) {
        let [one, two] = [own, other].map(|trace| trace.lines().next().unwrap().1.to_vec());
        let differing = (0..sensors.len()).filter(|sensor| one[*sensor] != two[*sensor]);
        names.extend(differing.map(|sensor| sensors[sensor].name.clone()));
        if (own[0].left, own[0].right) == (other[0].left, other[0].right) {
            moves |= (own[1].x, own[1].y, own[1].heading) != (other[1].x, other[1].y, other[1].heading);
        }
        lags |= other
            .iter()
            .any(|record| (record.x, record.y) != (record.seen_x, record.seen_y));
    }
    (names, moves, lags)
}

/// What each difference changes, and that it changes nothing else.
#[test]
fn each_difference_changes_what_it_should() {
    let full = full(|spec, _| spec.robot.collision = Collision::Undo);
    let sampled = sampled(|_, _| ());
    for (difference, of_full, of_sampled, moves, lags) in [
        (
            Difference::Geometry,
            "ahead aside back curved floor lamp left right",
            "ahead",
            "",
            false,
        ),
        (
            Difference::Reflectivity,
            "ahead aside curved floor right",
            "ahead",
            "",
            false,
        ),
        (
            Difference::Illumination,
            "ahead aside curved lamp right",
            "a ahead b c d",
            "",
            false,
        ),
        (
            Difference::ReadNoise,
            "ahead aside back curved floor lamp left right",
            "a ahead b c d",
            "",
            false,
        ),
        (Difference::Latency, "", "", "", true),
        (Difference::MotorLag, "", "", "full sampled", false),
        (Difference::Wheels, "", "", "full sampled", false),
        (Difference::Arcs, "", "", "sampled", false),
        (Difference::Slip, "", "", "", false),
    ] {
        for (name, spec, expected) in [("full", &full, of_full), ("sampled", &sampled, of_sampled)] {
            if !spec.robot.differs_by(difference) {
                assert!(expected.is_empty() && !moves.contains(name));
                continue;
            }
            // Where nothing collides in the first cycle, slipping shows in none.
            let (names, moved, lagged) = changed(spec, difference);
            let found = names.into_iter().collect::<Vec<_>>().join(" ");
            let what = (difference, name);
            assert_eq!(found, expected, "{what:?}");
            if difference != Difference::Slip {
                assert_eq!(moved, moves.contains(name), "{what:?}");
            }
            assert_eq!(lagged, lags, "{what:?}");
        }
    }
}

/// A life's first line: the pose, and the readings.
fn first(trace: &Trace) -> (&Record, &[u32]) {
    trace.lines().next().unwrap()
}

/// Object that a ray meets in the described arena, by what its end is on.
fn object([x, y]: [f64; 2]) -> (Object, usize) {
    if (x - 180.0).hypot(y - 400.0) < 31.0 {
        return (Object::Obstacle, 0);
    }
    let distances = [y, 600.0 - x, 600.0 - y, x];
    match distances.iter().position(|distance| *distance < 0.5) {
        Some(wall) => (Object::Wall, wall),
        None => (Object::Block, 0),
    }
}

/// How much more light the surroundings have at a place.
fn gain(surrogate: &Surrogate, severity: f64, [x, y]: [f64; 2]) -> f64 {
    let wave = |wave: &oneiro::surrogate::Wave| {
        let [along_x, along_y] = wave.turns_per_mm;
        0.3 / 4.0 * (TAU * (along_x * x + along_y * y + wave.phase)).cos()
    };
    1.0 + severity * surrogate.surroundings.waves.iter().map(wave).sum::<f64>()
}

/// Proximity sensors see objects by the light that returns, which falls with the square of the distance; light adds to it, and
/// other sensors' readings follow by their own laws.
#[test]
fn readings_are_those_of_the_light_that_returns() {
    for severity in [0.5_f32, 2.0] {
        for difference in [Difference::Reflectivity, Difference::Illumination] {
            let spec = full(|_, _| ());
            let own = living_as(&spec, Differences::only(severity, difference));
            let surrogate = own.surrogate.clone().unwrap();
            let (mut compared, mut beyond) = (0, 0);
            for trace in traces(own, 600) {
                let (record, details) = first(&trace);
                let [x, y] = [record.x, record.y].map(f64::from);
                let light = if difference == Difference::Illumination {
                    gain(&surrogate, severity.into(), [x, y])
                } else {
                    1.0
                };
                let ambient = if difference == Difference::Illumination {
                    f64::from(severity) * surrogate.surroundings.ambient
                } else {
                    0.0
                };
                // The proximity sensors `ahead` and `right`.
                for (sensor, heading, range) in [(0, 0.0, 100.0), (4, -0.2, 80.0)] {
                    let angle = TAU * (f64::from(record.heading) + heading);
                    let at = [x + 40.0 * angle.cos(), y + 40.0 * angle.sin()];
                    let distance = ray(at, angle, 2.5 * range);
                    let returned = if difference == Difference::Reflectivity && distance < 2.5 * range {
                        let (kind, index) = object([at[0] + distance * angle.cos(), at[1] + distance * angle.sin()]);
                        1.0 + f64::from(severity) * (surrogate.surroundings.reflectivity(kind, index) - 1.0)
                    } else {
                        light
                    };
                    let seeming = distance / returned.sqrt();
                    let expected = ((1.0 - seeming / range).max(0.0) + ambient).clamp(0.0, 1.0);
                    let found = reading(details, sensor);
                    assert!(
                        (found - expected).abs() < 2e-3,
                        "{difference:?} {found} {expected} {record:?}"
                    );
                    compared += 1;
                    beyond += u32::from(distance > range && found > ambient + 1e-3);
                }
                if difference == Difference::Reflectivity {
                    let on_patch = (x + 40.0 * (TAU * f64::from(record.heading)).cos() - 250.0)
                        .hypot(y + 40.0 * (TAU * f64::from(record.heading)).sin() - 200.0);
                    let (grey, index) = if on_patch < 150.0 { (0.4, 1) } else { (0.7, 0) };
                    let share = surrogate.surroundings.reflectivity(Object::Floor, index) - 1.0;
                    let expected = (grey * (1.0 + f64::from(severity) * share)).min(1.0);
                    let found = reading(details, 6);
                    assert!(
                        (found - expected).abs() < 1e-5 || (on_patch - 150.0).abs() < 0.01,
                        "{found} {expected}"
                    );
                }
            }
            assert!(
                compared == 1200 && beyond > 2,
                "{difference:?} {severity}: {compared} {beyond}"
            );
        }
    }
}

/// Noise has the spread that it is drawn with, alone and in proportion.
#[test]
fn noise_of_reading_has_its_spread() {
    let spec = full(|spec, _| {
        spec.start = Start::At {
            x: 530.0,
            y: 85.0,
            heading: 0.02,
        };
        spec.cycles = 1;
    });
    let [own, noisy] = [0.0, 1.0].map(|severity| living_as(&spec, Differences::only(severity, Difference::ReadNoise)));
    let [own, noisy] = [traces(own, 1), traces(noisy, 4000)];
    for sensor in [0, 4, 6] {
        let mean = reading(first(&own[0]).1, sensor);
        let off: Vec<f64> = noisy
            .iter()
            .map(|trace| reading(first(trace).1, sensor) - mean)
            .collect();
        let spread = (off.iter().map(|off| off * off).sum::<f64>() / off.len() as f64).sqrt();
        let expected = 3.4 / 1023.0 + 0.03 * mean;
        assert!((0.1..0.9).contains(&mean), "{sensor}: {mean}");
        assert!((spread / expected - 1.0).abs() < 0.05, "{sensor}: {spread} {expected}");
    }
}

/// Wheels in double precision: what is left of their own motion, and how unlike they are.
#[test]
fn wheels_lag_and_differ() {
    for (difference, severity) in [
        (Difference::MotorLag, 1.0_f32),
        (Difference::MotorLag, 0.3),
        (Difference::Wheels, 2.0),
    ] {
        let spec = full(|spec, _| {
            spec.arena.walls.clear();
            spec.arena.blocks.clear();
            spec.arena.obstacles.clear();
        });
        let own = living_as(&spec, Differences::only(severity, difference));
        let wheels = own.surrogate.as_ref().unwrap().individual.wheels;
        let lag = f64::from(severity) / (1.0 + f64::from(severity));
        let mut compared = 0;
        for trace in traces(own, 40) {
            let mut speeds = [0.0; 2];
            for pair in trace.windows(2) {
                let [now, next] = [&pair[0], &pair[1]];
                let goals = [now.left, now.right].map(|output| SPEED * (2.0 * f64::from(output) - 1.0));
                let mut ways = [0.0; 2];
                for wheel in 0..2 {
                    if difference == Difference::MotorLag {
                        for _ in 0..5 {
                            speeds[wheel] = goals[wheel] + lag * (speeds[wheel] - goals[wheel]);
                            ways[wheel] += 0.02 * speeds[wheel];
                        }
                    } else {
                        ways[wheel] = 0.1 * goals[wheel] * (1.0 + f64::from(severity) * wheels[wheel]);
                    }
                }
                let turn = (ways[1] - ways[0]) / BASE;
                let half = 0.5 * turn;
                let chord = 0.5 * (ways[0] + ways[1]) * if half.abs() < 1e-9 { 1.0 } else { half.sin() / half };
                let ahead = TAU * f64::from(now.heading) + half;
                let end = [
                    f64::from(now.x) + chord * ahead.cos(),
                    f64::from(now.y) + chord * ahead.sin(),
                ];
                let off = (f64::from(next.x) - end[0]).hypot(f64::from(next.y) - end[1]);
                assert!(off < 2e-3, "{difference:?} {off} {now:?} {next:?}");
                let turned = f64::from(next.heading) - f64::from(now.heading) - turn / TAU;
                assert!((turned - turned.round()).abs() < 1e-5, "{turned} {now:?}");
                compared += 1;
            }
        }
        assert!(compared > 5000, "{compared}");
    }
}

/// Readings are 20 to 40 ms old at severity 1, and those of the place where the robot then was.
#[test]
fn readings_are_late() {
    let spec = full(|_, _| ());
    let mut ages = Vec::new();
    for trace in traces(living_as(&spec, Differences::only(1.0, Difference::Latency)), 60) {
        assert_eq!((trace[0].x, trace[0].y), (trace[0].seen_x, trace[0].seen_y));
        for pair in trace.windows(2) {
            let [before, now] = [&pair[0], &pair[1]];
            let [way, behind] = [(before.x, before.y), (now.seen_x, now.seen_y)]
                .map(|(x, y)| f64::from(now.x - x).hypot(f64::from(now.y - y)));
            if way > 2.0 {
                ages.push(behind / way);
            }
        }
    }
    let [least, most] = [f64::min, f64::max].map(|of| ages.iter().copied().fold(0.3, of));
    assert!(
        ages.len() > 2000 && least > 0.199 && most < 0.401,
        "{} {least} {most}",
        ages.len()
    );
    assert!(least < 0.202 && most > 0.398, "{least} {most}");
}

/// A stopped robot does half of sliding and turning, where the simulator undoes both or the move.
#[test]
fn stopped_robots_slip() {
    for collision in [Collision::Undo, Collision::KeepTurn] {
        let spec = full(|spec, _| spec.robot.collision = collision);
        let of = |severity| traces(living_as(&spec, Differences::only(severity, Difference::Slip)), 100);
        let (mut compared, mut slid) = (0, 0);
        for trace in of(1.0) {
            for pair in trace.windows(2).filter(|pair| pair[0].collided > 0.0) {
                let [now, next] = [&pair[0], &pair[1]];
                let turn = 0.1 * SPEED * f64::from(now.speed_right - now.speed_left) / BASE / TAU;
                let share = if collision == Collision::Undo { 0.5 } else { 1.0 };
                let turned = f64::from(next.heading) - f64::from(now.heading) - share * turn;
                assert!((turned - turned.round()).abs() < 1e-5, "{turned} {now:?} {next:?}");
                let way = f64::from(next.x - now.x).hypot(f64::from(next.y - now.y));
                // No farther than half of the whole way.
                let whole = 0.05 * SPEED * f64::from(now.speed_left + now.speed_right).abs();
                assert!(way <= 0.5 * whole + 0.01, "{way} {whole}");
                compared += 1;
                slid += usize::from(way > 0.2);
            }
        }
        assert!(compared > 500 && slid > 100, "{compared} {slid}");
        // Nothing else has changed until a robot is stopped.
        for (one, other) in of(0.0).iter().zip(&of(1.0)) {
            let free = one
                .iter()
                .position(|record| record.collided > 0.0)
                .unwrap_or(one.len() - 1);
            assert!(one[..=free] == other[..=free]);
        }
    }
}

/// A robot's differences are those of its seed, and the same in each life.
#[test]
fn sensors_differ_by_seed() {
    let spec = full(|spec, _| {
        spec.start = Start::At {
            x: 530.0,
            y: 100.0,
            heading: 0.02,
        };
        spec.cycles = 1;
    });
    let of = |seed| {
        let mut own = spec.clone();
        own.surrogate = Some(Arc::new(Surrogate::drawn(
            seed,
            Differences::only(1.0, Difference::Geometry),
        )));
        let all: BTreeSet<Vec<u32>> = traces(own, 10).iter().map(|trace| first(trace).1.to_vec()).collect();
        assert_eq!(all.len(), 1);
        all
    };
    let seeds: BTreeSet<_> = (0..50).map(of).collect();
    assert_eq!(seeds.len(), 50);
    // A wall 30 mm before a sensor of 100 mm seems up to 18.7 % nearer or farther, and more where the sensor looks aside.
    let ahead: Vec<f64> = seeds.iter().map(|own| reading(own.iter().next().unwrap(), 0)).collect();
    let [least, most] = [f64::min, f64::max].map(|of| ahead.iter().copied().fold(0.7, of));
    assert!(
        (0.62..0.66).contains(&least) && (0.73..0.76).contains(&most),
        "{least} {most}"
    );
}

#[test]
fn what_changes_nothing_is_refused() {
    let refused = |spec: &WorldSpec, difference| {
        World::new(living_as(spec, Differences::only(1.0, difference)))
            .unwrap_err()
            .to_string()
    };
    let bare = spec(|_, own| own.sensors = vec![robot().sensors[3].clone()]);
    assert_eq!(
        refused(&bare, Difference::Arcs),
        "surrogate.differences: are arcs, which have no effect on this robot; allowed with one of latency, motor_lag, \
         wheels"
    );
    for difference in [Difference::Geometry, Difference::Illumination, Difference::Slip] {
        assert!(refused(&bare, difference).contains(difference.name()));
    }
    let noisy = WorldSpec {
        noise: Noise::SENSOR,
        ..living_as(&bare, Differences::all(1.0))
    };
    assert!(World::new(noisy).unwrap_err().to_string().starts_with("noise: "));
    assert!(World::new(living_as(&bare, Differences::all(1.0))).is_ok());
}
