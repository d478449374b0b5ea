//! A robot behind a guard: its process on the real clock, or one on a virtual clock.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use oneiro_base::console::Console;
use oneiro_base::exit::Failure;

use super::person::Person;
use super::trouble::Trouble;
use super::{Moment, Profile, Vehicle};
use crate::address::Wire;
use crate::guard::client::{Client, Lost, failure, is_realtime};
use crate::guard::message::{Report, Request, Status};
use crate::guard::values::Values;
use crate::guard::wheels::Wanted;
use crate::guard::{Condition, State};
use crate::link::wall;
use crate::realtime::RealTime;
use crate::tracker::{self, Tracker};

/// What to connect to, and how.
#[derive(Clone, Debug)]
pub struct Options {
    /// The robot.
    pub wire: Wire,
    /// What is read from it.
    pub wanted: Wanted,
    /// Settings of the guard, each written `KEY=VALUE`.
    pub settings: Vec<String>,
    /// Where the bytes of the link are recorded.
    pub record: Option<PathBuf>,
    /// The tracker that reports the pose, if any.
    pub tracker: Option<tracker::Values>,
    /// Its number where there are several robots, from 1.
    pub number: Option<usize>,
}

/// What connects a program with its guard.
pub trait Connection: Send {
    /// The time on the guard's clock, which never goes back.
    fn now(&self) -> Duration;

    /// Sends a request. A guard that does not take it is found out by its silence.
    fn send(&mut self, request: Request);

    /// Sends new speeds, mm/s. They count until they expire.
    fn drive(&mut self, speeds: [f64; 2]);

    /// The number of the last command.
    fn sequence(&self) -> u64;

    /// The next report and when it came, if one comes in time.
    ///
    /// # Errors
    /// The guard is gone, or has been silent for too long; until the robot is connected it may be silent.
    fn report_within(&mut self, limit: Duration) -> Result<Option<(Duration, Report)>, Lost>;

    /// Ends a lost guard, and stops the robot without it if possible. Returns the failure to report, with whether the
    /// robot has stopped.
    fn without(self: Box<Self>, lost: Lost, console: Console) -> Failure;

    /// Lets the guard stop the robot and end, and waits for that. Returns what there is to report, if anything.
    fn leave(self: Box<Self>, console: Console) -> Option<String>;
}

/// A connection with the guard's process.
struct Process {
    client: Client,
    wire: Wire,
}

impl Connection for Process {
    fn now(&self) -> Duration {
        wall()
    }

    fn send(&mut self, request: Request) {
        self.client.send(request);
    }

    fn drive(&mut self, speeds: [f64; 2]) {
        self.client.drive(speeds);
    }

    fn sequence(&self) -> u64 {
        self.client.sequence()
    }

    fn report_within(&mut self, limit: Duration) -> Result<Option<(Duration, Report)>, Lost> {
        self.client.report_within(limit)
    }

    fn without(mut self: Box<Self>, lost: Lost, console: Console) -> Failure {
        self.client.kill();
        lost.stopped(&self.wire, console)
    }

    fn leave(self: Box<Self>, console: Console) -> Option<String> {
        match self.client.finish(|_| ()) {
            Ok(None) => None,
            Ok(Some((_, message))) => Some(message),
            Err(lost) => Some(lost.stopped(&self.wire, console).to_string()),
        }
    }
}

/// The latest readings of the sensors of a kind, or of the odometers.
#[derive(Clone, Debug, Default)]
struct Latest {
    /// When it arrived, and its age then.
    at: Duration,
    age: Duration,
    values: Vec<f64>,
    /// Whether it has not been looked at yet.
    is_new: bool,
}

