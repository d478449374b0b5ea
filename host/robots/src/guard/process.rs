//! The guard's process: owns the link, measures time, and keeps the wheels at what the state machine decides.
//!
//! Nothing here waits for the robot or for the program: a thread has the robot, one reads messages, one writes them, and
//! this looks at all of it every 10 ms.

use std::io::{self, BufRead, BufReader, Read, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender, SyncSender};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use oneiro_base::exit::Failure;

use super::message::{LONGEST, Report, Request, Status, VERSION, sensors};
use super::values::Values;
use super::wheels::{Event, News, Travel, Wanted, Wheels};
use super::{Condition, Conditions, Guard, Inputs, Order, State};
use crate::address::Wire;
use crate::error::Error;
use crate::link::wall;
use crate::realtime::RealTime;
use crate::recording::Recording;

/// Between two looks.
pub(super) const TICK: Duration = Duration::from_millis(10);
/// Between two reports of the state, if it does not change.
pub(super) const PULSE: Duration = Duration::from_millis(100);
/// How long to wait for other threads at the end.
const FAREWELL: Duration = Duration::from_secs(1);

/// A guard's task.
pub struct Options {
    /// The robot.
    pub wire: Wire,
    /// What is read.
    pub wanted: Wanted,
    /// Where the link is recorded.
    pub recording: Option<Recording>,
    /// The guard's values.
    pub values: Values,
}

/// What comes from other threads.
enum Input {
    /// A line of the program; none if it was too long or no text.
    Line(Option<String>),
    /// The program has closed its end.
    Closed,
    /// News of the robot.
    Robot(Event),
}

/// Guards a robot until the program is gone or a signal comes, and the wheels stand still. Returns the exit code; its
/// reason has been reported.
///
/// # Errors
/// Signals can't be received.
pub fn run(options: Options) -> io::Result<u8> {
    leave_session();
    if options.values.realtime() {
        RealTime::from_here_on();
    }
    let ended = Arc::new(AtomicBool::new(false));
    end_at_signals(&ended)?;
    let (inbox, inputs) = mpsc::channel();
    let reports = Reports::start();
    reports.send(Report::Hello { version: VERSION });
    listen(inbox.clone());
    let tell = move |event| drop(inbox.send(Input::Robot(event)));
    let (wheels, thread) = Wheels::start(
        options.wire,
        options.recording,
        options.wanted,
        options.values.fuse(),
        tell,
    );
    let process = Process {
        keeper: Keeper::new(options.values, wall()),
        inputs,
        ended,
        reports,
        wheels,
    };
    Ok(process.work(thread))
}

/// Reports why there is nothing to guard. Returns the exit code.
pub fn refuse(refusal: &Failure) -> u8 {
    let reports = Reports::start();
    reports.send(Report::Hello { version: VERSION });
    reports.fail(refusal);
    reports.finish();
    refusal.code()
}

/// Leaves the terminal's session: what it sends to the program's group, a Ctrl-C among it, must not reach the guard.
fn leave_session() {
    // Fails for the leader of a group, such as one that a shell has started itself.
    #[cfg(unix)]
    let _ = rustix::process::setsid();
}

/// Sets a flag at the signals that ask for the end.
#[cfg(unix)]
fn end_at_signals(ended: &Arc<AtomicBool>) -> io::Result<()> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGQUIT, SIGTERM};
    for signal in [SIGTERM, SIGINT, SIGHUP, SIGQUIT] {
        signal_hook::flag::register(signal, Arc::clone(ended))?;
    }
    Ok(())
}

#[cfg(not(unix))]
fn end_at_signals(_: &Arc<AtomicBool>) -> io::Result<()> {
    Ok(())
}

/// Reads lines of standard input, in a thread.
fn listen(inbox: Sender<Input>) {
    thread::spawn(move || {
        let mut input = BufReader::new(io::stdin());
        loop {
            let mut line = Vec::new();
            let came = input.by_ref().take(LONGEST).read_until(b'\n', &mut line);
            let input = match came {
                Ok(0) | Err(_) => Input::Closed,
                // The rest of a line that is too long is taken for other lines, which make no sense.
                Ok(_) => Input::Line(String::from_utf8(line).ok().filter(|line| line.ends_with('\n'))),
            };
            let is_over = matches!(input, Input::Closed);
            if inbox.send(input).is_err() || is_over {
                return;
            }
        }
    });
}

/// Writes reports to standard output, in a thread: a program that does not read must not hold the guard.
struct Reports {
    queue: Option<SyncSender<Report>>,
    thread: JoinHandle<()>,
}

