//! Talk in the manner of the Khepera and the e-puck: a command, then an answer that is a line of text or a known number
//! of bytes.

use std::time::Duration;

use super::error::{Error, Result};
use super::link::Link;

/// How long a link may take to accept a command.
const SEND: Duration = Duration::from_millis(200);
/// Answers that can be missing at a new meeting: those to the command before, to its end, and to a stop.
const MISSING: usize = 3;
/// The answer to a stop, and to any other speeds.
const STOPPED: &str = "d";
/// Longest wait for a silence.
const BABBLE: Duration = Duration::from_millis(800);

/// Received bytes, until they are taken as lines or as bytes. Holds a bounded number of bytes.
#[derive(Debug, Default)]
pub(crate) struct Received {
    bytes: Vec<u8>,
    /// The rest of a line that is too long.
    skipping: bool,
}

impl Received {
    /// The longest line kept. Robots' answers have up to 60 characters, and their banners 80.
    pub(crate) const LONGEST: usize = 256;

    /// Adds bytes.
    pub(crate) fn push(&mut self, bytes: &[u8]) {
        self.bytes.extend_from_slice(bytes);
    }

    /// The next line that is not empty, without its end: CR, LF or both. A byte that is no printable ASCII character is
    /// written `\xNN`. Of a line that is too long only the beginning is returned, with dots at its end.
    pub(crate) fn line(&mut self) -> Option<String> {
        let is_end = |byte: &u8| matches!(byte, b'\r' | b'\n');
        loop {
            if !self.skipping {
                let empty = self.bytes.iter().take_while(|byte| is_end(byte)).count();
                self.bytes.drain(..empty);
            }
            let end = self.bytes.iter().position(is_end);
            let too_long = end.unwrap_or(self.bytes.len()) > Self::LONGEST;
            let was_skipping = self.skipping;
            let line: Vec<u8> = match end {
                Some(end) => self.bytes.drain(..=end).take(end).collect(),
                None if too_long || was_skipping => self.bytes.drain(..).collect(),
                None => return None,
            };
            self.skipping = end.is_none();
            if !was_skipping && !line.is_empty() {
                let shown = shown(&line[..line.len().min(Self::LONGEST)]);
                return Some(if too_long { shown + ".." } else { shown });
            }
            end?;
        }
    }

    /// Takes a number of bytes, if there are as many.
    pub(crate) fn take(&mut self, count: usize) -> Option<Vec<u8>> {
        (count <= self.bytes.len()).then(|| self.bytes.drain(..count).collect())
    }

    /// Forgets all bytes.
    pub(crate) fn clear(&mut self) {
        *self = Self::default();
    }
}

/// Bytes as text; what is no printable ASCII character as `\xNN`.
pub(crate) fn shown(bytes: &[u8]) -> String {
    bytes
        .iter()
        .map(|&byte| match byte {
            b' '..=b'~' => char::from(byte).to_string(),
            _ => format!("\\x{byte:02x}"),
        })
        .collect()
}

/// Finds a text in a stream, wherever it is cut.
#[derive(Debug)]
pub(crate) struct Watch {
    text: &'static [u8],
    /// The last bytes, one fewer than the text has.
    tail: Vec<u8>,
    found: bool,
}

impl Watch {
    /// Looks for a text.
    pub(crate) fn new(text: &'static str) -> Self {
        Self {
            text: text.as_bytes(),
            tail: Vec::new(),
            found: false,
        }
    }

    /// Adds bytes of the stream.
    pub(crate) fn push(&mut self, bytes: &[u8]) {
        self.tail.extend_from_slice(bytes);
        self.found |= self.tail.windows(self.text.len()).any(|part| part == self.text);
        let known = self.tail.len().saturating_sub(self.text.len() - 1);
        self.tail.drain(..known);
    }

    /// Whether the text has come since the last call.
    pub(crate) fn take(&mut self) -> bool {
        std::mem::take(&mut self.found)
    }
}

/// The answer to a command: the fields after its letter, which is the command's in lower case.
///
/// # Errors
/// A refusal, which begins with `z` or is "Command not found", or another line.
pub(crate) fn fields<'a>(command: &str, line: &'a str) -> Result<Vec<&'a str>> {
    let command = command.trim_end();
    let letter = command.chars().next().map_or(' ', |letter| letter.to_ascii_lowercase());
    if letter != 'z' && (line.starts_with('z') || line.starts_with("Command not found")) {
        return Err(Error::Refused {
            command: command.into(),
            answer: line.into(),
        });
    }
    match line.strip_prefix(letter) {
        Some("") => Ok(Vec::new()),
        Some(rest) if rest.starts_with(',') => Ok(rest[1..].split(',').map(str::trim).collect()),
        _ => Err(garbage(command, line)),
    }
}