/// A robot behind a guard. When this is dropped, the guard stops the robot and ends.
pub struct Guarded {
    /// None once the guard has ended.
    guard: Option<Box<dyn Connection>>,
    profile: Profile,
    /// One for each kind of sensors.
    readings: Vec<Latest>,
    travel: Latest,
    volts: Option<f64>,
    status: Option<Status>,
    /// Speeds that were set last, mm/s.
    speeds: [f64; 2],
    /// When they were sent.
    sent: Duration,
    /// Whether the guard lets it move; then any stop that was not ordered is a trouble.
    is_ready: bool,
    /// Whether the thread that drives gets real-time priority while it may move, and that priority.
    is_realtime: bool,
    raised: Option<RealTime>,
    tracker: Option<Tracker>,
    /// Whether the tracker has lost the robot, by the guard.
    is_lost: bool,
    stop: Arc<AtomicBool>,
    person: Option<Person>,
    /// Its number where there are several robots, and what its messages begin with there: its address.
    number: Option<usize>,
    label: String,
    console: Console,
}

impl Guarded {
    /// Time after which speeds are sent again, so that they don't expire.
    const REPEAT: Duration = Duration::from_millis(50);
    /// How long new readings may take. The guard reads each kind every 50 ms if the link is fast enough.
    const READINGS: Duration = Duration::from_millis(500);
    /// How long a tracker may take to see the robot first.
    const SIGHT: Duration = Duration::from_secs(5);
    /// How long the guard may take to stop the robot, or to let it move.
    const ANSWER: Duration = Duration::from_secs(3);
    /// How long a robot may wait for somebody if there is no terminal.
    const PATIENCE: Duration = Duration::from_mins(10);
    /// Between two attempts to resume without a terminal.
    const PAUSE: Duration = Duration::from_secs(1);
    /// How long a robot that was put back stands still, for the hand to be taken away.
    const HANDS_OFF: Duration = Duration::from_secs(2);

    /// Connects to a robot. Everything that waits ends when `stop` is set.
    ///
    /// # Errors
    /// Those of the guard: exit 3 for kinds of sensors that the robot lacks and settings that are not allowed, exit 4 for a
    /// robot that does not answer; exit 75 if `stop` is set.
    pub fn open(options: &Options, stop: Arc<AtomicBool>, console: Console) -> Result<Self, Failure> {
        let Options {
            wire,
            wanted,
            settings,
            record,
            tracker,
            number,
        } = options;
        // An address where nobody can listen is refused before the robot is touched.
        let tracker = match tracker {
            Some(tracker) => {
                let speed = Values::of(settings).map_err(Failure::input)?.speed_mm_s;
                Some((tracker, Tracker::listen(tracker, speed)?))
            }
            None => None,
        };
        console.say(format!("connecting to {wire}"));
        let client = Client::start(&wire.to_string(), wanted, settings, record.as_deref())?;
        let label = number.map_or_else(String::new, |_| format!("{wire}: "));
        let wire = wire.clone();
        let mut vehicle = Self::behind(Box::new(Process { client, wire }), wanted.odometry, stop, console)?;
        (vehicle.number, vehicle.label) = (*number, label);
        vehicle.is_realtime = is_realtime(settings);
        if let Some((values, tracker)) = tracker {
            tracker.limit(vehicle.profile.greatest_mm_s);
            seeing(values, &tracker, &vehicle.stop)?;
            vehicle.tracker = Some(tracker);
        }
        Ok(vehicle)
    }

    /// Waits until a guard has connected to its robot. Everything that waits ends when `stop` is set.
    ///
    /// # Errors
    /// As [`Guarded::open`].
    pub fn behind(
        mut guard: Box<dyn Connection>,
        odometry: bool,
        stop: Arc<AtomicBool>,
        console: Console,
    ) -> Result<Self, Failure> {
        loop {
            if stop.load(Ordering::Relaxed) {
                return Err(Trouble::Stopped.into());
            }
            match guard.report_within(Client::CYCLE) {
                Ok(Some((_, Report::Failed { code, message }))) => return Err(failure(code, &message)),
                Ok(Some((
                    _,
                    Report::Connected {
                        robot,
                        firmware,
                        greatest_mm_s,
                        unit_mm_s,
                        base_mm,
                        has_odometers,
                        sensors,
                    },
                ))) => {
                    console.say(format!("connected: {robot}"));
                    return Ok(Self {
                        readings: vec![Latest::default(); sensors.len()],
                        travel: Latest::default(),
                        volts: None,
                        profile: Profile {
                            robot,
                            firmware,
                            sensors,
                            greatest_mm_s,
                            unit_mm_s,
                            base_mm,
                            has_odometers: has_odometers && odometry,
                        },
                        status: None,
                        speeds: [0.0; 2],
                        sent: guard.now(),
                        guard: Some(guard),
                        is_ready: false,
                        is_realtime: false,
                        raised: None,
                        tracker: None,
                        is_lost: false,
                        stop,
                        person: None,
                        number: None,
                        label: String::new(),
                        console,
                    });
                }
                Ok(_) => {}
                Err(lost) => return Err(guard.without(lost, console)),
            }
        }
    }

