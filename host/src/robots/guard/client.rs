//! A program's side of the guard: starts it, sends it commands, and hears what it says.

use std::ffi::OsString;
use std::io::{self, BufRead, BufReader, Write};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::thread;
use std::time::Duration;

use super::message::{Report, Request, Status, VERSION};

/// A guard at work. When it is dropped the guard stops the robot and ends, and so it does when this process is killed.
pub(crate) struct Client {
    child: Child,
    requests: Option<ChildStdin>,
    reports: Receiver<Report>,
    sequence: u64,
    /// Looks in a row in which nothing was heard. Their number and not a time, since this process may be held up itself.
    looks: u32,
    is_connected: bool,
    /// The exit code and the message with which it failed.
    failure: Option<(u8, String)>,
}

/// The guard does nothing more: the wheels may be turning.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum Lost {
    /// Its process is gone.
    #[error("the guard is gone")]
    Ended,
    /// Its process is there, and says nothing.
    #[error("the guard hangs")]
    Hangs,
}

impl Client {
    /// Between two looks.
    pub(crate) const CYCLE: Duration = Duration::from_millis(20);
    /// Number of looks without a report, 1 s in all, after which the guard counts as hung. Once the robot is connected, it
    /// reports ten times a second.
    const SILENCE: u32 = 50;

    /// Starts the guard of a robot, with these arguments.
    ///
    /// # Errors
    /// The system can't start it.
    pub(crate) fn start(arguments: &[OsString]) -> io::Result<Self> {
        let mut child = Command::new(std::env::current_exe()?)
            .arg("guard")
            .args(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()?;
        let (sender, reports) = mpsc::channel();
        if let Some(stdout) = child.stdout.take() {
            thread::spawn(move || {
                let lines = BufReader::new(stdout).lines().map_while(Result::ok);
                for report in lines.filter_map(|line| serde_json::from_str(&line).ok()) {
                    if sender.send(report).is_err() {
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
            looks: 0,
            is_connected: false,
            failure: None,
        };
        client.send(Request::Hello { version: VERSION });
        Ok(client)
    }

    /// Sends new speeds, mm/s. They count until they expire.
    pub(crate) fn drive(&mut self, [left_mm_s, right_mm_s]: [f64; 2]) {
        self.sequence += 1;
        self.send(Request::Command {
            sequence: self.sequence,
            left_mm_s,
            right_mm_s,
        });
    }

    /// Sends a request. A guard that does not take it is found out by its silence.
    pub(crate) fn send(&mut self, request: Request) {
        let line = serde_json::to_string(&request).unwrap_or_default() + "\n";
        if let Some(requests) = &mut self.requests {
            let _ = requests.write_all(line.as_bytes());
        }
    }

    /// The next report, if one comes within a cycle.
    ///
    /// # Errors
    /// The guard is gone, or has been silent for too long; until the robot is connected it may be silent.
    pub(crate) fn report(&mut self) -> Result<Option<Report>, Lost> {
        match self.reports.recv_timeout(Self::CYCLE) {
            Ok(report) => {
                self.looks = 0;
                self.note(&report);
                Ok(Some(report))
            }
            Err(RecvTimeoutError::Disconnected) => Err(Lost::Ended),
            Err(RecvTimeoutError::Timeout) => {
                self.looks += u32::from(self.is_connected);
                if self.looks > Self::SILENCE {
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

    /// Lets the guard stop the robot and end, and waits for that; `hear` gets each state meanwhile. Returns the exit code
    /// and the message with which it failed, if it did.
    ///
    /// # Errors
    /// It was killed, or hangs.
    pub(crate) fn finish(mut self, mut hear: impl FnMut(&Status)) -> Result<Option<(u8, String)>, Lost> {
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
    pub(crate) fn kill(&mut self) {
        // It may be gone already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
