//! A whole robot is sampled: a Khepera that is emulated byte by byte on a virtual clock, with a surrogate as its body.

use std::cell::Cell;
use std::f64::consts::TAU;
use std::fs;
use std::path::Path;
use std::rc::Rc;
use std::time::Duration;

use oneiro::arena::{Arena, Obstacle, Wall};
use oneiro_robots::Kind;
use oneiro_robots::emulated::Bench;
use oneiro_robots::emulated::khepera::surrogate::Simulated;
use oneiro_robots::emulated::khepera::{Body, Firmware, Khepera};
use oneiro_robots::khepera;
use oneiro_robots::vehicle::direct::Direct;
use oneiro_robots::vehicle::{Moment, Profile};

use super::tests::{GOES_ON, Scratch, plan, quiet};
use super::*;

const SEED: u64 = 3;
const RADIUS: f32 = 27.5;
/// Rows of each object, and as many as a robot is sampled with by default where `ONEIRO_LONG` is set.
const ROWS: u32 = 10;
const ALL_ROWS: u32 = 20;
/// Where the robot stands, mm.
const PLACE: [f32; 2] = [300.0, 175.0];

/// An arena with one object straight ahead, or with none.
fn arena(place: &Place<'_>) -> Arena {
    let [x, y] = PLACE;
    let mut arena = Arena {
        walls: Vec::new(),
        ..Arena::rectangle(600.0, 350.0)
    };
    let Place::Before { object, gap, .. } = place else {
        return arena;
    };
    let (rim, class) = (x + RADIUS + gap + 0.01, object.class.clone());
    match object.shape {
        Shape::Wall => arena.walls.push(Wall {
            from: [rim, y - 1000.0],
            to: [rim, y + 1000.0],
            class,
        }),
        Shape::Round { radius } => arena.obstacles.push(Obstacle {
            x: rim + radius,
            y,
            radius,
            class,
        }),
        Shape::Block { .. } => unreachable!("no block is sampled here"),
    }
    arena
}

fn body(place: &Place<'_>) -> Simulated {
    Simulated::new(SEED, arena(place), [PLACE[0], PLACE[1], 0.0])
}

/// Puts the robot down before the object, its counters at 0.
struct Placer {
    bench: Bench<Simulated>,
    /// Looks until the program is killed, and how many are left when the motors begin.
    looks: Rc<Cell<u32>>,
    motors: u32,
}

impl Person for Placer {
    fn place(&mut self, _: &mut dyn Vehicle, place: &Place<'_>, _: &str) -> Result<Answer> {
        if let Place::Open(_) = place {
            self.looks.set(self.motors);
        }
        let mut line = self.bench.line();
        line.robot.set_counters([0; 2]);
        line.robot.body = body(place);
        Ok(Answer::Go)
    }

    fn decide(&mut self, _: &mut dyn Vehicle, words: &str, _: bool) -> Result<Answer> {
        panic!("{words}");
    }

    fn troubled(&mut self, trouble: Trouble) -> Result {
        panic!("{trouble}");
    }
}

/// A vehicle whose program is killed after some looks: its wheels turn on.
struct Mortal {
    own: Direct<Bench<Simulated>>,
    looks: Rc<Cell<u32>>,
}

impl Vehicle for Mortal {
    fn profile(&self) -> &Profile {
        self.own.profile()
    }

    fn now(&self) -> Duration {
        self.own.now()
    }

    fn look(&mut self) -> std::result::Result<Moment, Trouble> {
        let left = self.looks.get().checked_sub(1);
        self.looks.set(left.ok_or(Trouble::Broken("killed".into()))?);
        self.own.look()
    }

    fn drive(&mut self, speeds: [f64; 2]) -> std::result::Result<(), Trouble> {
        self.own.drive(speeds)
    }

    fn keep_until(&mut self, until: Duration) -> std::result::Result<(), Trouble> {
        self.own.keep_until(until)
    }

