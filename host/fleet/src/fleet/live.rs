//! A fleet's run: the operator waits for the robots, lets them act by the beacon until the experiment is over, and
//! restarts the daemons of robots that fall silent.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use oneiro_base::console::counted;
use oneiro_base::disk;
use oneiro_base::exit::{Code, Failure, Result};
use oneiro_base::plain;
use oneiro_lab::exchange::radio::Windows;
use serde::{Deserialize, Serialize};

use super::file::Fleet;
use super::operator::{Beacon, Ears, Socket, Station, Time};
use super::remote::Remote;
use super::service;

/// How often the operator looks at what has come.
const GLANCE: Duration = Duration::from_millis(20);
/// A robot without a message for this long is away.
pub(crate) const AWAY: Duration = Duration::from_secs(3);
/// A robot without a message for this long has its daemon restarted: a restart by systemd takes some seconds.
const SILENT: Duration = Duration::from_secs(15);
/// How often a daemon is started again in one silence, each time after twice the pause.
const ATTEMPTS: u32 = 5;

/// The operator's own record.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Record {
    /// The experiment's time so far, ms.
    pub milliseconds: i64,
    /// How often the operator has begun: no number of a datagram is used twice.
    pub boots: u32,
    /// Which datagrams were taken: none is taken twice, in no start.
    #[serde(default)]
    pub windows: Windows,
}

impl Record {
    const FILE: &str = "operator.json";

    /// The record of this start, which is on disk before any message is sent.
    ///
    /// # Errors
    /// Exit 5 if the record is damaged: without it, robots would take old numbers for replayed ones. Exit 6 if it can't
    /// be written.
    pub fn next(fleet: &Fleet) -> Result<Self> {
        plain::make_directory(&fleet.directory).map_err(|error| Failure::storage(&fleet.directory, &error))?;
        let path = fleet.directory.join(Self::FILE);
        let last: Self = disk::json_if_there(&path)?.unwrap_or_default();
        let next = Self {
            boots: last
                .boots
                .checked_add(1)
                .ok_or_else(|| Failure::corrupt(format_args!("{}: boots is {}", path.display(), last.boots)))?,
            ..last
        };
        disk::write(&path, &disk::json(&next))?;
        disk::sync_directory(&fleet.directory)?;
        Ok(next)
    }

    /// Saves what has come since: whole or not at all, at the end also through a power cut.
    ///
    /// # Errors
    /// Exit 6.
    pub fn save(&mut self, fleet: &Fleet, station: &Station, is_last: bool) -> Result {
        self.windows = station.windows();
        let (path, json) = (fleet.directory.join(Self::FILE), disk::json(self));
        if is_last {
            disk::write(&path, &json)
        } else {
            disk::note(&path, &json)
        }
    }
}

/// How a fleet is to live.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Robots without which the experiment does not begin.
    pub min: usize,
    /// How long to wait for them.
    pub wait: Duration,
}

/// How it ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// The experiment is over.
    Over,
    /// Somebody stopped it at this time of the experiment, ms.
    Stopped(i64),
}

