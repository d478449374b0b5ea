//! How described robots drive and what keeps them going: acceleration and latency, batteries and what charges them, and where
//! their sensors are, against simulations in double precision.

use std::collections::VecDeque;
use std::f64::consts::TAU;
use std::sync::Arc;

use oneiro::arena::{Arena, Patch};
use oneiro::batch::{Record, Trace};
use oneiro::differential::{Differential, Response, Sensor, SensorKind};
use oneiro::random::pcg4d;
use oneiro::tables::{MotorCell, MotorTable};
use oneiro::world::{Collision, Noise, World, WorldSpec};

use crate::composed::Subject;
use crate::described::{ray, sensor, spec, subject, traces};

/// Distance between the wheels, mm, and their greatest speed, mm/s.
const BASE: f64 = 60.0;
const SPEED: f64 = 200.0;

/// A robot in the open whose commands change in each cycle, because its sensors read nothing but noise.
fn restless(change: impl FnOnce(&mut WorldSpec, &mut Differential)) -> WorldSpec {
    spec(|spec, robot| {
        spec.arena = Arena {
            walls: Vec::new(),
            ..Arena::rectangle(600.0, 600.0)
        };
        spec.noise.sensor = (-0.9, 0.9);
        change(spec, robot);
    })
}

/// Wheels that are simulated by 200 small steps a cycle.
struct Wheels {
    acceleration: f64,
    /// Commanded speeds that are yet to take effect, mm/s.
    commands: VecDeque<[f64; 2]>,
    /// Speeds, mm/s.
    speeds: [f64; 2],
}

impl Wheels {
    const STEPS: u32 = 200;

    fn new(acceleration: Option<f32>, latency: Option<u32>) -> Self {
        Self {
            acceleration: acceleration
                .filter(|acceleration| *acceleration > 0.0)
                .map_or(f64::INFINITY, f64::from),
            commands: vec![[0.0; 2]; latency.unwrap_or(0) as usize].into(),
            speeds: [0.0; 2],
        }
    }

    /// Drives a cycle: the pose that it leads to from another (mm and radians), and the mean speeds in it, mm/s.
    fn cycle(&mut self, outputs: [f32; 2], [mut x, mut y, mut heading]: [f64; 3]) -> ([f64; 3], [f64; 2]) {
        let step = 0.1 / f64::from(Self::STEPS);
        let change = self.acceleration * step;
        self.commands
            .push_back(outputs.map(|output| SPEED * (2.0 * f64::from(output) - 1.0)));
        let goals = self.commands.pop_front().unwrap();
        let mut travelled = [0.0; 2];
        for _ in 0..Self::STEPS {
            let before = self.speeds;
            for (speed, goal) in self.speeds.iter_mut().zip(goals) {
                *speed += (goal - *speed).clamp(-change, change);
            }
            // An infinite acceleration takes no time.
            let share = if change.is_finite() { 0.5 } else { 0.0 };
            let mean = |wheel: usize| share * before[wheel] + (1.0 - share) * self.speeds[wheel];
            let [left, right] = [mean(0) * step, mean(1) * step];
            let turn = (right - left) / BASE;
            x += 0.5 * (left + right) * (heading + 0.5 * turn).cos();
            y += 0.5 * (left + right) * (heading + 0.5 * turn).sin();
            heading += turn;
            travelled = [travelled[0] + left, travelled[1] + right];
        }
        ([x, y, heading], travelled.map(|way| 10.0 * way))
    }
}

fn pose(record: &Record) -> [f64; 3] {
    [record.x.into(), record.y.into(), f64::from(record.heading) * TAU]
}

/// Difference of two headings, radians.
fn apart(one: f64, other: f64) -> f64 {
    let turns = (one - other) / TAU;
    TAU * (turns - turns.round()).abs()
}