    fn stop(&mut self) -> std::result::Result<(), Trouble> {
        self.own.stop()
    }

    fn recover(&mut self) -> std::result::Result<(), Trouble> {
        self.own.recover()
    }
}

/// Connects to the robot and samples it, for as many looks, and as many at its motors.
fn sampled(
    bench: &Bench<Simulated>,
    plan: &Plan,
    at: &Path,
    looks: u32,
    motors: u32,
) -> Result<(SensorTables, Option<MotorSamples>)> {
    let mut robot = khepera::Khepera::new(Box::new(bench.clone()));
    robot.begin().unwrap();
    let looks = Rc::new(Cell::new(looks));
    let mut vehicle = Mortal {
        own: Direct::new(Box::new(robot), bench.clone(), &[Kind::Proximity]),
        looks: Rc::clone(&looks),
    };
    let mut placer = Placer {
        bench: bench.clone(),
        looks,
        motors,
    };
    Walk::new(&mut vehicle, &mut placer, plan, at, &GOES_ON, quiet())?.go()
}

fn bench() -> Bench<Simulated> {
    Bench::new(Khepera::new(body(&Place::Open(0.0)), Firmware::ALL[0], 38_400))
}

/// The first readings in each bearing's interval as the surrogate itself turns on the spot, and how far it turns in a cycle, turns.
fn turned(place: &Place<'_>) -> (Vec<[u16; 8]>, f64) {
    let mut body = body(place);
    let mut cells = vec![None; 180];
    let (mut heading, mut last, mut cycles) = (0.0, 0.0, 0);
    while heading < 1.02 {
        cells[(body.pose[2] * 180.0) as usize % 180].get_or_insert(body.proximity());
        body.advance(Duration::from_millis(100), [-1, 1]);
        let turn = body.pose[2] - last;
        heading += f64::from(turn - turn.floor());
        last = body.pose[2];
        cycles += 1;
    }
    let cells = cells
        .into_iter()
        .map(|cell| cell.expect("each interval is wider than a cycle's turn"));
    (cells.collect(), heading / f64::from(cycles))
}