/// Runs a fleet until the experiment is over or `stop` is set. `ears` receive its robots' radio. `show` gets all that
/// is known, with the experiment's time in ms, at each glance; before the experiment starts that time is `None`.
///
/// # Errors
/// Exit 4 if too few robots answer; those of `show` and of writing the record, after which robots stand still.
pub fn live(
    fleet: &Arc<Fleet>,
    mut record: Record,
    (socket, station): (&Arc<Socket>, &Arc<Station>),
    options: Options,
    stop: &AtomicBool,
    mut show: impl FnMut(&Ears, Option<i64>) -> Result,
) -> Result<End> {
    let mut ears = Ears::new(fleet, Arc::clone(socket), Arc::clone(station));
    let began = Instant::now();
    while ears.present() < options.min {
        ears.call();
        ears.listen();
        show(&ears, None)?;
        if stop.load(Ordering::Relaxed) {
            record.save(fleet, station, true)?;
            return Ok(End::Stopped(record.milliseconds));
        }
        if began.elapsed() > options.wait {
            record.save(fleet, station, true)?;
            return Err(absent(&ears, options));
        }
        thread::sleep(GLANCE);
    }
    // Never back: robots may have lived on for a moment after the operator was lost.
    let time = Time::from(record.milliseconds.max(ears.farthest().unwrap_or(0)));
    ears.time = Some(time);
    let over = 1000 * i64::from(fleet.experiment.settings().seconds());
    let beacon = Beacon::begin(Arc::clone(socket), Arc::clone(station), time)?;
    let mut revivals = Revivals::default();
    let mut saved = record.milliseconds;
    let end = loop {
        ears.listen();
        beacon.renew();
        record.milliseconds = time.now();
        if record.milliseconds - saved >= 1000 {
            record.save(fleet, station, false)?;
            saved = record.milliseconds;
        }
        show(&ears, Some(record.milliseconds))?;
        if record.milliseconds >= over {
            break End::Over;
        }
        if stop.load(Ordering::Relaxed) {
            break End::Stopped(record.milliseconds);
        }
        revivals.look(fleet, &ears);
        thread::sleep(GLANCE);
    };
    beacon.end();
    record.save(fleet, station, false)?;
    // Their answers.
    let until = Instant::now() + Duration::from_millis(1500);
    while Instant::now() < until {
        ears.listen();
        thread::sleep(GLANCE);
    }
    record.save(fleet, station, true)?;
    show(&ears, Some(record.milliseconds))?;
    Ok(end)
}

/// Says which robots keep the experiment from beginning.
fn absent(ears: &Ears, options: Options) -> Failure {
    let why = ears
        .robots
        .iter()
        .filter_map(|(number, known)| match (known.refusal(), known.heard) {
            (Some(refused), _) => Some(format!("robot {number} {refused}")),
            (None, None) if known.is_stale => Some(format!(
                "robot {number} sends, but does not answer this start: it does not receive this machine, or old \
                 datagrams are replayed"
            )),
            (None, None) => Some(format!("robot {number} sent nothing")),
            (None, Some(_)) => None,
        });
    let why: Vec<String> = why
        .chain(ears.refused.iter().map(|(reason, count)| format!("{count} x {reason}")))
        .collect();
    let (seconds, present) = (options.wait.as_secs(), ears.present());
    Failure::of(
        Code::Device,
        format_args!(
            "after {seconds} s {}, and {} needed (--min N begins with fewer): {}",
            counted(present, "robot is ready", "robots are ready"),
            counted(options.min, "is", "are"),
            why.join("; ")
        ),
    )
}

/// Daemons that are started again.
#[derive(Default)]
struct Revivals(BTreeMap<u32, Revival>);

/// Attempts in one silence of a robot.
struct Revival {
    attempts: u32,
    due: Instant,
    work: Option<JoinHandle<()>>,
}

impl Revivals {
    /// Starts the daemons again of robots that have been silent for long. A thread does it: `ssh` may take minutes.
    fn look(&mut self, fleet: &Arc<Fleet>, ears: &Ears) {
        for (&number, known) in &ears.robots {
            let silent = known.heard.is_none_or(|at| at.elapsed() > SILENT);
            if !silent || known.refusal().is_some() {
                self.0.remove(&number);
                continue;
            }
            let now = Instant::now();
            let revival = self.0.entry(number).or_insert_with(|| Revival {
                attempts: 0,
                // A robot that was never there gets the time that one has that left.
                due: if known.heard.is_some() { now } else { now + SILENT },
                work: None,
            });
            let is_busy = revival.work.as_ref().is_some_and(|work| !work.is_finished());
            if revival.attempts < ATTEMPTS && now >= revival.due && !is_busy {
                revival.attempts += 1;
                revival.due = now + SILENT * 2_u32.pow(revival.attempts - 1);
                let fleet = Arc::clone(fleet);
                let work = thread::Builder::new().spawn(move || {
                    if let Some(robot) = fleet.robot(number) {
                        // The robot's messages will show whether it worked.
                        let _ = Remote::of(&fleet, robot).run(&service::start_command(&fleet, robot));
                    }
                });
                revival.work = work.ok();
            }
        }
    }
}

#[cfg(test)]
pub(super) mod tests;