/// Each cycle, and each life as a whole, goes where wheels roll that change their speed evenly and hear commands late.
///
/// A cycle is one arc, on which the body goes evenly. On the true way its speed changes by up to `a T`, and its rate of turning
/// by up to `2 a T / b`, which leads aside by up to `a T^2 turn / 12 + 2 a T^2 way / (8 b)`.
#[test]
fn wheels_accelerate_and_hear_late() {
    for (acceleration, latency) in [
        (Some(300.0), None),
        (Some(2000.0), Some(0)),
        (Some(9000.0), Some(1)),
        (Some(0.0), Some(8)),
        (None, Some(3)),
        (Some(700.0), Some(2)),
    ] {
        let world = restless(|_, robot| {
            (robot.acceleration, robot.latency) = (acceleration, latency);
        });
        let change = f64::from(acceleration.unwrap_or(0.0)) * 0.1;
        let (mut changes, mut farthest) = (0, 0.0_f64);
        for trace in traces(world, 40) {
            let mut wheels = Wheels::new(acceleration, latency);
            let mut whole = Wheels::new(acceleration, latency);
            let mut there = pose(&trace[0]);
            for pair in trace.windows(2) {
                let [now, next] = [&pair[0], &pair[1]];
                let outputs = [now.left, now.right];
                let before = wheels.speeds;
                let (end, means) = wheels.cycle(outputs, pose(now));
                for (found, mean) in [now.speed_left, now.speed_right].into_iter().zip(means) {
                    // Single precision, and a share of the greatest change for the small steps.
                    let off = (SPEED * f64::from(found) - mean).abs();
                    assert!(off < 5e-5 + 5e-3 * change.min(2.0 * SPEED), "{now:?} {means:?}");
                }
                let (way, turn) = (0.1 * means[0].abs().max(means[1].abs()), apart(end[2], pose(now)[2]));
                let bound = 2e-3 + 0.1 * change * turn / 12.0 + 0.2 * change * way / (8.0 * BASE);
                let off = (f64::from(next.x) - end[0]).hypot(f64::from(next.y) - end[1]);
                assert!(off < bound, "{acceleration:?} {latency:?} {off} {bound} {now:?}");
                assert!(apart(pose(next)[2], end[2]) < 2e-4, "{now:?} {end:?}");
                changes += u32::from(before != wheels.speeds);
                (there, _) = whole.cycle(outputs, there);
            }
            let last = trace.last().unwrap();
            assert!(apart(pose(last)[2], there[2]) < 5e-3, "{last:?} {there:?}");
            farthest = farthest.max((f64::from(last.x) - there[0]).hypot(f64::from(last.y) - there[1]));
        }
        println!("{acceleration:?} {latency:?}: {changes} changes, after 150 cycles up to {farthest:.3} mm apart");
        assert!(changes > 3000, "{changes}");
        assert!(farthest < if change > 0.0 { 4.0 } else { 0.02 }, "{farthest}");
    }
}

/// Until the first command arrives wheels stand still, even if none of their speeds is 0; then each has its effect, exactly.
#[test]
fn commands_arrive_in_order_and_on_time() {
    for latency in 1..=8 {
        let world = restless(|_, robot| (robot.latency, robot.speeds) = (Some(latency), 4));
        for trace in traces(world, 20) {
            for (cycle, record) in trace.iter().enumerate() {
                let speed = |output: f32| 2.0 * (3.0 * output + 0.5).floor() / 3.0 - 1.0;
                let due = cycle.checked_sub(latency as usize).map(|then| &trace[then]);
                let [left, right] = due.map_or([0.0; 2], |then| [then.left, then.right].map(speed));
                assert!((record.speed_left - left).abs() < 1e-6, "{cycle} {record:?}");
                assert!((record.speed_right - right).abs() < 1e-6, "{cycle} {record:?}");
            }
            assert_eq!(
                (trace[0].x, trace[0].y),
                (trace[latency as usize].x, trace[latency as usize].y)
            );
        }
    }
}

/// The slowest wheels gain as much in each cycle; the quickest are at full speed after a 500th of one.
#[test]
fn slow_and_quick_wheels_get_where_they_are_commanded() {
    for (acceleration, latency) in [(1.0, 0), (1e6, 0), (1e6, 8)] {
        let world = restless(|_, robot| {
            (robot.acceleration, robot.latency, robot.speeds) = (Some(acceleration), Some(latency), 2);
        });
        for trace in traces(world, 20) {
            let first = trace[latency as usize].speed_left.abs();
            if acceleration == 1.0 {
                // By 0.1 mm/s of 200, of which the mean is half.
                assert!((first - 0.00025).abs() < 1e-9, "{first}");
            } else {
                assert!((first - 0.999).abs() < 1e-6, "{first}");
            }
        }
    }
}