impl Reports {
    /// Reports that wait for the program; more are lost.
    const MOST: usize = 1000;

    #[expect(clippy::disallowed_methods, reason = "it is a pipe to the program that drives")]
    fn start() -> Self {
        let (queue, reports) = mpsc::sync_channel::<Report>(Self::MOST);
        let thread = thread::spawn(move || {
            for report in reports {
                let line = serde_json::to_string(&report).unwrap_or_default() + "\n";
                let mut stdout = io::stdout().lock();
                if stdout.write_all(line.as_bytes()).and_then(|()| stdout.flush()).is_err() {
                    return;
                }
            }
        });
        Self {
            queue: Some(queue),
            thread,
        }
    }

    /// Sends a report, if anybody may read it.
    fn send(&self, report: Report) {
        if let Some(queue) = &self.queue {
            let _ = queue.try_send(report);
        }
    }

    /// Reports a failure.
    fn fail(&self, failure: &Failure) {
        let (code, message) = (failure.code(), failure.to_string());
        self.send(Report::Failed { code, message });
    }

    /// Waits until all is written, if the program reads.
    fn finish(mut self) {
        self.queue = None;
        finished(self.thread);
    }
}

/// What a thread returns, if it ends soon.
fn finished<T>(thread: JoinHandle<T>) -> Option<T> {
    let until = wall() + FAREWELL;
    while !thread.is_finished() && wall() < until {
        thread::sleep(TICK);
    }
    if thread.is_finished() { thread.join().ok() } else { None }
}

/// Something that is sensed: it counts once it has been seen twice in a row.
#[derive(Default)]
struct Twice(bool);

impl Twice {
    fn push(&mut self, seen: bool) -> bool {
        std::mem::replace(&mut self.0, seen) && seen
    }
}

/// What has come, and what follows from it.
struct Heard {
    values: Values,
    /// Only for the next step.
    next: Inputs,
    has_greeted: bool,
    /// Sequence number of the newest command.
    sequence: Option<u64>,
    /// Messages in a row that make no sense.
    errors: u32,
    /// Conditions that hold until a message or a reading ends them.
    lasting: Conditions,
    battery: Twice,
    lifted: Twice,
    /// The stop that was confirmed last.
    confirmed: u64,
    /// When the robot has answered last.
    answered: Duration,
    /// The link's last problem since then.
    problem: Option<String>,
}

impl Heard {
    fn new(values: Values, now: Duration) -> Self {
        Self {
            values,
            next: Inputs::default(),
            has_greeted: false,
            sequence: None,
            errors: 0,
            lasting: Conditions::default(),
            battery: Twice::default(),
            lifted: Twice::default(),
            confirmed: 0,
            answered: now,
            problem: None,
        }
    }

    /// Takes a message of the program.
    fn line(&mut self, line: Option<&str>) {
        let request = line.and_then(|line| serde_json::from_str(line).ok());
        if request.is_some_and(|request| self.request(request)) {
            self.errors = 0;
            return;
        }
        self.errors += 1;
        if self.errors >= self.values.errors() {
            self.next.conditions.add(Condition::Messages, true);
        }
    }

    /// Takes a request. Returns whether it makes sense here.
    fn request(&mut self, request: Request) -> bool {
        match request {
            Request::Hello { version } => self.has_greeted = version == VERSION,
            // Not even a stop is missing from a program of another version: its commands are not obeyed.
            _ if !self.has_greeted => return false,
            Request::Command {
                sequence,
                left_mm_s,
                right_mm_s,
            } => {
                if self.sequence.is_some_and(|last| sequence <= last) {
                    return false;
                }
                self.sequence = Some(sequence);
                self.next.command = Some([left_mm_s, right_mm_s]);
            }
            Request::Tracker { lost } => self.lasting.set(Condition::Tracker, lost),
            Request::Stop => self.next.conditions.add(Condition::Operator, true),
            Request::Resume => self.next.resume = true,
            Request::End => self.lasting.add(Condition::Terminated, true),
        }
        self.has_greeted
    }

    /// Takes news of the robot.
    fn event(&mut self, Event { at, news }: Event) {
        let conditions = &mut self.next.conditions;
        match news {
            News::Connected(..) | News::Refused(_) | News::Read(..) | News::Travelled(_) => {}
            News::Answered => {
                self.answered = self.answered.max(at);
                self.problem = None;
            }
            News::Stopped(number) => self.confirmed = number,
            News::Battery(battery) => self.lasting.set(Condition::Battery, self.battery.push(battery.low)),
            News::Lifted(lifted) => {
                let lifted = self.lifted.push(lifted && self.values.lifted());
                self.lasting.set(Condition::Lifted, lifted);
            }
            News::NotStopped(error) => self.problem = Some(error.to_string()),
            News::Failed(error) => {
                match error {
                    Error::Restarted => conditions.add(Condition::Restarted, true),
                    Error::Garbage { .. } | Error::Refused { .. } => conditions.add(Condition::Answers, true),
                    Error::Disconnected { .. } => conditions.add(Condition::Late, true),
                    _ => {}
                }
                self.problem = Some(error.to_string());
            }
        }
    }

