//! Sampling of a robot on a wire, row by row: somebody places it, it turns or drives, and each row is saved at once.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use oneiro::tables::{GREATEST_READING, MotorSamples, SensorTables};
use oneiro_base::console::Console;
use oneiro_base::disk;
use oneiro_base::exit::{Failure, Result};
use oneiro_lab::reality::sampling::{self, BEARINGS, Grid, Notebook, Row, SPEEDS};
use oneiro_lab::reality::turning::{self, Overlap, Turn, Turning};
use oneiro_lab::reality::{Driven, Object, Shape, Trouble};
use oneiro_report::figures;
use oneiro_robots::vehicle::Vehicle;
use serde_json::json;

use super::person::{Answer, Person, Place};

/// A whole turn may be this far off, degrees.
const MOST_DRIFT: f64 = 4.0;
/// Readings at the same bearings may differ by this in the mean, of 1023.
const MOST_DIFFERENCE: f64 = 60.0;
/// The name of what is known of the robot's turns in its notebook.
const TURNING: &str = "turning";

/// What is sampled.
#[derive(Clone, Debug)]
pub(super) struct Plan {
    pub(super) objects: Vec<Object>,
    pub(super) grid: Grid,
    /// Turns before each object, whose mean is taken.
    pub(super) turns: u32,
    /// Speed of a wheel at 10 of -10 to 10, mm/s; none if motors are not sampled.
    pub(super) full_mm_s: Option<f64>,
}

/// One row.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Step<'a> {
    Turn { object: &'a Object, number: u32 },
    Motors { number: usize },
}

impl Step<'_> {
    fn name(self) -> String {
        match self {
            Self::Turn { object, number } => sampling::row_name(object, number),
            Self::Motors { number } => sampling::motors_name(number),
        }
    }
}

impl Plan {
    fn steps(&self) -> Vec<Step<'_>> {
        let rows = |object: &Object| object.views() * self.grid.rows;
        let turns = self.objects.iter();
        let turns = turns.flat_map(|object| (0..rows(object)).map(move |number| Step::Turn { object, number }));
        let motors = self.full_mm_s.map_or(0, |_| SPEEDS.count());
        turns.chain((0..motors).map(|number| Step::Motors { number })).collect()
    }

    /// One line that says which samples these are.
    pub(super) fn describe(&self, vehicle: &dyn Vehicle) -> String {
        let profile = vehicle.profile();
        let motors = self
            .full_mm_s
            .map_or(String::new(), |speed| format!(", full speed {speed} mm/s"));
        format!("{} {}, {} turns{motors}", profile.robot, profile.firmware, self.turns)
    }
}

/// One line that says how an object is sampled.
fn of_object(object: &Object, Grid { nearest, spacing, rows }: Grid) -> String {
    format!(
        "{:?}, {rows} rows from {nearest} mm in steps of {spacing} mm",
        object.shape
    )
}

fn object_name(object: &Object) -> String {
    format!("{}-object", object.class)
}

/// Whether objects can be sampled into a directory, as far as this can be checked without the robot.
///
/// # Errors
/// Exit 3 if it has rows of other distances or of another object of the same class; exit 6 if it can't be written.
pub(super) fn check(objects: &[Object], grid: Grid, directory: &Path) -> Result {
    let notebook = Notebook::at(directory)?;
    for object in objects {
        let known = notebook.read::<String>(&object_name(object))?;
        if let Some(known) = known.filter(|known| *known != of_object(object, grid)) {
            return Err(Failure::input(format_args!(
                "{}: has rows of `{}` as {known}; allowed: the same, or another directory",
                directory.display(),
                object.class
            )));
        }
    }
    Ok(())
}

/// A sampling in progress.
pub(super) struct Walk<'a> {
    pub(super) vehicle: &'a mut dyn Vehicle,
    pub(super) person: &'a mut dyn Person,
    pub(super) plan: &'a Plan,
    pub(super) directory: &'a Path,
    pub(super) stop: &'a AtomicBool,
    pub(super) console: Console,
    pub(super) notebook: Notebook,
}

impl<'a> Walk<'a> {
    /// Starts a sampling in a directory, or resumes the one that the directory holds.
    ///
    /// # Errors
    /// Exit 3 if the directory has rows of another robot, of other distances or of another object of the same class; exit 6 if
    /// it can't be written.
    pub(super) fn new(
        vehicle: &'a mut dyn Vehicle,
        person: &'a mut dyn Person,
        plan: &'a Plan,
        directory: &'a Path,
        stop: &'a AtomicBool,
        console: Console,
    ) -> Result<Self> {
        let notebook = Notebook::open(directory, &plan.describe(vehicle))?;
        check(&plan.objects, plan.grid, directory)?;
        for object in &plan.objects {
            notebook.save(&object_name(object), &of_object(object, plan.grid))?;
        }
        Ok(Self {
            vehicle,
            person,
            plan,
            directory,
            stop,
            console,
            notebook,
        })
    }