/// Shares of full speed that sampled motors have: uneven, and none is 0.
const SHARES: [f64; 7] = [-1.0, -0.7, -0.25, -0.1, 0.2, 0.45, 1.0];
const STATES: usize = SHARES.len();

/// Sampled motors of that many states. They bend: each pair of states goes and turns up to 20 % farther or less far than wheels
/// would that don't slip.
fn bent() -> MotorTable {
    let cell = |at: usize| {
        let [left, right] = [SHARES[at / STATES], SHARES[at % STATES]];
        let [way, turn, ..] = pcg4d([at as u32, 3, 0, 0]).map(|word| 0.8 + 0.4 * f64::from(word) / 4_294_967_296.0);
        // A cycle at full speed is measured exactly.
        let way = if left * right == 1.0 { 1.0 } else { way };
        MotorCell {
            displacement: (0.05 * SPEED * (left + right) * way) as f32,
            turn: (0.1 * SPEED * (right - left) / BASE / TAU * turn) as f32,
            left: left as f32,
            right: right as f32,
        }
    };
    MotorTable {
        states: STATES as u32,
        cells: (0..STATES * STATES).map(cell).collect(),
        scale: STATES as f32,
        offset: 0.0,
    }
}

/// Displacement and turn at speeds between those of the states, on the twisted plane through the four pairs around them.
fn between(motors: &MotorTable, speeds: [f64; 2]) -> [f64; 2] {
    let place = speeds.map(|speed| {
        let below = (0..STATES - 1).rev().find(|state| SHARES[*state] <= speed).unwrap_or(0);
        (below, (speed - SHARES[below]) / (SHARES[below + 1] - SHARES[below]))
    });
    let mut sum = [0.0; 2];
    for corner in 0..4 {
        let at = [corner / 2, corner % 2];
        let [left, right] = [0, 1].map(|wheel| place[wheel].0 + at[wheel]);
        let [a, b] = [0, 1].map(|wheel| {
            if at[wheel] == 1 {
                place[wheel].1
            } else {
                1.0 - place[wheel].1
            }
        });
        let cell = &motors.cells[left * STATES + right];
        sum[0] += a * b * f64::from(cell.displacement);
        sum[1] += a * b * f64::from(cell.turn);
    }
    sum
}

