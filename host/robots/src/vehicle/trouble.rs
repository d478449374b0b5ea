//! Troubles with a robot, by what has to be done about each.

use oneiro::evaluator;
use oneiro::parameter::Invalid;
use oneiro_base::exit::{Code, Failure};

/// The reason why a call to a robot, or to its substitute, failed.
#[derive(Clone, Debug, thiserror::Error)]
pub enum Trouble {
    /// The sensors could not be read, or not in time. A retry may work.
    #[error("the sensors can't be read: {0}")]
    Unreadable(String),
    /// The robot is lifted, stuck, or out of sight. A retry may work once it is put back.
    #[error("the robot has to be put back: {0}")]
    Displaced(String),
    /// Its battery is low. A retry may work once it is charged.
    #[error("the robot has to be charged: {0}")]
    Discharged(String),
    /// It was stopped for another reason that a person has to look at. A retry may work then.
    #[error("the robot was stopped: {0}")]
    Halted(String),
    /// It does not confirm that its wheels stand.
    #[error("cannot stop: {0}. The wheels may be turning: lift the robot, then switch it off or reset it")]
    Runaway(String),
    /// The user stopped it.
    #[error("stopped")]
    Stopped,
    /// It fails for good.
    #[error("{0}")]
    Broken(String),
    /// Its actions can't be recorded, or their record can't be read.
    #[error("{1}")]
    Unrecorded(Code, String),
}

impl Trouble {
    /// Whether a retry may work.
    pub fn may_pass(&self) -> bool {
        matches!(
            self,
            Self::Unreadable(_) | Self::Displaced(_) | Self::Discharged(_) | Self::Halted(_)
        )
    }
}

impl From<evaluator::Error> for Trouble {
    fn from(error: evaluator::Error) -> Self {
        match error {
            evaluator::Error::Cancelled => Self::Stopped,
            error => Self::Broken(error.to_string()),
        }
    }
}

impl From<Invalid> for Trouble {
    fn from(invalid: Invalid) -> Self {
        Self::Broken(invalid.to_string())
    }
}

impl From<Trouble> for Failure {
    fn from(trouble: Trouble) -> Self {
        match trouble {
            Trouble::Stopped => Self::stopped("stopped; run the same command again to continue"),
            Trouble::Unrecorded(code, problem) => Self::of(code, problem),
            other => Self::device(other),
        }
    }
}

impl From<Failure> for Trouble {
    fn from(failure: Failure) -> Self {
        match failure {
            Failure::Exit(code, error) => Self::Unrecorded(code, format!("{error:#}")),
            Failure::BrokenPipe => Self::Stopped,
        }
    }
}
