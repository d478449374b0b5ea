//! Reasons why a robot can't be used. Each message has the remedy.

use std::borrow::Cow;
use std::io;
use std::time::Duration;

use oneiro_base::exit::Failure;

/// The result of a call to a robot.
pub type Result<T = ()> = std::result::Result<T, Error>;

/// Reason why a call to a robot failed.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize, thiserror::Error)]
#[serde(rename_all = "snake_case")]
pub enum Error {
    /// The robot did not answer in time. Its wheels may be turning.
    #[error(
        "no answer to {command} within {} ms; check that the robot is on and in range, and that no other program \
         talks to it",
        limit.as_millis()
    )]
    TimedOut {
        /// What was asked.
        command: String,
        /// How long the driver waited.
        limit: Duration,
    },
    /// The link did not take all bytes in time. The wheels may be turning.
    #[error(
        "{bytes} bytes could not be sent within {} ms; check that the robot is on, and the flow control of its link",
        limit.as_millis()
    )]
    Unsent {
        /// How many there were.
        bytes: usize,
        /// How long the link had.
        limit: Duration,
    },
    /// The robot's answer does not fit the command.
    #[error("unexpected answer to {command}: \"{received}\"; check the cable, the baud rate and the kind of robot")]
    Garbage {
        /// What was asked.
        command: String,
        /// What came, or the problem with it.
        received: String,
    },
    /// The robot understood, and does not do it.
    #[error("the robot refused {command}: \"{answer}\"; its firmware may be older or of another kind")]
    Refused {
        /// What was asked.
        command: String,
        /// Its answer.
        answer: String,
    },
    /// The robot has restarted: its counters and its speeds are 0 again, unless a program on it drives.
    #[error("the robot has restarted, and may drive by itself; stop it and check its battery before you continue")]
    Restarted,
    /// The robot answers, but its wheels have not stopped.
    #[error("the robot has not stopped: {seen}; try again")]
    StillTurning {
        /// The evidence, as a clause.
        seen: String,
    },
    /// The link is gone. The wheels may be turning.
    #[error("{link}: the connection is lost: {cause}; check the cable or the radio and connect again")]
    Disconnected {
        /// The link's address.
        link: String,
        /// The system's message.
        cause: String,
    },
    /// The link can't be opened.
    #[error("{link}: can't be opened: {cause}; {advice}")]
    Unavailable {
        /// The link's address.
        link: String,
        /// The system's message.
        cause: String,
        /// What to do.
        advice: Cow<'static, str>,
    },
    /// No robot answers, no known one, or several.
    #[error("{link}: {problem}")]
    Unknown {
        /// The link's address.
        link: String,
        /// What is wrong, and what to do.
        problem: String,
    },
    /// The guard has ended the call for the sake of a stop.
    #[error("interrupted by a stop")]
    Interrupted,
    /// This robot does not have it.
    #[error("{robot} has no {what}; allowed: {allowed}")]
    Unsupported {
        /// The robot's name.
        robot: String,
        /// The request.
        what: String,
        /// What it has instead.
        allowed: String,
    },
}

impl Error {
    /// A lost link, from the system's error.
    pub fn lost(link: &str, error: &io::Error) -> Self {
        Self::Disconnected {
            link: link.into(),
            cause: error.to_string(),
        }
    }

    /// Whether another attempt over the same link can help.
    pub fn may_pass(&self) -> bool {
        matches!(
            self,
            Self::TimedOut { .. }
                | Self::Unsent { .. }
                | Self::Garbage { .. }
                | Self::Refused { .. }
                | Self::StillTurning { .. }
        )
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        match error {
            Error::Unsupported { .. } => Self::input(error),
            _ => Self::device(error),
        }
    }
}