    /// The inputs of the next step.
    fn take(&mut self, passed: Duration, now: Duration) -> Inputs {
        let mut inputs = std::mem::take(&mut self.next);
        inputs.passed = passed;
        inputs.confirmed = self.confirmed;
        inputs.quiet = now.saturating_sub(self.answered);
        inputs.conditions = inputs.conditions.or(self.lasting);
        inputs
    }
}

/// The guard's messages, decisions and reports, independent of its clock and of how it reads and writes.
pub(super) struct Keeper {
    heard: Heard,
    values: Values,
    /// None until the robot is connected.
    pub(super) guard: Option<Guard>,
    /// When it began, and when it decided last.
    start: Duration,
    last: Duration,
    /// What it reported last of its state, and when.
    said: Option<(Status, Duration)>,
}

impl Keeper {
    /// A guard that begins now.
    pub(super) fn new(values: Values, now: Duration) -> Self {
        Self {
            heard: Heard::new(values.clone(), now),
            values,
            guard: None,
            start: now,
            last: now,
            said: None,
        }
    }

    /// Takes a message of the program; none if it was too long or no text.
    pub(super) fn line(&mut self, line: Option<&str>) {
        self.heard.line(line);
    }

    /// Notes that the program is gone.
    pub(super) fn closed(&mut self) {
        self.heard.lasting.add(Condition::Closed, true);
    }

    /// Takes news of the robot. Returns what to pass on.
    pub(super) fn news(&mut self, event: Event) -> Option<Report> {
        let report = self.robot(&event);
        self.heard.event(event);
        report
    }

    /// Decides what the robot is to do, once it is connected.
    pub(super) fn step(&mut self, now: Duration) -> Option<Order> {
        let passed = now.saturating_sub(std::mem::replace(&mut self.last, now));
        let guard = self.guard.as_mut()?;
        Some(guard.step(&self.heard.take(passed, now)))
    }

    /// Whether the guard may end: the wheels stand still and nobody can drive them any more, or it has tried for long
    /// enough.
    pub(super) fn is_over(&self) -> bool {
        self.guard.as_ref().is_some_and(Guard::is_over)
    }

    /// Its state, if it has changed, and from time to time.
    pub(super) fn state(&mut self, now: Duration) -> Option<Status> {
        let guard = self.guard.as_ref()?;
        let [left_mm_s, right_mm_s] = guard.speeds();
        let status = Status {
            state: guard.state(),
            left_mm_s,
            right_mm_s,
            sequence: self.heard.sequence.unwrap_or_default(),
            reasons: guard.reasons().iter().collect(),
            needs_resume: guard.needs_resume(),
            cannot_stop: guard.cannot_stop(),
            problem: self.heard.problem.clone(),
        };
        // Values that change all the time are reported with the rest.
        let same = |last: &Status| {
            (last.state, &last.reasons, last.needs_resume, last.cannot_stop)
                == (status.state, &status.reasons, status.needs_resume, status.cannot_stop)
        };
        if self
            .said
            .as_ref()
            .is_some_and(|(last, at)| same(last) && now < *at + PULSE)
        {
            return None;
        }
        self.said = Some((status.clone(), now));
        Some(status)
    }

    /// A robot's event as a report, if it is passed on.
    fn robot(&mut self, event: &Event) -> Option<Report> {
        let start = self.start;
        let seconds = |at: Duration| at.saturating_sub(start).as_secs_f64();
        let milliseconds = |age: Duration| 1000.0 * age.as_secs_f64();
        Some(match &event.news {
            News::Connected(description, kinds) => {
                let wheels = description.wheels;
                let greatest = f64::from(wheels.greatest) * wheels.mm_s;
                self.guard = Some(Guard::new(self.values.clone(), greatest));
                self.heard.answered = event.at;
                Report::Connected {
                    robot: description.robot.clone(),
                    firmware: description.firmware.clone(),
                    greatest_mm_s: greatest.min(self.values.speed_mm_s),
                    unit_mm_s: wheels.mm_s,
                    base_mm: wheels.base_mm,
                    has_odometers: wheels.mm_per_count.is_some(),
                    sensors: sensors(description, kinds),
                }
            }
            News::Read(kind, reading) => Report::Reading {
                kind: kind.to_string(),
                time_s: seconds(reading.at),
                age_ms: milliseconds(reading.age),
                values: reading.values.clone(),
            },
            News::Travelled(Travel { at, age, mm }) => Report::Travel {
                left_mm: mm[0],
                right_mm: mm[1],
                time_s: seconds(*at),
                age_ms: milliseconds(*age),
            },
            News::Battery(battery) => Report::Battery {
                volts: battery.volts,
                low: battery.low,
            },
            _ => return None,
        })
    }

