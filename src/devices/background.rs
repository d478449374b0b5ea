//! Work that its caller may abandon: a compiler, such as a driver's, can't be interrupted.

use std::panic::resume_unwind;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

/// Abandoned threads.
static ABANDONED: Mutex<Vec<JoinHandle<()>>> = Mutex::new(Vec::new());

/// Does work on another thread and returns its result, or `None` within 10 ms once `stops` says so: the abandoned thread then
/// finishes by itself. Before the process ends, it waits for abandoned threads, since libraries in use can't be unloaded; a process
/// that ends by `_exit` doesn't.
///
/// # Panics
/// If the work does, or if no thread can be started.
pub fn wait<T: Send + 'static>(stops: impl Fn() -> bool, work: impl FnOnce() -> T + Send + 'static) -> Option<T> {
    const LOOK_UP: Duration = Duration::from_millis(10);
    if stops() {
        return None;
    }
    let (tell, done) = mpsc::channel();
    let thread = thread::spawn(move || {
        // Nobody may want it any more.
        let _ = tell.send(work());
    });
    loop {
        match done.recv_timeout(LOOK_UP) {
            Err(RecvTimeoutError::Timeout) if stops() => {
                abandon(thread);
                return None;
            }
            Err(RecvTimeoutError::Timeout) => {}
            ended => {
                thread.join().unwrap_or_else(|panic| resume_unwind(panic));
                return ended.ok();
            }
        }
    }
}

/// Abandons a thread.
pub(crate) fn abandon(thread: JoinHandle<()>) {
    let mut abandoned = ABANDONED.lock().unwrap_or_else(PoisonError::into_inner);
    abandoned.retain(|thread| !thread.is_finished());
    abandoned.push(thread);
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
    let abandoned = std::mem::take(&mut *ABANDONED.lock().unwrap_or_else(PoisonError::into_inner));
    for thread in abandoned {
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
