//! The record of a twin: tables of the arena and of how long wheels turned after faults, a log of the faults, and a hash of all that must
//! not depend on the machine's speed.

use std::fmt::Write as _;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use oneiro::swarm::Line;
use oneiro_base::contents::{Column, Entry, head};
use oneiro_base::exit::{Failure, Result};
use oneiro_base::plain;
use serde::{Deserialize, Serialize};

use super::super::page::REPLAY;
use super::faults::{Event, Fate, SECOND};

/// The files.
pub(super) const ARENA: &str = "twin.csv";
const FAULTS: &str = "faults.jsonl";
const STOPS: &str = "stops.csv";

static ARENA_COLUMNS: [Column; 9] = [
    Column::whole("second", "s", "the second of the experiment that has ended"),
    Column::whole("robot", "", "its number"),
    Column::number("x", "mm", "its position"),
    Column::number("y", "mm", "its position"),
    Column::number("heading", "turns", "counter-clockwise from the x axis"),
    Column::whole("carries", "", "1 if it carries food"),
    Column::whole("brought", "items", "food that it has brought so far"),
    Column::number("left", "mm/s", "speed of its left wheel"),
    Column::number("right", "mm/s", "speed of its right wheel"),
];
static STOPS_COLUMNS: [Column; 6] = [
    Column::number("second", "s", "when the fault began"),
    Column::text("fault", "its table in the script"),
    Column::whole("robot", "", "its number"),
    Column::whole("turning", "", "1 if a wheel turned at that moment"),
    Column::number(
        "stood_ms",
        "ms",
        "time from then until both wheels stood; empty if one still turned when the fault, or 5 s, had passed",
    ),
    Column::number("travel", "mm", "the robot's way in the arena until then"),
];

/// A row of the arena's table.
#[derive(Clone, Copy, Debug, Deserialize)]
pub(super) struct Row {
    pub(super) second: u32,
    pub(super) robot: u32,
    pub(super) x: f32,
    pub(super) y: f32,
    pub(super) heading: f32,
    pub(super) carries: u8,
    pub(super) brought: u32,
    pub(super) left: f64,
    pub(super) right: f64,
}

/// The files of a twin's directory.
pub(crate) static CONTENTS: LazyLock<Vec<Entry>> = LazyLock::new(|| {
    vec![
        Entry::table(ARENA, "one row per second and robot", &ARENA_COLUMNS),
        Entry::file(
            FAULTS,
            "one line per fault of the script, and one per second in which datagrams were lost, late, doubled, damaged or forged",
        ),
        Entry::table(STOPS, "one row per fault of the script and robot", &STOPS_COLUMNS),
        Entry::file("robots", "a directory for each robot, with the daemon's files"),
        Entry::file(REPLAY, "written by `oneiro fleet replay`: a page that plays the twin"),
    ]
});

/// What has befallen datagrams in a second.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub(super) struct Counts {
    pub(super) sent: u64,
    pub(super) lost: u64,
    pub(super) reordered: u64,
    pub(super) duplicated: u64,
    pub(super) corrupted: u64,
    pub(super) forged: u64,
}

impl Counts {
    pub(super) fn add(&mut self, fate: &Fate) {
        let [first, second] = fate.copies;
        self.sent += 1;
        self.lost += u64::from(first.is_none());
        self.reordered += u64::from(first.is_some() && fate.reordered);
        self.duplicated += u64::from(second.is_some());
        self.corrupted += fate
            .copies
            .iter()
            .flatten()
            .filter(|copy| copy.damage.is_some())
            .count() as u64;
    }

    fn has_faults(&self) -> bool {
        let sent = self.sent;
        *self
            != Self {
                sent,
                ..Self::default()
            }
    }
}

/// A file that grows.
struct Growing {
    path: PathBuf,
    file: BufWriter<File>,
}

impl Growing {
    fn create(directory: &Path, name: &str, first: &str) -> Result<Self> {
        let path = directory.join(name);
        let file = plain::create(&path).map_err(|error| oneiro_base::files::uncreated(&path, &error))?;
        let file = BufWriter::new(file);
        let mut growing = Self { path, file };
        growing.add(first)?;
        Ok(growing)
    }

    fn add(&mut self, text: &str) -> Result {
        let written = self.file.write_all(text.as_bytes());
        written.map_err(|error| Failure::storage(&self.path, &error))
    }

    fn flush(&mut self) -> Result {
        self.file.flush().map_err(|error| Failure::storage(&self.path, &error))
    }
}

/// The files of a running twin.
pub(super) struct Record {
    arena: Growing,
    faults: Growing,
    stops: Growing,
    hash: blake3::Hasher,
    counts: Counts,
}

impl Record {
    pub(super) fn new(directory: &Path) -> Result<Self> {
        Ok(Self {
            arena: Growing::create(directory, ARENA, &head(&ARENA_COLUMNS))?,
            faults: Growing::create(directory, FAULTS, "")?,
            stops: Growing::create(directory, STOPS, &head(&STOPS_COLUMNS))?,
            hash: blake3::Hasher::new(),
            counts: Counts::default(),
        })
    }

