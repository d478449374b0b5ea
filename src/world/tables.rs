//! Sampled tables: measured readings of a robot's sensors, and measured motions of its motors.
//!
//! [`SensorTables::khepera`] and [`MotorSamples::khepera`] are compiled in: a Khepera synthesised from published
//! statistics, not a recording. Read recordings with [`SensorTables::read`] and [`MotorSamples::read`].

mod sam;
#[cfg(test)]
mod synthesis;

use std::path::{Path, PathBuf};
use std::sync::{Arc, LazyLock};

pub use crate::genes::{SENSOR_NAMES, SENSORS};
pub use sam::Format;

use crate::parameter::{Choice, Choices, LEAST};

/// Most sensors of a table.
pub const GREATEST_SENSORS: usize = 64;

/// Maximum reading of a sensor: ten bits.
pub const GREATEST_READING: u16 = 1023;

/// Reason why a table couldn't be read or written, and where.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Error {
    /// The file.
    pub path: PathBuf,
    /// Line with the problem, counted from 1, if it is a single line.
    pub line: Option<usize>,
    /// The problem and what is allowed.
    pub problem: String,
}

impl std::fmt::Display for Error {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", self.path.display())?;
        if let Some(line) = self.line {
            write!(f, ", line {line}")?;
        }
        write!(f, ": {}", self.problem)
    }
}

impl std::error::Error for Error {}

/// A table read from a file, with warnings.
#[derive(Clone, Debug, PartialEq)]
pub struct Import<T> {
    /// The table.
    pub table: T,
    /// Warnings for the user, each with its file.
    pub warnings: Vec<String>,
}

/// Readings of objects of one class, by distance and bearing.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorTable {
    /// Class of object that was sampled, such as `wall` or `round`.
    pub class: String,
    /// Number of sensors, 1 to 64; a Khepera has 8.
    pub sensors: u32,
    /// Number of distances.
    pub rows: u32,
    /// Number of bearings in a full turn, clockwise from the heading: number k is the object at k / bearings turns.
    pub bearings: u32,
    /// Gap in mm between the robot's rim and the nearest point of the object in the first row.
    pub nearest: f32,
    /// Distance between rows, mm.
    pub spacing: f32,
    /// Number of points of view: 1 for an object that looks the same from everywhere. Otherwise number k is for a robot
    /// whose direction from the block, relative to the block's length, is between k and k + 1 times `1 / (2 views)`
    /// turns. From the opposite side a block looks the same.
    pub views: u32,
    /// Readings from 0 to 1023, at `cell * sensors + sensor`; the cell of a row and a bearing is
    /// `(view * rows + row) * bearings + bearing`.
    pub readings: Vec<u16>,
}

impl SensorTable {
    /// Reads a `.sam` or `.sample` file. The class is the file's name without its extension.
    ///
    /// A file begins with the line `sensors bearings rows nearest spacing`. Each row follows with a line `TURN row` and
    /// a line of readings for each bearing, one for each sensor; `END` ends the file. Readings are integers from 0 to 1023 in `.sam`, and
    /// these divided by 1023 in `.sample`. If an object was sampled from several points of view, their number is the
    /// sixth number of the first line, and the rows of all views follow one another with consecutive numbers. That is
    /// this project's own extension. `docs/khepera.md` has examples.
    ///
    /// # Errors
    /// The file can't be read; or the line that breaks the format, and what is allowed there.
    pub fn read(path: impl AsRef<Path>) -> Result<Import<Self>, Error> {
        let path = path.as_ref();
        sam::parse_sensors(&sam::load(path)?, path, Format::of(path)?)
    }

    /// Writes a new file in the format of its extension, `.sam` or `.sample`.
    ///
    /// # Errors
    /// The file exists already or can't be written; another extension.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        let path = path.as_ref();
        sam::save(path, &sam::print_sensors(self, Format::of(path)?))
    }

    /// Formats the table as the text of a `.sam` file.
    pub fn text(&self) -> String {
        sam::print_sensors(self, Format::Sam)
    }

    /// Formats the table as the text of a file of this format.
    pub fn text_in(&self, format: Format) -> String {
        sam::print_sensors(self, format)
    }

    /// Readings of all sensors in a cell, see [`SensorTable::readings`].
    pub fn cell(&self, cell: usize) -> &[u16] {
        &self.readings[cell * self.sensors as usize..][..self.sensors as usize]
    }

    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.views as usize * self.rows as usize * self.bearings as usize
    }

    /// Gap from the rim beyond which an object isn't sensed, mm.
    pub fn reach(&self) -> f32 {
        self.nearest + self.rows as f32 * self.spacing
    }
}

