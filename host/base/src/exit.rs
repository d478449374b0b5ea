//! How the program ends: exit codes, and the failure that carries one.

use std::fmt::Display;
use std::io;
use std::path::Path;

use oneiro::evaluator;
use oneiro::parameter::Invalid;
use oneiro::reported;
use oneiro::swarm::Trouble;

use crate::plain;

/// How to go on.
#[macro_export]
macro_rules! complete {
    () => {
        "Recorded results are complete. `oneiro resume` finishes a run; the same command finishes a sweep or a study"
    };
}
pub use crate::complete;

/// Exit codes other than 0; `docs/commands.md` lists them for users.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Code {
    /// A run, a check or a comparison failed.
    Failed = 1,
    /// The command line is not valid.
    Usage = 2,
    /// A configuration or an input file is invalid or missing.
    Input = 3,
    /// No usable device or robot.
    Device = 4,
    /// Recorded data are corrupt.
    Corrupt = 5,
    /// The disk is full, or reading or writing failed.
    Storage = 6,
    /// Not enough memory, or no thread can be started.
    Memory = 7,
    /// A mistake in Oneiro, or a crash in a library.
    Broken = 70,
    /// Stopped early; the run can be resumed.
    Stopped = 75,
    /// A second Ctrl-C.
    Aborted = 130,
}

/// Why a command failed or stopped.
#[derive(Debug)]
pub enum Failure {
    /// Ends the program with a code and a message.
    Exit(Code, anyhow::Error),
    /// The reader of standard output has closed it: the program ends silently with exit 0.
    BrokenPipe,
}

/// Message for stopped work of which nothing was recorded.
const NOT_RECORDED: &str = "stopped; nothing was recorded; run the same command to start again";

/// The result of a command.
pub type Result<T = ()> = std::result::Result<T, Failure>;

impl Failure {
    fn new(code: Code, problem: impl Display) -> Self {
        Self::Exit(code, anyhow::Error::msg(unnumbered(&problem.to_string())))
    }

    /// Any exit code.
    pub fn of(code: Code, problem: impl Display) -> Self {
        Self::new(code, problem)
    }

    /// Exit 1: a run, a check or a comparison failed.
    pub fn failed(problem: impl Display) -> Self {
        Self::new(Code::Failed, problem)
    }

    /// Exit 2: the command line is not valid.
    pub fn usage(problem: impl Display) -> Self {
        Self::new(Code::Usage, problem)
    }

    /// Exit 3: the problem, its place, and what is allowed.
    pub fn input(problem: impl Display) -> Self {
        Self::new(Code::Input, problem)
    }

    /// Exit 4: no usable device or robot.
    pub fn device(problem: impl Display) -> Self {
        Self::new(Code::Device, problem)
    }

    /// Exit 5: recorded data are corrupt.
    pub fn corrupt(problem: impl Display) -> Self {
        Self::new(Code::Corrupt, problem)
    }

    /// Exit 70: a part of the program panicked, whose message has been printed.
    pub fn broken(part: &str) -> Self {
        Self::new(
            Code::Broken,
            format_args!(
                concat!(
                    "{} panicked, which is a mistake in Oneiro. Please report it with the command and the line above. ",
                    complete!()
                ),
                part
            ),
        )
    }

    /// Exit 75: stopped early; the run can be resumed.
    pub fn stopped(message: impl Display) -> Self {
        Self::new(Code::Stopped, message)
    }

    /// Exit 6, for a file that the program failed to write or to read back: the path and the system's message. Exit 7
    /// if memory was missing; exit 3 for a pipe, a device, a link or the like, which are refused.
    pub fn storage(path: &Path, error: &io::Error) -> Self {
        if plain::is_refusal(error) {
            return Self::input(format_args!("{}: {error}", path.display()));
        }
        let (code, hint) = match error.kind() {
            io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => {
                (Code::Storage, "; free some space and try again")
            }
            io::ErrorKind::OutOfMemory => (Code::Memory, "; allow more memory (ulimit -v) and try again"),
            _ if is_file_limit(error) => (Code::Storage, "; allow more (ulimit -n 64) and try again"),
            _ => (Code::Storage, ""),
        };
        Self::new(code, format_args!("{}: {error}{hint}", path.display()))
    }

    /// Exit 6, for a file that a library failed to write: the library's message, which names the path.
    pub fn unwritten(problem: impl Display) -> Self {
        Self::new(Code::Storage, problem)
    }