    /// Adds a cycle of the arena to the hash.
    pub(super) fn cycle(&mut self, line: &Line) {
        let mut word = |bits: u32| {
            self.hash.update(&bits.to_le_bytes());
        };
        for seen in &line.robots {
            for value in [seen.x, seen.y, seen.heading] {
                word(value.to_bits());
            }
            word(u32::from(seen.carries));
            word(seen.brought);
            (0..4).for_each(|part| word((seen.heard >> (32 * part)) as u32));
        }
        line.food.iter().flatten().for_each(|value| word(value.to_bits()));
    }

    /// Adds a second of the arena: what was brought so far, and the wheels' speeds.
    pub(super) fn second(&mut self, second: u64, line: &Line, brought: &[u32], wheels: &[[f64; 2]]) -> Result {
        let mut rows = String::new();
        for (robot, seen) in line.robots.iter().enumerate() {
            let ([left, right], carries, brought) = (wheels[robot], u8::from(seen.carries), brought[robot]);
            let (x, y, heading) = (seen.x, seen.y, seen.heading);
            // Writing to text can't fail.
            let _ = writeln!(
                rows,
                "{second},{robot},{x},{y},{heading},{carries},{brought},{left},{right}"
            );
        }
        self.arena.add(&rows)?;
        let counts = std::mem::take(&mut self.counts);
        if counts.has_faults() {
            self.fault(&serde_json::json!({ "at_s": second, "fault": "packets", "counts": counts }))?;
        }
        Ok(())
    }

    /// Counts the fate of a datagram.
    pub(super) fn datagram(&mut self, fate: &Fate) {
        self.counts.add(fate);
    }

    /// Counts a forged datagram.
    pub(super) fn forged(&mut self) {
        self.counts.forged += 1;
    }

    /// Adds a fault of the script, and what came of it.
    pub(super) fn event(&mut self, event: &Event, outcome: &str) -> Result {
        self.fault(&serde_json::json!({
            "at_s": event.at as f64 / SECOND as f64,
            "robot": event.robot,
            "fault": event.what.name(),
            "what": event.what,
            "outcome": outcome,
        }))
    }

    fn fault(&mut self, line: &serde_json::Value) -> Result {
        self.faults.add(&format!("{line}\n"))
    }

    /// Adds how long wheels turned after a fault.
    pub(super) fn stop(&mut self, stop: &Stop) -> Result {
        let Stop {
            at,
            fault,
            robot,
            turning,
            stood,
            travel,
            ..
        } = stop;
        let second = *at as f64 / SECOND as f64;
        let stood = stood.map(|time| (time as f64 / 1e6).to_string()).unwrap_or_default();
        let turning = u8::from(*turning);
        self.stops
            .add(&format!("{second},{fault},{robot},{turning},{stood},{travel}\n"))
    }

    /// Writes what is left. Returns the hash of the arena and of these tables of the daemons.
    pub(super) fn finish(&mut self, intervals: &[Vec<u8>]) -> Result<String> {
        for table in intervals {
            self.hash.update(&(table.len() as u64).to_le_bytes());
            self.hash.update(table);
        }
        [&mut self.arena, &mut self.faults, &mut self.stops]
            .into_iter()
            .try_for_each(Growing::flush)?;
        Ok(self.hash.finalize().to_hex()[..16].to_owned())
    }
}

/// How long wheels turn after a fault.
pub(super) struct Stop {
    /// When the fault began, ns of the experiment's time, and on the conductor's clock.
    pub(super) at: u64,
    pub(super) began: u64,
    pub(super) fault: &'static str,
    pub(super) robot: usize,
    pub(super) turning: bool,
    /// How long they turned after that until they first stopped; none if they have not stopped yet.
    pub(super) stood: Option<u64>,
    /// Until when it is watched, on the conductor's clock.
    pub(super) until: u64,
    /// Where it was in the last cycle, and how far it has gone, mm.
    pub(super) last: [f32; 2],
    pub(super) travel: f64,
}

impl Stop {
    /// How long a robot is watched at most, ns.
    pub(super) const LONGEST: u64 = 5 * SECOND;

    /// Looks at the wheels at the end of a cycle. `stood`: the moment, by the conductor's clock, from which they stand
    /// still, or last did. Returns whether the watch is over.
    pub(super) fn look(&mut self, now: u64, stood: u64, place: [f32; 2]) -> bool {
        let [x, y] = [0, 1].map(|axis| f64::from(place[axis] - self.last[axis]));
        self.travel += x.hypot(y);
        self.last = place;
        if self.stood.is_none() && (!self.turning || stood >= self.began) {
            self.stood = Some(stood.saturating_sub(self.began));
        }
        // One cycle more, in which the arena's robot also comes to a stop.
        self.stood.is_some_and(|stood| now >= self.began + stood + SECOND / 5) || now >= self.until
    }
}