/// Sensor tables of a robot, one for each class of object.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorTables {
    /// Tables of equal shape.
    pub classes: Vec<SensorTable>,
    /// Activation of one unit of a reading: 1/1023. (Evorobot divides by 1024.)
    pub reading_scale: f32,
}

impl SensorTables {
    /// The compiled-in Khepera with the classes `wall` and `round`.
    pub fn khepera() -> Arc<Self> {
        static TABLES: LazyLock<Arc<SensorTables>> = LazyLock::new(|| {
            let built_in = |path: &str, text| {
                sam::parse_sensors(text, Path::new(path), Format::Sam)
                    .expect("the tables compiled in are read by the tests")
                    .table
            };
            Arc::new(SensorTables::new(vec![
                built_in("wall.sam", include_str!("tables/khepera/wall.sam")),
                built_in("round.sam", include_str!("tables/khepera/round.sam")),
            ]))
        });
        Arc::clone(&TABLES)
    }

    /// Makes tables whose readings count as 1/1023 each.
    pub fn new(classes: Vec<SensorTable>) -> Self {
        Self {
            classes,
            reading_scale: 1.0 / f32::from(GREATEST_READING),
        }
    }

    /// Reads one file for each class, like [`SensorTable::read`], and warns of classes with equal readings.
    ///
    /// # Errors
    /// As [`SensorTable::read`]; two files of one class; a shape that differs from the first file's.
    pub fn read<P: AsRef<Path>>(paths: &[P]) -> Result<Import<Self>, Error> {
        let mut warnings = Vec::new();
        let mut classes: Vec<SensorTable> = Vec::new();
        for path in paths {
            let path = path.as_ref();
            let import = SensorTable::read(path)?;
            let error = |problem| Error {
                path: path.to_owned(),
                line: None,
                problem,
            };
            for (other, other_path) in classes.iter().zip(paths) {
                if other.class == import.table.class {
                    return Err(error(format!(
                        "a second table of the class {}; allowed: one file per class, named after it",
                        other.class
                    )));
                }
                if shape(other) != shape(&import.table) {
                    return Err(error(format!(
                        "{}, but {} has {}; allowed: tables of one shape",
                        shape(&import.table),
                        other_path.as_ref().display(),
                        shape(other)
                    )));
                }
                if other.readings == import.table.readings {
                    warnings.push(format!(
                        "{} and {} hold the same readings: the robot can't distinguish {} from {}",
                        other_path.as_ref().display(),
                        path.display(),
                        other.class,
                        import.table.class
                    ));
                }
            }
            warnings.extend(import.warnings);
            classes.push(import.table);
        }
        Ok(Import {
            table: Self::new(classes),
            warnings,
        })
    }

    /// Number of sensors; 0 without classes.
    pub fn sensors(&self) -> u32 {
        self.classes.first().map_or(0, |table| table.sensors)
    }

    /// Gap from the rim beyond which no object is sensed, mm; 0 without classes.
    pub fn reach(&self) -> f32 {
        self.classes.first().map_or(0.0, SensorTable::reach)
    }

    /// Index of a class.
    pub fn class(&self, name: &str) -> Option<usize> {
        self.classes.iter().position(|table| table.class == name)
    }
}

/// Shape of a table, for messages.
fn shape(table: &SensorTable) -> String {
    format!(
        "{} sensors, {} rows of {} bearings, from {} mm in steps of {} mm",
        table.sensors, table.rows, table.bearings, table.nearest, table.spacing
    )
}

/// Measured motion of a robot in one cycle for each pair of wheel speeds.
#[derive(Clone, Debug, PartialEq)]
pub struct MotorSamples {
    /// Sampled speeds in the robot's own unit, ascending.
    pub speeds: Vec<i32>,
    /// For each pair, at `left * speeds + right`: change of heading in degrees, clockwise positive.
    pub degrees: Vec<f32>,
    /// For each pair: displacement along the heading, cm.
    pub centimetres: Vec<f32>,
}