    /// Takes the rows that are missing.
    ///
    /// # Errors
    /// Exit 75 if it was stopped; the robot's troubles; exit 6 if a row can't be saved.
    pub(super) fn go(&mut self) -> Result<(SensorTables, Option<MotorSamples>)> {
        let steps = self.plan.steps();
        let mut turning = self.turning()?;
        let (mut at, mut placed) = (0, None);
        while let Some(&step) = steps.get(at) {
            if self.is_taken(step)? {
                at += 1;
                continue;
            }
            let place = self.place(step);
            // For motors it is placed once.
            if placed != Some(place) || !matches!(place, Place::Open(_)) {
                let left = self.minutes(&steps, turning)?;
                let mut words = format!(
                    "row {} of {}, {left:.0} min left: {}",
                    at + 1,
                    steps.len(),
                    words(&place)
                );
                if !turning.1 {
                    words += ". First it turns three times, to measure its turns; then place it again";
                }
                match self.person.place(self.vehicle, &place, &words)? {
                    Answer::Back => {
                        at = at.saturating_sub(1);
                        self.notebook.forget(&steps[at].name())?;
                        placed = None;
                        continue;
                    }
                    Answer::Quit => return Err(Trouble::Stopped.into()),
                    Answer::Go | Answer::Again => placed = Some(place),
                }
            }
            match self.take(step, &mut turning) {
                Ok(true) => at += 1,
                Ok(false) => placed = None,
                Err(Taking::Failed(failure)) => return Err(failure),
                Err(Taking::Troubled(trouble)) => {
                    self.recover(trouble)?;
                    placed = None;
                }
            }
        }
        self.samples()
    }

    /// Waits until the robot can be driven again.
    fn recover(&mut self, trouble: Trouble) -> Result {
        if !trouble.may_pass() {
            return Err(trouble.into());
        }
        self.person.troubled(trouble)?;
        Ok(self.vehicle.recover()?)
    }

    /// The turns of the robot, if they were measured; otherwise its speed, for an estimate.
    fn turning(&mut self) -> Result<(Turning, bool)> {
        if let Some(known) = self.notebook.read(TURNING)? {
            return Ok((known, true));
        }
        let wheel_mm_s = loop {
            match turning::pace(self.vehicle) {
                Ok(speed) => break speed,
                Err(trouble) => self.recover(trouble)?,
            }
        };
        let guess = Turning {
            wheel_mm_s,
            apparent: 1.0,
        };
        Ok((guess, false))
    }

    fn is_taken(&self, step: Step<'_>) -> Result<bool> {
        Ok(match step {
            Step::Turn { .. } => self.notebook.read::<Row>(&step.name())?.is_some(),
            Step::Motors { .. } => self.notebook.read::<Vec<Driven>>(&step.name())?.is_some(),
        })
    }

