//! A low-priority thread next to the control thread, with a limited fraction of a processor.

use std::sync::mpsc::{self, Receiver, Sender, TryRecvError};
use std::thread;
use std::time::Duration;

use oneiro_base::exit::{Failure, Result};

/// A thread that answers one request after the other.
pub(super) struct Beside<Q, A> {
    requests: Sender<Q>,
    results: Receiver<Result<A>>,
}

impl<Q: Send + 'static, A: Send + 'static> Beside<Q, A> {
    /// Starts it.
    pub(super) fn start(mut answer: impl FnMut(Q) -> Result<A> + Send + 'static) -> Self {
        let (requests, asked) = mpsc::channel();
        let (sender, results) = mpsc::channel();
        // It ends when there can be no more requests.
        thread::spawn(move || {
            yield_to_others();
            for request in asked {
                if sender.send(answer(request)).is_err() {
                    return;
                }
            }
        });
        Self { requests, results }
    }

    /// Asks for something.
    pub(super) fn ask(&self, request: Q) {
        // If the thread is gone, its last words say why.
        let _ = self.requests.send(request);
    }

    /// The result, if there is one; waits for it if `must_wait`.
    ///
    /// # Errors
    /// Those of the answer.
    pub(super) fn result(&self, must_wait: bool) -> Result<Option<A>> {
        let result = if must_wait {
            self.results.recv().map_err(|_| TryRecvError::Disconnected)
        } else {
            self.results.try_recv()
        };
        match result {
            Ok(result) => result.map(Some),
            Err(TryRecvError::Empty) => Ok(None),
            Err(TryRecvError::Disconnected) => Err(Failure::failed("the thread that evolves has ended")),
        }
    }
}

/// Rests after some work, so that this thread uses only the fraction `share` of a processor.
pub(super) fn rest(busy: Duration, share: f64) {
    thread::sleep(busy.mul_f64(1.0 / share - 1.0));
}

/// Gives this thread, and those that it starts, the lowest priority. Results don't depend on it.
fn yield_to_others() {
    #[cfg(target_os = "linux")]
    let _ = rustix::process::setpriority_process(None, 19);
}
