//! The record of episodes on a robot: a table of all episodes, and for each a table with a row for each cycle.
//!
//! An episode is in the index before it begins, and complete there once its table is on disk. So whatever ends the program, no
//! complete episode is repeated, and an unfinished one is marked as cut short.

use std::fmt::Display;
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

use oneiro::random::Key;
use oneiro_base::contents::{Column, Entry, describe};
use oneiro_base::disk;
use oneiro_base::exit::{Failure, Result};
use oneiro_base::files::directory::{Form, Holds};
use oneiro_base::npy::npy;
use oneiro_base::plain;
use oneiro_base::utc::now;
use oneiro_report::csv::{Csv, known};
use oneiro_robots::vehicle::late::Late;

/// The table of all episodes.
pub(crate) const INDEX: &str = "lives.csv";
/// The status of an episode that has run to its end.
pub const COMPLETE: &str = "complete";
const UNDER_WAY: &str = "under way";
/// A directory of episodes.
const FORM: Form<'_> = Form {
    mark: INDEX,
    before: &[],
    option: "--log",
};

/// Identifies an episode that is requested again.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Identity {
    key: String,
    genome: String,
    world: String,
}

impl Identity {
    /// Identity of a genome's episode with a key, in a world with this hash.
    pub(super) fn new(key: Key, genes: &[f32], world: &str) -> Self {
        let bytes: Vec<u8> = genes.iter().flat_map(|gene| gene.to_le_bytes()).collect();
        Self {
            key: format!("{:08x}{:08x}", key.words[0], key.words[1]),
            genome: short(&bytes),
            world: world.into(),
        }
    }
}

/// The first 16 digits of a hash.
pub(super) fn short(bytes: &[u8]) -> String {
    blake3::hash(bytes).to_hex()[..16].to_owned()
}

/// A row of the index.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Row {
    pub(super) number: u32,
    identity: Identity,
    began: String,
    /// x and y in mm, heading in turns.
    pub(super) start: [f32; 3],
    pub(super) cycles: u32,
    fitness: Option<f32>,
    status: String,
    late: Late,
    /// Address of the robot that ran it.
    robot: String,
}

/// The cells of a row, in the order of [`COLUMNS`].
const CELLS: usize = 17;

static COLUMNS: [Column; CELLS] = [
    Column::whole("life", "", "its number, from 1; its cycles are in life-NUMBER.csv"),
    Column::text("began", "when it began, UTC"),
    Column::text("status", "complete, or why it was cut short"),
    Column::text("key", "the key of its random numbers, in hex"),
    Column::text("genome", "hash of its genes, which are in genome-HASH.npy"),
    Column::text("world", "hash of the world, the robot's sensors and its maximum speed"),
    Column::number("start_x_mm", "mm", "where it started"),
    Column::number("start_y_mm", "mm", "where it started"),
    Column::number(
        "start_heading_turns",
        "turns",
        "where it headed, counter-clockwise from the x axis",
    ),
    Column::whole("cycles", "100 ms", "cycles that were run"),
    Column::number("fitness", "", "its fitness, if it is complete"),
    Column::text("bits", "the fitness as its 32 bits, in hex"),
    Column::number("late_min_ms", "ms", "how late a cycle's command was sent: minimum"),
    Column::number("late_median_ms", "ms", "the same: median"),
    Column::number("late_99_ms", "ms", "the same: 99 % were not later"),
    Column::number("late_max_ms", "ms", "the same: maximum"),
    Column::text("robot", "address of the robot that ran it"),
];

impl Row {
    /// Whether it has run to its end.
    pub(super) fn is_complete(&self) -> bool {
        self.status == COMPLETE
    }

    /// Its fitness, if it is complete.
    pub(super) fn fitness(&self) -> Option<f32> {
        self.fitness.filter(|_| self.is_complete())
    }

    fn cells(&self) -> [String; CELLS] {
        let [x, y, heading] = self.start.map(|number| number.to_string());
        let [min, median, high, max] = self.late.quantiles().map(known);
        let Identity { key, genome, world } = self.identity.clone();
        let (fitness, bits) = self.fitness.map_or_else(Default::default, |fitness| {
            (fitness.to_string(), format!("{:08x}", fitness.to_bits()))
        });
        let (began, status) = (self.began.clone(), self.status.clone());
        [
            self.number.to_string(),
            began,
            status,
            key,
            genome,
            world,
            x,
            y,
            heading,
            self.cycles.to_string(),
            fitness,
            bits,
            min,
            median,
            high,
            max,
            self.robot.clone(),
        ]
    }