/// Sampled motors hear late, change their speeds evenly, and move as their samples say between the speeds that were sampled.
#[test]
fn sampled_motors_accelerate_and_hear_late() {
    let motors = bent();
    assert_eq!(motors.full_speed(), Some(SPEED as f32));
    for (acceleration, latency) in [
        (Some(300.0), None),
        (Some(2000.0), Some(1)),
        (None, Some(3)),
        (Some(0.0), Some(8)),
        (Some(1e6), None),
        (Some(700.0), Some(2)),
    ] {
        let world = restless(|spec, robot| {
            spec.robot.motors = Arc::new(motors.clone());
            spec.robot.collision = Collision::Undo;
            *robot = Differential {
                sensors: robot.sensors.clone(),
                acceleration,
                latency,
                turn_before_move: Some(0.5),
                ..Differential::sampled()
            };
        });
        let late = latency.unwrap_or(0) as usize;
        let change = acceleration.filter(|acceleration| *acceleration > 0.0);
        let change = change.map_or(f64::INFINITY, |acceleration| 0.1 * f64::from(acceleration) / SPEED);
        let (mut between_states, mut uneven) = (0, 0.0_f64);
        for trace in traces(world, 40) {
            let mut speeds = [0.0; 2];
            for (cycle, pair) in trace.windows(2).enumerate() {
                let [now, next] = [&pair[0], &pair[1]];
                let due = cycle
                    .checked_sub(late)
                    .map(|then| [trace[then].left, trace[then].right]);
                let mut means = [0.0; 2];
                let mut each = [0.0; 2];
                if let Some(due) = due {
                    let goals = due.map(|output| SHARES[((output * STATES as f32) as usize).min(STATES - 1)]);
                    for _ in 0..Wheels::STEPS {
                        let step = change / f64::from(Wheels::STEPS);
                        let before = speeds;
                        for (speed, goal) in speeds.iter_mut().zip(goals) {
                            *speed += (goal - *speed).clamp(-step, step);
                        }
                        let now = if step.is_finite() {
                            [0, 1].map(|wheel| 0.5 * (before[wheel] + speeds[wheel]))
                        } else {
                            speeds
                        };
                        let moved = between(&motors, now);
                        for axis in 0..2 {
                            means[axis] += now[axis] / f64::from(Wheels::STEPS);
                            each[axis] += moved[axis] / f64::from(Wheels::STEPS);
                        }
                    }
                }
                // The kernel's mean speeds are exact, those of small steps nearly.
                for (found, mean) in [now.speed_left, now.speed_right].into_iter().zip(means) {
                    assert!(
                        (f64::from(found) - mean).abs() < 1e-6 + 5e-3 * change.min(2.0),
                        "{now:?} {means:?}"
                    );
                }
                let own = [now.speed_left, now.speed_right].map(f64::from);
                let [way, turn] = if due.is_some() { between(&motors, own) } else { [0.0; 2] };
                let ahead = pose(now)[2] + 0.5 * TAU * turn;
                if now.collided == 0.0 {
                    let end = [
                        f64::from(now.x) + way * ahead.cos(),
                        f64::from(now.y) + way * ahead.sin(),
                    ];
                    let off = (f64::from(next.x) - end[0]).hypot(f64::from(next.y) - end[1]);
                    assert!(off < 1e-3, "{acceleration:?} {latency:?} {off} {now:?} {next:?}");
                    assert!(
                        apart(pose(next)[2], pose(now)[2] + TAU * turn) < 1e-5,
                        "{now:?} {next:?}"
                    );
                }
                uneven = uneven.max((way - each[0]).abs());
                let is_of_state = |speed: &f64| SHARES.iter().any(|share| (share - speed).abs() < 1e-6);
                between_states += usize::from(!own.iter().all(is_of_state));
            }
        }
        println!("{acceleration:?} {latency:?}: {between_states} cycles between states, up to {uneven:.3} mm apart");
        // At rest, before the first command, a wheel is between states, too.
        assert_eq!(between_states > 3000, change.is_finite(), "{between_states}");
        assert!(uneven < if change.is_finite() { 2.5 } else { 1e-4 }, "{uneven}");
    }
}

/// Motors sampled of wheels that don't slip accelerate as those wheels.
#[test]
fn straight_samples_accelerate_as_wheels_do() {
    let speeds: Vec<i32> = (-10..=10).collect();
    let share = |speed: i32| (f64::from(speed) / 10.0) as f32;
    let pairs = speeds
        .iter()
        .flat_map(|left| speeds.iter().map(move |right| (*left, *right)));
    let cell = |(left, right): (i32, i32)| MotorCell {
        displacement: (0.005 * SPEED * f64::from(left + right)) as f32,
        turn: (0.01 * SPEED * f64::from(right - left) / BASE / TAU) as f32,
        left: share(left),
        right: share(right),
    };
    let motors = Arc::new(MotorTable {
        states: 21,
        cells: pairs.map(cell).collect(),
        scale: 20.0,
        offset: 0.5,
    });
    let slow = |own: Differential| {
        restless(|spec, robot| {
            spec.robot.motors = Arc::clone(&motors);
            // Nothing is near, so that only a cycle's speeds tell robots apart.
            spec.noise.sensor = (0.0, 0.9);
            *robot = Differential {
                sensors: Vec::new(),
                acceleration: Some(450.0),
                latency: Some(1),
                ..own
            };
            robot
                .sensors
                .extend((0..4).map(|index| sensor(&format!("s{index}"), SensorKind::Proximity, 0.0, 0.01)));
        })
    };
    let sampled = traces(slow(Differential::sampled()), 40);
    let described = traces(
        slow(Differential {
            speeds: 21,
            ..Differential::new(BASE as f32, SPEED as f32)
        }),
        40,
    );
    let mut compared = 0;
    for (sampled, described) in sampled.iter().zip(&described) {
        for (one, other) in sampled.iter().zip(described.iter()) {
            assert_eq!((one.left, one.right), (other.left, other.right));
            assert!((one.speed_left - other.speed_left).abs() < 2e-6, "{one:?} {other:?}");
            assert!((one.speed_right - other.speed_right).abs() < 2e-6, "{one:?} {other:?}");
            compared += 1;
        }
        // Collisions depend on the way within a cycle, the heading does not.
        let [one, other] = [sampled, described].map(|trace| trace.last().unwrap());
        assert!(apart(pose(one)[2], pose(other)[2]) < 1e-3, "{one:?} {other:?}");
    }
    assert_eq!(compared, 40 * 150);
}

