//! Real-time priority, for the few threads that a robot's cycle waits for. They need a processor at once, and little of it.

#[cfg(target_os = "linux")]
use rustix::process::Pid;
#[cfg(target_os = "linux")]
use rustix::thread::gettid;

/// A thread at real-time priority, until this is dropped.
#[derive(Debug)]
pub(crate) struct RealTime {
    #[cfg(target_os = "linux")]
    thread: Pid,
    #[cfg(target_os = "linux")]
    before: i32,
}

#[cfg(target_os = "linux")]
impl RealTime {
    /// The lowest real-time priority comes before every thread that has none. The system keeps a twentieth of each processor
    /// for those.
    const PRIORITY: i32 = 1;

    /// Raises the calling thread, but not those that it starts. None where the system does not allow it, and for a thread that
    /// is at real-time priority already.
    pub(crate) fn of_this_thread() -> Option<Self> {
        Self::raised(libc::SCHED_FIFO | libc::SCHED_RESET_ON_FORK)
    }

    /// Raises the calling thread and those that it starts from now on, until they end. Nothing where the system does not allow
    /// it.
    pub(crate) fn from_here_on() {
        std::mem::forget(Self::raised(libc::SCHED_FIFO));
    }

    fn raised(policy: i32) -> Option<Self> {
        let thread = gettid();
        let before = policy_of(thread);
        let is_new = ![libc::SCHED_FIFO, libc::SCHED_RR].contains(&(before & !libc::SCHED_RESET_ON_FORK));
        (is_new && set(thread, policy, Self::PRIORITY)).then_some(Self { thread, before })
    }
}

#[cfg(target_os = "linux")]
impl Drop for RealTime {
    fn drop(&mut self) {
        // Only a privileged thread may clear the flag. A thread may always give up its priority.
        set(self.thread, self.before | libc::SCHED_RESET_ON_FORK, 0);
    }
}

#[cfg(target_os = "linux")]
fn policy_of(thread: Pid) -> i32 {
    // SAFETY: it takes a number and returns one.
    unsafe { libc::sched_getscheduler(thread.as_raw_pid()) }
}

/// Sets the policy of a thread. Returns whether the system has done so.
#[cfg(target_os = "linux")]
fn set(thread: Pid, policy: i32, priority: i32) -> bool {
    let parameters = libc::sched_param {
        sched_priority: priority,
    };
    // SAFETY: the system reads the parameters during the call.
    unsafe { libc::sched_setscheduler(thread.as_raw_pid(), policy, &raw const parameters) == 0 }
}

#[cfg(not(target_os = "linux"))]
impl RealTime {
    pub(crate) fn of_this_thread() -> Option<Self> {
        None
    }

    pub(crate) fn from_here_on() {}
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use std::thread;

    use super::*;

    fn policy() -> i32 {
        policy_of(gettid()) & !libc::SCHED_RESET_ON_FORK
    }

    /// Whether this is allowed here.
    fn may_raise() -> bool {
        let raise = || set(gettid(), libc::SCHED_FIFO, RealTime::PRIORITY);
        thread::spawn(raise).join().unwrap()
    }

    /// Where this is not allowed, nothing changes.
    #[test]
    fn a_thread_is_raised_until_it_is_dropped_and_its_own_threads_are_not() {
        let run = || {
            let before = policy();
            let raised = RealTime::of_this_thread();
            let during = if may_raise() { libc::SCHED_FIFO } else { before };
            assert_eq!((policy(), raised.is_some()), (during, may_raise()));
            assert!(!may_raise() || RealTime::of_this_thread().is_none());
            assert_eq!(policy(), during);
            assert_eq!(thread::spawn(policy).join().unwrap(), before);
            // Also by another thread.
            thread::spawn(move || drop(raised)).join().unwrap();
            assert_eq!(policy(), before);
        };
        thread::spawn(run).join().unwrap();
    }

    #[test]
    fn threads_of_a_raised_one_can_be_raised_too() {
        let run = || {
            let expected = if may_raise() { libc::SCHED_FIFO } else { policy() };
            RealTime::from_here_on();
            assert_eq!(policy(), expected);
            assert_eq!(thread::spawn(policy).join().unwrap(), expected);
        };
        thread::spawn(run).join().unwrap();
    }
}