    /// Why a stop is not confirmed.
    fn unconfirmed(&self) -> &str {
        self.heard
            .problem
            .as_deref()
            .unwrap_or("it does not confirm that its wheels stand")
    }

    /// The failure of a guard that has not stopped the robot; none if it has.
    fn unstopped(&self) -> Option<Failure> {
        let stands = self.guard.as_ref().is_none_or(|guard| guard.state() == State::Standing);
        (!stands).then(|| {
            Failure::device(format_args!(
                "cannot stop: {}. The wheels may be turning: lift the robot, then switch it off or reset it",
                self.unconfirmed()
            ))
        })
    }
}

struct Process {
    keeper: Keeper,
    inputs: Receiver<Input>,
    /// Set by a signal.
    ended: Arc<AtomicBool>,
    reports: Reports,
    wheels: Wheels,
}

impl Process {
    /// Maximum number taken between two steps.
    const MOST: usize = 1000;

    /// Works until the end. Returns the exit code.
    fn work(mut self, thread: JoinHandle<Option<String>>) -> u8 {
        let failure = loop {
            if let Some(refusal) = self.hear() {
                break Some(refusal);
            }
            let now = wall();
            let is_ended = self.ended.load(Ordering::Relaxed);
            self.keeper.heard.lasting.add(Condition::Terminated, is_ended);
            let Some(order) = self.keeper.step(now) else { continue };
            self.wheels.order(order);
            self.tell(now);
            if self.keeper.is_over() {
                break self.keeper.unstopped();
            }
        };
        self.wheels.end();
        let unwritten = finished(thread).flatten().map(Failure::unwritten);
        let failure = match (failure, unwritten) {
            (Some(failure), Some(problem)) => Some(failure.and(problem)),
            (failure, problem) => failure.or(problem),
        };
        let code = failure.as_ref().map_or(0, Failure::code);
        if let Some(failure) = failure {
            self.warn(&failure.to_string());
            self.reports.fail(&failure);
        }
        self.reports.finish();
        code
    }

    /// Takes all that has come, after a tick at most. Returns why there is no robot, if there is none.
    fn hear(&mut self) -> Option<Failure> {
        let mut input = match self.inputs.recv_timeout(TICK) {
            Ok(input) => Some(input),
            Err(RecvTimeoutError::Timeout) => None,
            // The robot's thread has ended without a word, which it does not do.
            Err(RecvTimeoutError::Disconnected) => return Some(Failure::device("the robot's thread has ended")),
        };
        // No more than a thread can send in a tick if something is wrong with it: a step must come.
        for _ in 0..Self::MOST {
            let Some(next) = input else { break };
            match next {
                Input::Line(line) => self.keeper.line(line.as_deref()),
                Input::Closed => self.keeper.closed(),
                Input::Robot(Event {
                    news: News::Refused(error),
                    ..
                }) => return Some(error.into()),
                Input::Robot(event) => {
                    if let Some(report) = self.keeper.news(event) {
                        self.reports.send(report);
                    }
                }
            }
            input = self.inputs.try_recv().ok();
        }
        None
    }

    /// Tells the state if it has changed, or from time to time.
    fn tell(&mut self, now: Duration) {
        let could_stop = self.keeper.said.as_ref().is_none_or(|(last, _)| !last.cannot_stop);
        let Some(status) = self.keeper.state(now) else { return };
        if status.cannot_stop && could_stop {
            self.warn(&format!("cannot stop the robot yet: {}", self.keeper.unconfirmed()));
        }
        self.reports.send(Report::State(status));
    }

