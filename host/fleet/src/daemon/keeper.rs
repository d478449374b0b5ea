//! A daemon's files: its checkpoint, which survives a power cut, and the tables that follow from it.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Sender};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use oneiro_base::disk;
use oneiro_base::exit::{Failure, Result};
use oneiro_base::plain;
use oneiro_base::sealed;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// The file of the checkpoint, and its version.
pub(crate) const CHECKPOINT: &str = "checkpoint";
const VERSION: u32 = 1;
/// After a write has failed, the next attempt.
const PAUSE: Duration = Duration::from_secs(1);

/// What a daemon keeps.
pub(super) trait Kept: Serialize + DeserializeOwned + Send + 'static {
    /// Its name inside the checkpoint.
    const NAME: &'static str;

    /// Files that follow from it and are written again with the next one, by their names.
    fn notes(&self) -> Vec<(&'static str, Vec<u8>)>;
}

/// A daemon's files.
#[derive(Clone, Debug)]
struct Files {
    directory: PathBuf,
    /// Hash of what the checkpoint belongs to.
    owner: blake3::Hash,
}

impl Files {
    fn write<S: Kept>(&self, saved: &S) -> Result {
        for (name, bytes) in saved.notes() {
            disk::note(&self.directory.join(name), &bytes)?;
        }
        let bytes = sealed::seal(S::NAME, VERSION, &self.owner, saved);
        disk::write(&self.directory.join(CHECKPOINT), &bytes)?;
        disk::sync_directory(&self.directory)
    }

    fn read<S: Kept>(&self) -> Result<Option<S>> {
        let path = self.directory.join(CHECKPOINT);
        if !path.exists() {
            return Ok(None);
        }
        sealed::open(S::NAME, VERSION, &self.owner, &disk::read(&path)?)
            .map(Some)
            .map_err(|problem| Failure::corrupt(format_args!("{}: {problem}", path.display())))
    }
}

/// Saves a daemon's state in another thread than the control thread.
pub(super) struct Keeper<S> {
    files: Files,
    /// The thread that writes; none where the control thread waits for it.
    thread: Option<(Sender<S>, JoinHandle<()>)>,
    problem: Arc<Mutex<Option<String>>>,
    /// Whether attempts are not repeated any more.
    ends: Arc<AtomicBool>,
    /// Keeps other daemons out of the directory.
    _lock: fs::File,
}

impl<S: Kept> Keeper<S> {
    /// Opens a directory with the saved state of the same robot and experiment. It waits for the disk until
    /// [`Keeper::start`].
    ///
    /// # Errors
    /// Exit 3: another daemon uses the directory; exit 5: the saved state is damaged, or is of another robot or
    /// experiment; exit 6: it can't be read.
    pub(super) fn open(directory: &Path, owner: blake3::Hash) -> Result<(Self, Option<S>)> {
        plain::make_directory(directory).map_err(|error| Failure::storage(directory, &error))?;
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

    /// From now on writes in a thread.
    pub(super) fn start(&mut self) {
        let (sender, waiting) = mpsc::channel::<S>();
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
    pub(crate) fn save_now(&mut self, saved: &S) -> Result {
        self.finish();
        self.files.write(saved)
    }

    /// Waits for the thread, which writes once more at most.
    fn finish(&mut self) {
        self.ends.store(true, Ordering::Relaxed);
        if let Some((sender, thread)) = self.thread.take() {
            drop(sender);
            // A state that it could not write is written again.
            let _ = thread.join();
        }
    }

    /// Saves. While that fails, [`Keeper::problem`] has the reason, and it is tried again.
    pub(super) fn save(&self, saved: S) {
        match &self.thread {
            // The thread ends when this sender is dropped.
            Some((sender, _)) => drop(sender.send(saved)),
            None => drop(note(&self.problem, self.files.write(&saved))),
        }
    }

    /// Why nothing can be saved at present.
    pub(super) fn problem(&self) -> Option<String> {
        self.problem.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Whether the caller has to try again: otherwise its thread does.
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