    /// The time on the guard's clock.
    fn time(&self) -> Duration {
        self.guard.as_ref().map_or_else(wall, |guard| guard.now())
    }

    /// The guard has ended or hangs: stops the robot without it.
    fn lost(&mut self, lost: Lost) -> Trouble {
        let failure = self.guard.take().map(|guard| guard.without(lost, self.console));
        Trouble::Broken(failure.map_or_else(|| lost.to_string(), |failure| failure.to_string()))
    }

    fn send(&mut self, request: Request) {
        if let Some(guard) = &mut self.guard {
            guard.send(request);
        }
    }

    /// Sends the speeds.
    fn send_speeds(&mut self) {
        self.sent = self.time();
        if let Some(guard) = &mut self.guard {
            guard.drive(self.speeds);
        }
    }

    /// Stops the wheels, by the guard.
    fn rest(&mut self) {
        (self.speeds, self.is_ready) = ([0.0; 2], false);
        self.send_speeds();
        self.raised = None;
    }

    /// Waits for one report of the guard, until a moment at most, and keeps the speeds from expiring.
    fn hear(&mut self, until: Duration) -> Result<(), Trouble> {
        let limit = until.saturating_sub(self.time()).min(Client::CYCLE);
        let Some(guard) = &mut self.guard else {
            return Err(Trouble::Broken(Lost::Ended.to_string()));
        };
        let report = guard.report_within(limit).map_err(|lost| self.lost(lost))?;
        let is_lost = self.tracker.as_ref().is_some_and(|tracker| tracker.pose().is_none());
        if is_lost != self.is_lost {
            self.is_lost = is_lost;
            self.send(Request::Tracker { lost: is_lost });
        }
        if let Some((at, report)) = report {
            self.take(at, report)?;
        }
        if self.time() >= self.sent + Self::REPEAT {
            self.send_speeds();
        }
        Ok(())
    }

    /// The same, unless the user has stopped the program.
    fn attend(&mut self, until: Duration) -> Result<(), Trouble> {
        if self.stop.load(Ordering::Relaxed) {
            self.settle()?;
            return Err(Trouble::Stopped);
        }
        self.hear(until)
    }

    /// Takes a report that came at this time.
    fn take(&mut self, at: Duration, report: Report) -> Result<(), Trouble> {
        let latest = |age_ms: f64, values| Latest {
            at,
            age: Duration::try_from_secs_f64(age_ms / 1000.0).unwrap_or_default(),
            values,
            is_new: true,
        };
        match report {
            Report::Hello { .. } | Report::Connected { .. } => {}
            Report::Reading {
                kind, age_ms, values, ..
            } => {
                let kinds = self.profile.sensors.iter().zip(&mut self.readings);
                for (_, newest) in kinds.filter(|(sensors, _)| sensors.kind == kind) {
                    *newest = latest(age_ms, values.clone());
                }
            }
            Report::Travel {
                left_mm,
                right_mm,
                age_ms,
                ..
            } => self.travel = latest(age_ms, vec![left_mm, right_mm]),
            Report::Battery { volts, .. } => self.volts = volts,
            Report::State(status) => {
                let trouble = trouble_of(&status);
                self.status = Some(status);
                if self.is_ready
                    && let Some(trouble) = trouble
                {
                    self.rest();
                    return Err(trouble);
                }
            }
            Report::Failed { message, .. } => return Err(Trouble::Broken(message)),
        }
        Ok(())
    }