    /// Says something on standard error, once there is no program that would say it.
    fn warn(&self, message: &str) {
        if self.keeper.heard.lasting.has(Condition::Closed) {
            oneiro_base::console::Console::default().ask(format!("oneiro guard: {message}"));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Battery;

    const HELLO: &str = r#"{"hello":{"version":1}}"#;

    fn command(sequence: u64) -> String {
        format!(r#"{{"command":{{"sequence":{sequence},"left_mm_s":40,"right_mm_s":-40.5}}}}"#)
    }

    fn heard(lines: &[&str]) -> Heard {
        let mut heard = Heard::new(Values::default(), wall());
        for line in lines {
            heard.line(Some(line));
        }
        heard
    }

    fn taken(heard: &mut Heard) -> Inputs {
        heard.take(TICK, wall())
    }

    #[test]
    fn nothing_is_obeyed_before_a_hello_of_this_version() {
        assert_eq!(taken(&mut heard(&[&command(1)])).command, None);
        let other = r#"{"hello":{"version":2}}"#;
        assert_eq!(taken(&mut heard(&[other, &command(1)])).command, None);
        assert_eq!(taken(&mut heard(&[HELLO, &command(1)])).command, Some([40.0, -40.5]));
    }

    #[test]
    fn commands_that_go_back_are_errors_and_three_in_a_row_stop() {
        let mut heard = heard(&[HELLO, &command(5)]);
        assert!(taken(&mut heard).command.is_some());
        for line in [command(5), command(4)] {
            heard.line(Some(&line));
            let inputs = taken(&mut heard);
            assert!(inputs.command.is_none() && inputs.conditions.is_empty());
        }
        // A valid one between them restarts the count.
        heard.line(Some(&command(6)));
        for line in [None, Some("nonsense")] {
            heard.line(line);
            assert!(taken(&mut heard).conditions.is_empty());
        }
        heard.line(Some("{}"));
        assert!(taken(&mut heard).conditions.has(Condition::Messages));
        assert!(taken(&mut heard).conditions.is_empty());
    }

    #[test]
    fn stops_and_resumes_are_for_one_step_and_a_lost_tracker_until_it_is_found() {
        let mut heard = heard(&[HELLO, "\"stop\"", "\"resume\"", r#"{"tracker":{"lost":true}}"#]);
        let inputs = taken(&mut heard);
        assert!(inputs.resume && inputs.conditions.has(Condition::Operator));
        let inputs = taken(&mut heard);
        let expected = [Condition::Tracker].into_iter().collect::<Conditions>();
        assert_eq!((inputs.resume, inputs.conditions), (false, expected));
        heard.line(Some(r#"{"tracker":{"lost":false}}"#));
        assert!(taken(&mut heard).conditions.is_empty());
    }

    #[test]
    fn what_the_robot_says_becomes_conditions() {
        let mut heard = heard(&[HELLO]);
        let mut after = |news: &[News]| {
            for news in news {
                heard.event(Event {
                    at: wall(),
                    news: news.clone(),
                });
            }
            let inputs = taken(&mut heard);
            (inputs.conditions.iter().collect::<Vec<_>>(), inputs.confirmed)
        };
        let [low, full] = [true, false].map(|low| News::Battery(Battery { volts: None, low }));
        assert_eq!(after(std::slice::from_ref(&low)), (vec![], 0));
        assert_eq!(after(&[full.clone(), low.clone()]), (vec![], 0));
        assert_eq!(after(std::slice::from_ref(&low)), (vec![Condition::Battery], 0));
        assert_eq!(after(&[]), (vec![Condition::Battery], 0));
        assert_eq!(after(&[full]), (vec![], 0));
        assert_eq!(
            after(&[News::Lifted(true), News::Lifted(true)]),
            (vec![Condition::Lifted], 0)
        );
        assert_eq!(after(&[News::Lifted(false), News::Stopped(7)]), (vec![], 7));
        assert_eq!(
            after(&[News::Failed(Error::Restarted)]),
            (vec![Condition::Restarted], 7)
        );
        let garbage = Error::Garbage {
            command: "N".into(),
            received: "x".into(),
        };
        assert_eq!(after(&[News::Failed(garbage.clone())]), (vec![Condition::Answers], 7));
        // While it stops, the stop is repeated, and what counts is whether it is confirmed.
        assert_eq!(after(&[News::NotStopped(garbage)]), (vec![], 7));
        let gone = Error::Disconnected {
            link: "x".into(),
            cause: "y".into(),
        };
        assert_eq!(after(&[News::Failed(gone)]), (vec![Condition::Late], 7));
    }

    #[test]
    fn lifting_can_be_left_out() {
        let values = Values::of(&["lifted=0".to_owned()]).unwrap();
        let mut heard = Heard::new(values, wall());
        for _ in 0..3 {
            heard.event(Event {
                at: wall(),
                news: News::Lifted(true),
            });
        }
        assert!(taken(&mut heard).conditions.is_empty());
    }
}
