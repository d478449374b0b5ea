//! Journal of one process, a shard, of a sweep. It grows while the device works, and survives any end of the process.
//!
//! | file | contents |
//! |---|---|
//! | `results.log` | a line for each finished run: a tag that exposes damaged lines, then JSON, see [`Line`] |
//! | `generations.log` | the finished runs' tables of generations, one after another |
//! | `checkpoint-N` | the two newest: the runs in progress, see [`Saved`] and [`crate::engine::checkpoint`] |
//! | `sessions.json` | provenance: the processes that worked here, with their times and devices |
//! | `lock` | held by the one process that writes |

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{self, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{self, SyncSender};
use std::thread::{self, JoinHandle};

use oneiro_base::disk;
use oneiro_base::exit::{Failure, Result};
use oneiro_base::plain;
use oneiro_base::utc::now;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::RunIndex;
use crate::engine::checkpoint;
use crate::engine::job::Named;
use crate::record::Session;
use crate::threads;

const RESULTS: &str = "results.log";
const GENERATIONS: &str = "generations.log";
const SESSIONS: &str = "sessions.json";
/// Length of the tag before a line's JSON, in hex digits: the beginning of its BLAKE3 hash.
const TAG: usize = 16;

/// A finished run, as a line of `results.log`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Line {
    pub run: RunIndex,
    pub id: String,
    /// Its values in the table of results.
    pub outcomes: Named,
    /// Its champion's genes as text, with commas between them; empty if it has no champion.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub champion: String,
    /// Hash of the results.
    pub result: String,
    /// Position of its generations in `generations.log`, their length, and their hash.
    pub from: u64,
    pub bytes: u64,
    pub blake3: String,
}

impl Line {
    /// Where its generations end.
    fn end(&self) -> Option<u64> {
        self.from.checked_add(self.bytes)
    }

    /// Appends it to a file's text.
    fn encode(&self, text: &mut Vec<u8>) {
        let start = text.len();
        text.extend([b' '; TAG + 1]);
        serde_json::to_writer(&mut *text, self).expect("numbers and words");
        let tag = tag(&text[start + TAG + 1..]);
        text[start..start + TAG].copy_from_slice(&tag);
        text.push(b'\n');
    }

    fn decode(line: &str) -> Option<Self> {
        let (own, json) = line.split_at_checked(TAG)?;
        let json = json.strip_prefix(' ')?;
        if own.as_bytes() != tag(json.as_bytes()) {
            return None;
        }
        serde_json::from_str(json).ok()
    }
}

fn tag(json: &[u8]) -> [u8; TAG] {
    let hex = blake3::hash(json).to_hex();
    std::array::from_fn(|digit| hex.as_bytes()[digit])
}

/// Contents of a shard's logs.
#[derive(Debug, Default)]
pub(crate) struct Logged {
    /// The shard's finished runs.
    pub lines: Vec<Line>,
    /// Warnings about unusable lines; their runs are repeated.
    pub problems: Vec<String>,
    /// Length in bytes of the table of results up to its last complete line.
    whole: u64,
}

impl Logged {
    /// Reads a shard's logs. A process may be writing them.
    pub(crate) fn read(directory: &Path) -> Result<Self> {
        let path = directory.join(RESULTS);
        let Some(text) = disk::read_if_there(&path)? else {
            return Ok(Self::default());
        };
        let whole = text.iter().rposition(|&byte| byte == b'\n').map_or(0, |end| end + 1);
        // Must be read after the lines: the writer puts generations first.
        let there = fs::metadata(directory.join(GENERATIONS)).map_or(0, |file| file.len());
        let mut logged = Self {
            whole: whole as u64,
            ..Self::default()
        };
        threads::prepare();
        let lines = text[..whole].par_split_inclusive(|&byte| byte == b'\n');
        let decoded = lines.map(|bytes| {
            let line = std::str::from_utf8(bytes).ok()?;
            Line::decode(line.trim_end_matches('\n'))
        });
        for (line, number) in decoded.collect::<Vec<_>>().into_iter().zip(1..) {
            match line {
                Some(line) if line.end().is_some_and(|end| end <= there) => logged.lines.push(line),
                Some(line) => logged.problems.push(format!(
                    "{}:{number}: {GENERATIONS} is shorter than it was; run {} is done again",
                    path.display(),
                    line.run
                )),
                None => logged.problems.push(format!(
                    "{}:{number}: is damaged; its run is done again",
                    path.display()
                )),
            }
        }
        Ok(logged)
    }
}

