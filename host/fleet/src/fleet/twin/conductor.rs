//! The conductor: gives time to daemons, guards, emulated robots and the arena, in the order of their next moments, one at a time. A
//! participant that computes holds the others, so nothing depends on how fast it is.
//!
//! At one moment bytes reach robots first; then faults begin and end, the arena runs a cycle, the operator's beacon is sent, and the
//! participants go on, robot by robot, the guard before its daemon.

use std::collections::BTreeMap;
use std::io::{self, ErrorKind};
use std::os::unix::net::UnixListener;
use std::path::{Path, PathBuf};
use std::process::Child;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use oneiro::swarm::Line;
use oneiro_base::exit::{Failure, Result};
use oneiro_base::plain;
use oneiro_robots::guard::values::Values;
use rustix::process::{Pid, Signal, kill_process};

use super::clocks::LocalClock;
use super::disk::SmallDisk;
use super::epuck::EPuck;
use super::faults::{self, Carrier, Event, Faults, OPERATOR, SECOND, TRACKER, What};
use super::guard::Guard;
use super::record::{Record, Stop};
use super::wire::{Port, Time, Up, VERSION};
use crate::daemon::epuck::{Activations, readings};

/// A cycle of the arena, ns, and the time between two beacons.
const CYCLE: u64 = SECOND / 10;
/// Time in which daemons connect to their robots, before the experiment's second 0, ns.
const LEAD_IN: u64 = 3 * SECOND;
/// How much earlier than the experiment daemons may end, whose clocks may be ahead, ns.
const CLOCKS: u64 = SECOND;
/// Time in which daemons end after the experiment, ns.
const FAREWELL: u64 = 10 * SECOND;
/// How long a daemon may take to start, and to compute, in real time.
const START: Duration = Duration::from_mins(1);
const COMPUTE: Duration = Duration::from_mins(10);
/// Datagrams that a forger has recorded.
const RECORDED: usize = 32;

/// The arena, driven from outside.
pub trait World {
    /// What each robot's sensors read until the next cycle.
    fn readings(&self) -> Vec<Activations>;

    /// Runs a cycle in which the left and the right wheel of each robot turn at these speeds, mm/s.
    ///
    /// # Errors
    /// It can't be computed.
    fn cycle(&mut self, wheels: &[[f64; 2]]) -> Result<Line>;
}

/// The operator's machine.
pub trait Operator {
    /// The beacon at a time of the experiment, ms, which is negative before it begins, and whether robots may live.
    fn beacon(&mut self, milliseconds: i64, go: bool) -> Vec<u8>;

    /// Takes a datagram of a robot. The time is since the conductor began.
    fn hear(&mut self, datagram: &[u8], now: Duration);
}

/// What starts daemons.
pub trait Daemons {
    /// Starts a robot's daemon, which connects to the socket. Returns its process, if it has one.
    ///
    /// # Errors
    /// The system can't start it.
    fn start(&mut self, robot: u32, socket: &Path) -> Result<Option<Child>>;

    /// Where its files are.
    fn directory(&self, robot: u32) -> PathBuf;
}

/// A twin's parts.
pub struct Plan {
    /// Number of robots.
    pub robots: u32,
    /// Length of the experiment, s.
    pub seconds: u32,
    /// Chance that the tracker does not see a robot in a cycle.
    pub tracking_loss: f64,
    /// The guards' values.
    pub guard: Values,
    /// The script of faults.
    pub faults: Faults,
    /// How many times faster than in reality time passes at most; as fast as possible if none.
    pub speed: Option<f64>,
    /// A new directory for the record.
    pub directory: PathBuf,
}

/// What came of it.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct Outcome {
    /// Hash of the arena's run and of the daemons' tables of intervals.
    pub hash: String,
    /// Seconds of the experiment.
    pub seconds: u64,
    /// Food that each robot has brought.
    pub brought: Vec<u32>,
    /// Daemons that ended by themselves too early, or with an error.
    pub problems: Vec<String>,
    /// Whether it was stopped before its end.
    pub stopped: bool,
}

