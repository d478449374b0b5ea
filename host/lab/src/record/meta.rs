//! Provenance of a run, which isn't part of its results: who computed it, where and when.

use std::path::Path;

use oneiro::evaluator::Device;
use oneiro_base::disk;
use oneiro_base::exit::Result;
use oneiro_base::utc::now;
use serde::{Deserialize, Serialize};

use super::META;
use crate::experiment::Input;
use crate::runs::Experiment;

/// `meta.json`
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Meta {
    /// Name of the experiment.
    pub name: String,
    /// Seed of the run.
    pub seed: u64,
    /// Progress of the run.
    pub status: Status,
    /// Finished generations, as of the last checkpoint or stop.
    pub generation: u32,
    /// Total number of generations.
    pub generations: u32,
    /// What the run makes of its budget of episodes, in words, if it has one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub budget: Option<String>,
    /// Files that the experiment names, and where they were.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) inputs: Vec<Origin>,
    /// Extensions of the run, in order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) extended: Vec<Extended>,
    /// The best score so far.
    pub best: Option<f32>,
    /// Processes that worked on it, in order.
    pub(crate) sessions: Vec<Session>,
}

/// Where a file of the run was.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Origin {
    /// The copy in the run's directory.
    file: String,
    /// The name in the experiment.
    from: String,
    /// BLAKE3 hash of the content.
    blake3: String,
}

/// What `oneiro resume --generations` or `--episodes` has changed.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Extended {
    /// When, UTC.
    pub(crate) at: String,
    /// The key of the new budget, and its value.
    pub(crate) key: String,
    pub(crate) value: u64,
    /// Total number of generations before and since.
    pub(crate) generations: [u32; 2],
    /// Generation that the run continued from.
    pub(crate) from_generation: u32,
    /// Hash of the results, if the run was finished.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) result: Option<String>,
}

/// Progress of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// A process works on it, or was killed while it did.
    Running,
    /// Stopped at a checkpoint.
    Stopped,
    /// All generations are finished.
    Done,
}

/// One process's work on a run.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Session {
    /// Version of the program.
    pub version: String,
    /// Commit that it was built from.
    pub(crate) commit: String,
    /// Backend on the command line.
    pub backend: String,
    /// Name of the device.
    pub device: String,
    /// Instruction set or driver of the device.
    pub detail: String,
    /// Whether it guarantees the bits that every other exact device gives.
    pub exact: bool,
    /// First generation of this session.
    pub(crate) from_generation: u32,
    /// Beginning, UTC.
    pub started: String,
    /// End, UTC; `None` if it was killed.
    pub ended: Option<String>,
}

impl Session {
    /// Begins a session now, of a program that was built from `commit`.
    pub fn new(commit: &str, backend: &str, device: &Device) -> Self {
        Self {
            version: env!("CARGO_PKG_VERSION").into(),
            commit: commit.into(),
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

impl Origin {
    fn of(input: &Input) -> Self {
        Self {
            file: input.name.clone(),
            from: input.named.clone(),
            blake3: input.content.hash.clone(),
        }
    }
}

impl Meta {
    /// Notes that a process works on a run of an experiment.
    pub(super) fn begin(directory: &Path, own: &dyn Experiment, seed: u64, session: Session) -> Result<Self> {
        let mut meta = Self::read(directory).unwrap_or_else(|| Self {
            name: own.name().into(),
            seed,
            budget: own.budget(),
            status: Status::Running,
            generation: 0,
            generations: own.length(),
            inputs: own.inputs().iter().map(Origin::of).collect(),
            extended: Vec::new(),
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
    pub fn read(directory: &Path) -> Option<Self> {
        disk::json_if_there(&directory.join(META)).ok()?
    }

    /// Writes a run's metadata.
    pub(super) fn write(&self, directory: &Path) -> Result {
        disk::note(&directory.join(META), &disk::json(self))
    }
}