/// A world with a battery of 5 s, and three patches of which two charge it.
fn charged(change: impl FnOnce(&mut WorldSpec, &mut Differential)) -> WorldSpec {
    spec(|spec, robot| {
        robot.battery = Some(5.0);
        robot.sensors.push(Sensor {
            range: None,
            ..sensor("energy", SensorKind::Battery, 0.0, 0.0)
        });
        let patch = Patch {
            x: 300.0,
            y: 200.0,
            ..Patch::default()
        };
        spec.arena.patches = vec![
            Patch {
                radius: Some(60.0),
                charges: Some(true),
                ..patch.clone()
            },
            Patch {
                x: 450.0,
                radius: Some(80.0),
                charges: Some(false),
                ..patch.clone()
            },
            Patch {
                y: 500.0,
                sides: Some([300.0, 80.0]),
                heading: 0.15,
                charges: Some(true),
                ..patch
            },
        ];
        change(spec, robot);
    })
}

/// How far a place is outside of the patches that charge, mm; less than 0 within.
fn outside([x, y]: [f64; 2]) -> f64 {
    let (sine, cosine) = (0.15 * TAU).sin_cos();
    let along = (x - 300.0) * cosine + (y - 500.0) * sine;
    let across = (y - 500.0) * cosine - (x - 300.0) * sine;
    let disc = (x - 300.0).hypot(y - 200.0) - 60.0;
    disc.min((along.abs() - 150.0).max(across.abs() - 40.0))
}

/// The readings of a detail's word, in the order of a trace.
fn readings(trace: &Trace, detail: usize) -> Vec<f64> {
    let words = trace.lines().map(|(_, details)| details[detail]);
    words.map(|word| f64::from(f32::from_bits(word))).collect()
}

/// A battery falls by a 50th in each cycle and no further than to 0, is full on a patch that charges, and noise is added to its
/// reading as to others. By itself it ends no life.
#[test]
fn a_battery_empties_and_is_charged() {
    let world = charged(|spec, _| spec.noise.sensor = (-0.1, 0.1));
    let (mut charges, mut empty, mut noisy) = (0, 0, 0);
    for trace in traces(world, 200) {
        assert_eq!(trace.len(), 150);
        let (perceived, real) = (readings(&trace, 5), readings(&trace, 11));
        let mut used = 0_u32;
        for (cycle, record) in trace.iter().enumerate() {
            let place = outside([record.x.into(), record.y.into()]);
            if cycle > 0 && place.abs() < 1e-3 {
                // At the edge either may be right.
                used = if real[cycle] == 1.0 { 0 } else { used };
            } else if cycle > 0 && place < 0.0 {
                charges += u32::from(used > 5);
                used = 0;
            }
            let expected = (1.0 - f64::from(used) / 50.0).max(0.0);
            assert!(
                (real[cycle] - expected).abs() < 1e-6,
                "{cycle} {record:?} {} {expected}",
                real[cycle]
            );
            assert_eq!(real[cycle] == 0.0, used >= 50);
            assert!((perceived[cycle] - real[cycle]).abs() <= 0.1 + 1e-6);
            empty += u32::from(used >= 50);
            noisy += u32::from(perceived[cycle] != real[cycle]);
            used += 1;
        }
    }
    assert!(
        charges > 50 && empty > 1000 && noisy > 20_000,
        "{charges} {empty} {noisy}"
    );
}

