//! Robots' reports: the operator's table `statuses.csv`, and the same for a page.

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

use csv::{ReaderBuilder, WriterBuilder};
use oneiro::swarm::SECOND;
use oneiro_base::contents::{Column, head};
use oneiro_base::disk;
use oneiro_base::exit::{Failure, Result};
use oneiro_base::files;
use oneiro_base::plain;
use oneiro_report::figures::{Act, Genes, Moment, Sight};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::operator::Known;
use super::table::{known_value, problems, state};

/// The table.
pub(crate) const STATUSES: &str = "statuses.csv";
pub(crate) static STATUSES_COLUMNS: [Column; 17] = [
    Column::whole("second", "s", "of the experiment"),
    Column::whole("robot", "", "its number"),
    Column::text(
        "state",
        "its activity, or `silent` if it has never sent anything, `away` if not for 3 s, `ready` if it has not \
         reported an activity, `refused` if it may not take part",
    ),
    Column::number("age_s", "s", "age of its last report; empty if there was none"),
    Column::whole(
        "interval",
        "",
        "the interval that it is in; this and all below except `problems` are empty if nothing was received for 3 s, \
         or it is refused",
    ),
    Column::number("s0", "0 to 0.99", "the gene of its simulator"),
    Column::number("g0", "0 to 0.99", "the gene of its controller's behaviour with food"),
    Column::number("g1", "0 to 0.99", "the gene of its behaviour without food"),
    Column::number("real", "", "its fitness in the interval so far"),
    Column::number(
        "simulated",
        "",
        "the fitness of its controller in the simulator; empty if none was chosen there yet",
    ),
    Column::whole("brought", "items", "food that it has brought so far"),
    Column::whole("carries", "", "1 if it carries food"),
    Column::number("x", "mm", "its position; empty if the tracker does not see it"),
    Column::number("y", "mm", "its position"),
    Column::number("heading", "turns", "counter-clockwise from the x axis"),
    Column::number("volts", "V", "the voltage of its battery; empty if unknown"),
    Column::text("problems", "its problems now, if any"),
];

/// A robot in a second.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Row {
    pub second: u32,
    pub robot: u32,
    pub state: String,
    pub(crate) age_s: Option<f32>,
    pub interval: Option<u32>,
    pub s0: Option<f32>,
    pub g0: Option<f32>,
    pub g1: Option<f32>,
    pub real: Option<f32>,
    pub simulated: Option<f32>,
    pub brought: Option<u32>,
    pub carries: Option<u8>,
    pub x: Option<f32>,
    pub y: Option<f32>,
    pub heading: Option<f32>,
    pub volts: Option<f32>,
    pub problems: String,
}

impl Row {
    /// What is known of a robot in a second. Of one that has fallen silent that is only when it spoke last.
    pub(super) fn of(second: u32, robot: u32, known: &Known) -> Self {
        let age = known.heard.map(|at| at.elapsed());
        let empty = Self {
            second,
            robot,
            state: state(known),
            age_s: age.map(|age| (age.as_secs_f32() * 1000.0).round() / 1000.0),
            problems: known.refusal().unwrap_or_default().to_owned(),
            ..Self::default()
        };
        let is_here = known.is_here() && known.refusal().is_none();
        let Some(status) = known.status.as_ref().filter(|_| is_here) else {
            return empty;
        };
        let [g0, g1] = status.controller.map(Some);
        // A daemon reports zeros if its tracker does not see it.
        let pose = Some(status.pose).filter(|pose| *pose != [0.0; 3]);
        Self {
            interval: Some(status.interval),
            s0: Some(status.simulator),
            g0,
            g1,
            real: Some(status.real),
            simulated: known_value(status.simulated),
            brought: Some(status.brought),
            carries: Some(u8::from(status.carries)),
            x: pose.map(|pose| pose[0]),
            y: pose.map(|pose| pose[1]),
            heading: pose.map(|pose| pose[2]),
            volts: known_value(status.volts),
            problems: problems(known).join(", "),
            ..empty
        }
    }

    fn pose(&self) -> Option<[f32; 3]> {
        Some([self.x?, self.y?, self.heading?])
    }

    fn genes(&self) -> Option<Genes> {
        Some(Genes {
            cycle: SECOND * self.second,
            s0: self.s0?,
            g0: self.g0?,
            g1: self.g1?,
        })
    }
}

/// The table, which grows.
#[derive(Debug)]
pub(super) struct Table {
    path: PathBuf,
    file: File,
}

impl Table {
    /// Opens the table of a fleet's directory, and returns the rows that it has. A row that was torn by the end of an earlier `start`
    /// is removed.
    ///
    /// # Errors
    /// Exit 5 for a table that is none, with its line; exit 6.
    pub(super) fn open(directory: &Path) -> Result<(Self, Vec<Row>)> {
        let path = directory.join(STATUSES);
        let text = if path.exists() {
            disk::read_text(&path)?
        } else {
            String::new()
        };
        let text = files::whole_lines(&text);
        let rows = read(&path, text)?;
        let storage = |error| Failure::storage(&path, &error);
        let file = plain::append_or_create(&path).map_err(storage)?;
        file.set_len(text.len() as u64).map_err(storage)?;
        let mut table = Self { path, file };
        if text.is_empty() {
            table.write(head(&STATUSES_COLUMNS).as_bytes())?;
        }
        Ok((table, rows))
    }

    /// Adds rows.
    ///
    /// # Errors
    /// Exit 6.
    pub(super) fn add(&mut self, rows: &[Row]) -> Result {
        let mut writer = WriterBuilder::new().has_headers(false).from_writer(Vec::new());
        rows.iter()
            .try_for_each(|row| writer.serialize(row))
            .map_err(Failure::failed)?;
        let bytes = writer.into_inner().map_err(Failure::failed)?;
        self.write(&bytes)
    }