    fn read(cells: &csv::StringRecord) -> Option<Self> {
        let text = |cell: usize| cells.get(cell).map(str::to_owned);
        let float = |cell: usize| cells.get(cell)?.parse::<f32>().ok();
        let late = |cell: usize| cells.get(cell).map(|text| text.parse::<f64>().unwrap_or(f64::NAN));
        let bits = cells.get(11)?;
        Some(Self {
            number: cells.get(0)?.parse().ok()?,
            began: text(1)?,
            status: text(2)?,
            identity: Identity {
                key: text(3)?,
                genome: text(4)?,
                world: text(5)?,
            },
            start: [float(6)?, float(7)?, float(8)?],
            cycles: cells.get(9)?.parse().ok()?,
            fitness: match bits {
                "" => None,
                bits => Some(f32::from_bits(u32::from_str_radix(bits, 16).ok()?)),
            },
            late: Late::of([late(12)?, late(13)?, late(14)?, late(15)?]),
            // Indices written by versions for one robot lack it.
            robot: text(16).unwrap_or_default(),
        })
    }
}

/// The part of an episode's cycle that determines the fitness.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Cycle {
    pub(super) activations: Vec<f32>,
    /// The pose at its end: x and y in mm, heading in turns.
    pub(super) end: [f32; 3],
}

/// Everything recorded of a cycle.
pub(super) struct Lived<'a> {
    pub(super) cycle: &'a Cycle,
    /// Since the episode began, s.
    pub(super) time_s: f64,
    pub(super) late_ms: f64,
    pub(super) age_ms: f64,
    pub(super) readings: &'a [f64],
    /// Commanded, mm/s.
    pub(super) speeds: [f64; 2],
    /// Since the episode began, mm.
    pub(super) travel: Option<[f64; 2]>,
    pub(super) reward: f32,
}

/// The table of an episode in progress.
#[derive(Debug)]
pub(super) struct Begun {
    /// The episode's number.
    pub(super) number: u32,
    cycles: u32,
    path: PathBuf,
    file: File,
}

/// A directory of episodes, locked as long as this value exists.
#[derive(Debug)]
pub(super) struct Logbook {
    directory: PathBuf,
    rows: Vec<Row>,
    /// The robots' names and the world's of what is sensed.
    pub(super) names: [Vec<String>; 2],
    _lock: File,
}

impl Begun {
    /// Records a cycle.
    ///
    /// # Errors
    /// Exit 6.
    pub(super) fn record(&mut self, lived: &Lived<'_>) -> Result {
        let thousandth = |number: f64| ((1000.0 * number).round() / 1000.0).to_string();
        let [x, y, heading] = lived.cycle.end;
        let travel = lived
            .travel
            .map_or_else(Default::default, |travel| travel.map(thousandth));
        let cells = [self.cycles.to_string(), thousandth(lived.time_s)]
            .into_iter()
            .chain([lived.late_ms, lived.age_ms].map(thousandth))
            .chain(lived.readings.iter().map(f64::to_string))
            .chain(lived.cycle.activations.iter().map(f32::to_string))
            .chain(lived.speeds.map(thousandth))
            .chain(travel)
            .chain([x, y, heading, lived.reward].map(|number| number.to_string()));
        let line = cells.collect::<Vec<_>>().join(",") + "\n";
        self.cycles += 1;
        let written = self.file.write_all(line.as_bytes());
        written.map_err(|error| Failure::storage(&self.path, &error))
    }
}

impl Logbook {
    /// Whether episodes can be recorded in a directory, as far as this can be checked without their robot.
    ///
    /// # Errors
    /// As [`Logbook::open`].
    pub(super) fn check(directory: &Path) -> Result {
        Self::taken(directory).map(drop)
    }

    /// Opens or makes a directory of episodes, and locks it. Returns its rows.
    fn taken(directory: &Path) -> Result<(Vec<Row>, File)> {
        let busy = || {
            let directory = directory.display();
            Failure::input(format_args!(
                "--log {directory}: another process logs episodes there; allowed: one at a time"
            ))
        };
        // Often it is a folder of a run's directory, which may belong to another run.
        if directory.is_symlink() {
            let directory = directory.display();
            return Err(Failure::input(format_args!(
                "{directory}: is a link; allowed: a directory"
            )));
        }
        let (lock, holds) = FORM.take(directory, busy)?;
        let rows = if holds == Holds::Mark {
            rows(&directory.join(INDEX))?
        } else {
            Vec::new()
        };
        Ok((rows, lock))
    }