    /// Waits until the guard lets the robot move. That needs no person where only this program or the link was late.
    fn get_ready(&mut self) -> Result<(), Trouble> {
        self.rest();
        let until = self.time() + Self::ANSWER;
        // Reports that the guard sent before it got this are out of date.
        let rest = self.guard.as_ref().map_or(0, |guard| guard.sequence());
        let is_new = |status: &Status| status.sequence >= rest;
        while !self
            .status
            .as_ref()
            .is_some_and(|status| is_new(status) && may_move(status))
        {
            if let Some(status) = self.status.as_ref().filter(|status| is_new(status)) {
                if !passes(status)
                    && let Some(trouble) = trouble_of(status)
                {
                    return Err(trouble);
                }
                self.send(Request::Resume);
            }
            if self.time() >= until {
                return Err(self.unready());
            }
            self.pause(Client::CYCLE)?;
        }
        self.is_ready = true;
        self.raised = self.is_realtime.then(RealTime::of_this_thread).flatten();
        Ok(())
    }

    /// Why it can't be driven, or does not stop.
    fn unready(&self) -> Trouble {
        let trouble = self.status.as_ref().and_then(trouble_of);
        trouble.unwrap_or_else(|| Trouble::Unreadable("the robot does not confirm that its wheels stand".into()))
    }

    /// Stops the wheels, and waits until the robot has confirmed it.
    fn settle(&mut self) -> Result<(), Trouble> {
        self.rest();
        let stop = self.guard.as_ref().map_or(0, |guard| guard.sequence());
        let until = self.time() + Self::ANSWER;
        let stands = |status: &Status| status.sequence >= stop && status.state == State::Standing;
        while !self.status.as_ref().is_some_and(stands) {
            if self.time() >= until {
                return Err(self.unready());
            }
            self.hear(until)?;
        }
        Ok(())
    }

    /// Attends to the guard for a while.
    fn pause(&mut self, time: Duration) -> Result<(), Trouble> {
        let until = self.time() + time;
        while self.time() < until {
            self.attend(until)?;
        }
        Ok(())
    }

    /// The person next to the robot.
    fn person(&mut self) -> &mut Person {
        self.person.get_or_insert_with(|| Person::at_terminal(self.number))
    }

    /// Asks for something that a person is to do.
    fn request(&self, words: &str) {
        self.console.ask(format!("{}{words}", self.label));
    }

    /// The latest readings of all sensors, if all of them are new.
    fn newest(&mut self) -> Option<Moment> {
        let travel = self.profile.has_odometers.then_some(&self.travel);
        if !self.readings.iter().chain(travel).all(|latest| latest.is_new) {
            return None;
        }
        let all = || self.readings.iter().chain(travel);
        let at = all().map(|latest| latest.at).max().unwrap_or_else(|| self.time());
        let age = all()
            .map(|latest| at.saturating_sub(latest.at) + latest.age)
            .max()
            .unwrap_or_default();
        let moment = Moment {
            at,
            age,
            readings: self.readings.iter().flat_map(|latest| latest.values.clone()).collect(),
            travel: travel.map(|latest| [latest.values[0], latest.values[1]]),
        };
        for latest in self.readings.iter_mut().chain([&mut self.travel]) {
            latest.is_new = false;
        }
        Some(moment)
    }
}

impl Vehicle for Guarded {
    fn profile(&self) -> &Profile {
        &self.profile
    }

    fn now(&self) -> Duration {
        self.time()
    }

    fn look(&mut self) -> Result<Moment, Trouble> {
        let until = self.time() + Self::READINGS;
        loop {
            if let Some(moment) = self.newest() {
                return Ok(moment);
            }
            if self.time() >= until {
                self.rest();
                let limit = Self::READINGS.as_millis();
                return Err(Trouble::Unreadable(format!("no new readings within {limit} ms")));
            }
            self.attend(until)?;
        }
    }

