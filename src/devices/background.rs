//! Work that its caller may abandon: a compiler, such as a driver's, can't be interrupted.

use std::panic::resume_unwind;
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

/// Abandoned threads, and whether what each makes is kept, such as code in a cache.
static ABANDONED: Mutex<Vec<(JoinHandle<()>, bool)>> = Mutex::new(Vec::new());

/// Work on another thread, which is abandoned once this is dropped: it then finishes by itself, and nobody needs what it makes.
pub(crate) struct Work<T> {
    done: Receiver<T>,
    thread: Option<JoinHandle<()>>,
}

impl<T: Send + 'static> Work<T> {
    /// # Panics
    /// If no thread can be started.
    pub(crate) fn begin(work: impl FnOnce() -> T + Send + 'static) -> Self {
        let (tell, done) = mpsc::channel();
        let thread = thread::spawn(move || {
            // Nobody may want it any more.
            let _ = tell.send(work());
        });
        Self {
            done,
            thread: Some(thread),
        }
    }

    /// Its result, if it is done within a time.
    ///
    /// # Panics
    /// If the work does.
    pub(crate) fn result(&mut self, within: Duration) -> Option<T> {
        let ended = self.done.recv_timeout(within);
        if matches!(ended, Err(RecvTimeoutError::Timeout)) {
            return None;
        }
        let thread = self.thread.take()?;
        thread.join().unwrap_or_else(|panic| resume_unwind(panic));
        ended.ok()
    }
}

impl<T> Drop for Work<T> {
    fn drop(&mut self) {
        self.thread.take().into_iter().for_each(|thread| abandon(thread, false));
    }
}

/// Does work on another thread and returns its result, or `None` within 10 ms once `stops` says so: the thread is then abandoned.
///
/// # Panics
/// If the work does, or if no thread can be started.
pub fn wait<T: Send + 'static>(stops: impl Fn() -> bool, work: impl FnOnce() -> T + Send + 'static) -> Option<T> {
    const LOOK_UP: Duration = Duration::from_millis(10);
    if stops() {
        return None;
    }
    let mut work = Work::begin(work);
    loop {
        match work.result(LOOK_UP) {
            None if stops() => return None,
            None => {}
            done => return done,
        }
    }
}

/// Waits for the abandoned threads that make something that is kept. Returns whether others still work: a process that ends by `_exit`
/// need not wait for these.
pub fn settle() -> bool {
    let (kept, others): (Vec<_>, Vec<_>) = take().into_iter().partition(|(_, is_kept)| *is_kept);
    join(kept);
    let is_busy = others.iter().any(|(thread, _)| !thread.is_finished());
    all().extend(others);
    is_busy
}

/// Abandons a thread, and says whether what it makes is kept. Before the process ends, it waits for all abandoned threads, since libraries
/// in use can't be unloaded; a process that ends by `_exit` waits for none, or for some ([`settle`]).
pub(crate) fn abandon(thread: JoinHandle<()>, is_kept: bool) {
    let mut abandoned = all();
    abandoned.retain(|(thread, _)| !thread.is_finished());
    abandoned.push((thread, is_kept));
    // Each time: what is registered last runs first, and so before the ends of libraries that were loaded in between.
    #[cfg(any(unix, windows))]
    // SAFETY: the function doesn't unwind: panics of joined threads are values.
    unsafe {
        libc::atexit(finish);
    }
}

/// Waits for all abandoned threads.
#[cfg(any(unix, windows))]
extern "C" fn finish() {
    join(take());
}

fn all() -> MutexGuard<'static, Vec<(JoinHandle<()>, bool)>> {
    ABANDONED.lock().unwrap_or_else(PoisonError::into_inner)
}

fn take() -> Vec<(JoinHandle<()>, bool)> {
    std::mem::take(&mut *all())
}

fn join(threads: Vec<(JoinHandle<()>, bool)>) {
    for (thread, _) in threads {
        let _ = thread.join();
    }
}

#[cfg(test)]
mod tests {
    use std::panic::catch_unwind;
    use std::sync::atomic::{AtomicBool, Ordering};
    use std::sync::mpsc;
    use std::time::Instant;

    use super::*;

    #[test]
    fn work_is_waited_for_until_it_is_to_stop() {
        assert_eq!(wait(|| false, || 7), Some(7));
        assert_eq!(wait(|| true, || 7), None, "it isn't begun");
        let (go_on, goes_on) = mpsc::channel::<()>();
        let stops = AtomicBool::new(false);
        let began = Instant::now();
        let done = wait(
            || stops.swap(true, Ordering::Relaxed),
            move || goes_on.recv_timeout(Duration::from_mins(1)),
        );
        assert!(done.is_none() && began.elapsed() < Duration::from_secs(30));
        drop(go_on);
        assert!(catch_unwind(|| wait(|| false, || panic!("on purpose"))).is_err());
    }
}