/// Reader of the tables of generations of finished runs.
pub struct Generations {
    path: PathBuf,
    file: BufReader<File>,
    /// Position in the file.
    at: u64,
}

impl Generations {
    /// Opens a shard's tables.
    pub fn open(directory: &Path) -> Result<Self> {
        let path = directory.join(GENERATIONS);
        let file = plain::open_table(&path).map_err(|error| Failure::storage(&path, &error))?;
        Ok(Self {
            path,
            file: BufReader::with_capacity(1 << 16, file),
            at: 0,
        })
    }

    /// Reads a run's lines.
    ///
    /// # Errors
    /// Exit 5 if they aren't what was written.
    pub fn of(&mut self, line: &Line) -> Result<String> {
        let mut bytes = vec![0; line.bytes as usize];
        // Most runs follow each other, so that they are in the buffer.
        self.file
            .seek_relative(line.from as i64 - self.at as i64)
            .and_then(|()| self.file.read_exact(&mut bytes))
            .map_err(|error| Failure::storage(&self.path, &error))?;
        self.at = line.from + line.bytes;
        let damaged = || {
            Failure::corrupt(format_args!(
                "{}: the generations of run {}, {} bytes from {} on, are damaged; remove the line of this run from \
                 {RESULTS} beside it, and `oneiro sweep run` does it again",
                self.path.display(),
                line.run,
                line.bytes,
                line.from
            ))
        };
        if blake3::hash(&bytes).to_hex().as_str() != line.blake3 {
            return Err(damaged());
        }
        String::from_utf8(bytes).map_err(|_| damaged())
    }
}

/// Results of a finished run. Numbers are text as in the tables, so that they have the same bytes whichever way they
/// take.
#[derive(Clone, Debug)]
pub struct Outcome {
    pub run: RunIndex,
    /// Its values in the table of results.
    pub outcomes: Named,
    /// Its champion's genes, with commas between them; empty if it has no champion.
    pub champion: String,
    /// Table of steps without its first line.
    pub generations: String,
    /// Hash of the results; a run directory of the same run has the same hash.
    pub result: String,
}

/// A run in progress, saved between two steps.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Saved {
    pub run: RunIndex,
    /// Finished generations or minutes.
    pub done: u32,
    /// Tables so far, with their first lines.
    pub tables: Vec<Vec<u8>>,
    /// The saved job.
    pub job: Vec<u8>,
}

/// Number of runs in progress at a shard's newest good checkpoint, and the total of their finished generations. A
/// process may be writing there.
pub fn under_way(directory: &Path, identity: &blake3::Hash) -> Result<(usize, u64)> {
    let newest = checkpoint::list(directory)?
        .into_iter()
        // A file that has disappeared wasn't the newest.
        .find_map(|(_, path)| checkpoint::read::<Vec<Saved>>(&path, identity).ok());
    let runs = newest.unwrap_or_default();
    let generations = runs.iter().map(|run| u64::from(run.done)).sum();
    Ok((runs.len(), generations))
}

/// State of a shard when a process begins to work on it.
#[derive(Debug)]
pub struct Begun {
    /// Finished runs. There may be more than at the last look: another process may have worked here until now.
    pub finished: BTreeSet<RunIndex>,
    /// Runs in progress.
    pub saved: Vec<Saved>,
    /// Warnings about damaged checkpoints.
    pub problems: Vec<String>,
}

/// Writer of a shard's journal, on its own thread. While it exists, no other process can write the journal.
#[derive(Debug)]
pub struct Journal {
    entries: SyncSender<Entry>,
    writer: JoinHandle<Result<Vec<Line>>>,
    directory: PathBuf,
    sessions: Vec<Session>,
    _lock: File,
}

enum Entry {
    Done(Vec<(Outcome, blake3::Hash)>),
    UnderWay(Vec<Saved>),
}