/// Each reading of the wired robot lies between those that its surrogate has within two bearings, but for their noise. Two
/// bearings: one that it turns in a cycle, in which its readings stay the same, and one for the other beginning of its cycles.
#[test]
fn a_robot_is_sampled_into_the_tables_of_its_surrogate() {
    let rows = match std::env::var_os("ONEIRO_LONG") {
        Some(_) => ALL_ROWS,
        None => ROWS,
    };
    let plan = plan(&["wall", "round"], rows, Some(82.0));
    let whole = Scratch::new("emulated");
    let (sensors, motors) = sampled(&bench(), &plan, &whole.0, u32::MAX, u32::MAX).unwrap();
    let mut inside = 0;
    let mut rate = 0.0;
    for (object, table) in plan.objects.iter().zip(&sensors.classes) {
        assert_eq!((table.rows, table.bearings, table.sensors), (rows, 180, 8));
        for row in 0..rows {
            let (view, gap) = plan.grid.place(object, row);
            let known;
            (known, rate) = turned(&Place::Before { object, view, gap });
            for bearing in 0..180 {
                for (sensor, &reading) in table.cell(row as usize * 180 + bearing).iter().enumerate() {
                    let near = (0..5).map(|aside| known[(bearing + 178 + aside) % 180][sensor]);
                    let (low, high) = (near.clone().min().unwrap(), near.max().unwrap());
                    let apart = f64::from(reading.saturating_sub(high).max(low.saturating_sub(reading)));
                    // Its standard deviation is 3.4 and 3 % of a reading; the difference of two readings has root 2 of it.
                    let noise = 2.0_f64.sqrt() * (3.4 + 0.03 * f64::from(high.max(reading)));
                    assert!(
                        apart <= 5.0 * noise,
                        "{} row {row}, {bearing}, {sensor}: {reading}, not {low} to {high}",
                        object.class
                    );
                    inside += u32::from(apart == 0.0);
                }
            }
        }
    }
    let readings = 2 * rows * 180 * 8;
    eprintln!(
        "{rows} rows: {inside} of {readings} readings are within those of the surrogate, the others within its noise"
    );
    // Noise leads out of the range of five bearings in 3 % of the readings.
    assert!(f64::from(inside) > 0.968 * f64::from(readings), "{inside}");

    // Odometers count what is commanded: 100 pulses a second by unit, 12 in a mm. They don't measure how far its body turns.
    let turning: Turning = serde_json::from_slice(&fs::read(whole.0.join("rows/turning.json")).unwrap()).unwrap();
    let wheels = 20.0 / 12.0 / (TAU * 53.0);
    assert_eq!(turning.wheel_mm_s, 8.2);
    assert!(
        (turning.apparent * rate / wheels - 1.0).abs() < 0.003,
        "{turning:?} {rate} {wheels}"
    );
    let motors = motors.unwrap();
    // A count in ten cycles, and 3 ms of the line in a second.
    let off = |speed: f64| 0.1 / 12.0 + 0.003 * speed.abs();
    for (pair, (degrees, centimetres)) in motors.degrees.iter().zip(&motors.centimetres).enumerate() {
        let [left, right] = [pair / 21, pair % 21].map(|index| (index as f64 - 10.0) * 10.0 / 12.0);
        let way = 10.0 * f64::from(*centimetres) - 0.5 * (left + right);
        assert!(way.abs() < 0.5 * (off(left) + off(right)), "{pair}: {way}");
        let turn = f64::from(*degrees).to_radians() + (right - left) / (53.0 * turning.apparent);
        assert!(turn.abs() < (off(left) + off(right)) / 53.0, "{pair}: {turn}");
    }

    // Killed ten times in the middle of a turn or of a drive, with turning wheels.
    let pieces = Scratch::new("killed");
    let bench = bench();
    let kept = || {
        let names = ["wall-", "round-", "motors-"];
        let files = pieces.files().into_iter();
        files
            .filter(|(name, _)| names.iter().any(|row| name.starts_with(row)))
            .count()
            - plan.objects.len()
    };
    let mut before = 0;
    for looks in [1000, 4500, 750, 10_000, 4000, 8000, 4500, 12_500, u32::MAX, u32::MAX] {
        let looks = looks.saturating_mul(rows / ROWS);
        let failure = sampled(&bench, &plan, &pieces.0, looks, 300).unwrap_err();
        assert_eq!((failure.code(), failure.to_string().as_str()), (4, "killed"));
        assert_ne!(bench.line().robot.speeds(), [0; 2]);
        assert!(kept() >= before);
        before = kept();
    }
    // 300 looks are 150 pairs, and 7 rows have 147.
    assert_eq!(before, 2 * rows as usize + 2 * 7);
    let (_, again) = sampled(&bench, &plan, &pieces.0, u32::MAX, u32::MAX).unwrap();
    assert_eq!(kept(), 2 * rows as usize + 21);
    let of_sensors = |scratch: &Scratch| -> Vec<(String, Vec<u8>)> {
        let files = scratch.files().into_iter();
        files.filter(|(name, _)| !name.starts_with("motor")).collect()
    };
    assert!(of_sensors(&pieces) == of_sensors(&whole));
    // Between two counts of its odometers it may stand elsewhere when its motors' rows begin: it is placed once for all of them.
    let again = again.unwrap();
    for (pair, (one, other)) in again.centimetres.iter().zip(&motors.centimetres).enumerate() {
        let [left, right] = [pair / 21, pair % 21].map(|index| (index as f64 - 10.0) * 10.0 / 12.0);
        let apart = 10.0 * f64::from((one - other).abs());
        assert!(apart < 0.5 * (off(left) + off(right)), "{pair}: {one} {other}");
    }
}
