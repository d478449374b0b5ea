//! Sampling of a robot, by section 3.2 of Miglino et al. (1995): its readings of an object at each bearing and distance
//! while it turns before the object, and its motion under each pair of speeds.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::{fs, io};

use oneiro::tables::{MotorSamples, SensorTable, SensorTables};
use oneiro_base::console::Bars;
use oneiro_base::disk;
use oneiro_base::exit::{Failure, Result};
use oneiro_base::plain;
use oneiro_base::progress;
use oneiro_report::figures;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::{Driven, Object, Sampled, Trouble, Turned, patiently};

/// Number of bearings in a turn.
pub const BEARINGS: u32 = 180;
/// From one row to the next, mm.
pub(super) const SPACING: f32 = Grid::USUAL.spacing;

/// The speeds of a wheel that any choice of 20 states takes, in the robot's unit.
pub const SPEEDS: std::ops::RangeInclusive<i32> = -10..=10;

/// The distances at which an object is sampled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// From the rim to the object in the first row, mm.
    pub nearest: f32,
    /// From one row to the next, mm.
    pub spacing: f32,
    /// Rows of each point of view.
    pub rows: u32,
}

impl Grid {
    /// The paper's.
    pub const USUAL: Self = Self {
        nearest: 5.0,
        spacing: 2.0,
        rows: 20,
    };

    /// Where the robot stands for a row of an object: the point of view, see [`Sampled::turn_before`], and the gap in mm. The
    /// rows of each point of view follow those of the one before; a view is sampled in its middle.
    pub fn place(self, object: &Object, row: u32) -> (f64, f32) {
        let view = (f64::from(row / self.rows) + 0.5) / f64::from(2 * object.views());
        (view, self.nearest + (row % self.rows) as f32 * self.spacing)
    }
}

/// Readings of all sensors at each bearing.
pub type Row = Vec<Vec<u16>>;

/// A robot's samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Samples {
    /// A table for each object.
    pub sensors: Arc<SensorTables>,
    /// The motion under each pair of speeds.
    pub motors: MotorSamples,
}

/// Saves each row once it is measured, so that sampling can continue after it.
#[derive(Debug)]
pub struct Notebook {
    /// None: nothing is saved.
    directory: Option<PathBuf>,
}

impl Notebook {
    /// Opens a notebook, which may hold rows of the same robot.
    ///
    /// # Errors
    /// Exit 3 if it holds rows of another robot; exit 6 if it can't be written.
    pub fn open(directory: &Path, robot: &str) -> Result<Self> {
        let notebook = Self::at(directory)?;
        let name = directory.join("rows/robot.txt");
        match disk::read_if_there(&name)? {
            Some(known) if known == robot.as_bytes() => (),
            Some(known) => {
                return Err(Failure::input(format_args!(
                    "{}: holds samples of another robot, {}; allowed: {robot}, or another directory",
                    directory.display(),
                    String::from_utf8_lossy(&known)
                )));
            }
            None => disk::write(&name, robot.as_bytes())?,
        }
        Ok(notebook)
    }

    /// The notebook of a directory, whichever robot it belongs to.
    ///
    /// # Errors
    /// Exit 6 if it can't be written.
    pub fn at(directory: &Path) -> Result<Self> {
        plain::make_directory(directory).map_err(|error| Failure::storage(directory, &error))?;
        let rows = disk::make_folder(directory, "rows")?;
        Ok(Self { directory: Some(rows) })
    }

    fn path(&self, name: &str) -> Option<PathBuf> {
        let directory = self.directory.as_ref()?;
        Some(directory.join(format!("{name}.json")))
    }

    /// Reads a row, if it was saved.
    ///
    /// # Errors
    /// Exit 5 if it is corrupt.
    pub fn read<T: DeserializeOwned>(&self, name: &str) -> Result<Option<T>> {
        let Some(path) = self.path(name) else { return Ok(None) };
        disk::json_if_there(&path)
    }