impl MotorSamples {
    /// The compiled-in Khepera with speeds -12 to 12: in 100 ms a wheel travels 0.82 mm per unit of speed, and the
    /// effective wheel base is 54.0 mm.
    pub fn khepera() -> Self {
        const MM_PER_UNIT: f64 = 0.82;
        const WHEEL_BASE: f64 = 54.0;
        let speeds: Vec<i32> = (-12..=12).collect();
        let pairs = || {
            speeds
                .iter()
                .flat_map(|&left| speeds.iter().map(move |&right| (f64::from(left), f64::from(right))))
        };
        Self {
            degrees: pairs()
                .map(|(left, right)| {
                    ((left - right) * MM_PER_UNIT / WHEEL_BASE * (180.0 / std::f64::consts::PI)) as f32
                })
                .collect(),
            centimetres: pairs()
                .map(|(left, right)| ((left + right) * (MM_PER_UNIT / 20.0)) as f32)
                .collect(),
            speeds,
        }
    }

    /// Reads a motor `.sam` file. It has one line for each speed of the left wheel and one column for each speed of the
    /// right wheel, first with changes of heading in degrees clockwise, then with displacements in cm. An odd number of
    /// speeds n counts from -(n - 1)/2 to (n - 1)/2; an even number leaves out 0.
    ///
    /// # Errors
    /// The file can't be read; or the line that breaks the format, and what is allowed there.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref();
        sam::parse_motors(&sam::load(path)?, path)
    }

    /// Formats the samples as the text of a `.sam` file. [`MotorSamples::read`] can only recover the speeds if they are
    /// all integers from -n to n, with or without 0.
    pub fn text(&self) -> String {
        sam::print_motors(self)
    }

    /// Writes a new `.sam` file.
    ///
    /// # Errors
    /// The file exists already or can't be written; or [`MotorSamples::read`] couldn't recover the speeds.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        let path = path.as_ref();
        if self.speeds != sam::speeds(self.speeds.len()) {
            return Err(Error {
                path: path.to_owned(),
                line: None,
                problem: "can't hold these speeds; allowed: every integer from -n to n, with or without 0".into(),
            });
        }
        sam::save(path, &sam::print_motors(self))
    }
}

/// The sampled speeds that a wheel uses, and the rule by which an output in `0..=1` selects one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum MotorStates {
    /// -10 to 10 without 0, state `floor(20 output)`: as many speeds backwards as forwards.
    #[default]
    Symmetric20,
    /// -10 to 9, state `floor(20 output)`.
    Asymmetric20,
    /// -10 to 10, state `round(20 output)`, as in Evorobot.
    Evorobot21,
}

impl Choice for MotorStates {
    const CHOICES: Choices<Self> = &[
        (
            "symmetric",
            Self::Symmetric20,
            "-10 to 10 without 0: as fast backwards as forwards",
        ),
        ("asymmetric", Self::Asymmetric20, "-10 to 9"),
        ("evorobot", Self::Evorobot21, "-10 to 10, 21 states, as in Evorobot"),
    ];
}

impl MotorStates {
    /// Speeds of the states in ascending order, fastest backwards first.
    pub fn speeds(self) -> Vec<i32> {
        match self {
            Self::Symmetric20 => (-10..=-1).chain(1..=10).collect(),
            Self::Asymmetric20 => (-10..=9).collect(),
            Self::Evorobot21 => (-10..=10).collect(),
        }
    }
}

/// Motions for each pair of motor states.
#[derive(Clone, Debug, PartialEq)]
pub struct MotorTable {
    /// Number of states of a wheel.
    pub states: u32,
    /// Motions at `left * states + right`.
    pub cells: Vec<MotorCell>,
    /// With `offset`: the state of an output in `0..=1` is `floor(output * scale + offset)`, at most the last.
    pub scale: f32,
    /// See `scale`.
    pub offset: f32,
}

/// Motion of one pair of motor states in one cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MotorCell {
    /// Along the heading, mm.
    pub displacement: f32,
    /// Counter-clockwise, turns.
    pub turn: f32,
    /// The left wheel's signed speed as a fraction of the maximum, -1 to 1.
    pub left: f32,
    /// The right wheel's signed speed as a fraction of the maximum, -1 to 1.
    pub right: f32,
}

/// A number, or zero if kernels don't take anything that small.
fn negligible_as_zero(number: f32) -> f32 {
    if number.abs() < LEAST { 0.0 } else { number }
}