    fn place<'s>(&self, step: Step<'s>) -> Place<'s> {
        match step {
            Step::Turn { object, number } => {
                let (view, gap) = self.plan.grid.place(object, number);
                Place::Before { object, view, gap }
            }
            Step::Motors { .. } => Place::Open(turning::reach_mm(self.plan.full_mm_s.unwrap_or(0.0))),
        }
    }

    /// Estimate of the time that the robot needs for all missing rows, min.
    fn minutes(&self, steps: &[Step<'_>], (turning, _): (Turning, bool)) -> Result<f64> {
        let mut seconds = 0.0;
        for step in steps {
            if !self.is_taken(*step)? {
                seconds += match step {
                    Step::Turn { .. } => turning.seconds(self.vehicle.profile().base_mm, self.plan.turns),
                    Step::Motors { .. } => SPEEDS.count() as f64 * turning::seconds_a_pair(),
                };
            }
        }
        Ok((seconds / 60.0).ceil())
    }

    /// Takes a row and keeps it. Returns whether it is kept. Until the turns of the robot have been measured, only those
    /// are: each row begins where the robot was placed, also on another day.
    fn take(&mut self, step: Step<'_>, turning: &mut (Turning, bool)) -> std::result::Result<bool, Taking> {
        match step {
            Step::Turn { object, number } => {
                if !turning.1 {
                    *turning = (turning::measured(self.vehicle, turning.0.wheel_mm_s, self.stop)?, true);
                    self.notebook.save(TURNING, &turning.0)?;
                    let percent = 100.0 * turning.0.apparent;
                    self.console
                        .say(format!("a whole turn is {percent:.1} % of what its wheels measure"));
                    return Ok(false);
                }
                let turn = turning::turn_before(self.vehicle, turning.0, self.plan.turns, self.stop)?;
                let row = turn
                    .row()
                    .map_err(|bearing| Failure::failed(format_args!("no bearing {bearing}")))?;
                Ok(self.keep(object, number, &turn, &row)?)
            }
            Step::Motors { number } => {
                let full = self.plan.full_mm_s.unwrap_or(0.0);
                let left = SPEEDS.start() + number as i32;
                let mut row = Vec::new();
                for right in SPEEDS {
                    let speeds = (left, right);
                    row.push(turning::drive(
                        self.vehicle,
                        speeds,
                        full,
                        turning.0.apparent,
                        self.stop,
                    )?);
                }
                self.notebook.save(&step.name(), &row)?;
                self.person.row_kept();
                self.console
                    .say(format!("motors: {left} of the left wheel with all of the right"));
                self.console
                    .print_line("", &json!({ "row": step.name(), "left": left }))?;
                Ok(true)
            }
        }
    }

    /// Shows a row, and keeps it if nothing is wrong with it or if the person says so.
    fn keep(&mut self, object: &Object, number: u32, turn: &Turn, row: &Row) -> Result<bool> {
        let name = sampling::row_name(object, number);
        let names = self.names();
        let doubts = doubts(
            turn.overlap,
            row,
            &names,
            number % self.plan.grid.rows < self.plan.grid.rows / 2,
        );
        let (view, gap) = self.plan.grid.place(object, number);
        self.console.say(lines(&names, row) + "\n" + &end_of_turn(turn.overlap));
        let line = json!({
            "row": name,
            "class": object.class,
            "view_turns": view,
            "gap_mm": gap,
            "drift_degrees": match turn.overlap {
                Overlap::Late { drift, .. } => (3600.0 * drift).round() / 10.0,
                _ => f64::NAN,
            },
            "doubts": doubts.iter().map(|(words, _)| words).collect::<Vec<_>>(),
        });
        self.console.print_line("", &line)?;
        if !doubts.is_empty() {
            let words: Vec<&str> = doubts.iter().map(|(words, _)| words.as_str()).collect();
            let is_useless = doubts.iter().any(|(_, is_useless)| *is_useless);
            let words = format!("{name}: {}", words.join("; "));
            match self.person.decide(self.vehicle, &words, is_useless)? {
                Answer::Go => {}
                Answer::Quit => return Err(Trouble::Stopped.into()),
                Answer::Again | Answer::Back => return Ok(false),
            }
        }
        self.notebook.save(&name, row)?;
        self.person.row_kept();
        let picture = figures::sensor_table(&sampling::table(
            object,
            self.plan.grid,
            &self.rows(object, names.len())?,
        ));
        disk::write(
            &self.directory.join(format!("{}.svg", object.class)),
            picture.as_bytes(),
        )?;
        Ok(true)
    }

    /// Names of the sensors.
    fn names(&self) -> Vec<String> {
        let sensors = self.vehicle.profile().sensors.iter();
        sensors.flat_map(|sensors| sensors.names.iter().cloned()).collect()
    }

    /// Rows of an object; those that are missing read nothing.
    fn rows(&self, object: &Object, sensors: usize) -> Result<Vec<Row>> {
        let row = |number| {
            let row = self.notebook.read(&sampling::row_name(object, number))?;
            Ok(row.unwrap_or_else(|| vec![vec![0; sensors]; BEARINGS as usize]))
        };
        (0..object.views() * self.plan.grid.rows).map(row).collect()
    }

    fn samples(&self) -> Result<(SensorTables, Option<MotorSamples>)> {
        let sensors = self.names().len();
        let table = |object| Ok(sampling::table(object, self.plan.grid, &self.rows(object, sensors)?));
        let tables = self.plan.objects.iter().map(table).collect::<Result<_>>()?;
        let motors = (0..SPEEDS.count()).map(|number| self.notebook.read(&sampling::motors_name(number)));
        let motors: Option<Vec<Vec<Driven>>> = motors.collect::<Result<_>>()?;
        let motors = motors.filter(|_| self.plan.full_mm_s.is_some());
        Ok((SensorTables::new(tables), motors.map(|rows| sampling::motors(&rows))))
    }
}

