//! What a daemon keeps on disk: its checkpoint, which is whole after a power cut, and a table of its intervals.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Sender};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::member::{Ended, State};
use crate::contents::{Column, head};
use crate::engine::disk;
use crate::exchange::radio::Windows;
use crate::exit::{Failure, Result};
use crate::sealed;

/// The file of the checkpoint, its name inside and its version.
pub(crate) const CHECKPOINT: &str = "checkpoint";
const NAME: &str = "daemon";
const VERSION: u32 = 1;
/// After a write has failed, the next attempt.
const PAUSE: Duration = Duration::from_secs(1);

/// The table of intervals: its file, and its columns.
pub(crate) const INTERVALS: &str = "intervals.csv";
pub(crate) static INTERVALS_COLUMNS: [Column; 12] = [
    Column::whole("interval", "", "its number, from 0, by the robot's own clock"),
    Column::whole("robot", "", "its number, from 0"),
    Column::number("s0", "0 to 0.99", "the gene of its simulator"),
    Column::number(
        "chosen_under",
        "0 to 0.99",
        "the gene of the simulator in which the acting controller was chosen",
    ),
    Column::number(
        "g0",
        "0 to 0.99",
        "the gene of the acting controller's behaviour with food, at the interval's end",
    ),
    Column::number("g1", "0 to 0.99", "the gene of its behaviour without food"),
    Column::number("real", "", "its fitness during this interval"),
    Column::whole(
        "brought",
        "items",
        "food that it brought during this interval, as far as the tracker told",
    ),
    Column::number(
        "simulated",
        "",
        "the same controller's fitness in the simulator in which it was chosen; empty if there is none",
    ),
    Column::whole("heard", "robots", "the number of robots that it heard"),
    Column::whole("taken", "", "1 if its next simulator came from another robot, else 0"),
    Column::whole(
        "missed",
        "",
        "1 if the daemon did not live through all of it, so that nothing evolved, else 0",
    ),
];

/// What is saved.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Saved {
    /// Times that the daemon has been started.
    pub(crate) boots: u32,
    /// The robot between two intervals.
    pub(crate) state: State,
    /// Its intervals so far.
    pub(crate) ended: Vec<Ended>,
    /// The datagrams that were taken.
    pub(crate) windows: Windows,
}

impl Saved {
    /// A robot that is started for the first time.
    pub(crate) fn new(state: State) -> Self {
        Self {
            boots: 1,
            state,
            ended: Vec::new(),
            windows: Windows::default(),
        }
    }

    /// The table of intervals.
    fn table(&self) -> String {
        let mut text = head(&INTERVALS_COLUMNS);
        for own in &self.ended {
            let simulated = own.simulated.map(|fitness| fitness.to_string()).unwrap_or_default();
            let [g0, g1] = own.controller;
            let (taken, missed) = (u8::from(own.taken), u8::from(own.missed));
            // Writing to a string can't fail.
            let _ = writeln!(
                text,
                "{},{},{},{},{g0},{g1},{},{},{simulated},{},{taken},{missed}",
                own.interval, own.robot, own.simulator, own.chosen_under, own.real, own.brought, own.heard
            );
        }
        text
    }
}

/// A daemon's files.
#[derive(Clone, Debug)]
struct Files {
    directory: PathBuf,
    /// Hash of what the checkpoint belongs to.
    owner: blake3::Hash,
}

impl Files {
    fn write(&self, saved: &Saved) -> Result {
        // First the table, which follows from the checkpoint and is written again with the next one.
        disk::note(&self.directory.join(INTERVALS), saved.table().as_bytes())?;
        let bytes = sealed::seal(NAME, VERSION, &self.owner, saved);
        disk::write(&self.directory.join(CHECKPOINT), &bytes)?;
        disk::sync_directory(&self.directory)
    }

