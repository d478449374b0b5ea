//! Binds threads to processors.
//!
//! Evaluating threads sleep between batches, and a batch may take less than a millisecond. The scheduler wakes a thread
//! where it slept or where its waker runs, unless it knows of a free processor; on a virtual machine it often takes an
//! idle processor for a busy one. Two threads then share one processor while the other idles, until the scheduler
//! balances them some milliseconds later. A thread bound to a processor is woken there.

#[cfg(target_os = "linux")]
pub(super) use linux::settle;

/// Does nothing: threads run where the system puts them.
#[cfg(not(target_os = "linux"))]
pub(super) fn settle(_index: usize, _threads: usize) {}

#[cfg(target_os = "linux")]
mod linux {
    use libc::cpu_set_t;

    /// Binds this thread, number `index` of `threads`, to its own processor if there are as many threads as processors
    /// that it may run on. With fewer threads, two evaluators could bind theirs to the same processors while others
    /// idle.
    pub(in crate::devices::cpu::workers) fn settle(index: usize, threads: usize) {
        let allowed = allowed();
        if allowed.len() != threads {
            return;
        }
        let mut processors = none();
        // SAFETY: the processor is from such a set. If the system refuses, the thread runs as before.
        unsafe {
            libc::CPU_SET(allowed[index], &mut processors);
            libc::sched_setaffinity(0, size_of::<cpu_set_t>(), &raw const processors);
        }
    }

    /// Processors that this thread may run on; empty if the system doesn't say, or has more than a set holds.
    fn allowed() -> Vec<usize> {
        let mut set = none();
        // SAFETY: writes a set of that size; 0 is this thread.
        if unsafe { libc::sched_getaffinity(0, size_of::<cpu_set_t>(), &raw mut set) } != 0 {
            return Vec::new();
        }
        // SAFETY: asks a set for a processor that it has room for.
        let holds = |&processor: &usize| unsafe { libc::CPU_ISSET(processor, &set) };
        (0..8 * size_of::<cpu_set_t>()).filter(holds).collect()
    }

    /// An empty set.
    fn none() -> cpu_set_t {
        // SAFETY: a set is an array of integers.
        unsafe { std::mem::zeroed() }
    }

    #[cfg(test)]
    mod tests {
        use super::*;

        /// Processors allowed to a thread that is one of `threads`.
        fn settled(index: usize, threads: usize) -> Vec<usize> {
            let thread = std::thread::spawn(move || {
                settle(index, threads);
                allowed()
            });
            thread.join().unwrap()
        }

        #[test]
        fn as_many_threads_as_processors_have_one_each() {
            let all = allowed();
            let each: Vec<usize> = (0..all.len()).flat_map(|index| settled(index, all.len())).collect();
            assert_eq!(each, all);
        }

        #[test]
        fn fewer_or_more_threads_run_anywhere() {
            let all = allowed();
            assert_eq!(settled(0, all.len() + 1), all);
            assert_eq!(settled(0, all.len() - 1), all);
        }
    }
}