impl Journal {
    /// Starts writing where the last process stopped.
    ///
    /// # Errors
    /// Exit 75 if another process writes there, exit 6 if writing fails.
    pub fn begin(directory: &Path, identity: blake3::Hash, session: Session) -> Result<(Self, Begun)> {
        /// Maximum number of entries that may wait for the disk; beyond that, the main loop also waits.
        const WAITING: usize = 4;
        let Some(lock) = disk::try_lock(directory)? else {
            return Err(Failure::stopped(format_args!(
                "{}: another process is working on this shard; run the same command again once it has finished",
                directory.display()
            )));
        };
        let logged = Logged::read(directory)?;
        let mut whole = logged.whole;
        if !logged.problems.is_empty() {
            // Unusable lines are removed: they would look good once new generations have grown into their place.
            let mut lines = Vec::new();
            logged.lines.iter().for_each(|line| line.encode(&mut lines));
            disk::write(&directory.join(RESULTS), &lines)?;
            disk::sync_directory(directory)?;
            whole = lines.len() as u64;
        }
        let mut begun = Begun {
            finished: logged.lines.iter().map(|line| line.run).collect(),
            saved: Vec::new(),
            problems: Vec::new(),
        };
        let found = checkpoint::list(directory)?;
        for (_, path) in &found {
            match checkpoint::read(path, &identity) {
                Ok(saved) => {
                    begun.saved = saved;
                    break;
                }
                Err(problem) => {
                    let words = checkpoint::words(&problem, "sweep");
                    begun
                        .problems
                        .push(format!("{}: {words}; it is not used", path.display()));
                }
            }
        }
        let end = logged.lines.iter().filter_map(Line::end).max().unwrap_or(0);
        let mut writer = Writer {
            results: Appended::cut_back(directory.join(RESULTS), whole)?,
            generations: Appended::cut_back(directory.join(GENERATIONS), end)?,
            directory: directory.to_owned(),
            identity,
            next: found.first().map_or(0, |(number, _)| number + 1),
            lines: logged.lines,
        };
        let (entries, received) = mpsc::sync_channel::<Entry>(WAITING);
        let writer = thread::spawn(move || {
            received.into_iter().try_for_each(|entry| writer.write(entry))?;
            Ok(writer.lines)
        });
        // Nothing depends on them.
        let known = disk::json_if_there(&directory.join(SESSIONS)).ok().flatten();
        let mut sessions: Vec<Session> = known.unwrap_or_default();
        sessions.push(session);
        disk::note(&directory.join(SESSIONS), &disk::json(&sessions))?;
        let journal = Self {
            entries,
            writer,
            directory: directory.to_owned(),
            sessions,
            _lock: lock,
        };
        Ok((journal, begun))
    }

    /// Records finished runs with their ids.
    ///
    /// # Errors
    /// Nothing can be written any more; [`Journal::close`] says why.
    pub fn done(&self, outcomes: Vec<(Outcome, blake3::Hash)>) -> Result {
        self.write(Entry::Done(outcomes))
    }

    /// Records runs in progress, which can be resumed from here whatever happens.
    ///
    /// # Errors
    /// As [`Journal::done`].
    pub fn checkpoint(&self, runs: Vec<Saved>) -> Result {
        self.write(Entry::UnderWay(runs))
    }

    fn write(&self, entry: Entry) -> Result {
        let sent = self.entries.send(entry);
        sent.map_err(|_| Failure::failed("results can't be written"))
    }

    /// Waits until everything is on disk. Returns all runs that the journal has.
    ///
    /// # Errors
    /// Exit 6 with what could not be written.
    pub fn close(mut self) -> Result<Vec<Line>> {
        let Self { entries, writer, .. } = self;
        drop(entries);
        let written = writer
            .join()
            .unwrap_or_else(|_| Err(Failure::broken("the writer of results")));
        if let Some(session) = self.sessions.last_mut() {
            session.ended = Some(now());
        }
        let lines = written?;
        disk::note(&self.directory.join(SESSIONS), &disk::json(&self.sessions))?;
        Ok(lines)
    }
}

/// Bytes written at a time.
const PIECE: usize = 1 << 18;