/// The range of numbers of 32 bits.
pub(crate) const ANY: (i64, i64) = (i32::MIN as i64, i32::MAX as i64);

/// The numbers of an answer, as many as `counts` allows, each from `low` to `high`.
///
/// # Errors
/// As [`fields`], and for other numbers.
pub(crate) fn numbers(command: &str, line: &str, counts: &[usize], (low, high): (i64, i64)) -> Result<Vec<i64>> {
    let fields = fields(command, line)?;
    let numbers: Option<Vec<i64>> = fields.iter().map(|field| field.parse().ok()).collect();
    numbers
        .filter(|numbers| counts.contains(&numbers.len()) && numbers.iter().all(|value| (low..=high).contains(value)))
        .ok_or_else(|| garbage(command, line))
}

/// The error of an answer that makes no sense.
pub(crate) fn garbage(command: &str, received: &str) -> Error {
    Error::Garbage {
        command: shown(command.trim_end().as_bytes()),
        received: received.into(),
    }
}

/// A conversation with a robot that says a banner when it starts.
pub(crate) struct Talk {
    link: Box<dyn Link>,
    received: Received,
    banner: Watch,
    /// How long an answer may take.
    patience: Duration,
    in_step: bool,
    /// Whether the last question of [`Talk::meet`] had no answer, which may still come.
    is_owed: bool,
}

impl Talk {
    /// A conversation over a link. `patience` is how long an answer may take over a cable.
    pub(crate) fn new(link: Box<dyn Link>, banner: &'static str, patience: Duration) -> Self {
        let patience = patience + link.delay();
        Self {
            link,
            received: Received::default(),
            banner: Watch::new(banner),
            patience,
            in_step: false,
            is_owed: false,
        }
    }

    /// Whether no answer to an earlier command can still come.
    pub(crate) fn in_step(&mut self) -> &mut bool {
        &mut self.in_step
    }

    /// The link.
    pub(crate) fn link(&mut self) -> &mut dyn Link {
        &mut *self.link
    }

    /// Ends the conversation.
    pub(crate) fn into_link(self) -> Box<dyn Link> {
        self.link
    }

    /// The time on the link's clock.
    pub(crate) fn now(&self) -> Duration {
        self.link.now()
    }

    /// Whether the banner has come since the last call.
    fn restarted(&mut self) -> bool {
        self.banner.take()
    }

    /// Receives more bytes; false once the time has passed.
    fn receive(&mut self, until: Duration) -> Result<bool> {
        let mut buffer = [0; 512];
        let count = self.link.read(&mut buffer, until)?;
        self.banner.push(&buffer[..count]);
        self.received.push(&buffer[..count]);
        Ok(count > 0)
    }

    /// Sends bytes; bytes that came before are discarded.
    ///
    /// # Errors
    /// The robot has restarted, or the link fails.
    pub(crate) fn send(&mut self, bytes: &[u8]) -> Result {
        let mut buffer = [0; 512];
        // As many as an operating system keeps for a port; a stream that does not end is found out by the answer.
        for _ in 0..128 {
            match self.link.waiting(&mut buffer)? {
                0 => break,
                count => self.banner.push(&buffer[..count]),
            }
        }
        self.received.clear();
        if self.restarted() {
            return Err(Error::Restarted);
        }
        let until = self.now() + SEND;
        self.link.write(bytes, until)
    }

    /// The next line.
    ///
    /// # Errors
    /// None came in time, the robot has restarted, or the link fails.
    pub(crate) fn line(&mut self, command: &str) -> Result<String> {
        self.line_until(command, self.now() + self.patience)
    }

    /// The next line. Answers to the guard's repeated stops are skipped.
    fn line_until(&mut self, command: &str, until: Duration) -> Result<String> {
        loop {
            let line = self.answer(command, until, Received::line)?;
            if line != STOPPED || command.starts_with('D') {
                return Ok(line);
            }
        }
    }