    fn drive(&mut self, speeds: [f64; 2]) -> Result<(), Trouble> {
        if !self.is_ready {
            self.get_ready()?;
        }
        self.speeds = speeds;
        self.send_speeds();
        Ok(())
    }

    fn keep_until(&mut self, until: Duration) -> Result<(), Trouble> {
        // Reports that have already arrived are also read.
        loop {
            self.attend(until)?;
            if self.time() >= until {
                return Ok(());
            }
        }
    }

    fn stop(&mut self) -> Result<(), Trouble> {
        self.settle()
    }

    fn volts(&self) -> Option<f64> {
        self.volts
    }

    fn seen(&self) -> Option<[f64; 3]> {
        self.tracker.as_ref()?.pose()
    }

    fn ask(&mut self, what: &str) -> Result<(), Trouble> {
        self.settle()?;
        let person = self.person();
        if !person.is_there() {
            return Err(Trouble::Broken(format!(
                "standard input is no terminal, so nobody can confirm this: {what}"
            )));
        }
        person.has_answered();
        let confirms = person.confirms();
        self.request(&format!("{what}; then {confirms}"));
        while !self.person().has_answered() {
            self.pause(Client::CYCLE)?;
        }
        Ok(())
    }

    fn recover(&mut self) -> Result<(), Trouble> {
        self.recover_until(&|| false)
    }

    fn recover_until(&mut self, is_over: &dyn Fn() -> bool) -> Result<(), Trouble> {
        self.rest();
        let until = self.time() + Self::PATIENCE;
        let mut asked = None;
        while !is_over() {
            self.pause(2 * Self::REPEAT)?;
            let Some(status) = self.status.clone() else { continue };
            let Some(trouble) = trouble_of(&status).filter(|_| !may_move(&status)) else {
                if asked.is_some() {
                    self.pause(Self::HANDS_OFF)?;
                    if !self.status.as_ref().is_some_and(may_move) {
                        continue;
                    }
                }
                return Ok(());
            };
            if passes(&status) {
                self.send(Request::Resume);
                continue;
            }
            let is_there = self.person().is_there();
            if asked.replace(trouble.to_string()) != asked {
                self.person().has_answered();
                let when = if is_there {
                    format!("; then {}", self.person().confirms())
                } else {
                    String::new()
                };
                self.request(&format!("{trouble}{when}"));
            }
            if is_there {
                if self.person().has_answered() {
                    self.send(Request::Resume);
                    // If it is not over, it is printed again.
                    asked = None;
                }
            } else if self.time() >= until {
                return Err(trouble);
            } else {
                self.send(Request::Resume);
                self.pause(Self::PAUSE)?;
            }
        }
        Ok(())
    }

    fn resume(&mut self) {
        self.rest();
        self.send(Request::Resume);
    }
}

impl Drop for Guarded {
    /// Waits until the guard has stopped the robot.
    fn drop(&mut self) {
        let ignored = self.tracker.as_ref().map(|tracker| tracker.ignored().counts());
        let ignored = ignored.into_iter().flatten().filter(|(_, count)| *count > 0);
        let ignored: Vec<String> = ignored.map(|(reason, count)| format!("{count} x {reason}")).collect();
        if !ignored.is_empty() {
            self.console.say(format!(
                "{}lines of the tracker that were ignored: {}",
                self.label,
                ignored.join(", ")
            ));
        }
        if let Some(message) = self.guard.take().and_then(|guard| guard.leave(self.console)) {
            self.request(&message);
        }
    }
}

/// Waits until a tracker sees its robot.
///
/// # Errors
/// Exit 4: it does not; exit 75 if `stop` is set.
fn seeing(values: &tracker::Values, tracker: &Tracker, stop: &AtomicBool) -> Result<(), Failure> {
    let until = wall() + Guarded::SIGHT;
    while tracker.pose().is_none() {
        if stop.load(Ordering::Relaxed) {
            return Err(Trouble::Stopped.into());
        }
        if wall() >= until {
            return Err(Failure::device(format_args!(
                "--tracker udp:{}: no sighting of robot {} within {} s; check that the tracker sees it and sends here",
                values.listen,
                values.id,
                Guarded::SIGHT.as_secs()
            )));
        }
        thread::sleep(Client::CYCLE);
    }
    Ok(())
}

