//! Robots' computers, reached by the system's `ssh`: its configuration, keys and known hosts are the user's.
//!
//! A file is written by `cat` into a file next to its place, hashed there, and renamed. Paths go unquoted into
//! commands: those of a fleet have no character that a shell would interpret ([`super::file`]).

use std::io::{Read, Write};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{self, Receiver};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use oneiro_base::exit::{Code, Failure, Result};

use super::Outcomes;
use super::file::{Computers, Robot, Ssh};
use super::sha256_hex;

/// Exit status of `ssh` itself.
const OWN: i32 = 255;
/// A host's maximum time for its first answer, s.
const CONNECT_S: u32 = 10;
/// Maximum length of an answer in text, bytes.
const TEXT: usize = 1 << 20;
/// What is kept of messages, from their end, bytes.
const MESSAGES: usize = 1 << 14;
/// What is shown of a message, characters.
const SHOWN: usize = 500;

/// A computer, ready for commands.
#[derive(Clone, Copy, Debug)]
pub struct Remote<'a> {
    ssh: &'a Ssh,
    host: &'a str,
}

/// What a command wrote.
#[derive(Debug)]
struct Ran {
    status: ExitStatus,
    stdout: Vec<u8>,
    stderr: String,
}

impl<'a> Remote<'a> {
    /// The computer of a robot.
    pub fn of(fleet: &'a Computers, robot: &'a Robot) -> Self {
        Self {
            ssh: &fleet.ssh,
            host: &robot.host,
        }
    }

    /// The command as a person would type it.
    pub fn shown(&self, command: &str) -> String {
        let options = self.ssh.options.iter().map(String::as_str);
        let words = [&*self.ssh.program, "-o", "BatchMode=yes"].into_iter().chain(options);
        let words: Vec<&str> = words.chain([self.host]).collect();
        format!("{} '{command}'", words.join(" "))
    }

    /// Runs a command and returns what it wrote to standard output, at most `most` bytes.
    ///
    /// # Errors
    /// Exit 4: `ssh` can't reach the host or is refused, with what to do; the command fails, with the last line that it wrote to
    /// standard error; or it takes too long or writes more.
    pub fn bytes(&self, command: &str, most: usize) -> Result<Vec<u8>> {
        self.run_with_input(command, &[], most)
    }

    /// Like [`Remote::bytes`], as text of at most 1 MiB.
    pub fn text(&self, command: &str) -> Result<String> {
        Ok(String::from_utf8_lossy(&self.bytes(command, TEXT)?).into_owned())
    }

    /// Runs a command.
    ///
    /// # Errors
    /// As [`Remote::text`].
    pub fn run(&self, command: &str) -> Result {
        self.text(command).map(|_| ())
    }

    /// Writes a file: completely or not at all, and only if its hash there is that of `bytes`.
    ///
    /// # Errors
    /// As [`Remote::run`].
    pub fn put(&self, directory: &str, name: &str, mode: &str, bytes: &[u8]) -> Result {
        let new = format!(".{name}.new");
        let hash = sha256_hex(bytes);
        let command = format!(
            "umask 077 && mkdir -p {directory} && cd {directory} && cat > {new} && h=$(sha256sum < {new}) && \
             if [ \"${{h%% *}}\" != {hash} ]; then rm -f {new}; echo {name} arrived damaged >&2; exit 1; fi && \
             chmod {mode} {new} && sync && mv -f {new} {name}"
        );
        self.run_with_input(&command, bytes, TEXT).map(|_| ())
    }

    fn run_with_input(&self, command: &str, input: &[u8], most: usize) -> Result<Vec<u8>> {
        let failed = |problem: String| Failure::of(Code::Device, problem);
        let ran = self.ran(command, input, most).map_err(failed)?;
        if ran.status.success() {
            return Ok(ran.stdout);
        }
        let last = ran
            .stderr
            .lines()
            .rfind(|line| !line.trim().is_empty())
            .unwrap_or_default()
            .trim();
        let last = &last[..last.char_indices().nth(SHOWN).map_or(last.len(), |(end, _)| end)];
        Err(failed(match ran.status.code() {
            Some(OWN) => format!("ssh: {last}{}", hint(&ran.stderr, self.host)),
            Some(code) if last.is_empty() => format!("a command failed there with exit status {code}"),
            Some(_) => last.to_owned(),
            None => format!("{} was killed", self.ssh.program),
        }))
    }