/// What a participant waits for.
#[derive(Clone, Copy, Default)]
struct Wait {
    /// The end of its waiting, on its own clock.
    until: u64,
    /// Whether bytes of the serial line, and lines of the daemon or the guard, end it before.
    line: bool,
    told: bool,
}

/// A participant.
enum Player {
    Daemon(Port),
    Guard(Guard),
}

impl Player {
    /// Gives it time, and takes its messages until it waits again.
    ///
    /// # Errors
    /// It has ended, or takes too long.
    fn turn(&mut self, time: Time) -> (Vec<Up>, io::Result<Wait>) {
        let mut said = match self {
            Self::Guard(guard) => guard.turn(time),
            Self::Daemon(port) => match port.send(&[time]) {
                Ok(()) => Vec::new(),
                Err(error) => return (Vec::new(), Err(error)),
            },
        };
        loop {
            match said.pop() {
                Some(Up::Wait { until, line, told }) => return (said, Ok(Wait { until, line, told })),
                last => said.extend(last),
            }
            let next = match self {
                Self::Guard(_) => Err(ErrorKind::UnexpectedEof.into()),
                Self::Daemon(port) => port.receive(),
            };
            match next {
                Ok(message) => said.push(message),
                Err(error) => return (said, Err(error)),
            }
        }
    }

    /// Gives it no more time.
    fn close(self) {
        match self {
            Self::Daemon(port) => port.close(),
            Self::Guard(guard) => guard.close(),
        }
    }
}

/// A participant's place.
struct Seat {
    player: Player,
    wait: Wait,
    /// Lines for it.
    lines: Vec<String>,
    /// Whether it does not know yet that the other side is gone, and that the experiment is over.
    is_alone: bool,
    must_know: bool,
}

impl Seat {
    /// A participant that waits for the time.
    fn new(player: Player) -> Self {
        Self {
            player,
            wait: Wait::default(),
            lines: Vec::new(),
            is_alone: false,
            must_know: false,
        }
    }
}

/// A robot and its participants.
struct Robot {
    body: EPuck,
    clock: LocalClock,
    daemon: Option<Seat>,
    guard: Option<Seat>,
    process: Option<Child>,
    disk: Option<SmallDisk>,
    /// When the daemon is restarted, continued, and has room on its disk.
    starts: Option<u64>,
    goes_on: Option<u64>,
    has_room: Option<u64>,
    /// Datagrams on their way to the daemon, in the order of arrival; with whether they are the tracker's.
    coming: BTreeMap<(u64, u64), (bool, Vec<u8>)>,
    brought: u32,
}

impl Robot {
    fn new() -> Self {
        Self {
            body: EPuck::new(),
            clock: LocalClock::default(),
            daemon: None,
            guard: None,
            process: None,
            disk: None,
            starts: None,
            goes_on: None,
            has_room: None,
            coming: BTreeMap::new(),
            brought: 0,
        }
    }

    fn seat(&mut self, who: Who) -> &mut Option<Seat> {
        match who {
            Who::Guard => &mut self.guard,
            Who::Daemon => &mut self.daemon,
        }
    }

    /// A participant's next moment, if it is there and is not stopped.
    fn due(&self, who: Who, now: u64) -> Option<u64> {
        let seat = match who {
            Who::Guard => self.guard.as_ref(),
            Who::Daemon => self.daemon.as_ref().filter(|_| self.goes_on.is_none()),
        }?;
        let news = !seat.lines.is_empty() || seat.is_alone;
        let at_once = (seat.wait.told && news || seat.must_know).then_some(now);
        let bytes = self.body.answered().filter(|_| seat.wait.line);
        let until = self.clock.reaches(seat.wait.until);
        [at_once, bytes]
            .into_iter()
            .flatten()
            .fold(until, u64::min)
            .max(now)
            .into()
    }