    /// Saves a row.
    ///
    /// # Errors
    /// Exit 6 if it can't be written.
    pub fn save<T: Serialize>(&self, name: &str, row: &T) -> Result {
        let Some(path) = self.path(name) else { return Ok(()) };
        disk::write(&path, &serde_json::to_vec(row).map_err(Failure::failed)?)
    }

    /// Removes a row, if it was saved, so that it is measured again.
    ///
    /// # Errors
    /// Exit 6 if it can't be removed.
    pub fn forget(&self, name: &str) -> Result {
        match self.path(name).map(|path| (fs::remove_file(&path), path)) {
            Some((Err(error), path)) if error.kind() != io::ErrorKind::NotFound => Err(Failure::storage(&path, &error)),
            _ => Ok(()),
        }
    }

    /// Reads a row that was saved before, or measures and saves it. Measuring takes this many turns before an object and drives.
    fn row<T: Serialize + DeserializeOwned>(
        &self,
        name: &str,
        robot: &mut dyn Sampled,
        (turns, drives): (u32, u32),
        take: impl FnOnce(&mut dyn Sampled) -> Result<T>,
    ) -> Result<T> {
        if let Some(row) = self.read(name)? {
            robot.leave_out(turns, drives);
            return Ok(row);
        }
        let row = take(robot)?;
        self.save(name, &row)?;
        Ok(row)
    }
}

/// The name of a row of an object in a notebook.
pub fn row_name(object: &Object, number: u32) -> String {
    format!("{}-{number:02}", object.class)
}

/// The name of the motors' row for a speed of the left wheel in a notebook, by its index.
pub fn motors_name(number: usize) -> String {
    format!("motors-{number:02}")
}

/// The number of rows of a whole sampling.
pub fn rows(objects: &[Object]) -> u64 {
    let views: u32 = objects.iter().map(Object::views).sum();
    u64::from(Grid::USUAL.rows * views) + SPEEDS.count() as u64
}

/// Samples a robot before each object, and its motors; `done` is called after each row.
///
/// # Errors
/// The robot's troubles; exit 6 if a row can't be saved.
pub fn sample(robot: &mut dyn Sampled, objects: &[Object], notebook: &Notebook, done: &dyn Fn()) -> Result<Samples> {
    let mut classes = Vec::new();
    for object in objects {
        let mut taken = Vec::new();
        for number in 0..object.views() * Grid::USUAL.rows {
            let name = row_name(object, number);
            taken.push(notebook.row(&name, robot, (1, 0), |robot| row(robot, object, number))?);
            done();
        }
        classes.push(table(object, Grid::USUAL, &taken));
    }
    let mut taken = Vec::new();
    for (number, left) in SPEEDS.enumerate() {
        let drives = SPEEDS.count() as u32;
        taken.push(notebook.row(&motors_name(number), robot, (0, drives), |robot| {
            motors_row(robot, left)
        })?);
        done();
    }
    Ok(Samples {
        sensors: Arc::new(SensorTables::new(classes)),
        motors: motors(&taken),
    })
}

/// Measures the missing samples, and writes `CLASS.sam` and `CLASS.svg` for each object, and `motor.sam`.
///
/// # Errors
/// The robot's troubles; exit 3 if the directory holds rows of another robot; exit 6 if a file can't be written.
pub fn take(robot: &mut dyn Sampled, objects: &[Object], directory: &Path, bars: Bars) -> Result<Samples> {
    let notebook = Notebook::open(directory, &robot.describe())?;
    let bar = progress::rows(rows(objects), "sampling", bars);
    let samples = sample(robot, objects, &notebook, &|| bar.inc(1))?;
    bar.finish_and_clear();
    write(&samples.sensors, Some(&samples.motors), directory)?;
    Ok(samples)
}

/// Writes `CLASS.sam` and `CLASS.svg` for each object, and `motor.sam` if motors were sampled.
///
/// # Errors
/// Exit 6 if a file can't be written.
pub fn write(sensors: &SensorTables, motors: Option<&MotorSamples>, directory: &Path) -> Result {
    for table in &sensors.classes {
        disk::write(&directory.join(format!("{}.sam", table.class)), table.text().as_bytes())?;
        let picture = figures::sensor_table(table);
        disk::write(&directory.join(format!("{}.svg", table.class)), picture.as_bytes())?;
    }
    match motors {
        Some(motors) => disk::write(&directory.join("motor.sam"), motors.text().as_bytes()),
        None => Ok(()),
    }
}