    /// Opens a directory of episodes, or makes one. Episodes that were under way when a program ended are marked as cut short.
    ///
    /// # Errors
    /// Exit 3 if another process has it, or it has other files and no index; exit 5 if the index is corrupt; exit 6 if it can't be
    /// read or written.
    pub(super) fn open(directory: &Path, names: [Vec<String>; 2]) -> Result<Self> {
        let (rows, lock) = Self::taken(directory)?;
        let mut book = Self {
            directory: directory.into(),
            rows,
            names,
            _lock: lock,
        };
        let cut: Vec<usize> = (0..book.rows.len())
            .filter(|row| book.rows[*row].status == UNDER_WAY)
            .collect();
        for row in cut {
            let path = book.table(book.rows[row].number);
            // It may have no table yet, and half a line at the end.
            let lines = disk::read_if_there(&path)?.map_or(0, |text| String::from_utf8_lossy(&text).lines().count());
            book.rows[row].cycles = lines.saturating_sub(1) as u32;
            book.rows[row].status = "the program ended".into();
        }
        describe(directory, "Episodes on a robot", &contents(&book.columns()))?;
        book.save()?;
        Ok(book)
    }

    /// The complete episode with this identity, if there is one.
    pub(super) fn complete(&self, identity: &Identity) -> Option<&Row> {
        self.rows
            .iter()
            .find(|row| row.identity == *identity && row.is_complete())
    }

    /// Begins an episode of a robot at an address.
    ///
    /// # Errors
    /// Exit 6.
    pub(super) fn begin(&mut self, identity: Identity, genes: &[f32], start: [f32; 3], robot: &str) -> Result<Begun> {
        let genome = self.directory.join(format!("genome-{}.npy", identity.genome));
        if !genome.exists() {
            disk::write(&genome, &npy(&[1, genes.len()], genes))?;
        }
        let number = self.rows.last().map_or(0, |row| row.number) + 1;
        self.rows.push(Row {
            number,
            identity,
            began: now(),
            start,
            cycles: 0,
            fitness: None,
            status: UNDER_WAY.into(),
            late: Late::default(),
            robot: robot.into(),
        });
        self.save()?;
        let path = self.table(number);
        let storage = |error| Failure::storage(&path, &error);
        let mut file = plain::create(&path).map_err(storage)?;
        file.write_all(Csv::new(&self.columns()).text().as_bytes())
            .map_err(storage)?;
        Ok(Begun {
            number,
            cycles: 0,
            path,
            file,
        })
    }

    /// Ends an episode: with its fitness, or with the reason why it was cut short.
    ///
    /// # Errors
    /// Exit 6.
    pub(super) fn end(&mut self, life: &Begun, outcome: std::result::Result<f32, String>, late: Late) -> Result {
        let synced = life.file.sync_all();
        synced.map_err(|error| Failure::storage(&life.path, &error))?;
        let Some(row) = self.rows.iter_mut().rfind(|row| row.number == life.number) else {
            return Ok(());
        };
        (row.cycles, row.late) = (life.cycles, late);
        match outcome {
            Ok(fitness) => (row.fitness, row.status) = (Some(fitness), COMPLETE.into()),
            Err(reason) => row.status = reason,
        }
        self.save()
    }

    /// The cycles of a complete episode.
    ///
    /// # Errors
    /// Exit 5 if its table has changed since it was written.
    pub(super) fn cycles(&self, row: &Row) -> Result<Vec<Cycle>> {
        let path = self.table(row.number);
        let corrupt = |problem: &str| Failure::corrupt(format_args!("{}: {problem}", path.display()));
        let text = disk::read_text(&path)?;
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let expected = self.columns();
        let names = expected.iter().map(|column| &*column.name);
        if !reader.headers().is_ok_and(|head| head.iter().eq(names)) {
            return Err(corrupt("has other columns"));
        }
        let first = 4 + self.names[0].len();
        let last = expected.len() - 4;
        let cycles = reader.records().map(|cells| {
            let cells = cells.ok()?;
            let float = |cell: usize| cells.get(cell)?.parse::<f32>().ok();
            let activations = (first..first + self.names[1].len()).map(float).collect::<Option<_>>()?;
            let end = [float(last)?, float(last + 1)?, float(last + 2)?];
            Some(Cycle { activations, end })
        });
        let cycles: Vec<Cycle> = cycles
            .collect::<Option<_>>()
            .ok_or_else(|| corrupt("has a torn line"))?;
        if cycles.len() != row.cycles as usize {
            return Err(corrupt("has another number of cycles than the index says"));
        }
        Ok(cycles)
    }

