use std::sync::Arc;

use oneiro::tables::SensorTables;

use super::*;
use crate::robots::guard::message::Sensors;

const GOES_ON: AtomicBool = AtomicBool::new(false);

/// A robot on a virtual clock that reads the built-in table of a wall, and turns as its wheels do but for what is wrong with it.
struct Mock {
    profile: Profile,
    tables: Arc<SensorTables>,
    row: usize,
    now: Duration,
    /// Speeds of the wheels, mm/s, and their true travel, mm.
    speeds: [f64; 2],
    travel: [f64; 2],
    /// Heading, turns.
    heading: f64,
    /// The wheels are this many times as far apart as they are said to be.
    wider: f64,
    /// Travel by a count of an odometer, mm.
    count_mm: f64,
    /// Duration of a look.
    look: Duration,
    /// Looks so far, and those that fail or take ten times as long.
    looks: u32,
    failing: fn(u32) -> bool,
    slow: fn(u32) -> bool,
    /// Within these turns of the heading the wheels slip.
    slippery: [f64; 2],
    is_stuck: bool,
    /// Greatest sum of speeds and time at which it ever was from its place, mm.
    farthest: f64,
    place: [f64; 2],
}

impl Mock {
    fn new() -> Self {
        let names = (0..8).map(|sensor| format!("proximity_{sensor}"));
        Self {
            profile: Profile {
                robot: "mock".into(),
                firmware: "1".into(),
                sensors: vec![Sensors {
                    kind: "proximity".into(),
                    names: names.collect(),
                    unit: String::new(),
                    range: (0.0, 1023.0),
                }],
                greatest_mm_s: 200.0,
                unit_mm_s: 8.2,
                base_mm: 53.0,
                has_odometers: true,
            },
            tables: SensorTables::khepera(),
            row: 0,
            now: Duration::from_secs(7),
            speeds: [0.0; 2],
            travel: [0.0; 2],
            heading: 0.0,
            wider: 1.0,
            count_mm: 1.0 / 12.0,
            look: Duration::from_millis(40),
            looks: 0,
            failing: |_| false,
            slow: |_| false,
            slippery: [f64::NAN; 2],
            is_stuck: false,
            farthest: 0.0,
            place: [0.0; 2],
        }
    }

    fn pass(&mut self, time: Duration) {
        const STEP: f64 = 1e-3;
        let steps = (time.as_secs_f64() / STEP).round() as u32;
        for _ in 0..steps {
            let [left, right] = self.speeds.map(|speed| if self.is_stuck { 0.0 } else { speed * STEP });
            self.travel = [self.travel[0] + left, self.travel[1] + right];
            let [from, to] = self.slippery;
            if !(from..to).contains(&self.heading) {
                self.heading += (right - left) / (TAU * self.profile.base_mm * self.wider);
            } else if (right - left).abs() > 0.0 {
                self.heading += 0.2 * (right - left) / (TAU * self.profile.base_mm * self.wider);
            }
            let way = 0.5 * (left + right);
            self.place[0] += way * (TAU * self.heading).cos();
            self.place[1] += way * (TAU * self.heading).sin();
            self.farthest = self.farthest.max(self.place[0].hypot(self.place[1]));
        }
        self.now += time;
    }

    /// What the table has where it stands.
    fn cell(&self, heading: f64) -> Vec<u16> {
        let bearing = ((heading.rem_euclid(1.0) * 180.0) as usize).min(179);
        self.tables.classes[0].cell(self.row * 180 + bearing).to_vec()
    }

    /// Asserts that all readings of a row are those of the table, at most this many bearings aside.
    fn assert_row(&self, row: &Row, aside: usize) {
        let table = &self.tables.classes[0];
        assert_eq!(row.len(), 180);
        for (bearing, cell) in row.iter().enumerate() {
            let mut near =
                (0..=2 * aside).map(|step| table.cell(self.row * 180 + (bearing + 180 + step - aside) % 180));
            assert!(near.any(|near| near == cell), "row {} at {bearing}: {cell:?}", self.row);
        }
    }
}

impl Vehicle for Mock {
    fn profile(&self) -> &Profile {
        &self.profile
    }

    fn now(&self) -> Duration {
        self.now
    }

    fn look(&mut self) -> std::result::Result<Moment, Trouble> {
        self.looks += 1;
        if (self.failing)(self.looks) {
            self.speeds = [0.0; 2];
            return Err(Trouble::Unreadable("no answer".into()));
        }
        let times = if (self.slow)(self.looks) { 10 } else { 1 };
        self.pass(self.look * times);
        let travel = self
            .travel
            .map(|travel| (travel / self.count_mm).floor() * self.count_mm);
        Ok(Moment {
            at: self.now,
            age: self.look,
            readings: self.cell(self.heading).into_iter().map(f64::from).collect(),
            travel: self.profile.has_odometers.then_some(travel),
        })
    }