/// Whether the guard lets a stopped robot move.
fn may_move(status: &Status) -> bool {
    status.state == State::Standing && status.reasons.is_empty() && !status.needs_resume
}

/// Whether only this program or the link was late or garbled, which needs no person.
fn passes(status: &Status) -> bool {
    let may_pass = |reason: &Condition| {
        matches!(
            reason,
            Condition::Silent | Condition::Expired | Condition::Late | Condition::Answers | Condition::Messages
        )
    };
    !status.cannot_stop && status.reasons.iter().all(may_pass)
}

/// The trouble that a stop is; none if the stop was commanded.
fn trouble_of(status: &Status) -> Option<Trouble> {
    let words: Vec<&str> = status.reasons.iter().copied().map(Condition::words).collect();
    let words = words.join("; ");
    if status.cannot_stop {
        let problem = status.problem.as_deref();
        let problem = problem.unwrap_or("it does not confirm that its wheels stand");
        return Some(Trouble::Runaway(problem.into()));
    }
    let kind = |reason: &Condition| match reason {
        Condition::Battery => 0,
        Condition::Lifted | Condition::Tracker => 1,
        Condition::Restarted | Condition::Operator => 2,
        Condition::Closed | Condition::Terminated => 3,
        _ => 4,
    };
    Some(match status.reasons.iter().map(kind).min()? {
        0 => Trouble::Discharged(words),
        1 => Trouble::Displaced(words),
        2 => Trouble::Halted(words),
        3 => Trouble::Broken(words),
        _ => Trouble::Unreadable(words),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn status(reasons: &[Condition]) -> Status {
        Status {
            state: State::Standing,
            left_mm_s: 0.0,
            right_mm_s: 0.0,
            sequence: 1,
            reasons: reasons.to_vec(),
            needs_resume: !reasons.is_empty(),
            cannot_stop: false,
            problem: None,
        }
    }

    /// Each reason for a stop, and all of them together, become the trouble with the remedy; only lateness of this
    /// program and of the link passes by itself.
    #[test]
    fn every_stop_of_the_guard_is_a_trouble() {
        for reason in Condition::ALL {
            let status = status(&[reason, Condition::Late]);
            let (expected, by_itself) = match reason {
                Condition::Battery => ("the robot has to be charged: the battery is low", false),
                Condition::Lifted => ("the robot has to be put back: the robot was lifted", false),
                Condition::Tracker => ("the robot has to be put back: the tracker", false),
                Condition::Operator => ("the robot was stopped: the operator stopped it", false),
                Condition::Restarted => ("the robot was stopped: the robot has restarted", false),
                Condition::Closed => ("the program that drives has ended", false),
                Condition::Terminated => ("the guard was ended by a signal", false),
                _ => ("the sensors can't be read: ", true),
            };
            let trouble = trouble_of(&status).unwrap().to_string();
            assert!(trouble.starts_with(expected), "{reason:?}: {trouble}");
            assert!(trouble.contains(reason.words()), "{reason:?}: {trouble}");
            assert_eq!((passes(&status), may_move(&status)), (by_itself, false), "{reason:?}");
        }
        let all = trouble_of(&status(&Condition::ALL)).unwrap();
        assert!(matches!(all, Trouble::Discharged(_)));
        let unstopped = Status {
            cannot_stop: true,
            problem: Some("no answer to D".into()),
            ..status(&[Condition::Late])
        };
        assert!(!passes(&unstopped));
        let trouble = trouble_of(&unstopped).unwrap().to_string();
        assert!(trouble.starts_with("cannot stop: no answer to D. The wheels may be turning"));
        assert!(trouble_of(&status(&[])).is_none() && may_move(&status(&[])));
    }
}