/// The journal's thread.
struct Writer {
    results: Appended,
    generations: Appended,
    directory: PathBuf,
    identity: blake3::Hash,
    /// Number of the next checkpoint.
    next: u64,
    /// Contents of the table of results.
    lines: Vec<Line>,
}

impl Writer {
    /// Writes the generations before the results that refer to them.
    fn write_pieces(&mut self) -> Result {
        self.generations.write_piece()?;
        self.results.write_piece()
    }

    fn write(&mut self, entry: Entry) -> Result {
        match entry {
            Entry::Done(outcomes) => {
                for (outcome, id) in outcomes {
                    let generations = &outcome.generations;
                    let line = Line {
                        run: outcome.run,
                        id: id.to_hex().to_string(),
                        outcomes: outcome.outcomes,
                        champion: outcome.champion,
                        result: outcome.result,
                        from: self.generations.bytes,
                        bytes: generations.len() as u64,
                        blake3: blake3::hash(generations.as_bytes()).to_hex().to_string(),
                    };
                    self.generations.push(|piece| piece.extend(generations.as_bytes()));
                    self.results.push(|piece| line.encode(piece));
                    self.lines.push(line);
                    if self.generations.piece.len() + self.results.piece.len() >= PIECE {
                        self.write_pieces()?;
                    }
                }
                self.write_pieces()
            }
            Entry::UnderWay(runs) => {
                // Runs that have left the checkpoint must be on disk before it is written.
                self.generations.sync()?;
                self.results.sync()?;
                // With no run in progress, older checkpoints are also useless.
                let kept = if runs.is_empty() { 1 } else { 2 };
                checkpoint::write(&self.directory, self.next, kept, &self.identity, &runs)?;
                self.next += 1;
                Ok(())
            }
        }
    }
}

/// An append-only file.
struct Appended {
    path: PathBuf,
    file: File,
    /// Length with the piece.
    bytes: u64,
    /// Bytes that are not in the file yet: short runs finish by the thousand, and a call to the system for each would cost
    /// more than the run.
    piece: Vec<u8>,
}

impl Appended {
    /// Opens a file and truncates it to `bytes` bytes.
    fn cut_back(path: PathBuf, bytes: u64) -> Result<Self> {
        let open = || -> io::Result<File> {
            let file = plain::append_or_create(&path)?;
            if file.metadata()?.len() != bytes {
                file.set_len(bytes)?;
            }
            Ok(file)
        };
        match open() {
            Ok(file) => Ok(Self {
                path,
                file,
                bytes,
                piece: Vec::new(),
            }),
            Err(error) => Err(Failure::storage(&path, &error)),
        }
    }

    fn push(&mut self, append: impl FnOnce(&mut Vec<u8>)) {
        let before = self.piece.len();
        append(&mut self.piece);
        self.bytes += (self.piece.len() - before) as u64;
    }

    fn write_piece(&mut self) -> Result {
        let written = self.file.write_all(&self.piece);
        self.piece.clear();
        written.map_err(|error| Failure::storage(&self.path, &error))
    }

    fn sync(&self) -> Result {
        self.file
            .sync_data()
            .map_err(|error| Failure::storage(&self.path, &error))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_damaged_line_is_none() {
        let line = Line {
            run: 5,
            id: "ab".into(),
            outcomes: [("best", "1.5"), ("mean", "NaN")]
                .map(|(name, value)| (name.into(), value.into()))
                .into(),
            champion: "0.1,-340282350000000000000000000000000000000".into(),
            result: "cd".into(),
            from: 10,
            bytes: 20,
            blake3: "ef".into(),
        };
        let mut good = Vec::new();
        line.encode(&mut good);
        let good = String::from_utf8(good).unwrap();
        assert_eq!(Line::decode(good.trim_end()), Some(line));
        for length in 0..good.len() - 1 {
            assert_eq!(Line::decode(&good[..length]), None);
        }
        for place in 0..good.len() - 1 {
            for bit in 0..8 {
                let mut bad = good.trim_end().as_bytes().to_vec();
                bad[place] ^= 1 << bit;
                let read = std::str::from_utf8(&bad).ok().and_then(Line::decode);
                assert_eq!(read, None, "byte {place}");
            }
        }
    }
}