/// Where an empty battery ends life, a life is as long as the battery lasts since it was charged last, and its fitness is what it
/// has earned by then. Before its end it is the same life.
#[test]
fn an_empty_battery_ends_life() {
    let long = traces(charged(|_, _| ()), 200);
    let short = traces(charged(|_, robot| robot.battery_ends_life = Some(true)), 200);
    let (mut ended, mut saved) = (0, 0);
    for (long, short) in long.iter().zip(&short) {
        let end = readings(long, 11)
            .iter()
            .position(|reading| *reading == 0.0)
            .unwrap_or(150);
        assert_eq!(short.len(), end);
        assert!(long.iter().zip(short.iter()).all(|(long, short)| long == short));
        assert!(end >= 50, "{end}");
        ended += u32::from(end < 150);
        saved += u32::from(end > 50);
    }
    assert!(ended > 50 && saved > 10, "{ended} {saved}");
}

/// A robot that arrives at the charger with its last charge lives on.
#[test]
fn the_last_charge_is_enough() {
    // Straight ahead at 20 mm a cycle from 25 mm before the edge of a patch: on it after the second cycle.
    let arrives = |seconds: f32, distance: f32| {
        let mut world = charged(|spec, robot| {
            robot.battery = Some(seconds);
            robot.battery_ends_life = Some(true);
            robot.speeds = 2;
            spec.start = oneiro::world::Start::At {
                x: 300.0 - 60.0 - distance,
                y: 200.0,
                heading: 0.0,
            };
        });
        world.cycles = 4;
        traces(world, 100)
            .iter()
            .filter(|trace| trace[0].speed_left == 1.0 && trace[0].speed_right == 1.0)
            .map(|trace| trace.len())
            .max()
            .unwrap()
    };
    assert_eq!(arrives(0.2, 25.0), 4);
    assert_eq!(arrives(0.1, 25.0), 1);
    assert_eq!(arrives(0.2, 45.0), 2);
}

/// Sensors look where they look from where they are.
#[test]
fn sensors_look_from_their_bearings() {
    let looking = |kind, index: usize, [heading, bearing, offset]: [f32; 3]| Sensor {
        bearing: Some(bearing),
        offset: Some(offset),
        ..sensor(["one", "two", "three"][index], kind, heading, 150.0)
    };
    let turned = [[0.5, 0.375, 38.0], [0.0, 0.2, 40.0], [-0.3, 0.9, 12.0]];
    let world = spec(|_, robot| {
        robot.sensors = vec![
            looking(SensorKind::Distance, 0, turned[0]),
            looking(SensorKind::Distance, 1, turned[1]),
            looking(SensorKind::Proximity, 2, turned[2]),
        ];
    });
    let (mut seen, mut wrong) = ([0; 3], 0);
    for trace in traces(world, 60) {
        for (record, details) in trace.lines().step_by(7) {
            for (index, [heading, bearing, offset]) in
                turned.map(|turned| turned.map(f64::from)).into_iter().enumerate()
            {
                let [x, y, angle] = pose(record);
                let at = angle + bearing * TAU;
                let measured = ray(
                    [x + offset * at.cos(), y + offset * at.sin()],
                    angle + heading * TAU,
                    150.0,
                ) / 150.0;
                let expected = if index == 2 { 1.0 - measured } else { measured };
                let found = f64::from(f32::from_bits(details[3 + index]));
                // At an edge a ray hits or misses.
                wrong += u32::from((found - expected).abs() > 2e-3);
                seen[index] += u32::from(found > 0.0 && found < 1.0);
            }
        }
    }
    assert!(seen.iter().all(|seen| *seen > 200) && wrong <= 5, "{seen:?} {wrong}");
}