    /// Path of an episode's table.
    fn table(&self, number: u32) -> PathBuf {
        self.directory.join(table(number))
    }

    /// Columns of the episodes' tables.
    fn columns(&self) -> Vec<Column> {
        columns(&self.names)
    }

    /// Writes the index.
    fn save(&self) -> Result {
        let mut csv = Csv::new(&COLUMNS);
        for row in &self.rows {
            csv.row(row.cells());
        }
        disk::write(&self.directory.join(INDEX), csv.text().as_bytes())?;
        disk::sync_directory(&self.directory)
    }
}

/// Name of an episode's table, by number.
pub fn table(number: impl Display) -> String {
    format!("life-{number}.csv")
}

static BEFORE: [Column; 4] = [
    Column::whole("cycle", "100 ms", "its number, from 0"),
    Column::number("time_s", "s", "when the sensors were read, since the episode began"),
    Column::number("late_ms", "ms", "how late the cycle's command was sent"),
    Column::number("age_ms", "ms", "maximum age of a reading then"),
];

static AFTER: [Column; 8] = [
    Column::number("left_mm_s", "mm/s", "commanded speed of the left wheel"),
    Column::number("right_mm_s", "mm/s", "commanded speed of the right wheel"),
    Column::number(
        "left_mm",
        "mm",
        "travel of the left wheel since the episode began, at the end of the cycle",
    ),
    Column::number("right_mm", "mm", "the same of the right wheel"),
    Column::number("x_mm", "mm", "where the cycle ended"),
    Column::number("y_mm", "mm", "where the cycle ended"),
    Column::number(
        "heading_turns",
        "turns",
        "where it headed then, counter-clockwise from the x axis",
    ),
    Column::number("reward", "", "the cycle's reward"),
];

/// Columns of an episode's table: the robot's and the world's names of sensors.
fn columns([raw, own]: &[Vec<String>; 2]) -> Vec<Column> {
    let raw = raw
        .iter()
        .map(|name| Column::number("", "", "what the robot's sensor read").named(format!("raw_{name}")));
    let own = own
        .iter()
        .map(|name| Column::number("", "0 to 1", "the activation").named(name.clone()));
    BEFORE
        .iter()
        .cloned()
        .chain(raw)
        .chain(own)
        .chain(AFTER.iter().cloned())
        .collect()
}

/// Files of any directory of episodes.
#[cfg(any(test, feature = "testing"))]
pub fn all_contents() -> Vec<Entry> {
    contents(&columns(&[["NAME".to_owned()].into(), ["NAME".to_owned()].into()]))
}

/// Files of a directory of episodes.
fn contents(columns: &[Column]) -> Vec<Entry> {
    vec![
        Entry::table(INDEX, "all episodes: one row per episode", &COLUMNS),
        Entry::table("life-NUMBER.csv", "an episode: one row per cycle", columns),
        Entry::file(
            "genome-HASH.npy",
            "the genes of an episode's controller, for `--genomes`",
        ),
        Entry::file(disk::LOCK, "keeps a second process from recording episodes here"),
    ]
}

/// Reads the index.
fn rows(path: &Path) -> Result<Vec<Row>> {
    let corrupt = |problem: &str| Failure::corrupt(format_args!("{}: {problem}", path.display()));
    let text = disk::read_text(path)?;
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let names = |count| COLUMNS.iter().take(count).map(|column| &*column.name);
    let is_known = |head: &csv::StringRecord| [CELLS, CELLS - 1].into_iter().any(|count| head.iter().eq(names(count)));
    if !reader.headers().is_ok_and(is_known) {
        return Err(corrupt("has other columns than a table of episodes"));
    }
    let rows = reader.records().zip(2..).map(|(cells, line)| {
        let row = cells.ok().as_ref().and_then(Row::read);
        row.ok_or_else(|| corrupt(&format!("line {line} isn't what was written")))
    });
    rows.collect()
}