    fn drive(&mut self, speeds: [f64; 2]) -> std::result::Result<(), Trouble> {
        self.pass(Duration::from_millis(15));
        let unit = self.profile.unit_mm_s;
        self.speeds = speeds.map(|speed| (speed / unit).round() * unit);
        Ok(())
    }

    fn keep_until(&mut self, until: Duration) -> std::result::Result<(), Trouble> {
        self.pass(until.saturating_sub(self.now));
        Ok(())
    }

    fn stop(&mut self) -> std::result::Result<(), Trouble> {
        self.drive([0.0; 2])
    }

    fn recover(&mut self) -> std::result::Result<(), Trouble> {
        self.stop()
    }
}

/// Measures how a mock turns, and takes all its rows.
fn rows(mock: &mut Mock, aside: usize) -> Turning {
    let speed = pace(mock).unwrap();
    let turning = measured(mock, speed, &GOES_ON).unwrap();
    for row in 0..20 {
        (mock.row, mock.heading) = (row, 0.0);
        let turn = turn_before(mock, turning, 1, &GOES_ON).unwrap();
        mock.assert_row(&turn.row().unwrap(), aside);
        assert_eq!(mock.speeds, [0.0; 2]);
        // It has its heading again.
        let off = mock.heading - mock.heading.round();
        assert!(off.abs() * 360.0 < 3.0, "{off}");
        match turn.overlap {
            Overlap::Late { drift, difference } => {
                assert!(
                    drift.abs() * 360.0 < 1.0 && difference < 25.0,
                    "row {row}: {:?}",
                    turn.overlap
                );
            }
            overlap => assert!(overlap == Overlap::Blank && row > 10, "row {row}: {overlap:?}"),
        }
    }
    turning
}

#[test]
fn readings_are_shares_of_each_sensor_s_range() {
    let sensors = |kind: &str, count, range| Sensors {
        kind: kind.into(),
        names: (0..count).map(|sensor| format!("{kind}_{sensor}")).collect(),
        unit: String::new(),
        range,
    };
    let mut profile = Mock::new().profile;
    profile.sensors = vec![
        sensors("proximity", 4, (0.0, 4095.0)),
        sensors("ground", 1, (-10.0, 10.0)),
    ];
    let moment = Moment {
        at: Duration::ZERO,
        age: Duration::ZERO,
        readings: vec![0.0, 4095.0, 2048.0, 5000.0, -5.0],
        travel: None,
    };
    assert_eq!(scaled(&profile, &moment), [0, 1023, 512, 1023, 256]);
}

#[test]
fn rows_are_those_of_the_table() {
    let turning = rows(&mut Mock::new(), 1);
    assert_eq!(turning.wheel_mm_s, 8.2);
    assert!((turning.apparent - 1.0).abs() < 1e-3, "{turning:?}");
}

/// The distance between its wheels is not what its description says.
#[test]
fn whole_turns_are_found_in_readings() {
    for wider in [0.9, 0.98, 1.02, 1.1, 1.15] {
        let mut mock = Mock { wider, ..Mock::new() };
        let turning = rows(&mut mock, 1);
        assert!((turning.apparent - wider).abs() < 2e-3, "{wider}: {turning:?}");
    }
}

#[test]
fn without_odometers_the_clock_tells_the_heading() {
    let mut mock = Mock {
        wider: 1.07,
        ..Mock::new()
    };
    mock.profile.has_odometers = false;
    // With a speed of 8.2 mm/s until it has stopped.
    let turning = rows(&mut mock, 1);
    assert!((turning.apparent - 1.07).abs() < 5e-3, "{turning:?}");
    let driven = drive(&mut mock, (1, 2), 82.0, 1.0, &GOES_ON);
    assert!(matches!(driven, Err(Trouble::Broken(problem)) if problem.contains("no odometers")));
}

#[test]
fn coarse_odometers_are_enough() {
    rows(
        &mut Mock {
            count_mm: 0.5,
            ..Mock::new()
        },
        1,
    );
}

/// A link with which one turn leaves bearings without a reading, and one that loses readings.
#[test]
fn bearings_without_a_reading_are_read_in_the_next_turn() {
    rows(
        &mut Mock {
            look: Duration::from_millis(137),
            ..Mock::new()
        },
        2,
    );
    rows(
        &mut Mock {
            slow: |look| look % 41 == 0,
            ..Mock::new()
        },
        1,
    );
    let mut slow = Mock {
        look: Duration::from_millis(900),
        ..Mock::new()
    };
    let turning = Turning {
        wheel_mm_s: 8.2,
        apparent: 1.0,
    };
    let trouble = turn_before(&mut slow, turning, 1, &GOES_ON).unwrap_err();
    assert!(
        trouble.to_string().contains("degrees after 3 turns at its slowest"),
        "{trouble}"
    );
    assert_eq!(slow.speeds, [0.0; 2]);
}