    /// For a file that the user named as input: exit 3 if it is missing or of the wrong kind, else exit 6.
    pub fn unreadable(path: &Path, error: &io::Error) -> Self {
        // Only a part of an impossibly long name.
        const LONGEST: usize = 1_000;
        let mut name = path.display().to_string();
        if name.len() > LONGEST {
            name = format!("{name:.200} ..");
        }
        match error.kind() {
            io::ErrorKind::NotFound
            | io::ErrorKind::PermissionDenied
            | io::ErrorKind::IsADirectory
            | io::ErrorKind::NotADirectory
            | io::ErrorKind::InvalidData
            | io::ErrorKind::InvalidInput
            | io::ErrorKind::InvalidFilename
            | io::ErrorKind::UnexpectedEof => Self::input(format_args!("{name}: {error}")),
            _ => Self::storage(path, error),
        }
    }

    /// For standard output: a silent end if its reader has closed it, else exit 6.
    pub fn stdout(error: &io::Error) -> Self {
        match error.kind() {
            io::ErrorKind::BrokenPipe => Self::BrokenPipe,
            _ => Self::storage(Path::new("standard output"), error),
        }
    }

    /// Both failures: the code of the first, and the messages of both.
    pub fn and(self, other: Self) -> Self {
        match (self, other) {
            (Self::Exit(code, error), Self::Exit(_, other)) => Self::new(code, format_args!("{error:#}\n{other:#}")),
            (Self::BrokenPipe, _) | (_, Self::BrokenPipe) => Self::BrokenPipe,
        }
    }

    /// The same failure, with a place before its message.
    pub fn at(self, place: &str) -> Self {
        match self {
            Self::Exit(code, error) => Self::new(code, format_args!("{place}: {error:#}")),
            Self::BrokenPipe => self,
        }
    }

    /// The same failure, with more words after its message.
    pub fn and_say(self, words: &str) -> Self {
        match self {
            Self::Exit(code, error) => Self::new(code, format_args!("{error:#}{words}")),
            Self::BrokenPipe => self,
        }
    }

    /// The exit code.
    pub fn code(&self) -> u8 {
        match self {
            Self::Exit(code, _) => *code as u8,
            Self::BrokenPipe => 0,
        }
    }
}

impl Display for Failure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Exit(_, error) => write!(f, "{error:#}"),
            Self::BrokenPipe => f.write_str("standard output was closed"),
        }
    }
}

impl From<reported::Error> for Failure {
    fn from(error: reported::Error) -> Self {
        match error {
            reported::Error::Invalid(invalid) => invalid.into(),
            reported::Error::Device(error) => error.into(),
        }
    }
}

impl From<Trouble> for Failure {
    fn from(trouble: Trouble) -> Self {
        match trouble {
            Trouble::Invalid(invalid) => invalid.into(),
            Trouble::Evaluation(error) => error.into(),
        }
    }
}

impl From<Invalid> for Failure {
    fn from(invalid: Invalid) -> Self {
        Self::input(invalid)
    }
}

impl From<evaluator::Error> for Failure {
    fn from(error: evaluator::Error) -> Self {
        match error {
            evaluator::Error::Cancelled => Self::stopped(NOT_RECORDED),
            evaluator::Error::NoDevice(_) | evaluator::Error::TooLarge(_) => Self::device(error),
            evaluator::Error::Short(_) => Self::new(Code::Memory, error),
            _ => Self::failed(error),
        }
    }
}

/// A message without the numbers of the system's errors in it, which say less than its words.
fn unnumbered(message: &str) -> String {
    let mut parts = message.split(" (os error ");
    let mut text = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let digits = part.trim_start_matches(|c: char| c.is_ascii_digit());
        match digits.strip_prefix(')') {
            Some(rest) if digits.len() < part.len() => text += rest,
            _ => text.extend([" (os error ", part]),
        }
    }
    text
}

/// Whether descriptors are missing.
fn is_file_limit(error: &io::Error) -> bool {
    #[cfg(unix)]
    let limits = [libc::EMFILE, libc::ENFILE];
    #[cfg(not(unix))]
    let limits = [];
    error.raw_os_error().is_some_and(|code| limits.contains(&code))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_those_of_the_readme() {
        assert_eq!(Failure::failed("").code(), 1);
        assert_eq!(Failure::usage("").code(), 2);
        assert_eq!(Failure::input("").code(), 3);
        assert_eq!(Failure::device("").code(), 4);
        assert_eq!(Failure::corrupt("").code(), 5);
        assert_eq!(
            Failure::storage(Path::new("a"), &io::ErrorKind::StorageFull.into()).code(),
            6
        );
        assert_eq!(
            Failure::storage(Path::new("a"), &io::ErrorKind::OutOfMemory.into()).code(),
            7
        );
        assert_eq!(Failure::broken("").code(), 70);
        assert_eq!(Failure::stopped("").code(), 75);
        assert_eq!(Code::Aborted as u8, 130);
        assert_eq!(Failure::stdout(&io::ErrorKind::BrokenPipe.into()).code(), 0);
        assert_eq!(
            Failure::unreadable(Path::new("a"), &io::ErrorKind::NotFound.into()).code(),
            3
        );
    }
}
