//! How many threads can be started: less memory or a limit on processes may allow fewer than there are processors.

use std::sync::Mutex;
use std::thread;

/// Threads that work needs besides those that compute.
const OTHERS: usize = 4;
/// Bytes that it needs next to the threads.
const ROOM: usize = 48 << 20;

/// How many of `wanted` computing threads can be started so that other work has threads and memory: all of them, or else half as many again
/// and again, but at minimum one.
///
/// ```
/// assert!((1..=2).contains(&oneiro::threads::startable(2)));
/// ```
pub fn startable(wanted: usize) -> usize {
    let mut count = wanted.max(1);
    while count > 1 && !can_start(count + OTHERS) {
        count /= 2;
    }
    count
}

/// Whether so many threads can run at the same time, and leave enough memory.
fn can_start(count: usize) -> bool {
    let gate = Mutex::new(());
    thread::scope(|scope| {
        // They wait until all are there.
        let _closed = gate.lock();
        let start = |_| thread::Builder::new().spawn_scoped(scope, || drop(gate.lock())).is_ok();
        (0..count).all(start) && Vec::<u8>::new().try_reserve_exact(ROOM).is_ok()
    })
}