#[test]
fn several_turns_are_averaged() {
    let mut mock = Mock::new();
    let turning = Turning {
        wheel_mm_s: 8.2,
        apparent: 1.0,
    };
    let turn = turn_before(&mut mock, turning, 3, &GOES_ON).unwrap();
    // At each bearing the mean of readings in neighbouring intervals.
    let table = &mock.tables.classes[0];
    for (bearing, cell) in turn.row().unwrap().into_iter().enumerate() {
        for (sensor, reading) in cell.into_iter().enumerate() {
            let near = [179, 0, 1].map(|aside| table.cell((bearing + aside) % 180)[sensor]);
            let (low, high) = (near.iter().min().unwrap(), near.iter().max().unwrap());
            assert!(
                (low..=high).contains(&&reading),
                "{bearing} {sensor}: {reading} {near:?}"
            );
        }
    }
    assert!(turn.turned().len() > 3 * 400);
}

/// Wheels that slip show in the readings alone.
#[test]
fn a_robot_that_slips_has_not_turned_once() {
    let turning = Turning {
        wheel_mm_s: 8.2,
        apparent: 1.0,
    };
    for (degrees, slippery) in [(0.0, [0.0; 2]), (8.0, [0.5, 0.5 + 2.0 / 360.0]), (-8.0, [0.0; 2])] {
        let mut mock = Mock {
            slippery,
            ..Mock::new()
        };
        if degrees < 0.0 {
            mock.wider = 360.0 / 368.0;
        }
        let turn = turn_before(&mut mock, turning, 1, &GOES_ON).unwrap();
        let Overlap::Late { drift, .. } = turn.overlap else {
            panic!("{:?}", turn.overlap)
        };
        assert!((360.0 * drift - degrees).abs() < 0.7, "{degrees}: {}", 360.0 * drift);
    }
    let mut mock = Mock {
        slippery: [0.5, 0.51],
        ..Mock::new()
    };
    let turn = turn_before(&mut mock, turning, 1, &GOES_ON).unwrap();
    assert_eq!(turn.overlap, Overlap::Unlike);
}

#[test]
fn troubles_end_a_turn() {
    let turning = Turning {
        wheel_mm_s: 8.2,
        apparent: 1.0,
    };
    let mut mock = Mock {
        failing: |look| look == 200,
        ..Mock::new()
    };
    let trouble = turn_before(&mut mock, turning, 1, &GOES_ON).unwrap_err();
    assert!(matches!(trouble, Trouble::Unreadable(_)));
    // Repeated from its place, it is a whole row.
    mock.heading = 0.0;
    mock.recover().unwrap();
    let turn = turn_before(&mut mock, turning, 1, &GOES_ON).unwrap();
    mock.assert_row(&turn.row().unwrap(), 1);

    let mut stuck = Mock {
        is_stuck: true,
        ..Mock::new()
    };
    let trouble = turn_before(&mut stuck, turning, 1, &GOES_ON).unwrap_err();
    assert!(
        matches!(&trouble, Trouble::Displaced(problem) if problem.contains("is it stuck")),
        "{trouble}"
    );
    assert_eq!(stuck.speeds, [0.0; 2]);

    let mut mock = Mock::new();
    let trouble = turn_before(&mut mock, turning, 1, &AtomicBool::new(true)).unwrap_err();
    assert!(matches!(trouble, Trouble::Stopped));
    assert_eq!(mock.speeds, [0.0; 2]);

    // Nothing before it.
    let mut alone = Mock::new();
    alone.tables = Arc::new(SensorTables::new(vec![oneiro::tables::SensorTable {
        readings: vec![7; 20 * 180 * 8],
        ..alone.tables.classes[0].clone()
    }]));
    let trouble = measured(&mut alone, 8.2, &GOES_ON).unwrap_err();
    assert!(
        trouble.to_string().contains("no whole turn can be recognised"),
        "{trouble}"
    );
}

#[test]
fn motors_are_measured_by_odometers_near_its_place() {
    let mut mock = Mock {
        wider: 1.02,
        ..Mock::new()
    };
    for left in -10..=10 {
        for right in -10..=10 {
            let driven = drive(&mut mock, (left, right), 82.0, 1.02, &GOES_ON).unwrap();
            let way = f64::from(left + right) * 0.41;
            let turn = f64::from(right - left) * 0.82 / (TAU * 53.0 * 1.02);
            // A count in a second, of each wheel.
            assert!(
                (driven.displacement - way).abs() < 0.1 / 12.0 + 1e-9,
                "{left} {right}: {driven:?}"
            );
            assert!(
                (driven.turn - turn).abs() < 0.2 / 12.0 / (TAU * 53.0),
                "{left} {right}: {driven:?}"
            );
        }
    }
    assert_eq!(mock.speeds, [0.0; 2]);
    assert!(mock.farthest < reach_mm(82.0) + 40.0, "{}", mock.farthest);
    let (x, y) = (mock.place[0], mock.place[1]);
    assert!(x.hypot(y) < 30.0, "{x} {y}");
}