    /// The next bytes, after which there must be no more.
    ///
    /// # Errors
    /// They did not come in time, there are more, the robot has restarted, or the link fails.
    pub(crate) fn bytes(&mut self, command: &str, count: usize) -> Result<Vec<u8>> {
        let bytes = self.answer(command, self.now() + self.patience, |received| received.take(count))?;
        match self.received.take(1) {
            None => Ok(bytes),
            Some(_) => Err(garbage(command, &format!("more than {count} bytes"))),
        }
    }

    /// Receives until there is an answer.
    fn answer<T>(&mut self, command: &str, until: Duration, find: impl Fn(&mut Received) -> Option<T>) -> Result<T> {
        loop {
            let found = find(&mut self.received);
            if self.restarted() {
                return Err(Error::Restarted);
            }
            if let Some(found) = found {
                return Ok(found);
            }
            if !self.receive(until)? {
                return Err(self.late(command));
            }
        }
    }

    /// Gets in step: asks what nothing else asks, and skips answers to earlier commands, since a robot answers in order. `silence` is
    /// the pause that ends an answer, after which it is asked. Returns the fields of its answer.
    ///
    /// # Errors
    /// The answer did not come in time, which names what came in its place; the robot has restarted, or the link fails.
    pub(crate) fn meet(&mut self, question: &str, silence: Duration) -> Result<Vec<String>> {
        // An answer to the same question, asked before, must not pass for that to this one.
        self.silence(if self.is_owed { self.patience } else { silence })?;
        self.is_owed = true;
        self.send(question.as_bytes())?;
        let until = self.now() + self.patience;
        let mut failure = self.late(question);
        for _ in 0..=MISSING {
            let line = match self.line_until(question, until) {
                Err(Error::TimedOut { .. }) => break,
                line => line?,
            };
            failure = match fields(question, &line) {
                Ok(fields) if !fields.is_empty() => {
                    self.is_owed = false;
                    return Ok(fields.into_iter().map(Into::into).collect());
                }
                Ok(_) => garbage(question, &line),
                Err(error) => error,
            };
        }
        Err(failure)
    }

    fn late(&self, command: &str) -> Error {
        Error::TimedOut {
            command: command.trim_end().into(),
            limit: self.patience,
        }
    }

    /// Discards bytes until none has come for `silence`.
    ///
    /// # Errors
    /// It does not end, or the link fails.
    pub(crate) fn silence(&mut self, silence: Duration) -> Result {
        let end = self.now() + BABBLE;
        loop {
            let until = (self.now() + silence).min(end);
            let came = self.receive(until)?;
            self.received.clear();
            if !came && until < end {
                return Ok(());
            }
            if !came {
                return Err(garbage("a pause", "a stream that does not end"));
            }
        }
    }
}

/// One end of a conversation that can fall out of step: an answer that comes late passes for that to a later command.
pub(crate) trait Stepped {
    /// Whether no answer to an earlier command can still come.
    fn in_step(&mut self) -> &mut bool;

    /// Gets back in step.
    ///
    /// # Errors
    /// The robot does not answer, or the link fails.
    fn resynchronise(&mut self) -> Result;
}

fn restore(robot: &mut impl Stepped) -> Result {
    *robot.in_step() = false;
    robot.resynchronise()?;
    *robot.in_step() = true;
    Ok(())
}

/// Gets in step with a robot that may have sent anything before, including its banner: tries twice.
///
/// # Errors
/// That of the second attempt, or one that does not pass.
pub(crate) fn afresh(robot: &mut impl Stepped) -> Result {
    match restore(robot) {
        Err(error) if error.may_pass() || error == Error::Restarted => restore(robot),
        outcome => outcome,
    }
}

/// Tries up to `tries` times, and gets back in step after each failure that may pass. Out of step, it does so before the
/// first attempt.
///
/// # Errors
/// That of the last attempt; that of getting in step if it says more, or if no attempt could be made.
pub(crate) fn persistently<R: Stepped, T>(
    robot: &mut R,
    tries: u32,
    mut attempt: impl FnMut(&mut R) -> Result<T>,
) -> Result<T> {
    if !*robot.in_step() {
        restore(robot)?;
    }
    let mut tried = 1;
    loop {
        *robot.in_step() = false;
        match attempt(robot) {
            Ok(done) => {
                *robot.in_step() = true;
                return Ok(done);
            }
            Err(error) if error.may_pass() => {
                restore(robot).map_err(|worse| if worse.may_pass() { error.clone() } else { worse })?;
                if tried == tries {
                    return Err(error);
                }
                tried += 1;
            }
            Err(error) => return Err(error),
        }
    }
}

#[cfg(test)]
mod tests;