    fn write(&mut self, bytes: &[u8]) -> Result {
        let written = self.file.write_all(bytes);
        written.map_err(|error| Failure::storage(&self.path, &error))
    }
}

/// The rows of a table whose lines are whole.
///
/// # Errors
/// Exit 5 with the line.
pub(super) fn read<T: DeserializeOwned>(path: &Path, text: &str) -> Result<Vec<T>> {
    let rows = ReaderBuilder::new().from_reader(text.as_bytes()).into_deserialize();
    rows.collect::<std::result::Result<_, _>>()
        .map_err(|error| Failure::corrupt(format_args!("{}: {error}", path.display())))
}

/// The rows of a fleet's table.
///
/// # Errors
/// Exit 3 if there is none; exit 5 if it is none.
pub(super) fn rows(directory: &Path) -> Result<Vec<Row>> {
    let path = directory.join(STATUSES);
    if !path.is_file() {
        return Err(Failure::input(format_args!(
            "{}: is missing; `oneiro fleet start` writes it while it runs",
            path.display()
        )));
    }
    read(&path, files::whole_lines(&disk::read_text(&path)?))
}

/// The robots' story so far, with a line a second, or fewer: as many as make up a bounded number of robots' lines.
#[derive(Debug)]
pub(crate) struct Story {
    robots: Vec<u32>,
    /// Robots' lines that it may have.
    most: usize,
    /// Seconds between lines; only the last may be in between.
    every: u32,
    lines: Vec<Vec<Row>>,
}

impl Story {
    /// The story of these robots, from rows in the order of time.
    pub(crate) fn of(robots: Vec<u32>, most: usize, rows: Vec<Row>) -> Self {
        let mut story = Self {
            robots,
            most,
            every: 1,
            lines: Vec::new(),
        };
        let mut line: Vec<Row> = Vec::new();
        for row in rows {
            if line
                .iter()
                .any(|other| other.second != row.second || other.robot == row.robot)
            {
                story.add(std::mem::take(&mut line));
            }
            line.push(row);
        }
        if !line.is_empty() {
            story.add(line);
        }
        story
    }

    /// Adds a line, of a second. It takes the place of those that are not before it, and of a last one between those that stay.
    pub(crate) fn add(&mut self, line: Vec<Row>) {
        let second = |line: &[Row]| line.first().map_or(0, |row| row.second);
        let every = self.every;
        let now = second(&line);
        while self
            .lines
            .last()
            .is_some_and(|last| second(last) >= now || second(last) % every > 0)
        {
            self.lines.pop();
        }
        self.lines.push(line);
        while self.lines.len() > 2 && self.lines.len() * self.robots.len() > self.most {
            self.every *= 2;
            let every = self.every;
            self.lines
                .retain(|line| second(line) % every == 0 || second(line) == now);
        }
    }

    /// The same for a page. Robots of whom there is nothing have never been heard.
    pub(crate) fn moments(&self) -> Vec<Moment> {
        let mut totals = vec![0; self.robots.len()];
        let unheard = Row {
            state: "silent".to_owned(),
            ..Row::default()
        };
        let moment = |line: &Vec<Row>| {
            let sights =
                self.robots.iter().zip(&mut totals).map(|(robot, total)| {
                    sight(line.iter().find(|row| row.robot == *robot).unwrap_or(&unheard), total)
                });
            Moment {
                cycle: SECOND * line.first().map_or(0, |row| row.second),
                robots: sights.collect(),
                food: Vec::new(),
            }
        };
        self.lines.iter().map(moment).collect()
    }

    /// The genes of each robot, where they change.
    pub(crate) fn genes(&self) -> Vec<Vec<Genes>> {
        let of_robot = |robot: &u32| {
            let rows = self.lines.iter().flatten().filter(|row| row.robot == *robot);
            let mut genes: Vec<Genes> = rows.filter_map(Row::genes).collect();
            genes.dedup_by_key(|status| [status.s0, status.g0, status.g1]);
            genes
        };
        self.robots.iter().map(of_robot).collect()
    }
}

/// A row for a page, and the food that its robot has brought so far.
fn sight(row: &Row, total: &mut u32) -> Sight {
    let before = *total;
    // A robot that has lost its directory may count less than it once did.
    *total = before.max(row.brought.unwrap_or_default());
    let act = ACTS.iter().position(|act| act.short == row.state);
    Sight {
        pose: row.pose(),
        act: act.unwrap_or(ACTS.len() - 1),
        carries: row.carries == Some(1),
        brought: *total - before,
        earned: row.real,
        heard: 0,
        age: row.age_s,
        problems: row.problems.clone(),
    }
}

/// States of robots, by their words in tables; the last is for unknown words.
pub(crate) const ACTS: [Act; 11] = [
    act("waiting", "#8593b5", Act::LIGHT),
    act("standing", "#5b6b8c", Act::LIGHT),
    act("off", "#c9ccd3", Act::DARK),
    act("living", "#2a9d8f", Act::LIGHT),
    act("troubled", "#d9485f", Act::LIGHT),
    act("over", "#8a6fb0", Act::LIGHT),
    act("ready", "#ffffff", None),
    act("refused", "#7a1f2e", None),
    act("away", "#ffffff", None),
    act("silent", "#ffffff", None),
    act("unknown", "#ffffff", None),
];

const fn act(word: &'static str, colour: &'static str, front: Option<&'static str>) -> Act {
    Act {
        name: word,
        short: word,
        colour,
        front,
    }
}
