//! Provenance of a run, which isn't part of its results: who computed it, where and when.

use std::path::Path;
use std::time::{Duration, SystemTime};

use oneiro::evaluator::Device;
use serde::{Deserialize, Serialize};

use super::META;
use crate::engine::disk;
use crate::exit::Result;

/// `meta.json`
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Meta {
    /// Name of the experiment.
    pub(crate) name: String,
    /// Seed of the run.
    pub(crate) seed: u64,
    /// Progress of the run.
    pub(crate) status: Status,
    /// Finished generations, as of the last checkpoint or stop.
    pub(crate) generation: u32,
    /// Total number of generations.
    pub(crate) generations: u32,
    /// The best score so far.
    pub(crate) best: Option<f32>,
    /// Processes that worked on it, in order.
    pub(crate) sessions: Vec<Session>,
}

/// Progress of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Status {
    /// A process works on it, or was killed while it did.
    Running,
    /// Stopped at a checkpoint.
    Stopped,
    /// All generations are finished.
    Done,
}

/// One process's work on a run.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Session {
    /// Version of the program.
    pub(crate) version: String,
    /// Commit that it was built from.
    pub(crate) commit: String,
    /// Backend on the command line.
    pub(crate) backend: String,
    /// Name of the device.
    pub(crate) device: String,
    /// Instruction set or driver of the device.
    pub(crate) detail: String,
    /// Whether it guarantees the bits that every other exact device gives.
    pub(crate) exact: bool,
    /// First generation of this session.
    pub(crate) from_generation: u32,
    /// Beginning, UTC.
    pub(crate) started: String,
    /// End, UTC; `None` if it was killed.
    pub(crate) ended: Option<String>,
}

impl Session {
    /// Begins a session now.
    pub(crate) fn new(backend: &str, device: &Device) -> Self {
        Self {
            version: env!("CARGO_PKG_VERSION").into(),
            commit: env!("ONEIRO_COMMIT").into(),
            backend: backend.into(),
            device: device.name.clone(),
            detail: device.detail.clone(),
            exact: device.exact,
            from_generation: 0,
            started: now(),
            ended: None,
        }
    }
}

impl Meta {
    /// Notes that a process works on a run of `generations` generations.
    pub(super) fn begin(directory: &Path, name: &str, seed: u64, generations: u32, session: Session) -> Result<Self> {
        let mut meta = Self::read(directory).unwrap_or_else(|| Self {
            name: name.into(),
            seed,
            status: Status::Running,
            generation: 0,
            generations,
            best: None,
            sessions: Vec::new(),
        });
        meta.status = Status::Running;
        meta.sessions.push(session);
        meta.write(directory)?;
        Ok(meta)
    }

    /// Notes how its work ended.
    pub(super) fn end(&mut self, directory: &Path, status: Status) -> Result {
        self.status = status;
        if let Some(session) = self.sessions.last_mut() {
            session.ended = Some(now());
        }
        self.write(directory)
    }

    /// Reads a run's metadata; `None` if they can't be read, since nothing depends on them.
    pub(crate) fn read(directory: &Path) -> Option<Self> {
        serde_json::from_slice(&std::fs::read(directory.join(META)).ok()?).ok()
    }

    /// Writes a run's metadata.
    pub(super) fn write(&self, directory: &Path) -> Result {
        disk::note(&directory.join(META), &disk::json(self))
    }
}

/// The time, UTC, to the second: `2026-11-21T02:00:00Z`.
pub(crate) fn now() -> String {
    let since = SystemTime::now()
        .duration_since(SystemTime::UNIX_EPOCH)
        .unwrap_or(Duration::ZERO);
    utc(since.as_secs())
}

fn utc(seconds: u64) -> String {
    let (days, second) = (seconds / 86_400, seconds % 86_400);
    let mut year = 1970;
    let mut day = days;
    let is_leap = |year: u64| (year.is_multiple_of(4) && !year.is_multiple_of(100)) || year.is_multiple_of(400);
    let length = |year| if is_leap(year) { 366 } else { 365 };
    while day >= length(year) {
        day -= length(year);
        year += 1;
    }
    let february = if is_leap(year) { 29 } else { 28 };
    let mut month = 1;
    for days in [31, february, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31] {
        if day < days {
            break;
        }
        day -= days;
        month += 1;
    }
    let (hour, minute) = (second / 3600, second / 60 % 60);
    format!(
        "{year}-{month:02}-{:02}T{hour:02}:{minute:02}:{:02}Z",
        day + 1,
        second % 60
    )
}

#[cfg(test)]
mod tests {
    use super::utc;

    #[test]
    fn times_are_right() {
        assert_eq!(utc(0), "1970-01-01T00:00:00Z");
        assert_eq!(utc(951_782_400), "2000-02-29T00:00:00Z");
        assert_eq!(utc(951_868_799), "2000-02-29T23:59:59Z");
        assert_eq!(utc(1_709_164_800), "2024-02-29T00:00:00Z");
        assert_eq!(utc(1_735_689_599), "2024-12-31T23:59:59Z");
        assert_eq!(utc(4_102_444_800), "2100-01-01T00:00:00Z");
    }
}