/// A sensor farther out than the body's rim may be beyond a wall, which it then touches, wherever it looks.
#[test]
fn no_sensor_sees_through_what_is_between_it_and_the_body() {
    let far = |name, kind, bearing, heading| Sensor {
        bearing,
        offset: Some(90.0),
        ..sensor(name, kind, heading, 150.0)
    };
    let world = spec(|_, robot| {
        robot.sensors = vec![
            far("plain", SensorKind::Distance, None, 0.2),
            far("same", SensorKind::Distance, Some(0.2), 0.2),
            far("aside", SensorKind::Proximity, Some(0.2), 0.45),
            Sensor {
                response: Some(Response(vec![[0.0, 0.75], [100.0, 0.25]])),
                ..far("curve", SensorKind::Proximity, Some(0.2), 0.45)
            },
        ];
    });
    let (mut behind, mut free, mut wrong) = (0, 0, 0);
    for trace in traces(world, 60) {
        for (record, details) in trace.lines().step_by(7) {
            let [plain, same, aside, curve] = [0, 1, 2, 3].map(|index| f64::from(f32::from_bits(details[4 + index])));
            let [x, y, angle] = pose(record);
            let at = angle + 0.2 * TAU;
            let is_behind = ray([x, y], at, 90.0) < 90.0;
            let looks = ray([x + 90.0 * at.cos(), y + 90.0 * at.sin()], angle + 0.45 * TAU, 150.0);
            let expected = if is_behind { 1.0 } else { 1.0 - looks / 150.0 };
            behind += u32::from(is_behind);
            free += u32::from(!is_behind && aside > 0.0);
            let is_right = (plain - same).abs() < 1e-4
                && (aside - expected).abs() < 2e-3
                && (!is_behind || (same, curve) == (0.0, 0.75));
            // At an edge a ray hits or misses.
            wrong += u32::from(!is_right);
        }
    }
    assert!(behind > 100 && free > 100 && wrong <= 3, "{behind} {free} {wrong}");
}

/// A response is read between its points, beyond them, and not beyond the range; two sensors may share one.
#[test]
fn responses_are_lines_between_points() {
    let points = [[5.0, 0.9], [10.0, 1.0], [40.0, 0.25], [80.0, 0.2]];
    let curve = |name: &str, points: &[[f32; 2]], range| Sensor {
        response: Some(Response(points.into())),
        ..sensor(name, SensorKind::Proximity, 0.0, range)
    };
    let line = [[0.0, 1.0], [100.0, 0.0]];
    let world = spec(|_, robot| {
        robot.sensors = vec![
            curve("curve", &points, 100.0),
            curve("line", &line, 100.0),
            sensor("linear", SensorKind::Proximity, 0.0, 100.0),
            curve("again", &points, 100.0),
            curve("near", &points, 80.0),
        ];
    });
    let read = |distance: f64| {
        let points = points.map(|point| point.map(f64::from));
        let after = points.iter().position(|[at, _]| *at > distance);
        match after {
            Some(0) => points[0][1],
            Some(after) => {
                let [near, far] = [points[after - 1], points[after]];
                near[1] + (far[1] - near[1]) * (distance - near[0]) / (far[0] - near[0])
            }
            None => points[3][1],
        }
    };
    let mut pieces = [0; 6];
    for trace in traces(world, 200) {
        for (_, details) in trace.lines() {
            let real = |index: usize| f64::from(f32::from_bits(details[5 + index]));
            let [curve, line, linear] = [0, 1, 2].map(real);
            assert!((line - linear).abs() < 1e-6, "{line} {linear}");
            assert_eq!((curve.to_bits(), linear == 0.0), (real(3).to_bits(), curve == 0.0));
            let distance = 100.0 * (1.0 - linear);
            if linear > 0.0 {
                assert!((curve - read(distance)).abs() < 1e-5, "{distance} {curve}");
                assert!(real(4) == if distance < 80.0 - 1e-3 { curve } else { 0.0 } || (distance - 80.0).abs() < 1e-3);
            }
            let piece = [5.0, 10.0, 40.0, 80.0, 99.999]
                .iter()
                .take_while(|at| distance >= **at)
                .count();
            pieces[piece] += 1;
        }
    }
    assert!(pieces.iter().all(|count| *count > 20), "{pieces:?}");
}

/// Episodes that are pinned ([`crate::composed`]).
pub(crate) fn subjects() -> Vec<Subject> {
    let all = |spec: &mut WorldSpec, robot: &mut Differential| {
        spec.noise = Noise {
            motor: 0.1,
            ..Noise::SENSOR
        };
        (robot.acceleration, robot.latency) = (Some(700.0), Some(3));
        robot.battery_ends_life = Some(true);
        robot.sensors[0].response = Some(Response(vec![[0.0, 1.0], [20.0, 0.3], [90.0, 0.1]]));
        robot.sensors[1].bearing = Some(0.3);
    };
    let sampled = |acceleration, latency| {
        restless(|spec, robot| {
            spec.robot.motors = Arc::new(bent());
            spec.noise.motor = 0.1;
            *robot = Differential {
                sensors: robot.sensors.clone(),
                acceleration,
                latency,
                ..Differential::sampled()
            };
        })
    };
    let slow = restless(|_, robot| robot.acceleration = Some(333.0));
    let late = restless(|_, robot| (robot.latency, robot.speeds) = (Some(8), 7));
    vec![
        subject("accelerating", slow),
        subject("late, of 7 speeds", late),
        subject("charged", charged(|_, _| ())),
        subject("charged, with all else", charged(all)),
        subject("sampled, accelerating, late", sampled(Some(700.0), Some(3))),
        subject("sampled, late", sampled(None, Some(1))),
        subject("sampled, accelerating", sampled(Some(90.0), None)),
    ]
}

