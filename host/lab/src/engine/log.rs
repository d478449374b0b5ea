//! An append-only file that can be cut back to its length at a checkpoint.

use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use oneiro_base::disk;
use oneiro_base::exit::{Failure, Result};
use oneiro_base::plain;
use serde::{Deserialize, Serialize};

/// Length of a log and its hash.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Extent {
    bytes: u64,
    blake3: String,
}

/// The beginning of a log, known to be unchanged.
#[derive(Debug)]
pub(crate) struct Prefix {
    bytes: u64,
    hasher: blake3::Hasher,
}

impl Prefix {
    /// Reads the beginning of a log, if it is still there.
    pub(crate) fn of(path: &Path, extent: &Extent) -> Option<Self> {
        let file = plain::open_table(path).ok()?;
        let is_long_enough = file.metadata().is_ok_and(|file| file.len() >= extent.bytes);
        let mut hasher = blake3::Hasher::new();
        hasher.update_reader(file.take(extent.bytes)).ok()?;
        let is_same = is_long_enough && hasher.finalize().to_hex().as_str() == extent.blake3;
        is_same.then_some(Self {
            bytes: extent.bytes,
            hasher,
        })
    }
}

/// Writer of a log. Lines wait in memory: after a crash, everything beyond the last checkpoint is discarded anyway.
#[derive(Debug)]
pub(crate) struct Log {
    path: PathBuf,
    /// Bytes that are not written yet.
    waiting: Vec<u8>,
    /// Number of bytes written.
    written: u64,
    hasher: blake3::Hasher,
    flushed: Instant,
}

impl Log {
    /// Starts an empty log.
    pub(crate) fn create(path: PathBuf) -> Result<Self> {
        plain::create_anew(&path).map_err(|error| Failure::storage(&path, &error))?;
        Ok(Self::new(path, 0, blake3::Hasher::new()))
    }

    fn new(path: PathBuf, written: u64, hasher: blake3::Hasher) -> Self {
        Self {
            path,
            waiting: Vec::new(),
            written,
            hasher,
            flushed: Instant::now(),
        }
    }

    /// Cuts a log back to its beginning and continues from there.
    pub(crate) fn cut_back(path: PathBuf, prefix: Prefix) -> Result<Self> {
        let cut = plain::append(&path).and_then(|file| file.set_len(prefix.bytes));
        cut.map_err(|error| Failure::storage(&path, &error))?;
        Ok(Self::new(path, prefix.bytes, prefix.hasher))
    }

    /// The extent of a log that begins with another head, of `old` bytes so far. If it does, the log is written to `target`. `None` if
    /// the log is not what it was at `extent`.
    ///
    /// # Errors
    /// Exit 6.
    pub(crate) fn with_head(
        path: &Path,
        extent: &Extent,
        old: usize,
        head: &[u8],
        target: Option<&Path>,
    ) -> Result<Option<Extent>> {
        let failed = |error| Failure::storage(path, &error);
        let Some(rest) = extent.bytes.checked_sub(old as u64) else {
            return Ok(None);
        };
        if Prefix::of(path, extent).is_none() {
            return Ok(None);
        }
        let mut file = plain::open_table(path).map_err(failed)?;
        let mut before = vec![0; old];
        file.read_exact(&mut before).map_err(failed)?;
        if before == head {
            return Ok(Some(extent.clone()));
        }
        let mut hasher = blake3::Hasher::new();
        hasher.update(head);
        hasher.update_reader((&file).take(rest)).map_err(failed)?;
        if let Some(target) = target {
            file.seek(SeekFrom::Start(old as u64)).map_err(failed)?;
            disk::write_through(target, |new| {
                let copied = new.write_all(head).and_then(|()| io::copy(&mut file.take(rest), new));
                copied.map(drop).map_err(|error| Failure::storage(target, &error))
            })?;
        }
        Ok(Some(Extent {
            bytes: head.len() as u64 + rest,
            blake3: hasher.finalize().to_hex().to_string(),
        }))
    }

    /// Appends bytes; they are written after a moment, or earlier if there are many.
    pub(crate) fn push(&mut self, bytes: &[u8]) -> Result {
        const MANY: usize = 1 << 22;
        // `oneiro watch` reads them.
        const LATE: Duration = Duration::from_millis(200);
        self.hasher.update(bytes);
        self.waiting.extend_from_slice(bytes);
        if self.waiting.len() >= MANY || self.flushed.elapsed() >= LATE {
            self.flush(false)?;
        }
        Ok(())
    }

    /// Writes all waiting bytes and waits until they are on disk. Returns the log's extent.
    pub(crate) fn sync(&mut self) -> Result<Extent> {
        self.flush(true)?;
        Ok(Extent {
            bytes: self.written,
            blake3: self.hasher.finalize().to_hex().to_string(),
        })
    }

    fn flush(&mut self, sync: bool) -> Result {
        let write = || -> io::Result<()> {
            let mut file = plain::append(&self.path)?;
            file.write_all(&self.waiting)?;
            if sync { file.sync_all() } else { Ok(()) }
        };
        write().map_err(|error| Failure::storage(&self.path, &error))?;
        self.written += self.waiting.len() as u64;
        self.waiting.clear();
        self.flushed = Instant::now();
        Ok(())
    }
}