    /// The next moment at which something happens to it.
    fn next(&self, now: u64) -> Option<u64> {
        let timers = [self.body.next(), self.starts, self.goes_on, self.has_room];
        let seats = Who::ALL.map(|who| self.due(who, now));
        timers.into_iter().chain(seats).flatten().min()
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Who {
    Guard,
    Daemon,
}

impl Who {
    const ALL: [Self; 2] = [Self::Guard, Self::Daemon];

    fn other(self) -> Self {
        match self {
            Self::Guard => Self::Daemon,
            Self::Daemon => Self::Guard,
        }
    }
}

/// A running twin.
pub struct Conductor<'a> {
    plan: Plan,
    world: &'a mut dyn World,
    operator: &'a mut dyn Operator,
    daemons: &'a mut dyn Daemons,
    listener: UnixListener,
    socket: PathBuf,
    robots: Vec<Robot>,
    now: u64,
    /// The next cycle and the next fault.
    cycle: u64,
    event: usize,
    beacon: u64,
    /// When the experiment ends or has ended.
    end: u64,
    is_over: bool,
    /// Until when the operator is silent.
    silent: u64,
    /// How many datagrams each has sent to each, and how many there were in all.
    counts: BTreeMap<(u32, u32), u64>,
    sequence: u64,
    /// Datagrams on their way to the operator.
    reports: BTreeMap<(u64, u64), Vec<u8>>,
    /// The last datagrams.
    said: Vec<Vec<u8>>,
    stops: Vec<Stop>,
    places: Vec<[f32; 2]>,
    record: Record,
    outcome: Outcome,
}

impl<'a> Conductor<'a> {
    /// Prepares a twin, whose daemons are not started yet.
    ///
    /// # Errors
    /// Exit 3 if the directory exists; exit 4 without the right to mount the disks that the script fills; exit 6.
    pub fn new(
        plan: Plan,
        world: &'a mut dyn World,
        operator: &'a mut dyn Operator,
        daemons: &'a mut dyn Daemons,
    ) -> Result<Self> {
        let directory = &plan.directory;
        plain::make_directory(directory).map_err(|error| oneiro_base::files::uncreated(directory, &error))?;
        let record = Record::new(directory)?;
        oneiro_base::contents::describe(directory, "A twin", &super::record::CONTENTS)?;
        // Names of sockets are short, and those of directories need not be.
        let name = blake3::hash(directory.as_os_str().as_encoded_bytes()).to_hex();
        let socket = std::env::temp_dir().join(format!("oneiro-twin-{}-{}", std::process::id(), &name[..8]));
        let listener = UnixListener::bind(&socket).map_err(|error| Failure::storage(&socket, &error))?;
        let mut robots: Vec<Robot> = (0..plan.robots).map(|_| Robot::new()).collect();
        for event in &plan.faults.events {
            if let (Some(number), What::Disk { .. }) = (event.robot, event.what) {
                let robot = &mut robots[number as usize];
                if robot.disk.is_none() {
                    robot.disk = Some(SmallDisk::mount(&daemons.directory(number))?);
                }
            }
        }
        let end = LEAD_IN + u64::from(plan.seconds) * SECOND;
        let places = vec![[0.0; 2]; robots.len()];
        let mut conductor = Self {
            plan,
            world,
            operator,
            daemons,
            listener,
            socket,
            robots,
            now: 0,
            cycle: 0,
            event: 0,
            beacon: 0,
            end,
            is_over: false,
            silent: 0,
            counts: BTreeMap::new(),
            sequence: 0,
            reports: BTreeMap::new(),
            said: Vec::new(),
            stops: Vec::new(),
            places,
            record,
            outcome: Outcome::default(),
        };
        conductor.sense();
        Ok(conductor)
    }

