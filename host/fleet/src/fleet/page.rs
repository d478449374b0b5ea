//! The page of a fleet, a file for a browser: its arena, genes, food, states and problems, during the experiment and
//! afterwards.
//!
//! `live.html` never changes; every second it reloads `live.js` in the same folder. A thread writes that file, and the
//! table of statuses: the program that gives robots leave to move never waits for the disk. Lines that arrive while the
//! disk is busy are left out.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::mpsc::{self, SyncSender, TrySendError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant, SystemTime};

use oneiro::swarm::{Lamp, Swarm};
use oneiro_base::disk;
use oneiro_base::exit::{Failure, Result};
use oneiro_report::figures::{ForagersReplay, Genes, Moment, Teller, foragers_page, live_page, live_script};

use super::file::Fleet;
use super::operator::Known;
use super::statuses::{self, ACTS, Row, Story, Table};

/// The files.
pub const PAGE: &str = "live.html";
pub const SCRIPT: &str = "live.js";
pub const REPLAY: &str = "replay.html";
/// The live page's number of robots' lines, about 20 bytes each: 27 minutes of ten robots in full, then every other
/// second.
const MOST: usize = 16_384;
/// Lines that wait for a slow disk.
const WAITING: usize = 4;
/// Interval between two writes of the page while the experiment's time is stopped.
const PAUSE: Duration = Duration::from_secs(1);

/// What is the same at all times.
#[derive(Debug)]
struct Scene {
    title: String,
    foragers: Swarm,
    lamp: Lamp,
    robots: Vec<u32>,
}

impl Scene {
    fn of(fleet: &Fleet) -> Self {
        Self {
            title: format!("{}, seed {}", fleet.experiment.name(), fleet.seed),
            foragers: fleet.experiment.settings().swarm(),
            lamp: fleet.experiment.plan(fleet.seed).lamp(),
            robots: fleet.robots.iter().map(|robot| robot.number).collect(),
        }
    }

    fn replay<'a>(&'a self, lines: &'a [Moment], genes: &'a [Vec<Genes>]) -> ForagersReplay<'a> {
        ForagersReplay {
            title: &self.title,
            foragers: &self.foragers,
            lamp: self.lamp,
            names: &self.robots,
            acts: &ACTS,
            teller: Teller::Robots,
            lines,
            genes,
        }
    }
}

/// Writes a page of robots' reports during `oneiro fleet start`, in the fleet's directory, and returns its path.
///
/// # Errors
/// Exit 3 if nothing was recorded; exit 5 if that is damaged; exit 6.
pub fn replay(fleet: &Fleet) -> Result<PathBuf> {
    let scene = Scene::of(fleet);
    let rows = statuses::rows(&fleet.directory)?;
    let story = Story::of(scene.robots.clone(), usize::MAX, rows);
    let page = foragers_page(&scene.replay(&story.moments(), &story.genes()));
    let path = fleet.directory.join(REPLAY);
    disk::write(&path, page.as_bytes())?;
    Ok(path)
}

/// Messages to the thread.
enum Told {
    /// A line, and whether it belongs to the record: the experiment's time runs.
    Line(Vec<Row>, bool),
    /// How the robots' experiment has ended.
    End(String),
}

/// The page of a running fleet.
pub struct Page {
    sender: SyncSender<Told>,
    thread: JoinHandle<Result>,
    /// The experiment's time before it runs, s.
    second: u32,
    /// The last line: when, whether the experiment's time ran, and the second.
    last: Option<(Instant, bool, u32)>,
}

impl Page {
    /// Makes the page of a fleet whose experiment is at a time in ms. It has the robots' earlier reports.
    ///
    /// # Errors
    /// Exit 5 for a damaged table of statuses; exit 6; exit 1 if there is no thread for it.
    pub fn open(fleet: &Fleet, milliseconds: i64) -> Result<Self> {
        let mut writer = Writer::begin(fleet)?;
        Self::written_by(move |told| writer.take(told), milliseconds)
    }

    /// A page whose messages go to `take`.
    fn written_by(take: impl FnMut(Told) -> Result + Send + 'static, milliseconds: i64) -> Result<Self> {
        let (sender, told) = mpsc::sync_channel::<Told>(WAITING);
        let write = move || told.into_iter().map(take).fold(Ok(()), Result::and);
        let thread = thread::Builder::new().name("page".into()).spawn(write);
        Ok(Self {
            sender,
            thread: thread.map_err(|error| Failure::failed(format_args!("the page has no thread: {error}")))?,
            second: seconds(milliseconds),
            last: None,
        })
    }

    /// Shows what is known of the robots, once in a second of the experiment, at its time in ms; before it runs, once a second.
    pub fn look(&mut self, robots: &BTreeMap<u32, Known>, time: Option<i64>) {
        let (runs, second) = (time.is_some(), time.map_or(self.second, seconds));
        let is_new =
            |(at, ran, last): (Instant, bool, u32)| (ran, last) != (runs, second) || (!runs && at.elapsed() >= PAUSE);
        if !self.last.is_none_or(is_new) {
            return;
        }
        self.last = Some((Instant::now(), runs, second));
        let rows = robots
            .iter()
            .map(|(robot, known)| Row::of(second, *robot, known))
            .collect();
        match self.sender.try_send(Told::Line(rows, runs)) {
            // A busy disk, or a thread that has crashed: neither is a reason to keep robots from living.
            Ok(()) | Err(TrySendError::Full(_) | TrySendError::Disconnected(_)) => (),
        }
    }

    /// Writes on the page how the robots' experiment has ended, and waits until all is written: robots already stand
    /// still.
    ///
    /// # Errors
    /// The first error of writing.
    pub fn end(self, how: String) -> Result {
        // If the thread has crashed, joining it returns the error.
        let _ = self.sender.send(Told::End(how));
        drop(self.sender);
        let crashed = |_| Err(Failure::broken("the page's writer"));
        self.thread.join().unwrap_or_else(crashed)
    }
}

/// Whole seconds of a time in ms.
fn seconds(milliseconds: i64) -> u32 {
    u32::try_from(milliseconds / 1000).unwrap_or_default()
}

/// The thread's state.
struct Writer {
    scene: Scene,
    story: Story,
    table: Table,
    script: PathBuf,
}

impl Writer {
    /// Writes the page, and what is known at the beginning.
    fn begin(fleet: &Fleet) -> Result<Self> {
        let scene = Scene::of(fleet);
        let (table, rows) = Table::open(&fleet.directory)?;
        let writer = Self {
            story: Story::of(scene.robots.clone(), MOST, rows),
            script: fleet.directory.join(SCRIPT),
            scene,
            table,
        };
        let genes = vec![Vec::new(); writer.scene.robots.len()];
        let page = live_page(&writer.scene.replay(&[], &genes), SCRIPT);
        disk::note(&fleet.directory.join(PAGE), page.as_bytes())?;
        writer.write(None)?;
        Ok(writer)
    }

    fn take(&mut self, told: Told) -> Result {
        match told {
            Told::Line(rows, is_recorded) => {
                let recorded = if is_recorded { self.table.add(&rows) } else { Ok(()) };
                self.story.add(rows);
                recorded.and(self.write(None))
            }
            Told::End(how) => self.write(Some(&how)),
        }
    }

    fn write(&self, end: Option<&str>) -> Result {
        let (moments, genes) = (self.story.moments(), self.story.genes());
        let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
        let written = now.map_or(0, |now| now.as_millis() as u64);
        let script = live_script(&self.scene.replay(&moments, &genes), written, end);
        disk::note(&self.script, script.as_bytes())
    }
}

#[cfg(test)]
mod tests;
