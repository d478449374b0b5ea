//! The threads for the host's work: rayon's, of which every process has one set.

use std::sync::Once;
use std::thread;

use oneiro::threads::startable;

/// Starts them: one for each processor, or fewer where no more can be started, for which rayon would panic. Call before rayon is first
/// used. After the first call it does nothing.
pub(crate) fn prepare() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let wanted = thread::available_parallelism().map_or(1, usize::from);
        let mut builder = rayon::ThreadPoolBuilder::new();
        let count = startable(wanted);
        // Otherwise rayon takes the number from its environment variable.
        if count < wanted {
            builder = builder.num_threads(count);
        }
        // If rayon has already been used, its threads exist.
        let _ = builder.build_global();
    });
}