type Change = dyn Fn(&mut WorldSpec, &mut Differential);

#[test]
fn what_cannot_be_is_refused() {
    let refused = |change: &Change| {
        World::new(charged(|spec, robot| change(spec, robot)))
            .unwrap_err()
            .to_string()
    };
    let cases: [(&Change, &str); 16] = [
        (
            &|_, robot| robot.acceleration = Some(0.5),
            "robot.acceleration_mm_s2: is 0.5; allowed: 0, or at least 1",
        ),
        (
            &|_, robot| robot.acceleration = Some(-1.0),
            "robot.acceleration_mm_s2: is -1; allowed: 0 to 1000000",
        ),
        (
            &|_, robot| robot.latency = Some(9),
            "robot.latency_cycles: is 9; allowed: 0 to 8",
        ),
        (
            &|_, robot| robot.battery = Some(0.0),
            "robot.battery_s: is 0; allowed: 0.1 to 100000",
        ),
        (
            &|spec, robot| {
                robot.battery = None;
                spec.arena.patches.clear();
            },
            "robot.sensors[5].kind: is battery; allowed: only with robot.battery_s",
        ),
        (
            &|_, robot| {
                robot.battery = None;
                robot.sensors.pop();
            },
            "arena.patches[0].charges: is true; allowed: only with robot.battery_s",
        ),
        (
            &|_, robot| (robot.battery, robot.battery_ends_life) = (None, Some(true)),
            "robot.battery_ends_life: is true; allowed: only with robot.battery_s",
        ),
        (
            &|_, robot| robot.sensors[5].range = Some(1.0),
            "robot.sensors[5].range_mm: is given; allowed: not with kind = \"battery\"",
        ),
        (
            &|_, robot| robot.sensors[5].heading = 0.1,
            "robot.sensors[5].heading_turns: is given; allowed: not with kind = \"battery\"",
        ),
        (
            &|_, robot| robot.sensors[5].offset = Some(1.0),
            "robot.sensors[5].offset_mm: is given; allowed: not with kind = \"battery\"",
        ),
        (
            &|_, robot| robot.sensors[3].bearing = Some(0.1),
            "robot.sensors[3].bearing_turns: is given; allowed: not with kind = \"bumper\"",
        ),
        (
            &|_, robot| robot.sensors[1].response = Some(Response(vec![[0.0, 1.0], [1.0, 0.0]])),
            "robot.sensors[1].response: is given; allowed: not with kind = \"distance\"",
        ),
        (
            &|_, robot| robot.sensors[0].response = Some(Response(vec![[0.0, 1.0]])),
            "robot.sensors[0].response: has 1 points; allowed: 2 to 32",
        ),
        (
            &|_, robot| robot.sensors[0].response = Some(Response(vec![[0.0, 1.0], [9.0, 1.5]])),
            "robot.sensors[0].response[1][1]: is 1.5; allowed: 0 to 1",
        ),
        (
            &|_, robot| robot.sensors[0].response = Some(Response(vec![[0.0, 1.0], [9.0, 0.5], [9.0, 0.0]])),
            "robot.sensors[0].response: goes from 9 to 9 mm; allowed: each distance at least 0.01 mm beyond the one \
             before",
        ),
        (
            &|_, robot| robot.sensors[0].response = Some(Response(vec![[0.0, 1.0], [101.0, 0.5]])),
            "robot.sensors[0].response[1][0]: is 101; allowed: 0 to 100",
        ),
    ];
    for (change, expected) in cases {
        assert_eq!(refused(change), expected);
    }
}
