//! A robot on a virtual clock, for tests.

use std::f64::consts::TAU;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use oneiro::tables::SensorTables;
use oneiro_robots::guard::message::Sensors;
use oneiro_robots::vehicle::{Moment, Profile, Vehicle};

use super::super::Trouble;
use super::super::sampling::Row;

/// The place where a person puts the robot and sets its odometers to 0: before an object, by its class and the row, or in the
/// open.
pub type Hands = Arc<Mutex<Option<Option<(usize, usize)>>>>;

/// A robot on a virtual clock that reads the built-in table of a wall, and turns by its wheels, except for its faults.
pub struct Mock {
    pub profile: Profile,
    pub tables: Arc<SensorTables>,
    pub row: usize,
    pub now: Duration,
    /// Speeds of the wheels, mm/s, and their true travel, mm.
    pub speeds: [f64; 2],
    pub travel: [f64; 2],
    /// Heading, turns.
    pub heading: f64,
    /// True distance between the wheels, as a multiple of the profile's.
    pub wider: f64,
    /// Travel by a count of an odometer, mm.
    pub count_mm: f64,
    /// Duration of a look.
    pub look: Duration,
    /// Looks so far, and those that fail or take ten times as long.
    pub looks: u32,
    pub failing: fn(u32) -> bool,
    pub slow: fn(u32) -> bool,
    /// Whether it fails for good when it fails.
    pub is_broken: bool,
    /// Within these turns of the heading the wheels slip.
    pub slippery: [f64; 2],
    pub is_stuck: bool,
    /// Its position relative to its first place, mm, and its maximum distance from there.
    pub farthest: f64,
    pub place: [f64; 2],
    /// The place where a person puts it.
    pub hands: Hands,
    pub class: Option<usize>,
}

impl Mock {
    /// A robot without faults.
    #[expect(clippy::new_without_default, reason = "for tests")]
    pub fn new() -> Self {
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
            is_broken: false,
            slippery: [f64::NAN; 2],
            is_stuck: false,
            farthest: 0.0,
            place: [0.0; 2],
            hands: Hands::default(),
            class: Some(0),
        }
    }

    fn pass(&mut self, time: Duration) {
        const STEP: f64 = 1e-3;
        if let Some(put) = self.hands.lock().unwrap().take() {
            (self.class, self.row) = put.map_or((None, 0), |(class, row)| (Some(class), row));
            (self.heading, self.place, self.travel) = (0.0, [0.0; 2], [0.0; 2]);
        }
        let steps = (time.as_secs_f64() / STEP).round() as u32;
        for _ in 0..steps {
            let [left, right] = self.speeds.map(|speed| if self.is_stuck { 0.0 } else { speed * STEP });
            self.travel = [self.travel[0] + left, self.travel[1] + right];
            let [from, to] = self.slippery;
            if !(from..to).contains(&self.heading.rem_euclid(1.0)) {
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

    /// The table's cell at the robot's position.
    fn cell(&self, heading: f64) -> Vec<u16> {
        let bearing = ((heading.rem_euclid(1.0) * 180.0) as usize).min(179);
        match self.class {
            Some(class) => self.tables.classes[class].cell(self.row * 180 + bearing).to_vec(),
            None => vec![0; 8],
        }
    }

    /// Asserts that all readings of a row are those of the table, at most this many bearings aside.
    pub fn assert_row(&self, row: &Row, aside: usize) {
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

    fn look(&mut self) -> Result<Moment, Trouble> {
        self.looks += 1;
        if (self.failing)(self.looks) {
            self.speeds = [0.0; 2];
            let problem = "no answer".into();
            return Err(if self.is_broken {
                Trouble::Broken(problem)
            } else {
                Trouble::Unreadable(problem)
            });
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

    fn drive(&mut self, speeds: [f64; 2]) -> Result<(), Trouble> {
        self.pass(Duration::from_millis(15));
        let unit = self.profile.unit_mm_s;
        self.speeds = speeds.map(|speed| (speed / unit).round() * unit);
        Ok(())
    }

    fn keep_until(&mut self, until: Duration) -> Result<(), Trouble> {
        self.pass(until.saturating_sub(self.now));
        Ok(())
    }

    fn stop(&mut self) -> Result<(), Trouble> {
        self.drive([0.0; 2])
    }

    fn recover(&mut self) -> Result<(), Trouble> {
        self.stop()
    }
}