/// Samples a robot without saving rows: for a simulation, which takes a second.
pub fn sample_unkept(robot: &mut dyn Sampled, objects: &[Object]) -> Result<Samples> {
    sample(robot, objects, &Notebook { directory: None }, &|| ())
}

/// One row of a sensor table: the first reading in each bearing's interval as the robot turns.
fn row(robot: &mut dyn Sampled, object: &Object, row: u32) -> Result<Row> {
    let (view, gap) = Grid::USUAL.place(object, row);
    let turn = patiently(|| robot.turn_before(object, view, gap))?;
    binned(&turn).map_err(|bearing| {
        let low = f64::from(bearing) * 360.0 / f64::from(BEARINGS);
        Failure::failed(format_args!(
            "sampling {} at {gap} mm: no reading between {low} and {} degrees; the robot turns too fast",
            object.class,
            low + 360.0 / f64::from(BEARINGS)
        ))
    })
}

/// The first reading of each bearing's interval, or the first interval without one.
fn binned(turn: &[Turned]) -> std::result::Result<Row, u32> {
    let cells = (0..).zip(first_readings(turn));
    cells.map(|(bearing, cell)| cell.ok_or(bearing)).collect()
}

/// The first reading of each bearing's interval, where there is one.
pub(super) fn first_readings(turn: &[Turned]) -> Vec<Option<Vec<u16>>> {
    let mut cells = vec![None; BEARINGS as usize];
    for moment in turn {
        let bearing = ((moment.bearing * f64::from(BEARINGS)) as usize).min(BEARINGS as usize - 1);
        cells[bearing].get_or_insert_with(|| moment.readings.clone());
    }
    cells
}

/// The rounded mean of each sensor's readings.
pub(super) fn mean(cells: &[&[u16]]) -> Vec<u16> {
    let count = cells.len() as u32;
    let sum = |sensor: usize| cells.iter().map(|cell| u32::from(cell[sensor])).sum::<u32>();
    let sensors = cells.first().map_or(0, |cell| cell.len());
    (0..sensors)
        .map(|sensor| ((sum(sensor) + count / 2) / count) as u16)
        .collect()
}

/// A robot that turns before each object several times. Its reading at a bearing is the rounded mean over the turns.
pub struct Averaged<'a> {
    robot: &'a mut dyn Sampled,
    turns: u32,
}

impl<'a> Averaged<'a> {
    /// Averages over this number of turns, which is at least one.
    pub fn new(robot: &'a mut dyn Sampled, turns: u32) -> Self {
        Self {
            robot,
            turns: turns.max(1),
        }
    }
}

impl Sampled for Averaged<'_> {
    fn describe(&self) -> String {
        format!("{}, the mean of {} turns", self.robot.describe(), self.turns)
    }

    /// One reading for each bearing's interval that has readings in all turns.
    fn turn_before(&mut self, object: &Object, view: f64, gap: f32) -> std::result::Result<Vec<Turned>, Trouble> {
        let mut turns = Vec::new();
        for _ in 0..self.turns {
            turns.push(first_readings(&self.robot.turn_before(object, view, gap)?));
        }
        let seen = |bearing: u32| {
            let cells: Vec<&[u16]> = turns
                .iter()
                .filter_map(|turn| turn[bearing as usize].as_deref())
                .collect();
            (cells.len() == turns.len()).then(|| Turned {
                bearing: (f64::from(bearing) + 0.5) / f64::from(BEARINGS),
                readings: mean(&cells),
            })
        };
        Ok((0..BEARINGS).filter_map(seen).collect())
    }

    fn drive(&mut self, speeds: (i32, i32)) -> std::result::Result<Driven, Trouble> {
        self.robot.drive(speeds)
    }

    fn leave_out(&mut self, turns: u32, drives: u32) {
        self.robot.leave_out(turns * self.turns, drives);
    }
}

