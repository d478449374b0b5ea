//! The log of a daemon: a line of JSON for each event, to a file that never grows without bound and, under systemd, to the journal.
//!
//! Whoever logs never waits: events go into a queue of bounded length, and a thread writes them. What does not fit, or can't be written
//! because the disk is full, is dropped and counted, and a line `dropped` says how many were, as soon as there is room again.
//!
//! | event | further keys |
//! |---|---|
//! | `said` | `sequence`, `second`: a sent message |
//! | `heard` | `sender`, `sequence`, `second`: a received message |
//! | `end` | `stopped`: whether the robot has confirmed that its wheels stand |
//! | `dropped` | `count`: lines before this one that are missing |
//!
//! `oneiro fleet collect` and `stop` read these; other events have what describes them.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{self, Receiver, SyncSender};
use std::thread;
use std::time::Duration;

use oneiro_base::console::shown_in_json;
use oneiro_base::plain;
use oneiro_base::utc;
use serde_json::{Map, Value, json};

/// The current file; earlier ones are `log-1.jsonl`, `log-2.jsonl` and so on.
pub(super) const FILE: &str = "log.jsonl";
/// Waiting lines: about ten seconds of a robot among nine others.
const QUEUE: usize = 1024;
/// Longest wait for the last lines to be written when a log is closed.
const LAST: Duration = Duration::from_secs(2);

/// How much a log keeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Limits {
    /// Bytes of a file; the line that exceeds them is the first of the next.
    pub bytes: u64,
    /// Number of files, including the current one. The oldest is deleted.
    pub files: u64,
}

impl Default for Limits {
    /// 256 MiB, two days of a robot that always hears nine others: ten lines a second of about 150 bytes.
    fn default() -> Self {
        Self {
            bytes: 16 << 20,
            files: 16,
        }
    }
}

/// The writing end of a log.
#[derive(Debug)]
pub(super) struct Log {
    robot: u32,
    boot: u32,
    lines: Option<SyncSender<String>>,
    /// Lines that found no room in the queue, and have not been reported yet.
    dropped: Arc<AtomicU64>,
    /// Lines that were dropped in all, or could not be written.
    lost: Arc<AtomicU64>,
    /// Hears when the thread has ended.
    ended: Receiver<()>,
}

impl Log {
    /// Continues the log of a directory. Nothing fails, since a full disk may have room later.
    pub(super) fn open(directory: &Path, robot: u32, boot: u32, limits: Limits) -> Self {
        Self::with(Pages::new(directory, limits), journal(), robot, boot)
    }

    fn with(pages: Pages, journal: Option<Box<dyn Write + Send>>, robot: u32, boot: u32) -> Self {
        let (lines, waiting) = mpsc::sync_channel(QUEUE);
        let (end, ended) = mpsc::channel();
        let dropped = Arc::new(AtomicU64::new(0));
        let lost = Arc::new(AtomicU64::new(0));
        let writer = Writer {
            pages,
            journal,
            dropped: Arc::clone(&dropped),
            lost: Arc::clone(&lost),
            missing: 0,
            head: (robot, boot),
        };
        let thread = thread::Builder::new().name("log".into()).spawn(move || {
            writer.write(&waiting);
            // The receiver may have stopped waiting.
            let _ = end.send(());
        });
        Self {
            robot,
            boot,
            // Without a thread all lines are dropped, and counted.
            lines: thread.is_ok().then_some(lines),
            dropped,
            lost,
            ended,
        }
    }