    /// Lets the experiment pass, until its end or until `stop` is set; `advanced` gets each second that has passed.
    ///
    /// # Errors
    /// Daemons can't be started, or don't answer; the arena can't be computed; exit 6 when the record can't be written.
    pub fn run(mut self, stop: &AtomicBool, mut advanced: impl FnMut(u64)) -> Result<Outcome> {
        let lived = self.live(stop, &mut advanced);
        self.close();
        lived?;
        self.outcome.seconds = self.cycle / 10;
        self.outcome.brought = self.robots.iter().map(|robot| robot.brought).collect();
        let stops = std::mem::take(&mut self.stops);
        stops.iter().try_for_each(|stop| self.record.stop(stop))?;
        for robot in &mut self.robots {
            if let Some(disk) = robot.disk.take() {
                disk.keep()?;
            }
        }
        let tables = (0..self.plan.robots).map(|robot| self.daemons.directory(robot).join("intervals.csv"));
        let tables: Vec<Vec<u8>> = tables
            .filter_map(|path| plain::read(&path, plain::MAXIMUM).ok())
            .collect();
        self.outcome.hash = self.record.finish(&tables)?;
        Ok(std::mem::take(&mut self.outcome))
    }

    fn live(&mut self, stop: &AtomicBool, advanced: &mut dyn FnMut(u64)) -> Result {
        (0..self.plan.robots).try_for_each(|robot| self.launch(robot))?;
        let start = Instant::now();
        loop {
            if stop.load(Ordering::Relaxed) && !self.is_over {
                self.outcome.stopped = true;
                self.end = self.now;
            }
            let robots = self.robots.iter().filter_map(|robot| robot.next(self.now));
            let faults = self.plan.faults.events.get(self.event).map(|event| LEAD_IN + event.at);
            let cycle = (!self.is_over).then_some(LEAD_IN + self.cycle * CYCLE);
            let end = if self.is_over { self.end + FAREWELL } else { self.end };
            let next = robots
                .chain(faults.filter(|_| !self.is_over))
                .chain(cycle)
                .chain([self.beacon, end])
                .min();
            self.now = self.now.max(next.unwrap_or(end));
            if self.is_over && (self.now >= end || self.robots.iter().all(|robot| robot.daemon.is_none())) {
                return Ok(());
            }
            self.bodies();
            if self.now >= self.end {
                self.finish();
            } else {
                self.script()?;
            }
            self.timers()?;
            if !self.is_over && self.now >= LEAD_IN + self.cycle * CYCLE {
                self.pace(start);
                self.arena()?;
                if self.cycle.is_multiple_of(10) {
                    advanced(self.cycle / 10);
                }
            }
            if self.now >= self.beacon {
                self.beacon += CYCLE;
                self.operate();
            }
            self.serve()?;
        }
    }

    /// Time of the experiment, ns; none before it begins.
    fn time(&self) -> Option<u64> {
        self.now.checked_sub(LEAD_IN)
    }

    /// Lets the robots live that get bytes now.
    fn bodies(&mut self) {
        for robot in &mut self.robots {
            if robot.body.next().is_some_and(|at| at <= self.now) {
                robot.body.live(self.now);
            }
        }
    }

    /// Waits where time passes faster than it may.
    fn pace(&self, start: Instant) {
        if let Some(speed) = self.plan.speed {
            let due = Duration::from_secs_f64(self.now as f64 / SECOND as f64 / speed);
            thread::sleep(due.saturating_sub(start.elapsed()));
        }
    }

    /// Begins the faults of this moment.
    fn script(&mut self) -> Result {
        while let Some(event) = self.plan.faults.events.get(self.event).copied() {
            if LEAD_IN + event.at > self.now {
                return Ok(());
            }
            self.event += 1;
            let outcome = match event.robot {
                None => self.silence(event.what),
                Some(robot) => self.befall(robot, event.what),
            };
            self.record.event(&event, outcome)?;
            if outcome == DONE {
                self.watch(&event);
            }
        }
        Ok(())
    }