/// A table from its rows.
pub fn table(object: &Object, grid: Grid, rows: &[Row]) -> SensorTable {
    SensorTable {
        class: object.class.clone(),
        sensors: rows
            .first()
            .and_then(|row| row.first())
            .map_or(0, |cell| cell.len() as u32),
        rows: grid.rows,
        bearings: BEARINGS,
        nearest: grid.nearest,
        spacing: grid.spacing,
        views: object.views(),
        readings: rows.iter().flatten().flatten().copied().collect(),
    }
}

/// Measures one speed of the left wheel with each of the right.
fn motors_row(robot: &mut dyn Sampled, left: i32) -> Result<Vec<Driven>> {
    SPEEDS.map(|right| patiently(|| robot.drive((left, right)))).collect()
}

/// The motors' samples from their rows.
pub fn motors(rows: &[Vec<Driven>]) -> MotorSamples {
    let all = || rows.iter().flatten();
    MotorSamples {
        speeds: SPEEDS.collect(),
        // Files count turns clockwise.
        degrees: all().map(|driven| (0.0 - driven.turn * 360.0) as f32).collect(),
        centimetres: all().map(|driven| (driven.displacement / 10.0) as f32).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::super::Shape;
    use super::*;

    /// A mock of a connected robot: it reads the bearing in degrees and the gap, and fails on request.
    struct Wired {
        degrees_a_cycle: f64,
        troubles: Vec<Trouble>,
    }

    impl Wired {
        fn trouble(&mut self) -> std::result::Result<(), Trouble> {
            self.troubles.pop().map_or(Ok(()), Err)
        }
    }

    impl Sampled for Wired {
        fn describe(&self) -> String {
            "a robot on a wire".into()
        }

        fn turn_before(&mut self, _: &Object, _: f64, gap: f32) -> std::result::Result<Vec<Turned>, Trouble> {
            self.trouble()?;
            let cycles = (400.0 / self.degrees_a_cycle) as u32;
            let moment = |cycle: u32| {
                // Never on an edge of an interval, where rounding decides.
                let degrees = (0.25 + f64::from(cycle) * self.degrees_a_cycle) % 360.0;
                Turned {
                    bearing: degrees / 360.0,
                    readings: vec![degrees as u16, gap as u16, 0, 0, 0, 0, 0, 1023],
                }
            };
            Ok((0..cycles).map(moment).collect())
        }

        fn drive(&mut self, (left, right): (i32, i32)) -> std::result::Result<Driven, Trouble> {
            self.trouble()?;
            Ok(Driven {
                displacement: f64::from(left + right),
                turn: f64::from(right - left) / 100.0,
            })
        }
    }

    fn wall() -> Object {
        Object {
            class: "wall".into(),
            shape: Shape::Wall,
        }
    }

    #[test]
    fn a_cell_is_the_first_reading_of_its_interval() {
        let mut robot = Wired {
            degrees_a_cycle: 1.5,
            troubles: Vec::new(),
        };
        let samples = sample_unkept(&mut robot, &[wall()]).unwrap();
        let table = &samples.sensors.classes[0];
        assert_eq!(
            (table.rows, table.bearings, table.nearest, table.spacing),
            (20, 180, 5.0, 2.0)
        );
        for row in 0..20 {
            for bearing in 0..180 {
                let cell = table.cell(row * 180 + bearing);
                let first = 0.25 + ((2.0 * bearing as f64 - 0.25) / 1.5).ceil().max(0.0) * 1.5;
                assert_eq!(cell[..2], [first as u16, 5 + 2 * row as u16], "bearing {bearing}");
            }
        }
        let motors = samples.motors;
        assert_eq!(motors.speeds, (-10..=10).collect::<Vec<_>>());
        // Left -10, right 10: no displacement, a fifth of a turn to the left.
        assert_eq!((motors.centimetres[20], motors.degrees[20]), (0.0, -72.0));
    }

    #[test]
    fn the_mean_of_several_turns_is_rounded() {
        /// Its reading is the number of its turns so far, at every bearing except those that `blind` selects.
        struct Counting {
            turns: u16,
            blind: fn(turn: u16, bearing: u16) -> bool,
        }

        impl Sampled for Counting {
            fn describe(&self) -> String {
                "it counts".into()
            }

            fn turn_before(&mut self, _: &Object, _: f64, _: f32) -> std::result::Result<Vec<Turned>, Trouble> {
                self.turns += 1;
                let seen = (0..180).filter(|&bearing| !(self.blind)(self.turns, bearing));
                Ok(seen
                    .map(|bearing| Turned {
                        bearing: (f64::from(bearing) + 0.1) / 180.0,
                        readings: vec![bearing + self.turns, 1023, 0, 0, 0, 0, 0, u16::from(self.turns == 1)],
                    })
                    .collect())
            }

            fn drive(&mut self, _: (i32, i32)) -> std::result::Result<Driven, Trouble> {
                Err(Trouble::Broken("it only turns".into()))
            }
        }

        let seeing = |blind| Counting { turns: 0, blind };
        let mut robot = seeing(|_, _| false);
        let mut averaged = Averaged::new(&mut robot, 10);
        assert_eq!(averaged.describe(), "it counts, the mean of 10 turns");
        let cells = row(&mut averaged, &wall(), 0).unwrap();
        assert_eq!(robot.turns, 10);
        for (bearing, cell) in (0..).zip(cells) {
            // The mean of 1 to 10 is 5.5, and of one reading of 1 among ten 0.1.
            assert_eq!(cell, [bearing + 6, 1023, 0, 0, 0, 0, 0, 0], "bearing {bearing}");
        }
        // A bearing without a reading in one turn is not sampled.
        let mut robot = seeing(|turn, bearing| turn == 7 && bearing == 3);
        let failure = row(&mut Averaged::new(&mut robot, 10), &wall(), 0)
            .unwrap_err()
            .to_string();
        assert!(failure.contains("no reading between 6 and 8 degrees"), "{failure}");
    }

    #[test]
    fn a_robot_that_turns_too_fast_is_refused() {
        let mut robot = Wired {
            degrees_a_cycle: 3.0,
            troubles: Vec::new(),
        };
        let failure = sample_unkept(&mut robot, &[wall()]).unwrap_err().to_string();
        assert!(failure.contains("no reading between 4 and 6 degrees"), "{failure}");
    }

    #[test]
    fn temporary_failures_are_tried_three_times() {
        let lifted = || Trouble::Displaced("it was lifted".into());
        let sampled = |troubles| {
            sample_unkept(
                &mut Wired {
                    degrees_a_cycle: 1.5,
                    troubles,
                },
                &[wall()],
            )
        };
        assert!(sampled(vec![lifted(), Trouble::Unreadable("no answer".into())]).is_ok());
        assert!(sampled(vec![lifted(), lifted(), lifted()]).is_err());
        assert!(sampled(vec![Trouble::Broken("no power".into())]).is_err());
    }

    #[test]
    fn a_notebook_resumes_and_belongs_to_one_robot() {
        let directory = std::env::temp_dir().join(format!("oneiro-notebook-{}", std::process::id()));
        let mut robot = Wired {
            degrees_a_cycle: 1.5,
            troubles: vec![Trouble::Broken("the battery is empty".into())],
        };
        let notebook = Notebook::open(&directory, &robot.describe()).unwrap();
        let kept = |robot: &mut Wired| notebook.row("wall-00", robot, (1, 0), |robot| row(robot, &wall(), 0));
        assert!(kept(&mut robot).is_err());
        let first = kept(&mut robot).unwrap();
        robot.troubles = vec![Trouble::Broken("the battery is empty".into())];
        assert_eq!(kept(&mut robot).unwrap(), first, "it was not asked again");
        let again = Notebook::open(&directory, &robot.describe());
        let other = Notebook::open(&directory, "another robot");
        fs::remove_dir_all(&directory).unwrap();
        assert!(again.is_ok());
        assert!(
            other
                .unwrap_err()
                .to_string()
                .contains("holds samples of another robot")
        );
    }
}
