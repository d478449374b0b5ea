//! Threads that compute, one for each processor.

mod affinity;

use crate::evaluator::Error;

/// A pool of threads.
#[derive(Debug)]
pub(super) struct Workers(rayon::ThreadPool);

impl Workers {
    /// Starts threads.
    ///
    /// # Errors
    /// [`Error::Short`] if the system refuses.
    pub(super) fn start(threads: usize) -> Result<Self, Error> {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .start_handler(move |index| affinity::settle(index, threads))
            .thread_name(|index| format!("oneiro-cpu-{index}"))
            .build();
        pool.map(Self).map_err(|error| {
            Error::Short(format!(
                "no thread can be started: {error}; allowed: more memory or processes"
            ))
        })
    }

    /// The number of threads.
    pub(super) fn count(&self) -> usize {
        self.0.current_num_threads()
    }

    /// Whether all threads find something true.
    pub(super) fn all(&self, is_true: fn() -> bool) -> bool {
        !self.0.broadcast(|_| is_true()).contains(&false)
    }

    /// Does work whose parallel parts run on these threads.
    pub(super) fn install<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        self.0.install(work)
    }
}