    fn read(&self) -> Result<Option<Saved>> {
        let path = self.directory.join(CHECKPOINT);
        if !path.exists() {
            return Ok(None);
        }
        sealed::open(NAME, VERSION, &self.owner, &disk::read(&path)?)
            .map(Some)
            .map_err(|problem| Failure::corrupt(format_args!("{}: {problem}", path.display())))
    }
}

/// Saves what a daemon tells it to, beside the control thread.
pub(crate) struct Keeper {
    files: Files,
    /// The thread that writes; none where the control thread waits for it.
    thread: Option<(Sender<Saved>, JoinHandle<()>)>,
    problem: Arc<Mutex<Option<String>>>,
    /// Whether attempts are not repeated any more.
    ends: Arc<AtomicBool>,
    /// Keeps other daemons out of the directory.
    _lock: fs::File,
}

impl Keeper {
    /// Takes a directory, and what was saved there for the same robot and experiment. It waits for the disk until
    /// [`Keeper::start`].
    ///
    /// # Errors
    /// Exit 3: another daemon has the directory; exit 5: what was saved is damaged, or is of another robot or experiment; exit 6: it
    /// can't be read.
    pub(crate) fn open(directory: &Path, owner: blake3::Hash) -> Result<(Self, Option<Saved>)> {
        fs::create_dir_all(directory).map_err(|error| Failure::storage(directory, &error))?;
        let lock = disk::try_lock(directory)?;
        let lock = lock.ok_or_else(|| {
            Failure::input(format_args!(
                "{}: another daemon is using this directory",
                directory.display()
            ))
        })?;
        let files = Files {
            directory: directory.to_owned(),
            owner,
        };
        let saved = files.read()?;
        let keeper = Self {
            files,
            thread: None,
            problem: Arc::default(),
            ends: Arc::default(),
            _lock: lock,
        };
        Ok((keeper, saved))
    }

    /// Writes on a thread of its own from now on.
    pub(crate) fn start(&mut self) {
        let (sender, waiting) = mpsc::channel::<Saved>();
        let (files, problem, ends) = (self.files.clone(), Arc::clone(&self.problem), Arc::clone(&self.ends));
        let thread = thread::spawn(move || {
            while let Ok(mut saved) = waiting.recv() {
                loop {
                    saved = waiting.try_iter().last().unwrap_or(saved);
                    if note(&problem, files.write(&saved)) || ends.load(Ordering::Relaxed) {
                        break;
                    }
                    thread::sleep(PAUSE);
                }
            }
        });
        self.thread = Some((sender, thread));
    }

    /// Saves, and waits until all is on disk: at the beginning, and at the end.
    ///
    /// # Errors
    /// Exit 6.
    pub(crate) fn save_now(&mut self, saved: &Saved) -> Result {
        self.finish();
        self.files.write(saved)
    }

    /// Waits for the thread, which writes once more at most.
    fn finish(&mut self) {
        self.ends.store(true, Ordering::Relaxed);
        if let Some((sender, thread)) = self.thread.take() {
            drop(sender);
            // What it could not write is written again.
            let _ = thread.join();
        }
    }

    /// Saves. While it does not succeed, [`Keeper::problem`] says why, and it is tried again.
    pub(crate) fn save(&self, saved: Saved) {
        match &self.thread {
            // The thread waits for more as long as this lives.
            Some((sender, _)) => drop(sender.send(saved)),
            None => drop(note(&self.problem, self.files.write(&saved))),
        }
    }

    /// Why nothing can be saved at present.
    pub(crate) fn problem(&self) -> Option<String> {
        self.problem.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Whether it has to be told to try again: otherwise its thread does.
    pub(crate) fn is_to_repeat(&self) -> bool {
        self.thread.is_none() && self.problem().is_some()
    }
}

/// Notes the outcome of an attempt, and returns whether it succeeded.
fn note(problem: &Mutex<Option<String>>, outcome: Result) -> bool {
    let outcome = outcome.err().map(|failure| failure.to_string());
    let is_written = outcome.is_none();
    *problem.lock().unwrap_or_else(PoisonError::into_inner) = outcome;
    is_written
}
