//! A program's side of the guard: starts it, sends it commands, and receives its reports.

use std::io::{self, BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::thread;
use std::time::Duration;

use oneiro_base::console::Console;
use oneiro_base::exit::{Code, Failure};
use oneiro_base::program;

use super::message::{Report, Request, Status, VERSION};
use super::values::Values;
use super::wheels::Wanted;
use crate as robots;
use crate::address::Wire;
use crate::link::wall;
use crate::realtime::RealTime;
use crate::{stopped, unstopped};

/// A guard at work. When it is dropped the guard stops the robot and ends, and so it does when this process is killed.
pub struct Client {
    child: Child,
    requests: Option<ChildStdin>,
    /// The guard's reports, each with its time on the links' clock.
    reports: Receiver<(Duration, Report)>,
    sequence: u64,
    /// Waiting in a row in which nothing was heard. Not the time since then, since this process may be held up itself.
    silence: Duration,
    is_connected: bool,
    /// The exit code and the message with which it failed.
    failure: Option<(u8, String)>,
}

/// The guard does nothing more: the wheels may be turning.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Lost {
    /// Its process is gone.
    #[error("the guard is gone")]
    Ended,
    /// Its process exists, and sends nothing.
    #[error("the guard hangs")]
    Hangs,
}

impl Lost {
    /// Stops the robot without its guard. Returns the failure to report, with whether the robot has stopped.
    pub fn stopped(self, wire: &Wire, console: Console) -> Failure {
        console.say(format!(
            "{self}, and the wheels may be turning: stopping them without it"
        ));
        match robots::connect(wire, None).and_then(|mut robot| stopped(&mut *robot)) {
            Ok(()) => Failure::device(format_args!(
                "{self}; the robot was stopped without it, and has confirmed that"
            )),
            Err(error) => unstopped(&error),
        }
    }
}

/// A failure that the guard has reported.
pub fn failure(code: u8, message: &str) -> Failure {
    const INPUT: u8 = Code::Input as u8;
    const STORAGE: u8 = Code::Storage as u8;
    match code {
        INPUT => Failure::input(message),
        STORAGE => Failure::unwritten(message),
        _ => Failure::device(message),
    }
}

/// Whether threads are to have real-time priority. Settings that are not valid are for the guard to refuse.
pub(crate) fn is_realtime(settings: &[String]) -> bool {
    Values::of(settings).is_ok_and(|values| values.realtime())
}

impl Client {
    /// Between two looks.
    pub const CYCLE: Duration = Duration::from_millis(20);
    /// Waiting without a report after which the guard counts as hung. Once the robot is connected, it reports ten times a
    /// second.
    const SILENCE: Duration = Duration::from_secs(1);

    /// Starts the guard of a robot with its settings, each written `KEY=VALUE`, and a file for a recording of the link.
    ///
    /// # Errors
    /// Exit 1: the system can't start it.
    pub fn start(address: &str, wanted: &Wanted, settings: &[String], record: Option<&Path>) -> Result<Self, Failure> {
        let mut command = Command::new(program::path().map_err(|error| unstarted(&error))?);
        command.args(["guard", address]);
        for kind in &wanted.kinds {
            command.args(["--kinds", &kind.to_string()]);
        }
        for setting in settings {
            command.args(["--guard", setting]);
        }
        if wanted.odometry {
            command.arg("--odometry");
        }
        if let Some(record) = record {
            command.arg("--record").arg(record);
        }
        Self::of(command, is_realtime(settings)).map_err(|error| unstarted(&error))
    }

    fn of(mut command: Command, is_realtime: bool) -> io::Result<Self> {
        let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn()?;
        let (sender, reports) = mpsc::channel();
        if let Some(stdout) = child.stdout.take() {
            thread::spawn(move || {
                let _raised = is_realtime.then(RealTime::of_this_thread);
                let lines = BufReader::new(stdout).lines().map_while(Result::ok);
                for report in lines.filter_map(|line| serde_json::from_str(&line).ok()) {
                    if sender.send((wall(), report)).is_err() {
                        return;
                    }
                }
            });
        }
        let mut client = Self {
            requests: child.stdin.take(),
            child,
            reports,
            sequence: 0,
            silence: Duration::ZERO,
            is_connected: false,
            failure: None,
        };
        client.send(Request::Hello { version: VERSION });
        Ok(client)
    }

    /// Sends new speeds, mm/s. They count until they expire.
    pub fn drive(&mut self, [left_mm_s, right_mm_s]: [f64; 2]) {
        self.sequence += 1;
        self.send(Request::Command {
            sequence: self.sequence,
            left_mm_s,
            right_mm_s,
        });
    }

    /// The number of the last command.
    pub fn sequence(&self) -> u64 {
        self.sequence
    }

    /// Sends a request. A guard that does not take it is found out by its silence.
    pub fn send(&mut self, request: Request) {
        let line = serde_json::to_string(&request).unwrap_or_default() + "\n";
        if let Some(requests) = &mut self.requests {
            let _ = requests.write_all(line.as_bytes());
        }
    }

    /// The next report, if one comes within a cycle.
    ///
    /// # Errors
    /// The guard is gone, or has been silent for too long; until the robot is connected it may be silent.
    pub fn report(&mut self) -> Result<Option<Report>, Lost> {
        let report = self.report_within(Self::CYCLE)?;
        Ok(report.map(|(_, report)| report))
    }

    /// The next report and when it came, on the links' clock, if one comes in time.
    ///
    /// # Errors
    /// As [`Client::report`].
    pub fn report_within(&mut self, limit: Duration) -> Result<Option<(Duration, Report)>, Lost> {
        match self.reports.recv_timeout(limit) {
            Ok((at, report)) => {
                self.silence = Duration::ZERO;
                self.note(&report);
                Ok(Some((at, report)))
            }
            Err(RecvTimeoutError::Disconnected) => Err(Lost::Ended),
            Err(RecvTimeoutError::Timeout) => {
                if self.is_connected {
                    self.silence += limit;
                }
                if self.silence > Self::SILENCE {
                    Err(Lost::Hangs)
                } else {
                    Ok(None)
                }
            }
        }
    }

    fn note(&mut self, report: &Report) {
        match report {
            Report::Connected { .. } => self.is_connected = true,
            Report::Failed { code, message } => self.failure = Some((*code, message.clone())),
            _ => {}
        }
    }

    /// Lets the guard stop the robot and end, and waits for that; `hear` gets each state until then. Returns the exit
    /// code and the message with which it failed, if it did.
    ///
    /// # Errors
    /// It was killed, or hangs.
    pub fn finish(mut self, mut hear: impl FnMut(&Status)) -> Result<Option<(u8, String)>, Lost> {
        self.send(Request::End);
        loop {
            match self.report() {
                Ok(Some(Report::State(status))) => hear(&status),
                Ok(_) => {}
                Err(Lost::Ended) => break,
                Err(Lost::Hangs) => {
                    self.kill();
                    return Err(Lost::Hangs);
                }
            }
        }
        match (self.child.wait(), self.failure) {
            (_, Some(failure)) => Ok(Some(failure)),
            (Ok(status), None) if status.success() => Ok(None),
            _ => Err(Lost::Ended),
        }
    }

    /// Kills a guard that hangs, which frees the link.
    pub fn kill(&mut self) {
        // It may be gone already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn unstarted(error: &io::Error) -> Failure {
    Failure::failed(format_args!("the guard can't be started: {error}"))
}
