//! Reasons why an optimiser can't go on.

use oneiro_base::exit::Failure;
use oneiro_base::sealed::Problem;

/// The result of a call to an optimiser.
pub type Result<T = ()> = std::result::Result<T, Error>;

/// Reason why a call to an optimiser failed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Error {
    /// Another number of scores than individuals.
    #[error("generation {generation}: {scores} scores for {individuals} individuals; allowed: one for each")]
    Scores {
        generation: u32,
        scores: usize,
        individuals: usize,
    },
    /// Another number of descriptors than the individuals have.
    #[error(
        "generation {generation}: {numbers} numbers describe the behaviour of {individuals} individuals; allowed: {allowed}"
    )]
    Descriptors {
        generation: u32,
        numbers: usize,
        individuals: usize,
        allowed: usize,
    },
    /// A saved state that is damaged, or of another algorithm, version or settings.
    #[error("the saved state of the optimiser {0}")]
    Sealed(Problem),
    /// A state that was sealed with other lengths than its optimiser has.
    #[error("the saved state of the optimiser has other lengths")]
    Lengths,
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        match error {
            Error::Scores { .. } | Error::Descriptors { .. } => Self::failed(error),
            Error::Sealed(_) | Error::Lengths => Self::corrupt(error),
        }
    }
}