    /// Runs a command until it ends, or kills it when its time is over or it has written too much.
    fn ran(&self, command: &str, input: &[u8], most: usize) -> std::result::Result<Ran, String> {
        let mut ssh = Command::new(&self.ssh.program);
        // If an option is repeated, ssh takes the first.
        ssh.args(["-o", "BatchMode=yes"])
            .args(&self.ssh.options)
            .args(["-o", &format!("ConnectTimeout={CONNECT_S}")])
            .args([self.host, command])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        let mut child = ssh.spawn().map_err(|error| format!("{}: {error}", self.ssh.program))?;
        let has_too_much = Arc::new(AtomicBool::new(false));
        let stdout = first(child.stdout.take(), most, &has_too_much);
        let stderr = last(child.stderr.take());
        if let Some(mut stdin) = child.stdin.take() {
            let input = input.to_owned();
            // It ends when all is written, or when ssh does. A command may ignore its input.
            thread::spawn(move || stdin.write_all(&input));
        }
        let seconds = self.ssh.timeout_s;
        let late = || format!("took longer than {seconds} s (ssh.timeout_s)");
        let until = Instant::now() + Duration::from_secs(seconds.into());
        let status = wait(&mut child, until, &has_too_much);
        if has_too_much.load(Ordering::Relaxed) {
            return Err(format!("answered with more than {most} bytes; allowed: up to that"));
        }
        let status = status.ok_or_else(late)?;
        // What a process that the command left behind still holds open never ends.
        let rest = Duration::from_secs(5);
        let stdout = stdout.recv_timeout(rest).map_err(|_| late())?;
        if has_too_much.load(Ordering::Relaxed) {
            return Err(format!("answered with more than {most} bytes; allowed: up to that"));
        }
        let stderr = stderr.recv_timeout(rest).unwrap_or_default();
        Ok(Ran {
            status,
            stdout,
            stderr: String::from_utf8_lossy(&stderr).into_owned(),
        })
    }
}

/// Reads a stream in a thread, to its end or up to `most` bytes; then it sets `has_too_much`.
fn first(stream: Option<impl Read + Send + 'static>, most: usize, has_too_much: &Arc<AtomicBool>) -> Receiver<Vec<u8>> {
    let has_too_much = Arc::clone(has_too_much);
    read(stream, move |stream| {
        let mut bytes = Vec::new();
        // Output before an error is kept.
        let _ = stream.take(most as u64 + 1).read_to_end(&mut bytes);
        has_too_much.store(bytes.len() > most, Ordering::Relaxed);
        bytes
    })
}

/// Reads a stream to its end on a thread, and keeps its last bytes.
fn last(stream: Option<impl Read + Send + 'static>) -> Receiver<Vec<u8>> {
    read(stream, |mut stream| {
        let (mut bytes, mut piece) = (Vec::new(), [0; 1 << 12]);
        while let Ok(length @ 1..) = stream.read(&mut piece) {
            bytes.extend_from_slice(&piece[..length]);
            bytes.drain(..bytes.len().saturating_sub(MESSAGES));
        }
        bytes
    })
}

fn read<S: Read + Send + 'static>(
    stream: Option<S>,
    take: impl FnOnce(S) -> Vec<u8> + Send + 'static,
) -> Receiver<Vec<u8>> {
    let (sender, receiver) = mpsc::channel();
    if let Some(stream) = stream {
        // Nobody may wait for it any more.
        thread::spawn(move || sender.send(take(stream)));
    }
    receiver
}

/// Waits for a process, no longer than until then, or until `is_over`; kills it afterwards and returns nothing.
fn wait(child: &mut Child, until: Instant, is_over: &AtomicBool) -> Option<ExitStatus> {
    let mut pause = Duration::from_millis(2);
    loop {
        if let Ok(Some(status)) = child.try_wait() {
            return Some(status);
        }
        if Instant::now() >= until || is_over.load(Ordering::Relaxed) {
            // If it has already ended, there is nothing to kill.
            let _ = child.kill();
            let _ = child.wait();
            return None;
        }
        thread::sleep(pause);
        pause = (2 * pause).min(Duration::from_millis(50));
    }
}

/// What to do about a message of `ssh`.
fn hint(message: &str, host: &str) -> String {
    let has = |words: &str| message.contains(words);
    if has("Permission denied") {
        format!(
            "; it may ask for no password here: `ssh-copy-id {host}` once, then `ssh {host} true` must work by itself"
        )
    } else if has("Host key verification failed") {
        format!("; connect once by hand and compare the fingerprint: `ssh {host}`")
    } else if has("Could not resolve hostname") {
        "; allowed: a name of ~/.ssh/config, a host name or an address".to_owned()
    } else if has("timed out") || has("No route to host") || has("Connection refused") {
        "; is it on, in this network, and does it run an ssh server?".to_owned()
    } else {
        String::new()
    }
}

/// Does the same for several robots, some of them at a time; a failure of one does not stop the others.
pub fn on_each<T: Send>(
    fleet: &Computers,
    robots: &[&Robot],
    work: impl Fn(&Robot, Remote<'_>) -> Result<T> + Sync,
) -> Outcomes<T> {
    let next = AtomicUsize::new(0);
    let outcomes = Mutex::new(Vec::with_capacity(robots.len()));
    let threads = robots.len().min(fleet.ssh.parallel as usize);
    thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                while let Some(robot) = robots.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let outcome = work(robot, Remote::of(fleet, robot));
                    let mut outcomes = outcomes.lock().unwrap_or_else(PoisonError::into_inner);
                    outcomes.push((robot.number, outcome));
                }
            });
        }
    });
    let mut outcomes = outcomes.into_inner().unwrap_or_else(PoisonError::into_inner);
    outcomes.sort_by_key(|(number, _)| *number);
    outcomes
}