/// Why a row is not taken.
enum Taking {
    Troubled(Trouble),
    Failed(Failure),
}

impl From<Trouble> for Taking {
    fn from(trouble: Trouble) -> Self {
        Self::Troubled(trouble)
    }
}

impl From<Failure> for Taking {
    fn from(failure: Failure) -> Self {
        Self::Failed(failure)
    }
}

/// Where a person has to put the robot.
fn words(place: &Place<'_>) -> String {
    match *place {
        Place::Before { object, view, gap } => {
            let (what, point, direction) = match object.shape {
                Shape::Wall => (format!("the {}, a wall", object.class), "it", String::new()),
                Shape::Round { radius } => (
                    format!("the {}, a cylinder of {radius} mm radius", object.class),
                    "its middle",
                    String::new(),
                ),
                Shape::Block { length, width } => (
                    format!("the {}, a block of {length} x {width} mm", object.class),
                    "its nearest point",
                    format!(
                        "; seen from above, the line from the block's centre to the robot's is {:.1} degrees \
                         counter-clockwise off the block's length",
                        360.0 * view
                    ),
                ),
            };
            format!(
                "put the robot's rim {gap} mm from {what}, heading straight at {point}{direction}. Nothing else near it"
            )
        }
        Place::Open(reach) => format!(
            "motors: put the robot on the floor with {:.1} m free on all sides. It drives up to {:.1} m and back",
            (2.0 * reach / 1000.0).max(0.5),
            reach / 1000.0
        ),
    }
}

/// A line on the end of a turn.
fn end_of_turn(overlap: Overlap) -> String {
    match overlap {
        Overlap::Blank => "whole turn: by the wheels; too little is sensed here to check it".into(),
        Overlap::Unlike => "whole turn: not recognised".into(),
        Overlap::Late { drift, difference } => format!(
            "whole turn: {:.1} degrees off; readings repeat to within {difference:.0} of {GREATEST_READING}",
            360.0 * drift.abs()
        ),
    }
}

/// What may be wrong with a row, and whether that makes it useless. In near rows the sensors must read something.
fn doubts(overlap: Overlap, row: &Row, names: &[String], is_near: bool) -> Vec<(String, bool)> {
    let mut doubts = Vec::new();
    match overlap {
        Overlap::Unlike => {
            let words =
                "its readings differ after a whole turn: it has not turned exactly once, or something has moved";
            doubts.push((words.to_owned(), true));
        }
        Overlap::Late { drift, difference } => {
            let degrees = 360.0 * drift.abs();
            if degrees > MOST_DRIFT {
                doubts.push((
                    format!("a whole turn was {degrees:.0} degrees off; allowed: {MOST_DRIFT}"),
                    true,
                ));
            }
            if difference > MOST_DIFFERENCE {
                let words = format!(
                    "readings of the same bearings differ by {difference:.0} on average; allowed: {MOST_DIFFERENCE} of \
                     {GREATEST_READING}"
                );
                doubts.push((words, false));
            }
        }
        Overlap::Blank => {}
    }
    let saturated: Vec<&str> = (0..names.len())
        .filter(|&sensor| 2 * row.iter().filter(|cell| cell[sensor] >= GREATEST_READING).count() > row.len())
        .map(|sensor| names[sensor].as_str())
        .collect();
    if !saturated.is_empty() {
        doubts.push((
            format!(
                "the maximum reading at more than half of the bearings: {}",
                saturated.join(", ")
            ),
            false,
        ));
    }
    if is_near && row.iter().flatten().all(|reading| *reading == 0) {
        doubts.push(("all readings are 0".to_owned(), false));
    }
    doubts
}

/// A line for each sensor: its readings by the object's bearing, from straight ahead clockwise.
fn lines(names: &[String], row: &Row) -> String {
    const BARS: [char; 9] = [' ', '▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
    /// Bearings of a character.
    const WIDTH: usize = 3;
    let longest = names.iter().map(|name| name.chars().count()).max().unwrap_or(0);
    let line = |(sensor, name): (usize, &String)| {
        let bar = |cells: &[Vec<u16>]| {
            let most = cells.iter().map(|cell| cell[sensor]).max().unwrap_or(0);
            BARS[(usize::from(most) * 8).div_ceil(usize::from(GREATEST_READING)).min(8)]
        };
        let bars: String = row.chunks(WIDTH).map(bar).collect();
        format!("{name:>longest$} |{bars}|")
    };
    names.iter().enumerate().map(line).collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod emulated;
#[cfg(test)]
mod tests;
