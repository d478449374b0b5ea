//! What other programs may call: experiments, evaluations, evolutions, recorded runs, sweeps and stepped lives, as the commands do
//! them and with the same messages. Nothing here prints or listens for signals. The Python package is made of this.
//!
//! | file | contents |
//! |---|---|
//! | `controller` | controllers alone, stepped with readings from elsewhere |
//! | [`device`] | evaluators that are opened once, and what this machine has |
//! | [`experiment`] | an experiment and its evolution |
//! | [`evaluate`] | fitness, measures and traces of genomes |
//! | [`recorded`] | runs and sweeps in directories |
//! | [`stepped`] | lives that are commanded cycle by cycle |
//! | [`watch`] | what `oneiro watch` shows |
//! | `wording` | messages in the words of calls |

#[cfg(feature = "compose")]
pub mod controller;
pub mod device;
pub mod evaluate;
pub mod experiment;
pub mod recorded;
pub mod stepped;
pub mod watch;
mod wording;

use std::fmt::{self, Display, Formatter};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use oneiro::evaluator::Control;
use oneiro_base::exit::Failure;
use oneiro_lab::engine::job::Progress;
use oneiro_lab::engine::watcher::Watch;

/// Why something was not done: the message that the program prints, in the words of calls, and the exit code that it ends with.
#[derive(Debug)]
pub struct Error {
    code: u8,
    message: String,
}

/// What the functions of this module return.
pub type Result<T = ()> = std::result::Result<T, Error>;

impl Error {
    /// Bad input, exit code 3: the problem, its place, and what is allowed.
    pub fn input(problem: impl Display) -> Self {
        Failure::input(problem).into()
    }

    /// The program's exit code: 1 failed, 2 usage, 3 input, 4 no device, 5 data corrupt, 6 storage, 7 memory or threads, 70 a mistake
    /// in Oneiro, 75 stopped.
    pub fn code(&self) -> u8 {
        self.code
    }
}

impl Display for Error {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Error {}

impl<F: Into<Failure>> From<F> for Error {
    fn from(failure: F) -> Self {
        let failure = failure.into();
        Self {
            code: failure.code(),
            message: wording::of_calls(&failure.to_string()),
        }
    }
}

/// Work in progress: another thread sees how far it is, and stops it.
#[derive(Debug, Default)]
pub struct Task {
    control: Control,
    stop: Arc<AtomicBool>,
    done: AtomicU64,
    total: AtomicU64,
}

impl Task {
    /// Asks the work to stop. It soon ends with the exit code 75.
    pub fn stop(&self) {
        self.stop.store(true, Ordering::Relaxed);
        self.control.cancel();
    }

    /// Robot-steps done, and how many there are in all; 0 until that is known.
    pub fn steps(&self) -> [u64; 2] {
        let done = self.done.load(Ordering::Relaxed) + self.control.steps();
        [done, self.total.load(Ordering::Relaxed)]
    }

    fn expect(&self, steps: u64) {
        self.total.store(steps, Ordering::Relaxed);
    }
}

/// The engine's watcher of a task.
struct Counted<'a>(&'a Task);

impl Watch for Counted<'_> {
    fn stops(&self) -> bool {
        false
    }

    fn steps(&mut self, done: u64) {
        self.0.done.store(done, Ordering::Relaxed);
    }

    fn advanced(&mut self, _: Progress) {}
}
