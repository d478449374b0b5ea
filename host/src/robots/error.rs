//! Reasons why a robot can't be used. Each message says what to do.

use std::io;
use std::time::Duration;

/// The result of a call to a robot.
pub(crate) type Result<T = ()> = std::result::Result<T, Error>;

/// Reason why a call to a robot failed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum Error {
    /// The robot did not answer, or took no bytes, in time. Its wheels may be turning.
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
    /// What the robot sent is no answer to what was asked.
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
        /// What it said.
        answer: String,
    },
    /// The robot has restarted: it stands still, and its counters have begun at 0 again.
    #[error("the robot has restarted; check its battery, place it again and go on")]
    Restarted,
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
        advice: &'static str,
    },
    /// No robot answers, none that is known, or several.
    #[error("{link}: {problem}")]
    Unknown {
        /// The link's address.
        link: String,
        /// What is wrong, and what to do.
        problem: String,
    },
    /// The guard has ended the call for the sake of a stop.
    #[error("ended for the sake of a stop")]
    Interrupted,
    /// This robot does not have it.
    #[error("{robot} has no {what}; allowed: {allowed}")]
    Unsupported {
        /// The robot's name.
        robot: String,
        /// What was asked for.
        what: String,
        /// What it has instead.
        allowed: String,
    },
}

impl Error {
    /// A lost link, from the system's error.
    pub(crate) fn lost(link: &str, error: &io::Error) -> Self {
        Self::Disconnected {
            link: link.into(),
            cause: error.to_string(),
        }
    }

    /// Whether another attempt over the same link can help.
    pub(crate) fn may_pass(&self) -> bool {
        matches!(
            self,
            Self::TimedOut { .. } | Self::Garbage { .. } | Self::Refused { .. }
        )
    }
}