    /// Watches the wheels of those whom a fault befalls.
    fn watch(&mut self, event: &Event) {
        let time = match event.what {
            What::Kill { time } => time.unwrap_or(Stop::LONGEST),
            What::Clock { .. } => Stop::LONGEST,
            What::Pause { time } | What::Serial { time } | What::Disk { time } | What::Operator { time } => time,
        };
        for (robot, emulated) in self.robots.iter_mut().enumerate() {
            if event.robot.is_none_or(|befallen| befallen as usize == robot) {
                emulated.body.live(self.now);
                self.stops.push(Stop {
                    at: event.at,
                    began: self.now,
                    fault: event.what.name(),
                    robot,
                    turning: emulated.body.standing().is_none(),
                    stood: None,
                    until: self.now + time.saturating_add(SECOND / 2).min(Stop::LONGEST),
                    last: self.places[robot],
                    travel: 0.0,
                });
            }
        }
    }

    fn silence(&mut self, what: What) -> &'static str {
        if let What::Operator { time } = what {
            self.silent = self.silent.max(self.now + time);
        }
        DONE
    }

    /// Begins a fault of a robot. Returns what came of it.
    fn befall(&mut self, number: u32, what: What) -> &'static str {
        let now = self.now;
        let robot = &mut self.robots[number as usize];
        let is_down = robot.daemon.is_none();
        match what {
            What::Kill { .. } | What::Pause { .. } if is_down => return "the daemon was down",
            What::Kill { time } => {
                robot.starts = time.map(|time| now + time);
                robot.goes_on = None;
                if let Some(process) = &mut robot.process {
                    // It may already have ended.
                    let _ = process.kill();
                    let _ = process.wait();
                }
                robot.process = None;
                self.leave(number, Who::Daemon);
            }
            What::Pause { time } => {
                signal(robot.process.as_ref(), Signal::STOP);
                robot.goes_on = Some(robot.goes_on.unwrap_or(0).max(now + time));
            }
            What::Serial { time } => robot.body.hang(now + time),
            What::Disk { time } => {
                if let Some(disk) = &robot.disk {
                    disk.fill();
                    robot.has_room = Some(robot.has_room.unwrap_or(0).max(now + time));
                }
            }
            What::Clock { ppm, jump_ns } => robot.clock.change(now, ppm, jump_ns),
            What::Operator { .. } => {}
        }
        DONE
    }

    /// Ends the faults whose time is over.
    fn timers(&mut self) -> Result {
        let now = self.now;
        for number in 0..self.plan.robots {
            let robot = &mut self.robots[number as usize];
            let is_due = |timer: &mut Option<u64>| timer.take_if(|at| *at <= now).is_some();
            if is_due(&mut robot.goes_on) {
                signal(robot.process.as_ref(), Signal::CONT);
            }
            if is_due(&mut robot.has_room)
                && let Some(disk) = &robot.disk
            {
                disk.free();
            }
            if is_due(&mut robot.starts) && !self.is_over {
                self.launch(number)?;
            }
        }
        Ok(())
    }

    /// Starts a daemon, and waits for its first message.
    fn launch(&mut self, number: u32) -> Result {
        let mut process = self.daemons.start(number, &self.socket)?;
        let port = self.accept(number, process.as_mut())?;
        let robot = &mut self.robots[number as usize];
        robot.process = process;
        robot.coming.clear();
        robot.daemon = Some(Seat::new(Player::Daemon(port)));
        let guard = Player::Guard(Guard::new(number, &self.plan.guard));
        if let Some(old) = robot.guard.replace(Seat::new(guard)) {
            old.player.close();
        }
        Ok(())
    }

    /// The connection of a daemon that was started.
    fn accept(&self, number: u32, process: Option<&mut Child>) -> Result<Port> {
        let failed = |error: io::Error| Failure::storage(&self.socket, &error);
        let place = format!("robot {number}");
        self.listener.set_nonblocking(true).map_err(failed)?;
        let (start, mut process) = (Instant::now(), process);
        let stream = loop {
            match self.listener.accept() {
                Ok((stream, _)) => break stream,
                Err(error) if error.kind() == ErrorKind::WouldBlock => {}
                Err(error) => return Err(failed(error)),
            }
            if let Some(Ok(Some(status))) = process.as_mut().map(|process| process.try_wait()) {
                return Err(Failure::failed(format_args!("the daemon ended before it had begun: {status}")).at(&place));
            }
            if start.elapsed() > START {
                let limit = START.as_secs();
                return Err(Failure::failed(format_args!("the daemon has not begun within {limit} s")).at(&place));
            }
            thread::sleep(Duration::from_millis(1));
        };
        stream.set_nonblocking(false).map_err(failed)?;
        let mut port = Port::new(stream);
        port.limit(Some(COMPUTE)).map_err(failed)?;
        hello(&mut port, number).map_err(|failure| failure.at(&place))?;
        Ok(port)
    }

    /// Notes that a participant is gone.
    fn leave(&mut self, number: u32, who: Who) {
        let robot = &mut self.robots[number as usize];
        if let Some(seat) = robot.seat(who).take() {
            seat.player.close();
        }
        if let Some(other) = robot.seat(who.other()) {
            other.is_alone = true;
        }
    }

    /// Lets the arena run a cycle, and sends the tracker's sightings.
    fn arena(&mut self) -> Result {
        let now = self.now;
        let wheels: Vec<[f64; 2]> = self
            .robots
            .iter_mut()
            .map(|robot| {
                robot.body.live(now);
                robot.body.speeds_mm_s()
            })
            .collect();
        if self.cycle.is_multiple_of(10) {
            self.forge();
        }
        let line = self.world.cycle(&wheels)?;
        self.record.cycle(&line);
        self.sense();
        for (robot, seen) in self.robots.iter_mut().zip(&line.robots) {
            robot.brought += seen.brought;
        }
        self.cycle += 1;
        self.places = line.robots.iter().map(|seen| [seen.x, seen.y]).collect();
        for stop in std::mem::take(&mut self.stops) {
            self.look(stop)?;
        }
        for robot in 0..self.plan.robots {
            if !self.plan.faults.is_unseen(robot, self.cycle, self.plan.tracking_loss) {
                let sighting = self.sighting(robot, &line);
                self.deliver(TRACKER, robot, Carrier::Tracker, sighting.as_bytes());
            }
        }
        if self.cycle.is_multiple_of(10) {
            let brought: Vec<u32> = self.robots.iter().map(|robot| robot.brought).collect();
            self.record.second(self.cycle / 10 - 1, &line, &brought, &wheels)?;
        }
        Ok(())
    }

    /// Looks at a robot that is watched.
    fn look(&mut self, mut stop: Stop) -> Result {
        let stood = self.robots[stop.robot].body.stood();
        if stop.look(self.now, stood, self.places[stop.robot]) {
            return self.record.stop(&stop);
        }
        self.stops.push(stop);
        Ok(())
    }

    /// Gives robots the arena's readings.
    fn sense(&mut self) {
        for (robot, activations) in self.robots.iter_mut().zip(self.world.readings()) {
            robot.body.readings = readings(&activations);
        }
    }

    /// The tracker's report on a robot.
    fn sighting(&self, robot: u32, line: &Line) -> String {
        let seen = &line.robots[robot as usize];
        let heard: Vec<u32> = (0..self.plan.robots)
            .filter(|other| seen.heard >> other & 1 == 1)
            .collect();
        let sighting = serde_json::json!({
            "id": robot,
            "t": self.cycle as f64 / 10.0,
            "x": seen.x,
            "y": seen.y,
            "heading": seen.heading,
            "carries": seen.carries,
            "brought": self.robots[robot as usize].brought,
            "heard": heard,
        });
        sighting.to_string()
    }

    /// Sends the operator's beacon, and passes on what has arrived for the operator.
    fn operate(&mut self) {
        let now = self.now;
        while let Some(report) = self.reports.first_entry().filter(|report| report.key().0 <= now) {
            self.operator.hear(&report.remove(), Duration::from_nanos(now));
        }
        if now >= self.silent {
            let milliseconds = (now as i64 - LEAD_IN as i64) / 1_000_000;
            let go = milliseconds >= 0 && !self.is_over;
            let beacon = self.operator.beacon(milliseconds, go);
            self.broadcast(OPERATOR, &beacon);
        }
    }

    /// Sends a datagram to all others.
    fn broadcast(&mut self, sender: u32, datagram: &[u8]) {
        if self.said.len() == RECORDED {
            self.said.remove(0);
        }
        self.said.push(datagram.to_vec());
        for receiver in (0..self.plan.robots)
            .chain([OPERATOR])
            .filter(|receiver| *receiver != sender)
        {
            self.deliver(sender, receiver, Carrier::Radio, datagram);
        }
    }

    /// Sends a datagram to one, as its fate is.
    fn deliver(&mut self, sender: u32, receiver: u32, channel: Carrier, datagram: &[u8]) {
        let count = self.counts.entry((sender, receiver)).or_default();
        let at = self.now.saturating_sub(LEAD_IN);
        let fate = self.plan.faults.fate(sender, receiver, *count, channel, at);
        *count += 1;
        self.record.datagram(&fate);
        for copy in fate.copies.into_iter().flatten() {
            let bytes = match copy.damage {
                Some(damage) => faults::damaged(datagram, damage),
                None => datagram.to_vec(),
            };
            self.arrive(receiver, self.now + copy.time, channel, bytes);
        }
    }

    /// Lets a datagram arrive. Nobody keeps those for a daemon that is down.
    fn arrive(&mut self, receiver: u32, at: u64, channel: Carrier, datagram: Vec<u8>) {
        self.sequence += 1;
        let key = (at, self.sequence);
        if receiver == OPERATOR {
            self.reports.insert(key, datagram);
        } else {
            let robot = &mut self.robots[receiver as usize];
            if robot.daemon.is_some() {
                robot.coming.insert(key, (channel == Carrier::Tracker, datagram));
            }
        }
    }

    /// Lets the datagrams come that are forged in the second that begins.
    fn forge(&mut self) {
        let second = self.cycle / 10;
        for receiver in (0..self.plan.robots).chain([OPERATOR]) {
            for (at, word) in self.plan.faults.forged(receiver, second) {
                let bytes = faults::forgery(word, &self.said);
                self.record.forged();
                self.arrive(receiver, self.now + at, Carrier::Radio, bytes);
            }
        }
    }

    /// Gives time to the first participant for whom it is time.
    fn serve(&mut self) -> Result {
        for number in 0..self.plan.robots {
            for who in Who::ALL {
                let due = self.robots[number as usize].due(who, self.now);
                if due.is_some_and(|at| at <= self.now) {
                    return self.turn(number, who);
                }
            }
        }
        Ok(())
    }

    /// Gives time to a participant, and takes its messages until it waits again.
    fn turn(&mut self, number: u32, who: Who) -> Result {
        let (now, ended) = (self.now, self.is_over);
        let robot = &mut self.robots[number as usize];
        let line = if who == Who::Guard {
            robot.body.live(now);
            robot.body.take(now)
        } else {
            Vec::new()
        };
        let mut datagrams = Vec::new();
        while who == Who::Daemon
            && let Some(datagram) = robot.coming.first_entry().filter(|datagram| datagram.key().0 <= now)
        {
            datagrams.push(datagram.remove());
        }
        let shown = robot.clock.shows(now);
        let Some(mut seat) = robot.seat(who).take() else {
            return Ok(());
        };
        let time = Time {
            now: shown,
            ended,
            closed: std::mem::take(&mut seat.is_alone),
            line,
            told: std::mem::take(&mut seat.lines),
            datagrams,
        };
        seat.must_know = false;
        let (said, wait) = seat.player.turn(time);
        for message in said {
            self.take(number, who, message);
        }
        match wait {
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {
                let limit = COMPUTE.as_secs();
                let problem = format_args!("robot {number}: the daemon has not answered for {limit} s");
                return Err(Failure::failed(problem));
            }
            Err(_) => {
                *self.robots[number as usize].seat(who) = Some(seat);
                self.handle_end(number, who);
            }
            Ok(wait) => {
                seat.wait = wait;
                *self.robots[number as usize].seat(who) = Some(seat);
            }
        }
        Ok(())
    }

    /// Takes a participant's message.
    fn take(&mut self, number: u32, who: Who, message: Up) {
        let now = self.now;
        let robot = &mut self.robots[number as usize];
        match (message, who) {
            (Up::Line(bytes), Who::Guard) => robot.body.receive(&bytes, now),
            (Up::Reopen, Who::Guard) => robot.body.reopen(),
            (Up::Tell(line), who) => {
                if let Some(other) = robot.seat(who.other()) {
                    other.lines.push(line);
                }
            }
            (Up::Send(datagram), Who::Daemon) => self.broadcast(number, &datagram),
            // It makes no sense here.
            (Up::Line(_) | Up::Reopen | Up::Send(_) | Up::Hello { .. } | Up::Wait { .. }, _) => {}
        }
    }

    /// Handles a participant that has ended unasked.
    fn handle_end(&mut self, number: u32, who: Who) {
        self.leave(number, who);
        if who == Who::Guard {
            return;
        }
        let robot = &mut self.robots[number as usize];
        let status = robot.process.take().and_then(|mut process| process.wait().ok());
        let has_failed = status.is_some_and(|status| !status.success() && status.code() != Some(75));
        let is_early = !self.is_over && self.now + CLOCKS < self.end;
        if has_failed || is_early {
            let at = self.time().unwrap_or_default() as f64 / SECOND as f64;
            let how = status.map_or_else(String::new, |status| format!(": {status}"));
            let problem = format!("robot {number}: the daemon ended at {at} s{how}");
            self.outcome.problems.push(problem);
        }
    }

    /// Ends the experiment: stops all daemons.
    fn finish(&mut self) {
        if std::mem::replace(&mut self.is_over, true) {
            return;
        }
        for robot in &mut self.robots {
            (robot.starts, robot.has_room) = (None, None);
            if robot.goes_on.take().is_some() {
                signal(robot.process.as_ref(), Signal::CONT);
            }
            if let Some(disk) = &robot.disk {
                disk.free();
            }
            if let Some(seat) = &mut robot.daemon {
                seat.must_know = true;
            }
        }
    }

    /// Ends all that has not ended.
    fn close(&mut self) {
        for (number, robot) in self.robots.iter_mut().enumerate() {
            if let Some(mut process) = robot.process.take() {
                signal(Some(&process), Signal::CONT);
                // It may have ended.
                let _ = process.kill();
                let _ = process.wait();
                let problem = format!("robot {number}: the daemon did not end, and was killed");
                self.outcome.problems.push(problem);
            }
            for who in Who::ALL {
                if let Some(seat) = robot.seat(who).take() {
                    seat.player.close();
                }
            }
        }
    }
}

impl Drop for Conductor<'_> {
    fn drop(&mut self) {
        // Nobody connects to it any more.
        let _ = std::fs::remove_file(&self.socket);
    }
}

/// The log's word for a fault that has begun.
const DONE: &str = "done";

fn signal(process: Option<&Child>, signal: Signal) {
    if let Some(process) = process {
        // It may have ended.
        let _ = kill_process(Pid::from_child(process), signal);
    }
}

/// Waits for a daemon's first message.
fn hello(port: &mut Port, number: u32) -> Result {
    match port.receive() {
        Ok(Up::Hello { version, robot }) if (version, robot) == (VERSION, number) => Ok(()),
        Ok(said) => Err(Failure::failed(format_args!(
            "said {said:?}; allowed: version {VERSION}, robot {number}"
        ))),
        Err(error) => Err(Failure::failed(format_args!("said nothing: {error}"))),
    }
}