    /// Logs an event that happened so long after the daemon's start. `fields` is an object with what else there is to say.
    pub(super) fn event(&self, at: Duration, experiment_ms: Option<i64>, event: &str, fields: Value) {
        let head = (self.robot, self.boot);
        let line = line(head, at, experiment_ms, event, fields);
        let is_taken = self.lines.as_ref().is_some_and(|lines| lines.try_send(line).is_ok());
        if !is_taken {
            self.dropped.fetch_add(1, Ordering::Relaxed);
            self.lost.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// Lines that were dropped so far, or could not be written.
    pub(super) fn lost(&self) -> u64 {
        self.lost.load(Ordering::Relaxed)
    }
}

impl Drop for Log {
    /// Waits until all lines are written, but not for ever.
    fn drop(&mut self) {
        if self.lines.take().is_some() {
            let _ = self.ended.recv_timeout(LAST);
        }
    }
}

fn line((robot, boot): (u32, u32), at: Duration, experiment_ms: Option<i64>, event: &str, fields: Value) -> String {
    let mut values = Map::from_iter([
        ("at_ms".to_owned(), json!(at.as_millis() as u64)),
        ("experiment_ms".to_owned(), json!(experiment_ms)),
        ("utc".to_owned(), json!(utc::now())),
        ("robot".to_owned(), json!(robot)),
        ("boot".to_owned(), json!(boot)),
        ("event".to_owned(), json!(event)),
    ]);
    if let Value::Object(fields) = fields {
        values.extend(fields);
    }
    shown_in_json(&Value::Object(values).to_string()).into_owned() + "\n"
}

/// Standard error, if it is systemd's journal: `JOURNAL_STREAM` has its device and inode (systemd.exec(5)).
#[expect(clippy::disallowed_methods, reason = "it is asked what it is")]
fn journal() -> Option<Box<dyn Write + Send>> {
    use std::os::fd::AsFd;
    use std::os::unix::fs::MetadataExt;
    let stream = std::env::var("JOURNAL_STREAM").ok()?;
    let file = File::from(io::stderr().as_fd().try_clone_to_owned().ok()?);
    let metadata = file.metadata().ok()?;
    let is_journal = stream == format!("{}:{}", metadata.dev(), metadata.ino());
    is_journal.then(|| Box::new(file) as Box<dyn Write + Send>)
}

/// The thread that writes.
struct Writer {
    pages: Pages,
    journal: Option<Box<dyn Write + Send>>,
    dropped: Arc<AtomicU64>,
    lost: Arc<AtomicU64>,
    /// Lines that are missing in the file, and not reported there yet.
    missing: u64,
    /// Robot and boot.
    head: (u32, u32),
}

impl Writer {
    fn write(mut self, lines: &Receiver<String>) {
        let mut last = String::new();
        while let Ok(line) = lines.recv() {
            self.missing += self.dropped.swap(0, Ordering::Relaxed);
            if self.missing > 0 && self.report(&line) {
                self.missing = 0;
            }
            if self.pages.push(line.as_bytes()).is_err() {
                self.missing += 1;
                self.lost.fetch_add(1, Ordering::Relaxed);
            }
            // A closed standard error stays closed.
            if self
                .journal
                .as_mut()
                .is_some_and(|journal| journal.write_all(line.as_bytes()).is_err())
            {
                self.journal = None;
            }
            last = line;
        }
        self.missing += self.dropped.swap(0, Ordering::Relaxed);
        if self.missing > 0 {
            self.report(&last);
        }
    }

    /// Writes how many lines are missing, with the time of the next line. Returns whether it is written.
    fn report(&mut self, beside: &str) -> bool {
        let times: Value = serde_json::from_str(beside).unwrap_or_default();
        let at = Duration::from_millis(times["at_ms"].as_u64().unwrap_or(0));
        let fields = json!({ "count": self.missing });
        let line = line(self.head, at, times["experiment_ms"].as_i64(), "dropped", fields);
        self.pages.push(line.as_bytes()).is_ok()
    }
}

/// The files of a log.
#[derive(Debug)]
struct Pages {
    directory: PathBuf,
    limits: Limits,
    file: Option<File>,
    /// Bytes of whole lines in the file.
    length: u64,
    /// Number of the next file that is full.
    next: u64,
}

impl Pages {
    fn new(directory: &Path, limits: Limits) -> Self {
        let entries = fs::read_dir(directory).into_iter().flatten().flatten();
        let number = |name: &str| name.strip_prefix("log-")?.strip_suffix(".jsonl")?.parse::<u64>().ok();
        let last = entries.filter_map(|entry| number(entry.file_name().to_str()?)).max();
        Self {
            directory: directory.to_owned(),
            limits,
            file: None,
            length: 0,
            next: last.unwrap_or(0) + 1,
        }
    }

    fn path(&self, number: u64) -> PathBuf {
        self.directory.join(format!("log-{number}.jsonl"))
    }

    /// Appends a line, whole or not at all.
    fn push(&mut self, line: &[u8]) -> io::Result<()> {
        if self.length > 0 && self.length + line.len() as u64 > self.limits.bytes {
            self.turn()?;
        }
        let length = self.length;
        let file = self.open_file()?;
        if let Err(error) = file.write_all(line) {
            // Removes the rest of a torn line. If even that fails, the next start cuts it off.
            let _ = file.set_len(length);
            return Err(error);
        }
        self.length += line.len() as u64;
        Ok(())
    }

    /// The current file, opened if need be. After a crash its last line may be torn: it is ended, so that the next one
    /// is whole.
    fn open_file(&mut self) -> io::Result<&mut File> {
        if self.file.is_none() {
            let path = self.directory.join(FILE);
            let mut file = plain::append_or_create(&path)?;
            self.length = file.metadata()?.len();
            if self.length > 0 && !ends_a_line(&path)? {
                file.write_all(b"\n")?;
                self.length += 1;
            }
            self.file = Some(file);
        }
        self.file.as_mut().ok_or_else(|| io::ErrorKind::NotFound.into())
    }

    /// Puts the full file aside, and removes the oldest.
    fn turn(&mut self) -> io::Result<()> {
        self.file = None;
        self.length = 0;
        fs::rename(self.directory.join(FILE), self.path(self.next))?;
        if let Some(oldest) = (self.next + 1).checked_sub(self.limits.files) {
            // The oldest may be gone already.
            let _ = fs::remove_file(self.path(oldest));
        }
        self.next += 1;
        Ok(())
    }
}

fn ends_a_line(path: &Path) -> io::Result<bool> {
    use std::io::{Read, Seek, SeekFrom};
    let mut file = plain::open(path)?;
    file.seek(SeekFrom::End(-1))?;
    let mut last = [0];
    file.read_exact(&mut last)?;
    Ok(last == *b"\n")
}

#[cfg(test)]
mod tests;