impl MotorTable {
    /// The compiled-in Khepera.
    pub fn khepera(states: MotorStates) -> Arc<Self> {
        static TABLES: LazyLock<[Arc<MotorTable>; 3]> = LazyLock::new(|| {
            [
                MotorStates::Symmetric20,
                MotorStates::Asymmetric20,
                MotorStates::Evorobot21,
            ]
            .map(|states| {
                let table = MotorTable::new(&MotorSamples::khepera(), states);
                Arc::new(table.expect("the speeds -12 to 12 have all states"))
            })
        });
        Arc::clone(&TABLES[states as usize])
    }

    /// Selects the states' speeds from samples. Motion that is too little for a kernel, below a millionth of a mm or of a
    /// turn in a cycle, counts as none.
    ///
    /// # Errors
    /// The first speed that was not sampled.
    pub fn new(samples: &MotorSamples, states: MotorStates) -> Result<Self, i32> {
        let speeds = states.speeds();
        let greatest = speeds.iter().fold(1, |greatest, speed| speed.abs().max(greatest)) as f32;
        let columns = speeds
            .iter()
            .map(|speed| samples.speeds.iter().position(|sampled| sampled == speed).ok_or(*speed))
            .collect::<Result<Vec<_>, _>>()?;
        let mut cells = Vec::with_capacity(speeds.len() * speeds.len());
        for (&left, &left_speed) in columns.iter().zip(&speeds) {
            for (&right, &right_speed) in columns.iter().zip(&speeds) {
                let sample = left * samples.speeds.len() + right;
                cells.push(MotorCell {
                    displacement: negligible_as_zero(samples.centimetres[sample] * 10.0),
                    // Subtracted rather than negated: zero has one sign.
                    turn: negligible_as_zero(0.0 - samples.degrees[sample] / 360.0),
                    left: left_speed as f32 / greatest,
                    right: right_speed as f32 / greatest,
                });
            }
        }
        let (scale, offset) = match states {
            MotorStates::Symmetric20 | MotorStates::Asymmetric20 => (20.0, 0.0),
            MotorStates::Evorobot21 => (20.0, 0.5),
        };
        Ok(Self {
            states: speeds.len() as u32,
            cells,
            scale,
            offset,
        })
    }

    /// Speed of a wheel whose share is 1, mm/s: that of the robot when both wheels have their fastest state. `None` if there are
    /// no speeds between states: unless they are at least 2, have ascending speeds, the same for both wheels, and the robot goes
    /// forwards or backwards as the fastest says.
    pub fn full_speed(&self) -> Option<f32> {
        /// Minimum difference between the speeds of two states.
        const LEAST_STEP: f32 = 1e-4;
        let states = self.states as usize;
        let both = |state: usize| &self.cells[state * states + state];
        let has_speeds = |(index, cell): (usize, &MotorCell)| {
            let [left, right] = [both(index / states), both(index % states)].map(|cell| cell.left);
            (cell.left, cell.right) == (left, right)
        };
        let ascends = |state: usize| both(state).left - both(state - 1).left >= LEAST_STEP;
        let fastest = [0, states.checked_sub(1)?].map(both);
        let fastest = fastest
            .into_iter()
            .max_by(|a, b| a.left.abs().total_cmp(&b.left.abs()))?;
        let speed = 10.0 * fastest.displacement / fastest.left;
        let is_between = states > 1 && (1..states).all(ascends) && self.cells.iter().enumerate().all(has_speeds);
        // Slower robots than described ones aren't allowed either.
        (is_between && speed >= 0.01).then_some(speed)
    }

    /// Reads a motor `.sam` file, like [`MotorSamples::read`], and selects the states' speeds.
    ///
    /// # Errors
    /// As [`MotorSamples::read`]; a speed that was not sampled.
    pub fn read(path: impl AsRef<Path>, states: MotorStates) -> Result<Self, Error> {
        let path = path.as_ref();
        let samples = MotorSamples::read(path)?;
        Self::new(&samples, states).map_err(|speed| Error {
            path: path.to_owned(),
            line: None,
            problem: format!(
                "has no speed {speed}, but {} speeds; allowed: samples of all speeds from {} to {}",
                samples.speeds.len(),
                states.speeds()[0],
                states.speeds().last().copied().unwrap_or_default()
            ),
        })
    }
}
